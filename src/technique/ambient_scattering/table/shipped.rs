//! The tables that come with the program.

use std::path::Path;
use std::sync::OnceLock;

use super::collided::{Collided, weights};
use super::entries::Table;
use super::grid::Grid;
use super::optics::{colliding, thin_collided, unscattered};
use super::pack::{COARSE, MAIN_ALBEDO, OTHER_ALBEDOS, Packed, other_grid, unpack};
use super::slice::Slice;
use super::{Request, Sums, TableError};

const NAME: &str = "assets/tables/ambient_scattering.tynpack";
const BYTES: &[u8] = include_bytes!("../../../../assets/tables/ambient_scattering.tynpack");

/// The paper's table at albedo 0.9, and others on a coarser grid.
pub struct Shipped {
    main: Collided,
    // Ascending in sqrt(1 - albedo); `None` is `main`.
    tables: Vec<(f64, Option<Collided>)>,
    // Logarithms of relative standard errors of C: those of `main`, then of OTHER_ALBEDOS.
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
        let depths = OTHER_ALBEDOS.iter().map(|a| depth(*a));
        let mut tables: Vec<_> = depths.zip(others.into_iter().map(Some)).collect();
        tables.push((depth(MAIN_ALBEDO), None));
        tables.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self {
            main,
            tables,
            errors,
        })
    }

    /// The relative standard error of what has collided, of the nearest nodes of angle, extinction, anisotropy
    /// and albedo.
    fn relative_error(&self, theta: f64, sigma_t: f64, g: f64, albedo: f64) -> f64 {
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
        // C has a slope in the albedo at 1, so none in its depth: the second table stands on the other side, too.
        let mirrored = std::iter::once((-self.tables[1].0, &self.tables[1].1));
        let tables: Vec<_> = mirrored
            .chain(self.tables.iter().map(|t| (t.0, &t.1)))
            .collect();
        let depths: Vec<_> = tables.iter().map(|t| t.0).collect();
        let (grid, coarse) = (self.main.grid, other_grid());
        let mut fine = vec![0.0; grid.sigmas.count * grid.thetas.count];
        let mut rest = vec![0.0; coarse.sigmas.count * coarse.thetas.count];
        for (node, weight) in weights(&depths, depth(albedo)) {
            let (to, values) = match tables[node].1 {
                Some(table) => (&mut rest, table.at_g(g)),
                None => (&mut fine, self.main.at_g(g)),
            };
            to.iter_mut()
                .zip(values)
                .for_each(|(to, v)| *to += weight * v);
        }
        add_finer(&mut fine, grid.thetas.count, &rest);
        Slice::new(&grid, albedo, g, fine)
    }

    /// Radiance and its standard error, 1 / sr, of any entry; for many of one anisotropy and albedo take a
    /// [`slice`](Self::slice).
    #[must_use]
    pub fn entry(&self, theta: f64, sigma_t: f64, g: f64, albedo: f64) -> [f64; 2] {
        let radiance = self.slice(g, albedo).radiance(theta, sigma_t);
        let collided = radiance - unscattered(theta, sigma_t, g);
        let error = self.relative_error(theta, sigma_t, g, albedo);
        [radiance, error * collided]
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

/// Adds values of every `COARSE`-th extinction, cubic between them.
fn add_finer(fine: &mut [f64], thetas: usize, coarse: &[f64]) {
    let nodes: Vec<_> = (0..coarse.len() / thetas).map(|s| s as f64).collect();
    for (s, row) in fine.chunks_mut(thetas).enumerate() {
        for (node, weight) in weights(&nodes, s as f64 / COARSE as f64) {
            let values = &coarse[node * thetas..(node + 1) * thetas];
            row.iter_mut()
                .zip(values)
                .for_each(|(to, v)| *to += weight * v);
        }
    }
}

/// What is shipped: the sums that [`requests`] asks for, in order.
#[must_use]
pub fn packed([main, others @ ..]: &[Sums; 4]) -> Packed {
    let others = others
        .iter()
        .flat_map(|sums| (0..sums.request.albedos.len()).map(move |k| (sums, k)));
    let collided = |(sums, k): (&Sums, usize)| {
        Collided::new(sums.request.grid, |column, angle| {
            sums.collided(column, k, angle)[0]
        })
    };
    let mut errors = vec![log_errors(main, 0, COARSE)];
    errors.extend(others.clone().map(|(sums, k)| log_errors(sums, k, 1)));
    Packed {
        main: collided((main, 0)),
        others: others.map(collided).collect(),
        errors,
    }
}

/// Logarithms of the relative standard errors of `C`, of every `step`-th extinction and every `COARSE`-th
/// angle; where nothing is uncertain a small one.
fn log_errors(sums: &Sums, albedo: usize, step: usize) -> Vec<f32> {
    let grid = sums.request.grid;
    let columns =
        (0..grid.columns()).filter(|column| (column % grid.sigmas.count).is_multiple_of(step));
    let angles = || (0..grid.thetas.count).step_by(COARSE);
    let entries = columns.flat_map(|column| angles().map(move |angle| (column, angle)));
    entries
        .map(|(column, angle)| {
            let [value, error] = sums.collided(column, albedo, angle);
            (error / value.max(1e-38)).clamp(1e-6, 1e6).ln() as f32
        })
        .collect()
}

/// The requests whose sums [`packed`] takes: the paper's grid, then albedos that paths of the same length tell
/// most about.
#[must_use]
pub fn requests() -> [Request; 4] {
    let [a, b, c, d, e, f, g] = OTHER_ALBEDOS;
    let request = |albedos, grid| Request {
        median_error: 0.015,
        tail_error: 0.04,
        batches: [16, 4096],
        ..Request::new(albedos, grid)
    };
    [
        request(vec![MAIN_ALBEDO], Grid::PAPER),
        request(vec![a, b, c], other_grid()),
        request(vec![d, e], other_grid()),
        request(vec![f, g], other_grid()),
    ]
}
