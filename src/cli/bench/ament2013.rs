//! Table 1 of `[Ament2013]`: 512^2 pixels, early ray termination at an opacity of 0.98, an orbit of 720 frames.
//!
//! The print tells the models apart by colour, which its text has lost. Section 6 and the captions say
//! which model each sub-figure shows, and the columns list the sub-figures in order. Of several figures of
//! one model the one with the largest radius and without highlights or added occlusion stands here.

use super::paper::{Aim, Column, Model, Printed, Row, Spot, Table};
use super::stand_in;
use crate::volume::procedural::Procedural;

pub(super) const TABLE: Table = Table {
    title: "[Ament2013, Table 1]",
    rows: &ROWS,
    models: stand_in::RAYS,
    unlit: Model::EmissionAbsorption,
    changes: &Column::CHANGES,
    times: true,
    aims: &AIMS,
    note: "A change's time is that of caches, without the image.",
};

const AIMS: [Aim; 6] = {
    const fn aim(model: Model, column: Column, over: Model, goal: Option<f64>) -> Aim {
        Aim {
            model,
            column,
            over,
            goal,
        }
    }
    use Column::{Light, Rendering, TransferFunction};
    use Model::{AmbientOcclusion, AmbientScattering, EmissionAbsorption, SingleScattering};
    [
        aim(AmbientOcclusion, Rendering, EmissionAbsorption, None),
        aim(SingleScattering, Rendering, EmissionAbsorption, None),
        aim(AmbientScattering, Rendering, EmissionAbsorption, Some(1.5)),
        aim(AmbientScattering, Rendering, SingleScattering, None),
        aim(
            AmbientScattering,
            TransferFunction,
            AmbientOcclusion,
            Some(1.0),
        ),
        aim(AmbientScattering, Light, SingleScattering, Some(0.1)),
    ]
};

/// The table's rows, in its order.
pub(super) const ROWS: [Row; 7] = [
    Row {
        name: "Supernova",
        dims: [432, 432, 432],
        stand_in: Procedural::Supernova,
        lights: &[Spot::Centre],
        radius: Some(14.0),
        g: 0.6,
        remark: "figure 1b has gradient shading; the radius is not stated",
        printed: &[
            emission_absorption("1a", 64.0),
            ambient_occlusion("1b", 532.0, 27.0),
            ambient_scattering("1c", [490.0, 34.0, 34.0], 20.0),
        ],
    },
    Row {
        name: "Vis. Human",
        dims: [202, 256, 259],
        stand_in: Procedural::SheppLogan,
        lights: &[Spot::UpperLeft],
        radius: Some(14.0),
        g: 0.0,
        remark: "where the light is, is not stated",
        printed: &[
            single_scattering("6a", [1020.0, 1020.0], 110.0),
            ambient_occlusion("6b", 126.0, 105.0),
            ambient_scattering("6c", [117.0, 16.0, 16.0], 60.0),
        ],
    },
    Row {
        name: "Manix (Tiss.)",
        dims: [256, 256, 276],
        stand_in: Procedural::SheppLogan,
        lights: &[Spot::Front, Spot::Behind],
        radius: Some(14.0),
        g: 0.8,
        remark: "figures 7a to 7e are one entry; the radius is not stated",
        printed: &[ambient_scattering("7a-e", [182.0, 11.0, 11.0], 38.0)],
    },
    Row {
        name: "Manix (Skel.)",
        dims: [256, 256, 276],
        stand_in: Procedural::MechanicalPart,
        lights: &[Spot::Behind],
        radius: Some(14.0),
        g: 0.8,
        remark: "",
        printed: &[
            single_scattering("8a-b", [1190.0, 1190.0], 60.0),
            ambient_scattering("8e", [180.0, 10.0, 10.0], 35.0),
        ],
    },
    Row {
        name: "Mecanix",
        dims: [256, 256, 302],
        stand_in: Procedural::MechanicalPart,
        lights: &[Spot::Left],
        radius: Some(14.0),
        g: 0.8,
        remark: "",
        printed: &[
            single_scattering("9a", [1372.0, 1372.0], 73.0),
            ambient_scattering("9c", [192.0, 20.0, 20.0], 48.0),
        ],
    },
    Row {
        name: "Buoyancy Flow",
        dims: [181, 91, 181],
        stand_in: Procedural::Cloud,
        lights: &[Spot::Front, Spot::UpperLeft],
        radius: Some(10.0),
        g: 0.5,
        remark: "where the two lights are, is not stated",
        printed: &[
            emission_absorption("10a", 180.0),
            ambient_scattering("10b", [85.0, 5.0, 5.0], 63.0),
        ],
    },
    Row {
        name: "Boundary Layer",
        dims: [538, 54, 261],
        stand_in: Procedural::MarschnerLobb,
        lights: &[Spot::UpperLeft],
        radius: Some(14.0),
        g: 0.5,
        remark: "figures 11b and 11c have highlights; where the light is, is not stated",
        printed: &[
            ambient_occlusion("11a", 128.0, 105.0),
            single_scattering("11b", [780.0, 780.0], 87.0),
            ambient_scattering("11c", [112.0, 8.0, 8.0], 69.0),
        ],
    },
];

const fn emission_absorption(figure: &'static str, fps: f64) -> Printed {
    Printed {
        model: Model::EmissionAbsorption,
        figure,
        changes_ms: [None, None, None],
        fps,
    }
}

const fn ambient_occlusion(figure: &'static str, transfer_function: f64, fps: f64) -> Printed {
    Printed {
        model: Model::AmbientOcclusion,
        figure,
        changes_ms: [Some(transfer_function), None, None],
        fps,
    }
}

const fn single_scattering(
    figure: &'static str,
    [transfer_function, light]: [f64; 2],
    fps: f64,
) -> Printed {
    Printed {
        model: Model::SingleScattering,
        figure,
        changes_ms: [Some(transfer_function), None, Some(light)],
        fps,
    }
}

const fn ambient_scattering(
    figure: &'static str,
    [transfer_function, phase, light]: [f64; 3],
    fps: f64,
) -> Printed {
    Printed {
        model: Model::AmbientScattering,
        figure,
        changes_ms: [Some(transfer_function), Some(phase), Some(light)],
        fps,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::cli::bench::paper::ratio;

    fn of(row: &Row, (model, column): (Model, Column), over: (Model, Column)) -> Option<f64> {
        ratio(row.seconds(model, column), row.seconds(over.0, over.1))
    }

    fn row(name: &str) -> &'static Row {
        ROWS.iter().find(|r| r.name == name).unwrap()
    }

    #[test]
    fn ratios_are_those_of_the_print() {
        use Column::{Light, Rendering, TransferFunction};
        use Model::{AmbientOcclusion, AmbientScattering, EmissionAbsorption, SingleScattering};
        let frame = (EmissionAbsorption, Rendering);
        // Numerators and denominators as printed; frames a second are inverted.
        let cases = [
            (
                "Supernova",
                (AmbientScattering, Rendering),
                frame,
                64.0 / 20.0,
            ),
            (
                "Supernova",
                (AmbientOcclusion, Rendering),
                frame,
                64.0 / 27.0,
            ),
            (
                "Supernova",
                (AmbientScattering, TransferFunction),
                frame,
                490.0 * 64.0 / 1000.0,
            ),
            (
                "Supernova",
                (AmbientScattering, TransferFunction),
                (AmbientOcclusion, TransferFunction),
                490.0 / 532.0,
            ),
            (
                "Buoyancy Flow",
                (AmbientScattering, Rendering),
                frame,
                180.0 / 63.0,
            ),
            (
                "Vis. Human",
                (AmbientScattering, Light),
                (SingleScattering, Light),
                16.0 / 1020.0,
            ),
            (
                "Mecanix",
                (AmbientScattering, Rendering),
                (SingleScattering, Rendering),
                73.0 / 48.0,
            ),
        ];
        for (name, what, over, expected) in cases {
            let found = of(row(name), what, over).unwrap();
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{name} {what:?} over {over:?}: {found}, expected {expected}"
            );
        }
    }

    #[test]
    fn what_the_print_leaves_out_has_no_ratio() {
        let light = (Model::AmbientScattering, Column::Light);
        let single = (Model::SingleScattering, Column::Light);
        assert_eq!(of(row("Supernova"), light, single), None);
        let frame = (Model::EmissionAbsorption, Column::Rendering);
        let measured: Vec<_> = ROWS
            .iter()
            .filter(|r| of(r, light, frame).is_some())
            .map(|r| r.name)
            .collect();
        assert_eq!(measured, ["Supernova", "Buoyancy Flow"]);
    }

    #[test]
    fn every_row_has_the_papers_method() {
        for row in &ROWS {
            let all = Column::ALL.map(|c| row.seconds(Model::AmbientScattering, c));
            let [tf, phase, light, frame] = all.map(Option::unwrap);
            // Section 6: a light's move costs what a phase function's change does, and both cost less
            // than what a change of the transfer function does.
            assert_eq!(phase, light, "{}", row.name);
            assert!(phase < tf && frame < tf, "{}", row.name);
        }
    }
}
