//! The fit of a sensor's parameters to the images of a camera.

use photosite_core::Result;
use photosite_core::units::{Celsius, Seconds};

use super::dark_model::{DarkFrames, DarkModel};
use super::defects::{Defect, replacements};
use super::frame_group::CameraFrames;
use super::frame_stack::StackStatistics;
use super::measured::Measured;
use super::parameters::{Assumption, FittedGainStep, KnownFacts, Parameter};
use super::pattern_maps::PatternMaps;
use super::patterns::{Averages, MendedFrames, Patterns};
use super::photon_transfer::{PhotonTransfer, TransferPoint};
use super::read_noise_shape::{FEWEST_IMAGES, Found, OtherNoise, ReadNoiseShape};
use super::sheet::Sheet;
use super::survey::Survey;
use crate::characterisation::NotMeasured;

/// Sensor fitted to the images of a camera.
#[derive(Clone, Debug)]
pub struct CameraFit {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Bits of the numbers.
    pub bits: u32,
    /// Parameters that the images tell.
    pub parameters: Vec<Parameter>,
    /// Keys that had to be assumed.
    pub assumed: Vec<Assumption>,
    /// Figures that the images do not tell, and why.
    pub left_out: Vec<NotMeasured>,
    /// Statements about the images: light that drifts, images that nothing goes with.
    pub notes: Vec<String>,
    /// Measured patterns of the pixels.
    pub maps: PatternMaps,
    /// Pixels that do not work as the others.
    pub defects: Vec<Defect>,
    /// Photon transfer curve.
    pub transfer: PhotonTransfer,
    /// Dark signal and noise.
    pub dark: DarkModel,
    /// Dark currents at the temperatures that were measured, in DN/s.
    pub dark_currents: Vec<(Option<Celsius>, Measured)>,
    /// Noise of the read-out at several gains, in their order; none of images of one gain.
    pub gain_steps: Vec<FittedGainStep>,
}

/// Fits a sensor to images of a camera.
///
/// # Errors
///
/// Images that cannot be read, that are of another size or another camera, or of which none are dark.
pub fn fit_camera(frames: &CameraFrames<'_>, known: &KnownFacts) -> Result<CameraFit> {
    let mut mended = MendedFrames { frames, replacements: Vec::new() };
    let mut survey = Survey::new(&mended)?;
    let mut averages = averages_of(&mended, &survey)?;
    let (defects, hot) = averages.defects(frames.size[0]);
    if !defects.is_empty() {
        mended.replacements = replacements(&defects, frames.size[0]);
        survey = Survey::new(&mended)?;
        averages = averages_of(&mended, &survey)?;
    }
    let patterns = averages.patterns(frames.size);
    let maps = PatternMaps::new(&averages, &patterns, survey.transfer.told_bend(), frames.size);
    let notes = survey.notes(frames);
    let mut sheet = Sheet::new(known, &survey);
    let shape = read_noise_shape(&mended, &survey, &patterns, sheet.system_gain())?;
    sheet.fill(&survey, shape, &patterns, &defects, hot, frames);
    let Patterns { response, dark, .. } = &patterns;
    sheet.tell_shading(dark, response.as_ref());
    let dark_currents = survey.dark_currents();
    let Survey { dark, transfer, .. } = survey;
    let Sheet { parameters, assumed, left_out, .. } = sheet;
    let (size, bits) = (frames.size, frames.bits);
    let gain_steps = Vec::new();
    Ok(CameraFit {
        size,
        bits,
        parameters,
        assumed,
        left_out,
        notes,
        maps,
        defects,
        transfer,
        dark,
        dark_currents,
        gain_steps,
    })
}

/// Shape of the read noise in the shortest dark images of which there are enough, where the dark current adds least.
fn read_noise_shape(
    frames: &MendedFrames<'_>,
    survey: &Survey,
    patterns: &Patterns,
    system_gain: Option<f64>,
) -> Result<Found> {
    /// Part of the noise that may be the dark current's where K, and so its distribution, is not known.
    const MOST_OF_DARK_CURRENT: f64 = 0.05;
    let seconds = |frames: &DarkFrames| frames.time.map_or(0.0, |time| time.0);
    let enough = survey.dark.frames().iter().zip(&survey.dark_groups);
    let enough = enough.filter(|(frames, _)| frames.statistics.images >= FEWEST_IMAGES);
    let Some((dark, &group)) = enough.min_by(|(a, _), (b, _)| seconds(a).total_cmp(&seconds(b))) else {
        return Ok(Err("four dark images of one exposure time would tell it".to_owned()));
    };
    let variance = match (dark.time, survey.dark.variance) {
        (Some(time), Some(line)) if line.slope.value > 0.0 => line.slope.times(time.0),
        _ => Measured::default(),
    };
    if system_gain.is_none() && variance.value > MOST_OF_DARK_CURRENT * dark.statistics.temporal.pixel.value {
        let reason = "without a system gain, which flats would tell, the noise of the dark current is not told from it";
        return Ok(Err(reason.to_owned()));
    }
    let rise = patterns.rise.as_ref().map_or(0.0, |rise| rise.variances.pixel.value.max(0.0).sqrt());
    let other = OtherNoise::of_dark_current(variance, rise * seconds(dark), system_gain.unwrap_or(1.0));
    ReadNoiseShape::of(frames, group, other)
}

/// Averages of the images that tell the patterns.
fn averages_of(frames: &MendedFrames<'_>, survey: &Survey) -> Result<Averages> {
    let left = |s: &StackStatistics| s.temporal.map(|v| v.times(1.0 / s.images as f64));
    let reference = survey.dark_reference();
    let dark_statistics = &survey.dark.frames()[reference].statistics;
    let dark_stack = frames.stack(survey.dark_groups[reference])?;
    let mut is_constant: Vec<bool> = dark_stack.pixel_variances().map(|variance| variance == 0.0).collect();
    let dark = dark_stack.average();
    let response = match survey.transfer.clearest() {
        Some(TransferPoint { group, .. }) => {
            let (group, time) = (*group, frames.frames.groups[*group].time);
            let bright = frames.stack(group)?;
            let still = bright.pixel_variances().map(|variance| variance == 0.0);
            is_constant.iter_mut().zip(still).for_each(|(constant, still)| *constant &= still);
            let beside = beside(survey, time).unwrap_or(reference);
            let dark_beside =
                if beside == reference { None } else { Some(frames.stack(survey.dark_groups[beside])?.average()) };
            let dark_beside = dark_beside.as_ref().unwrap_or(&dark);
            let difference = bright.average().iter().zip(dark_beside).map(|(b, d)| b - d).collect();
            let noise = survey.statistics[group].as_ref().map(left).unwrap_or_default();
            Some((difference, noise.plus(left(&survey.dark.frames()[beside].statistics))))
        }
        None => None,
    };
    let timed = |(frames, &group): (_, &usize)| {
        let DarkFrames { time, statistics }: &DarkFrames = frames;
        Some((group, (*time)?.0, statistics))
    };
    let timed: Option<Vec<_>> = survey.dark.frames().iter().zip(&survey.dark_groups).map(timed).collect();
    let lines = match timed.filter(|_| survey.dark.mean.is_some()) {
        Some(timed) => Some(frames.lines(&timed)?),
        None => None,
    };
    Ok(Averages {
        dark_noise: left(dark_statistics),
        dark_images: dark_statistics.images,
        dark_time: survey.reference_time().unwrap_or(0.0),
        dark,
        response,
        lines,
        is_constant,
    })
}

/// Dark images with the most images of an exposure time.
fn beside(survey: &Survey, time: Option<Seconds>) -> Option<usize> {
    let frames = survey.dark.frames().iter().enumerate().filter(|(_, f)| f.time == time);
    frames.max_by_key(|(_, f)| f.statistics.images).map(|(i, _)| i)
}
