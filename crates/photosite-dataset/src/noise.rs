//! Monte Carlo noise of a data set's images relative to the sensor's noise, and settings that would lessen it.

use serde::Serialize;

use photosite_capture::report::RenderReport;
use photosite_capture::report::noise_words::{UNSEEN, times, together};
use photosite_core::math::float::rounded;

/// Recommended `render.noise_target`: both kinds of noise together are 2 % more than the sensor's alone.
const TARGET: f64 = 0.2;

/// Ratio of Monte Carlo noise to the sensor's noise in the images of a data set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SetNoise {
    /// Median ratio of the images; `None` where no image has one.
    pub median: Option<f64>,
    /// Ratio of the noisiest image.
    pub worst: Option<f64>,
    /// Name of the noisiest image.
    pub worst_picture: Option<String>,
    /// Number of images without a ratio: those of a single sample per pixel, those without light, and those that are all
    /// saturated.
    pub unknown: usize,
    /// Samples per pixel with which the median would equal the sensor's noise, and a fifth of it; `None` where images
    /// have a noise target.
    #[serde(skip)]
    samples: Option<[f64; 2]>,
}

/// Noise of one image.
struct Known {
    ratio: f64,
    /// Samples per pixel at which Monte Carlo noise would equal that of the sensor.
    equal: f64,
    image: String,
}

impl SetNoise {
    /// Noise of images with their names.
    pub(super) fn of<'a>(images: impl IntoIterator<Item = (String, Option<&'a RenderReport>)>) -> Self {
        let (mut known, mut unknown, mut has_target) = (Vec::new(), 0, false);
        for (image, render) in images {
            has_target |= render.is_some_and(|render| render.noise.is_some());
            match render.and_then(|render| Some((render, render.noise_ratio?))) {
                Some((render, ratio)) => {
                    let equal = f64::from(render.samples_per_pixel) * ratio.powi(2);
                    known.push(Known { ratio, equal, image });
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
            worst_picture: worst.map(|known| known.image.clone()),
            unknown,
            samples: equal.map(|equal| [equal, equal / TARGET.powi(2)]),
        }
    }

    /// Summary for the user; `None` for a set without images.
    pub fn in_words(&self) -> Option<String> {
        let Self { median, worst, worst_picture, unknown, .. } = self;
        let untold = "a single sample of each pixel, the dark, or saturation of all pixels does not tell it";
        let (Some(median), Some(worst), Some(image)) = (median, worst, worst_picture) else {
            return (*unknown > 0).then(|| {
                format!("Monte Carlo noise is not known: {untold}; --set render.samples_per_pixel=2 or more does")
            });
        };
        let of = "that of the sensor in the median image";
        let mut said = format!("Monte Carlo noise is {} {of} and {} in {image}", times(*median), times(*worst));
        if *worst <= UNSEEN {
            said += ": it is not seen";
        } else {
            said += &format!(": {} in the median image", together(*median));
        }
        if let Some(remedy) = self.remedy(*median) {
            said += &format!("; {remedy}");
        }
        if *unknown > 0 {
            said += &format!("; of {unknown} images it is not known, as {untold}");
        }
        Some(said)
    }

    /// Advice to lessen a median that is visible.
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

/// Median: the middle value, or the mean of the middle two.
fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = numbers.collect();
    sorted.sort_by(f64::total_cmp);
    let [below, above] = [sorted.len().checked_sub(1)? / 2, sorted.len() / 2].map(|at| sorted.get(at).copied());
    Some(f64::midpoint(below?, above?))
}
