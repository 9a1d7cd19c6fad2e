//! Variations: the values of the keys of a `[[vary]]` in each frame.

use super::distribution::VariationDistribution;
use super::draws::Draws;
use super::toml_value::toml;
use super::{SamplingDescription, VariationDescription};
use photosite_core::Invalid;
use photosite_core::key_path;
use photosite_core::math::hash::hash64;

/// Matches of a `[[vary]]` pattern in the capture and on disk.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Keys that the variation's key matches: one, where it is no pattern.
    pub keys: Vec<String>,
    /// Files that match the variation's pattern of files, relative to the capture.
    pub files: Vec<String>,
}

/// Keys with the distribution of their values.
#[derive(Clone, Debug)]
pub(super) struct Variation {
    keys: Vec<String>,
    distribution: VariationDistribution,
    sampling: SamplingDescription,
    /// Whether each key has a value of its own.
    is_of_pattern: bool,
    per_camera: bool,
}

impl VariationDescription {
    /// Keys of the variation, as they are written.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        let of_tables = self.choices.iter().flatten().next().into_iter().flat_map(|table| table.keys());
        self.key.as_deref().into_iter().chain(of_tables.map(String::as_str)).map(str::trim)
    }
}

impl Variation {
    /// Checks a description.
    pub(super) fn new(d: &VariationDescription, found: &Found, sampling: SamplingDescription) -> Result<Self, Invalid> {
        let distribution = VariationDistribution::new(d, &found.files)?;
        let refuse = |key: &str, message: &str, help: &str| Err(Invalid::new(key, message).help(help));
        match (&d.key, &d.choices) {
            (None, None) => {
                return refuse("", "the key `key` is missing", "for example key = \"exposure.time_s\"");
            }
            (Some(_), Some(_)) => {
                return refuse(
                    "key",
                    "cannot be combined with choices, whose tables name their keys",
                    "remove one of them",
                );
            }
            (Some(_), None) | (None, Some(_)) => {}
        }
        let is_pattern =
            d.key.as_ref().is_some_and(|key| key_path::keys(key).iter().any(|key| key_path::is_pattern(key)));
        if d.together && !(is_pattern && matches!(distribution, VariationDistribution::Value(_))) {
            let message = "only applies with a key that matches several, such as \"materials.paint-*.roughness\"";
            return refuse("together", message, "remove it");
        }
        if let VariationDistribution::Count([_, most]) = distribution {
            let keys = found.keys.len();
            if !is_pattern {
                let message = "only applies with a key that matches several, such as \"lights.*.on\"";
                return refuse("count", message, "choice = [true, false] varies one key");
            }
            if most as usize > keys {
                let message = format!("asks for {most}, but the key matches {keys}");
                return refuse("count", &message, "write a number up to that");
            }
        }
        let keys = match &distribution {
            VariationDistribution::Choices(choice) => choice.things()[0].keys().cloned().collect(),
            VariationDistribution::Value(_) | VariationDistribution::Count(_) => found.keys.clone(),
        };
        Ok(Self { keys, distribution, sampling, is_of_pattern: is_pattern && !d.together, per_camera: d.per_camera })
    }

    /// Keys that vary.
    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        self.keys.iter().map(|key| key.trim())
    }

    /// Whether each camera has values of its own.
    pub(super) fn is_per_camera(&self) -> bool {
        self.per_camera
    }

    /// Draws `key=value` of each key in frame `frame` of `frames`, for a camera. `seed` is this variation's own.
    pub(super) fn set(&self, seed: u64, frame: u32, frames: u32, camera: usize) -> Vec<String> {
        let seed = hash64(seed, if self.per_camera { camera as u64 + 1 } else { 0 });
        let draws = |seed| Draws::new(self.sampling, seed, frame, frames);
        match &self.distribution {
            VariationDistribution::Choices(choice) => {
                let table = choice.draw(&mut draws(seed));
                table.iter().map(|(key, value)| format!("{key}={}", toml(value))).collect()
            }
            VariationDistribution::Count([least, most]) => {
                let mut draws = draws(seed);
                let count = *least as usize + draws.index((most - least) as usize + 1);
                let is_chosen = draws.subset(count, self.keys.len());
                self.keys.iter().zip(is_chosen).map(|(key, is_chosen)| format!("{key}={is_chosen}")).collect()
            }
            VariationDistribution::Value(distribution) => {
                // A key that comes to be, as of another material, leaves the values of the others as they are.
                let seed_of = |key: &str| if self.is_of_pattern { hash64(seed, hash_of(key)) } else { seed };
                let value = |key: &String| distribution.draw(&mut draws(seed_of(key)), frame, frames);
                self.keys.iter().map(|key| format!("{key}={}", value(key))).collect()
            }
        }
    }
}

fn hash_of(text: &str) -> u64 {
    text.bytes().fold(text.len() as u64, |hash, byte| hash64(hash, u64::from(byte)))
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn described(d: Value) -> VariationDescription {
        serde_json::from_value(d).expect("a description")
    }

    fn found(keys: &[&str]) -> Found {
        Found { keys: keys.iter().map(|key| (*key).to_owned()).collect(), files: vec!["a.png".into(), "b.png".into()] }
    }

    fn variation(d: Value, keys: &[&str]) -> Variation {
        Variation::new(&described(d), &found(keys), SamplingDescription::Independent).expect("a variation")
    }

    /// Reference: draws of the first version with data sets, for a set of seed 5 and three frames, so that sets keep
    /// their images.
    #[test]
    fn draws_stay_what_they_were() {
        let cases = [
            (
                json!({ "log_uniform": [0.002, 0.006] }),
                0,
                ["0.0027582668479332116", "0.0035291849130929813", "0.0020969476181414374"],
            ),
            (json!({ "normal": [20, 5] }), 0, ["17.218666398696268", "20.604232729777408", "23.23595738726561"]),
            (json!({ "uniform": [300, 900] }), 0, ["527.1123591872968", "744.1957515156539", "893.1357231786767"]),
            (json!({ "choice": ["D65", "A", "D50"], "per_camera": true }), 0, ["\"D65\"", "\"A\"", "\"D65\""]),
            (json!({ "sweep": [2, 4] }), 0, ["2.0", "3.0", "4.0"]),
        ];
        for (i, (mut distribution, camera, golden)) in cases.into_iter().enumerate() {
            distribution["key"] = "k".into();
            let variation = variation(distribution, &["k"]);
            let seed = hash64(hash64(5, 2), i as u64);
            let drawn = [0, 1, 2].map(|frame| variation.set(seed, frame, 3, camera));
            assert_eq!(drawn, golden.map(|value| vec![format!("k={value}")]));
        }
        let own = variation(json!({ "key": "k", "choice": ["D65", "A", "D50"], "per_camera": true }), &["k"]);
        let drawn = [0, 1, 2].map(|frame| own.set(hash64(hash64(5, 2), 3), frame, 3, 1).remove(0));
        assert_eq!(drawn, ["k=\"A\"", "k=\"D50\"", "k=\"A\""]);
    }

    #[test]
    fn values_of_any_kind_are_written_as_toml() {
        let choice = json!(["D65", [1, 2.5], { "file": "a \"b\".csv" }]);
        let variation = variation(json!({ "key": "k", "choice": choice }), &["k"]);
        let mut found: Vec<String> = (0..50).flat_map(|frame| variation.set(1, frame, 50, 0)).collect();
        found.sort();
        found.dedup();
        assert_eq!(found, ["k=\"D65\"", "k=[1, 2.5]", r#"k={ "file" = "a \"b\".csv" }"#]);
    }

    #[test]
    fn cameras_share_a_value_unless_told_otherwise() {
        let shared = variation(json!({ "key": "a", "uniform": [0, 1] }), &["a"]);
        let own = variation(json!({ "key": "a", "uniform": [0, 1], "per_camera": true }), &["a"]);
        assert_eq!(shared.set(1, 3, 9, 0), shared.set(1, 3, 9, 1));
        assert_ne!(own.set(1, 3, 9, 0), own.set(1, 3, 9, 1));
        assert_ne!(shared.set(1, 3, 9, 0), shared.set(1, 4, 9, 0));
    }

    #[test]
    fn keys_of_a_pattern_have_values_of_their_own_or_one() {
        let own = variation(json!({ "key": "m.*.x", "uniform": [0, 1] }), &["m.a.x", "m.b.x"]);
        let [a, b] = own.set(1, 0, 9, 0).try_into().expect("two");
        assert_ne!(a.strip_prefix("m.a.x="), b.strip_prefix("m.b.x="));
        // Another key leaves them as they are.
        let more = variation(json!({ "key": "m.*.x", "uniform": [0, 1] }), &["m.0.x", "m.a.x", "m.b.x"]);
        assert_eq!(more.set(1, 0, 9, 0)[1..], [a, b]);
        let one = variation(json!({ "key": "m.*.x", "uniform": [0, 1], "together": true }), &["m.a.x", "m.b.x"]);
        let [a, b] = one.set(1, 0, 9, 0).try_into().expect("two");
        assert_eq!(a.strip_prefix("m.a.x=").expect("its key"), b.strip_prefix("m.b.x=").expect("its key"));
    }

    #[test]
    fn keys_of_a_table_vary_together() {
        let tables = json!([{ "a": 1, "b": "x" }, { "a": 2, "b": "y" }]);
        let variation = variation(json!({ "choices": tables, "weights": [1, 0] }), &[]);
        assert_eq!(variation.keys().collect::<Vec<_>>(), ["a", "b"]);
        assert!((0..20).all(|frame| variation.set(1, frame, 20, 0) == ["a=1", "b=\"x\""]));
    }

    #[test]
    fn so_many_of_the_keys_are_true() {
        let variation =
            variation(json!({ "key": "l.*.on", "count": [1, 3] }), &["l.0.on", "l.1.on", "l.2.on", "l.3.on"]);
        let mut counts = [0; 5];
        for frame in 0..3000 {
            let set = variation.set(4, frame, 3000, 0);
            assert!(set.iter().enumerate().all(|(i, change)| change.starts_with(&format!("l.{i}.on="))));
            counts[set.iter().filter(|change| change.ends_with("=true")).count()] += 1;
        }
        // Five standard deviations of a third of 3000.
        assert!(
            counts[0] == 0 && counts[4] == 0 && counts[1..4].iter().all(|n: &i32| n.abs_diff(1000) < 130),
            "{counts:?}"
        );
    }

    #[test]
    fn what_cannot_be_varied_so_is_refused_at_its_key() {
        for (d, key) in [
            (json!({ "key": "a" }), ""),
            (json!({ "uniform": [0, 1] }), ""),
            (json!({ "key": "a", "uniform": [0, 1], "sweep": [0, 1] }), "sweep"),
            (json!({ "key": "a", "uniform": [1, 0] }), "uniform"),
            (json!({ "key": "a", "log_uniform": [0, 1] }), "log_uniform"),
            (json!({ "key": "a", "normal": [0, -1] }), "normal"),
            (json!({ "key": "a", "choice": [] }), "choice"),
            (json!({ "key": "a", "choice": [1, 2], "weights": [1] }), "weights"),
            (json!({ "key": "a", "choice": [1, 2], "weights": [0, 0] }), "weights"),
            (json!({ "key": "a", "choice": [1, 2], "weights": [2, -1] }), "weights"),
            (json!({ "key": "a", "uniform": [1, 2], "weights": [1, 1] }), "weights"),
            (json!({ "key": "a", "choices": [{ "b": 1 }] }), "key"),
            (json!({ "choices": [{ "b": 1 }, { "c": 1 }] }), "choices[1]"),
            (json!({ "choices": [{ "b": 1 }, { "b": 1, "c": 1 }] }), "choices[1]"),
            (json!({ "choices": [{}] }), "choices[0]"),
            (json!({ "key": "a", "box": [[0, 1], [1, 0]] }), "box"),
            (json!({ "key": "a", "box": [[0], [1, 1]] }), "box"),
            (json!({ "key": "a", "sphere": { "radius_m": [-1, 1] } }), "sphere.radius_m"),
            (json!({ "key": "a", "sphere": { "up": [0, 0, 0] } }), "sphere.up"),
            (json!({ "key": "a", "sphere": { "angle_deg": [0, 200] } }), "sphere.angle_deg"),
            (json!({ "key": "a", "rotation": { "angle_deg": [0, 20] } }), "rotation.angle_deg"),
            (json!({ "key": "a", "hsv": { "value": [0, 2] } }), "hsv.value"),
            (json!({ "key": "a", "count": [0, 1] }), "count"),
            (json!({ "key": "a.*", "count": [0, 2] }), "count"),
            (json!({ "key": "a.*", "count": [1, 0] }), "count"),
            (json!({ "key": "a", "uniform": [0, 1], "together": true }), "together"),
        ] {
            let refused = Variation::new(&described(d.clone()), &found(&["a"]), SamplingDescription::Independent);
            let invalid = refused.expect_err(&d.to_string());
            assert!(invalid.key == key && invalid.help.is_some(), "{d}: {invalid:?}");
        }
    }
}
