//! The device that traces the light of a capture.

use std::sync::Arc;

use super::Capture;
use photosite_transport::integrator::Device;

impl Capture {
    /// The capture, whose light a device traces in place of the processor. It is no key of the file: another machine has
    /// other devices. Reports and fingerprints name it, since the last bits of the image depend on it.
    #[must_use]
    pub fn on_device(self, device: Arc<dyn Device>) -> Self {
        Self { device: Some(device), ..self }
    }

    /// The device that traces the capture's light; `None` for the processor.
    pub fn device(&self) -> Option<&Arc<dyn Device>> {
        self.device.as_ref()
    }
}
