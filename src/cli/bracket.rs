//! A bracket: the same light exposed for different times, and what the pictures say of it together.

use std::time::Instant;

use photosite::Result;
use photosite::develop::merge::merge;
use photosite::image::{Estimate, Planes};
use photosite::raw::RawImage;
use photosite::sensor::Exposure;
use photosite::units::Seconds;

use super::chain::{Chain, Exposed};
use super::output_folder::OutputFolder;
use super::report::Timings;

/// Reads out a picture for each of the times and writes it; develops and returns the one whose time is nearest to that of
/// `exposed`; merges all to a map of the light. `write_light` writes what is left of the light beside the electrons.
pub(super) fn write_bracket(
    chain: &Chain<'_>,
    exposed: &Exposed,
    times: &[Seconds],
    folder: &mut OutputFolder,
    timings: &mut Timings,
    write_light: impl FnOnce(&mut OutputFolder) -> Result<()>,
) -> Result<RawImage> {
    let output = chain.settings.output;
    let mut pictures = Vec::new();
    for (frame, &time) in (0..).zip(times) {
        let start = Instant::now();
        pictures.push(chain.read_out(&shot(exposed, time), frame)?);
        timings.expose_s += start.elapsed().as_secs_f64();
    }
    let distance = |time: Seconds| (time.0 / exposed.exposure.time.0).ln().abs();
    let nearest = (0..times.len()).min_by(|&a, &b| distance(times[a]).total_cmp(&distance(times[b]))).unwrap_or(0);
    let start = Instant::now();
    let picture = chain.develop(&pictures[nearest])?;
    let merged = merge(&pictures).map_err(|invalid| chain.in_exposure(invalid))?;
    let longest = Seconds(merged.times_s[1]);
    let light = chain.develop_merged(merged)?;
    timings.develop_s += start.elapsed().as_secs_f64();

    let start = Instant::now();
    folder.remove_earlier()?;
    for (frame, raw) in (0..).zip(&pictures) {
        folder.write_frame(output, Some(frame), raw)?;
    }
    folder.write_hdr(&light, chain.settings.develop.colour_space, longest)?;
    if output.electrons {
        folder.write_electrons(None, exposed)?;
    }
    write_light(folder)?;
    folder.write_picture(None, &picture)?;
    timings.write_s += start.elapsed().as_secs_f64();
    Ok(pictures.swap_remove(nearest))
}

/// The same light, collected for another time.
fn shot(exposed: &Exposed, time: Seconds) -> Exposed {
    let mean = exposed.electrons.mean.clone().scaled(time.0 / exposed.exposure.time.0);
    // No picture needs the variance.
    let variance = Planes::zeros::<&str>(mean.width(), mean.height(), []);
    Exposed { exposure: Exposure { time, ..exposed.exposure }, electrons: Estimate { mean, variance } }
}
