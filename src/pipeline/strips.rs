//! How much of a picture is traced at a time.

use photosite_core::{Help, Remedy};
use std::ops::Range;

use super::camera::pixels;
use crate::capture::Capture;
use crate::film::Film;
use crate::{Error, Invalid, Result};

const GIB: f64 = (1u64 << 30) as f64;

/// Memory for the film of a picture. The results do not depend on it, as they do not on the number of threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmMemory {
    gib: f64,
}

impl FilmMemory {
    /// At most so many GiB, a number above 0: a picture whose film needs more is traced in strips, one after the other.
    pub fn gib(gib: f64) -> Result<Self> {
        let message = || format!("{gib} GiB is no memory for a film; write a number above 0, for example 2.5");
        let usable = gib.is_finite() && gib > 0.0;
        if usable { Ok(Self { gib }) } else { Err(Error::Usage { message: message(), help: None }) }
    }

    /// The strips of a picture whose film has so many channels.
    pub(super) fn strips(self, capture: &Capture, channels: usize) -> Result<Strips> {
        let [width, height] = pixels(capture).map(|n| n as usize);
        let with_pilot = match capture.render.noise_target {
            Some(_) => capture.sensor.cfa.channels().len(),
            None => 0,
        };
        let mut row = width * Film::bytes_per_pixel(channels);
        if with_pilot > 0 {
            row += width * Film::bytes_per_pixel(with_pilot);
        }
        // The conversion saturates at the largest number.
        let most = ((self.gib * GIB) as usize / row.max(1)).clamp(1, height);
        let limit = [
            ("noise_target", capture.render.noise_target.is_some()),
            ("time_limit_s", capture.render.time_limit.is_some()),
        ];
        match limit.into_iter().find(|(_, is_given)| *is_given && most < height) {
            None => Ok(Strips { most: whole_groups(most, height, capture), height }),
            Some((key, _)) => {
                let needed = ((row * height) as f64 / GIB * 10.0).ceil().max(1.0) / 10.0;
                let message = format!("takes the film of the whole picture, {needed} GiB; {} are allowed", self.gib);
                let help =
                    Help::any([Remedy::FilmMemory(needed.to_string()), "write samples_per_pixel in its place".into()]);
                Err(capture.source.error(Invalid::new(key, message).help(help).within("render")))
            }
        }
    }
}

impl Default for FilmMemory {
    /// 4 GiB.
    fn default() -> Self {
        Self { gib: 4.0 }
    }
}

/// At most so many rows of a picture, unless it fits in, in which no group of pixels that share is cut.
fn whole_groups(most: usize, height: usize, capture: &Capture) -> usize {
    let [_, rows] = capture.render.reuse_columns_and_rows();
    if most < height { (most / rows).max(1) * rows } else { most }
}

/// Strips of rows that are traced one after the other; one of all rows where memory allows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strips {
    most: usize,
    height: usize,
}

impl Strips {
    /// Whether there is more than one.
    pub(super) fn are_several(self) -> bool {
        self.most < self.height
    }

    /// The strips from a row on.
    pub(super) fn from(self, first: usize) -> impl Iterator<Item = Range<usize>> {
        (first..self.height).step_by(self.most).map(move |first| first..(first + self.most).min(self.height))
    }
}
