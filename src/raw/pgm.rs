//! The digital numbers as binary PGM of 16 bits, most significant byte first (Netpbm's `pgm(5)`), or PPM where every pixel
//! has three channels (`ppm(5)`).

use std::io::{self, BufRead, Read, Write};

use crate::Invalid;

use super::{Cfa, MAX_SIDE, RawImage};

/// Writes a PGM file. Its maximum is 65535 whatever the converter's bits, so that no reader rescales the numbers.
pub fn write_pgm<W: Write>(raw: &RawImage, mut to: W) -> io::Result<()> {
    let magic = match raw.cfa.samples_per_pixel() {
        1 => "P5",
        3 => "P6",
        other => return Err(io::Error::other(format!("pixels of {other} numbers fit neither PGM nor PPM"))),
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

/// Reads a binary PGM file of 8 or 16 bits as the numbers of a monochrome sensor and a PPM file as RGB, unscaled: nothing
/// in it says more.
pub fn read_pgm<R: BufRead>(mut from: R) -> Result<RawImage, Invalid> {
    let unreadable = |error: &dyn std::fmt::Display| Invalid::new("", format!("cannot read it as PGM: {error}"));
    let mut magic = [0; 2];
    from.read_exact(&mut magic).map_err(|e| unreadable(&e))?;
    let cfa = match &magic {
        b"P5" => Cfa::mono(),
        b"P6" => Cfa::full(["R", "G", "B"])?,
        _ => return Err(unreadable(&"it does not begin with P5 or P6").help("write it as binary PGM or PPM")),
    };
    let mut header = [0; 3];
    for (number, name) in header.iter_mut().zip(["width", "height", "maximum"]) {
        *number = decimal(&mut from).map_err(|e| unreadable(&format!("its {name}: {e}")))?;
    }
    let [width, height, maximum] = header;
    let (width, height) = (width as usize, height as usize);
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(unreadable(&format!("{width} × {height} pixels are not a picture")));
    }
    let Some(maximum) = u16::try_from(maximum).ok().filter(|&maximum| maximum > 0) else {
        return Err(unreadable(&format!("a maximum of {maximum} instead of 1–65535")));
    };
    let (numbers, wide) = (width * height * cfa.samples_per_pixel(), maximum > 0xff);
    let size = numbers * if wide { 2 } else { 1 };
    let mut bytes = Vec::new();
    from.take(size as u64).read_to_end(&mut bytes).map_err(|e| unreadable(&e))?;
    if bytes.len() != size {
        let message = format!("{} bytes of pixels instead of {size}", bytes.len());
        return Err(unreadable(&message).help("the file is cut short"));
    }
    let data = if wide {
        bytes.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect()
    } else {
        bytes.into_iter().map(u16::from).collect()
    };
    Ok(RawImage::bare(width, height, data, cfa, maximum))
}

/// The next number of the header, with the one white space behind it. Comments go from # to the end of the line.
fn decimal(from: &mut impl BufRead) -> io::Result<u32> {
    let mut digits = String::new();
    loop {
        let mut byte = [0];
        from.read_exact(&mut byte)?;
        match byte[0] {
            b'#' => {
                from.skip_until(b'\n')?;
            }
            digit if digit.is_ascii_digit() && digits.len() < 9 => digits.push(digit.into()),
            space if space.is_ascii_whitespace() && digits.is_empty() => {}
            space if space.is_ascii_whitespace() => return digits.parse().map_err(io::Error::other),
            other => return Err(io::Error::other(format!("{:?} is no digit", char::from(other)))),
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
        assert_eq!(read_pgm(&file[..]), Ok(raw));
        for length in 0..file.len() {
            assert!(read_pgm(&file[..length]).is_err(), "cut to {length} bytes");
        }
    }

    #[test]
    fn files_of_other_programs_are_not_rescaled() {
        let narrow = read_pgm(&b"P5 # by hand\n#\n 2\t1\n100\n\x07\xff"[..]).expect("8 bits");
        assert_eq!((narrow.width, narrow.height, narrow.data, narrow.white_level_dn), (2, 1, vec![7, 255], 100));
        let wide = read_pgm(&b"P5\n1 2\n4095\n\x01\x02\x0f\xff"[..]).expect("12 bits");
        assert_eq!((wide.height, wide.data, wide.bits), (2, vec![0x102, 0xfff], 12));
    }

    #[test]
    fn other_files_are_refused() {
        for (file, complaint) in [
            (&b"P2 1 1 255 7"[..], "P5 or P6"),
            (b"P5 1 x 255 7", "height"),
            (b"P5 0 1 255 ", "not a picture"),
            (b"P5 99999 99999 255 ", "not a picture"),
            (b"P5 1 1 65536 aa", "65536"),
            (b"P5 1 1 0 a", "maximum"),
            (b"P5 99999999999 1 255 a", "width"),
        ] {
            let error = read_pgm(file).expect_err("refused");
            assert!(error.message.contains(complaint), "{error}");
        }
    }
}
