//! `--device`: who traces the light.

use std::str::FromStr;

use photosite_capture::Capture;
use photosite_core::Result;
use photosite_pipeline::Monitor;

/// Choice of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum DeviceArg {
    /// The processor.
    Cpu,
    /// A graphics card: the first, or the one of a number or a part of its name.
    Gpu(Option<String>),
    /// The first graphics card, if it can render all of the scene.
    Auto,
}

impl FromStr for DeviceArg {
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

/// Words for those whose program was built without graphics cards.
#[cfg(not(feature = "gpu"))]
pub(super) const NOT_BUILT: &str =
    "this program was built without graphics cards: cargo install --path . --locked --features gpu builds it with them";

#[cfg(not(feature = "gpu"))]
impl DeviceArg {
    /// The capture on the device that was chosen.
    pub(super) fn settle(&self, capture: Capture, monitor: &dyn Monitor) -> Result<Capture> {
        use photosite_core::Error;
        use photosite_pipeline::Event;
        match self {
            Self::Cpu => Ok(capture),
            Self::Gpu(_) => {
                let help = Some("render with --device cpu".into());
                Err(Error::Usage { message: format!("--device: {NOT_BUILT}"), help })
            }
            Self::Auto => {
                monitor.report(Event::Warning(&format!("the processor traces: {NOT_BUILT}")));
                Ok(capture)
            }
        }
    }
}

#[cfg(feature = "gpu")]
impl DeviceArg {
    /// The capture on the device that was chosen. What a card cannot render is an error, or a warning where the choice
    /// was left open.
    pub(super) fn settle(&self, capture: Capture, monitor: &dyn Monitor) -> Result<Capture> {
        use photosite_core::Error;
        use photosite_gpu::support::unsupported;
        use photosite_pipeline::Event;
        use std::sync::Arc;
        let refused = unsupported(capture.scene(), capture.render());
        let (which, is_open) = match self {
            Self::Cpu => return Ok(capture),
            Self::Gpu(which) => (which.as_deref(), false),
            Self::Auto => (None, true),
        };
        let keep = |words: String, capture: Capture| {
            monitor.report(Event::Warning(&format!("the processor traces: {words}")));
            Ok(capture)
        };
        match refused {
            Some(refused) if is_open => return keep(refused.to_string(), capture),
            Some(refused) => return Err(capture.source().error(refused)),
            None => {}
        }
        match opened(which) {
            Ok(card) => Ok(capture.on_device(Arc::new(card))),
            Err(words) if is_open => keep(words, capture),
            Err(words) => {
                let help = Some("photosite devices lists what there is; --device cpu renders without".into());
                Err(Error::Resources { message: format!("--device: {words}"), help })
            }
        }
    }
}

/// The card of that number or name, or the first.
#[cfg(feature = "gpu")]
fn opened(which: Option<&str>) -> Result<photosite_gpu::Card, String> {
    let Some(which) = which else {
        let none = "this machine has no graphics card that can be used; software is used where it is asked for by name";
        return photosite_gpu::open(None)?.ok_or_else(|| none.to_owned());
    };
    let named = |name: &str| name.to_lowercase().contains(&which.to_lowercase());
    let number = match which.parse::<usize>() {
        Ok(number) => number,
        Err(_) => photosite_gpu::adapters()
            .iter()
            .position(|adapter| named(&adapter.name))
            .ok_or_else(|| format!("no device of this machine is called {which:?}"))?,
    };
    photosite_gpu::open(Some(number))?.ok_or_else(|| format!("there is no device {number}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_have_numbers_or_names() {
        for (text, device) in [
            ("cpu", DeviceArg::Cpu),
            ("auto", DeviceArg::Auto),
            ("gpu", DeviceArg::Gpu(None)),
            ("gpu:1", DeviceArg::Gpu(Some("1".to_owned()))),
            ("gpu:llvmpipe", DeviceArg::Gpu(Some("llvmpipe".to_owned()))),
        ] {
            assert_eq!(text.parse(), Ok(device));
        }
        for text in ["", "cuda", "gpu:", "cpu:1", "GPU"] {
            assert!(text.parse::<DeviceArg>().is_err(), "{text}");
        }
    }
}
