//! Ranges of what the medium is made of beside numbers: shapes over values and gradients, and noise.

use super::error::Problem;
use super::spec_medium::{OctaveSpec, PerturbationSpec, PrimitiveSpec};
use super::validate::{at_least, finite, positive, vector, within};
use crate::scene::perturbation::MOST_OCTAVES;
use crate::scene::transfer_function::Shape;

/// Most shapes of a transfer function: a table is made of them, entry by entry.
const MOST_PRIMITIVES: usize = 256;

/// Shapes of a transfer function.
pub(super) fn primitives(list: &[PrimitiveSpec]) -> Result<(), Problem> {
    if !(1..=MOST_PRIMITIVES).contains(&list.len()) {
        let found = list.len();
        return Err(Problem::new(
            "transfer_function.primitives",
            format!("found {found} shapes, expected 1 to {MOST_PRIMITIVES}"),
        ));
    }
    let mut shapes = list.iter().enumerate();
    shapes.try_for_each(|(i, p)| primitive(&format!("transfer_function.primitives.{i}"), p))
}

fn primitive(key: &str, p: &PrimitiveSpec) -> Result<(), Problem> {
    let of = |name: &str| format!("{key}.{name}");
    p.value
        .into_iter()
        .try_for_each(|x| finite(&of("value"), Some(x)))?;
    ascending(&of("value"), p.value)?;
    match p.gradient {
        Some([low, high]) => {
            at_least(&of("gradient"), Some(low), 0.0)?;
            ascending(&of("gradient"), [low, high])?;
            if p.shape != Shape::Box {
                finite(&of("gradient"), Some(high))?;
            }
        }
        None if p.shape != Shape::Box => {
            return Err(Problem::new(
                &of("gradient"),
                "found none, expected the lowest and highest of the shape; only a box may have all",
            ));
        }
        None => {}
    }
    p.color
        .into_iter()
        .try_for_each(|x| at_least(&of("color"), Some(x), 0.0))?;
    within(&of("opacity"), Some(p.opacity), 0.0, 1.0)
}

/// A range of some extent.
fn ascending(key: &str, [low, high]: [f64; 2]) -> Result<(), Problem> {
    // NaN is not above anything; two numbers may be too far apart for a float.
    if high > low && (high == f64::INFINITY || (high - low).is_finite()) {
        return Ok(());
    }
    Err(Problem::new(
        key,
        format!("found [{low}, {high}], expected two numbers, the second above the first"),
    ))
}

/// Noise.
pub(super) fn perturbation(p: &PerturbationSpec) -> Result<(), Problem> {
    finite("medium.perturbation.time", p.time)?;
    let found = p.octaves.len();
    if !(1..=MOST_OCTAVES).contains(&found) {
        return Err(Problem::new(
            "medium.perturbation.octaves",
            format!("found {found} octaves, expected 1 to {MOST_OCTAVES}"),
        ));
    }
    let mut together = [0.0; 4];
    for (i, spec) in p.octaves.iter().enumerate() {
        octave(
            &format!("medium.perturbation.octaves.{i}"),
            spec,
            &mut together,
        )?;
    }
    Ok(())
}

/// One octave; `together`: opacity and colour of those before.
fn octave(place: &str, octave: &OctaveSpec, together: &mut [f64; 4]) -> Result<(), Problem> {
    let key = |name: &str| format!("{place}.{name}");
    positive(&key("frequency"), Some(octave.frequency))?;
    at_least(&key("displacement"), octave.displacement, 0.0)?;
    within(&key("opacity"), octave.opacity, 0.0, 1.0)?;
    let color = octave
        .color
        .map_or([0.0; 3], |c| c.0.to_array().map(f64::from));
    color
        .into_iter()
        .try_for_each(|c| within(&key("color"), Some(c), 0.0, 1.0))?;
    vector(&key("offset"), octave.offset, false)?;
    vector(&key("velocity"), octave.velocity, false)?;
    let opacity = octave.opacity.unwrap_or(0.0);
    for (sum, share) in together
        .iter_mut()
        .zip([opacity, color[0], color[1], color[2]])
    {
        *sum += share;
    }
    let (name, most) = if together[0] > 1.0 + 1e-6 {
        ("opacity", together[0])
    } else {
        ("color", together[1].max(together[2]).max(together[3]))
    };
    if most > 1.0 + 1e-6 {
        return Err(Problem::new(
            &key(name),
            format!("found {most} of all octaves together, expected at most 1"),
        ));
    }
    if octave.displacement.unwrap_or(0.0) + opacity + color.iter().sum::<f64>() == 0.0 {
        return Err(Problem::new(
            place,
            "found noise without effect, expected displacement, opacity or color above 0",
        ));
    }
    Ok(())
}
