//! How much of a front's power passes a slab: adding and doubling `[vandeHulst1980]`, in f64.
//!
//! A tube of light within a medium is dimmed as a front is by a slab of the same depth: what is scattered
//! forward still arrives, whichever way it leaves. It passes all in vacuum, `exp(-tau)` without scattering,
//! never less than that, and falls with depth.

use std::f64::consts::PI;

/// Directions in a hemisphere, by Gauss-Legendre quadrature over the cosine.
const STREAMS: usize = 12;

/// Depth of the thinnest layer, doubled until it is [`DEEPEST`].
const THINNEST: f64 = 1e-6;

/// Deepest slab that is computed; beyond, light falls exponentially.
const DEEPEST: f64 = 64.0;

type Matrix = [[f64; STREAMS]; STREAMS];
type Vector = [f64; STREAMS];

/// Transmission over depth, for one albedo and one g.
pub struct Slab {
    // Depth and `-ln(transmission) / depth`, rising in depth.
    nodes: Vec<[f64; 2]>,
    // Share of a thin layer's depth that dims.
    thin: f64,
    // Change of `-ln(transmission)` with depth, far in.
    decay: f64,
    // Of a depth, that which is scattered neither into the forward peak nor past it.
    peak: f64,
}

/// A layer: what of light from either side it reflects and transmits, and what of a front of unit irradiance
/// from above it scatters down and up. Radiances over the directions.
#[derive(Clone)]
struct Layer {
    depth: f64,
    reflection: Matrix,
    transmission: Matrix,
    down: Vector,
    up: Vector,
}

impl Slab {
    /// For an albedo in [0, 1] and a mean cosine in [-0.99, 0.99].
    #[must_use]
    pub fn new(albedo: f64, g: f64) -> Self {
        // The part of the phase function that the directions do not resolve is a peak straight on, which is as
        // good as no scattering (delta-M scaling, [Wiscombe1977]).
        let f = g.abs().powi(2 * STREAMS as i32) * f64::from(u8::from(g > 0.0));
        let peak = 1.0 - albedo * f;
        let scaled = if peak > 0.0 {
            (1.0 - f) * albedo / peak
        } else {
            0.0
        };
        let moments: Vec<f64> = (0..2 * STREAMS)
            .map(|l| (g.powi(l as i32) - f) / (1.0 - f))
            .collect();
        let optics = Optics::new(scaled, &moments);
        let (mut nodes, mut thin) = (Vec::new(), 1.0);
        // Two chains of doublings, half an octave apart.
        for start in [THINNEST, THINNEST * 2f64.sqrt()] {
            let mut layer = optics.thin(start);
            while layer.depth < DEEPEST {
                let passed = optics.passed(&layer).clamp((-layer.depth).exp(), 1.0);
                nodes.push([layer.depth, -passed.ln() / layer.depth]);
                layer = optics.doubled(&layer);
            }
        }
        nodes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        if let Some(first) = nodes.first() {
            thin = first[1];
        }
        let decay = match nodes[..] {
            [.., a, b] => ((b[0] * b[1] - a[0] * a[1]) / (b[0] - a[0])).clamp(0.0, 1.0),
            _ => 1.0,
        };
        Self {
            nodes,
            thin,
            decay,
            peak,
        }
    }

    /// `-ln(transmission) / depth` of a slab of optical depth `depth` >= 0; in [0, 1], and 1 without scattering.
    #[must_use]
    pub fn dimming(&self, depth: f64) -> f64 {
        self.peak * self.scaled(depth * self.peak)
    }

    fn scaled(&self, depth: f64) -> f64 {
        let upper = self.nodes.partition_point(|n| n[0] <= depth);
        match (
            upper.checked_sub(1).map(|i| self.nodes[i]),
            self.nodes.get(upper),
        ) {
            (None, _) => self.thin,
            (Some(a), Some(b)) => {
                let s = (depth / a[0]).ln() / (b[0] / a[0]).ln();
                a[1] + s * (b[1] - a[1])
            }
            (Some(a), None) => (a[0] * a[1] + (depth - a[0]) * self.decay) / depth,
        }
    }
}

/// The directions and how light changes between them.
struct Optics {
    albedo: f64,
    cosines: Vector,
    weights: Vector,
    // Share scattered from direction j into a unit of cosine about direction i: to the same side, and back.
    forward: Matrix,
    backward: Matrix,
    // The same from straight down.
    front_forward: Vector,
    front_backward: Vector,
}

impl Optics {
    fn new(albedo: f64, moments: &[f64]) -> Self {
        let (cosines, weights) = gauss_legendre();
        let zero = [[0.0; STREAMS]; STREAMS];
        let mut optics = Self {
            albedo,
            cosines,
            weights,
            forward: zero,
            backward: zero,
            front_forward: [0.0; STREAMS],
            front_backward: [0.0; STREAMS],
        };
        for j in 0..=STREAMS {
            let from = cosines.get(j).copied().unwrap_or(1.0);
            let value = |to: f64| redistribution(to, from, moments);
            let mut forward = cosines.map(value);
            let mut backward = cosines.map(|c| value(-c));
            // No light is lost to the quadrature.
            let sum: f64 = (0..STREAMS)
                .map(|i| weights[i] * (forward[i] + backward[i]))
                .sum();
            forward
                .iter_mut()
                .chain(&mut backward)
                .for_each(|v| *v /= sum);
            if j == STREAMS {
                (optics.front_forward, optics.front_backward) = (forward, backward);
                continue;
            }
            for i in 0..STREAMS {
                (optics.forward[i][j], optics.backward[i][j]) = (forward[i], backward[i]);
            }
        }
        optics
    }

    /// A layer in which light is scattered at most once.
    fn thin(&self, depth: f64) -> Layer {
        let mut layer = Layer {
            depth,
            reflection: [[0.0; STREAMS]; STREAMS],
            transmission: [[0.0; STREAMS]; STREAMS],
            down: [0.0; STREAMS],
            up: [0.0; STREAMS],
        };
        for i in 0..STREAMS {
            let hit = self.albedo * depth / self.cosines[i];
            for j in 0..STREAMS {
                layer.reflection[i][j] = hit * self.backward[i][j] * self.weights[j];
                layer.transmission[i][j] = hit * self.forward[i][j] * self.weights[j];
            }
            layer.transmission[i][i] += (-depth / self.cosines[i]).exp();
            layer.down[i] = hit * self.front_forward[i] / (2.0 * PI);
            layer.up[i] = hit * self.front_backward[i] / (2.0 * PI);
        }
        layer
    }

    /// Two of the same layer, one below the other.
    fn doubled(&self, l: &Layer) -> Layer {
        let (r, t) = (&l.reflection, &l.transmission);
        // Light that goes to and fro between the two.
        let between = inverse_of_one_minus(&product(r, r));
        let bounced = product(&between, t);
        let reflected = product(t, &product(r, &bounced));
        let front = (-l.depth).exp();
        let up_below = l.up.map(|v| v * front);
        let to_below: Vector = std::array::from_fn(|i| l.down[i] + applied(r, &up_below)[i]);
        let falling = applied(&between, &to_below);
        let rising: Vector = std::array::from_fn(|i| up_below[i] + applied(r, &falling)[i]);
        Layer {
            depth: 2.0 * l.depth,
            reflection: std::array::from_fn(|i| std::array::from_fn(|j| r[i][j] + reflected[i][j])),
            transmission: product(t, &bounced),
            down: std::array::from_fn(|i| front * l.down[i] + applied(t, &falling)[i]),
            up: std::array::from_fn(|i| l.up[i] + applied(t, &rising)[i]),
        }
    }

    /// Share of the front's power that leaves the layer below.
    fn passed(&self, l: &Layer) -> f64 {
        let leaving = (0..STREAMS).map(|i| self.weights[i] * self.cosines[i] * l.down[i]);
        (-l.depth).exp() + 2.0 * PI * leaving.sum::<f64>()
    }
}

/// The phase function averaged over azimuth, for cosines of the directions with the slab's normal; its integral
/// over one of them is 1.
fn redistribution(to: f64, from: f64, moments: &[f64]) -> f64 {
    let (mut a, mut b) = ([1.0, to], [1.0, from]);
    let mut sum = 0.0;
    for (l, moment) in moments.iter().enumerate() {
        let n = l as f64;
        sum += 0.5 * (2.0 * n + 1.0) * moment * a[0] * b[0];
        a = [
            a[1],
            ((2.0 * n + 3.0) * to * a[1] - (n + 1.0) * a[0]) / (n + 2.0),
        ];
        b = [
            b[1],
            ((2.0 * n + 3.0) * from * b[1] - (n + 1.0) * b[0]) / (n + 2.0),
        ];
    }
    // A sharp peak rings in so many moments.
    sum.max(1e-9)
}

/// Nodes and weights over [0, 1].
fn gauss_legendre() -> (Vector, Vector) {
    let n = STREAMS as f64;
    let node = |i: usize| {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..50 {
            let (mut p, mut before) = (x, 1.0);
            for k in 2..=STREAMS {
                let k = k as f64;
                (p, before) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k, p);
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        [0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope)]
    };
    let nodes: [[f64; 2]; STREAMS] = std::array::from_fn(node);
    (nodes.map(|n| n[0]), nodes.map(|n| n[1]))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = [[0.0; STREAMS]; STREAMS];
    for i in 0..STREAMS {
        for k in 0..STREAMS {
            for j in 0..STREAMS {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

fn applied(a: &Matrix, v: &Vector) -> Vector {
    a.map(|row| row.iter().zip(v).map(|(a, v)| a * v).sum())
}

/// By elimination; reflections are below 1, so that no pivot is small.
fn inverse_of_one_minus(m: &Matrix) -> Matrix {
    let one = |i: usize, j: usize| f64::from(u8::from(i == j));
    let mut a: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| one(i, j) - m[i][j]));
    let mut inverse: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| one(i, j)));
    for k in 0..STREAMS {
        let pivot = 1.0 / a[k][k];
        a[k].iter_mut()
            .chain(&mut inverse[k])
            .for_each(|v| *v *= pivot);
        let (row, row_inverse) = (a[k], inverse[k]);
        for i in (0..STREAMS).filter(|i| *i != k) {
            let factor = a[i][k];
            for j in 0..STREAMS {
                a[i][j] -= factor * row[j];
                inverse[i][j] -= factor * row_inverse[j];
            }
        }
    }
    inverse
}
