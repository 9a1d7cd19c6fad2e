//! Values as TOML writes them in a line.

use serde_json::Value;

/// Number as TOML, with all digits that tell it from others.
pub(super) fn number(x: f64) -> String {
    format!("{x:?}")
}

/// List of numbers in brackets, without a negative 0.
pub(super) fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    format!("[{}]", numbers.into_iter().map(|x| number(x + 0.0)).collect::<Vec<_>>().join(", "))
}

/// Value as TOML in a single line.
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

/// Text in quotes: JSON's strings are TOML's basic ones.
fn text_in_quotes(text: &str) -> String {
    Value::from(text).to_string()
}
