//! `film.npy.gz`: the sums of a part of a render, from which the whole is merged.
//!
//! The file is a NumPy array of `float64`, shape (rows, columns, channels, 4), compressed by gzip (RFC 1952) to half of
//! its bytes: `numpy.load(gzip.open(…))` reads it. The four values are Σ v over the samples v of the pixel with its
//! rounding error, and Σ v² with its own: [`Sums`]. The channels are named in `part.json`. The file is written and read
//! strip by strip, since films of large images do not fit into memory.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};

use flate2::Compression;
use flate2::bufread::GzDecoder;
use flate2::write::GzEncoder;
use npyz::{NpyFile, NpyReader, Order, WriterBuilder};

use super::npy::write_planes;
use photosite_core::Invalid;
use photosite_core::math::double_double::DoubleDouble;
use photosite_raw::with_short_header;
use photosite_transport::film::{Film, Sums};

/// Number of values for each channel of a pixel.
const NUMBERS: usize = 4;

fn shape([width, height]: [usize; 2], channels: usize) -> [u64; 4] {
    [height, width, channels, NUMBERS].map(|n| n as u64)
}

fn write_header<W: Write>(shape: &[u64], to: W) -> io::Result<()> {
    let options = npyz::WriteOptions::<f64>::new().default_dtype().shape(shape).writer(to);
    options.write_header_only().map(|_| ())
}

fn write_sums<W: Write>(film: &Film, mut to: W) -> io::Result<()> {
    for s in film.sums() {
        let numbers = [s.sum.high, s.sum.low, s.squares.high, s.squares.low];
        to.write_all(numbers.map(f64::to_le_bytes).as_flattened())?;
    }
    Ok(())
}

/// Bytes of the file of an image of `size` columns and rows and this number of channels, up to `row`.
pub fn film_bytes(size: [usize; 2], channels: usize, row: usize) -> u64 {
    let mut header = Vec::new();
    write_header(&shape(size, channels), &mut header).expect("memory takes all");
    (header.len() + row * size[0] * channels * NUMBERS * size_of::<f64>()) as u64
}

/// Writes the sums of a film's rows to their place in the file of an image of `height` rows.
pub fn write_film<W: Write + Seek>(film: &Film, height: usize, mut to: W) -> io::Result<()> {
    let (size, channels) = ([film.width(), height], film.channels().len());
    to.seek(SeekFrom::Start(0))?;
    write_header(&shape(size, channels), &mut to)?;
    to.seek(SeekFrom::Start(film_bytes(size, channels, film.image_rows().start)))?;
    write_sums(film, &mut to)?;
    to.flush()
}

/// Compresses what [`write_film`] has written.
pub fn write_compressed(film: &mut impl Read, to: impl Write) -> io::Result<()> {
    // More work saves next to nothing: half of the bytes are zeros, and the others noise.
    let mut compressed = GzEncoder::new(to, Compression::fast());
    io::copy(film, &mut compressed)?;
    compressed.finish()?.flush()
}

/// Writes the number of samples of each pixel: an array of `uint32`, shape (rows, columns).
pub fn write_samples<W: Write>(size: [usize; 2], counts: &[u32], to: W) -> io::Result<()> {
    write_planes(size, &[counts], |count| count, to)
}

/// Reader of a file's sums, from its first row to its last.
pub struct FilmReader<'a> {
    numbers: NpyReader<f64, Box<dyn Read + 'a>>,
}

/// Writes an unfinished film: its numbers of samples, and the sums of all of them, one array after the other.
pub fn write_unfinished<W: Write>(film: &Film, mut to: W) -> io::Result<()> {
    let size = [film.width(), film.height()];
    write_samples(size, film.counts(), &mut to)?;
    write_header(&shape(size, film.channels().len()), &mut to)?;
    write_sums(film, to)
}

/// Adds the sums that [`write_unfinished`] wrote to a film of the same size and channels.
pub fn add_unfinished<R: Read>(film: &mut Film, mut from: R) -> Result<(), Invalid> {
    let counts = read_samples([film.width(), film.height()], &mut from)?;
    FilmReader::new([film.width(), film.height()], film.channels().len(), from)?.add_sums(film, counts)
}

/// Reads the numbers of samples that [`write_samples`] wrote.
pub fn read_samples<R: Read>([width, height]: [usize; 2], from: R) -> Result<Vec<u32>, Invalid> {
    let counts = array(&[height, width].map(|n| n as u64), from)?.data::<u32>().map_err(|e| unreadable(&e))?;
    counts.collect::<io::Result<Vec<u32>>>().map_err(|e| unreadable(&e))
}

fn unreadable(error: &dyn std::fmt::Display) -> Invalid {
    Invalid::new("", format!("cannot read it as the sums of a film: {error}")).help("render that part again")
}

/// Reader of an array of that shape.
fn array<'a>(shape: &[u64], from: impl Read + 'a) -> Result<NpyFile<Box<dyn Read + 'a>>, Invalid> {
    let from: Box<dyn Read + 'a> = Box::new(with_short_header(from)?);
    let array = NpyFile::new(from).map_err(|e| unreadable(&e))?;
    if array.shape() != shape || array.order() == Order::Fortran {
        return Err(unreadable(&format!("its shape is {:?} instead of {shape:?}", array.shape())));
    }
    Ok(array)
}

impl<'a> FilmReader<'a> {
    /// Reader of the sums of an image of `size` columns and rows. Values are read one by one, so `from` should be
    /// buffered.
    pub fn new(size: [usize; 2], channels: usize, from: impl Read + 'a) -> Result<Self, Invalid> {
        let numbers = array(&shape(size, channels), from)?.data::<f64>().map_err(|e| unreadable(&e))?;
        Ok(Self { numbers })
    }

    /// Reader of a file that [`write_compressed`] wrote.
    pub fn compressed(size: [usize; 2], channels: usize, from: impl BufRead + 'a) -> Result<Self, Invalid> {
        Self::new(size, channels, BufReader::new(GzDecoder::new(from)))
    }

    /// Adds the next rows, as many as a film of the same columns and channels holds, of `samples` samples per pixel.
    pub fn add_to(&mut self, film: &mut Film, samples: u32) -> Result<(), Invalid> {
        let pixels = film.counts().len();
        self.add_sums(film, std::iter::repeat_n(samples, pixels))
    }

    fn add_sums(&mut self, film: &mut Film, counts: impl IntoIterator<Item = u32>) -> Result<(), Invalid> {
        let mut failure = None;
        let mut next = || match self.numbers.next() {
            Some(Ok(number)) if !number.is_nan() => Some(number),
            Some(Ok(_)) => {
                failure = Some(unreadable(&"it holds something that is not a number"));
                None
            }
            Some(Err(error)) => {
                failure = Some(unreadable(&error));
                None
            }
            None => None,
        };
        let wanted = film.sums().len();
        let sums = std::iter::from_fn(|| {
            let [sum, squares] = [(next()?, next()?), (next()?, next()?)].map(|(high, low)| DoubleDouble { high, low });
            Some(Sums { sum, squares })
        });
        film.add(sums.take(wanted), counts);
        failure.map_or(Ok(()), Err)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use photosite_core::spectrum::{SampledSpectrum, Spectrum, WavelengthSampler};
    use photosite_transport::film::{FilmResponses, Response};

    fn responses() -> FilmResponses {
        let response = |name: &str, level| Response::new(name, Spectrum::constant(level));
        FilmResponses::new(&[response("A", 1.0), response("B", 0.3)])
    }

    fn empty() -> Film {
        Film::new(3, 2, responses())
    }

    fn film() -> Film {
        let mut film = empty();
        let sampler = WavelengthSampler::new(&Spectrum::constant(1.0));
        for (y, row) in film.bands(1).iter_mut().enumerate() {
            for i in 0..21 {
                let light = SampledSpectrum::splat(0.1 + (i * i) as f32 / (1 + y) as f32);
                row.add(i % 3, [[(light, &sampler.sample(i as f32 / 21.0))]]);
            }
        }
        film
    }

    fn file() -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        write_film(&film(), 2, &mut file).expect("written");
        file.into_inner()
    }

    fn add_film(film: &mut Film, samples: u32, file: &[u8]) -> Result<(), Invalid> {
        let size = [film.width(), film.height()];
        FilmReader::new(size, film.channels().len(), file)?.add_to(film, samples)
    }

    #[test]
    fn sums_come_back_bit_by_bit() {
        let mut read = empty();
        add_film(&mut read, 7, &file()[..]).expect("a film");
        assert_eq!((read.sums(), read.samples()), (film().sums(), 7));
        assert_eq!(read.estimate(["A", "B"]), film().estimate(["A", "B"]));
    }

    #[test]
    fn strips_of_rows_make_the_file_and_are_read_from_it() {
        let whole = film();
        let mut file = Cursor::new(Vec::new());
        let strip = |row: usize| Film::of_rows(3, row..row + 1, responses());
        for row in 0..2 {
            let mut film = strip(row);
            film.add(whole.sums()[row * 6..].iter().copied(), [7; 3]);
            assert_eq!(file.get_ref().len() as u64, if row == 0 { 0 } else { film_bytes([3, 2], 2, row) });
            write_film(&film, 2, &mut file).expect("written");
        }
        let bytes = file.into_inner();
        assert!(bytes == self::file());
        let mut sums = FilmReader::new([3, 2], 2, &bytes[..]).expect("a film");
        for row in 0..2 {
            let mut read = strip(row);
            sums.add_to(&mut read, 7).expect("rows");
            assert_eq!((read.sums(), read.samples()), (&whole.sums()[row * 6..][..6], 7));
        }
    }

    #[test]
    fn what_is_not_finished_comes_back_with_its_counts() {
        let mut film = film();
        let sampler = WavelengthSampler::new(&Spectrum::constant(1.0));
        film.bands(1)[1].add(2, [[(SampledSpectrum::splat(0.7), &sampler.sample(0.3))]]);
        let mut file = Vec::new();
        for _ in 0..2 {
            write_unfinished(&film, &mut file).expect("written");
        }
        let mut from = &file[..];
        for _ in 0..2 {
            let mut read = empty();
            add_unfinished(&mut read, &mut from).expect("a film");
            assert_eq!((read.sums(), read.counts()), (film.sums(), film.counts()));
        }
        assert!(from.is_empty() && film.counts()[5] == 8);
        assert!(add_unfinished(&mut empty(), &file[..100]).is_err());
    }

    #[test]
    fn damaged_and_other_files_are_refused() {
        let whole = file();
        for length in [0, 5, 11, 60, 128, whole.len() / 2, whole.len() - 1] {
            assert!(add_film(&mut empty(), 7, &whole[..length]).is_err(), "cut to {length} bytes");
        }
        let mut file = whole.clone();
        for at in 0..file.len() {
            for value in [0x00, 0xff, b'9', file[at] ^ 0x10] {
                file[at] = value;
                let _ = add_film(&mut empty(), 7, &file[..]);
            }
            file[at] = whole[at];
        }
        let last = file.len() - 8;
        file[last..].copy_from_slice(&f64::NAN.to_le_bytes());
        let error = add_film(&mut empty(), 7, &file[..]).expect_err("refused");
        assert!(error.message.contains("not a number"), "{error}");
        let mut wide = Film::new(4, 2, FilmResponses::new(&[]));
        let error = add_film(&mut wide, 7, &whole[..]).expect_err("refused");
        assert!(error.message.contains("[2, 3, 2, 4] instead of [2, 4, 0, 4]"), "{error}");
    }
}
