//! The command line. One file a subcommand.

mod auto;
mod bench;
mod compare;
#[cfg(feature = "shader-compiler")]
mod compile_shaders;
mod completions;
mod devices;
mod error;
mod info;
mod input;
mod plan;
mod progress;
mod render;
mod schema;
mod sequence;
mod study;
mod table;
mod time;

use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::gpu::{Device, GpuError, Validation};
pub use error::CliError;

/// Renders volumetric data on Vulkan: CT, MRI, microscopy, simulation, clouds.
#[derive(Parser)]
#[command(
    name = "tyndall",
    version,
    after_help = "Exit codes: 0 done; 1 a file could not be written, read or compared; 2 wrong usage; \
                  3 the scene or volume is not as it should be; 4 the device cannot do it; \
                  5 the validation layer reported something; 6 a limit of `compare` or of `render --technique auto` \
                  cannot be kept.\n\
                  Environment: TYNDALL_DEVICE (as --device), VK_DRIVER_FILES (which drivers the loader sees)."
)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

/// Options of every command.
#[derive(Args)]
struct Global {
    /// Vulkan device: its index or a part of its name (see `tyndall devices`).
    #[arg(long, global = true, value_name = "NAME|INDEX")]
    device: Option<String>,
    /// Watch every Vulkan call with the validation layer; any message is a failure.
    #[arg(long, global = true)]
    validate: bool,
    /// No progress bars, no remarks.
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene, a volume file or a procedural volume to PNG, EXR and JSON.
    Render(render::RenderArgs),
    /// Show what is in a volume file or scene, without rendering.
    Info(info::InfoArgs),
    /// List the Vulkan devices.
    Devices(devices::DevicesArgs),
    /// Show stages, resources and bytes of a scene, and what it does not need.
    Plan(plan::PlanArgs),
    /// Measure each stage over a camera orbit, and what each kind of change costs.
    Bench(bench::BenchArgs),
    /// Measure how far an image is from a reference, and hold it to limits.
    Compare(compare::CompareArgs),
    /// Render every technique at every setting worth trying, beside a reference: time, memory, errors.
    Study(study::StudyArgs),
    /// Build, check, plot and convert the preintegration table of `ambient_scattering`.
    Table(table::TableArgs),
    /// Print the JSON Schema of scene files.
    Schema,
    /// Print a shell's completion script.
    Completions(completions::CompletionsArgs),
    /// Compile glsl/ into spirv/ (for developers).
    #[cfg(feature = "shader-compiler")]
    CompileShaders(compile_shaders::CompileShadersArgs),
}

/// Runs the program on the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.command {
        Command::Render(args) => render::run(&cli.global, args),
        Command::Info(args) => info::run(&cli.global, args),
        Command::Devices(args) => devices::run(&cli.global, args),
        Command::Plan(args) => plan::run(&cli.global, args),
        Command::Bench(args) => bench::run(&cli.global, args),
        Command::Compare(args) => compare::run(args),
        Command::Study(args) => study::run(&cli.global, args),
        Command::Table(args) => table::run(&cli.global, args),
        Command::Schema => schema::run(),
        Command::Completions(args) => completions::run(args),
        #[cfg(feature = "shader-compiler")]
        Command::CompileShaders(args) => compile_shaders::run(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => error.report(),
    }
}

impl Global {
    /// Opens the device that the user chose, or the best one.
    fn open_device(&self) -> Result<Device, GpuError> {
        let environment = std::env::var("TYNDALL_DEVICE")
            .ok()
            .filter(|v| !v.is_empty());
        let wanted = self.device.clone().or(environment);
        let validation = if self.validate {
            Validation::On
        } else {
            Validation::Off
        };
        Device::open(wanted.as_deref(), validation)
    }
}

/// The usual command, for completions.
fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// Prints a line, or ends quietly where the reader has gone (`tyndall plan | head`).
fn print(text: &str) -> Result<(), CliError> {
    use std::io::Write;
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(CliError::Stdout(e)),
        _ => Ok(()),
    }
}

/// Prints a value as indented JSON.
fn print_json(value: &impl serde::Serialize) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(value).map_err(|e| CliError::Stdout(e.into()))?;
    print(&text)
}
