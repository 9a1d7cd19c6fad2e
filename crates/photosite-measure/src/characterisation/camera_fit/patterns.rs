//! Fixed patterns of a camera: of the dark signal, of the response and of the dark current, and the pixels that are no
//! part of them.

use photosite_core::Result;

use super::defects::{Defect, DefectKind, Outliers, hot_pixels, mend};
use super::frame_group::CameraFrames;
use super::frame_stack::{FrameStack, Parts, StackStatistics};
use super::measured::Measured;
use super::pattern::Pattern;

/// Images of a camera, read with the numbers of defective pixels replaced.
pub(super) struct MendedFrames<'a> {
    pub(super) frames: &'a CameraFrames<'a>,
    pub(super) replacements: Vec<(usize, usize)>,
}

impl MendedFrames<'_> {
    /// Numbers of an image.
    pub(super) fn image(&self, group: usize, image: usize) -> Result<Vec<u16>> {
        let mut numbers = (self.frames.read)(group, image)?;
        mend(&mut numbers, &self.replacements);
        Ok(numbers)
    }

    /// Sums over all images of a group. `unfit` makes an error of images that do not fit.
    pub(super) fn stack(&self, group: usize) -> Result<FrameStack> {
        let mut stack = FrameStack::new(self.frames.size, self.frames.largest());
        for (image, name) in self.frames.groups[group].images.iter().enumerate() {
            stack.add(&self.image(group, image)?).map_err(|invalid| invalid.in_file(name.as_ref()))?;
        }
        Ok(stack)
    }

    /// Lines of every pixel's dark signal over time, of these groups with their times in s and statistics: the rise,
    /// DN/s, and the signal at no time, DN, each with the variances that temporal noise leaves in them.
    pub(super) fn lines(&self, dark: &[(usize, f64, &StackStatistics)]) -> Result<[(Vec<f64>, Parts); 2]> {
        let count = |s: &StackStatistics| s.images as f64;
        let all: f64 = dark.iter().map(|(.., s)| count(s)).sum();
        let mean_time = dark.iter().map(|(_, time, s)| time * count(s)).sum::<f64>() / all;
        let spread: f64 = dark.iter().map(|(_, time, s)| (time - mean_time).powi(2) * count(s)).sum();
        let pixels = self.frames.size[0] * self.frames.size[1];
        let mut lines = [0, 1].map(|_| (vec![0.0; pixels], Parts::default()));
        for &(group, time, statistics) in dark {
            let rise = (time - mean_time) / spread;
            let average = self.stack(group)?.average();
            for ((image, noise), weight) in lines.iter_mut().zip([rise, 1.0 / all - mean_time * rise]) {
                image.iter_mut().zip(&average).for_each(|(sum, y)| *sum += weight * count(statistics) * y);
                *noise = noise.plus(statistics.temporal.map(|v| v.times(weight * weight * count(statistics))));
            }
        }
        Ok(lines)
    }
}

/// Averages that patterns are found in.
pub(super) struct Averages {
    /// Average of the dark reference, DN.
    pub(super) dark: Vec<f64>,
    pub(super) dark_noise: Parts,
    /// Images of the dark reference.
    pub(super) dark_images: usize,
    /// Average of the bright reference less that of the dark images beside it, DN.
    pub(super) response: Option<(Vec<f64>, Parts)>,
    /// Rise of the dark signal, DN/s, and what it is at no time, DN.
    pub(super) lines: Option<[(Vec<f64>, Parts); 2]>,
    /// Whether a pixel had the same number in all images of both references.
    pub(super) is_constant: Vec<bool>,
}

/// Patterns of a camera, DN².
pub(super) struct Patterns {
    pub(super) dark: Pattern,
    pub(super) response: Option<Pattern>,
    pub(super) rise: Option<Pattern>,
    /// Pattern of the dark signal at no time.
    pub(super) start: Option<Pattern>,
}

impl Averages {
    pub(super) fn patterns(&self, size: [usize; 2]) -> Patterns {
        let of = |(image, noise): &(Vec<f64>, Parts)| Pattern::of(image, size, *noise);
        Patterns {
            dark: Pattern::of(&self.dark, size, self.dark_noise),
            response: self.response.as_ref().map(of),
            rise: self.lines.as_ref().map(|[rise, _]| of(rise)),
            start: self.lines.as_ref().map(|[_, start]| of(start)),
        }
    }

    /// Pixels that are no part of the patterns, and the distribution of the hot ones: the part of all pixels and what
    /// each has more, DN/s; or how many there are where they are too few for that.
    pub(super) fn defects(&self, width: usize) -> (Vec<Defect>, Result<[Measured; 2], usize>) {
        // Averages of whole numbers lie so far apart, and a pattern of less stays unseen.
        let step = 0.3 / (self.dark_images as f64).sqrt();
        let mut defects = Vec::new();
        let mut found = |place: usize, kind| defects.push(Defect { x: place % width, y: place / width, kind });
        // At no time, where that is known: dark currents are no offsets.
        let dark = Outliers::of(self.lines.as_ref().map_or(&self.dark, |[_, (start, _)]| start), width);
        let dark_limit = dark.threshold(step);
        if let Some((image, _)) = &self.response {
            let mean = image.iter().sum::<f64>() / image.len() as f64;
            let outliers = Outliers::of(image, width);
            let limit = outliers.threshold(step);
            for (place, &deviation) in outliers.deviations.iter().enumerate().filter(|(_, d)| d.abs() > limit) {
                let is_dark = image[place].abs() < 0.1 * mean;
                let kind = match deviation < 0.0 && is_dark {
                    true if self.is_constant[place] && dark.deviations[place].abs() > dark_limit => DefectKind::Stuck,
                    true => DefectKind::Dead,
                    false => DefectKind::Odd,
                };
                found(place, kind);
            }
        }
        let mut hot = Err(0);
        if let Some([(image, noise), _]) = &self.lines {
            let outliers = Outliers::of(image, width);
            let limit = outliers.uneven_threshold(image, noise.pixel.value.sqrt());
            let beyond = outliers.deviations.iter().enumerate().filter(|(_, d)| **d > limit);
            beyond.for_each(|(place, _)| found(place, DefectKind::Hot));
            hot = hot_pixels(&outliers.deviations, limit);
        }
        let far = dark.deviations.iter().enumerate().filter(|(_, d)| d.abs() > dark_limit);
        far.for_each(|(place, _)| found(place, DefectKind::Odd));
        // The first finding of a pixel stands.
        defects.sort_by_key(|d| (d.y, d.x));
        defects.dedup_by_key(|d| (d.y, d.x));
        (defects, hot)
    }
}
