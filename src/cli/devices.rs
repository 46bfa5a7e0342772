//! `tyndall devices`.

use clap::Args;

use super::{CliError, Global, print, print_json};
use crate::gpu::{DeviceInfo, Instance, Validation};
use crate::technique::size;

/// List the Vulkan devices.
#[derive(Args)]
pub(super) struct DevicesArgs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(global: &Global, args: &DevicesArgs) -> Result<(), CliError> {
    let validation = if global.validate {
        Validation::On
    } else {
        Validation::Off
    };
    let devices = Instance::new(validation)?.devices()?;
    if args.json {
        return print_json(&devices);
    }
    if devices.is_empty() {
        return print("no Vulkan device; on Debian: apt-get install mesa-vulkan-drivers");
    }
    for device in &devices {
        print(&describe(device))?;
    }
    Ok(())
}

fn describe(d: &DeviceInfo) -> String {
    let yes = |b| if b { "yes" } else { "no" };
    let l = &d.limits;
    let usable = d
        .unusable
        .as_ref()
        .map_or("usable".to_owned(), |why| format!("not usable: {why}"));
    format!(
        "{}  {}  ({:?}, {usable})\n   driver     {}, Vulkan {}\n   memory     {} device-local, one allocation up to {}\n   \
         3D image   up to {} along an axis\n   filtering  16-bit {}, 32-bit float {}\n   timestamps {}\n   subgroup   {}",
        d.index,
        d.name,
        d.kind,
        d.driver,
        d.api,
        size(l.heap_bytes),
        size(l.max_allocation),
        l.max_image_3d,
        yes(l.linear_r16_unorm),
        yes(l.linear_r32_sfloat),
        if d.timestamp_period_ns > 0.0 {
            format!("every {} ns", d.timestamp_period_ns)
        } else {
            "none".to_owned()
        },
        d.subgroup_size,
    )
}
