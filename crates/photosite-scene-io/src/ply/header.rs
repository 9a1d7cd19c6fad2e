//! Header of a PLY file: the form of the values, and the elements.

use std::path::Path;

use photosite_core::{Error, Invalid, Result, text};

/// Content of the header.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) form: Form,
    pub(super) elements: Vec<Element>,
    /// Image names in `TextureFile` comments, with their lines.
    pub(super) images: Vec<(usize, String)>,
    /// Start of the values: the byte, and the line, counted from 1.
    pub(super) end: (usize, usize),
}

/// Form of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A list of items with the same properties.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    line: usize,
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Number),
    /// List: its length, which is written first, and its items.
    List {
        length: Number,
        item: Number,
    },
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    /// All types with their two names.
    const NAMES: [(Self, [&str; 2]); 8] = [
        (Self::I8, ["char", "int8"]),
        (Self::U8, ["uchar", "uint8"]),
        (Self::I16, ["short", "int16"]),
        (Self::U16, ["ushort", "uint16"]),
        (Self::I32, ["int", "int32"]),
        (Self::U32, ["uint", "uint32"]),
        (Self::F32, ["float", "float32"]),
        (Self::F64, ["double", "float64"]),
    ];

    fn named(name: &str) -> Result<Self, Invalid> {
        let found = Self::NAMES.into_iter().find(|(_, names)| names.contains(&name));
        found.map(|(number, _)| number).ok_or_else(|| {
            Invalid::new("property", format!("{name:?} is not a type of numbers"))
                .help("write char, uchar, short, ushort, int, uint, float or double")
        })
    }

    /// Usual name of the type.
    pub(super) fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(number, _)| *number == self).map_or("", |(_, names)| names[0])
    }

    /// Size in bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Smallest and largest whole number of the type.
    pub(super) fn range(self) -> (f64, f64) {
        match self {
            Self::I8 => (i8::MIN.into(), i8::MAX.into()),
            Self::U8 => (u8::MIN.into(), u8::MAX.into()),
            Self::I16 => (i16::MIN.into(), i16::MAX.into()),
            Self::U16 => (u16::MIN.into(), u16::MAX.into()),
            Self::I32 => (i32::MIN.into(), i32::MAX.into()),
            Self::U32 => (u32::MIN.into(), u32::MAX.into()),
            Self::F32 | Self::F64 => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }
}

impl Element {
    /// Index of a number property among the properties.
    pub(super) fn number(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name && matches!(p.kind, Kind::Number(_)))
    }

    /// Index of a list property among the properties.
    pub(super) fn list(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name && matches!(p.kind, Kind::List { .. }))
    }

    /// Type of a property, or of the items of a list property.
    pub(super) fn type_of(&self, property: usize) -> Number {
        match self.properties[property].kind {
            Kind::Number(number) | Kind::List { item: number, .. } => number,
        }
    }
}

impl Header {
    /// The element of that name.
    pub(super) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|element| element.name == name)
    }

    /// Reads the header of a file, from its first byte on.
    pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Self> {
        let is_end = |byte: u8| matches!(byte, b'\n' | b'\r');
        if !bytes.starts_with(b"ply") || !bytes.get(3).is_none_or(|&byte| is_end(byte) || byte == b' ') {
            let help = "a PLY file begins with the line \"ply\"; name files of other kinds by their own ending";
            return Err(Invalid::new("", "is not a PLY file").help(help).in_file(path));
        }
        let mut header = Self { form: Form::Ascii, elements: Vec::new(), images: Vec::new(), end: (0, 0) };
        let first_end = bytes.iter().position(|&byte| is_end(byte)).unwrap_or(bytes.len());
        // Where lines end in \r alone, a \n behind the last one is a value.
        let is_lone = bytes[first_end..].starts_with(b"\r") && !bytes[first_end..].starts_with(b"\r\n");
        let mut has_form = false;
        let (mut at, mut line) = (0, 0);
        loop {
            line += 1;
            let rest = &bytes[at..];
            let Some(length) = rest.iter().position(|&byte| is_end(byte)) else {
                let help = "the file is damaged; copy or export it again";
                return Err(Invalid::new("", "the header ends without end_header").help(help).at_line(path, line));
            };
            at += length + if !is_lone && rest[length..].starts_with(b"\r\n") { 2 } else { 1 };
            let text = text::decode_any(rest[..length].to_vec()).map_err(|reason| Error::io(path, "read", reason))?;
            match text.trim() {
                "end_header" => break,
                text => has_form |= header.add(text, line).map_err(|invalid| invalid.at_line(path, line))?,
            }
        }
        if !has_form {
            let help = "for example \"format ascii 1.0\"";
            return Err(Invalid::new("", "the header has no line \"format\"").help(help).in_file(path));
        }
        header.end = (at, line + 1);
        header.check(path)?;
        Ok(header)
    }

    /// Reads a line of the header. Returns whether it gives the form.
    fn add(&mut self, text: &str, line: usize) -> Result<bool, Invalid> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let unknown = |help: &str| Err(Invalid::new("", format!("cannot be read: {text:?}")).help(help));
        match words[..] {
            ["format", form, "1.0"] => {
                self.form = match form {
                    "ascii" => Form::Ascii,
                    "binary_little_endian" => Form::LittleEndian,
                    "binary_big_endian" => Form::BigEndian,
                    _ => return unknown("the format is ascii, binary_little_endian or binary_big_endian"),
                };
                return Ok(true);
            }
            ["format", ..] => return unknown("write, for example, \"format ascii 1.0\""),
            ["comment", "TextureFile", ..] => {
                let name = text.split_once("TextureFile").map_or("", |(_, name)| name.trim());
                self.images.push((line, name.to_owned()));
            }
            [] | ["ply"] | ["comment" | "obj_info", ..] => {}
            ["element", name, count] => {
                let Ok(count) = count.parse() else { return unknown("write \"element NAME COUNT\"") };
                self.elements.push(Element { name: name.to_owned(), count, properties: Vec::new(), line });
            }
            ["property", .., name] => {
                let kind = match words[1..words.len() - 1] {
                    [number] => Kind::Number(Number::named(number)?),
                    ["list", length, item] => {
                        let (length, item) = (Number::named(length)?, Number::named(item)?);
                        if !length.is_whole() {
                            return unknown("the length of a list is a whole number, for example uchar");
                        }
                        Kind::List { length, item }
                    }
                    _ => return unknown("write \"property TYPE NAME\" or \"property list TYPE TYPE NAME\""),
                };
                let Some(element) = self.elements.last_mut() else {
                    return unknown("a property follows the element that has it");
                };
                element.properties.push(Property { name: name.to_owned(), kind });
            }
            _ => return unknown("a line of the header begins with format, comment, element or property"),
        }
        Ok(false)
    }

    /// Refuses duplicate elements and properties, since either may be meant.
    fn check(&self, path: &Path) -> Result<()> {
        for (i, element) in self.elements.iter().enumerate().filter(|(_, e)| matches!(&*e.name, "vertex" | "face")) {
            let twice = |name: &str, line: usize| {
                let invalid = Invalid::new("", format!("{name:?} appears twice"));
                Err(invalid.help("remove one of the two with a program that edits meshes").at_line(path, line))
            };
            if self.elements[..i].iter().any(|earlier| earlier.name == element.name) {
                return twice(&element.name, element.line);
            }
            let mut names: Vec<&str> = element.properties.iter().map(|p| &*p.name).collect();
            names.sort_unstable();
            if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
                return twice(pair[0], element.line);
            }
        }
        Ok(())
    }
}
