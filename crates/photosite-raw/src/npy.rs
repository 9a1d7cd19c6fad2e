//! The digital numbers as a NumPy array of `uint16`, shape (rows, columns), or (rows, columns, channels) where every
//! pixel has all channels.

use std::io::{self, Read, Write};

use npyz::{NpyFile, Order, WriterBuilder};

use photosite_core::Invalid;

use super::{Cfa, MAX_SIDE, RawImage, check_memory};

/// Writes an NPY file.
pub fn write_npy<W: Write>(raw: &RawImage, to: W) -> io::Result<()> {
    let shape = [raw.height, raw.width, raw.cfa.samples_per_pixel()].map(|n| n as u64);
    let axes = if raw.cfa.is_full() { 3 } else { 2 };
    let mut array = npyz::WriteOptions::new().default_dtype().shape(&shape[..axes]).writer(to).begin_nd()?;
    array.extend(raw.data.iter().copied())?;
    array.finish()
}

/// Reads an array of `uint16` with two axes as the numbers of a monochrome sensor, and one with a third axis of three
/// channels as RGB: nothing in it says more.
pub fn read_npy<R: Read>(from: R) -> Result<RawImage, Invalid> {
    let NpyImage { width, height, channels, numbers } = read_npy_image(from)?;
    let cfa = match channels {
        1 => Cfa::mono(),
        3 => Cfa::full(["R", "G", "B"])?,
        _ => {
            return Err(unreadable(&format!("{channels} channels do not form a raw image"))
                .help("write an array of shape (rows, columns), or (rows, columns, 3) for RGB"));
        }
    };
    match numbers {
        NpyValues::U16(data) => Ok(RawImage::bare(width, height, data, cfa, u16::MAX)),
        NpyValues::U8(_) | NpyValues::F32(_) => {
            Err(unreadable(&"its numbers are not 16-bit digital numbers").help("write an array of uint16"))
        }
    }
}

/// Image of an NPY array.
#[derive(Clone, Debug, PartialEq)]
pub struct NpyImage {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values a pixel, 1 to 4, one beside the other.
    pub channels: usize,
    /// Values of all pixels.
    pub numbers: NpyValues,
}

/// Values of an array.
#[derive(Clone, Debug, PartialEq)]
pub enum NpyValues {
    /// `uint8`.
    U8(Vec<u8>),
    /// `uint16`.
    U16(Vec<u16>),
    /// `float32`, or `float64` in single precision.
    F32(Vec<f32>),
}

/// Reads an array of shape (rows, columns) or (rows, columns, channels), of 8 or 16 bits or of floating-point numbers.
pub fn read_npy_image<R: Read>(from: R) -> Result<NpyImage, Invalid> {
    let array = NpyFile::new(with_short_header(from)?).map_err(|e| unreadable(&e))?;
    let (height, width, channels) = match *array.shape() {
        [height, width] => (height, width, 1),
        [height, width, channels @ 1..=4] => (height, width, channels as usize),
        _ => {
            return Err(unreadable(&format!("an array of shape {:?} is not an image", array.shape()))
                .help("write an array of shape (rows, columns), or (rows, columns, 3) for RGB"));
        }
    };
    let sides = 1..=MAX_SIDE as u64;
    if !sides.contains(&width) || !sides.contains(&height) {
        return Err(unreadable(&format!("{width} × {height} pixels are not an image")));
    }
    if array.order() == Order::Fortran {
        return Err(
            unreadable(&"it is in Fortran order, columns first").help("write numpy.ascontiguousarray(array) instead")
        );
    }
    let (width, height) = (width as usize, height as usize);
    check_memory([width, height], channels)?;
    let wanted = width * height * channels;
    let numbers = match array.try_data::<u16>() {
        Ok(numbers) => NpyValues::U16(all(numbers, wanted)?),
        Err(array) => match array.try_data::<u8>() {
            Ok(numbers) => NpyValues::U8(all(numbers, wanted)?),
            Err(array) => match array.try_data::<f32>() {
                Ok(numbers) => NpyValues::F32(all(numbers, wanted)?),
                Err(array) => {
                    let numbers = array.data::<f64>();
                    let numbers = numbers
                        .map_err(|e| unreadable(&e).help("write an array of uint8, uint16, float32 or float64"))?;
                    NpyValues::F32(all(numbers.map(|number| number.map(|number| number as f32)), wanted)?)
                }
            },
        },
    };
    Ok(NpyImage { width, height, channels, numbers })
}

/// Collects `wanted` numbers, as many as the shape states.
fn all<T>(numbers: impl Iterator<Item = io::Result<T>>, wanted: usize) -> Result<Vec<T>, Invalid> {
    // Not with the capacity that the header states, which may be damaged.
    let mut data = Vec::new();
    for number in numbers {
        let number = number.map_err(|error| {
            let is_cut = error.kind() == io::ErrorKind::UnexpectedEof;
            if is_cut { unreadable(&format!("{} numbers instead of {wanted}", data.len())) } else { unreadable(&error) }
        });
        data.push(number.map_err(|invalid| invalid.help("the file is truncated"))?);
    }
    Ok(data)
}

fn unreadable(error: &dyn std::fmt::Display) -> Invalid {
    Invalid::new("", format!("cannot read it as NPY: {error}"))
}

/// Bytes of the longest header: that of an image has a line of text.
const LONGEST_HEADER: u32 = 1 << 16;
/// Most opening brackets in a header: that of plain numbers has two. Each one within others doubles the time that the
/// parser of headers takes.
const MOST_BRACKETS: usize = 8;

/// Passes a file on, unless its header states a length that memory must not be taken for, or would take for ever to
/// parse.
pub fn with_short_header<R: Read>(mut from: R) -> Result<impl Read, Invalid> {
    let refused = |problem: String| Invalid::new("", format!("cannot read it as NPY: {problem}"));
    let mut start = Vec::new();
    let mut read = |start: &mut Vec<u8>, most: u32| {
        let read = from.by_ref().take(most.into()).read_to_end(start);
        read.map(drop).map_err(|error| refused(error.to_string()))
    };
    read(&mut start, 12)?;
    // Version 1 has two bytes for the length, later ones four.
    let (header, length) = match start[..] {
        [_, _, _, _, _, _, 2..=u8::MAX, _, a, b, c, d] => (12, u32::from_le_bytes([a, b, c, d])),
        [_, _, _, _, _, _, _, _, a, b, ..] => (10, u16::from_le_bytes([a, b]).into()),
        _ => (start.len(), 0),
    };
    if length > LONGEST_HEADER {
        return Err(refused(format!("a header of {length} bytes")).help("the file is damaged"));
    }
    let more = (header + length as usize).saturating_sub(start.len());
    read(&mut start, more as u32)?;
    let brackets = start.iter().skip(header).take(length as usize).filter(|byte| b"([{".contains(byte)).count();
    if brackets > MOST_BRACKETS {
        let help = "write an array of plain numbers, as numpy.save(\"picture.npy\", array) does";
        return Err(refused(format!("a header of {brackets} brackets")).help(help));
    }
    Ok(io::Cursor::new(start).chain(from))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> Vec<u8> {
        let raw = RawImage::bare(7, 5, (0..35).map(|i| i * 1_801).collect(), Cfa::mono(), u16::MAX);
        let mut file = Vec::new();
        write_npy(&raw, &mut file).expect("written");
        assert_eq!(read_npy(&file[..]), Ok(raw));
        file
    }

    #[test]
    fn headers_of_lists_in_lists_are_refused_at_once() {
        for (version, length) in [(1u8, &[100u8, 0][..]), (2, &[100, 0, 0, 0])] {
            let start = [&b"\x93NUMPY"[..], &[version, 0], length, b"{'descr': "].concat();
            // What comes behind the header may have as many brackets as it likes.
            let file = [&start[..], &b"[".repeat(90), &b"[".repeat(1000)].concat();
            let error = read_npy(&file[..]).expect_err("no array");
            assert!(error.message.contains("91 brackets"), "{error}");
        }
    }

    #[test]
    fn damaged_files_are_errors_and_no_panics() {
        let whole = file();
        for length in 0..whole.len() {
            assert!(read_npy(&whole[..length]).is_err(), "cut to {length} bytes");
        }
        let mut file = whole.clone();
        for at in 0..file.len() {
            for value in [0x00, 0xff, b'9', file[at] ^ 0x10] {
                file[at] = value;
                let _ = read_npy(&file[..]);
            }
            file[at] = whole[at];
        }
    }

    #[test]
    fn images_of_any_numbers_are_read() {
        fn file<T: npyz::AutoSerialize>(shape: &[u64], numbers: impl IntoIterator<Item = T>) -> NpyImage {
            let mut file = Vec::new();
            let mut array =
                npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut file).begin_nd().expect("begun");
            array.extend(numbers).and_then(|()| array.finish()).expect("written");
            read_npy_image(&file[..]).expect("read")
        }
        let image = |channels, numbers| NpyImage { width: 3, height: 1, channels, numbers };
        assert_eq!(file(&[1, 3], [1u8, 2, 255]), image(1, NpyValues::U8(vec![1, 2, 255])));
        assert_eq!(file(&[1, 3, 1], [1u16, 2, 65_535]), image(1, NpyValues::U16(vec![1, 2, 65_535])));
        let numbers = [0.5f32, -1.0, 1e9, 0.0, 1.0, 2.0];
        assert_eq!(file(&[1, 3, 2], numbers), image(2, NpyValues::F32(numbers.to_vec())));
        assert_eq!(file(&[1, 3, 2], numbers.map(f64::from)), image(2, NpyValues::F32(numbers.to_vec())));
    }

    #[test]
    fn only_rows_of_16_bit_numbers_are_a_mosaic() {
        let read = |header: &str| {
            let length = (header.len() as u16).to_le_bytes();
            read_npy(&[b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), b"\x01\x02\x03\x04"].concat()[..])
        };
        let header = |dtype: &str, fortran: &str, shape: &str| {
            read(&format!("{{'descr': '{dtype}', 'fortran_order': {fortran}, 'shape': {shape}}}"))
        };
        let big_endian = header(">u2", "False", "(1, 2)").expect("an array");
        assert_eq!((big_endian.width, big_endian.height, big_endian.data), (2, 1, vec![0x102, 0x304]));
        for (array, complaint) in [
            (header("<u2", "False", "(2,)"), "shape [2]"),
            (header("<u2", "False", "(0, 2)"), "not an image"),
            (header("<u2", "False", "(1, 99999)"), "not an image"),
            (header("<f4", "False", "(1, 1)"), "not 16-bit digital numbers"),
            (header("|u1", "False", "(2, 2)"), "not 16-bit digital numbers"),
            (header("<i4", "False", "(1, 1)"), "cannot read it as NPY"),
            (header("<u2", "False", "(1, 1, 2)"), "2 channels"),
            (header("<u2", "True", "(1, 2)"), "columns first"),
            (header("<u2", "False", "(2, 2)"), "cannot read it as NPY"),
        ] {
            let error = array.expect_err("refused");
            assert!(
                error.message.contains(complaint) && error.help.is_some() != complaint.contains("not a"),
                "{error}"
            );
        }
    }
}
