//! Choosing a transfer function from the data.

use super::definition::window;
use super::histogram::{Histogram, Window};
use super::modality::{Modality, guess};
use super::{Preset, TransferFunction};
use crate::volume::{Statistics, Volume};

/// Chooses a transfer function from the histogram and the guessed modality; its name says which and
/// why.
///
/// | data look like | function |
/// |---|---|
/// | Hounsfield units, a quarter or more is air | [`Preset::CtSkinBone`] |
/// | Hounsfield units | [`Preset::CtBone`] |
/// | few voxels differ from the lowest value (vessels, a mask) | [`Preset::Generic`]'s colours, opaque above Otsu's threshold |
/// | MRI: patient space or mm, tissue with a peak of its own | [`Preset::Mri`] |
/// | a height field | [`Preset::Terrain`] |
/// | anything else | [`Preset::Generic`] |
///
/// The lowest value of a volume that is not constant is transparent, its highest is not.
#[must_use]
pub fn automatic(volume: &Volume, statistics: &Statistics) -> TransferFunction {
    if volume.height_field.is_some() {
        let function = Preset::Terrain.transfer_function(&volume.grid, statistics);
        return named(function, "heights of a surface");
    }
    let range = format!("({} … {})", short(statistics.min), short(statistics.max));
    let Some(histogram) = Histogram::of(statistics) else {
        let function = Preset::Generic.transfer_function(&volume.grid, statistics);
        return named(
            function,
            &format!("all values are {}", short(statistics.max)),
        );
    };
    let window = window(statistics);
    let modality = guess(volume, statistics, &histogram, window);
    let (preset, reason) = match modality {
        Modality::CtInAir => (
            Preset::CtSkinBone,
            format!("values look like Hounsfield units {range} with air around"),
        ),
        Modality::CtInside => (
            Preset::CtBone,
            format!("values look like Hounsfield units {range}"),
        ),
        Modality::Mri => (
            Preset::Mri,
            format!(
                "tissue above a background that ends at {}",
                short(window.low)
            ),
        ),
        Modality::Sparse => (
            Preset::Generic,
            format!(
                "few voxels above the background, opaque from {}",
                short(window.split)
            ),
        ),
        Modality::Other => (
            Preset::Generic,
            format!("range {range}, background ends at {}", short(window.low)),
        ),
    };
    let mut function = preset.transfer_function(&volume.grid, statistics);
    if modality == Modality::Sparse {
        make_surface(&mut function, window);
    }
    named(function, &reason)
}

/// Opaque above the split between background and foreground: thin vessels would be fog under a ramp
/// over the whole range.
fn make_surface(function: &mut TransferFunction, window: Window) {
    // A background that reaches up to the split leaves no ramp of its own.
    let ramp = (window.split - window.low).max(0.01 * (window.high - window.low));
    for value in [window.low + 0.25 * ramp, window.low + ramp] {
        let (color, opacity) = function.evaluate(value);
        let at = function.points.partition_point(|p| p.value <= value);
        let point = super::ControlPoint {
            value,
            color,
            opacity,
        };
        function.points.insert(at, point);
    }
    for point in &mut function.points {
        let s = ((point.value - window.low) / ramp).clamp(0.0, 1.0);
        point.opacity = 0.9 * s * s;
    }
}

fn named(function: TransferFunction, reason: &str) -> TransferFunction {
    TransferFunction {
        name: format!("automatic: {}, {reason}", function.name),
        ..function
    }
}

/// Four significant digits, without an exponent where the number is of ordinary size.
fn short(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e7).contains(&size) {
        return format!("{value:.3e}");
    }
    let digits = if size >= 1000.0 || value == value.trunc() {
        0
    } else if size >= 1.0 {
        1
    } else {
        4
    };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_in_names_are_short() {
        assert_eq!(short(-1024.0), "-1024");
        assert_eq!(short(0.0), "0");
        assert_eq!(short(0.25), "0.2500");
        assert_eq!(short(45.251), "45.3");
        assert_eq!(short(1.0 / 3e7), "3.333e-8");
    }
}
