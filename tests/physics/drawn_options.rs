//! Values of keys at random, as the schema describes them that the program makes of its keys. Each choice has random
//! numbers of its own, by its path, so that a new key changes only the draws that it takes part in.

use std::collections::BTreeSet;

use photosite::math::hash::hash64;
use photosite::math::philox::Philox;
use rand::RngExt;
use rand::seq::IndexedRandom;
use serde_json::{Map, Value, json};

/// Names that strings may be, by the end of their key.
const NAMES: [(&str, &[&str]); 10] = [
    ("glass", &["BK7"]),
    ("metal", &["Au", "Al"]),
    ("first", &["a"]),
    ("second", &["b"]),
    (
        "preset",
        &["generic-cmos-color", "onsemi-kai-02170-mono", "swissspad2", "automotive-hdr-color", "sony-imx250-mono"],
    ),
    ("prescription", &["cooke-triplet", "double-gauss"]),
    ("cfa", &["mono", "RGGB", "quad-bayer", "x-trans", "full:RGB", "rgbw"]),
    ("format", &["2/3", "aps-c"]),
    ("transmittance", &["no-such-spectrum"]),
    ("name", &["mine"]),
];

/// Kinds that are not drawn, as one image takes seconds: images of points by waves, which have tests of their own.
const SLOW: [&str; 1] = ["wave"];

/// Values at random of what the schema describes.
#[derive(Clone, Copy)]
pub(crate) struct Draw<'a> {
    pub(crate) schema: &'a Value,
    seed: u64,
}

impl<'a> Draw<'a> {
    pub(crate) fn new(schema: &'a Value, seed: u64) -> Self {
        Self { schema, seed }
    }

    /// Random numbers of a path.
    fn random(&self, path: &str) -> Philox {
        Philox::new(self.hash(path), 0)
    }

    fn hash(&self, path: &str) -> u64 {
        path.bytes().fold(self.seed, |hash, byte| hash64(hash, u64::from(byte)))
    }

    /// The one of some names that has the largest number at a path: a new name takes its share, and leaves the other
    /// draws as they were.
    fn chosen<T>(&self, path: &str, of: impl IntoIterator<Item = T>, name: impl Fn(&T) -> String) -> T {
        let number = |one: &T| self.hash(&format!("{path}/{}", name(one)));
        of.into_iter().max_by_key(number).expect("one of some")
    }

    fn resolved(&self, of: &'a Value) -> &'a Value {
        match of.get("$ref").and_then(Value::as_str) {
            Some(name) => self.resolved(self.schema.pointer(name.trim_start_matches('#')).expect("a definition")),
            None => of,
        }
    }

    /// The option of this number: a key of one of the tables, or of one within it, and what it may be.
    pub(crate) fn option(&self, number: u64, tables: &[&str]) -> (String, Value) {
        let draw = Self { seed: hash64(self.seed, number), ..*self };
        let table = draw.chosen("", tables, |table| (*table).to_string());
        let mut path = format!("/{table}");
        let mut of = draw.resolved(&draw.schema["properties"][table]);
        loop {
            let properties = of["properties"].as_object().expect("keys");
            let (key, value) = draw.chosen(&path, properties, |(key, _)| (*key).clone());
            path = format!("{path}/{key}");
            of = draw.resolved(value);
            // Half of the tables are gone into, so that their keys come beside those of the base and its preset.
            if of.get("properties").is_none() || draw.random(&path).random::<bool>() {
                let value = draw.value(&path, key, of);
                return (path, value);
            }
        }
    }

    /// A value of a key at a path, of one of some alternatives.
    pub(crate) fn value_of(
        &self,
        path: &str,
        key: &str,
        all: &'a [Value],
        is_wanted: impl Fn(&Value) -> bool,
    ) -> Value {
        let is_slow = |one: &Value| SLOW.iter().any(|slow| one.to_string().contains(&format!("\"{slow}\"")));
        let quick = all.iter().enumerate().filter(|(_, one)| is_wanted(one) && !is_slow(one));
        // Alternatives are named by what sets them apart, or stand in their order.
        let name = |(i, one): &(usize, &Value)| {
            let own = one.get("const").or(one.get("$ref")).or(one.pointer("/properties/type/const"));
            own.map_or_else(|| i.to_string(), ToString::to_string)
        };
        let chosen = self.chosen(path, quick, name);
        self.value(&format!("{path}|{}", name(&chosen)), key, chosen.1)
    }

    /// A value of a key at a path.
    pub(crate) fn value(&self, path: &str, key: &str, of: &'a Value) -> Value {
        let of = self.resolved(of);
        if let Some(only) = of.get("const") {
            return only.clone();
        }
        for alternatives in ["oneOf", "anyOf"] {
            if let Some(all) = of.get(alternatives).and_then(Value::as_array) {
                return self.value_of(path, key, all, |_| true);
            }
        }
        if let Some(all) = of.get("enum").and_then(Value::as_array) {
            return self.chosen(path, all, |one| one.to_string()).clone();
        }
        let mut random = self.random(path);
        let kind = match of["type"].as_array() {
            Some(kinds) => kinds.choose(&mut random).and_then(Value::as_str).expect("a type"),
            None => of["type"].as_str().unwrap_or("string"),
        };
        match kind {
            "boolean" => json!(random.random::<bool>()),
            "integer" => json!(number(&mut random, of, 8.0).round() as i64),
            "number" => json!(number(&mut random, of, 1e3)),
            "string" => json!(name(&mut random, key)),
            "array" => {
                let least = of["minItems"].as_u64().unwrap_or(1);
                let count = random.random_range(least..=of["maxItems"].as_u64().unwrap_or(least.max(2)));
                let items = of.get("items").unwrap_or(&Value::Null);
                (0..count).map(|i| self.value(&format!("{path}/{i}"), key, items)).collect()
            }
            "object" => {
                let required: BTreeSet<&str> =
                    of["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
                let mut table = Map::new();
                for (key, of) in of["properties"].as_object().into_iter().flatten() {
                    let path = format!("{path}/{key}");
                    if required.contains(key.as_str()) || self.random(&format!("{path}?")).random_range(0..3) == 0 {
                        table.insert(key.clone(), self.value(&path, key, of));
                    }
                }
                Value::Object(table)
            }
            other => panic!("{path}: what is a {other}?"),
        }
    }
}

/// A number in its range: at an end, or between them by its order of magnitude. Whole numbers are small, as they count
/// pixels and samples.
fn number(random: &mut Philox, of: &Value, most: f64) -> f64 {
    let bound = |keys: [&str; 2]| keys.iter().find_map(|key| of.get(*key).and_then(Value::as_f64));
    let low = bound(["minimum", "exclusiveMinimum"]);
    let high = bound(["maximum", "exclusiveMaximum"]).unwrap_or(most).min(most.max(low.unwrap_or(0.0)));
    match random.random_range(0..4) {
        0 => of["minimum"].as_f64().unwrap_or(1.0),
        1 if most > 8.0 => low.unwrap_or(-1.0) + 10f64.powf(random.random_range(-6.0..3.0)),
        _ => {
            let low = low.unwrap_or(0.0);
            low + (high - low) * random.random::<f64>().powi(3)
        }
    }
}

fn name(random: &mut Philox, key: &str) -> &'static str {
    let names = NAMES.iter().find(|(of, _)| *of == key).map_or(&["no-such-name"][..], |(_, names)| *names);
    names.choose(random).copied().expect("a name")
}
