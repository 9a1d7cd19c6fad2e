//! The value of a varied key in a frame.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use super::VariationDescription;
use photosite_core::Invalid;
use photosite_core::math::hash::hash64;
use photosite_core::math::philox::Philox;

/// How values are found.
#[derive(Clone, Debug)]
enum Law {
    Uniform([f64; 2]),
    LogUniform([f64; 2]),
    Normal([f64; 2]),
    Choice(Vec<Value>),
    Sweep([f64; 2]),
}

/// A key with its law.
#[derive(Clone, Debug)]
pub(super) struct Variation {
    key: String,
    law: Law,
    per_camera: bool,
}

impl Variation {
    /// Checks a description.
    pub(super) fn new(d: &VariationDescription) -> Result<Self, Invalid> {
        let numbers = |law: fn([f64; 2]) -> Law, range: &Option<[f64; 2]>| range.map(law);
        let given = [
            ("uniform", numbers(Law::Uniform, &d.uniform)),
            ("log_uniform", numbers(Law::LogUniform, &d.log_uniform)),
            ("normal", numbers(Law::Normal, &d.normal)),
            ("choice", d.choice.clone().map(Law::Choice)),
            ("sweep", numbers(Law::Sweep, &d.sweep)),
        ];
        let mut laws = given.into_iter().filter_map(|(name, law)| law.map(|law| (name, law)));
        let Some((name, law)) = laws.next() else {
            return Err(Invalid::new("", "does not say how the key varies").help("for example uniform = [0, 12]"));
        };
        if let Some((other, _)) = laws.next() {
            return Err(Invalid::new(other, format!("cannot go with {name}")).help("keep one of them"));
        }
        let wrong = |message: String, help: &str| Err(Invalid::new(name, message).help(help));
        match &law {
            Law::Uniform([a, b]) | Law::Sweep([a, b]) if !(a.is_finite() && b.is_finite()) => {
                wrong(format!("must be two numbers, got {a} and {b}"), "for example [0, 12]")
            }
            Law::Uniform([a, b]) if a > b => wrong(format!("{a} is above {b}"), "write the smaller number first"),
            Law::LogUniform([a, b]) if !(*a > 0.0 && a <= b && b.is_finite()) => {
                wrong(format!("must be two numbers above 0 in order, got {a} and {b}"), "for example [100, 10000]")
            }
            Law::Normal([mean, deviation]) if !(mean.is_finite() && *deviation >= 0.0 && deviation.is_finite()) => {
                wrong(format!("must be a mean and a deviation, got {mean} and {deviation}"), "for example [20, 5]")
            }
            Law::Choice(values) if values.is_empty() => {
                wrong("has nothing to choose from".to_owned(), "for example [\"D65\", \"A\"]")
            }
            Law::Uniform(_) | Law::LogUniform(_) | Law::Normal(_) | Law::Choice(_) | Law::Sweep(_) => {
                Ok(Self { key: d.key.clone(), law, per_camera: d.per_camera })
            }
        }
    }

    /// The key that varies.
    pub(super) fn key(&self) -> &str {
        self.key.trim()
    }

    /// Whether each camera has a value of its own.
    pub(super) fn is_per_camera(&self) -> bool {
        self.per_camera
    }

    /// `key=value` in a frame of so many, for a camera. `seed` is this variation's own.
    pub(super) fn set(&self, seed: u64, frame: u32, frames: u32, camera: usize) -> String {
        let who = if self.per_camera { camera as u64 + 1 } else { 0 };
        let mut random = Philox::new(hash64(seed, who), u64::from(frame));
        let value = match &self.law {
            Law::Uniform([a, b]) => number(a + (b - a) * random.random::<f64>()),
            Law::LogUniform([a, b]) => number(a * (b / a).powf(random.random::<f64>())),
            Law::Normal([mean, deviation]) => {
                let z: f64 = StandardNormal.sample(&mut random);
                number(mean + deviation * z)
            }
            Law::Choice(values) => toml(&values[random.random_range(0..values.len())]),
            Law::Sweep([first, last]) => {
                let part = f64::from(frame) / f64::from(frames.max(2) - 1);
                number(first + (last - first) * part)
            }
        };
        format!("{}={value}", self.key)
    }
}

/// A number as TOML has it, with all digits that tell it from others.
pub(super) fn number(x: f64) -> String {
    format!("{x:?}")
}

/// A value as TOML writes it in a line.
pub fn toml(value: &Value) -> String {
    match value {
        // Null cannot come from TOML.
        Value::Null => "false".to_owned(),
        Value::Bool(_) | Value::Number(_) => value.to_string(),
        Value::String(text) => text_in_quotes(text),
        Value::Array(values) => format!("[{}]", values.iter().map(toml).collect::<Vec<_>>().join(", ")),
        Value::Object(table) => {
            let pairs = table.iter().map(|(key, value)| format!("{} = {}", text_in_quotes(key), toml(value)));
            format!("{{ {} }}", pairs.collect::<Vec<_>>().join(", "))
        }
    }
}

/// JSON's strings are TOML's basic ones.
fn text_in_quotes(text: &str) -> String {
    Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn nothing(key: &str) -> VariationDescription {
        VariationDescription {
            key: key.to_owned(),
            uniform: None,
            log_uniform: None,
            normal: None,
            choice: None,
            sweep: None,
            per_camera: false,
        }
    }

    fn values(d: VariationDescription) -> Vec<f64> {
        let variation = Variation::new(&d).expect("a law");
        let value = |frame| variation.set(7, frame, 1000, 0).split_once('=').and_then(|(_, v)| v.parse().ok());
        (0..1000).map(|frame| value(frame).expect("a number")).collect()
    }

    #[test]
    fn numbers_follow_their_law() {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        // Five standard deviations of the mean of a thousand.
        let near = |found: f64, wanted: f64, deviation: f64| {
            assert!((found - wanted).abs() < 5.0 * deviation / 1000f64.sqrt(), "{found}, not {wanted}");
        };
        let uniform = values(VariationDescription { uniform: Some([-2.0, 6.0]), ..nothing("a") });
        assert!(uniform.iter().all(|v| (-2.0..6.0).contains(v)));
        near(mean(&uniform), 2.0, 8.0 / 12f64.sqrt());
        let logs = values(VariationDescription { log_uniform: Some([0.01, 100.0]), ..nothing("a") });
        let logs: Vec<f64> = logs.iter().map(|v| v.log10()).collect();
        assert!(logs.iter().all(|v| (-2.0..2.0).contains(v)));
        near(mean(&logs), 0.0, 4.0 / 12f64.sqrt());
        let normal = values(VariationDescription { normal: Some([20.0, 3.0]), ..nothing("a") });
        near(mean(&normal), 20.0, 3.0);
        let sweep = values(VariationDescription { sweep: Some([1.0, 3.0]), ..nothing("a") });
        assert_eq!((sweep[0], sweep[999]), (1.0, 3.0));
        assert!(sweep.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn values_of_any_kind_are_written_as_toml() {
        let choice = vec![json!("D65"), json!([1, 2.5]), json!({ "file": "a \"b\".csv" })];
        let variation = Variation::new(&VariationDescription { choice: Some(choice), ..nothing("k") }).expect("a law");
        let mut found: Vec<String> = (0..50).map(|frame| variation.set(1, frame, 50, 0)).collect();
        found.sort();
        found.dedup();
        assert_eq!(found, ["k=\"D65\"", "k=[1, 2.5]", r#"k={ "file" = "a \"b\".csv" }"#]);
    }

    #[test]
    fn cameras_share_a_value_unless_told_otherwise() {
        let uniform = VariationDescription { uniform: Some([0.0, 1.0]), ..nothing("a") };
        let own = VariationDescription { per_camera: true, ..uniform.clone() };
        let [shared, own] = [uniform, own].map(|d| Variation::new(&d).expect("a law"));
        assert_eq!(shared.set(1, 3, 9, 0), shared.set(1, 3, 9, 1));
        assert_ne!(own.set(1, 3, 9, 0), own.set(1, 3, 9, 1));
        assert_ne!(shared.set(1, 3, 9, 0), shared.set(1, 4, 9, 0));
    }

    #[test]
    fn one_law_and_one_only() {
        assert!(Variation::new(&nothing("a")).is_err());
        let two = VariationDescription { uniform: Some([0.0, 1.0]), sweep: Some([0.0, 1.0]), ..nothing("a") };
        assert_eq!(Variation::new(&two).expect_err("two laws").key, "sweep");
        let back = VariationDescription { uniform: Some([1.0, 0.0]), ..nothing("a") };
        assert_eq!(Variation::new(&back).expect_err("backwards").key, "uniform");
    }
}
