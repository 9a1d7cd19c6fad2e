//! What the page can change: keys of a capture, and how a control of each looks.

use serde::Serialize;

use super::answer::Failure;
use crate::sensor::{Stage, presets};
use hyper::StatusCode;

/// A key that can be changed, and what values it takes.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Control {
    pub(super) key: &'static str,
    pub(super) group: &'static str,
    pub(super) label: &'static str,
    pub(super) unit: &'static str,
    #[serde(flatten)]
    pub(super) kind: Kind,
}

/// How a control looks.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub(super) enum Kind {
    /// A slider in even steps.
    Linear { min: f64, max: f64, step: f64 },
    /// A slider in even ratios.
    Logarithmic { min: f64, max: f64 },
    /// A whole number.
    Whole { min: u64, max: u64 },
    /// One of these.
    Choice { options: Vec<String> },
    /// On or off.
    Flag,
    /// Any of these.
    Several { options: Vec<String> },
}

/// The names by which a capture file calls them.
fn names<T: Serialize>(values: impl IntoIterator<Item = T>) -> Vec<String> {
    let name = |value| serde_json::to_value(value).ok()?.as_str().map(str::to_owned);
    values.into_iter().filter_map(name).collect()
}

/// All controls.
pub(super) fn all() -> Vec<Control> {
    let control = |group, key, label, unit, kind| Control { key, group, label, unit, kind };
    let choice = |options: &[&str]| Kind::Choice { options: options.iter().map(|&name| name.to_owned()).collect() };
    let linear = |min, max, step| Kind::Linear { min, max, step };
    vec![
        control("Exposure", "exposure.time_s", "Exposure time", "s", Kind::Logarithmic { min: 1e-5, max: 10.0 }),
        control("Exposure", "exposure.auto", "Automatic exposure", "", Kind::Flag),
        control("Exposure", "exposure.compensation_ev", "Compensation", "EV", linear(-4.0, 4.0, 0.1)),
        control("Exposure", "exposure.gain_db", "Gain", "dB", linear(0.0, 48.0, 0.1)),
        control("Exposure", "exposure.digital_gain_db", "Digital gain", "dB", linear(0.0, 48.0, 0.1)),
        control("Exposure", "exposure.temperature_c", "Temperature", "°C", linear(-40.0, 80.0, 1.0)),
        control(
            "Sensor",
            "sensor.preset",
            "Sensor",
            "",
            Kind::Choice { options: presets::names().map(str::to_owned).collect() },
        ),
        control("Sensor", "render.seed", "Seed", "", Kind::Whole { min: 0, max: u64::from(u32::MAX) }),
        control("Sensor", "exposure.stages_off", "Stages left out", "", Kind::Several { options: names(Stage::ALL) }),
        control(
            "Development",
            "develop.white_balance",
            "White balance",
            "",
            choice(&[
                "as-shot",
                "grey-world",
                "white-patch",
                "temperature",
                "candle",
                "incandescent",
                "halogen",
                "fluorescent",
                "d50",
                "flash",
                "daylight",
                "overcast",
                "shade",
                "blue-sky",
                "none",
            ]),
        ),
        control("Development", "develop.temperature_k", "Temperature of white", "K", linear(2000.0, 12000.0, 50.0)),
        control("Development", "develop.tint", "Tint", "", linear(-150.0, 150.0, 1.0)),
        control(
            "Development",
            "develop.demosaic",
            "Demosaic",
            "",
            choice(&["auto", "nearest", "bilinear", "guided", "malvar", "menon", "markesteijn", "lmmse"]),
        ),
        control("Development", "develop.exposure_ev", "Brightness", "EV", linear(-4.0, 4.0, 0.1)),
        control(
            "Development",
            "develop.tone_curve",
            "Tone curve",
            "",
            choice(&["linear", "srgb", "gamma", "filmic", "reinhard", "log", "local"]),
        ),
        control("Development", "develop.sharpening", "Sharpening", "", linear(0.0, 3.0, 0.05)),
    ]
}

impl Control {
    /// The change, `key=value`, that a value of the page stands for.
    pub(super) fn change(&self, value: &str) -> Result<String, Failure> {
        let wrong = |what: String| Failure::new(StatusCode::BAD_REQUEST, format!("{}: {what}", self.key));
        let quoted = |name: &str, options: &[String]| match options.iter().any(|option| option == name) {
            true => Ok(format!("{name:?}")),
            false => Err(wrong(format!("{name:?} is none of {}", options.join(", ")))),
        };
        let toml = match &self.kind {
            Kind::Linear { .. } | Kind::Logarithmic { .. } => {
                let number = value.parse::<f64>().ok().filter(|number| number.is_finite());
                format!("{:?}", number.ok_or_else(|| wrong(format!("{value:?} is no number")))?)
            }
            Kind::Whole { .. } => {
                let number = value.parse::<u64>();
                number.map_err(|_| wrong(format!("{value:?} is no whole number")))?.to_string()
            }
            Kind::Choice { options } => quoted(value, options)?,
            Kind::Flag if value == "true" || value == "false" => value.to_owned(),
            Kind::Flag => return Err(wrong(format!("{value:?} is neither true nor false"))),
            Kind::Several { options } => {
                let names = value.split(',').filter(|name| !name.is_empty());
                let quoted: Vec<String> = names.map(|name| quoted(name, options)).collect::<Result<_, _>>()?;
                format!("[{}]", quoted.join(", "))
            }
        };
        Ok(format!("{}={toml}", self.key))
    }
}
