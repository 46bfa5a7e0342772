//! `tyndall info`.

use clap::Args;
use serde_json::{Value, json};

use super::input::SceneArgs;
use super::{CliError, Global, print, print_json};
use crate::scene::Scene;
use crate::scene::file::describe;
use crate::volume::read_header;

/// Show what is in a volume file or scene, without rendering.
#[derive(Args)]
pub(super) struct InfoArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Read only the header: no statistics, no automatic choices.
    #[arg(long)]
    header: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(global: &Global, args: &InfoArgs) -> Result<(), CliError> {
    if args.header {
        return header(args);
    }
    let (file, scene) = args.scene.load(global)?;
    let steps = file.time_steps()?;
    if args.json {
        let mut value = describe(&scene);
        value["statistics"] = serde_json::to_value(&*scene.statistics).unwrap_or(Value::Null);
        value["time_steps"] = json!(steps);
        value["time_step"] = json!(file.time());
        return print_json(&value);
    }
    print(&table(&scene, file.time(), steps))
}

fn header(args: &InfoArgs) -> Result<(), CliError> {
    let Some(path) = args.scene.volume_file() else {
        return Err(CliError::Usage("--header needs a volume file".to_owned()));
    };
    args.scene.one_step()?;
    let h = read_header(path, &args.scene.read_options())?;
    let g = &h.grid;
    if args.json {
        return print_json(&json!({
            "format": h.format,
            "dims": g.dims.to_array(),
            "type": h.scalar_type,
            "spacing": g.spacing().to_array(),
            "world_from_index": g.world_from_index.to_cols_array(),
            "space": g.space,
            "slope": h.rescale.slope,
            "intercept": h.rescale.intercept,
            "time_steps": h.time_steps,
            "unit": h.spatial_unit,
        }));
    }
    print(&format!(
        "{}: {:?}, {} x {} x {} of {}, {} time step(s)",
        path.display(),
        h.format,
        g.dims.x,
        g.dims.y,
        g.dims.z,
        h.scalar_type,
        h.time_steps
    ))
}

fn table(scene: &Scene, step: u32, steps: u32) -> String {
    let (v, s) = (&scene.volume, &scene.statistics);
    let (g, spacing) = (&v.grid, v.grid.spacing());
    let unit = v.spatial_unit.as_deref().unwrap_or("world units");
    let (lo, hi) = g.world_bounds();
    let stored = v.stored_dims();
    let bars = histogram(&s.histogram);
    let time = match steps {
        1 => "1 step".to_owned(),
        n => format!("{n} steps, 0 to {}; here step {step}", n - 1),
    };
    format!(
        "{}\n  {:<9} {} x {} x {} of {}\n  time      {time}\n  spacing   {} x {} x {} {unit}\n  box       {:.2} ... {:.2} {unit}\n  \
         axes      {:?}\n  values    {} ... {}, mean {:.6}\n  invalid   {} NaN, {} infinite\n  histogram {bars}\n  transfer  {}",
        v.name,
        if v.height_field.is_some() {
            "heights"
        } else {
            "voxels"
        },
        stored.x,
        stored.y,
        stored.z,
        v.voxels.scalar_type(),
        spacing.x,
        spacing.y,
        spacing.z,
        lo,
        hi,
        g.space,
        s.min,
        s.max,
        s.mean,
        s.nan,
        s.infinite,
        scene.medium.transfer_function.name
    )
}

/// Sixty columns, the height logarithmic in the count.
fn histogram(bins: &[u64]) -> String {
    const BARS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let columns: Vec<f64> = bins
        .chunks(bins.len().div_ceil(60).max(1))
        .map(|c| (c.iter().sum::<u64>() as f64).ln_1p())
        .collect();
    let highest = columns.iter().copied().fold(1e-9, f64::max);
    columns
        .iter()
        .map(|c| BARS[(c / highest * 8.0).round() as usize])
        .collect()
}
