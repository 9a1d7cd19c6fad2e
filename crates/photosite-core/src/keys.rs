//! Keys with values that a program gives in place of a file's text: what `#[derive(Keys)]` makes builders of.
//!
//! A value is written as TOML, so that what programs, command lines and files say goes one way: it is read, checked,
//! reported and compared by the same code.

use std::collections::BTreeMap;
use std::ops::Deref;

use serde::Serialize;

use crate::key_path;
pub use photosite_derive::Keys;

/// A type of a table of keys.
pub trait Key {
    /// Value that is given for the key.
    type Given: Given;
}

/// A value of a key.
pub trait Given {
    /// The value as TOML, in one line.
    fn toml(&self) -> String;

    /// Gives a key this value; the value of a table leaves the keys of the table that it does not have.
    fn lay_over(&self, key: &str, changes: &mut Changes) {
        changes.set(key, &self.toml());
    }
}

/// Keys with their values, `key=value` each, as overrides have them. Each stands there once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes(Vec<String>);

impl Changes {
    /// Gives a key a value, which is TOML.
    pub fn set(&mut self, key: &str, toml: &str) {
        self.0.retain(|change| key_path::split_change(change).is_none_or(|(other, _)| other != key));
        self.0.push(format!("{key}={toml}"));
    }
}

impl Deref for Changes {
    type Target = [String];

    fn deref(&self) -> &[String] {
        &self.0
    }
}

impl Given for Changes {
    fn toml(&self) -> String {
        format!("{{{}}}", self.0.join(", "))
    }

    fn lay_over(&self, key: &str, changes: &mut Changes) {
        if self.0.is_empty() {
            changes.set(key, "{}");
        }
        for (below, toml) in self.0.iter().filter_map(|change| key_path::split_change(change)) {
            changes.set(&format!("{key}.{below}"), toml);
        }
    }
}

/// The keys of a table with the one that tells its kind.
pub fn tagged(tag: &str, name: &str, keys: &[String]) -> Changes {
    let mut changes = Changes::default();
    changes.set(tag, &name.to_owned().toml());
    changes.0.extend_from_slice(keys);
    changes
}

/// The key of a name in a table of names.
pub fn below(key: &str, name: &str) -> String {
    format!("{key}.{}", key_path::path(&[name.to_owned()]))
}

/// The name that serde has for a value.
pub fn name(value: &impl Serialize) -> String {
    // JSON escapes in strings what TOML does, but for the letter DEL.
    serde_json::to_string(value).unwrap_or_default().replace('\u{7f}', "\\u007f")
}

impl Given for String {
    fn toml(&self) -> String {
        name(self)
    }
}

impl Given for f64 {
    /// Whole numbers as people write them.
    fn toml(&self) -> String {
        if self.fract() == 0.0 && self.abs() < 1e15 { format!("{self:.0}") } else { format!("{self:?}").to_lowercase() }
    }
}

impl<T: Given> Given for Vec<T> {
    fn toml(&self) -> String {
        format!("[{}]", self.iter().map(T::toml).collect::<Vec<_>>().join(", "))
    }
}

impl<T: Given> Given for BTreeMap<String, T> {
    fn toml(&self) -> String {
        let mut changes = Changes::default();
        self.iter().for_each(|(name, value)| value.lay_over(&key_path::path(std::slice::from_ref(name)), &mut changes));
        changes.toml()
    }
}

impl<T: Given, const N: usize> Given for [T; N] {
    fn toml(&self) -> String {
        format!("[{}]", self.iter().map(T::toml).collect::<Vec<_>>().join(", "))
    }
}

/// Types whose numbers and names are written as they are shown.
macro_rules! shown {
    ($($kind:ty)*) => {
        $(impl Given for $kind {
            fn toml(&self) -> String {
                self.to_string()
            }
        })*
    };
}

shown! { bool u8 u16 u32 u64 usize f32 }

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::key_path::toml_value;

    proptest! {
        #[test]
        fn numbers_and_texts_are_read_as_they_were_given(number: f64, text: String) {
            let read = toml_value(&number.toml()).expect("TOML");
            let read = read.as_float().or_else(|| read.as_integer().map(|whole| whole as f64)).expect("a number");
            prop_assert!(read == number || read.is_nan() && number.is_nan());
            prop_assert_eq!(toml_value(&text.toml()), Some(toml::Value::String(text)));
        }
    }

    #[test]
    fn a_table_leaves_the_keys_that_it_does_not_have() {
        let mut inner = Changes::default();
        inner.set("a", "1");
        inner.set("b", "2");
        inner.set("a", "3");
        let mut outer = Changes::default();
        inner.lay_over("t", &mut outer);
        Changes::default().lay_over("u", &mut outer);
        assert_eq!(*outer, ["t.b=2", "t.a=3", "u={}"]);
        assert_eq!(inner.toml(), "{b=2, a=3}");
        assert_eq!(below("materials", "oak.light"), "materials.\"oak.light\"");
    }
}
