//! Results of exposed light: frames or the images of a bracket, developed images, files.

use std::time::Instant;

use photosite_core::Result;
use photosite_core::units::Seconds;
use photosite_develop::merge::merge;
use photosite_raw::RawImage;

use crate::expose::chain::CollectedElectrons;
use crate::expose::frame_series::FrameSeries;
use crate::monitor::{Event, Monitor, go_on};
use crate::write::output_folder::OutputFolder;
use photosite_capture::report::Timings;

/// Frames of a series that see the light.
#[derive(Clone, Copy)]
pub(crate) enum Frames {
    /// All frames, of this number.
    All(u32),
    /// Frame of this number, out of a series of `of` frames in which each has light of its own.
    One { number: u32, of: u32 },
}

impl Frames {
    /// Number of the first frame.
    pub(crate) fn first(self) -> u32 {
        match self {
            Self::All(_) => 0,
            Self::One { number, .. } => number,
        }
    }

    /// Whether these are the first of their series, or the only one.
    pub(crate) fn begin(self) -> bool {
        match self {
            Self::All(_) | Self::One { number: 0, .. } | Self::One { of: ..=1, .. } => true,
            Self::One { .. } => false,
        }
    }

    /// Number in the names of files of light, where each frame has light of its own.
    pub(crate) fn light_number(self) -> Option<u32> {
        match self {
            Self::One { number, of } if of > 1 => Some(number),
            Self::All(_) | Self::One { .. } => None,
        }
    }
}

/// A series on its way into a folder.
pub(crate) struct Results<'a> {
    pub(crate) series: FrameSeries<'a>,
    pub(crate) folder: &'a mut OutputFolder,
    pub(crate) timings: &'a mut Timings,
    pub(crate) monitor: &'a dyn Monitor,
    /// Name of the card that has exposed the first frame, or the warning that the processor has; `None` without a card.
    pub(crate) device: Option<Result<String, String>>,
}

impl Results<'_> {
    /// Reads out the frames, or an image for each time of a bracket, and writes them; develops the first, or the one of
    /// a bracket whose time is nearest to that of `exposed`, which is returned; merges a bracket to a map of the light.
    /// `write_light` writes what is left of the light beside the electrons, numbered where there are several.
    ///
    /// Raw files and light are there before anything is developed: they take the longest to get, whatever becomes of
    /// the development, and the light's memory is free again.
    pub(crate) fn write(
        &mut self,
        exposed: CollectedElectrons,
        frames: Frames,
        write_light: impl FnOnce(&mut OutputFolder, Option<u32>) -> Result<()>,
    ) -> Result<RawImage> {
        let Self { series, folder, timings, monitor, device } = self;
        let chain = series.chain;
        let output = chain.settings.output;
        series.see(exposed)?;
        let times = series.times.clone().unwrap_or_default();
        let (count, are_named) = match frames {
            _ if !times.is_empty() => (times.len() as u32, true),
            Frames::All(count) => (count, count > 1),
            Frames::One { of, .. } => (1, of > 1),
        };
        // One after the other: a series may be larger than the memory. Those of a bracket are needed together.
        let mut kept = Vec::new();
        for _ in 0..count {
            go_on(*monitor)?;
            let start = Instant::now();
            let frame = series.next().expect("there is light for all")?;
            timings.expose_s += start.elapsed().as_secs_f64();
            if device.is_none() {
                if let Some(Err(warning)) = &frame.device {
                    monitor.report(Event::Warning(warning));
                }
                device.clone_from(&frame.device);
            }
            let start = Instant::now();
            if kept.is_empty() && frames.begin() {
                folder.remove_earlier()?;
            }
            let number = are_named.then_some(frame.number);
            folder.write_frame(output, number, &frame.raw)?;
            folder.write_noise(number, &output.noise, &frame.maps)?;
            timings.write_s += start.elapsed().as_secs_f64();
            if kept.is_empty() || !times.is_empty() {
                kept.push(frame.raw);
            }
        }
        let start = Instant::now();
        let exposed = series.light.take().expect("it was given above");
        if output.electrons {
            folder.write_electrons(frames.light_number(), &exposed)?;
        }
        write_light(folder, frames.light_number())?;
        timings.write_s += start.elapsed().as_secs_f64();
        let distance = |time: Seconds| (time.0 / exposed.exposure.time.0).ln().abs();
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
            let (image, warning) = chain.develop_with(&raw, chain.settings.develop)?;
            warning.iter().for_each(|words| monitor.report(Event::Warning(words)));
            timings.develop_s += start.elapsed().as_secs_f64();
            let start = Instant::now();
            folder.write_image(frames.light_number(), &image)?;
            timings.write_s += start.elapsed().as_secs_f64();
        }
        Ok(raw)
    }
}
