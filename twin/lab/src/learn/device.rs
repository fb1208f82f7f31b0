//! The device of a training: the cores of this machine, or a graphics processor through Vulkan (Cargo feature `gpu`).
//!
//! A process chooses once, before its first tensor. A flight does not use this module.

use std::sync::OnceLock;

use burn_tensor::Device;

use super::LearnError;

/// A kind of device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// All cores that the process may use.
    Cpu,
    /// The fastest graphics processor that has a Vulkan driver.
    Gpu,
}

static CHOSEN: OnceLock<Device> = OnceLock::new();

/// Chooses the device for all tensors of this process.
///
/// # Errors
/// [`LearnError::Device`] if the machine has no such device, this program was built without it, or the process chose another before.
pub fn choose(kind: DeviceKind) -> Result<(), LearnError> {
    let found = match kind {
        DeviceKind::Cpu => Device::flex(),
        DeviceKind::Gpu => gpu()?,
    };
    let again = || LearnError::Device("another device is in use in this process".to_owned());
    if CHOSEN.get_or_init(|| found.clone()) == &found { Ok(()) } else { Err(again()) }
}

/// The device for tensors with gradients (`tracked`) or without; the cores if no device was chosen.
pub fn device(tracked: bool) -> Device {
    let chosen = CHOSEN.get_or_init(Device::flex).clone();
    if tracked { chosen.autodiff() } else { chosen }
}

#[cfg(feature = "gpu")]
fn gpu() -> Result<Device, LearnError> {
    use burn_tensor::wgpu::WgpuBackend;
    let options = Device::wgpu_options().graphics_api(WgpuBackend::Vulkan);
    options.init().map_err(|why| {
        LearnError::Device(format!(
            "no graphics processor with a Vulkan driver can be used ({why}); `vulkaninfo --summary` lists what the system offers"
        ))
    })
}

#[cfg(not(feature = "gpu"))]
fn gpu() -> Result<Device, LearnError> {
    Err(LearnError::Device(
        "this program was built without it; build it with `cargo build --release --features gpu`"
            .to_owned(),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_choice_holds_for_the_whole_process() {
        assert!(choose(DeviceKind::Cpu).is_ok() && choose(DeviceKind::Cpu).is_ok());
        let why = choose(DeviceKind::Gpu).map_or_else(|why| why.to_string(), |()| String::new());
        assert!(why.contains("--device"), "what to do is said: {why}");
    }
}
