//! The tables that come with the program.

use std::path::Path;
use std::sync::OnceLock;

use super::collided::{Collided, FLOOR, weights};
use super::entries::Table;
use super::grid::Grid;
use super::optics::{colliding, thin_collided};
use super::pack::{COARSE, MAIN_ALBEDO, OTHER_ALBEDOS, Packed, unpack};
use super::slice::Slice;
use super::{Request, Sums, TableError};

const NAME: &str = "assets/tables/ambient_scattering.tynpack";
const BYTES: &[u8] = include_bytes!("../../../../assets/tables/ambient_scattering.tynpack");

/// The paper's table at albedo 0.9, and on a coarser grid what other albedos change.
pub struct Shipped {
    main: Collided,
    // Ascending in sqrt(1 - albedo); `main`'s albedo among them, as zeros.
    others: Vec<(f64, Collided)>,
    // Logarithms of relative standard errors: those of `main`, then of OTHER_ALBEDOS.
    errors: Vec<Vec<f32>>,
}

/// The shipped tables, unpacked at the first call (some hundredths of a second).
///
/// # Errors
/// The program was built with a file that is none.
pub fn shipped() -> Result<&'static Shipped, &'static TableError> {
    static SHIPPED: OnceLock<Result<Shipped, TableError>> = OnceLock::new();
    SHIPPED
        .get_or_init(|| Shipped::unpack(Path::new(NAME), BYTES))
        .as_ref()
}

impl Shipped {
    /// Unpacks what [`pack`](super::pack::pack) packed; `path` names it in errors.
    ///
    /// # Errors
    /// Bytes that are no packed tables.
    pub fn unpack(path: &Path, bytes: &[u8]) -> Result<Self, TableError> {
        let Packed {
            main,
            others,
            errors,
        } = unpack(path, bytes)?;
        let grid = other_grid();
        let mut list = vec![(depth(MAIN_ALBEDO), vec![0.0; grid.len()])];
        let depths = OTHER_ALBEDOS.iter().map(|a| depth(*a));
        list.extend(depths.zip(others));
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        let collided = |(at, log_ratio)| (at, Collided { grid, log_ratio });
        Ok(Self {
            main,
            others: list.into_iter().map(collided).collect(),
            errors,
        })
    }

    /// The relative standard error that the nearest nodes of angle, extinction, anisotropy and albedo have.
    #[must_use]
    pub fn relative_error(&self, theta: f64, sigma_t: f64, g: f64, albedo: f64) -> f64 {
        let grid = self.main.grid.coarser(COARSE);
        let column = grid.gs.nearest(g) * grid.sigmas.count + grid.sigmas.nearest(sigma_t);
        let at = column * grid.thetas.count + grid.thetas.nearest(theta);
        let away = |a: &f64| (depth(*a) - depth(albedo)).abs();
        let albedos = std::iter::once(&MAIN_ALBEDO).chain(&OTHER_ALBEDOS);
        let lists = albedos.zip(&self.errors);
        let list = lists.min_by(|a, b| away(a.0).total_cmp(&away(b.0)));
        list.map_or(0.0, |(_, errors)| f64::from(errors[at]).exp())
    }

    /// The table at any `g` within -0.99 and 0.99 and any albedo within 0 and 1.
    #[must_use]
    pub fn slice(&self, g: f64, albedo: f64) -> Slice {
        let (g, albedo) = (g.clamp(-0.99, 0.99), albedo.clamp(0.0, 1.0));
        let mut log_ratio = self.main.at_g(g);
        let depths: Vec<_> = self.others.iter().map(|o| o.0).collect();
        let grid = other_grid();
        let mut change = vec![0.0; grid.sigmas.count * grid.thetas.count];
        for (node, weight) in weights(&depths, depth(albedo)) {
            let values = self.others[node].1.at_g(g);
            change
                .iter_mut()
                .zip(values)
                .for_each(|(to, v)| *to += weight * v);
        }
        add_finer(&mut log_ratio, grid.thetas.count, &change);
        Slice::new(&self.main.grid, albedo, g, log_ratio)
    }

    /// Radiance and its standard error, 1 / sr, of any entry; for many of one anisotropy and albedo take a
    /// [`slice`](Self::slice).
    #[must_use]
    pub fn entry(&self, theta: f64, sigma_t: f64, g: f64, albedo: f64) -> [f64; 2] {
        let radiance = self.slice(g, albedo).radiance(theta, sigma_t);
        let error = self.relative_error(theta, sigma_t, g, albedo);
        [radiance, error * radiance]
    }

    /// The paper's table: albedo 0.9, 256 x 256 x 19.
    #[must_use]
    pub fn table(&self) -> Table {
        let grid = self.main.grid;
        let value = |index: usize| {
            let column = index / grid.thetas.count;
            let [sigma_t, g] = grid.column(column);
            let thin = thin_collided(grid.thetas.node(index % grid.thetas.count), g);
            let collided = thin * f64::from(self.main.log_ratio[index]).exp();
            let known = Table::unscattered(&grid, index);
            (known + MAIN_ALBEDO * colliding(sigma_t) * collided) as f32
        };
        Table {
            albedo: MAIN_ALBEDO,
            samples: 0,
            grid,
            radiance: (0..grid.len()).map(value).collect(),
            standard_error: Vec::new(),
        }
    }
}

/// Where an albedo lies among the others: diffusion falls off with it, so logarithms are nearly straight.
fn depth(albedo: f64) -> f64 {
    (1.0 - albedo).sqrt()
}

/// All angles, every `COARSE`-th extinction.
fn other_grid() -> Grid {
    Grid {
        thetas: Grid::PAPER.thetas,
        ..Grid::PAPER.coarser(COARSE)
    }
}

/// Adds values of every `COARSE`-th extinction, linear between them.
fn add_finer(fine: &mut [f64], thetas: usize, coarse: &[f64]) {
    for (s, row) in fine.chunks_mut(thetas).enumerate() {
        let (low, share) = (s / COARSE, (s % COARSE) as f64 / COARSE as f64);
        let high = low + usize::from(share > 0.0);
        for (t, value) in row.iter_mut().enumerate() {
            let at = |s: usize| coarse[s * thetas + t];
            *value += at(low) + share * (at(high) - at(low));
        }
    }
}

/// What is shipped: sums of the paper's grid at [`MAIN_ALBEDO`], and those that [`other_albedos`] asks for.
#[must_use]
pub fn packed(main: &Sums, others: &Sums) -> Packed {
    let index = |a: f64| others.request.albedos.iter().position(|b| *b == a);
    let reference = index(MAIN_ALBEDO).unwrap_or(0);
    let change = |albedo: &f64| {
        let k = index(*albedo).unwrap_or(0);
        let log = |column, angle| {
            let [value, beside] = [k, reference].map(|k| others.collided(column, k, angle)[0]);
            let log = (value.max(1e-30) / beside.max(1e-30)).ln() as f32;
            log.clamp(FLOOR, -FLOOR)
        };
        entries(others, 1, log)
    };
    let error = |albedo: &f64| {
        let k = index(*albedo).unwrap_or(0);
        entries(others, COARSE, |column, angle| {
            log_error(others.radiance(column, k, angle))
        })
    };
    let (thetas, sigmas) = (
        main.request.grid.thetas.count,
        main.request.grid.sigmas.count,
    );
    let main_errors = (0..main.request.grid.columns())
        .filter(|column| column % sigmas % COARSE == 0)
        .flat_map(|column| {
            (0..thetas)
                .step_by(COARSE)
                .map(move |angle| (column, angle))
        })
        .map(|(column, angle)| log_error(main.radiance(column, 0, angle)));
    let mut errors = vec![main_errors.collect()];
    errors.extend(OTHER_ALBEDOS.iter().map(error));
    Packed {
        main: Collided::new(main.request.grid, |column, angle| {
            main.collided(column, 0, angle)[0]
        }),
        others: OTHER_ALBEDOS.iter().map(change).collect(),
        errors,
    }
}

/// Logarithm of a relative standard error; where nothing is uncertain a small one.
fn log_error([value, error]: [f64; 2]) -> f32 {
    (error / value.max(1e-38)).clamp(1e-6, 1e6).ln() as f32
}

/// `value(column, angle)` at every column and every `step`-th angle.
fn entries(sums: &Sums, step: usize, value: impl Fn(usize, usize) -> f32) -> Vec<f32> {
    let grid = sums.request.grid;
    let angles = || (0..grid.thetas.count).step_by(step);
    let value = &value;
    (0..grid.columns())
        .flat_map(|column| angles().map(move |angle| value(column, angle)))
        .collect()
}

/// The request whose sums [`packed`] takes beside those of the paper's grid.
#[must_use]
pub fn other_albedos() -> Request {
    let mut albedos = OTHER_ALBEDOS.to_vec();
    albedos.push(MAIN_ALBEDO);
    albedos.sort_by(|a, b| b.total_cmp(a));
    Request {
        // Errors of one albedo beside another are smaller: both come from the same paths.
        median_error: 0.05,
        tail_error: 0.2,
        batches: [8, 64],
        ..Request::new(albedos, other_grid())
    }
}
