//! What is seen of a picture at a viewing distance: blurred colours, edges and points.

use std::f64::consts::{PI, SQRT_2};

use glam::Vec3;
use rayon::prelude::*;

use super::color::Spaces;
use super::{MAX_PIXELS_PER_DEGREE, MIN_PIXELS_PER_DEGREE, PIXELS_PER_DEGREE};
use crate::output::metrics::filter::{Plane, gaussian, sampled};

/// One Gaussian of a contrast sensitivity: `a sqrt(pi / b) exp(-pi^2 x^2 / b)` at `x` degrees.
struct Sensitivity {
    a: f64,
    b: f64,
}

/// Light, and red against green `[Andersson2020, Table 1]`.
const LIGHT: Sensitivity = Sensitivity { a: 1.0, b: 0.0047 };
const RED_GREEN: Sensitivity = Sensitivity { a: 1.0, b: 0.0053 };
/// Yellow against blue needs two.
const YELLOW_BLUE: [Sensitivity; 2] = [
    Sensitivity { a: 34.1, b: 0.04 },
    Sensitivity { a: 13.5, b: 0.025 },
];

/// Width of the detectors of edges and points, in degrees `[Andersson2020, Sec. 4.2]`.
const FEATURE_WIDTH: f64 = 0.082;

/// The filters for one viewing distance.
pub(super) struct Filters {
    light: Vec<f32>,
    red_green: Vec<f32>,
    yellow_blue: [Vec<f32>; 2],
    /// Shares of the two, with the sum 1.
    yellow_blue_shares: [f32; 2],
    /// Gaussian of the detectors, and its first and second derivatives.
    smooth: Vec<f32>,
    first: Vec<f32>,
    second: Vec<f32>,
}

impl Filters {
    pub(super) fn new(pixels_per_degree: f64) -> Self {
        let ppd = if pixels_per_degree.is_nan() {
            PIXELS_PER_DEGREE
        } else {
            pixels_per_degree.clamp(MIN_PIXELS_PER_DEGREE, MAX_PIXELS_PER_DEGREE)
        };
        // All kernels have the radius of the widest: three standard deviations.
        let radius = (3.0 * YELLOW_BLUE[0].sigma() * ppd).ceil() as usize;
        let blur = |s: &Sensitivity| single(&gaussian(radius, s.sigma() * ppd));
        let weights = YELLOW_BLUE.each_ref().map(|s| s.weight(radius, ppd));
        let total: f64 = weights.iter().sum();
        let sigma = 0.5 * FEATURE_WIDTH * ppd;
        let feature_radius = (3.0 * sigma).ceil() as usize;
        let bell = |x: f64| (-x * x / (2.0 * sigma * sigma)).exp();
        let first = sampled(feature_radius, |x| -x * bell(x));
        let second = sampled(feature_radius, |x| {
            (x * x / (sigma * sigma) - 1.0) * bell(x)
        });
        Self {
            light: blur(&LIGHT),
            red_green: blur(&RED_GREEN),
            yellow_blue: YELLOW_BLUE.each_ref().map(blur),
            yellow_blue_shares: weights.map(|w| (w / total) as f32),
            smooth: single(&gaussian(feature_radius, sigma)),
            first: single(&balanced(&first)),
            second: single(&balanced(&second)),
        }
    }

    /// Pixels that the widest filter reaches to each side.
    pub(super) fn radius(&self) -> usize {
        self.light.len().max(self.smooth.len()) / 2
    }
}

impl Sensitivity {
    /// Standard deviation in degrees.
    fn sigma(&self) -> f64 {
        (self.b / 2.0).sqrt() / PI
    }

    /// Sum of the sampled kernel over both axes.
    fn weight(&self, radius: usize, ppd: f64) -> f64 {
        let row = sampled(radius, |x| (-(PI * x / ppd).powi(2) / self.b).exp());
        self.a * (PI / self.b).sqrt() * row.iter().sum::<f64>().powi(2)
    }
}

/// Positive weights scaled to the sum 1, negative ones to -1, so that a step across the whole
/// range has the response 1.
fn balanced(weights: &[f64]) -> Vec<f64> {
    let sum = |sign: f64| weights.iter().map(|w| (w * sign).max(0.0)).sum::<f64>();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    let scaled = weights
        .iter()
        .map(|&w| w / if w > 0.0 { positive } else { negative });
    scaled.collect()
}

fn single(weights: &[f64]) -> Vec<f32> {
    weights.iter().map(|&w| w as f32).collect()
}

/// A picture as seen.
pub(super) struct Seen {
    /// Row by row from the top left.
    pub(super) pixels: Vec<SeenPixel>,
}

/// One pixel as seen.
#[derive(Clone, Copy)]
pub(super) struct SeenPixel {
    /// Blurred colour, Hunt-adjusted CIELAB.
    pub(super) lab: Vec3,
    /// Strength of the edge here, in [0, 1].
    edge: f32,
    /// Strength of the point or line here.
    point: f32,
}

impl SeenPixel {
    /// Difference of edges and points in [0, 1] `[Andersson2020, Eq. 7]`.
    pub(super) fn feature_difference(&self, other: &Self) -> f32 {
        let edge = (self.edge - other.edge).abs();
        let point = (self.point - other.point).abs();
        (edge.max(point) / SQRT_2 as f32).sqrt().min(1.0)
    }
}

impl Seen {
    /// `pixels` are linear RGB in [0, 1], `width` a row, at least one.
    pub(super) fn new(width: usize, pixels: &[Vec3], filters: &Filters) -> Self {
        let spaces = Spaces::new();
        let opponent: Vec<Vec3> = pixels.par_iter().map(|&p| spaces.opponent(p)).collect();
        let plane = |value: fn(&Vec3) -> f32| Plane::new(width, &opponent, value);
        let blurred = |plane: &Plane<f32>, kernel: &[f32]| plane.filtered(kernel, kernel).values;
        let light = blurred(&plane(|p| p.x), &filters.light);
        let red_green = blurred(&plane(|p| p.y), &filters.red_green);
        let blue = plane(|p| p.z);
        let [wide, narrow] = filters.yellow_blue.each_ref().map(|k| blurred(&blue, k));
        let [wide_share, narrow_share] = filters.yellow_blue_shares;
        let features = features(&plane(|p| (p.x + 16.0) / 116.0), filters);
        let pixel = |(i, (edge, point)): (usize, (f32, f32))| {
            let yellow_blue = wide_share * wide[i] + narrow_share * narrow[i];
            let blurred = Vec3::new(light[i], red_green[i], yellow_blue);
            let rgb = spaces.rgb_from_opponent(blurred);
            SeenPixel {
                lab: spaces.hunt_lab(rgb.clamp(Vec3::ZERO, Vec3::ONE)),
                edge,
                point,
            }
        };
        Self {
            pixels: features.into_par_iter().enumerate().map(pixel).collect(),
        }
    }
}

/// Strengths of edge and point of each pixel: lengths of the vectors of filtered light along both
/// axes `[Andersson2020, Sec. 4.2]`.
fn features(light: &Plane<f32>, filters: &Filters) -> Vec<(f32, f32)> {
    let across = light.filtered_across(&filters.smooth);
    let down = light.filtered_down(&filters.smooth);
    let edge_x = down.filtered_across(&filters.first).values;
    let edge_y = across.filtered_down(&filters.first).values;
    let point_x = down.filtered_across(&filters.second).values;
    let point_y = across.filtered_down(&filters.second).values;
    (0..light.values.len())
        .into_par_iter()
        .map(|i| (edge_x[i].hypot(edge_y[i]), point_x[i].hypot(point_y[i])))
        .collect()
}
