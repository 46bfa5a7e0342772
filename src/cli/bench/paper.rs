//! What a paper's table of times says, and what is compared with it.

use serde::Serialize;

use crate::scene::Scene;
use crate::volume::procedural::Procedural;

/// An optical model of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Model {
    EmissionAbsorption,
    AmbientOcclusion,
    SingleScattering,
    AmbientScattering,
    SlicesUnlit,
    SlicesSurface,
    SlicesDirect,
    SlicesIndirect,
    SlicesNoise,
}

impl Model {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::EmissionAbsorption => "emission-absorption",
            Self::AmbientOcclusion => "ambient occlusion",
            Self::SingleScattering => "single scattering",
            Self::AmbientScattering => "ambient scattering",
            Self::SlicesUnlit => "slices, unlit",
            Self::SlicesSurface => "surface shading",
            Self::SlicesDirect => "direct light",
            Self::SlicesIndirect => "direct + indirect",
            Self::SlicesNoise => "the same, with noise",
        }
    }
}

/// What a table has a column of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Column {
    /// Delay of a transfer function change, without the image.
    TransferFunction,
    /// Delay of a phase function change, likewise.
    Phase,
    /// Delay of a light's move, likewise.
    Light,
    /// An image, all caches being up to date.
    Rendering,
}

impl Column {
    pub(super) const CHANGES: [Self; 3] = [Self::TransferFunction, Self::Phase, Self::Light];
    pub(super) const ALL: [Self; 4] = [
        Self::TransferFunction,
        Self::Phase,
        Self::Light,
        Self::Rendering,
    ];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::TransferFunction => "transfer function",
            Self::Phase => "phase",
            Self::Light => "light",
            Self::Rendering => "rendering",
        }
    }

    /// The model whose time in the same column tells most about another's, beside emission-absorption.
    pub(super) const fn rival(self) -> Option<Model> {
        match self {
            Self::TransferFunction => Some(Model::AmbientOcclusion),
            Self::Phase => None,
            Self::Light | Self::Rendering => Some(Model::SingleScattering),
        }
    }
}

/// Where a light is, as the first view sees it; it stays there while the camera goes round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Spot {
    /// A point in the volume's centre.
    Centre,
    /// Parallel light from the viewer.
    Front,
    /// Parallel light towards the viewer.
    Behind,
    /// Parallel light from the left.
    Left,
    /// Parallel light over the viewer's left shoulder.
    UpperLeft,
}

impl Spot {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Centre => "a point in the centre",
            Self::Front => "parallel from the front",
            Self::Behind => "parallel from behind",
            Self::Left => "parallel from the left",
            Self::UpperLeft => "parallel from the upper left",
        }
    }
}

/// What a table says of one model in one row.
#[derive(Debug)]
pub(super) struct Printed {
    pub(super) model: Model,
    /// The figure that was timed.
    pub(super) figure: &'static str,
    /// Milliseconds of a change of transfer function, phase and light; none: it makes no delay.
    pub(super) changes_ms: [Option<f64>; 3],
    /// Images a second; of those without light, where the paper gives shares alone.
    pub(super) fps: f64,
}

/// A row of a table, and what stands in for its data set.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) dims: [u32; 3],
    pub(super) stand_in: Procedural,
    pub(super) lights: &'static [Spot],
    /// Radius of the neighbourhood that light is gathered from, voxels, for models that have one.
    pub(super) radius: Option<f64>,
    /// Mean cosine of the phase function.
    pub(super) g: f64,
    /// What else the paper's figure shows, or what it does not say.
    pub(super) remark: &'static str,
    pub(super) printed: &'static [Printed],
}

impl Row {
    /// What the paper says of a model.
    pub(super) fn printed(&self, model: Model) -> Option<&'static Printed> {
        self.printed.iter().find(|p| p.model == model)
    }

    /// The paper's seconds, or shares of a time.
    pub(super) fn seconds(&self, model: Model, column: Column) -> Option<f64> {
        let printed = self.printed(model)?;
        let [tf, phase, light] = printed.changes_ms;
        match column {
            Column::TransferFunction => tf.map(|ms| 1e-3 * ms),
            Column::Phase => phase.map(|ms| 1e-3 * ms),
            Column::Light => light.map(|ms| 1e-3 * ms),
            Column::Rendering => Some(1.0 / printed.fps),
        }
    }
}

/// A time over another.
pub(super) fn ratio(time: Option<f64>, over: Option<f64>) -> Option<f64> {
    let (time, over) = (time?, over?);
    (over > 0.0).then(|| time / over)
}

/// A ratio that is wanted over all rows: `model`'s time over `over`'s, and what the project aims at.
#[derive(Debug)]
pub(super) struct Aim {
    pub(super) model: Model,
    pub(super) column: Column,
    pub(super) over: Model,
    /// The ratio is to be this, at most.
    pub(super) goal: Option<f64>,
}

/// Makes a row's scene one of a model.
pub(super) type Setup = fn(&Row, &mut Scene);

/// What a paper measured, and what is made of it here.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) title: &'static str,
    pub(super) rows: &'static [Row],
    /// The models that are measured, in the order of their turns.
    pub(super) models: &'static [(Model, Setup)],
    /// The model without light, whose frame is the measure of all times.
    pub(super) unlit: Model,
    /// The kinds of change that models keep caches for.
    pub(super) changes: &'static [Column],
    /// Whether the paper gives times rather than shares of them.
    pub(super) times: bool,
    /// The ratios that sum up a run.
    pub(super) aims: &'static [Aim],
    /// What else a reader must know.
    pub(super) note: &'static str,
}
