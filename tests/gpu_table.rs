//! The preintegration stage against the CPU, against itself interrupted, and against what is shipped.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::f64::consts::PI;
use std::ops::ControlFlow;

use common::device;
use tyndall::gpu::Device;
use tyndall::technique::ambient_scattering::table::build::build;
use tyndall::technique::ambient_scattering::table::layout::{ANGLES, Job};
use tyndall::technique::ambient_scattering::table::optics::{colliding, unscattered};
use tyndall::technique::ambient_scattering::table::record::{Estimator, Preintegrator};
use tyndall::technique::ambient_scattering::table::{
    Axis, Grid, Request, Sums, reference, shipped, state,
};

fn axis(count: usize, min: f64, max: f64) -> Axis {
    Axis { count, min, max }
}

/// A few columns: sigma_t 0, 2 and 4 (or what `sigma_max` says), three values of g, five angles.
fn request(sigma_max: f64, albedos: &[f64]) -> Request {
    let grid = Grid {
        thetas: axis(5, 0.0, PI),
        sigmas: axis(3, 0.0, sigma_max),
        gs: axis(3, -0.8, 0.8),
    };
    Request {
        median_error: 0.02,
        tail_error: 0.1,
        ..Request::new(albedos.to_vec(), grid)
    }
}

fn built(device: &Device, request: &Request) -> Sums {
    let sums = build(device, request, None, &mut |_, _| ControlFlow::Continue(()));
    let sums = sums.unwrap().unwrap();
    device.check_validation().unwrap();
    assert_eq!(device.live_allocations(), vec![], "memory left behind");
    sums
}

#[test]
fn the_stage_agrees_with_the_cpu() {
    let device = device();
    for albedos in [&[0.9, 0.4][..], &[1.0]] {
        agrees_with_the_cpu(&device, &request(4.0, albedos));
    }
}

fn agrees_with_the_cpu(device: &Device, request: &Request) {
    let sums = built(device, request);
    let grid = request.grid;
    let (mut chi_squared, mut count) = (0.0, 0.0);
    for column in 0..grid.columns() {
        let [sigma_t, g] = grid.column(column);
        for (k, albedo) in request.albedos.iter().enumerate() {
            for (i, theta) in grid.thetas.nodes().enumerate() {
                let point = reference::entry(theta, sigma_t, g, *albedo, 20_000, 7);
                let [found, error] = sums.radiance(column, k, i);
                let error = error.hypot(point.standard_error) + 1e-6 * found;
                let z = (found - point.radiance) / error;
                // Of 135 entries, 4.5 once in 1000 runs; the seeds are fixed.
                let at = format!("{theta} {sigma_t} {g} {albedo}: {found:e}, {point:?}");
                assert!(z.abs() < 4.5, "z {z}: {at}");
                chi_squared += z * z;
                count += 1.0;
            }
        }
    }
    // Angles share paths, so the sum spreads more than that of independent ones.
    assert!(chi_squared < 2.0 * count, "chi^2 {chi_squared} of {count}");
}

#[test]
fn an_interrupted_build_ends_with_the_same_bits() {
    let device = device();
    let request = Request {
        median_error: 0.005,
        ..request(4.0, &[0.9])
    };
    let whole = built(&device, &request);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.sums");
    let mut parts = 0;
    let sums = loop {
        let stop = &mut |_, _| ControlFlow::Break(());
        match build(&device, &request, Some(&path), stop).unwrap() {
            Some(sums) => break sums,
            None => parts += 1,
        }
        assert!(path.is_file() && parts < 100);
    };
    assert!(parts > 1, "{parts}");
    assert!(!path.exists(), "the state is removed at the end");
    assert!(sums == whole, "not the same bits");
    // Another request does not go on from it, and neither does anything from half a file.
    state::save(&path, &whole).unwrap();
    let other = Request {
        seed: 2,
        ..request.clone()
    };
    let error = state::load(&path, &other).unwrap_err().to_string();
    assert!(
        error.contains("state.sums") && error.contains("hash"),
        "{error}"
    );
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let error = state::load(&path, &request).unwrap_err().to_string();
    assert!(error.contains("expected"), "{error}");
}

/// Means over batches and their standard errors, of `L_o`, at 5 angles.
fn column(device: &Device, estimator: Estimator, [sigma_t, g]: [f64; 2]) -> Vec<[f64; 2]> {
    let stage = Preintegrator::new(device, estimator, &[0.9], 3).unwrap();
    let angles = axis(5, 0.0, PI);
    let job = |b| Job::new([sigma_t, g], 0.9, [0.0, angles.step()], [1, b]);
    let jobs: Vec<_> = (0..48).map(job).collect();
    let mut sums = vec![[0.0; 2]; ANGLES];
    let add = |_: usize, means: &[f32]| {
        for (sum, mean) in sums.iter_mut().zip(means) {
            *sum = [sum[0] + f64::from(*mean), sum[1] + f64::from(*mean).powi(2)];
        }
    };
    stage.run(&jobs, add).unwrap();
    let n = jobs.len() as f64;
    let entry = |(theta, [sum, squares]): (f64, [f64; 2])| {
        let mean = sum / n;
        let error = ((squares / n - mean * mean).max(0.0) / (n - 1.0)).sqrt();
        if estimator == Estimator::Plain {
            return [mean, error];
        }
        let scale = 0.9 * colliding(sigma_t);
        [unscattered(theta, sigma_t, g) + scale * mean, scale * error]
    };
    angles.nodes().zip(sums).map(entry).collect()
}

#[test]
fn both_estimators_agree() {
    let device = device();
    for at in [[0.0, 0.3], [1.0, -0.9], [6.0, 0.5]] {
        let shared = column(&device, Estimator::Shared, at);
        let plain = column(&device, Estimator::Plain, at);
        for ([a, ea], [b, eb]) in shared.iter().zip(&plain) {
            let z = (a - b) / (ea.hypot(*eb) + 1e-6 * a);
            // Of 15 entries 4.5 never; the seeds are fixed.
            assert!(
                z.abs() < 4.5,
                "{at:?}: {a:e} +- {ea:e}, plain {b:e} +- {eb:e}"
            );
        }
    }
    device.check_validation().unwrap();
    assert_eq!(device.live_allocations(), vec![], "memory left behind");
}

#[test]
fn what_is_shipped_agrees_with_new_columns() {
    let grid = Grid {
        thetas: axis(6, 0.0, PI),
        // All of them nodes of the coarser grid, too.
        sigmas: axis(4, 0.0, 20.0),
        gs: axis(3, -0.9, 0.9),
    };
    let request = Request {
        seed: 9,
        batches: [48, 48],
        ..Request::new(vec![0.98, 0.3], grid)
    };
    let sums = built(&device(), &request);
    let (mut chi_squared, mut count) = (0.0, 0.0);
    for (column, k, angle) in (0..grid.columns())
        .flat_map(|c| (0..12).map(move |i| (c, i / 6, i % 6)))
        .filter(|(c, ..)| grid.column(*c)[0] > 0.0)
    {
        let ([sigma_t, g], theta) = (grid.column(column), grid.thetas.node(angle));
        let [expected, error] = sums.radiance(column, k, angle);
        let [found, found_error] = shipped()
            .unwrap()
            .entry(theta, sigma_t, g, request.albedos[k]);
        // What few paths reach has errors that are not known well enough.
        if expected > 1e-4 && error < 0.05 * expected {
            let z = (found - expected) / error.hypot(found_error);
            assert!(
                z.abs() < 4.5,
                "{theta} {sigma_t} {g}: {found:e}, {expected:e} +- {error:e}"
            );
            chi_squared += z * z;
            count += 1.0;
        }
    }
    // Angles share paths, so the sum spreads more than that of independent ones.
    eprintln!("chi^2 {chi_squared} of {count}");
    assert!(count > 60.0 && chi_squared < 2.0 * count);
}

#[test]
fn jobs_that_outlast_a_dispatch_go_on_to_the_same_bits() {
    let device = device();
    // Paths without absorption wander for hundreds of collisions before they leave this sphere.
    let job = |batch| Job::new([20.0, -0.9], 1.0, [0.0, 0.05], [3, batch]);
    let jobs: Vec<_> = (0..2).map(job).collect();
    let found = |rounds: Option<u32>| {
        let stage = Preintegrator::new(&device, Estimator::Shared, &[1.0, 0.9], 1).unwrap();
        let stage = match rounds {
            Some(rounds) => stage.with_rounds(rounds),
            None => stage,
        };
        let mut bits = Vec::new();
        let add = |_: usize, means: &[f32]| bits.extend(means.iter().map(|m| m.to_bits()));
        let done = stage.run(&jobs, add);
        (done, bits)
    };
    let (done, whole) = found(None);
    done.unwrap();
    assert_eq!(whole.len(), 2 * 2 * ANGLES);
    let (done, parts) = found(Some(40));
    done.unwrap();
    assert!(whole == parts, "not the same bits");
    // What would never end is refused, not left out.
    let (refused, none) = found(Some(1));
    let message = refused.unwrap_err().to_string();
    assert!(
        message.contains("sigma_t = 20, g = -0.9") && none.is_empty(),
        "{message}"
    );
    device.check_validation().unwrap();
    assert_eq!(device.live_allocations(), vec![], "memory left behind");
}

#[test]
fn what_is_shipped_goes_on_beyond_its_last_extinction() {
    let request = request(40.0, &[0.9]);
    let sums = built(&device(), &request);
    let grid = request.grid;
    for column in 0..grid.columns() {
        let [sigma_t, g] = grid.column(column);
        if sigma_t < 40.0 {
            continue;
        }
        let slice = shipped().unwrap().slice(g, 0.9);
        for (i, theta) in grid.thetas.nodes().enumerate() {
            let [expected, error] = sums.radiance(column, 0, i);
            let found = slice.radiance(theta, sigma_t);
            eprintln!("{g} {theta}: {found:e}, built {expected:e} +- {error:e}");
            // Only where the noise of a small build leaves something to compare: there 20 extinctions more are
            // foretold within a quarter; see the README for the dark side.
            if expected > 1e-3 {
                let off = (found / expected - 1.0).abs();
                assert!(off < 0.25 + 3.0 * error / expected, "{g} {theta}: {off}");
            }
        }
    }
}

/// Columns at extinctions that the shipped table has, all its angles.
fn held_out(device: &Device, albedo: f64, g: f64) -> Sums {
    let grid = Grid {
        thetas: Grid::PAPER.thetas,
        sigmas: axis(6, 0.0, 20.0),
        gs: axis(1, g, g),
    };
    let request = Request {
        median_error: 0.01,
        seed: 5,
        ..Request::new(vec![albedo], grid)
    };
    built(device, &request)
}

/// What a way of interpolating says of a node of sigma_t and an angle.
type Guess<'a> = &'a dyn Fn(usize, usize) -> f64;

/// Relative differences of `guess(sigma node, angle)` from sums, of entries brighter than 1e-4: median and 95th
/// of 100.
fn differences(sums: &Sums, guess: Guess<'_>) -> [f64; 2] {
    let mut list = Vec::new();
    for column in 1..6 {
        for angle in 0..256 {
            let [radiance, _] = sums.radiance(column, 0, angle);
            if radiance > 1e-4 {
                list.push((guess(51 * column, angle) / radiance - 1.0).abs());
            }
        }
    }
    list.sort_by(f64::total_cmp);
    [0.5, 0.95].map(|share| list[(share * (list.len() - 1) as f64) as usize])
}

#[test]
#[ignore = "prints the README's tables"]
fn interpolation_figures() {
    let device = device();
    let table = shipped().unwrap().table();
    let grid = table.grid;
    println!("between g: median and 95th of 100, %");
    for g in [-0.85, -0.45, 0.05, 0.45, 0.85] {
        let sums = held_out(&device, 0.9, g);
        let (i, share) = grid.gs.place(g);
        let at = |i: usize, s, t| f64::from(table.radiance[table.index(i, s, t)]);
        let known =
            |g: f64, s: usize, t: usize| unscattered(grid.thetas.node(t), grid.sigmas.node(s), g);
        let p = |g: f64, t: usize| tyndall::technique::phase_hg(grid.thetas.node(t).cos(), g);
        let [low, high] = [grid.gs.node(i), grid.gs.node(i + 1)];
        let mix = |a: f64, b: f64| a + share * (b - a);
        let rest = |i: usize, g: f64, s, t| (at(i, s, t) - known(g, s, t)).max(1e-30);
        let slice = shipped().unwrap().slice(g, 0.9);
        let methods: [(&str, Guess<'_>); 5] = [
            ("linear", &|s, t| mix(at(i, s, t), at(i + 1, s, t))),
            ("logarithm linear", &|s, t| {
                mix(at(i, s, t).ln(), at(i + 1, s, t).ln()).exp()
            }),
            ("over p_g, linear", &|s, t| {
                p(g, t) * mix(at(i, s, t) / p(low, t), at(i + 1, s, t) / p(high, t))
            }),
            ("collided, logarithm linear", &|s, t| {
                let log = mix(rest(i, low, s, t).ln(), rest(i + 1, high, s, t).ln());
                known(g, s, t) + log.exp()
            }),
            ("as it is", &|s, t| f64::from(slice.radiance[s * 256 + t])),
        ];
        for (name, guess) in methods {
            let [median, tail] = differences(&sums, guess);
            println!(
                "{g:6} {name:<28} {:6.2} {:6.2}",
                100.0 * median,
                100.0 * tail
            );
        }
    }
    println!("between every fifth extinction: median and 95th of 100, %");
    for g in [-0.8, 0.0, 0.8] {
        let [median, tail] = between_extinctions(g);
        println!("{g:6} {:6.2} {:6.2}", 100.0 * median, 100.0 * tail);
    }
    println!("between albedos: median and 95th of 100, %");
    for (albedo, g) in [
        (0.99, 0.0),
        (0.85, 0.0),
        (0.85, 0.6),
        (0.7, -0.4),
        (0.5, 0.0),
        (0.5, 0.8),
        (0.15, 0.4),
    ] {
        let sums = held_out(&device, albedo, g);
        let slice = shipped().unwrap().slice(g, albedo);
        let [median, tail] = differences(&sums, &|s, t| f64::from(slice.radiance[s * 256 + t]));
        println!("{albedo} {g}: {:6.2} {:6.2}", 100.0 * median, 100.0 * tail);
    }
}

/// Relative differences of the shipped table from what every fifth of its extinctions says, as other albedos
/// are kept: median and 95th of 100 of entries brighter than 1e-4.
fn between_extinctions(g: f64) -> [f64; 2] {
    let slice = shipped().unwrap().slice(g, 0.9);
    let grid = Grid::PAPER;
    // The logarithm of C beside that of thin media.
    let log = |s: usize, t: usize| {
        let (theta, sigma_t) = (grid.thetas.node(t), grid.sigmas.node(s));
        let rest = f64::from(slice.radiance[256 * s + t]) - unscattered(theta, sigma_t, g);
        let thin = tyndall::technique::phase_hg(theta.cos(), g * g);
        (rest / (0.9 * colliding(sigma_t) * thin)).ln()
    };
    let mut list = Vec::new();
    for (s, t) in (11..245).flat_map(|s| (0..256).map(move |t| (s, t))) {
        let radiance = f64::from(slice.radiance[256 * s + t]);
        if radiance < 1e-4 || s % 5 == 0 {
            continue;
        }
        let (first, x) = (s / 5 - 1, (s % 5) as f64 / 5.0 + 1.0);
        let weight = |i: usize| -> f64 {
            let others = (0..4).filter(|j| *j != i).map(|j| j as f64);
            others.map(|j| (x - j) / (i as f64 - j)).product()
        };
        let guess: f64 = (0..4).map(|i| weight(i) * log(5 * (first + i), t)).sum();
        let known = unscattered(grid.thetas.node(t), grid.sigmas.node(s), g);
        list.push(((guess - log(s, t)).exp_m1() * (radiance - known) / radiance).abs());
    }
    list.sort_by(f64::total_cmp);
    [0.5, 0.95].map(|share| list[(share * (list.len() - 1) as f64) as usize])
}
