//! The Vulkan instance, with validation on request.

use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

use ash::{ext, vk};

use super::GpuError;
use super::error::Context;

/// Whether the validation layer watches every call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Validation {
    /// No layer.
    Off,
    /// Core checks and synchronization validation; every message is collected.
    On,
}

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Messages gathered by the debug messenger.
pub(super) type Messages = Arc<Mutex<Vec<String>>>;

/// A loaded Vulkan library with an instance of version 1.3.
pub struct Instance {
    pub(super) entry: ash::Entry,
    pub(super) raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    pub(super) debug_utils: bool,
    // The messenger's user data points into this allocation; it outlives the messenger.
    pub(super) messages: Messages,
}

impl Instance {
    /// Loads Vulkan and creates an instance.
    ///
    /// # Errors
    /// No loader, no validation layer (when asked for), or the driver's refusal.
    pub fn new(validation: Validation) -> Result<Self, GpuError> {
        // SAFETY: the system's Vulkan loader is trusted to be one.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| GpuError::NoLoader(e.to_string()))?;
        let layers = Self::layers(&entry, validation)?;
        let debug_utils = validation == Validation::On || has_debug_utils(&entry);
        let extensions: Vec<_> = debug_utils
            .then(|| ext::debug_utils::NAME.as_ptr())
            .into_iter()
            .collect();
        let application = vk::ApplicationInfo::default()
            .application_name(c"tyndall")
            .api_version(vk::API_VERSION_1_3);
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        if validation == Validation::On {
            info = info.push_next(&mut features);
        }
        // SAFETY: every pointer in `info` lives until the call returns.
        let raw =
            unsafe { entry.create_instance(&info, None) }.context("vkCreateInstance", "tyndall")?;
        let mut instance = Self {
            entry,
            raw,
            messenger: None,
            debug_utils,
            messages: Messages::default(),
        };
        if validation == Validation::On {
            instance.listen()?;
        }
        Ok(instance)
    }

    fn layers(entry: &ash::Entry, validation: Validation) -> Result<Vec<*const i8>, GpuError> {
        if validation == Validation::Off {
            return Ok(Vec::new());
        }
        // SAFETY: `entry` is a loaded Vulkan library.
        let found = unsafe { entry.enumerate_instance_layer_properties() }
            .context("vkEnumerateInstanceLayerProperties", "tyndall")?;
        if found.iter().any(|l| l.layer_name_as_c_str() == Ok(LAYER)) {
            Ok(vec![LAYER.as_ptr()])
        } else {
            Err(GpuError::NoValidationLayer)
        }
    }

    fn listen(&mut self) -> Result<(), GpuError> {
        use vk::DebugUtilsMessageSeverityFlagsEXT as Severity;
        use vk::DebugUtilsMessageTypeFlagsEXT as Type;
        let loader = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::WARNING | Severity::ERROR)
            .message_type(Type::GENERAL | Type::VALIDATION | Type::PERFORMANCE)
            .pfn_user_callback(Some(collect))
            .user_data(Arc::as_ptr(&self.messages).cast_mut().cast());
        // SAFETY: the user data outlives the messenger, which `drop` destroys first.
        let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }
            .context("vkCreateDebugUtilsMessengerEXT", "tyndall")?;
        self.messenger = Some((loader, messenger));
        Ok(())
    }

    /// Takes the validation messages gathered since the last call.
    #[must_use]
    pub fn take_messages(&self) -> Vec<String> {
        self.messages
            .lock()
            .map(|mut m| std::mem::take(&mut *m))
            .unwrap_or_default()
    }
}

fn has_debug_utils(entry: &ash::Entry) -> bool {
    // SAFETY: `entry` is a loaded Vulkan library.
    unsafe { entry.enumerate_instance_extension_properties(None) }.is_ok_and(|list| {
        list.iter()
            .any(|e| e.extension_name_as_c_str() == Ok(ext::debug_utils::NAME))
    })
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: devices hold the instance alive, so nothing made from it is left.
        unsafe {
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

/// The driver's or layer's message goes into the list that `user_data` points to.
unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes valid callback data, and `user_data` is the `Mutex` of `Messages`.
    let (message, messages) = unsafe {
        let message = (*data).message_as_c_str().map(CStr::to_string_lossy);
        (message, &*user_data.cast::<Mutex<Vec<String>>>())
    };
    if let (Some(message), Ok(mut messages)) = (message, messages.lock()) {
        // The loader itself warns about layers and drivers it skips; those are not about us.
        if !message.starts_with("loader") && !message.contains("terminator_CreateInstance") {
            messages.push(message.into_owned());
        }
    }
    vk::FALSE
}
