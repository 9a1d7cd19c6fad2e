//! Reading values into Rust types by serde, with errors in the user's words: what was found and what to write, where.

use std::fmt;

use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Expected, IntoDeserializer, MapAccess, SeqAccess, Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;

use photosite_calibration::truth::TruthLayer;
use photosite_sensor::NoiseMap;

use super::nodes::{Entry, Node, Value, join};
use photosite_core::suggest::{did_you_mean, list};

/// Reason why a value does not fit its type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadError {
    pub message: String,
    pub help: Option<String>,
    /// Path of the value at fault within the one that was read; made on the error's way out.
    pub path: String,
    /// Unknown key of the table at that path, where that is the fault.
    pub unknown_key: Option<String>,
}

impl ReadError {
    fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None, path: String::new(), unknown_key: None }
    }

    fn within(mut self, step: &str) -> Self {
        self.path = join(step, &self.path);
        self
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for ReadError {}

impl serde::de::Error for ReadError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(message.to_string())
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::new(format!("expected {}, found {}", expectation(expected), finding(found)))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::invalid_type(found, expected)
    }

    fn invalid_length(len: usize, expected: &dyn Expected) -> Self {
        Self::new(format!("expected {}, found {len}", expectation(expected)))
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        let suggestion = did_you_mean(variant, expected.iter().copied());
        let mut error = Self::new(format!("unknown value {variant:?}{suggestion}"));
        error.help = Some(format!("write one of {}", quoted(expected)));
        error
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        let suggestion = match list_that_holds(field).filter(|key| expected.contains(key)) {
            Some(key) => format!("; did you mean `{key} = [{field:?}]`?"),
            None => did_you_mean(field, expected.iter().copied()),
        };
        let mut error = Self::new(format!("unknown key `{field}`{suggestion}"));
        error.unknown_key = Some(field.to_owned());
        error.help = Some(match expected {
            [] => "no keys belong here".to_owned(),
            _ => format!("the keys here are {}", list(field, expected.iter().copied())),
        });
        error
    }

    fn missing_field(field: &'static str) -> Self {
        Self::new(format!("the key `{field}` is missing"))
    }
}

/// The key of a list of outputs that has this word as one of its values.
fn list_that_holds(word: &str) -> Option<&'static str> {
    if TruthLayer::named(word).is_some() {
        return Some("truth");
    }
    NoiseMap::ALL.iter().any(|map| map.name() == word).then_some("noise")
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ")
}

/// Expectation of serde, in words that are not Rust's.
fn expectation(expected: &dyn Expected) -> String {
    let text = expected.to_string();
    match text.as_str() {
        "f64" | "f32" => "a number".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, not negative".to_owned(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list in brackets".to_owned(),
        "a map" => "a table".to_owned(),
        _ if text.starts_with("struct ") => "a table".to_owned(),
        _ => match text.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} values"),
            None => text,
        },
    }
}

fn finding(found: Unexpected<'_>) -> String {
    match found.to_string().as_str() {
        "sequence" => "a list".to_owned(),
        "map" => "a table".to_owned(),
        text => text.to_owned(),
    }
}

/// A node as serde reads it.
#[derive(Clone, Copy)]
pub(crate) struct Reader<'a>(pub &'a Node);

impl<'de> Deserializer<'de> for Reader<'de> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        match &self.0.value {
            Value::String(text) => visitor.visit_borrowed_str(text),
            Value::Integer(value) => match (i64::try_from(*value), u64::try_from(*value)) {
                (Ok(value), _) => visitor.visit_i64(value),
                (_, Ok(value)) => visitor.visit_u64(value),
                (Err(_), Err(_)) => Err(ReadError::new("the number has too many digits")),
            },
            Value::Float(value) => visitor.visit_f64(*value),
            Value::Boolean(value) => visitor.visit_bool(*value),
            // Dates are wanted as text, so that they may be in quotes too.
            Value::Datetime(text) => visitor.visit_borrowed_str(text),
            Value::Array(array) => {
                let expected = expectation(&visitor);
                let mut elements = Elements(array.iter().enumerate());
                let value = visitor.visit_seq(&mut elements)?;
                match elements.0.len() {
                    0 => Ok(value),
                    _ => Err(ReadError::new(format!("expected {expected}, found {}", array.len()))),
                }
            }
            Value::Table(table) => visitor.visit_map(Entries { entries: table.iter(), value: None }),
        }
    }

    /// Reads a struct from a table: keys belong to names, and a list in place of a table is no shorthand.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        if matches!(self.0.value, Value::Array(_)) {
            return Err(ReadError::new("expected a table, found a list"));
        }
        self.deserialize_any(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_newtype_struct(self)
    }

    /// Reads an enum, written as the name of a variant.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        match self.0.as_str() {
            Some(text) => visitor.visit_enum(Variant(text)),
            None => {
                let mut error = ReadError::new("expected a string");
                error.help = Some(format!("write one of {}", quoted(variants)));
                Err(error)
            }
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier ignored_any
    }
}

/// The elements of an array.
struct Elements<'a>(std::iter::Enumerate<std::slice::Iter<'a, Node>>);

impl<'de> SeqAccess<'de> for &mut Elements<'de> {
    type Error = ReadError;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, ReadError> {
        let Some((index, node)) = self.0.next() else { return Ok(None) };
        let read = finite(node).and_then(|()| seed.deserialize(Reader(node)));
        read.map(Some).map_err(|error| error.within(&format!("[{index}]")))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// The entries of a table.
struct Entries<'a> {
    entries: std::collections::btree_map::Iter<'a, String, Entry>,
    value: Option<(&'a str, &'a Node)>,
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = ReadError;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, ReadError> {
        let Some((key, entry)) = self.entries.next() else { return Ok(None) };
        self.value = Some((key, &entry.node));
        let key: serde::de::value::BorrowedStrDeserializer<'_, ReadError> =
            serde::de::value::BorrowedStrDeserializer::new(key);
        seed.deserialize(key).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, ReadError> {
        let (key, node) = self.value.take().expect("serde asks for a key before its value");
        let checked = if MAY_BE_INFINITE.contains(&key) { Ok(()) } else { finite(node) };
        checked.and_then(|()| seed.deserialize(Reader(node))).map_err(|error| error.within(key))
    }
}

/// Keys whose values may be infinite: a white that is never reached.
const MAY_BE_INFINITE: [&str; 1] = ["tone_white"];

/// Refuses infinite numbers and NaN.
fn finite(node: &Node) -> Result<(), ReadError> {
    match node.value {
        Value::Float(x) if !x.is_finite() => Err(ReadError::new(format!("must be finite, got {x}"))),
        Value::Float(_)
        | Value::String(_)
        | Value::Integer(_)
        | Value::Boolean(_)
        | Value::Datetime(_)
        | Value::Array(_)
        | Value::Table(_) => Ok(()),
    }
}

/// A variant without contents.
struct Variant<'a>(&'a str);

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = ReadError;
    type Variant = UnitOnly;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, UnitOnly), ReadError> {
        let name: serde::de::value::StrDeserializer<'_, ReadError> = self.0.into_deserializer();
        Ok((seed.deserialize(name)?, UnitOnly))
    }
}

/// Contents of a variant, which capture files do not have: variants are plain names.
struct UnitOnly;

impl<'de> serde::de::VariantAccess<'de> for UnitOnly {
    type Error = ReadError;

    fn unit_variant(self) -> Result<(), ReadError> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, _: T) -> Result<T::Value, ReadError> {
        Err(ReadError::new("needs more than a name"))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, ReadError> {
        Err(ReadError::new("needs more than a name"))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, ReadError> {
        Err(ReadError::new("needs more than a name"))
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::tree::nodes::parse;

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Sample {
        f_number: f64,
        count: Option<u32>,
        place: Option<[f64; 3]>,
        mode: Option<Mode>,
        flag: Option<bool>,
        seed: Option<u64>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(rename_all = "kebab-case")]
    enum Mode {
        OneWay,
        Another,
    }

    #[test]
    fn values_of_every_type_are_read() {
        let text =
            "f_number = 4\ncount = 3\nplace = [1, 2.5, -3]\nmode = 'one-way'\nflag = true\nseed = 18446744073709551615";
        let read = |text: &str| Sample::deserialize(Reader(&parse(text, 0).expect("TOML"))).expect("fits");
        let expected = Sample {
            f_number: 4.0,
            count: Some(3),
            place: Some([1.0, 2.5, -3.0]),
            mode: Some(Mode::OneWay),
            flag: Some(true),
            seed: Some(u64::MAX),
        };
        assert_eq!(read(text), expected);
        let others = "mode = 'another'\nflag = false\nf_number = 0.5";
        let expected = Sample {
            f_number: 0.5,
            count: None,
            place: None,
            mode: Some(Mode::Another),
            flag: Some(false),
            seed: None,
        };
        assert_eq!(read(others), expected);
    }

    #[test]
    fn errors_say_what_was_found_and_what_to_write() {
        for (text, message, path) in [
            ("f_number = 'four'", "expected a number, found string \"four\"", "f_number"),
            ("f_number = 4\ncount = -1", "expected a whole number, not negative, found integer `-1`", "count"),
            ("f_number = 4\ncount = 1.5", "expected a whole number, not negative, found floating point `1.5`", "count"),
            ("f_number = 4\nplace = [1, 2]", "expected a list of 3 values, found 2", "place"),
            ("f_number = 4\nplace = [1, 2, 3, 4]", "expected a list of 3 values, found 4", "place"),
            ("f_number = 4\nplace = [1, true, 3]", "expected a number, found boolean `true`", "place[1]"),
            ("f_number = 4\nmode = 'oneway'", "unknown value \"oneway\"; did you mean `one-way`?", "mode"),
            ("f_number = 4\nmode = 3", "expected a string", "mode"),
            ("f_number = 4\nflag = 1979-05-27", "expected true or false, found string \"1979-05-27\"", "flag"),
            ("f_number = 4\ncount = { a = 1 }", "expected a whole number, not negative, found a table", "count"),
            ("fnumber = 4", "unknown key `fnumber`; did you mean `f_number`?", ""),
            ("count = 1", "the key `f_number` is missing", ""),
        ] {
            let tree = parse(text, 0).expect("TOML");
            let error = Sample::deserialize(Reader(&tree)).expect_err(text);
            assert_eq!((error.message.as_str(), error.path.as_str()), (message, path));
        }
    }
}
