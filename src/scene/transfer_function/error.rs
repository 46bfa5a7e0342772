//! What can be wrong with a transfer function.

/// A transfer function that cannot be read or is not one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {message}")]
pub struct TransferFunctionError {
    /// The file, or the function's name where it does not come from a file.
    pub path: String,
    /// The field or line, what was found and what was expected.
    pub message: String,
}

impl TransferFunctionError {
    pub(super) fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            message: message.into(),
        }
    }
}
