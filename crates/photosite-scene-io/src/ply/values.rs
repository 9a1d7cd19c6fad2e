//! Values of a PLY file in sequence, from text or from bytes.

use std::path::Path;

use super::header::{Element, Form, Header, Kind, Number};
use photosite_core::{Error, Invalid, Result};

/// Values that are not yet read.
pub(super) struct Values<'a> {
    bytes: &'a [u8],
    form: Form,
    /// Start of the next value, or of the blanks before it.
    at: usize,
    /// Line of the next value, in a text.
    line: usize,
    path: &'a Path,
}

/// Receiver of the items of lists: index of the property, item.
type Items<'a> = &'a mut dyn FnMut(usize, f64);

impl<'a> Values<'a> {
    /// Values of a file, whose header was read.
    pub(super) fn new(bytes: &'a [u8], header: &Header, path: &'a Path) -> Self {
        let (at, line) = header.end;
        Self { bytes, form: header.form, at, line, path }
    }

    /// Largest number of values that can follow, each of at least `bytes` bytes.
    pub(super) fn most(&self, bytes: usize) -> u64 {
        // In text a value takes a digit, and all but the last a blank.
        let bytes = if self.form == Form::Ascii { 2 } else { bytes };
        (self.bytes.len() - self.at) as u64 / bytes as u64 + 1
    }

    /// Refuses an element that needs more bytes than there are, before anything is allocated for it.
    pub(super) fn check(&self, element: &Element) -> Result<()> {
        let left = (self.bytes.len() - self.at) as u64;
        let sizes = element.properties.iter().map(|property| match (self.form, property.kind) {
            (Form::Ascii, _) => 2,
            (_, Kind::Number(number) | Kind::List { length: number, .. }) => number.size() as u64,
        });
        // The last value of a text has no blank behind it.
        let needed = sizes.sum::<u64>().checked_mul(element.count);
        let needed = needed.map(|needed| needed.saturating_sub(u64::from(self.form == Form::Ascii)));
        if needed.is_some_and(|needed| needed <= left) {
            return Ok(());
        }
        let Element { name, count, .. } = element;
        let message = format!("is truncated: {count} of {name:?} are announced, but only {left} bytes follow");
        Err(Invalid::new("", message).help("the file is damaged; copy or export it again").in_file(self.path))
    }

    /// Reads the next row of an element: a number for each property, 0 for lists, whose items are passed to `items`.
    pub(super) fn row(&mut self, element: &Element, index: u64, row: &mut Vec<f64>, items: Items<'_>) -> Result<()> {
        self.skip_blanks();
        let line = self.line;
        row.clear();
        let mut read = || {
            for (i, property) in element.properties.iter().enumerate() {
                row.push(match property.kind {
                    Kind::Number(number) => self.number(number)?,
                    Kind::List { length, item } => {
                        let length = self.number(length)?;
                        let most = self.most(item.size());
                        if !(length >= 0.0 && length <= most as f64) {
                            let message =
                                format!("a list of {length} values is impossible where at most {most} follow");
                            return Err(Invalid::new("", message));
                        }
                        for _ in 0..length as u64 {
                            items(i, self.number(item)?);
                        }
                        0.0
                    }
                });
            }
            self.end_line(&element.properties)
        };
        read().map_err(|invalid| self.error(invalid, element, index, line))
    }

    /// Error of one row of an element.
    pub(super) fn fault(&self, element: &Element, index: u64, message: impl Into<String>) -> Error {
        self.error(Invalid::new("", message), element, index, self.line)
    }

    fn error(&self, invalid: Invalid, element: &Element, index: u64, line: usize) -> Error {
        let key = format!("{} {index}", element.name);
        let help = invalid.help.unwrap_or_else(|| "the file is damaged; copy or export it again".into());
        match self.form {
            Form::Ascii => Invalid::new(key, invalid.message).help(help).at_line(self.path, line),
            Form::LittleEndian | Form::BigEndian => {
                let message = format!("{}, at byte {}", invalid.message, self.at);
                Invalid::new(key, message).help(help).in_file(self.path)
            }
        }
    }

    /// Skips an element.
    pub(super) fn skip(&mut self, element: &Element) -> Result<()> {
        // Those without properties take no bytes, whatever their number.
        if element.properties.is_empty() {
            return Ok(());
        }
        let mut row = Vec::new();
        (0..element.count).try_for_each(|i| self.row(element, i, &mut row, &mut |_, _| {}))
    }

    /// Number of bytes behind the last element that are no blanks.
    pub(super) fn left_over(&self) -> usize {
        self.bytes[self.at..].iter().filter(|byte| !byte.is_ascii_whitespace() && **byte != 0).count()
    }

    fn number(&mut self, number: Number) -> Result<f64, Invalid> {
        match self.form {
            Form::Ascii => self.word(number),
            Form::LittleEndian | Form::BigEndian => self.binary(number),
        }
    }

    fn word(&mut self, number: Number) -> Result<f64, Invalid> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let word = &rest[..rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len())];
        if word.is_empty() {
            return Err(Invalid::new("", "the file ends within it"));
        }
        self.at += word.len();
        let text = String::from_utf8_lossy(word);
        // Singles are rounded once, not by way of doubles.
        let value =
            if number == Number::F32 { text.parse::<f32>().ok().map(f64::from) } else { text.parse::<f64>().ok() };
        let (low, high) = number.range();
        match value {
            Some(value) if !number.is_whole() || (value.fract() == 0.0 && (low..=high).contains(&value)) => Ok(value),
            Some(_) => Err(Invalid::new("", format!("{text:?} is no {}", number.name()))),
            None => Err(Invalid::new("", format!("{text:?} is not a number"))),
        }
    }

    fn binary(&mut self, number: Number) -> Result<f64, Invalid> {
        let Some(bytes) = self.bytes.get(self.at..self.at + number.size()) else {
            return Err(Invalid::new("", "the file ends within it"));
        };
        let mut ordered = [0; 8];
        for (i, &byte) in bytes.iter().enumerate() {
            ordered[if self.form == Form::BigEndian { bytes.len() - 1 - i } else { i }] = byte;
        }
        self.at += bytes.len();
        let [a, b, c, d, ..] = ordered;
        Ok(match number {
            Number::I8 => (a as i8).into(),
            Number::U8 => a.into(),
            Number::I16 => i16::from_le_bytes([a, b]).into(),
            Number::U16 => u16::from_le_bytes([a, b]).into(),
            Number::I32 => i32::from_le_bytes([a, b, c, d]).into(),
            Number::U32 => u32::from_le_bytes([a, b, c, d]).into(),
            Number::F32 => f32::from_le_bytes([a, b, c, d]).into(),
            Number::F64 => f64::from_le_bytes(ordered),
        })
    }

    /// Moves to the next word of a text.
    fn skip_blanks(&mut self) {
        if self.form != Form::Ascii {
            return;
        }
        while let Some(&byte) = self.bytes.get(self.at).filter(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
            let is_end = byte == b'\n' || byte == b'\r' && self.bytes.get(self.at) != Some(&b'\n');
            self.line += usize::from(is_end);
        }
    }

    /// Refuses values that follow in the same line: where some are missing or too many, all later values would be
    /// shifted.
    fn end_line(&mut self, properties: &[super::header::Property]) -> Result<(), Invalid> {
        if self.form != Form::Ascii {
            return Ok(());
        }
        let rest = &self.bytes[self.at..];
        match rest.iter().find(|byte| !matches!(byte, b' ' | b'\t')) {
            None | Some(b'\n' | b'\r') => Ok(()),
            Some(_) => {
                let names: Vec<&str> = properties.iter().map(|p| &*p.name).collect();
                let message = format!("has other values than the header announces: {}", names.join(", "));
                Err(Invalid::new("", message))
            }
        }
    }
}
