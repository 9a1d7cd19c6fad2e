//! Common parts of lens files: size, encoding, numbers and units.

use photosite_core::{Invalid, text};

use super::draft::{Fault, Read};

/// Largest size of a lens file, bytes: the largest known ones have 0.2 MB.
pub(super) const MOST_BYTES: usize = 1_000_000;

/// Text of a file, decoded as Latin-1 where it is no UTF, as written by older versions of OpticStudio.
pub(super) fn decoded(bytes: &[u8]) -> Result<String, Invalid> {
    if bytes.len() > MOST_BYTES {
        let message = format!("{} bytes, where lens files have at most 1 MB", bytes.len());
        return Err(
            Invalid::new("", message).help("give the prescription alone, without the merit function and images")
        );
    }
    text::decode_any(bytes.to_vec()).map_err(|error| Invalid::new("", error.to_string()))
}

/// Number in a file. Fortran's exponents (`1.5D-3`) are accepted.
pub(super) fn number(text: &str) -> Option<f64> {
    let plain = text.trim();
    let parsed = plain.parse::<f64>().ok().or_else(|| plain.replace(['d', 'D'], "e").parse().ok())?;
    // `nan` and `inf` are words of Rust, not of these files.
    (parsed.is_finite() && plain.bytes().any(|b| b.is_ascii_digit())).then_some(parsed)
}

/// Millimetres in a unit of length.
pub(super) fn mm_of(unit: &str) -> Option<f64> {
    match unit.to_ascii_lowercase().as_str() {
        "mm" => Some(1.0),
        "cm" => Some(10.0),
        "in" | "inch" | "inches" => Some(25.4),
        "m" | "meter" | "meters" => Some(1000.0),
        _ => None,
    }
}

/// First word of a record as a number above 0.
pub(super) fn positive<S: AsRef<str>>(words: &[S], key: &str, line: usize) -> Read<f64> {
    let word = words.first().map_or("", |word| word.as_ref());
    match number(word) {
        Some(number) if number > 0.0 => Ok(number),
        Some(_) | None => Err(Fault::at(line, format!("{key} {word}: not a number above 0"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_no_longer_than_lenses_need() {
        assert_eq!(decoded(b"NAME \xd818 mm").expect("Latin-1"), "NAME Ø18 mm");
        assert!(decoded(&vec![b' '; MOST_BYTES + 1]).is_err());
    }

    #[test]
    fn numbers_are_finite() {
        assert_eq!(number(" -1.5E-3 "), Some(-1.5e-3));
        assert_eq!(number("1.5D-3"), Some(1.5e-3));
        for text in ["nan", "inf", "infinity", "1e999", "", "1,5", "AS"] {
            assert_eq!(number(text), None, "{text}");
        }
    }
}
