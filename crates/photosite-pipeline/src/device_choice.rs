//! Choice of the device that traces light or exposes: the processor, or a graphics card of this machine.
//!
//! In: what a user writes, `cpu`, `gpu`, `gpu:1`, `gpu:NAME` or `auto`. Out: a [`Device`] for captures, or a
//! [`SensorCard`], or none.

use std::str::FromStr;
use std::sync::Arc;

use photosite_capture::Capture;
use photosite_core::{Error, Result};
use photosite_transport::integrator::Device;
use serde::Serialize;

use crate::expose::sensor_card::SensorCard;
use crate::monitor::{Event, Monitor};

/// Choice of a device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The processor.
    #[default]
    Cpu,
    /// A graphics card: the first, or the one of a number or a part of its name.
    Gpu(Option<String>),
    /// The first graphics card, if it has what the settings ask for.
    Auto,
}

impl FromStr for DeviceChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "cpu" => Ok(Self::Cpu),
            None if text == "gpu" => Ok(Self::Gpu(None)),
            None if text == "auto" => Ok(Self::Auto),
            Some(("gpu", which)) if !which.is_empty() => Ok(Self::Gpu(Some(which.to_owned()))),
            None | Some(_) => Err("write cpu, gpu, auto, or one of `photosite devices` such as gpu:0".to_owned()),
        }
    }
}

/// Words for those whose program was built without graphics cards; `None` where it was built with them.
pub const BUILT_WITHOUT: Option<&str> = if cfg!(feature = "gpu") {
    None
} else {
    Some(
        "this program was built without graphics cards: cargo install --path . --locked --features gpu builds it with them",
    )
};

/// A device of this machine.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceFacts {
    /// Value of `--device`.
    pub device: String,
    /// Name.
    pub name: String,
    /// Kind: "processor", "discrete", "integrated", "virtual", "software", "unknown".
    pub kind: &'static str,
    /// Interface of a graphics card: "vulkan", "metal", "dx12".
    pub interface: Option<String>,
    /// Driver of a graphics card.
    pub driver: Option<String>,
    /// Largest table of a scene, GiB.
    pub largest_table_gib: Option<f64>,
    /// Why it cannot be used.
    pub refusal: Option<String>,
}

/// Devices of this machine: the processor, and graphics cards where the program was built with them.
pub fn devices() -> Vec<DeviceFacts> {
    let processor = DeviceFacts {
        device: "cpu".to_owned(),
        name: format!("the processor, {} threads", rayon::current_num_threads()),
        kind: "processor",
        interface: None,
        driver: None,
        largest_table_gib: None,
        refusal: None,
    };
    std::iter::once(processor).chain(cards()).collect()
}

#[cfg(not(feature = "gpu"))]
fn cards() -> impl Iterator<Item = DeviceFacts> {
    std::iter::empty()
}

#[cfg(feature = "gpu")]
fn cards() -> impl Iterator<Item = DeviceFacts> {
    let facts = |(number, adapter): (usize, photosite_gpu::Adapter)| DeviceFacts {
        device: format!("gpu:{number}"),
        name: adapter.name,
        kind: adapter.kind,
        interface: Some(adapter.interface),
        driver: Some(adapter.driver),
        largest_table_gib: Some((adapter.largest_binding as f64 / f64::from(1 << 30) * 1e3).round() / 1e3),
        refusal: adapter.refusal,
    };
    photosite_gpu::adapters().into_iter().enumerate().map(facts)
}

impl DeviceChoice {
    /// The capture on the chosen device. What a card cannot render is an error, or a warning where the choice was left
    /// open.
    pub fn settle(&self, capture: Capture, monitor: &dyn Monitor) -> Result<Capture> {
        Ok(match self.device_for([&capture], monitor)? {
            Some(device) => capture.on_device(device),
            None => capture,
        })
    }

    /// The chosen device, for the light of all these captures; `None` for the processor.
    #[cfg(not(feature = "gpu"))]
    pub fn device_for<'a>(
        &self,
        _: impl IntoIterator<Item = &'a Capture>,
        monitor: &dyn Monitor,
    ) -> Result<Option<Arc<dyn Device>>> {
        self.without_cards("traces", monitor).map(|()| None)
    }

    /// The chosen card, for sensors; `None` for the processor.
    #[cfg(not(feature = "gpu"))]
    pub fn sensor_card(&self, monitor: &dyn Monitor) -> Result<Option<Arc<SensorCard>>> {
        self.without_cards("exposes", monitor).map(|()| None)
    }

    /// Refuses a card, or warns that the processor does the work where the choice was left open.
    #[cfg(not(feature = "gpu"))]
    fn without_cards(&self, does: &str, monitor: &dyn Monitor) -> Result<()> {
        let words = BUILT_WITHOUT.unwrap_or_default();
        match self {
            Self::Cpu => Ok(()),
            Self::Gpu(_) => {
                let help = Some("take the device cpu".into());
                Err(Error::Usage { message: format!("device: {words}"), help })
            }
            Self::Auto => {
                monitor.report(Event::Warning(&format!("the processor {does}: {words}")));
                Ok(())
            }
        }
    }

    /// The chosen device, for the light of all these captures; `None` for the processor. What a card cannot render is
    /// an error, or a warning where the choice was left open.
    #[cfg(feature = "gpu")]
    pub fn device_for<'a>(
        &self,
        captures: impl IntoIterator<Item = &'a Capture>,
        monitor: &dyn Monitor,
    ) -> Result<Option<Arc<dyn Device>>> {
        for capture in captures {
            match photosite_gpu::support::unsupported(capture.render()) {
                Some(refused) if *self == Self::Auto => {
                    monitor.report(Event::Warning(&format!("the processor traces: {refused}")));
                    return Ok(None);
                }
                Some(refused) if *self != Self::Cpu => return Err(capture.source().error(refused)),
                Some(_) | None => {}
            }
        }
        Ok(self.card("traces", monitor)?.map(|card| -> Arc<dyn Device> { card }))
    }

    /// The chosen card, for sensors; `None` for the processor. What it lacks of a sensor the processor does, as
    /// warnings of the exposure say.
    ///
    /// # Errors
    ///
    /// A card that is not there, or cannot be used.
    #[cfg(feature = "gpu")]
    pub fn sensor_card(&self, monitor: &dyn Monitor) -> Result<Option<Arc<SensorCard>>> {
        Ok(self.card("exposes", monitor)?.map(|card| Arc::new(SensorCard::new(card))))
    }

    /// The chosen card; `None` for the processor, with a warning that it does the work where the choice was left open.
    #[cfg(feature = "gpu")]
    fn card(&self, does: &str, monitor: &dyn Monitor) -> Result<Option<Arc<photosite_gpu::Card>>> {
        let which = match self {
            Self::Cpu => return Ok(None),
            Self::Gpu(which) => which.as_deref(),
            Self::Auto => None,
        };
        match opened(which) {
            Ok(card) => Ok(Some(card)),
            Err(words) if *self == Self::Auto => {
                monitor.report(Event::Warning(&format!("the processor {does}: {words}")));
                Ok(None)
            }
            Err(words) => {
                let help = Some("photosite devices lists what there is; the device cpu is always there".into());
                Err(Error::Resources { message: format!("device: {words}"), help })
            }
        }
    }
}

/// The card of that number or name, or the first.
#[cfg(feature = "gpu")]
fn opened(which: Option<&str>) -> Result<Arc<photosite_gpu::Card>, String> {
    let named = |which: &str| {
        let is_called = |name: &str| name.to_lowercase().contains(&which.to_lowercase());
        let found = photosite_gpu::adapters().iter().position(|adapter| is_called(&adapter.name));
        found.ok_or_else(|| format!("no device of this machine is called {which:?}"))
    };
    let number = match which {
        Some(which) => which.parse().map_or_else(|_| named(which), Ok)?,
        None => photosite_gpu::first().ok_or(
            "this machine has no graphics card that can be used; software is used where it is asked for by name",
        )?,
    };
    photosite_gpu::shared(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_have_numbers_or_names() {
        for (text, device) in [
            ("cpu", DeviceChoice::Cpu),
            ("auto", DeviceChoice::Auto),
            ("gpu", DeviceChoice::Gpu(None)),
            ("gpu:1", DeviceChoice::Gpu(Some("1".to_owned()))),
            ("gpu:llvmpipe", DeviceChoice::Gpu(Some("llvmpipe".to_owned()))),
        ] {
            assert_eq!(text.parse(), Ok(device));
        }
        for text in ["", "cuda", "gpu:", "cpu:1", "GPU"] {
            assert!(text.parse::<DeviceChoice>().is_err(), "{text}");
        }
    }
}
