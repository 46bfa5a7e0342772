//! Errors that point into the scene file.

use std::fmt;
use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};

use crate::scene::LatLongMapError;
use crate::scene::transfer_function::TransferFunctionError;
use crate::volume::VolumeError;

/// What is wrong with a key, before it is known where the key stands.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Problem {
    /// Path of the key: `["lights", "0", "directional"]`.
    pub(super) path: Vec<String>,
    /// What was found and what was expected.
    pub(super) message: String,
    /// What would help.
    pub(super) help: Option<String>,
}

impl Problem {
    /// `path` is dotted.
    pub(super) fn new(path: &str, message: impl Into<String>) -> Self {
        Self {
            path: path.split('.').map(str::to_owned).collect(),
            message: message.into(),
            help: None,
        }
    }
}

/// A scene that cannot be read.
#[derive(Debug)]
pub struct SceneError {
    /// `scene.toml:3:7: image.width: found ..., expected ...` or a reader's message.
    message: String,
    help: Option<String>,
    // The text and the place in it; absent for overrides and for files that cannot be read.
    place: Option<Box<(NamedSource<String>, Range<usize>)>>,
}

impl SceneError {
    /// An error without a place in the file.
    pub(super) fn plain(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            help: None,
            place: None,
        }
    }

    /// An error at a place in the file.
    pub(super) fn at(
        name: &str,
        text: &str,
        span: Range<usize>,
        message: &str,
        help: Option<String>,
    ) -> Self {
        let (line, column) = line_column(text, span.start);
        Self {
            message: format!("{name}:{line}:{column}: {message}"),
            help,
            place: Some(Box::new((NamedSource::new(name, text.to_owned()), span))),
        }
    }

    /// Adds advice.
    pub(super) fn with_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }
}

/// Line and column, from 1, of a byte offset.
fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
    (line, column)
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        match &self.help {
            Some(help) => write!(f, "; {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for SceneError {}

impl Diagnostic for SceneError {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place.as_ref().map(|p| &p.0 as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.place.as_ref()?;
        let label = LabeledSpan::new_with_span(Some("here".to_owned()), place.1.clone());
        Some(Box::new(std::iter::once(label)))
    }
}

impl From<VolumeError> for SceneError {
    fn from(error: VolumeError) -> Self {
        Self::plain(error.to_string())
    }
}

impl From<LatLongMapError> for SceneError {
    fn from(error: LatLongMapError) -> Self {
        Self::plain(error.to_string())
    }
}

impl From<TransferFunctionError> for SceneError {
    fn from(error: TransferFunctionError) -> Self {
        Self::plain(error.to_string())
    }
}
