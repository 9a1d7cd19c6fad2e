//! Kinds of files, for those that were given to a command of another kind, and the commands that take them.

use std::path::Path;

use super::super::tables::SECTIONS;
use super::super::tree::source::CaptureSource;
use super::super::tree::text_file::read_text;
use super::geometry_kind::GeometryKind;
use photosite_core::{Error, Invalid, Result};
use photosite_files::formats::{Format, Holds};

/// A kind of file that some command takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A capture file.
    Capture,
    /// A data set file.
    DataSet,
    /// A sensor file.
    Sensor,
    /// `capture.json`.
    Report,
    /// A scene in a format of its own.
    Model,
    /// Digital numbers of a sensor.
    Raw,
    /// Numbers in columns and rows that may be those of a sensor.
    PixelValues,
    /// Light, stored or developed.
    Light,
    /// An image for the eye.
    Image,
    /// The surfaces of a lens.
    Lens,
}

impl FileKind {
    /// The kind that the name of a file tells; TOML files may be several.
    pub fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_ascii_lowercase();
        if GeometryKind::of(path).is_some() {
            return Some(Self::Model);
        }
        if let Some(format) = Format::of(path) {
            return Some(match format.holds {
                Holds::Raw => Self::Raw,
                Holds::Arrays => Self::PixelValues,
                Holds::Light => Self::Light,
                Holds::Codes => Self::Image,
            });
        }
        match extension.as_str() {
            "json" => Some(Self::Report),
            "zmx" | "seq" | "roa" => Some(Self::Lens),
            _ => None,
        }
    }

    /// The kind that the keys at the top of a TOML file tell.
    pub fn of_keys<'a>(keys: impl Iterator<Item = &'a str>) -> Option<Self> {
        let keys: Vec<&str> = keys.collect();
        if keys.contains(&"capture") {
            return Some(Self::DataSet);
        }
        // A sensor file has no tables of captures but those that mean something else in it.
        if keys.contains(&"adc") {
            return Some(Self::Sensor);
        }
        if keys.contains(&"surfaces") {
            return Some(Self::Lens);
        }
        keys.iter().any(|key| SECTIONS.contains(key)).then_some(Self::Capture)
    }

    /// The kind of a file, by its name or what it holds.
    fn of_file(path: &Path) -> Option<Self> {
        if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
            return Self::of_name(path);
        }
        let source = CaptureSource::parse(path, read_text(path).ok()?).ok()?;
        Self::of_keys(source.sections().map(|(key, _)| key))
    }

    /// Name of such a file, as sentences have it.
    fn name(self) -> &'static str {
        match self {
            Self::Capture => "a capture file",
            Self::DataSet => "a data set file",
            Self::Sensor => "a sensor file",
            Self::Report => "the report of a render",
            Self::Model => "a scene",
            Self::Raw => "a raw file",
            Self::PixelValues => "a raw file, or an image",
            Self::Light => "an image of light",
            Self::Image => "an image",
            Self::Lens => "a lens file",
        }
    }

    /// Command that takes such a file.
    fn command(self, path: &Path) -> String {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        match self {
            Self::Capture | Self::Model | Self::Report => {
                format!("`photosite render` makes its image; a data set file names it by capture = {name:?}")
            }
            Self::DataSet => "`photosite dataset` makes its images".to_owned(),
            Self::Sensor => {
                format!("a capture names it by [sensor] preset = {name:?}; `photosite info` says what it holds")
            }
            Self::Raw => "`photosite develop` makes an image of it".to_owned(),
            Self::PixelValues | Self::Light => "`photosite develop` makes an image of a raw file or of light, and \
                                            `photosite expose` takes light or, with --unit, an image"
                .to_owned(),
            Self::Image => "`photosite expose` takes it with --unit, as light on the sensor".to_owned(),
            Self::Lens => {
                format!("a capture names it by [lens] prescription = {name:?}; `photosite lens` says what it does")
            }
        }
    }

    /// Error of such a file where `wanted` is expected.
    pub fn refusal(self, wanted: &str, path: &Path) -> Invalid {
        Invalid::new("", format!("is {}, and {wanted} is expected here", self.name())).help(self.command(path))
    }

    /// The error of such a file where `wanted` is.
    pub fn instead_of(self, wanted: &str, path: &Path) -> Error {
        self.refusal(wanted, path).in_file(path)
    }

    /// Refuses a file that is certainly none of these kinds.
    pub fn expect(path: &Path, kinds: &[Self], wanted: &str) -> Result<()> {
        Self::check(path, kinds, wanted).map_err(|invalid| invalid.in_file(path))
    }

    /// Refuses a file that is certainly none of these kinds.
    pub fn check(path: &Path, kinds: &[Self], wanted: &str) -> std::result::Result<(), Invalid> {
        match Self::of_file(path).filter(|kind| path.is_file() && !kinds.contains(kind)) {
            Some(other) => Err(other.refusal(wanted, path)),
            None => Ok(()),
        }
    }

    /// Refuses a file that a key of a capture names, as [`check`](Self::check) does.
    pub fn check_named(path: &Path, kinds: &[Self], wanted: &str) -> std::result::Result<(), Invalid> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Self::check(path, kinds, wanted)
            .map_err(|invalid| Invalid { message: format!("{name} {}", invalid.message), ..invalid })
    }
}
