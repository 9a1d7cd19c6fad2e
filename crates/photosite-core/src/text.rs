//! Decoding of texts: UTF-8 or UTF-16, with or without a byte order mark, or eight bits a letter, with lines that end
//! in `\n`, `\r\n` or `\r`.
//!
//! All readers of texts from users begin here, so that all accept the same files.

use std::borrow::Cow;
use std::io::{self, ErrorKind};

/// Decodes a text of UTF-8 or UTF-16, without its byte order mark. Lines that end in `\r` alone end in `\n` then.
///
/// # Errors
///
/// The line that is no UTF-8; a text that says it is UTF-16 and is not; UTF-32.
pub fn decode(bytes: Vec<u8>) -> io::Result<String> {
    let (text, start) = unmarked(bytes)?;
    String::from_utf8(text).map_err(|bad| {
        let valid = &bad.as_bytes()[..bad.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|&&byte| byte == b'\n').count();
        let what = if start == Start::Utf8 { "begins as UTF-8, but line" } else { "line" };
        invalid(format!("{what} {line} is not valid UTF-8 text; save the file in that encoding"))
    })
}

/// Decodes a text as [`decode`] does, or as Latin-1 where it is neither UTF-8 nor UTF-16: comments and names in older
/// files are in any code page, and only ASCII matters.
///
/// # Errors
///
/// Errors of [`decode`], except for bytes that are no UTF-8 and do not begin as such.
pub fn decode_any(bytes: Vec<u8>) -> io::Result<String> {
    let (text, start) = unmarked(bytes)?;
    match String::from_utf8(text) {
        Ok(text) => Ok(text),
        Err(_) if start == Start::Utf8 => Err(invalid("begins as UTF-8, but is not valid UTF-8; save it again")),
        Err(bad) => Ok(bad.as_bytes().iter().map(|&byte| char::from(byte)).collect()),
    }
}

/// Bytes of a file that begins with a text and may go on with binary data, with UTF-16 turned into UTF-8, without a
/// byte order mark. Line ends stay.
///
/// # Errors
///
/// A text that says it is UTF-16 and is not; UTF-32.
pub fn plain(bytes: &[u8]) -> io::Result<Cow<'_, [u8]>> {
    Ok(match Start::of(bytes)? {
        Start::Plain => Cow::Borrowed(bytes),
        Start::Utf8 => Cow::Borrowed(&bytes[UTF8_MARK.len()..]),
        Start::Utf16 { mark, unit } => Cow::Owned(utf16(&bytes[mark..], unit)?.into_bytes()),
    })
}

/// Bytes of [`plain`] with line ends as [`decode`] leaves them, and the encoding of the start.
fn unmarked(bytes: Vec<u8>) -> io::Result<(Vec<u8>, Start)> {
    let start = Start::of(&bytes)?;
    let mut text = match plain(&bytes)? {
        Cow::Borrowed(same) if same.len() == bytes.len() => bytes,
        other @ (Cow::Borrowed(_) | Cow::Owned(_)) => other.into_owned(),
    };
    for i in 0..text.len() {
        if text[i] == b'\r' && text.get(i + 1) != Some(&b'\n') {
            text[i] = b'\n';
        }
    }
    Ok((text, start))
}

const UTF8_MARK: &[u8] = b"\xef\xbb\xbf";

/// Encoding of a text, by its first bytes.
#[derive(Clone, Copy, Debug)]
enum Start {
    /// A text without a mark.
    Plain,
    /// A text with the mark of UTF-8.
    Utf8,
    /// A text of UTF-16 after a mark of `mark` bytes, which may be 0.
    Utf16 { mark: usize, unit: fn([u8; 2]) -> u16 },
}

impl PartialEq for Start {
    fn eq(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }
}

impl Start {
    fn of(bytes: &[u8]) -> io::Result<Self> {
        Ok(match bytes {
            [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => {
                return Err(invalid("is text in UTF-32; save it again, as UTF-8"));
            }
            [0xff, 0xfe, ..] => Self::Utf16 { mark: 2, unit: u16::from_le_bytes },
            [0xfe, 0xff, ..] => Self::Utf16 { mark: 2, unit: u16::from_be_bytes },
            _ if bytes.starts_with(UTF8_MARK) => Self::Utf8,
            _ if is_latin_in_words(bytes, 0) => Self::Utf16 { mark: 0, unit: u16::from_le_bytes },
            _ if is_latin_in_words(bytes, 1) => Self::Utf16 { mark: 0, unit: u16::from_be_bytes },
            _ => Self::Plain,
        })
    }
}

/// Whether a file begins with letters of Latin-1 in two bytes each, of which the first or the second has the letter.
fn is_latin_in_words(bytes: &[u8], letter: usize) -> bool {
    /// Number of letters that decide: no binary header has as many in a row.
    const TELLING: usize = 8;
    let words = bytes.as_chunks::<2>().0;
    let is_letter = |word: &[u8; 2]| {
        let (byte, other) = (word[letter], word[1 - letter]);
        other == 0 && (!byte.is_ascii_control() || byte.is_ascii_whitespace())
    };
    bytes.len().is_multiple_of(2) && words.len() >= 2 && words.iter().take(TELLING).all(is_letter)
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> io::Result<String> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let units: Vec<u16> = pairs.iter().map(|&pair| unit(pair)).collect();
    match String::from_utf16(&units) {
        Ok(text) if rest.is_empty() => Ok(text),
        Ok(_) | Err(_) => Err(invalid("begins as UTF-16, but is not valid UTF-16; save it again, as UTF-8")),
    }
}

fn invalid(message: impl Into<String>) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, message.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A text in all encodings that are read.
    fn encodings(text: &str) -> Vec<Vec<u8>> {
        let wide = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
        vec![
            text.as_bytes().to_vec(),
            [UTF8_MARK, text.as_bytes()].concat(),
            [&b"\xff\xfe"[..], &wide(u16::to_le_bytes)].concat(),
            [&b"\xfe\xff"[..], &wide(u16::to_be_bytes)].concat(),
        ]
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "NAME Ø18 mm, f/2\nµ";
        for bytes in encodings(text) {
            assert_eq!(decode(bytes.clone()).expect("text"), text);
            assert_eq!(plain(&bytes).expect("text"), text.as_bytes());
            assert_eq!(decode_any(bytes).expect("text"), text);
        }
        // As iconv -t UTF-16LE writes it
        for order in [|c: u8| [c, 0], |c: u8| [0, c]] {
            assert_eq!(decode(b"v 1 2 3\nf 1".iter().flat_map(|&c| order(c)).collect()).expect("text"), "v 1 2 3\nf 1");
        }
        assert_eq!(decode_any(b"NAME \xd818 mm".to_vec()).expect("Latin-1"), "NAME Ø18 mm");
    }

    #[test]
    fn what_is_no_text_of_its_kind_says_so() {
        for (bytes, words) in [
            (&b"one\ntwo\n\xff"[..], "line 3 is not valid UTF-8"),
            (b"\xef\xbb\xbfone\xff", "line 1"),
            (b"\xff\xfe\x00\xd8", "not valid UTF-16"),
            (b"\xff\xfev\0x", "not valid UTF-16"),
            (b"\xff\xfe\0\0v\0\0\0", "UTF-32"),
            (b"\0\0\xfe\xff\0\0\0v", "UTF-32"),
        ] {
            let error = decode(bytes.to_vec()).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn numbers_are_not_taken_for_a_text() {
        // An STL file whose head is empty, a PLY file, an image
        for bytes in [&[0u8; 84][..], b"ply\nformat binary_little_endian 1.0\n\r\0\0\0", b"\x89PNG\r\n\x1a\n\0\0\0\r"] {
            assert!(matches!(plain(bytes).expect("kept"), Cow::Borrowed(same) if same == bytes));
        }
    }

    proptest! {
        /// Lines are the same whatever ends them.
        #[test]
        fn ends_of_lines_do_not_matter(lines in prop::collection::vec("[a-zé\u{1f52d} 0-9]{0,6}", 1..8)) {
            let expected = lines.join("\n");
            for end in ["\n", "\r\n", "\r"] {
                for bytes in encodings(&lines.join(end)) {
                    let text = decode(bytes).expect("text");
                    prop_assert_eq!(text.lines().collect::<Vec<_>>(), expected.lines().collect::<Vec<_>>());
                }
            }
        }

        #[test]
        fn no_bytes_make_the_decoder_panic(bytes in prop::collection::vec(any::<u8>(), 0..40)) {
            let (_, _, _) = (decode(bytes.clone()), decode_any(bytes.clone()), plain(&bytes));
        }
    }
}
