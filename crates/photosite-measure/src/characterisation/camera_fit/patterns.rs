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

    /// Lines of every pixel's dark signal over time, of these groups with their times in s and statistics.
    pub(super) fn lines(&self, dark: &[(usize, f64, &StackStatistics)]) -> Result<DarkLines> {
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
        let [rise, start] = lines;
        Ok(DarkLines { rise, start, mean_time })
    }
}

/// Lines of every pixel's dark signal over time, with the variances that temporal noise leaves in them.
pub(super) struct DarkLines {
    /// Rise, DN/s.
    pub(super) rise: (Vec<f64>, Parts),
    /// Signal at no time, DN.
    pub(super) start: (Vec<f64>, Parts),
    /// Mean time of all images, s, at which signal and rise are told independently.
    mean_time: f64,
}

impl DarkLines {
    /// Offsets of the pixels with the variances that noise leaves in them. The signal at the mean time t, less what the dark
    /// current adds there: the rise with σ² of noise, which tells its pattern of s² by s²/(s² + σ²). Where dark
    /// currents are alike, that is the mean of all images.
    fn offsets(&self, rise: &Parts) -> (Vec<f64>, Parts) {
        let t = self.mean_time;
        let told = |part: fn(&Parts) -> Measured| part(rise).root().map_or(0.0, |_| part(rise).value);
        let share = {
            let (s, sigma) = (told(|p| p.pixel), self.rise.1.pixel.value);
            if s > 0.0 { s / (s + sigma) } else { 0.0 }
        };
        let left = |part: fn(&Parts) -> Measured| {
            let [at_start, of_rise] = [&self.start.1, &self.rise.1].map(|noise| part(noise).value);
            let uneven = share * share * of_rise + (1.0 - share).powi(2) * told(part);
            Measured::new((at_start - t * t * of_rise).max(0.0) + t * t * uneven, 0.0)
        };
        let images = self.start.0.iter().zip(&self.rise.0);
        let offsets = images.map(|(start, rise)| start + (1.0 - share) * t * rise).collect();
        (offsets, Parts { pixel: left(|p| p.pixel), row: left(|p| p.row), column: left(|p| p.column) })
    }
}

/// Averages that patterns are found in.
pub(super) struct Averages {
    /// Average of the dark reference, DN.
    pub(super) dark: Vec<f64>,
    pub(super) dark_noise: Parts,
    /// Images of the dark reference.
    pub(super) dark_images: usize,
    /// Exposure time of the dark reference, s; 0 where it is unknown.
    pub(super) dark_time: f64,
    /// Average of the bright reference less that of the dark images beside it, DN.
    pub(super) response: Option<(Vec<f64>, Parts)>,
    /// Lines of the dark signal over time, where times are known.
    pub(super) lines: Option<DarkLines>,
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
    /// Exposure time of the dark reference, s.
    dark_time: f64,
}

impl Patterns {
    /// Pattern of the offsets: that of the dark reference, less what an uneven dark current adds, or that of the lines at
    /// no time, whichever is known better.
    pub(super) fn offsets(&self) -> Parts {
        let rise = self.rise.as_ref().map(|rise| rise.variances.pixel).filter(|rise| rise.root().is_ok());
        let uneven = rise.unwrap_or_default().times(self.dark_time * self.dark_time);
        let of_time = Parts { pixel: self.dark.variances.pixel.minus(uneven), ..self.dark.variances };
        let of_start = self.start.as_ref().map(|pattern| pattern.variances);
        let clearer = |part: fn(&Parts) -> Measured| {
            let start = of_start.as_ref().map(part);
            start.filter(|start| start.standard_error < part(&of_time).standard_error).unwrap_or(part(&of_time))
        };
        Parts { pixel: clearer(|p| p.pixel), row: clearer(|p| p.row), column: clearer(|p| p.column) }
    }
}

impl Averages {
    /// Offsets of the pixels, with the variances that noise leaves in them.
    pub(super) fn offsets(&self, patterns: &Patterns) -> (Vec<f64>, Parts) {
        match (&self.lines, &patterns.rise) {
            (Some(lines), Some(rise)) => lines.offsets(&rise.variances),
            _ => (self.dark.clone(), self.dark_noise),
        }
    }

    pub(super) fn patterns(&self, size: [usize; 2]) -> Patterns {
        let of = |(image, noise): &(Vec<f64>, Parts)| Pattern::of(image, size, *noise);
        Patterns {
            dark: Pattern::of(&self.dark, size, self.dark_noise),
            response: self.response.as_ref().map(of),
            rise: self.lines.as_ref().map(|lines| of(&lines.rise)),
            start: self.lines.as_ref().map(|lines| of(&lines.start)),
            dark_time: self.dark_time,
        }
    }

    /// Pixels that are no part of the patterns, and the distribution of the hot ones: the part of all pixels and what
    /// each has more, DN/s; or how many there are where they are too few for that.
    pub(super) fn defects(&self, width: usize) -> (Vec<Defect>, Result<[Measured; 2], usize>) {
        // Averages of whole numbers lie so far apart, and a pattern of less stays unseen.
        let step = 0.3 / (self.dark_images as f64).sqrt();
        let mut defects = Vec::new();
        let mut found = |place: usize, kind, value| {
            defects.push(Defect { x: place % width, y: place / width, kind, value });
        };
        // At no time, where that is known: dark currents are no offsets.
        let dark = Outliers::of(self.lines.as_ref().map_or(&self.dark, |lines| &lines.start.0), width);
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
                found(place, kind, (kind == DefectKind::Stuck).then(|| self.dark[place].round()));
            }
        }
        let mut hot = Err(0);
        if let Some(DarkLines { rise: (image, noise), .. }) = &self.lines {
            let outliers = Outliers::of(image, width);
            let limit = outliers.uneven_threshold(image, noise.pixel.value.sqrt());
            let beyond = outliers.deviations.iter().enumerate().filter(|(_, d)| **d > limit);
            beyond.for_each(|(place, more)| found(place, DefectKind::Hot, Some(*more)));
            hot = hot_pixels(&outliers.deviations, limit);
        }
        let far = dark.deviations.iter().enumerate().filter(|(_, d)| d.abs() > dark_limit);
        far.for_each(|(place, _)| found(place, DefectKind::Odd, None));
        // The first finding of a pixel stands.
        defects.sort_by_key(|d| (d.y, d.x));
        defects.dedup_by_key(|d| (d.y, d.x));
        (defects, hot)
    }
}
