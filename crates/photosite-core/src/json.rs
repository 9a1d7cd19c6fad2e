//! Search for the line of a JSON value by its path, for messages.

use std::ops::Range;
use std::path::Path;

use crate::Error;
use crate::error::Invalid;

/// Error of a value in a JSON text whose key is a path such as `nodes[3].scale`, with the value's line if the text has
/// it.
pub fn located(invalid: Invalid, path: &Path, json: &[u8]) -> Error {
    let Some((text, span)) = std::str::from_utf8(json).ok().and_then(|text| Some((text, find(text, &invalid.key)?)))
    else {
        return invalid.in_file(path);
    };
    invalid.in_text(path, text, span)
}

/// Bytes of the value at `path`, or of the innermost value around it that is there. `None` for the empty path.
fn find(text: &str, path: &str) -> Option<Range<usize>> {
    let steps = path.split(['.', '[']).map(|step| step.trim_end_matches(']')).filter(|step| !step.is_empty());
    let mut scanner = Scanner { text: text.as_bytes(), at: 0 };
    scanner.space();
    let mut found = None;
    for step in steps {
        if !scanner.enter(step)? {
            break;
        }
        let start = scanner.at;
        let mut value = Scanner { text: scanner.text, at: start };
        value.skip_value()?;
        found = Some(start..value.at);
    }
    found
}

/// Scanner of JSON that is known to be well-formed; a syntax error ends the search with `None`.
struct Scanner<'a> {
    text: &'a [u8],
    at: usize,
}

impl Scanner<'_> {
    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn space(&mut self) {
        while self.peek().is_some_and(|b| b.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    /// Moves from the start of an object or array to the value at `step`, a name or a number; false if it has none.
    fn enter(&mut self, step: &str) -> Option<bool> {
        let is_object = match self.peek()? {
            b'{' => true,
            b'[' => false,
            _ => return Some(false),
        };
        self.at += 1;
        for index in 0.. {
            self.space();
            if matches!(self.peek()?, b'}' | b']') {
                return Some(false);
            }
            let name = if is_object {
                let start = self.at;
                self.skip_value()?;
                let name = std::str::from_utf8(self.text.get(start + 1..self.at.checked_sub(1)?)?).ok()?.to_owned();
                self.space();
                self.at += 1;
                self.space();
                name
            } else {
                index.to_string()
            };
            if name == step {
                return Some(true);
            }
            self.skip_value()?;
            self.space();
            if self.peek()? == b',' {
                self.at += 1;
            }
        }
        None
    }

    /// Moves behind the value that starts here, without recursion: brackets are counted.
    fn skip_value(&mut self) -> Option<()> {
        let mut depth = 0usize;
        loop {
            match self.peek()? {
                b'"' => self.skip_string()?,
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' => {
                    depth = depth.checked_sub(1)?;
                    self.at += 1;
                }
                b',' | b':' => self.at += 1,
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => {
                    while self.peek().is_some_and(|b| !b.is_ascii_whitespace() && !b",:]}".contains(&b)) {
                        self.at += 1;
                    }
                }
            }
            if depth == 0 {
                return Some(());
            }
        }
    }

    fn skip_string(&mut self) -> Option<()> {
        self.at += 1;
        loop {
            match self.peek()? {
                b'\\' => self.at += 2,
                b'"' => {
                    self.at += 1;
                    return Some(());
                }
                _ => self.at += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{
  "name": "quote \" and { bracket",
  "nodes": [ {"a": 1},
    { "b": [1, 2,
            -3.5e2], "scale": [0, 0, 0] } ]
}"#;

    #[test]
    fn values_are_found_by_their_path() {
        for (path, value) in [
            ("nodes[0].a", "1"),
            ("nodes[1].b[2]", "-3.5e2"),
            ("nodes[1].scale", "[0, 0, 0]"),
            ("nodes[0]", "{\"a\": 1}"),
        ] {
            assert_eq!(&TEXT[find(TEXT, path).expect(path)], value, "{path}");
        }
        // What is missing is shown by what it should be in.
        assert_eq!(&TEXT[find(TEXT, "nodes[0].b.c").expect("outer")], "{\"a\": 1}");
        assert_eq!(find(TEXT, "absent"), None);
        assert_eq!(find(TEXT, ""), None);
    }

    #[test]
    fn malformed_text_does_not_panic_and_shows_nothing_beyond_its_end() {
        let whole = find(TEXT, "nodes[1].b[2]").expect("there");
        for len in 0..TEXT.len() {
            // The value, or what it should be in.
            if let Some(found) = find(&TEXT[..len], "nodes[1].b[2]") {
                assert!(found.start <= whole.start && found.end <= len, "{len}: {found:?}");
            }
        }
    }

    #[test]
    fn an_error_names_the_line() {
        let error = located(Invalid::new("nodes[1].b[2]", "is odd"), Path::new("a.gltf"), TEXT.as_bytes());
        assert_eq!(error.to_string(), "a.gltf:5: nodes[1].b[2]: is odd");
    }
}
