//! `film.npy`: the sums of a part of a render, from which the whole is put together.
//!
//! A NumPy array of `float64`, shape (rows, columns, channels, 4). The four are Σ v over the samples v of the pixel and what
//! rounding leaves of it, and the same of Σ v²: [`Sums`]. What the channels are is said elsewhere.

use std::io::{self, Read, Write};

use npyz::{NpyFile, Order, WriterBuilder};

use super::npy::write_planes;
use crate::Invalid;
use crate::film::{Film, Sums};
use crate::math::double_double::DoubleDouble;
use crate::raw::with_short_header;

/// Numbers for each channel of a pixel.
const NUMBERS: usize = 4;

fn shape(film: &Film) -> [u64; 4] {
    [film.height(), film.width(), film.channels().len(), NUMBERS].map(|n| n as u64)
}

/// Writes all sums of a film.
pub fn write_film<W: Write>(film: &Film, to: W) -> io::Result<()> {
    let mut array = npyz::WriteOptions::new().default_dtype().shape(&shape(film)).writer(to).begin_nd()?;
    let numbers = |s: &Sums| [s.sum.high, s.sum.low, s.squares.high, s.squares.low];
    array.extend(film.sums().iter().flat_map(numbers))?;
    array.finish()
}

/// Writes how many samples each pixel has: an array of `uint32`, shape (rows, columns).
pub fn write_samples<W: Write>(film: &Film, to: W) -> io::Result<()> {
    write_planes([film.width(), film.height()], &[film.counts()], |count| count, to)
}

/// Adds the sums of a file, of `samples` samples a pixel, to a film of the same size and channels.
pub fn add_film<R: Read>(film: &mut Film, samples: u32, from: R) -> Result<(), Invalid> {
    let pixels = film.counts().len();
    add_sums(film, std::iter::repeat_n(samples, pixels), from)
}

/// Writes a film that is not finished: its numbers of samples, and the sums of all of them, one array after the other.
pub fn write_unfinished<W: Write>(film: &Film, mut to: W) -> io::Result<()> {
    write_samples(film, &mut to)?;
    write_film(film, to)
}

/// Adds what [`write_unfinished`] wrote to a film of the same size and channels.
pub fn add_unfinished<R: Read>(film: &mut Film, mut from: R) -> Result<(), Invalid> {
    let array = array(&[film.height(), film.width()].map(|n| n as u64), &mut from)?;
    let counts = array.data::<u32>().map_err(|e| unreadable(&e))?;
    let counts = counts.collect::<io::Result<Vec<u32>>>().map_err(|e| unreadable(&e))?;
    add_sums(film, counts, from)
}

fn unreadable(error: &dyn std::fmt::Display) -> Invalid {
    Invalid::new("", format!("cannot read it as the sums of a film: {error}")).help("render that part again")
}

/// An array of that shape.
fn array<R: Read>(shape: &[u64], from: R) -> Result<NpyFile<impl Read + use<R>>, Invalid> {
    let array = NpyFile::new(with_short_header(from)?).map_err(|e| unreadable(&e))?;
    if array.shape() != shape || array.order() == Order::Fortran {
        return Err(unreadable(&format!("its shape is {:?} instead of {shape:?}", array.shape())));
    }
    Ok(array)
}

fn add_sums<R: Read>(film: &mut Film, counts: impl IntoIterator<Item = u32>, from: R) -> Result<(), Invalid> {
    let array = array(&shape(film), from)?;
    let mut numbers = array.data::<f64>().map_err(|e| unreadable(&e))?;
    let mut failure = None;
    let mut next = || match numbers.next() {
        Some(Ok(number)) if !number.is_nan() => Some(number),
        Some(Ok(_)) => {
            failure = Some(unreadable(&"it holds what is no number"));
            None
        }
        Some(Err(error)) => {
            failure = Some(unreadable(&error));
            None
        }
        None => None,
    };
    let sums = std::iter::from_fn(|| {
        let [sum, squares] = [(next()?, next()?), (next()?, next()?)].map(|(high, low)| DoubleDouble { high, low });
        Some(Sums { sum, squares })
    });
    film.add(sums, counts);
    failure.map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{FilmResponses, Response};
    use crate::spectrum::{SampledSpectrum, Spectrum, WavelengthSampler};

    fn empty() -> Film {
        let response = |name: &str, level| Response { name: name.to_owned(), spectrum: Spectrum::constant(level) };
        Film::new(3, 2, FilmResponses::new(&[response("A", 1.0), response("B", 0.3)]))
    }

    fn film() -> Film {
        let mut film = empty();
        let sampler = WavelengthSampler::new(&Spectrum::constant(1.0));
        for (y, row) in film.rows().iter_mut().enumerate() {
            for i in 0..21 {
                let light = SampledSpectrum::splat(0.1 + (i * i) as f32 / (1 + y) as f32);
                row.add(i % 3, light, &sampler.sample(i as f32 / 21.0));
            }
        }
        film
    }

    fn file() -> Vec<u8> {
        let mut file = Vec::new();
        write_film(&film(), &mut file).expect("written");
        file
    }

    #[test]
    fn sums_come_back_bit_by_bit() {
        let mut read = empty();
        add_film(&mut read, 7, &file()[..]).expect("a film");
        assert_eq!((read.sums(), read.samples()), (film().sums(), 7));
        assert_eq!(read.estimate(["A", "B"]), film().estimate(["A", "B"]));
    }

    #[test]
    fn what_is_not_finished_comes_back_with_its_counts() {
        let mut film = film();
        let sampler = WavelengthSampler::new(&Spectrum::constant(1.0));
        film.rows()[1].add(2, SampledSpectrum::splat(0.7), &sampler.sample(0.3));
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
        assert!(error.message.contains("no number"), "{error}");
        let mut wide = Film::new(4, 2, FilmResponses::new(&[]));
        let error = add_film(&mut wide, 7, &whole[..]).expect_err("refused");
        assert!(error.message.contains("[2, 3, 2, 4] instead of [2, 4, 0, 4]"), "{error}");
    }
}
