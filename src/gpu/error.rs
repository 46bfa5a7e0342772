//! What can go wrong with Vulkan.

use ash::vk;

/// A failure of the driver, of the machine, or of a limit.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No Vulkan loader on this machine.
    #[error(
        "no Vulkan loader found ({0}); install one, on Debian: apt-get install libvulkan1 mesa-vulkan-drivers"
    )]
    NoLoader(String),
    /// The loader finds no device that can run Tyndall.
    #[error("no usable Vulkan device: {0}")]
    NoDevice(String),
    /// The user's choice of device matches none.
    #[error("no device matches `{wanted}`; available: {available}")]
    UnknownDevice {
        /// What `--device` or `TYNDALL_DEVICE` said.
        wanted: String,
        /// Index and name of every device.
        available: String,
    },
    /// The validation layer was asked for and is not installed.
    #[error("validation layer not installed; on Debian: apt-get install vulkan-validationlayers")]
    NoValidationLayer,
    /// A Vulkan call failed.
    #[error("{call} of `{object}` failed: {result}")]
    Call {
        /// The Vulkan function.
        call: &'static str,
        /// The name of the object it was called for.
        object: String,
        /// What the driver answered.
        result: vk::Result,
    },
    /// Memory could not be had for one object.
    #[error("no device memory for `{object}` ({bytes} bytes): {reason}")]
    Allocation {
        /// The object's name.
        object: String,
        /// Its size.
        bytes: u64,
        /// What the allocator said.
        reason: String,
    },
    /// A compiled shader is not what the program expects.
    #[error("shader `{name}`: {message}")]
    Shader {
        /// The shader's name.
        name: String,
        /// What is wrong with it.
        message: String,
    },
    /// The validation layer spoke.
    #[error("{} validation message(s), the first: {}", .0.len(), .0.first().map_or("", String::as_str))]
    Validation(Vec<String>),
}

/// Attaches call and object to a driver's answer.
pub(super) trait Context<T> {
    /// Names the failing call and its object.
    fn context(self, call: &'static str, object: &str) -> Result<T, GpuError>;
}

impl<T> Context<T> for Result<T, vk::Result> {
    fn context(self, call: &'static str, object: &str) -> Result<T, GpuError> {
        self.map_err(|result| GpuError::Call {
            call,
            object: object.to_owned(),
            result,
        })
    }
}
