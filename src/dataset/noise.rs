//! How noisy the pictures of a data set are: Monte Carlo noise beside that of the sensor, and what would lessen it.

use serde::Serialize;

use crate::math::float::rounded;
use crate::report::RenderReport;
use crate::report::noise_words::{UNSEEN, times, together};

/// The ratio that is asked for with `render.noise_target`: both together are 2 % more than the sensor's alone.
const TARGET: f64 = 0.2;

/// Monte Carlo noise over the sensor's, of the pictures of a data set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SetNoise {
    /// The ratio of the picture in the middle, or between the two that are; `None` where no picture tells it.
    pub median: Option<f64>,
    /// The ratio of the noisiest picture.
    pub worst: Option<f64>,
    /// The name of the noisiest picture.
    pub worst_picture: Option<String>,
    /// How many pictures do not tell it: those of a single sample a pixel, and those without light.
    pub unknown: usize,
    /// Samples a pixel with which the median would be as large as the sensor's noise, and a fifth of it; `None` where
    /// pictures have a noise target.
    #[serde(skip)]
    samples: Option<[f64; 2]>,
}

/// What is known of one picture.
struct Known {
    ratio: f64,
    /// Samples a pixel at which its noise would be that of the sensor.
    equal: f64,
    picture: String,
}

impl SetNoise {
    /// The noise of pictures by their names.
    pub(super) fn of<'a>(pictures: impl IntoIterator<Item = (String, Option<&'a RenderReport>)>) -> Self {
        let (mut known, mut unknown, mut has_target) = (Vec::new(), 0, false);
        for (picture, render) in pictures {
            has_target |= render.is_some_and(|render| render.noise.is_some());
            match render.and_then(|render| Some((render, render.noise_ratio?))) {
                Some((render, ratio)) => {
                    let equal = f64::from(render.samples_per_pixel) * ratio.powi(2);
                    known.push(Known { ratio, equal, picture });
                }
                None => unknown += 1,
            }
        }
        known.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
        let worst = known.last();
        let equal = median(known.iter().map(|known| known.equal)).filter(|_| !has_target);
        Self {
            median: median(known.iter().map(|known| known.ratio)),
            worst: worst.map(|known| known.ratio),
            worst_picture: worst.map(|known| known.picture.clone()),
            unknown,
            samples: equal.map(|equal| [equal, equal / TARGET.powi(2)]),
        }
    }

    /// What a user must know of it; `None` of a set without pictures.
    pub fn in_words(&self) -> Option<String> {
        let Self { median, worst, worst_picture, unknown, .. } = self;
        let untold = "a single sample of each pixel, or the dark, does not tell it";
        let (Some(median), Some(worst), Some(picture)) = (median, worst, worst_picture) else {
            return (*unknown > 0).then(|| {
                format!("Monte Carlo noise is not known: {untold}; --set render.samples_per_pixel=2 or more does")
            });
        };
        let of = "that of the sensor in the median picture";
        let mut said = format!("Monte Carlo noise is {} {of} and {} in {picture}", times(*median), times(*worst));
        if *worst <= UNSEEN {
            said += ": it is not seen";
        } else {
            said += &format!(": {} in the median picture", together(*median));
        }
        if let Some(remedy) = self.remedy(*median) {
            said += &format!("; {remedy}");
        }
        if *unknown > 0 {
            said += &format!("; of {unknown} pictures it is not known, as {untold}");
        }
        Some(said)
    }

    /// What would lessen the noise of a median that is seen.
    fn remedy(&self, median: f64) -> Option<String> {
        let [equal, little] = self.samples?.map(|samples| rounded(samples.ceil(), 2));
        let key = "--set render.samples_per_pixel";
        let fifth = format!("{key}={little} would bring it to a fifth of the sensor's there");
        match median {
            ..=TARGET => None,
            ..=1.0 => Some(fifth),
            _ => Some(format!(
                "{key}={equal} would make them equal there, and {little} bring it to a fifth of the sensor's"
            )),
        }
        .map(|words| {
            format!("{words}; --set render.noise_target={TARGET} beside it ends each pixel that is there already")
        })
    }
}

/// The middle of numbers, or the mean of the two that are there.
fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = numbers.collect();
    sorted.sort_by(f64::total_cmp);
    let [below, above] = [sorted.len().checked_sub(1)? / 2, sorted.len() / 2].map(|at| sorted.get(at).copied());
    Some(f64::midpoint(below?, above?))
}
