//! Which axes of an NRRD are spatial and which one counts time steps.

use glam::{DVec3, UVec3};

use crate::volume::header_text::{Fields, shown};
use crate::volume::source::check_dims;
use crate::volume::{ScalarType, VolumeError};

/// What a voxel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Holds {
    /// One value.
    Scalars,
    /// Red, green and blue.
    Colors,
}

/// The axes of a header.
#[derive(Debug)]
pub(super) struct Axes {
    /// Number of axes in the file, 3 or 4.
    pub count: usize,
    /// The spatial ones, fastest first.
    pub spatial: [usize; 3],
    /// Sizes of the spatial axes.
    pub dims: UVec3,
    /// Size of the fourth axis; 1 without it.
    pub steps: u32,
    /// World steps of the spatial axes (in the file's space), if given.
    pub directions: Option<[DVec3; 3]>,
}

impl Axes {
    /// Sorts out `dimension`, `sizes`, `kinds` and `space directions`.
    pub(super) fn parse(
        fields: &Fields,
        scalar_type: ScalarType,
        holds: Holds,
    ) -> Result<Self, VolumeError> {
        let (least, expected) = match holds {
            Holds::Scalars => (3, "3, or 4 with the time steps on the slowest axis"),
            Holds::Colors => (4, "4 with the 3 colours on the fastest axis"),
        };
        fields.require("dimension", expected)?;
        let count = fields
            .parse::<usize>("dimension", expected)?
            .unwrap_or_default();
        if !(least..=4).contains(&count) {
            return Err(fields.error("dimension", expected));
        }
        let expected = format!("{count} positive sizes (`dimension: {count}`)");
        let sizes: Vec<i64> = fields.list("sizes", &expected)?.unwrap_or_default();
        if sizes.len() != count || sizes.iter().any(|n| *n < 1) {
            return Err(fields.error("sizes", expected));
        }
        let directions = directions(fields, count)?;
        let other = if count == 4 {
            Some(other_axis(fields, &sizes, directions.as_deref(), holds)?)
        } else {
            None
        };
        let mut axes = (0..count).filter(|axis| Some(*axis) != other);
        let spatial = std::array::from_fn(|_| axes.next().unwrap_or_default());
        let steps = match other {
            None | Some(0) => 1,
            Some(axis) => u32::try_from(sizes[axis])
                .map_err(|_| fields.error("sizes", "at most 4294967295 time steps"))?,
        };
        let dims = check_dims(
            fields.path(),
            "sizes",
            spatial.map(|axis| sizes[axis]),
            steps,
            scalar_type,
        )?;
        let directions = match directions {
            None => None,
            Some(all) => {
                let [Some(x), Some(y), Some(z)] = spatial.map(|axis| all[axis]) else {
                    return Err(fields.error("space directions", "vectors for 3 axes"));
                };
                Some([x, y, z])
            }
        };
        Ok(Self {
            count,
            spatial,
            dims,
            steps,
            directions,
        })
    }
}

/// Finds the axis of a 4D file that is not spatial: the slowest, or one of size 1.
fn other_axis(
    fields: &Fields,
    sizes: &[i64],
    directions: Option<&[Option<DVec3>]>,
    holds: Holds,
) -> Result<usize, VolumeError> {
    let kinds: Option<Vec<&str>> = fields.text("kinds").map(|k| k.split_whitespace().collect());
    if kinds.as_ref().is_some_and(|k| k.len() != sizes.len()) {
        return Err(fields.error("kinds", format!("{} kinds", sizes.len())));
    }
    let (field, candidates): (_, Vec<usize>) = match (directions, &kinds) {
        (Some(all), _) => (
            "space directions",
            (0..4).filter(|axis| all[*axis].is_none()).collect(),
        ),
        (None, Some(kinds)) => (
            "kinds",
            (0..4)
                .filter(|axis| !matches!(kinds[*axis], "domain" | "space" | "???" | "none"))
                .collect(),
        ),
        // Nothing says what the axes are: the colours come first, the steps of a 3D grid last.
        (None, None) if holds == Holds::Colors => ("sizes", vec![0]),
        (None, None) => ("sizes", vec![3]),
    };
    if holds == Holds::Colors {
        return match candidates[..] {
            [0] if sizes[0] == 3 => Ok(0),
            _ => Err(fields.error(
                field,
                "3 colours on the first (fastest) axis, then 3 spatial axes",
            )),
        };
    }
    match candidates[..] {
        [axis] if axis == 3 || sizes[axis] == 1 => Ok(axis),
        [axis] => {
            let found = format!("a non-spatial axis {} of {} values", axis + 1, sizes[axis]);
            let expected = "one value a voxel; time steps on the fourth (slowest) axis";
            Err(VolumeError::field(fields.path(), field, found, expected))
        }
        _ if field == "kinds" && candidates.is_empty() => Ok(3),
        _ => Err(fields.error(field, "3 spatial axes and one other")),
    }
}

/// Parses `space directions`: per axis a vector of 3 or `none`.
fn directions(fields: &Fields, count: usize) -> Result<Option<Vec<Option<DVec3>>>, VolumeError> {
    const FIELD: &str = "space directions";
    let expected = format!("{count} entries, each (x,y,z) or none");
    let Some(text) = fields.text(FIELD) else {
        return Ok(None);
    };
    let entries = vectors(text)
        .filter(|v| v.len() == count)
        .ok_or_else(|| fields.error(FIELD, expected))?;
    if count == 3 && entries.iter().any(Option::is_none) {
        return Err(fields.error(FIELD, "a vector for each of the 3 axes"));
    }
    Ok(Some(entries))
}

/// Parses vectors such as `(1,0,0) (0, 1, 0) none`; nothing if they are malformed.
pub(super) fn vectors(text: &str) -> Option<Vec<Option<DVec3>>> {
    let mut rest = text.trim();
    let mut out = Vec::new();
    while !rest.is_empty() {
        if let Some(inside) = rest.strip_prefix('(') {
            let (numbers, after) = inside.split_once(')')?;
            let parsed: Result<Vec<f64>, _> =
                numbers.split(',').map(|n| n.trim().parse()).collect();
            let xyz: [f64; 3] = parsed.ok()?.try_into().ok()?;
            out.push(Some(DVec3::from_array(xyz)));
            rest = after.trim_start();
        } else {
            rest = rest.strip_prefix("none")?.trim_start();
            out.push(None);
        }
    }
    Some(out)
}

/// Parses quoted strings such as `"mm" "mm" ""`; nothing if they are malformed.
pub(super) fn quoted<'a>(fields: &'a Fields, key: &str) -> Result<Vec<&'a str>, VolumeError> {
    let Some(mut rest) = fields.text(key) else {
        return Ok(Vec::new());
    };
    let mut out = Vec::new();
    while let Some(inside) = rest.strip_prefix('"') {
        let Some((word, after)) = inside.split_once('"') else {
            break;
        };
        out.push(word);
        rest = after.trim_start();
    }
    if rest.is_empty() {
        return Ok(out);
    }
    let found = shown(rest);
    Err(VolumeError::field(
        fields.path(),
        key,
        found,
        "words in double quotes",
    ))
}
