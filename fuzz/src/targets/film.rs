//! `film.npy`, the sums of a part, and the same of a checkpoint.

use photosite::film::{Film, FilmResponses, Response};
use photosite::io::film_file::{FilmReader, add_unfinished, read_samples};
use photosite::spectrum::Spectrum;

/// Columns and rows.
const SIZE: [usize; 2] = [3, 2];

pub(crate) fn target(data: &[u8]) {
    let empty = || Film::new(SIZE[0], SIZE[1], FilmResponses::new(&[Response::new("A", Spectrum::constant(1.0))]));
    if let Ok(mut sums) = FilmReader::new(SIZE, 1, data) {
        let _ = sums.add_to(&mut empty(), 7);
    }
    let _ = read_samples(SIZE, data);
    let _ = add_unfinished(&mut empty(), data);
}
