//! `[[targets]]`.

use std::borrow::Cow;

use photosite_core::keys::{Key, Keys};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;

use photosite_calibration::targets::TargetDescription;

/// A calibration target that stands in the scene.
#[derive(Debug)]
pub(crate) struct TargetTable {
    pub(crate) placement: PlacementTable,
    pub(crate) description: TargetDescription,
}

/// Where a target stands: the keys that all kinds have.
#[derive(Debug, Default, Deserialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
#[keys(beside = "TargetDescription")]
pub(crate) struct PlacementTable {
    /// Name of the target; its materials are called NAME-white, NAME-black and so on. Left out: the type.
    pub(crate) name: Option<String>,
    /// Where the middle of the sheet is, m. Left out: [0, 0, 0].
    pub(crate) position_m: Option<[f64; 3]>,
    /// A point that the front faces, m. Left out: one in the direction +z of the position.
    pub(crate) look_at_m: Option<[f64; 3]>,
    /// What is up on the front. Left out: [0, 1, 0].
    pub(crate) up: Option<[f64; 3]>,
}

impl PlacementTable {
    /// Its keys.
    pub(crate) const KEYS: [&str; 4] = ["name", "position_m", "look_at_m", "up"];
}

impl Key for TargetTable {
    type Given = <TargetDescription as Key>::Given;
}

impl JsonSchema for TargetTable {
    fn schema_name() -> Cow<'static, str> {
        "TargetTable".into()
    }

    /// That of the kinds, each with the keys of the placement before its own.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let placement = PlacementTable::json_schema(generator).to_value();
        let mut kinds = TargetDescription::json_schema(generator);
        let shared = placement["properties"].as_object().into_iter().flatten();
        for kind in kinds.get_mut("oneOf").and_then(|kinds| kinds.as_array_mut()).into_iter().flatten() {
            for (key, property) in shared.clone() {
                kind["properties"][key] = property.clone();
            }
        }
        kinds.insert("description".to_owned(), "A calibration target that stands in the scene.".into());
        kinds
    }
}
