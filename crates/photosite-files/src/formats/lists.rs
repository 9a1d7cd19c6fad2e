//! Lists of formats in messages and help, and the choice among them by the name of a file.

use std::path::Path;

use super::{FORMATS, Format};
use photosite_core::{Error, Result};

/// Usual endings of formats, as a sentence lists them: ".png, .tiff or .exr".
pub fn endings(fits: impl Fn(&Format) -> bool) -> String {
    listed(&fits, |format| format!(".{}", format.ending()))
}

/// Names of formats, as a sentence lists them: "DNG, TIFF or NPY".
pub fn names(fits: impl Fn(&Format) -> bool) -> String {
    listed(&fits, |format| format.name.to_owned())
}

/// Usual endings of raw files, those of files that state most first.
pub fn raw_endings() -> Vec<&'static str> {
    let (speak, silent): (Vec<_>, Vec<_>) =
        FORMATS.into_iter().filter(|format| format.writes_raw()).partition(|format| format.states_meaning);
    speak.into_iter().chain(silent).map(Format::ending).collect()
}

fn listed(fits: &dyn Fn(&Format) -> bool, word: fn(&Format) -> String) -> String {
    let words: Vec<String> = FORMATS.into_iter().filter(|format| fits(format)).map(word).collect();
    match &words[..] {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        few => few.concat(),
    }
}

/// Format in which an image of that name is written, one of those that fit; else the error that the name `is_not` one.
pub fn written(path: &Path, fits: impl Fn(&Format) -> bool, is_not: &str) -> Result<&'static Format> {
    let fits = |format: &Format| format.image_writer.is_some() && fits(format);
    Format::of(path).filter(|format| fits(format)).ok_or_else(|| Error::Usage {
        message: format!("{} is not the name of {is_not}", path.display()),
        help: Some(format!("give a name that ends with {}", endings(fits)).into()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_the_format() {
        for (name, format) in [("a.png", "PNG"), ("b.TIF", "TIFF"), ("c.jpeg", "JPEG"), ("d.pnm", "PPM")] {
            assert_eq!(Format::of(name.as_ref()).expect("known").name, format);
        }
        let of_floats = |name: &str| written(name.as_ref(), |format| format.floats, "a map");
        assert!(of_floats("a.npy").is_ok() && of_floats("a.hdr").is_err() && of_floats("a").is_err());
        let Err(Error::Usage { message, help }) = of_floats("a.png") else { panic!("refused") };
        assert_eq!(message, "a.png is not the name of a map");
        assert_eq!(help, Some("give a name that ends with .tiff, .npy or .exr".into()));
        assert_eq!(names(|format| format.states_meaning), "DNG or EXR");
        assert_eq!(raw_endings()[..2], ["dng", "exr"]);
    }

    /// Test of texts that a table cannot make: docstrings, documentation, a file that users edit.
    #[test]
    fn texts_that_list_formats_name_each() {
        let written = |format: &Format| format.image_writer.is_some();
        let crates = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
        type Fits = fn(&Format) -> bool;
        let texts: [(&str, &str, &str, Fits); 5] = [
            ("photosite-files/src/developed.rs", "| extension", "Values of a colour", written),
            ("photosite-capture/src/files/init.rs", "raw = [", "image = ", Format::writes_raw),
            ("../python/photosite/_raw.py", "def save", "Raises:", Format::writes_raw),
            ("../docs/reference/files.md", "`raw.dng`", "of several", Format::writes_raw),
            ("../docs/guides/capture-file.md", "\nraw = [", "image", Format::writes_raw),
        ];
        for (file, begin, end, fits) in texts {
            let text = std::fs::read_to_string(crates.join(file)).expect(file);
            let (_, text) = text.split_once(begin).expect(file);
            let text = text.split_once(end).map_or(text, |(list, _)| list);
            for format in FORMATS.into_iter().filter(|format| fits(format)) {
                assert!(text.contains(format.ending()), "{file} leaves out {format:?}: {text}");
            }
        }
    }
}
