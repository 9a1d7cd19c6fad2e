//! Strips of an image: the rows that are traced at a time.

use std::ops::Range;
use std::str::FromStr;

use super::memory_needs::{self, Needs};
use crate::camera::capture_camera::pixels;
use photosite_capture::Capture;
use photosite_core::memory;
use photosite_core::{Error, Invalid, Result};
use photosite_core::{Help, Remedy};
use photosite_transport::film::Film;

const GIB: f64 = (1u64 << 30) as f64;

/// Memory for the film of an image. The results do not depend on it, as they do not on the number of threads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmMemory {
    gib: f64,
}

impl FilmMemory {
    /// Memory of at most this many GiB, a number above 0: an image whose film needs more is traced in strips, one after
    /// the other.
    pub fn gib(gib: f64) -> Result<Self> {
        let message =
            || format!("{gib} GiB is not an amount of memory for a film; write a number above 0, for example 2.5");
        let usable = gib.is_finite() && gib > 0.0;
        if usable { Ok(Self { gib }) } else { Err(Error::Usage { message: message(), help: None }) }
    }

    /// Cuts an image whose film has this many channels into strips. Scarce memory makes them smaller than was asked
    /// for, and refuses an image that takes more even in strips of the fewest rows. `is_exposed` unless sums alone are
    /// kept; `is_filed` where the rows of several strips lie in a file.
    pub(crate) fn strips(
        self,
        capture: &Capture,
        channels: usize,
        [is_exposed, is_filed]: [bool; 2],
    ) -> Result<Strips> {
        let [width, height] = pixels(capture).map(|n| n as usize);
        let pilot = capture.render().noise_target.map(|_| capture.sensor().cfa.channels().len());
        let row = width * (Film::bytes_per_pixel(channels) + pilot.map_or(0, Film::bytes_per_pixel));
        memory_needs::check_scene(capture.scene(), capture.source())?;
        let (needs, scene, left) = (Needs::of(capture), memory_needs::of_scene(capture.scene()), memory::left());
        let beside = scene.saturating_add(needs.beside_film());
        let rows = if is_exposed { needs.rows(channels) } else { 0 };
        let film = (row * height) as u64;
        let whole = beside.saturating_add(film).saturating_add(rows);
        let scarce = left.filter(|left| whole > left.bytes());
        let kept = |most: usize| if is_filed && most < height { 0 } else { rows };
        // The conversion saturates at the largest number.
        let mut most = ((self.gib * GIB) as usize / row).clamp(1, height);
        if let Some(left) = scarce {
            let for_film = left.bytes().saturating_sub(beside.saturating_add(kept(0)));
            most = most.min(usize::try_from(for_film).unwrap_or(usize::MAX) / row);
            // All rows in one would not lie in a file.
            most = most.clamp(1, (height - 1).max(1));
        }
        let limit = [
            ("noise_target", capture.render().noise_target.is_some()),
            ("time_limit_s", capture.render().time_limit_s.is_some()),
        ];
        if let Some((key, _)) = limit.into_iter().find(|(_, is_given)| *is_given && most < height) {
            let instead = "write samples_per_pixel in its place";
            let in_render = |invalid: Invalid| capture.source().error(invalid.within(key).within("render"));
            if let Some(left) = scarce {
                left.check(whole, "the film of the whole image", instead).map_err(in_render)?;
            }
            let needed = (film as f64 / GIB * 10.0).ceil().max(1.0) / 10.0;
            let message = format!("takes the film of the whole image, {needed} GiB; {} are allowed", self.gib);
            let help = Help::any([Remedy::FilmMemory(needed.to_string()), instead.into()]);
            return Err(in_render(Invalid::new("", message).help(help)));
        }
        if let Some(left) = left {
            let tracing = beside.saturating_add((row * most) as u64);
            let exposing = if is_exposed { scene.saturating_add(needs.exposing()) } else { 0 };
            needs.check(left, tracing.max(exposing).saturating_add(kept(most)))?;
        }
        Ok(Strips { most, height, first: None })
    }
}

impl FromStr for FilmMemory {
    type Err = Error;

    /// Memory by its number of GiB.
    fn from_str(text: &str) -> Result<Self> {
        Self::gib(text.parse().unwrap_or(f64::NAN))
    }
}

impl Default for FilmMemory {
    /// Memory of 4 GiB.
    fn default() -> Self {
        Self { gib: 4.0 }
    }
}

/// Strips of rows that are traced one after the other; one of all rows where memory allows it.
#[derive(Clone, Debug)]
pub(crate) struct Strips {
    most: usize,
    height: usize,
    /// First strip, where it was begun with other memory.
    first: Option<Range<usize>>,
}

impl Strips {
    /// Whether there is more than one strip.
    pub(crate) fn are_several(&self) -> bool {
        let is_cut = |rows: &Range<usize>| rows.start > 0 || (1..self.height).contains(&rows.end);
        self.most < self.height || self.first.as_ref().is_some_and(is_cut)
    }

    /// Whether memory holds the film of these rows.
    pub(crate) fn hold(&self, rows: &Range<usize>) -> bool {
        rows.end <= self.height && rows.len() <= self.most
    }

    /// Goes on with these rows.
    pub(crate) fn going_on(self, rows: Range<usize>) -> Self {
        Self { first: Some(rows), ..self }
    }

    /// The strips from a row on.
    pub(crate) fn from(&self, first: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let Self { most, height, .. } = *self;
        let begun = self.first.clone().filter(|rows| rows.start == first && !rows.is_empty());
        let next = begun.as_ref().map_or(first, |rows| rows.end);
        let rest = (next..height).step_by(most).map(move |first| first..(first + most).min(height));
        begun.into_iter().chain(rest)
    }
}
