//! Light of finished rows, in single precision and in a file rather than in memory.
//!
//! A film holds exact sums, 32 bytes for each channel of a pixel. Once a pixel has all its samples, its means and the
//! variances that are asked for are enough: 4 bytes each. Row after row, each holds the numbers of samples of its
//! pixels (`u32`), then the means of the film's channels and the variances of the first few (`f32`), plane after plane.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, MutexGuard};

use rayon::prelude::*;

use super::image_rows::ImageRows;
use photosite_core::image::{Channel, Estimate, Planes};
use photosite_transport::film::Film;

/// Storage of rows: a file, or memory where they are few.
pub trait Store: Read + Write + Seek + Send {}
impl<T: Read + Write + Seek + Send> Store for T {}

/// Bytes of a value.
const BYTES: usize = 4;
/// Values before the means of a row: one, the number of samples.
const COUNTS: usize = 1;
/// Number of rows that are prepared in parallel.
const ROWS_AT_ONCE: usize = 32;
/// Number of pixels whose sums stay in the cache from one channel to the next.
const PIXELS_AT_ONCE: usize = 64;

/// Rows of an image, as far as they are done.
#[derive(Clone)]
pub struct LightRows {
    store: Arc<Mutex<Box<dyn Store>>>,
    size: [usize; 2],
    channels: Vec<String>,
    /// Number of leading channels whose variance is kept.
    with_variance: usize,
    /// Factor on means when they are read.
    level: f32,
}

impl LightRows {
    /// Bytes per pixel of this number of channels, of which the first `with_variance` have a variance.
    pub fn bytes_per_pixel(channels: usize, with_variance: usize) -> usize {
        (COUNTS + channels + with_variance) * BYTES
    }

    /// Rows of an image of `size` columns and rows and a film's channels; the variance of the first `with_variance` is
    /// kept, too.
    pub fn new(store: Box<dyn Store>, size: [usize; 2], channels: Vec<String>, with_variance: usize) -> Self {
        Self { store: Arc::new(Mutex::new(store)), size, channels, with_variance, level: 1.0 }
    }

    /// The rows with their light scaled by `factor`.
    #[must_use]
    pub fn at_level(&self, factor: f32) -> Self {
        Self { level: self.level * factor, ..self.clone() }
    }

    fn row_bytes(&self) -> usize {
        self.size[0] * Self::bytes_per_pixel(self.channels.len(), self.with_variance)
    }

    /// The store, positioned at the beginning of a plane of a row.
    fn at(&self, row: usize, plane: usize) -> io::Result<MutexGuard<'_, Box<dyn Store>>> {
        let place = row as u64 * self.row_bytes() as u64 + (plane * self.size[0] * BYTES) as u64;
        let mut store = self.store.lock().expect("nobody panics while holding it");
        store.seek(SeekFrom::Start(place))?;
        Ok(store)
    }

    /// Writes the rows of a film into the store.
    pub fn write(&self, film: &Film) -> io::Result<()> {
        let mut store = self.at(film.image_rows().start, 0)?;
        for first in (0..film.height()).step_by(ROWS_AT_ONCE) {
            let rows = first..(first + ROWS_AT_ONCE).min(film.height());
            let bytes: Vec<Vec<u8>> = rows.into_par_iter().map(|row| self.row(film, row)).collect();
            bytes.iter().try_for_each(|row| store.write_all(row))?;
        }
        store.flush()
    }

    /// Bytes of a row of a film.
    fn row(&self, film: &Film, row: usize) -> Vec<u8> {
        let width = self.size[0];
        let mut bytes = vec![0; self.row_bytes()];
        for first in (0..width).step_by(PIXELS_AT_ONCE) {
            let pixels = row * width + first..row * width + (first + PIXELS_AT_ONCE).min(width);
            let mut planes =
                bytes.chunks_exact_mut(width * BYTES).map(|plane| plane[first * BYTES..].as_chunks_mut().0);
            let mut put = |values: &mut dyn Iterator<Item = [u8; BYTES]>| {
                planes.next().into_iter().flatten().zip(values).for_each(|(to, value)| *to = value);
            };
            put(&mut film.counts()[pixels.clone()].iter().map(|count| count.to_le_bytes()));
            for channel in 0..self.channels.len() {
                put(&mut film.means(channel, pixels.clone()).map(f32::to_le_bytes));
            }
            for channel in 0..self.with_variance {
                put(&mut film.variances(channel, pixels.clone()).map(f32::to_le_bytes));
            }
        }
        bytes
    }

    /// Passes the values of a plane of a row to `take`, column by column.
    fn read(&self, plane: usize, row: usize, mut take: impl FnMut(usize, [u8; BYTES])) -> io::Result<()> {
        let mut bytes = vec![0; self.size[0] * BYTES];
        self.at(row, plane)?.read_exact(&mut bytes)?;
        bytes.as_chunks().0.iter().enumerate().for_each(|(column, &number)| take(column, number));
        Ok(())
    }

    /// Samples of each pixel, row by row.
    pub fn counts(&self) -> io::Result<Vec<u32>> {
        let mut counts = Vec::with_capacity(self.size[0] * self.size[1]);
        for row in 0..self.size[1] {
            self.read(0, row, |_, number| counts.push(u32::from_le_bytes(number)))?;
        }
        Ok(counts)
    }

    /// Means of the channels `names`, to be read row by row. Names that the film lacks are left out.
    pub fn means<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> SomeRows<'_> {
        self.some(names, COUNTS)
    }

    /// Means and variances of some of the leading channels, in memory.
    pub fn estimate<'a>(&self, names: impl IntoIterator<Item = &'a str> + Clone) -> io::Result<Estimate> {
        let variances = self.some(names.clone(), COUNTS + self.channels.len());
        Ok(Estimate { mean: self.means(names).to_planes()?, variance: variances.to_planes()? })
    }

    fn some<'a>(&self, names: impl IntoIterator<Item = &'a str>, first: usize) -> SomeRows<'_> {
        let place = |name: &str| self.channels.iter().position(|channel| channel == name);
        let planes = names.into_iter().filter_map(place).map(|at| (&*self.channels[at], first + at)).collect();
        SomeRows { of: self, planes }
    }
}

/// Some planes of an image that is kept as rows.
pub struct SomeRows<'a> {
    of: &'a LightRows,
    /// Names of the planes, and their indices in a row.
    planes: Vec<(&'a str, usize)>,
}

impl SomeRows<'_> {
    /// Planes in memory.
    pub fn to_planes(&self) -> io::Result<Planes> {
        let [width, height] = self.size();
        let plane = |(at, &(name, _)): (usize, &(&str, usize))| {
            let mut data = vec![0.0; width * height];
            let mut rows = data.chunks_mut(width).enumerate();
            rows.try_for_each(|(row, to)| self.read_row(at, row, to))?;
            Ok(Channel { name: name.to_owned(), data })
        };
        let channels = self.planes.iter().enumerate().map(plane).collect::<io::Result<_>>()?;
        Planes::new(width, height, channels).map_err(|invalid| io::Error::other(invalid.message))
    }
}

impl ImageRows for SomeRows<'_> {
    fn size(&self) -> [usize; 2] {
        self.of.size
    }

    fn names(&self) -> Vec<&str> {
        self.planes.iter().map(|&(name, _)| name).collect()
    }

    fn read_row(&self, plane: usize, row: usize, to: &mut [f32]) -> io::Result<()> {
        let (_, place) = self.planes[plane];
        let is_variance = place >= COUNTS + self.of.channels.len();
        let level = if is_variance { self.of.level * self.of.level } else { self.of.level };
        self.of.read(place, row, |column, number| to[column] = level * f32::from_le_bytes(number))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use photosite_core::spectrum::{SampledSpectrum, Spectrum, WavelengthSampler};
    use photosite_transport::film::{FilmResponses, Response};

    const NAMES: [&str; 3] = ["R", "G", "550"];

    /// Rows of an image of 3 × 4 pixels, whose samples follow from their positions.
    fn film(rows: std::ops::Range<usize>) -> Film {
        let response = |name: &str| Response::new(name, Spectrum::from_fn(|l| l / (300.0 + 100.0 * name.len() as f64)));
        let mut film = Film::of_rows(3, rows.clone(), FilmResponses::new(&NAMES.map(response)));
        let sampler = WavelengthSampler::new(&Spectrum::constant(1.0));
        for (y, row) in rows.clone().zip(&mut film.bands(1)) {
            for i in 0..13 * (y + 1) {
                let light = SampledSpectrum::splat(0.1 + (i * i) as f32);
                row.add(i % 3, [[(light, &sampler.sample(i as f32 / 55.0))]]);
            }
        }
        film
    }

    #[test]
    fn rows_that_come_in_strips_are_those_of_a_film_of_all() {
        let whole = film(0..4);
        for height in 1..=4 {
            let store = Box::new(Cursor::new(Vec::new()));
            let rows = LightRows::new(store, [3, 4], NAMES.map(str::to_owned).into(), 2);
            // In any order.
            for first in (0..4).step_by(height).rev() {
                rows.write(&film(first..(first + height).min(4))).expect("written");
            }
            assert_eq!(rows.counts().expect("read"), whole.counts());
            assert_eq!(rows.estimate(["G", "absent"]).expect("read"), whole.estimate(["G"]));
            let bands = rows.means(["550", "R"]).to_planes().expect("read");
            assert_eq!(bands, whole.estimate(["550", "R"]).mean);
            // A quarter is exact.
            let less = rows.at_level(0.25);
            let expected = whole.estimate(["G"]);
            let found = less.estimate(["G"]).expect("read");
            assert_eq!(found.mean, expected.mean.scaled(0.25));
            assert_eq!(found.variance, expected.variance.scaled(0.0625));
        }
    }
}
