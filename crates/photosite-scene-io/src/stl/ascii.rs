//! ASCII STL: solids of facets, in words.

use std::path::Path;
use std::str::Lines;

use glam::Vec3;

use super::solid::{FACET, Solid};
use photosite_core::{Error, Invalid, Result, memory, text};

/// Number of lines of a facet, as all programs write it.
const LINES: u64 = 7;

/// Reads a text file.
pub(super) fn read(bytes: Vec<u8>, path: &Path) -> Result<Vec<Solid>> {
    let text = text::decode_any(bytes).map_err(|reason| Error::io(path, "read", reason))?;
    let facets = text.bytes().filter(|&byte| byte == b'\n').count() as u64 / LINES;
    memory::check(facets * FACET, &format!("its geometry of {facets} facets"), "simplify it")
        .map_err(|invalid| invalid.in_file(path))?;
    let mut words = Words { lines: text.lines(), rest: "", line: 0, path };
    let mut solids = Vec::new();
    while let Some(word) = words.next() {
        if !word.eq_ignore_ascii_case("solid") {
            return Err(words.unexpected("\"solid\"", Some(word)));
        }
        solids.push(read_solid(&mut words)?);
    }
    Ok(solids)
}

/// Reads a solid behind its first word.
fn read_solid(words: &mut Words<'_>) -> Result<Solid> {
    let mut solid = Solid::named(words.rest_of_line());
    loop {
        match words.next() {
            Some(word) if word.eq_ignore_ascii_case("facet") => {
                words.expect(&["normal"])?;
                // Some programs write what is no number where a facet has no area.
                let normal = [words.number(), words.number(), words.number()].map(|n| n.unwrap_or(f32::NAN));
                words.expect(&["outer", "loop"])?;
                let mut corners = [Vec3::ZERO; 3];
                for corner in &mut corners {
                    words.expect(&["vertex"])?;
                    *corner = Vec3::new(words.number()?, words.number()?, words.number()?);
                }
                words.expect(&["endloop", "endfacet"])?;
                solid.add(normal.into(), corners).map_err(|invalid| invalid.at_line(words.path, words.line))?;
            }
            Some(word) if word.eq_ignore_ascii_case("endsolid") => {
                words.rest_of_line();
                return Ok(solid.finished());
            }
            word => return Err(words.unexpected("\"facet\" or \"endsolid\"", word)),
        }
    }
}

/// Words of a text, with their lines.
struct Words<'a> {
    lines: Lines<'a>,
    /// Rest of the current line.
    rest: &'a str,
    /// Current line, counted from 1.
    line: usize,
    path: &'a Path,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        loop {
            self.rest = self.rest.trim_start();
            if !self.rest.is_empty() {
                let end = self.rest.find(char::is_whitespace).unwrap_or(self.rest.len());
                let word;
                (word, self.rest) = self.rest.split_at(end);
                return Some(word);
            }
            self.rest = self.lines.next()?;
            self.line += 1;
        }
    }

    fn rest_of_line(&mut self) -> String {
        std::mem::take(&mut self.rest).trim().to_owned()
    }

    fn expect(&mut self, words: &[&str]) -> Result<()> {
        for expected in words {
            match self.next() {
                Some(word) if word.eq_ignore_ascii_case(expected) => {}
                word => return Err(self.unexpected(&format!("{expected:?}"), word)),
            }
        }
        Ok(())
    }

    fn number(&mut self) -> Result<f32> {
        let word = self.next();
        match word.map(str::parse) {
            Some(Ok(number)) => Ok(number),
            Some(Err(_)) | None => Err(self.unexpected("a number", word)),
        }
    }

    /// Error of an unexpected word.
    fn unexpected(&self, expected: &str, found: Option<&str>) -> Error {
        let message = match found {
            Some(word) => format!("{expected} must follow, not {word:?}"),
            None => format!("the file ends where {expected} must follow"),
        };
        let help = "the file is damaged; copy or export it again";
        Invalid::new("", message).help(help).at_line(self.path, self.line)
    }
}
