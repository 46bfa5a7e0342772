//! What batches of paths add up to, and how well that is known.

use super::grid::Grid;
use super::layout::{LANES, PATHS};
use super::optics::{colliding, thin_collided, unscattered};

/// Radiance below which errors are not counted.
pub const DARK: f64 = 1e-4;
/// Albedo that 0 counts as where errors are: it scatters nothing, but others are interpolated from it.
const FAINT: f64 = 0.1;

/// What is to be built.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Albedos, at most [`MAX_ALBEDOS`](super::layout::MAX_ALBEDOS), the largest first, each in [0, 1].
    pub albedos: Vec<f64>,
    /// The grid; at most [`ANGLES`](super::layout::ANGLES) angles.
    pub grid: Grid,
    /// Of all random numbers.
    pub seed: u32,
    /// Relative standard error that half of a column's entries brighter than [`DARK`] keep to, at each albedo.
    pub median_error: f64,
    /// And 98 of 100 of them.
    pub tail_error: f64,
    /// Batches of a column, at least and at most.
    pub batches: [u32; 2],
}

impl Request {
    /// The paper's grid at one albedo, to the default errors.
    #[must_use]
    pub const fn new(albedos: Vec<f64>, grid: Grid) -> Self {
        Self {
            albedos,
            grid,
            seed: 1,
            median_error: 0.02,
            tail_error: 0.05,
            batches: [16, 512],
        }
    }
}

/// Sums over batches of `C`, the collided radiance per colliding light and albedo:
/// `L_o = unscattered + albedo * colliding * C`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    /// What they are of.
    pub request: Request,
    /// Batches of each column.
    pub batches: Vec<u32>,
    /// Batches that each column is to have.
    pub goals: Vec<u32>,
    /// Sums of the batches' means: angle fastest, then albedo, then column.
    pub totals: Vec<f64>,
    /// And of their squares.
    pub squares: Vec<f64>,
}

impl Sums {
    /// Nothing yet; the least batches to do for each column that is not known in closed form.
    #[must_use]
    pub fn new(request: Request) -> Self {
        let (grid, first) = (request.grid, request.batches[0]);
        let values = grid.len() * request.albedos.len();
        let goal = |c| if grid.column(c)[0] > 0.0 { first } else { 0 };
        Self {
            batches: vec![0; grid.columns()],
            goals: (0..grid.columns()).map(goal).collect(),
            totals: vec![0.0; values],
            squares: vec![0.0; values],
            request,
        }
    }

    /// Paths of a column, on average.
    #[must_use]
    pub fn paths_of_a_column(&self) -> u32 {
        let batches: u64 = self.batches.iter().map(|b| u64::from(*b)).sum();
        let mean = batches / (self.batches.len() as u64).max(1);
        mean as u32 * LANES * PATHS
    }

    /// Adds a batch's means of one column: `stride` values an albedo.
    pub fn add(&mut self, column: usize, means: &[f32], stride: usize) {
        let (angles, albedos) = (self.request.grid.thetas.count, self.request.albedos.len());
        let first = column * albedos * angles;
        for (k, means) in means.chunks(stride).enumerate() {
            for (i, mean) in means.iter().take(angles).enumerate() {
                let (at, mean) = (first + k * angles + i, f64::from(*mean));
                self.totals[at] += mean;
                self.squares[at] += mean * mean;
            }
        }
        self.batches[column] += 1;
    }

    /// `C` and its standard error, 1 / sr, of an entry.
    #[must_use]
    pub fn collided(&self, column: usize, albedo: usize, angle: usize) -> [f64; 2] {
        let grid = &self.request.grid;
        let batches = f64::from(self.batches[column]);
        let [sigma_t, g] = grid.column(column);
        if sigma_t == 0.0 {
            return [thin_collided(grid.thetas.node(angle), g), 0.0];
        }
        let albedos = self.request.albedos.len();
        let at = (column * albedos + albedo) * grid.thetas.count + angle;
        let mean = self.totals[at] / batches;
        let variance = (self.squares[at] / batches - mean * mean).max(0.0);
        [mean, (variance / (batches - 1.0).max(1.0)).sqrt()]
    }

    /// `L_o` and its standard error, 1 / sr, of an entry.
    #[must_use]
    pub fn radiance(&self, column: usize, albedo: usize, angle: usize) -> [f64; 2] {
        self.scattered_by(self.request.albedos[albedo], column, albedo, angle)
    }

    /// The same, were `C` of one albedo scattered by another.
    fn scattered_by(
        &self,
        scattering: f64,
        column: usize,
        albedo: usize,
        angle: usize,
    ) -> [f64; 2] {
        let [sigma_t, g] = self.request.grid.column(column);
        let theta = self.request.grid.thetas.node(angle);
        let scale = scattering * colliding(sigma_t);
        let [mean, error] = self.collided(column, albedo, angle);
        [unscattered(theta, sigma_t, g) + scale * mean, scale * error]
    }

    /// The relative standard error of an entry brighter than [`DARK`].
    fn relative_error(&self, column: usize, albedo: usize, angle: usize) -> Option<f64> {
        let scattering = self.request.albedos[albedo].max(FAINT);
        let [radiance, error] = self.scattered_by(scattering, column, albedo, angle);
        (radiance > DARK).then_some(error / radiance)
    }

    /// Relative standard errors of a column's entries brighter than [`DARK`], ascending.
    #[must_use]
    pub fn errors(&self, column: usize, albedo: usize) -> Vec<f64> {
        let angles = 0..self.request.grid.thetas.count;
        let errors = angles.filter_map(|i| self.relative_error(column, albedo, i));
        let mut errors: Vec<_> = errors.collect();
        errors.sort_by(f64::total_cmp);
        errors
    }

    /// How many times as large as requested a column's errors are, at the worst albedo.
    fn excess(&self, column: usize) -> f64 {
        let request = &self.request;
        let of = |albedo| {
            let errors = self.errors(column, albedo);
            let share = |share| quantile(&errors, share).unwrap_or(0.0);
            (share(0.5) / request.median_error).max(share(0.98) / request.tail_error)
        };
        (0..request.albedos.len()).map(of).fold(0.0, f64::max)
    }

    /// Sets goals by the errors so far; returns whether any column needs more.
    pub fn plan(&mut self) -> bool {
        for column in 0..self.batches.len() {
            let done = f64::from(self.batches[column]);
            // An error from few batches is uncertain: at most four times as many at once.
            let needed = done * self.excess(column).powi(2).clamp(1.0, 4.0);
            self.goals[column] = (needed.ceil() as u32).min(self.request.batches[1]);
        }
        self.batches.iter().zip(&self.goals).any(|(b, g)| b < g)
    }
}

/// How well the bright entries of sums are known.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Figures {
    /// Which entries.
    pub region: String,
    /// Entries brighter than [`DARK`].
    pub entries: usize,
    /// Median of their relative standard errors.
    pub median: f64,
    /// What 95 of 100 of them stay below.
    pub percentile_95: f64,
    /// What 99 of 100 of them stay below.
    pub percentile_99: f64,
    /// The largest.
    pub largest: f64,
}

/// Whether a column's sigma_t and g and an angle's index belong to a region.
type Within<'a> = &'a dyn Fn([f64; 2], usize) -> bool;

/// Figures of the whole table and of its parts, at one albedo; albedo 0 counts as 0.1.
#[must_use]
pub fn figures(sums: &Sums, albedo: usize) -> Vec<Figures> {
    let angle = |i: usize| sums.request.grid.thetas.node(i).to_degrees();
    let regions: [(&str, Within<'_>); 9] = [
        ("all", &|_, _| true),
        ("theta < 45", &|_, i| angle(i) < 45.0),
        ("theta 45 to 135", &|_, i| (45.0..135.0).contains(&angle(i))),
        ("theta >= 135", &|_, i| angle(i) >= 135.0),
        ("sigma_t < 5", &|c, _| c[0] < 5.0),
        ("sigma_t >= 5", &|c, _| c[0] >= 5.0),
        ("theta < 45, sigma_t >= 5", &|c, i| {
            angle(i) < 45.0 && c[0] >= 5.0
        }),
        ("|g| <= 0.5", &|c, _| c[1].abs() < 0.55),
        ("|g| > 0.5", &|c, _| c[1].abs() > 0.55),
    ];
    regions
        .map(|(name, within)| region(sums, albedo, name, within))
        .to_vec()
}

fn region(sums: &Sums, albedo: usize, name: &str, within: Within<'_>) -> Figures {
    let grid = sums.request.grid;
    let entries = (0..grid.columns()).flat_map(|c| (0..grid.thetas.count).map(move |i| (c, i)));
    let mut errors: Vec<f64> = entries
        .filter(|(c, i)| within(grid.column(*c), *i))
        .filter_map(|(c, i)| sums.relative_error(c, albedo, i))
        .collect();
    errors.sort_by(f64::total_cmp);
    let share = |share| quantile(&errors, share).unwrap_or(0.0);
    Figures {
        region: name.to_owned(),
        entries: errors.len(),
        median: share(0.5),
        percentile_95: share(0.95),
        percentile_99: share(0.99),
        largest: share(1.0),
    }
}

/// The value below which a share of sorted values lies.
#[must_use]
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    sorted.get((share * last as f64).round() as usize).copied()
}
