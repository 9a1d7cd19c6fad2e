//! Bytes of a lens file as text: programs write UTF-16 or eight bits a letter.

use photosite_core::Invalid;

use super::draft::{Fault, Read};

/// Most bytes of a lens file: the largest that we know have 0.2 MB.
pub(super) const MOST_BYTES: usize = 1_000_000;

/// The text of a file. A byte order mark says UTF-16 or UTF-8; without one it is UTF-8, and where it is not, Latin-1,
/// as older versions of OpticStudio write.
pub(super) fn decoded(bytes: &[u8]) -> Result<String, Invalid> {
    if bytes.len() > MOST_BYTES {
        let message = format!("{} bytes, where lens files have at most 1 MB", bytes.len());
        return Err(
            Invalid::new("", message).help("give the prescription alone, without the merit function and pictures")
        );
    }
    let utf16 = |unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        String::from_utf16(&units).map_err(|_| {
            Invalid::new("", "it begins as UTF-16, but is not valid UTF-16").help("save it again, as UTF-8")
        })
    };
    match bytes {
        [0xff, 0xfe, ..] => utf16(u16::from_le_bytes),
        [0xfe, 0xff, ..] => utf16(u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => {
            String::from_utf8(rest.to_vec()).map_err(|_| Invalid::new("", "it begins as UTF-8, but is not valid UTF-8"))
        }
        _ => Ok(std::str::from_utf8(bytes)
            .map_or_else(|_| bytes.iter().map(|&byte| char::from(byte)).collect(), str::to_owned)),
    }
}

/// A number of a file. Fortran's exponents (`1.5D-3`) are read, too.
pub(super) fn number(text: &str) -> Option<f64> {
    let plain = text.trim();
    let parsed = plain.parse::<f64>().ok().or_else(|| plain.replace(['d', 'D'], "e").parse().ok())?;
    // `nan` and `inf` are words of Rust, not of these files.
    (parsed.is_finite() && plain.bytes().any(|b| b.is_ascii_digit())).then_some(parsed)
}

/// mm of a unit of length.
pub(super) fn mm_of(unit: &str) -> Option<f64> {
    match unit.to_ascii_lowercase().as_str() {
        "mm" => Some(1.0),
        "cm" => Some(10.0),
        "in" | "inch" | "inches" => Some(25.4),
        "m" | "meter" | "meters" => Some(1000.0),
        _ => None,
    }
}

/// The first word of a record as a number above 0.
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
    fn every_encoding_gives_the_same_text() {
        let text = "NAME Ø18 mm, f/2";
        let wide = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
        let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).expect("Latin-1")).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", text.as_bytes()].concat(),
            [&b"\xff\xfe"[..], &wide(u16::to_le_bytes)].concat(),
            [&b"\xfe\xff"[..], &wide(u16::to_be_bytes)].concat(),
            latin,
        ] {
            assert_eq!(decoded(&bytes).expect("text"), text);
        }
        assert!(decoded(b"\xff\xfe\x00\xd8").is_err());
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
