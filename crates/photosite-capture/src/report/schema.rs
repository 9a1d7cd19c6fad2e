//! JSON Schema of `capture.json`.

use schemars::generate::SchemaSettings;
use serde_json::Value;

use super::Report;
use crate::schema_links::remove_rustdoc_links;

/// JSON Schema (draft 2020-12) of reports.
pub fn report_schema() -> Value {
    let schema = SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<Report>();
    let mut schema = schema.to_value();
    remove_rustdoc_links(&mut schema);
    schema["title"] = "photosite's capture.json".into();
    schema
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_in_assets_is_the_one_of_the_program() {
        const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/report.schema.json");
        let text = serde_json::to_string_pretty(&report_schema()).expect("JSON") + "\n";
        if std::env::var_os("UPDATE_SCHEMA").is_some() {
            std::fs::write(PATH, &text).expect("written");
        }
        let kept = std::fs::read_to_string(PATH).expect("assets/report.schema.json");
        assert!(kept == text, "run the test with UPDATE_SCHEMA=1 and commit assets/report.schema.json");
    }
}
