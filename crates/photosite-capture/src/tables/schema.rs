//! The JSON Schemas of capture, data set and sensor files, by which editors complete and check them.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::super::tables::CaptureFile;
use crate::schema_links::remove_rustdoc_links;
use photosite_calibration::dataset::DatasetDescription;
use photosite_measure::synthetic_noise::SyntheticNoise;
use photosite_sensor::SensorDescription;

/// The JSON Schema (draft 2020-12) of capture files. The committed copies of this and of the others are
/// `assets/*.schema.json`.
pub fn capture_schema() -> Value {
    let mut schema = schema_of::<CaptureFile>();
    make_partial(&mut schema);
    schema
}

/// The JSON Schema of data set files.
pub fn dataset_schema() -> Value {
    schema_of::<DatasetDescription>()
}

/// The JSON Schema of sensor files.
pub fn sensor_schema() -> Value {
    let mut schema = schema_of::<SensorDescription>();
    schema["title"] = "photosite sensor".into();
    schema
}

/// The JSON Schema of the keys of `photosite noise add`.
pub fn noise_schema() -> Value {
    let mut schema = schema_of::<SyntheticNoise>();
    schema["title"] = "photosite noise add".into();
    schema
}

fn schema_of<T: JsonSchema>() -> Value {
    let mut schema = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<T>().to_value();
    remove_null(&mut schema);
    remove_rustdoc_links(&mut schema);
    schema
}

/// Takes `null` out of the alternatives of optional keys: TOML leaves them out.
fn remove_null(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            object.values_mut().for_each(remove_null);
            if let Some(Value::Array(types)) = object.get_mut("type") {
                types.retain(|kind| kind != "null");
                if let [only] = &types[..] {
                    let only = only.clone();
                    object.insert("type".to_owned(), only);
                }
            }
            let Some(Value::Array(alternatives)) = object.get_mut("anyOf") else { return };
            alternatives.retain(|alternative| *alternative != json!({ "type": "null" }));
            if let [Value::Object(only)] = &alternatives[..] {
                let only = only.clone();
                object.remove("anyOf");
                object.extend(only);
            }
        }
        Value::Array(array) => array.iter_mut().for_each(remove_null),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

/// Makes every key of `[sensor]` optional, in tables within it too: a preset gives what is left out.
fn make_partial(schema: &mut Value) {
    let Some(definitions) = schema.get_mut("$defs").and_then(Value::as_object_mut) else { return };
    let mut names = vec!["SensorTable".to_owned()];
    let mut seen: Vec<String> = Vec::new();
    while let Some(name) = names.pop() {
        let Some(definition) = definitions.get_mut(&name) else { continue };
        remove_required(definition);
        references(definition, &mut names);
        seen.push(name);
        names.retain(|name| !seen.contains(name));
    }
}

/// `required` lists within a definition, but not those of the alternatives of a value: a curve has to name its file.
fn remove_required(definition: &mut Value) {
    if let Some(definition) = definition.as_object_mut().filter(|definition| definition.contains_key("properties")) {
        definition.remove("required");
    }
}

/// Adds the names of definitions that the keys of a table refer to, but for kinds of values.
fn references(definition: &Value, names: &mut Vec<String>) {
    match definition {
        Value::Object(object) => {
            if let Some(name) = object.get("$ref").and_then(Value::as_str).and_then(|r| r.strip_prefix("#/$defs/"))
                && name != "SpectrumSource"
            {
                names.push(name.to_owned());
            }
            object.values().for_each(|value| references(value, names));
        }
        Value::Array(array) => array.iter().for_each(|value| references(value, names)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Map;

    use super::*;

    const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets");

    fn schemas() -> [(&'static str, Value); 4] {
        [
            ("capture", capture_schema()),
            ("dataset", dataset_schema()),
            ("sensor", sensor_schema()),
            ("noise", noise_schema()),
        ]
    }

    #[test]
    fn the_committed_schemas_are_current() {
        for (name, schema) in schemas() {
            let path = format!("{ASSETS}/{name}.schema.json");
            let current = serde_json::to_string_pretty(&schema).expect("JSON") + "\n";
            if std::env::var_os("UPDATE_SCHEMA").is_some() {
                std::fs::write(&path, &current).expect("written");
            }
            let committed = std::fs::read_to_string(&path).unwrap_or_default();
            assert!(committed == current, "run the test with UPDATE_SCHEMA=1 and commit {path}");
        }
    }

    #[test]
    fn every_key_is_described_and_no_other_allowed() {
        fn check(path: &str, schema: &Map<String, Value>) {
            if let Some(properties) = schema.get("properties").and_then(Value::as_object) {
                assert_eq!(schema.get("additionalProperties"), Some(&json!(false)), "{path}");
                for (key, property) in properties {
                    let described = ["description", "const", "$ref"].iter().any(|k| property.get(k).is_some());
                    assert!(described, "{path}.{key}: {property}");
                }
            }
            for (key, value) in schema {
                let children = value.as_object().into_iter().map(|v| (key.clone(), v));
                let listed =
                    value.as_array().into_iter().flatten().filter_map(Value::as_object).map(|v| (key.clone(), v));
                children.chain(listed).for_each(|(key, value)| check(&format!("{path}/{key}"), value));
            }
        }
        for (name, schema) in schemas() {
            check(name, schema.as_object().expect("an object"));
            assert!(schema["title"].is_string() && schema["description"].is_string(), "{name}");
            assert!(!schema.to_string().contains("\"null\""), "{name}: TOML has no null");
        }
        let schema = capture_schema();
        let sensor = &schema["$defs"]["SensorTable"];
        assert!(sensor.get("required").is_none() && sensor["properties"].get("adc").is_some(), "{sensor}");
        assert!(schema["$defs"]["AdcDescription"].get("required").is_none());
    }
}
