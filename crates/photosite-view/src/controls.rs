//! Controls of the page: the keys of a capture that it can change, and the look of each control. Meanings of keys and
//! their values are those of the schema of capture files.

use hyper::StatusCode;
use serde::Serialize;
use serde_json::Value;

use super::answer::Failure;
use photosite_capture::capture_schema;
use photosite_sensor::presets;

/// Control of a key that can be changed, and the values that it takes.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Control {
    pub(super) key: &'static str,
    group: &'static str,
    label: &'static str,
    unit: &'static str,
    /// Description of the key by the schema.
    about: String,
    #[serde(flatten)]
    kind: Kind,
}

/// Look of a control.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Kind {
    /// A slider in even steps.
    Linear { min: f64, max: f64, step: f64 },
    /// A slider in even ratios.
    Logarithmic { min: f64, max: f64 },
    /// A whole number.
    Whole { min: u64, max: u64 },
    /// A choice of one of these.
    Choice { options: Vec<Named> },
    /// A switch, on or off.
    Flag,
    /// A choice of any of these.
    Several { options: Vec<Named> },
}

/// A value by its name, and what it means.
#[derive(Clone, Debug, Serialize)]
struct Named {
    name: String,
    about: String,
}

/// Look of a control whose options are those of the schema.
enum Looks {
    Linear(f64, f64, f64),
    Logarithmic(f64, f64),
    Whole(u64, u64),
    Choice,
    Flag,
    Several,
    Presets,
}

use Looks::{Choice, Flag, Linear, Logarithmic, Presets, Several, Whole};

/// Groups, keys, labels and units, in the order of the page.
#[rustfmt::skip]
const ALL: [(&str, &str, &str, &str, Looks); 23] = [
    ("Exposure", "exposure.auto", "Automatic exposure", "", Flag),
    ("Exposure", "exposure.time_s", "Exposure time", "s", Logarithmic(1e-5, 10.0)),
    ("Exposure", "lens.f_number", "f-number", "", Logarithmic(0.5, 64.0)),
    ("Exposure", "exposure.gain_db", "Gain", "dB", Linear(0.0, 36.0, 0.1)),
    ("Exposure", "exposure.digital_gain_db", "Digital gain", "dB", Linear(0.0, 24.0, 0.1)),
    ("Exposure", "exposure.temperature_c", "Temperature", "°C", Linear(-40.0, 80.0, 1.0)),
    ("Sensor", "sensor.preset", "Sensor", "", Presets),
    ("Sensor", "render.seed", "Seed", "", Whole(0, 9999)),
    ("Sensor", "exposure.stages_off", "Noise and other effects", "", Several),
    ("Development", "develop.white_balance", "White balance", "", Choice),
    ("Development", "develop.temperature_k", "Colour temperature", "K", Linear(2000.0, 12000.0, 50.0)),
    ("Development", "develop.tint", "Tint", "", Linear(-100.0, 100.0, 1.0)),
    ("Development", "develop.demosaic", "Demosaicking", "", Choice),
    ("Development", "develop.highlights", "Highlights", "", Choice),
    ("Development", "develop.defects", "Defective pixels", "", Choice),
    ("Development", "develop.noise_filter", "Noise filter", "", Choice),
    ("Development", "develop.exposure_ev", "Brightness", "EV", Linear(-4.0, 4.0, 0.1)),
    ("Development", "develop.tone_curve", "Tone curve", "", Choice),
    ("Development", "develop.sharpening", "Sharpening", "", Linear(0.0, 3.0, 0.05)),
    ("Development", "develop.sharpening_radius_px", "Sharpening radius", "px", Linear(0.3, 5.0, 0.1)),
    ("Development", "develop.colour_matrix", "Colour matrix", "", Flag),
    ("Development", "develop.lens_falloff", "Correct lens falloff", "", Flag),
    ("Development", "develop.distortion", "Correct lens distortion", "", Flag),
];

/// All controls.
pub(super) fn all() -> Vec<Control> {
    let schema = Schema(capture_schema());
    let control =
        |(group, key, label, unit, looks): (&'static str, &'static str, &'static str, &'static str, Looks)| {
            let found = schema.key(key);
            let options = || found.map_or_else(Vec::new, |found| schema.options(found));
            let kind = match looks {
                Linear(min, max, step) => Kind::Linear { min, max, step },
                Logarithmic(min, max) => Kind::Logarithmic { min, max },
                Whole(min, max) => Kind::Whole { min, max },
                Choice => Kind::Choice { options: options() },
                Flag => Kind::Flag,
                Several => Kind::Several { options: options() },
                Presets => Kind::Choice {
                    options: presets::names()
                        .map(|name| Named { name: name.to_owned(), about: String::new() })
                        .collect(),
                },
            };
            Control { key, group, label, unit, about: found.map_or_else(String::new, said), kind }
        };
    ALL.into_iter().map(control).collect()
}

/// Description of a schema's item.
fn said(schema: &Value) -> String {
    schema["description"].as_str().unwrap_or_default().replace('\n', " ")
}

/// The schema of capture files.
struct Schema(Value);

impl Schema {
    /// Schema of a key of a table.
    fn key(&self, key: &str) -> Option<&Value> {
        let (table, key) = key.split_once('.')?;
        let table = self.meant(self.0.get("properties")?.get(table)?);
        table.get("properties")?.get(key)
    }

    /// Schema that a reference means.
    fn meant<'a>(&'a self, schema: &'a Value) -> &'a Value {
        let name = schema["$ref"].as_str().and_then(|path| path.strip_prefix("#/$defs/"));
        let of_several = || schema["anyOf"].as_array().and_then(|all| all.iter().find(|one| one["$ref"].is_string()));
        match name {
            Some(name) => &self.0["$defs"][name],
            None => of_several().map_or(schema, |one| self.meant(one)),
        }
    }

    /// The values that are named, of a key or of the elements of its list.
    fn options(&self, schema: &Value) -> Vec<Named> {
        let meant = self.meant(schema.get("items").unwrap_or(schema));
        let one = |option: &Value| Some(Named { name: option["const"].as_str()?.to_owned(), about: said(option) });
        meant["oneOf"].as_array().into_iter().flatten().filter_map(one).collect()
    }
}

impl Control {
    /// The change, `key=value`, that a value of the page stands for.
    pub(super) fn change(&self, value: &str) -> Result<String, Failure> {
        let wrong = |what: String| Failure::new(StatusCode::BAD_REQUEST, format!("{}: {what}", self.key));
        let quoted = |name: &str, options: &[Named]| match options.iter().any(|option| option.name == name) {
            true => Ok(format!("{name:?}")),
            false => {
                let names: Vec<&str> = options.iter().map(|option| option.name.as_str()).collect();
                Err(wrong(format!("{name:?} is not one of {}", names.join(", "))))
            }
        };
        let toml = match &self.kind {
            Kind::Linear { .. } | Kind::Logarithmic { .. } => {
                let number = value.parse::<f64>().ok().filter(|number| number.is_finite());
                format!("{:?}", number.ok_or_else(|| wrong(format!("{value:?} is not a number")))?)
            }
            Kind::Whole { .. } => {
                let number = value.parse::<u32>();
                number.map_err(|_| wrong(format!("{value:?} is not a whole number")))?.to_string()
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

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_sensor::Stage;

    #[test]
    fn every_control_is_a_key_of_captures_with_its_meaning() {
        let all = all();
        for control in &all {
            assert!(!control.about.is_empty(), "{}", control.key);
            match &control.kind {
                Kind::Choice { options } | Kind::Several { options } => {
                    assert!(options.len() > 1, "{}", control.key);
                    let is_said = |option: &Named| !option.about.is_empty() || control.key == "sensor.preset";
                    assert!(options.iter().all(is_said), "{}", control.key);
                }
                Kind::Linear { .. } | Kind::Logarithmic { .. } | Kind::Whole { .. } | Kind::Flag => {}
            }
        }
        let stages = all.iter().find(|control| control.key == "exposure.stages_off").expect("there");
        assert!(matches!(&stages.kind, Kind::Several { options } if options.len() == Stage::ALL.len()));
    }
}
