//! Tags of a DNG file, as numbers, bytes and text.

use std::collections::HashSet;

use tiff::decoder::Decoder;
use tiff::decoder::ifd::Value;
use tiff::tags::{IfdPointer, Tag};
use tiff::{Directory, TiffError};

use super::openable::Openable;
use photosite_core::Invalid;

/// A file whose tags can be asked for.
pub(super) struct Tags<'a> {
    pub(super) decoder: Decoder<Openable<'a>>,
}

impl Tags<'_> {
    pub(super) fn value(&mut self, directory: &Directory, tag: Tag) -> Result<Option<Value>, Invalid> {
        self.decoder.read_directory_tags(directory).find_tag(tag).map_err(unreadable)
    }

    /// All numbers of a tag; none where it is missing.
    pub(super) fn numbers(&mut self, directory: &Directory, tag: Tag) -> Result<Vec<f64>, Invalid> {
        let Some(value) = self.value(directory, tag)? else { return Ok(Vec::new()) };
        let values = if let Value::List(values) = value { values } else { vec![value] };
        values.into_iter().map(|value| number(tag, value)).collect()
    }

    /// The first number of a tag.
    pub(super) fn number(&mut self, directory: &Directory, tag: Tag) -> Result<Option<f64>, Invalid> {
        Ok(self.numbers(directory, tag)?.first().copied())
    }

    /// The first number of a tag in the first of these directories that has it.
    pub(super) fn first_number(&mut self, directories: &[&Directory], tag: Tag) -> Result<Option<f64>, Invalid> {
        for directory in directories {
            if let Some(number) = self.number(directory, tag)? {
                return Ok(Some(number));
            }
        }
        Ok(None)
    }

    /// Numbers of a tag, if there are exactly N.
    pub(super) fn array<const N: usize>(
        &mut self,
        directory: &Directory,
        tag: Tag,
    ) -> Result<Option<[f64; N]>, Invalid> {
        Ok(<[f64; N]>::try_from(self.numbers(directory, tag)?).ok())
    }

    /// The tag's numbers as bytes.
    pub(super) fn bytes(&mut self, directory: &Directory, tag: Tag) -> Result<Vec<u8>, Invalid> {
        Ok(self.numbers(directory, tag)?.into_iter().map(|byte| byte as u8).collect())
    }

    /// A text, of characters or bytes, without the zeros that end it; empty where there is none.
    pub(super) fn text_or_bytes(&mut self, directory: &Directory, tag: Tag) -> Result<String, Invalid> {
        if let Ok(text) = self.text(directory, tag) {
            return Ok(text);
        }
        let bytes = self.bytes(directory, tag)?;
        Ok(String::from_utf8_lossy(&bytes).trim_end_matches('\0').to_owned())
    }

    /// Directories from this one on, each of which names the next; those that damage leads back to are left out.
    pub(super) fn following(&mut self, first: IfdPointer) -> Vec<Directory> {
        const MOST: usize = 65_536;
        let (mut found, mut seen, mut next) = (Vec::new(), HashSet::new(), Some(first));
        while let Some(pointer) = next.filter(|pointer| pointer.0 != 0 && seen.len() < MOST && seen.insert(pointer.0)) {
            let Ok(directory) = self.decoder.read_directory(pointer) else { break };
            next = directory.next();
            found.push(directory);
        }
        found
    }

    /// A text; empty where there is none.
    pub(super) fn text(&mut self, directory: &Directory, tag: Tag) -> Result<String, Invalid> {
        match self.value(directory, tag)? {
            Some(text) => text.into_string().map_err(unreadable),
            None => Ok(String::new()),
        }
    }
}

pub(super) fn unreadable(error: TiffError) -> Invalid {
    Invalid::new("", format!("cannot read it as TIFF: {error}"))
}

fn number(tag: Tag, value: Value) -> Result<f64, Invalid> {
    let signed = value.clone().into_i64().map(|v| v as f64);
    let float = || value.clone().into_f64().or_else(|_| value.clone().into_f32().map(f64::from));
    let unsigned = || value.clone().into_u64().map(|v| v as f64);
    let fraction = || {
        if let Value::Rational(n, d) = value {
            return Some(f64::from(n) / f64::from(d));
        }
        if let Value::SRational(n, d) = value { Some(f64::from(n) / f64::from(d)) } else { None }
    };
    unsigned()
        .or(signed)
        .or_else(|_| float())
        .ok()
        .or_else(fraction)
        .ok_or_else(|| Invalid::new(format!("tag {}", tag.to_u16()), "not a number").help("the file is damaged"))
}
