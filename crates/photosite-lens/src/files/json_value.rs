//! JSON values of optical programs, with the path of each kept for messages.

use serde_json::Value;

use super::draft::{Fault, Read};

/// A value and its path, `surface_group.surfaces[3].geometry`.
#[derive(Clone, Debug)]
pub(super) struct At<'a> {
    pub(super) value: &'a Value,
    pub(super) path: String,
}

/// Parses a text as JSON. Python writes infinities and NaN as bare words, which JSON does not have: they become
/// strings.
pub(super) fn parsed(text: &str) -> Read<Value> {
    serde_json::from_str(&with_words_quoted(text)).map_err(|error| {
        Fault::at(error.line(), format!("not valid JSON: {error}"))
            .help("save the lens again from the program that wrote it")
    })
}

/// Text with `Infinity`, `-Infinity` and `NaN` put in quotes, except within strings.
pub(super) fn with_words_quoted(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len());
    let (mut is_in_text, mut rest) = (false, text);
    while let Some(c) = rest.chars().next() {
        let word = ["-Infinity", "Infinity", "NaN"].into_iter().find(|word| !is_in_text && rest.starts_with(word));
        let taken = match (word, c) {
            (Some(word), _) => {
                quoted.push('"');
                quoted.push_str(word);
                quoted.push('"');
                word.len()
            }
            (None, '\\') if is_in_text => {
                let pair = rest.char_indices().nth(2).map_or(rest.len(), |(at, _)| at);
                quoted.push_str(&rest[..pair]);
                pair
            }
            (None, _) => {
                is_in_text ^= c == '"';
                quoted.push(c);
                c.len_utf8()
            }
        };
        rest = &rest[taken..];
    }
    quoted
}

impl<'a> At<'a> {
    pub(super) fn root(value: &'a Value) -> Self {
        Self { value, path: String::new() }
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// Fault at this value.
    pub(super) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault { line: None, invalid: photosite_core::Invalid::new(self.path.clone(), message) }
    }

    /// Value of a key; `None` where it is missing or null.
    pub(super) fn get(&self, key: &str) -> Option<At<'a>> {
        let value = self.value.get(key).filter(|value| !value.is_null())?;
        Some(At { value, path: self.path_of(key) })
    }

    /// Value of a required key.
    pub(super) fn needed(&self, key: &str) -> Read<At<'a>> {
        self.get(key).ok_or_else(|| self.fault(format!("there is no `{key}`")))
    }

    /// Values of a list.
    pub(super) fn items(&self) -> Read<Vec<At<'a>>> {
        let items = self.value.as_array().ok_or_else(|| self.fault("no list"))?;
        Ok(items.iter().enumerate().map(|(i, value)| At { value, path: format!("{}[{i}]", self.path) }).collect())
    }

    /// A number, or infinity.
    pub(super) fn number(&self) -> Read<f64> {
        match self.value {
            Value::Number(number) => number.as_f64().ok_or_else(|| self.fault(format!("{number} is not a number"))),
            Value::String(text) if text == "Infinity" => Ok(f64::INFINITY),
            Value::String(text) if text == "-Infinity" => Ok(f64::NEG_INFINITY),
            other @ (Value::Null | Value::Bool(_) | Value::String(_) | Value::Array(_) | Value::Object(_)) => {
                Err(self.fault(format!("{other} is not a number")))
            }
        }
    }

    /// A finite number.
    pub(super) fn finite(&self) -> Read<f64> {
        let number = self.number()?;
        if number.is_finite() { Ok(number) } else { Err(self.fault(format!("{number} is not finite"))) }
    }

    /// Finite number of a key; `None` where it is missing.
    pub(super) fn finite_of(&self, key: &str) -> Read<Option<f64>> {
        self.get(key).map(|at| at.finite()).transpose()
    }

    /// Text of a key; empty where it is missing.
    pub(super) fn text_of(&self, key: &str) -> &'a str {
        self.value.get(key).and_then(Value::as_str).unwrap_or_default()
    }

    /// Whether a key is true.
    pub(super) fn is_true(&self, key: &str) -> bool {
        self.value.get(key).and_then(Value::as_bool).unwrap_or(false)
    }
}

/// Aspheric terms of a list of coefficients, of which the first has the order `first` and the others follow in steps of
/// `step`.
pub(super) fn asphere(coefficients: &At, [first, step]: [u32; 2]) -> Read<Vec<(u32, f64)>> {
    let mut terms = Vec::new();
    for (i, coefficient) in coefficients.items()?.iter().enumerate() {
        let value = coefficient.finite()?;
        let order = first + step * u32::try_from(i).unwrap_or(u32::MAX / 4);
        if value != 0.0 && order < 2 {
            return Err(coefficient.fault("a term r¹, which makes a cone with a tip"));
        }
        if value != 0.0 {
            terms.push((order, value));
        }
    }
    Ok(terms)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinite_numbers_of_python_are_read_and_texts_are_left_alone() {
        let text = r#"{"a": Infinity, "b": [-Infinity, NaN], "NaN \" Infinity": "Infinity \\"}"#;
        let value = parsed(text).expect("JSON");
        let root = At::root(&value);
        assert_eq!(root.needed("a").and_then(|a| a.number()).expect("a number"), f64::INFINITY);
        assert!(root.needed("a").and_then(|a| a.finite()).is_err());
        let b = root.needed("b").and_then(|b| b.items()).expect("a list");
        assert_eq!(b[0].number().expect("a number"), f64::NEG_INFINITY);
        assert_eq!(b[1].number().expect_err("none").invalid.key, "b[1]");
        assert_eq!(root.text_of("NaN \" Infinity"), "Infinity \\");
        assert_eq!(parsed("{\n\"a\": }").expect_err("broken").line, Some(2));
    }
}
