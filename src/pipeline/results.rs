//! What follows from exposed light: frames or the pictures of a bracket, what is developed of them, files.

use std::sync::Arc;
use std::time::Instant;

use crate::Result;
use crate::develop::merge::merge;
use crate::image::{Estimate, Planes};
use crate::raw::RawImage;
use crate::sensor::Exposure;
use crate::units::{Decibels, Seconds};

use super::carried::Carried;
use super::chain::{Chain, Exposed};
use super::monitor::{Monitor, go_on};
use super::output_folder::OutputFolder;
use crate::report::Timings;

/// Which frames of a series see the light.
#[derive(Clone, Copy)]
pub(super) enum Frames {
    /// So many, all of them.
    All(u32),
    /// The one of this number, out of a series of so many in which each has light of its own.
    One { number: u32, of: u32 },
}

impl Frames {
    /// Numbers of the frames, and whether they are part of their files' names.
    pub(super) fn numbers(self) -> (std::ops::Range<u32>, bool) {
        match self {
            Self::All(count) => (0..count, count > 1),
            Self::One { number, of } => (number..number + 1, of > 1),
        }
    }

    /// Whether these are the first of their series, or the only one.
    pub(super) fn begin(self) -> bool {
        match self {
            Self::All(_) | Self::One { number: 0, .. } | Self::One { of: ..=1, .. } => true,
            Self::One { .. } => false,
        }
    }

    /// The number in the names of files of light, where each frame has light of its own.
    pub(super) fn light_number(self) -> Option<u32> {
        match self {
            Self::One { number, of } if of > 1 => Some(number),
            Self::All(_) | Self::One { .. } => None,
        }
    }
}

/// A series so far.
#[derive(Default)]
pub(super) struct SeriesState {
    /// State after its last frame.
    carried: Carried,
    /// Gains of its frames, where there is gain control.
    pub(super) gains: Vec<Decibels>,
}

/// Reads out the frames, or a picture for each time of a bracket, and writes them; develops the first, or the one of a
/// bracket whose time is nearest to that of `exposed`, which is returned; merges a bracket to a map of the light.
/// `write_light` writes what is left of the light beside the electrons, numbered where there are several.
///
/// `state` is that of the series so far, and then with these frames: the images of a bracket are taken one after the
/// other, too.
///
/// Raw files and light are there before anything is developed: they take the longest to get, whatever becomes of the
/// development, and the light's memory is free again.
#[expect(clippy::too_many_arguments, reason = "an exposure, where it goes, and what it hands on")]
pub(super) fn write_results(
    monitor: &dyn Monitor,
    chain: &Chain<'_>,
    exposed: Exposed,
    frames: Frames,
    folder: &mut OutputFolder,
    timings: &mut Timings,
    state: &mut SeriesState,
    write_light: impl FnOnce(&mut OutputFolder, Option<u32>) -> Result<()>,
) -> Result<RawImage> {
    let output = chain.settings.output;
    let times = chain.bracket(&exposed)?;
    let (numbers, are_named) = match &times {
        Some(times) => (0..times.len() as u32, true),
        None => frames.numbers(),
    };
    let light_number = frames.light_number();
    // One after the other: a series may be larger than the memory. Those of a bracket are needed together.
    let mut kept = Vec::new();
    let first = numbers.start;
    for number in numbers {
        go_on(monitor)?;
        let start = Instant::now();
        let mut read_out = |exposed| chain.read_out_next(exposed, number, &output.noise.maps, &mut state.carried);
        let (raw, maps, taken) = match &times {
            Some(times) => read_out(&shot(&exposed, times[number as usize]))?,
            None => read_out(&exposed)?,
        };
        if chain.settings.exposure.gain_control.is_some() {
            state.gains.push(taken.gain);
        }
        timings.expose_s += start.elapsed().as_secs_f64();
        let start = Instant::now();
        if number == first && frames.begin() {
            folder.remove_earlier()?;
        }
        folder.write_frame(output, are_named.then_some(number), &raw)?;
        folder.write_noise(are_named.then_some(number), &output.noise, &maps)?;
        timings.write_s += start.elapsed().as_secs_f64();
        if number == first || times.is_some() {
            kept.push(raw);
        }
    }
    let start = Instant::now();
    if output.electrons {
        folder.write_electrons(light_number, &exposed)?;
    }
    write_light(folder, light_number)?;
    timings.write_s += start.elapsed().as_secs_f64();
    let distance = |time: Seconds| (time.0 / exposed.exposure.time.0).ln().abs();
    let times = times.unwrap_or_default();
    let shown = (0..times.len()).min_by(|&a, &b| distance(times[a]).total_cmp(&distance(times[b]))).unwrap_or(0);
    drop(exposed);

    if times.len() > 1 {
        let start = Instant::now();
        let merged = merge(&kept).map_err(|invalid| chain.in_exposure(invalid))?;
        let longest = Seconds(merged.times_s[1]);
        let (light, pixel_aspect) = chain.develop_merged(merged)?;
        timings.develop_s += start.elapsed().as_secs_f64();
        let start = Instant::now();
        folder.write_hdr(&light, chain.settings.develop.colour_space, pixel_aspect, longest)?;
        timings.write_s += start.elapsed().as_secs_f64();
    }
    let start = Instant::now();
    let raw = kept.swap_remove(shown);
    if output.image {
        let picture = chain.develop(&raw)?;
        timings.develop_s += start.elapsed().as_secs_f64();
        let start = Instant::now();
        folder.write_picture(light_number, &picture)?;
        timings.write_s += start.elapsed().as_secs_f64();
    }
    Ok(raw)
}

/// The light of an exposure, collected for another time.
fn shot(exposed: &Exposed, time: Seconds) -> Exposed {
    let mean = exposed.electrons.mean.clone().scaled(time.0 / exposed.exposure.time.0);
    // No picture needs the variance.
    let variance = Planes::zeros::<&str>(mean.width(), mean.height(), []);
    let electrons = Arc::new(Estimate { mean, variance });
    Exposed { exposure: Exposure { time, ..exposed.exposure }, electrons, warnings: Vec::new() }
}
