//! Failures of the command line and their exit codes.

use std::process::ExitCode;

use crate::gpu::GpuError;
use crate::output::OutputError;
use crate::scene::file::SceneError;
use crate::study::StudyError;
use crate::technique::ambient_scattering::table::TableError;
use crate::technique::{PlanError, RenderError};
use crate::volume::VolumeError;

/// Whatever ends a command early.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The scene is not as it should be.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The volume is not as it should be.
    #[error(transparent)]
    Volume(#[from] VolumeError),
    /// The scene does not fit the device, or Vulkan failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Standard output could not be written.
    #[error("standard output: {0}")]
    Stdout(std::io::Error),
    /// The arguments do not fit together.
    #[error("{0}")]
    Usage(String),
    /// Two images cannot be compared: which and why.
    #[error("{0}")]
    Compare(String),
    /// Measures beyond their limits, one sentence each.
    #[error("{}", .0.join("\nerror: "))]
    Limits(Vec<String>),
    /// A study could not keep its files.
    #[error("{0}")]
    Study(String),
    /// A table could not be built, read or written.
    #[error(transparent)]
    Table(TableError),
    /// Several scenes are not as they should be.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\nerror: "))]
    Several(Vec<CliError>),
    /// Shaders could not be compiled.
    #[error(transparent)]
    Shader(#[from] crate::shaders::ShaderError),
}

impl From<GpuError> for CliError {
    fn from(error: GpuError) -> Self {
        Self::Render(error.into())
    }
}

impl From<PlanError> for CliError {
    fn from(error: PlanError) -> Self {
        Self::Render(error.into())
    }
}

impl From<StudyError> for CliError {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Scene(error) => Self::Scene(error),
            StudyError::Render(error) => Self::Render(error),
            StudyError::Output(error) => Self::Output(error),
            StudyError::Technique { .. } => Self::Usage(error.to_string()),
            StudyError::Io { .. } => Self::Study(error.to_string()),
        }
    }
}

impl From<TableError> for CliError {
    fn from(error: TableError) -> Self {
        match error {
            TableError::Gpu(error) => error.into(),
            TableError::Output(error) => Self::Output(error),
            error => Self::Table(error),
        }
    }
}

impl CliError {
    /// The documented exit code.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Output(_)
            | Self::Stdout(_)
            | Self::Shader(_)
            | Self::Compare(_)
            | Self::Table(_)
            | Self::Study(_) => 1,
            Self::Several(errors) => errors.first().map_or(1, Self::exit_code),
            Self::Usage(_) => 2,
            Self::Scene(_) | Self::Volume(_) => 3,
            Self::Render(RenderError::Gpu(GpuError::Validation(_))) => 5,
            Self::Render(_) => 4,
            Self::Limits(_) => 6,
        }
    }

    /// Tells the user and gives the exit code. Scene errors point into the file.
    pub(super) fn report(self) -> ExitCode {
        let code = ExitCode::from(self.exit_code());
        match self {
            Self::Several(errors) => errors.into_iter().for_each(|e| {
                e.report();
            }),
            Self::Scene(error) => eprintln!("{:?}", miette::Report::new(error)),
            Self::Render(RenderError::Gpu(GpuError::Validation(messages))) => {
                eprintln!("error: {} validation message(s)", messages.len());
                messages.iter().for_each(|m| eprintln!("{m}"));
            }
            error => eprintln!("error: {error}"),
        }
        code
    }
}
