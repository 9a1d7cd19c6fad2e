//! A folder of flats and darks: what each image was taken of, by a table, the metadata of raw files, and names.
//!
//! | fact | from, in this order |
//! |---|---|
//! | kind | column `kind` of `frames.csv`; the words bias, dark, offset, flat, bright in names of files and folders |
//! | exposure time | column `exposure_s`; the raw file; a part of the name such as `20ms`, `0.5s`, `100us`; 0 of bias frames |
//! | gain | column `gain`; ISO of the raw file; a part of the name such as `iso800`, `gain12`, `12dB` |
//! | temperature | column `temperature_c`; a part of the name such as `25C`, `-10C` |
//! | photons per pixel | column `photons` |

use std::path::{Path, PathBuf};

use photosite_core::units::{Celsius, Seconds};
use photosite_core::{Error, Invalid, Result, input};
use photosite_measure::characterisation::camera_fit::{FrameGroup, FrameLight};
use photosite_raw::RawImage;

use super::frame_table::{FRAME_TABLE, Kind, TableRow, read_table};
use crate::formats::Format;
use crate::raw_file::{is_mosaic, read_raw};

/// Images of a folder.
pub(super) struct FolderFrames {
    /// At least one, in the order of their names.
    pub(super) frames: Vec<FolderFrame>,
    /// Bits that raw files state.
    pub(super) bits: Option<u32>,
    pub(super) pixel_pitch_m: Option<[f64; 2]>,
}

/// Image of a folder.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FolderFrame {
    pub(super) path: PathBuf,
    is_dark: bool,
    time: Option<Seconds>,
    pub(super) gain: Option<String>,
    temperature: Option<Celsius>,
    photons: Option<f64>,
}

/// Statement about a gain.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameGain {
    /// Statement in words: "12 dB", "ISO 800", "gain 2".
    pub name: String,
    /// The words without the number.
    kind: String,
    /// Number of the statement; not-a-number of one without.
    value: f64,
}

impl FrameGain {
    pub(super) fn new(name: &str) -> Self {
        let (numbers, words): (Vec<&str>, Vec<&str>) =
            name.split_whitespace().partition(|word| word.parse::<f64>().is_ok_and(f64::is_finite));
        // Of two numbers, or of none, nothing follows but that gains are the same.
        let (kind, value) = match numbers[..] {
            [number] => (words.join(" "), number.parse().unwrap_or(0.0)),
            _ => (name.to_owned(), 0.0),
        };
        Self { name: name.to_owned(), kind, value }
    }

    /// Gain over another one in dB, where the statements tell: of decibels, and of ISO speeds.
    pub fn decibels_over(&self, first: &Self) -> Option<f64> {
        match self.kind.to_lowercase().as_str() {
            "db" => Some(self.value - first.value),
            "iso" if first.value > 0.0 => Some(20.0 * (self.value / first.value).log10()),
            _ => None,
        }
    }

    /// Whether the statement is in decibels.
    pub fn is_in_decibels(&self) -> bool {
        self.kind.eq_ignore_ascii_case("dB")
    }
}

/// Finds the images of a folder and of the folders in it.
pub(super) fn frames_of(folder: &Path) -> Result<FolderFrames> {
    let table = read_table(folder)?;
    let mut paths = match &table {
        Some(rows) => rows.iter().map(|row| row.path.clone()).collect(),
        None => image_paths(folder)?,
    };
    paths.sort();
    if paths.is_empty() {
        let help = "give a folder of dark images and flats: DNG, TIFF, PNG, PGM or NPY, or a descriptor (.txt)";
        return Err(Invalid::new("", "has no images").help(help).in_file(folder));
    }
    let mut frames = Vec::new();
    let (mut bits, mut pixel_pitch_m) = (None, None);
    for path in paths {
        let row = table.iter().flatten().find(|row| row.path == path);
        let raw = if is_mosaic(&path) { Some(read_raw(&path)?) } else { None };
        if let Some(raw) = &raw {
            let of_file = raw.linear().bits;
            if bits.is_some_and(|bits| bits != of_file) {
                let message = format!("has numbers of {of_file} bits, and other images have {}", bits.unwrap_or(0));
                return Err(Invalid::new("", message).help("all images must be of one camera").in_file(&path));
            }
            bits = Some(of_file);
            pixel_pitch_m = pixel_pitch_m.or(raw.metadata.pixel_pitch_m);
        }
        frames.push(FolderFrame::new(folder, path, row, raw.as_ref())?);
    }
    Ok(FolderFrames { frames, bits, pixel_pitch_m })
}

impl FolderFrames {
    /// The images of each gain, the lowest first, with the statement about it.
    ///
    /// # Errors
    ///
    /// Images of which some state a gain and others none, or another kind of gain.
    pub(super) fn by_gain(self) -> Result<Vec<(Option<FrameGain>, Self)>> {
        let Self { frames, bits, pixel_pitch_m } = self;
        let mut found: Vec<(Option<FrameGain>, Self)> = Vec::new();
        for frame in frames {
            let gain = frame.gain.as_deref().map(FrameGain::new);
            if let Some((first, other)) = found.first()
                && gain.as_ref().map(|gain| &gain.kind) != first.as_ref().map(|first| &first.kind)
            {
                let words = |gain: Option<&str>| gain.unwrap_or("no stated gain").to_owned();
                let (own, other) = (words(frame.gain.as_deref()), &other.frames[0]);
                let message = format!("has {own}, and {} has {}", other.path.display(), words(other.gain.as_deref()));
                let help = format!("write the gains of all images in the same way, in their names or in {FRAME_TABLE}");
                return Err(Invalid::new("", message).help(help).in_file(&frame.path));
            }
            match found.iter_mut().find(|(known, _)| *known == gain) {
                Some((_, set)) => set.frames.push(frame),
                None => found.push((gain, Self { frames: vec![frame], bits, pixel_pitch_m })),
            }
        }
        let value = |gain: &Option<FrameGain>| gain.as_ref().map_or(0.0, |gain| gain.value);
        found.sort_by(|(a, _), (b, _)| value(a).total_cmp(&value(b)));
        Ok(found)
    }

    /// Images of the same light together, with their paths: those of one kind, time, temperature and folder.
    pub(super) fn groups(&self) -> Vec<(FrameGroup, Vec<PathBuf>)> {
        let mut groups: Vec<(FrameGroup, Vec<PathBuf>)> = Vec::new();
        for frame in &self.frames {
            let light = if frame.is_dark { FrameLight::Dark } else { FrameLight::Bright { photons: frame.photons } };
            let name = frame.path.display().to_string();
            let goes_with = |(group, paths): &&mut (FrameGroup, Vec<PathBuf>)| {
                let is_near = group.is_dark() || paths[0].parent() == frame.path.parent();
                (group.time, group.light, group.temperature) == (frame.time, light, frame.temperature) && is_near
            };
            match groups.iter_mut().find(goes_with) {
                Some((group, paths)) => {
                    group.images.push(name);
                    paths.push(frame.path.clone());
                }
                None => {
                    let images = vec![name.clone()];
                    let group = FrameGroup { name, time: frame.time, light, temperature: frame.temperature, images };
                    groups.push((group, vec![frame.path.clone()]));
                }
            }
        }
        groups
    }
}

impl FolderFrame {
    fn new(folder: &Path, path: PathBuf, row: Option<&TableRow>, raw: Option<&RawImage>) -> Result<Self> {
        let below = path.strip_prefix(folder).unwrap_or(&path).with_extension("");
        let words = words(&below.to_string_lossy());
        let kind = match row.and_then(|row| row.kind).or_else(|| words.iter().rev().find_map(|word| Kind::named(word)))
        {
            Some(kind) => kind,
            None => {
                let help = format!(
                    "put dark, bias or flat into its name or that of its folder, or write {FRAME_TABLE} with the columns \
                     file,kind,exposure_s"
                );
                return Err(Invalid::new("", "does not say whether it is a dark image or a flat")
                    .help(help)
                    .in_file(&path));
            }
        };
        let of_file = raw.map(|raw| raw.metadata.exposure_time_s).filter(|&time| time > 0.0);
        let of_name = words.iter().rev().find_map(|word| time_of(word));
        let of_kind = (kind == Kind::Bias).then_some(0.0);
        let time = row.and_then(|row| row.exposure_s).or(of_file).or(of_name).or(of_kind).map(Seconds);
        let iso = raw.and_then(|raw| raw.metadata.iso).map(|iso| format!("ISO {iso}"));
        let gain =
            row.and_then(|row| row.gain.clone()).or(iso).or_else(|| words.iter().rev().find_map(|word| gain_of(word)));
        let celsius =
            row.and_then(|row| row.temperature_c).or_else(|| words.iter().rev().find_map(|word| celsius_of(word)));
        let photons = row.and_then(|row| row.photons);
        Ok(Self { is_dark: kind != Kind::Flat, time, gain, temperature: celsius.map(Celsius), photons, path })
    }
}

/// Words of a name: letters, digits, points and signs between other characters. A sign belongs to a number that it
/// stands before, after a space or underscore.
fn words(name: &str) -> Vec<String> {
    let is_part = |c: char| c.is_alphanumeric() || c == '.' || c == '-' || c == '+';
    let rough = name.split(|c: char| !is_part(c)).filter(|word| !word.is_empty());
    let split = |word: &str| -> Vec<String> {
        let signed = word.starts_with('-') && word[1..].starts_with(|c: char| c.is_ascii_digit());
        let parts = word.split('-').filter(|part| !part.is_empty()).map(str::to_owned);
        let mut parts: Vec<String> = parts.collect();
        if signed && let Some(first) = parts.first_mut() {
            first.insert(0, '-');
        }
        parts
    };
    rough.flat_map(split).collect()
}

/// Number at the begin of a word, and the letters after it.
fn number_and_unit(word: &str) -> Option<(f64, String)> {
    let end = word.find(|c: char| c.is_alphabetic())?;
    Some((word[..end].parse().ok()?, word[end..].to_lowercase()))
}

/// Exposure time of a word such as `20ms`, s.
fn time_of(word: &str) -> Option<f64> {
    let word = ["exposure", "exp", "t"].iter().find_map(|head| word.strip_prefix(head)).unwrap_or(word);
    let (number, unit) = number_and_unit(word)?;
    let per_second = match unit.as_str() {
        "ns" => 1e9,
        "us" | "µs" | "μs" => 1e6,
        "ms" => 1e3,
        "s" | "sec" => 1.0,
        _ => return None,
    };
    // Divided, so that 100us and 0.1ms are the same time.
    (number >= 0.0).then_some(number / per_second)
}

/// Gain of a word such as `iso800`, `gain12` or `12dB`.
fn gain_of(word: &str) -> Option<String> {
    let lower = word.to_lowercase();
    let number = |text: &str| text.parse::<f64>().ok();
    if let Some((gain, _)) = number_and_unit(&lower).filter(|(_, unit)| unit == "db") {
        return Some(format!("{gain} dB"));
    }
    let named = [("iso", "ISO"), ("gain", "gain")];
    named.iter().find_map(|(head, name)| Some(format!("{name} {}", number(lower.strip_prefix(head)?)?)))
}

/// Temperature of a word such as `25C`.
fn celsius_of(word: &str) -> Option<f64> {
    let (number, unit) = number_and_unit(word)?;
    let fits = matches!(unit.as_str(), "c" | "degc" | "celsius") && (-273.15..200.0).contains(&number);
    fits.then_some(number)
}

/// Images in a folder and the folders in it.
fn image_paths(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![(folder.to_owned(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let entries = input::entries(&folder).map_err(|reason| Error::io(&folder, "read", reason))?;
        for path in entries {
            let path = path.map_err(|reason| Error::io(&folder, "read", reason))?.path();
            if path.is_dir() && depth < 3 {
                folders.push((path, depth + 1));
            } else if path.is_file() && Format::of(&path).is_some_and(Format::reads_images) {
                found.push(path);
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_what_an_image_is_of() {
        for (name, kind, time, gain, celsius) in [
            ("dark_20ms_001", Some(Kind::Dark), Some(0.02), None, None),
            ("bias/IMG-0007", Some(Kind::Bias), None, None, None),
            ("flats/exp0.5s-iso800", Some(Kind::Flat), Some(0.5), Some("ISO 800"), None),
            ("Dark 100us 12dB_-10C", Some(Kind::Dark), Some(1e-4), Some("12 dB"), Some(-10.0)),
            ("darks-25C/gain2-03", Some(Kind::Dark), None, Some("gain 2"), Some(25.0)),
            ("holiday", None, None, None, None),
        ] {
            let words = words(name);
            let last = |f: &dyn Fn(&str) -> Option<f64>| words.iter().rev().find_map(|word| f(word));
            assert_eq!(words.iter().rev().find_map(|word| Kind::named(word)), kind, "{name}");
            assert_eq!(last(&time_of), time, "{name}");
            assert_eq!(words.iter().rev().find_map(|word| gain_of(word)).as_deref(), gain, "{name}");
            assert_eq!(last(&celsius_of), celsius, "{name}");
        }
    }
}
