//! Lenses that ship with the program, in `assets/lenses`, whose README gives their sources.

use std::path::Path;

use super::read::read;
use super::report::Reading;

/// Texts of `assets/lenses/NAME.toml` for all names.
macro_rules! embed {
    ($($name:literal,)*) => {
        &[$(($name, include_str!(concat!("../../assets/lenses/", $name, ".toml")))),*]
    };
}

/// All lenses, sorted by name.
const LENSES: &[(&str, &str)] = embed![
    "canon-ef50",
    "canon-ef85",
    "canon-rf24",
    "cooke-triplet",
    "double-gauss",
    "fisheye-170",
    "nikkor-z14",
    "phone-us7535658",
    "retrofocus",
    "telephoto",
    "tessar",
    "zoom-laikin",
];

/// Names of the lenses.
pub fn names() -> impl Iterator<Item = &'static str> {
    LENSES.iter().map(|(name, _)| *name)
}

/// A lens by its name; `None` where there is none.
pub fn shipped(name: &str) -> Option<Reading> {
    let (name, text) = LENSES.iter().find(|(known, _)| *known == name)?;
    let path = format!("{name}.toml");
    // A test reads every one.
    Some(read(text.as_bytes(), Path::new(&path)).unwrap_or_else(|error| panic!("assets/lenses/{error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lens_is_that_of_its_reference_file() {
        for name in names() {
            let file = format!("{}/tests/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
            let bytes = std::fs::read(&file).expect("committed");
            let reference = read(&bytes, Path::new(&file)).expect("a lens");
            let own = shipped(name).expect("listed");
            assert_eq!(own.prescription, reference.prescription, "{name}");
            assert!(own.prescription.licence.is_some_and(|licence| !licence.is_empty()), "{name}");
        }
        assert_eq!(names().count(), 12);
        assert!(shipped("butter").is_none());
    }
}
