//! The digital numbers as an image of Netpbm: written as binary PGM (Netpbm's `pgm(5)`) of 16 bits, most significant
//! byte first, or PPM (`ppm(5)`) where every pixel has three channels; read from any of
//!
//! | begins with | holds |
//! |---|---|
//! | `P1`, `P4` | PBM, bits as text or binary (`pbm(5)`): 1 is black, the number 0, and 0 is white, the number 1 |
//! | `P2`, `P5` | PGM, grey numbers as text or binary |
//! | `P3`, `P6` | PPM, red, green and blue as text or binary |

use std::io::{self, BufRead, Read, Write};

use photosite_core::Invalid;

use super::{Cfa, MAX_SIDE, RawImage, check_memory};

/// Writes a PGM file, or a PPM file of three numbers a pixel. Its maximum is 65535 whatever the converter's bits, so
/// that no reader rescales the numbers.
pub fn write_pgm<W: Write>(raw: &RawImage, mut to: W) -> io::Result<()> {
    let magic = match raw.cfa.samples_per_pixel() {
        1 => "P5",
        3 => "P6",
        other => return Err(io::Error::other(format!("pixels of {other} values fit neither PGM nor PPM"))),
    };
    write!(to, "{magic}\n{} {}\n65535\n", raw.width, raw.height)?;
    let mut row_bytes = Vec::with_capacity(2 * raw.row_length());
    for row in raw.data.chunks(raw.row_length().max(1)) {
        row_bytes.clear();
        row_bytes.extend(row.iter().flat_map(|dn| dn.to_be_bytes()));
        to.write_all(&row_bytes)?;
    }
    Ok(())
}

/// Reads a PBM or PGM file as the numbers of a monochrome sensor and a PPM file as RGB, unscaled: nothing in it says
/// more. The file's maximum is the white level.
pub fn read_pnm<R: BufRead>(mut from: R) -> Result<RawImage, Invalid> {
    let mut magic = [0; 2];
    let begun = from.read_exact(&mut magic);
    let (kind, is_text) = match &magic {
        b"P1" => ("PBM", true),
        b"P2" => ("PGM", true),
        b"P3" => ("PPM", true),
        b"P4" => ("PBM", false),
        b"P5" => ("PGM", false),
        b"P6" => ("PPM", false),
        _ => return Err(unreadable("PBM, PGM or PPM", &"it does not begin with P1 to P6").help("convert it to PGM")),
    };
    let unreadable = |error: &dyn std::fmt::Display| unreadable(kind, error);
    begun.map_err(|e| unreadable(&e))?;
    let mut number = |name: &str| decimal(&mut from).map_err(|e| unreadable(&format!("its {name}: {e}")));
    let (width, height) = (number("width")? as usize, number("height")? as usize);
    let maximum = if kind == "PBM" { 1 } else { number("maximum")? };
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(unreadable(&format!("{width} × {height} pixels are not an image")));
    }
    let Some(maximum) = u16::try_from(maximum).ok().filter(|&maximum| maximum > 0) else {
        return Err(unreadable(&format!("a maximum of {maximum} instead of 1–65535")));
    };
    let cfa = if kind == "PPM" { Cfa::full(["R", "G", "B"])? } else { Cfa::mono() };
    check_memory([width, height], cfa.samples_per_pixel())?;
    let row_length = width * cfa.samples_per_pixel();
    let data = match (kind, is_text) {
        ("PBM", true) => text(from, row_length * height, bit),
        (_, true) => text(from, row_length * height, |from| u16::try_from(decimal(from)?).map_err(io::Error::other)),
        ("PBM", false) => bits(from, width, height),
        (_, false) => binary(from, row_length * height, maximum),
    };
    let data = data.map_err(|error| {
        let is_cut = error.kind() == io::ErrorKind::UnexpectedEof;
        if is_cut { unreadable(&error).help("the file is truncated") } else { unreadable(&error) }
    })?;
    Ok(RawImage::bare(width, height, data, cfa, maximum))
}

fn unreadable(kind: &str, error: &dyn std::fmt::Display) -> Invalid {
    Invalid::new("", format!("cannot read it as {kind}: {error}"))
}

/// Reads values of one byte, or of two where the maximum needs them.
fn binary(from: impl Read, count: usize, maximum: u16) -> io::Result<Vec<u16>> {
    if maximum <= 0xff {
        return Ok(bytes(from, count)?.into_iter().map(u16::from).collect());
    }
    Ok(bytes(from, 2 * count)?.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect())
}

/// Bits of rows that end with a whole byte, the most significant first.
fn bits(from: impl Read, width: usize, height: usize) -> io::Result<Vec<u16>> {
    let row_bytes = width.div_ceil(8);
    let bytes = bytes(from, row_bytes * height)?;
    let row = |row: &[u8]| (0..width).map(|x| u16::from(row[x / 8] >> (7 - x % 8) & 1 == 0)).collect::<Vec<_>>();
    Ok(bytes.chunks_exact(row_bytes).flat_map(row).collect())
}

/// Reads `count` bytes, for which no memory is taken before they are there.
fn bytes(from: impl Read, count: usize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(count as u64).read_to_end(&mut bytes)?;
    if bytes.len() != count {
        let message = format!("{} bytes of pixels instead of {count}", bytes.len());
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, message));
    }
    Ok(bytes)
}

/// Reads values that are written as text.
fn text<R: BufRead>(mut from: R, count: usize, next: fn(&mut R) -> io::Result<u16>) -> io::Result<Vec<u16>> {
    let mut numbers = Vec::new();
    while numbers.len() < count {
        numbers.push(next(&mut from).map_err(|error| {
            let place = format!("number {} of {count}: {error}", numbers.len() + 1);
            io::Error::new(error.kind(), place)
        })?);
    }
    Ok(numbers)
}

/// The next bit of a text, in which nothing needs to part them.
fn bit(from: &mut impl BufRead) -> io::Result<u16> {
    match first(from)? {
        b'0' => Ok(1),
        b'1' => Ok(0),
        other => Err(io::Error::other(format!("{:?} is neither 0 nor 1", char::from(other)))),
    }
}

/// The next number, with the one white space behind it.
fn decimal(from: &mut impl BufRead) -> io::Result<u32> {
    let mut digits = String::new();
    let mut byte = first(from)?;
    loop {
        match byte {
            b'#' => {
                from.skip_until(b'\n')?;
                break;
            }
            digit if digit.is_ascii_digit() && digits.len() < 9 => digits.push(digit.into()),
            space if space.is_ascii_whitespace() => break,
            other => return Err(io::Error::other(format!("{:?} is not a digit", char::from(other)))),
        }
        // A text may end with its last digit.
        let Some(&next) = from.fill_buf()?.first() else { break };
        from.consume(1);
        byte = next;
    }
    digits.parse().map_err(io::Error::other)
}

/// The next byte that is no white space and in no comment, which goes from # to the end of the line.
fn first(from: &mut impl BufRead) -> io::Result<u8> {
    loop {
        let mut byte = [0];
        from.read_exact(&mut byte)?;
        match byte[0] {
            b'#' => drop(from.skip_until(b'\n')?),
            space if space.is_ascii_whitespace() => {}
            other => return Ok(other),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_as_they_went() {
        let raw = RawImage::bare(7, 5, (0..35).map(|i| i * 1_801).collect(), Cfa::mono(), u16::MAX);
        let mut file = Vec::new();
        write_pgm(&raw, &mut file).expect("written");
        assert_eq!(read_pnm(&file[..]), Ok(raw));
        for length in 0..file.len() {
            assert!(read_pnm(&file[..length]).is_err(), "cut to {length} bytes");
        }
    }

    #[test]
    fn files_of_other_programs_are_not_rescaled() {
        let narrow = read_pnm(&b"P5 # by hand\n#\n 2\t1\n100\n\x07\xff"[..]).expect("8 bits");
        assert_eq!((narrow.width, narrow.height, narrow.data, narrow.white_level_dn), (2, 1, vec![7, 255], 100));
        let wide = read_pnm(&b"P5\n1 2\n4095\n\x01\x02\x0f\xff"[..]).expect("12 bits");
        assert_eq!((wide.height, wide.data, wide.bits), (2, vec![0x102, 0xfff], 12));
    }

    /// The examples of Netpbm's manual, shortened.
    #[test]
    fn every_kind_is_read_as_text_and_binary() {
        // A 1 is black.
        let bits = vec![1, 0, 1, 1, 1, 0, 0, 1, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 0, 1];
        for file in [
            &b"P1\n# J\n10 2\n0100011000 # the first row\n1000 0 1 0 0 1\n0"[..],
            b"P1 10 2 0 1 0 0 0 1 1 0 0 0\r\n1 0 0 0 0 1 0 0 1 0",
            b"P4\n10 2\n\x46\x3f\x84\x80",
        ] {
            let found = read_pnm(file).expect("bits");
            assert_eq!((found.width, found.height, found.white_level_dn, found.cfa), (10, 2, 1, Cfa::mono()));
            assert_eq!(found.data, bits, "{:?}", String::from_utf8_lossy(file));
        }
        for file in [&b"P2\n3 1 15\n0 7\n15"[..], b"P2 3#columns\n1 15 0\t7# half\n15\n", b"P5 3 1 15\n\x00\x07\x0f"] {
            let found = read_pnm(file).expect("grey");
            assert_eq!((found.width, found.data, found.white_level_dn), (3, vec![0, 7, 15], 15));
        }
        for file in
            [&b"P3\n1 2 1000\n1000 0 7\n1 2 3\n"[..], b"P6 1 2 1000\n\x03\xe8\x00\x00\x00\x07\x00\x01\x00\x02\x00\x03"]
        {
            let found = read_pnm(file).expect("colours");
            assert_eq!((found.height, found.data, found.bits), (2, vec![1000, 0, 7, 1, 2, 3], 10));
            assert_eq!(found.cfa.channels(), ["R", "G", "B"]);
        }
    }

    #[test]
    fn other_files_are_refused() {
        for (file, complaint) in [
            (&b"P7 1 1 255 7"[..], "P1 to P6"),
            (b"P", "P1 to P6"),
            (b"P5 1 x 255 7", "height"),
            (b"P5 0 1 255 ", "not an image"),
            (b"P5 99999 99999 255 ", "not an image"),
            (b"P5 1 1 65536 aa", "65536"),
            (b"P5 1 1 0 a", "maximum"),
            (b"P5 99999999999 1 255 a", "width"),
            (b"P5 2 1 255\na", "1 bytes of pixels instead of 2"),
            (b"P4 9 2 \xff\xff\xff", "3 bytes of pixels instead of 4"),
            (b"P2 2 1 255 7", "number 2 of 2"),
            (b"P2 2 1 255 7 -8", "number 2 of 2: '-' is not a digit"),
            (b"P2 1 1 255 65536", "number 1 of 1"),
            (b"P1 2 1 02", "number 2 of 2: '2' is neither 0 nor 1"),
            (b"P3 1 1 255 7 8", "number 3 of 3"),
        ] {
            let error = read_pnm(file).expect_err("refused");
            assert!(error.message.contains(complaint), "{error}");
        }
        assert_eq!(read_pnm(&b"P2 2 1 255 7"[..]).expect_err("cut").help, Some("the file is truncated".into()));
    }
}
