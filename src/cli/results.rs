//! What follows from exposed light: frames, their picture, files.

use std::time::Instant;

use photosite::Result;
use photosite::raw::RawImage;

use super::bracket::write_bracket;
use super::chain::{Chain, Exposed};
use super::output_folder::OutputFolder;
use super::report::Timings;

/// Which frames of a series see the light.
#[derive(Clone, Copy)]
pub(super) enum Frames {
    /// So many, all of them.
    All(u32),
    /// The one of this number, out of a series of so many in which each has light of its own.
    One { number: u32, of: u32 },
}

/// Reads out the frames and writes them, or those of a bracket; develops the first, which is returned. `write_light` writes
/// what is left of the light beside the electrons, numbered where there are several.
///
/// Raw files and light are there before anything is developed: they take the longest to get, whatever becomes of the
/// development, and the light's memory is free again.
pub(super) fn write_results(
    chain: &Chain<'_>,
    exposed: Exposed,
    frames: Frames,
    folder: &mut OutputFolder,
    timings: &mut Timings,
    write_light: impl FnOnce(&mut OutputFolder, Option<u32>) -> Result<()>,
) -> Result<RawImage> {
    if let Some(times) = chain.bracket(&exposed)? {
        return write_bracket(chain, &exposed, &times, folder, timings, |folder| write_light(folder, None));
    }
    let (first_frame, light_number, raw_number, more) = match frames {
        Frames::All(1) => (0, None, None, 1..1),
        Frames::All(count) => (0, None, Some(0), 1..count),
        Frames::One { number, of: 1 } => (number, None, None, 1..1),
        Frames::One { number, .. } => (number, Some(number), Some(number), 1..1),
    };
    let start = Instant::now();
    let first = chain.read_out(&exposed, first_frame)?;
    timings.expose_s += start.elapsed().as_secs_f64();

    let start = Instant::now();
    let mut reading_out = 0.0;
    if first_frame == 0 {
        folder.remove_earlier()?;
    }
    let output = chain.settings.output;
    folder.write_frame(output, raw_number, &first)?;
    // One after the other: a series may be larger than the memory.
    for frame in more {
        let start = Instant::now();
        let raw = chain.read_out(&exposed, frame)?;
        reading_out += start.elapsed().as_secs_f64();
        folder.write_frame(output, Some(frame), &raw)?;
    }
    if output.electrons {
        folder.write_electrons(light_number, &exposed)?;
    }
    write_light(folder, light_number)?;
    drop(exposed);
    timings.expose_s += reading_out;
    timings.write_s += start.elapsed().as_secs_f64() - reading_out;

    let start = Instant::now();
    let picture = chain.develop(&first)?;
    timings.develop_s += start.elapsed().as_secs_f64();
    let start = Instant::now();
    folder.write_picture(light_number, &picture)?;
    timings.write_s += start.elapsed().as_secs_f64();
    Ok(first)
}
