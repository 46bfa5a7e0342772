//! A supernova remnant: a shell torn into filaments around a glowing core.

use glam::DVec3;

use super::noise::{fbm, gradient_noise, ridged, smoothstep, vector_noise};

/// Nothing is further out: the faces of the box are in vacuum.
const OUTER: f64 = 0.97;
/// Mean radius of the shell.
const SHELL: f64 = 0.70;
/// Radius of the blast wave, the thin front ahead of the shell.
const BLAST: f64 = 0.90;

/// Density, in [0, 1]. From the outside in:
///
/// - blast wave, radius 0.9: a thin smooth front of at most 0.13;
/// - shell, radius about 0.7: filaments of 0.3 to 0.86 on a veil of 0.05 to 0.2, with fingers of
///   dense gas that trail inwards (the Rayleigh-Taylor instability of a decelerated shell) and
///   gaps where the shell has run ahead;
/// - ejecta: streaks of at most 0.2;
/// - core, radius below 0.34: rises to 1 in the middle, the only place above 0.86.
pub(super) fn evaluate(p: DVec3) -> f64 {
    let r = p.length();
    if r >= OUTER {
        return 0.0;
    }
    let core = core(p, r);
    if r < 0.12 {
        return core;
    }
    let dir = p / r;
    // The shell is no sphere: it has run further where the gas around it was thinner.
    let ahead = fbm(dir * 1.6, 2, 41);
    let bulge = 0.10 * ahead;
    let blast = blast(dir, r - 0.5 * bulge);
    let depth = SHELL + bulge - r;
    let gas = if depth < -0.13 {
        0.0
    } else {
        (shell(p, dir, depth) * smoothstep(0.4, -0.2, ahead)).max(ejecta(dir, r))
    };
    (core + gas + blast).min(1.0) * smoothstep(OUTER, OUTER - 0.02, r)
}

fn core(p: DVec3, r: f64) -> f64 {
    if r > 0.34 {
        return 0.0;
    }
    let lumps = 1.0 + 0.5 * gradient_noise(p * 9.0, 5) * smoothstep(0.02, 0.1, r);
    let q = 1.0 - r / 0.34;
    (q * q * (0.35 + 0.65 * smoothstep(0.22, 0.04, r)) * lumps).clamp(0.0, 1.0)
}

fn blast(dir: DVec3, r: f64) -> f64 {
    let front = smoothstep(BLAST + 0.015, BLAST, r) * smoothstep(BLAST - 0.09, BLAST, r);
    if front == 0.0 {
        return 0.0;
    }
    front * (0.07 + 0.05 * gradient_noise(dir * 3.0, 71).clamp(-1.0, 1.0))
}

/// `depth` is the distance below the shell's surface.
fn shell(p: DVec3, dir: DVec3, depth: f64) -> f64 {
    if depth > 0.42 {
        return 0.0;
    }
    // Lookups along the direction make walls that run inwards; the part along p breaks them up.
    let q = dir + p * 2.2;
    let q = q + vector_noise(q * 0.9, 13) * 0.45;
    let crest = ridged(q, 4, 17);
    // Filaments stand a little out of the shell, and fingers hang from the strongest of them.
    let rim = smoothstep(-0.06, 0.0, depth + 0.10 * (crest - 0.6));
    let veil = rim * smoothstep(0.12, 0.02, depth);
    let reach = 0.10 + 0.26 * smoothstep(0.65, 0.95, crest);
    let finger = rim * smoothstep(reach, 0.3 * reach, depth);
    0.20 * veil * (0.3 + 0.7 * crest) + 0.66 * finger * smoothstep(0.60, 0.98, crest)
}

fn ejecta(dir: DVec3, r: f64) -> f64 {
    let streak = ridged(dir * 3.7 + DVec3::splat(0.6 * r), 2, 53);
    0.2 * streak * smoothstep(0.12, 0.3, r) * smoothstep(0.75, 0.5, r)
}
