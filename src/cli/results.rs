//! What follows from exposed light: frames, their picture, files.

use std::time::Instant;

use photosite::Result;
use photosite::raw::RawImage;

use super::chain::{Chain, Exposed};
use super::output_folder::OutputFolder;
use super::report::Timings;

/// Reads out every frame and writes it; develops the first, which is returned. `write_light` writes what is left of the
/// light beside the electrons.
pub(super) fn write_results(
    chain: &Chain<'_>,
    exposed: &Exposed,
    folder: &mut OutputFolder,
    timings: &mut Timings,
    write_light: impl FnOnce(&mut OutputFolder) -> Result<()>,
) -> Result<RawImage> {
    let start = Instant::now();
    let first = chain.read_out(exposed, 0)?;
    timings.expose_s += start.elapsed().as_secs_f64();
    let start = Instant::now();
    let picture = chain.develop(&first)?;
    timings.develop_s = start.elapsed().as_secs_f64();

    let start = Instant::now();
    let mut reading_out = 0.0;
    folder.remove_earlier()?;
    let (output, frames) = (chain.settings.output, chain.settings.exposure.frames);
    folder.write_frame(output, (frames > 1).then_some(0), &first)?;
    // One after the other: a series may be larger than the memory.
    for frame in 1..frames {
        let start = Instant::now();
        let raw = chain.read_out(exposed, frame)?;
        reading_out += start.elapsed().as_secs_f64();
        folder.write_frame(output, Some(frame), &raw)?;
    }
    if output.electrons {
        folder.write_electrons(exposed)?;
    }
    write_light(folder)?;
    folder.write_picture(&picture)?;
    timings.expose_s += reading_out;
    timings.write_s = start.elapsed().as_secs_f64() - reading_out;
    Ok(first)
}
