//! The grid that radiance is tabulated on.

/// Evenly spaced values, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// How many, at least 1.
    pub count: usize,
    /// The first.
    pub min: f64,
    /// The last.
    pub max: f64,
}

impl Axis {
    /// The value of a node.
    #[must_use]
    pub fn node(&self, i: usize) -> f64 {
        if i + 1 == self.count && i > 0 {
            return self.max;
        }
        self.min + i as f64 * self.step()
    }

    /// All values in order.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        (0..self.count).map(|i| self.node(i))
    }

    /// Distance between neighbours; 0 for a single value.
    #[must_use]
    pub fn step(&self) -> f64 {
        (self.max - self.min) / (self.count.max(2) - 1) as f64
    }

    /// The node nearest to `value`.
    #[must_use]
    pub fn nearest(&self, value: f64) -> usize {
        let (i, share) = self.place(value);
        i + usize::from(share > 0.5)
    }

    /// The node at or before `value` and how far it is to the next, 0 to 1; clamped to the ends.
    #[must_use]
    pub fn place(&self, value: f64) -> (usize, f64) {
        if self.count < 2 {
            return (0, 0.0);
        }
        let at = ((value - self.min) / self.step()).clamp(0.0, (self.count - 1) as f64);
        let i = (at as usize).min(self.count - 2);
        (i, at - i as f64)
    }
}

/// Angles, extinctions and anisotropies of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Angle between the outgoing direction and the light's, radians; 0 is straight on.
    pub thetas: Axis,
    /// Extinction times the sphere's radius.
    pub sigmas: Axis,
    /// Mean cosine of the phase function.
    pub gs: Axis,
}

impl Grid {
    /// The paper's grid as the authors publish it: 256 x 256 x 19 over [0, pi] x [0, 20] x [-0.9, 0.9].
    pub const PAPER: Self = Self {
        thetas: Axis {
            count: 256,
            min: 0.0,
            max: std::f64::consts::PI,
        },
        sigmas: Axis {
            count: 256,
            min: 0.0,
            max: 20.0,
        },
        gs: Axis {
            count: 19,
            min: -0.9,
            max: 0.9,
        },
    };

    /// Entries in all.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.columns() * self.thetas.count
    }

    /// Whether there is no entry.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Pairs of extinction and anisotropy.
    #[must_use]
    pub const fn columns(&self) -> usize {
        self.sigmas.count * self.gs.count
    }

    /// `sigma_t` and `g` of a column; `g` is slowest.
    #[must_use]
    pub fn column(&self, column: usize) -> [f64; 2] {
        [
            self.sigmas.node(column % self.sigmas.count),
            self.gs.node(column / self.sigmas.count),
        ]
    }

    /// The same span with every `step`-th angle and extinction; `step` divides their steps.
    #[must_use]
    pub fn coarser(&self, step: usize) -> Self {
        let coarser = |axis: Axis| Axis {
            count: (axis.count - 1) / step + 1,
            ..axis
        };
        Self {
            thetas: coarser(self.thetas),
            sigmas: coarser(self.sigmas),
            gs: self.gs,
        }
    }
}
