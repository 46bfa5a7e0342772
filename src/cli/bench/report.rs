//! Ratios of what was measured, beside the same ratios of the paper.

use serde::Serialize;

use super::paper::{Aim, Column, Model, Row, Spot, Table, ratio};
use super::turns::Measured;
use crate::gpu::DeviceInfo;
use crate::technique::Spread;

/// Everything that a run prints.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) paper: &'static str,
    /// The model that times are given over.
    pub(super) unlit: Model,
    pub(super) device: DeviceInfo,
    pub(super) image: [u32; 2],
    pub(super) frames: u32,
    pub(super) repeat: u32,
    pub(super) note: String,
    pub(super) rows: Vec<RowReport>,
    pub(super) summary: Vec<Summary>,
}

/// One row of the paper's table.
#[derive(Serialize)]
pub(super) struct RowReport {
    pub(super) name: &'static str,
    pub(super) dims: [u32; 3],
    pub(super) stand_in: &'static str,
    pub(super) lights: &'static [Spot],
    pub(super) radius_voxels: Option<f64>,
    pub(super) phase_g: f64,
    pub(super) remark: &'static str,
    pub(super) models: Vec<ModelReport>,
}

/// One model in a row.
#[derive(Serialize)]
pub(super) struct ModelReport {
    pub(super) model: Model,
    pub(super) technique: &'static str,
    /// The paper's figure of it, if this row has one.
    pub(super) figure: Option<&'static str>,
    pub(super) times: Vec<Time>,
    /// Bytes at rest beside volume and image.
    pub(super) bytes: u64,
    pub(super) resources: Vec<Bytes>,
}

/// A resource of a plan.
#[derive(Serialize)]
pub(super) struct Bytes {
    pub(super) name: &'static str,
    pub(super) bytes: u64,
}

/// One column of a model.
#[derive(Serialize)]
pub(super) struct Time {
    pub(super) what: Column,
    pub(super) device_seconds: Spread,
    /// The paper's, on its own device.
    pub(super) paper_seconds: Option<f64>,
    /// Over a frame without light.
    pub(super) over_unlit: Pair,
    /// Over the same column of the model that tells most about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) over_rival: Option<Rival>,
}

/// A time over another model's.
#[derive(Serialize)]
pub(super) struct Rival {
    pub(super) model: Model,
    #[serde(flatten)]
    pub(super) ratio: Pair,
}

/// A ratio of this run, and the same of the paper where it has both times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Pair {
    pub(super) here: Option<f64>,
    pub(super) paper: Option<f64>,
}

/// One ratio over all rows.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    pub(super) model: Model,
    pub(super) what: Column,
    pub(super) over: Model,
    /// Median over the rows that were measured.
    pub(super) here: f64,
    /// Median over those of them that the paper has both times of.
    pub(super) paper: Option<f64>,
    pub(super) rows: usize,
    pub(super) paper_rows: usize,
    pub(super) goal: Option<f64>,
    pub(super) reached: Option<bool>,
}

/// Medians of one row beside the paper's times.
struct Both<'a> {
    table: &'a Table,
    row: &'a Row,
    measured: &'a [Measured],
}

impl Both<'_> {
    fn here(&self, model: Model, column: Column) -> Option<f64> {
        let measured = self.measured.iter().find(|m| m.model == model)?;
        measured.seconds[column as usize].map(|s| s.median)
    }

    fn ratio(&self, time: (Model, Column), over: (Model, Column)) -> Pair {
        Pair {
            here: ratio(self.here(time.0, time.1), self.here(over.0, over.1)),
            paper: ratio(
                self.row.seconds(time.0, time.1),
                self.row.seconds(over.0, over.1),
            ),
        }
    }

    fn time(&self, model: Model, column: Column) -> Option<Time> {
        let measured = self.measured.iter().find(|m| m.model == model)?;
        let unlit = self.table.unlit;
        // A model without light has no caches to compare with those of others.
        let rival = column.rival().filter(|rival| {
            let compared = model != *rival && model != unlit;
            compared && self.here(*rival, column).is_some()
        });
        Some(Time {
            what: column,
            device_seconds: measured.seconds[column as usize]?,
            paper_seconds: self.row.seconds(model, column).filter(|_| self.table.times),
            over_unlit: self.ratio((model, column), (unlit, Column::Rendering)),
            over_rival: rival.map(|rival| Rival {
                model: rival,
                ratio: self.ratio((model, column), (rival, column)),
            }),
        })
    }
}

/// Puts what a row's models cost beside the paper.
pub(super) fn row(table: &Table, row: &Row, measured: &[Measured]) -> RowReport {
    let both = Both {
        table,
        row,
        measured,
    };
    let model = |m: &Measured| {
        let bytes = |&(name, bytes): &(&'static str, u64)| Bytes { name, bytes };
        ModelReport {
            model: m.model,
            technique: m.technique,
            figure: row.printed(m.model).map(|p| p.figure),
            times: Column::ALL
                .into_iter()
                .filter_map(|column| both.time(m.model, column))
                .collect(),
            bytes: m.memory.iter().map(|(_, bytes)| bytes).sum(),
            resources: m.memory.iter().map(bytes).collect(),
        }
    };
    RowReport {
        name: row.name,
        dims: row.dims,
        stand_in: row.stand_in.name(),
        lights: row.lights,
        radius_voxels: row.radius,
        phase_g: row.g,
        remark: row.remark,
        models: measured.iter().map(model).collect(),
    }
}

/// Medians over rows of the ratios that the project aims at; what was not measured is left out.
pub(super) fn summary(table: &Table, rows: &[(&Row, Vec<Measured>)]) -> Vec<Summary> {
    let one = |aim: &Aim| {
        let pairs: Vec<_> = rows
            .iter()
            .map(|(row, measured)| {
                Both {
                    table,
                    row,
                    measured,
                }
                .ratio((aim.model, aim.column), (aim.over, aim.column))
            })
            .filter(|pair| pair.here.is_some())
            .collect();
        let paper: Vec<f64> = pairs.iter().filter_map(|p| p.paper).collect();
        let paper_rows = paper.len();
        let here = median(pairs.iter().filter_map(|p| p.here).collect())?;
        Some(Summary {
            model: aim.model,
            what: aim.column,
            over: aim.over,
            here,
            paper: median(paper),
            rows: pairs.len(),
            paper_rows,
            goal: aim.goal,
            reached: aim.goal.map(|goal| here <= goal),
        })
    };
    table.aims.iter().filter_map(one).collect()
}

fn median(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| Spread::of(values).median)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::cli::bench::ament2013::{ROWS, TABLE};

    fn measured(model: Model, seconds: [Option<f64>; 4]) -> Measured {
        Measured {
            model,
            technique: "some",
            seconds: seconds.map(|s| s.map(|s| Spread::of(vec![s]))),
            memory: vec![("a", 3), ("b", 4)],
        }
    }

    /// Emission-absorption takes 2 s a frame, single scattering 3, ambient scattering `frame`.
    fn times(frame: f64) -> Vec<Measured> {
        use Model::{AmbientScattering, EmissionAbsorption, SingleScattering};
        vec![
            measured(EmissionAbsorption, [Some(1.0), None, None, Some(2.0)]),
            measured(SingleScattering, [Some(9.0), None, Some(8.0), Some(3.0)]),
            measured(
                AmbientScattering,
                [Some(5.0), Some(0.5), Some(0.4), Some(frame)],
            ),
        ]
    }

    #[test]
    fn ratios_stand_beside_the_papers() {
        let report = row(&TABLE, &ROWS[0], &times(6.0));
        let times = &report.models[2].times;
        let [tf, phase, light, rendering] = &times[..] else {
            unreachable!("every column was measured");
        };
        let frame = |t: &Time| t.over_unlit;
        assert_eq!(frame(rendering).here, Some(3.0));
        assert!((frame(rendering).paper.unwrap() - 3.2).abs() < 1e-12);
        assert_eq!(frame(phase).here, Some(0.25));
        assert!(phase.over_rival.is_none(), "no other model has a phase");
        assert!(
            tf.over_rival.is_none(),
            "ambient occlusion was not measured"
        );
        let rival = light.over_rival.as_ref().unwrap();
        assert_eq!(rival.model, Model::SingleScattering);
        assert_eq!((rival.ratio.here, rival.ratio.paper), (Some(0.05), None));
        assert_eq!(report.models[2].bytes, 7);
        assert_eq!(report.models[1].figure, None);
    }

    #[test]
    fn the_summary_has_medians_over_rows_and_judges_goals() {
        let rows: Vec<_> = [(0, 6.0), (1, 2.0), (5, 2.8)]
            .map(|(i, frame)| (&ROWS[i], times(frame)))
            .into();
        let list = summary(&TABLE, &rows);
        let find = |column, over| {
            let mut list = list.iter().filter(|s| s.model == Model::AmbientScattering);
            list.find(|s| s.what == column && s.over == over)
        };
        let rendering = find(Column::Rendering, Model::EmissionAbsorption).unwrap();
        assert_eq!((rendering.here, rendering.rows), (1.4, 3));
        assert_eq!(rendering.reached, Some(true));
        let paper = 0.5 * (64.0 / 20.0 + 180.0 / 63.0);
        assert!((rendering.paper.unwrap() - paper).abs() < 1e-12);
        assert_eq!(rendering.paper_rows, 2);
        let light = find(Column::Light, Model::SingleScattering).unwrap();
        assert_eq!((light.here, light.reached), (0.05, Some(true)));
        assert!(find(Column::TransferFunction, Model::AmbientOcclusion).is_none());
        let slow = summary(&TABLE, &[(&ROWS[0], times(3.1))]);
        assert!(slow.iter().any(|s| s.reached == Some(false)));
    }

    #[test]
    fn a_device_without_timestamps_gives_no_ratios() {
        let zero = measured(Model::EmissionAbsorption, [None, None, None, Some(0.0)]);
        let report = row(&TABLE, &ROWS[0], &[zero]);
        let time = &report.models[0].times[0];
        assert_eq!(time.over_unlit.here, None);
    }
}
