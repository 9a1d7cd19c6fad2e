//! JSON for people and programs: a line for each key of an object, arrays in one line.

use std::io;

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::Formatter;

/// Value as JSON text, without a line break at its end.
pub fn pretty_json(value: &impl Serialize) -> String {
    let mut text = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut text, KeysOnLines { depth: 0, is_empty: false });
    value.serialize(&mut serializer).expect("our own structures have string keys and finite numbers");
    String::from_utf8(text).expect("JSON is UTF-8")
}

struct KeysOnLines {
    depth: usize,
    is_empty: bool,
}

impl KeysOnLines {
    fn new_line<W: io::Write + ?Sized>(&self, to: &mut W) -> io::Result<()> {
        write!(to, "\n{:width$}", "", width = 2 * self.depth)
    }
}

impl Formatter for KeysOnLines {
    fn begin_array_value<W: io::Write + ?Sized>(&mut self, to: &mut W, first: bool) -> io::Result<()> {
        if first { Ok(()) } else { to.write_all(b", ") }
    }

    fn begin_object<W: io::Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.depth += 1;
        self.is_empty = true;
        to.write_all(b"{")
    }

    fn end_object<W: io::Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if !self.is_empty {
            self.new_line(to)?;
        }
        self.is_empty = false;
        to.write_all(b"}")
    }

    fn begin_object_key<W: io::Write + ?Sized>(&mut self, to: &mut W, first: bool) -> io::Result<()> {
        self.is_empty = false;
        if !first {
            to.write_all(b",")?;
        }
        self.new_line(to)
    }

    fn begin_object_value<W: io::Write + ?Sized>(&mut self, to: &mut W) -> io::Result<()> {
        to.write_all(b": ")
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    #[test]
    fn arrays_stay_in_a_line_and_all_comes_back() {
        let value =
            json!({ "a": [1, 2.5, [3]], "none": {}, "lights": [{ "cd": 1 }, {}], "deep": { "b": "x", "c": null } });
        let text = pretty_json(&value);
        assert_eq!(
            text,
            "{\n  \"a\": [1, 2.5, [3]],\n  \"none\": {},\n  \"lights\": [{\n    \"cd\": 1\n  }, {}],\n  \"deep\": {\n    \
             \"b\": \"x\",\n    \"c\": null\n  }\n}"
        );
        assert_eq!(serde_json::from_str::<Value>(&text).expect("JSON"), value);
    }
}
