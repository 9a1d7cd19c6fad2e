//! Light that lands in other pixels than the one whose path it came along, wavelength by wavelength.

use std::ops::Range;

use glam::Vec4;

use super::{FilmBand, FilmResponses, add_values};

/// Light that one wavelength brings to a sample of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct OneWavelength {
    /// Position of the wavelength in a spectral table: the entry before it, and the part of the way from there to the
    /// next.
    pub entry: u32,
    /// Part of the way from `entry` to the next entry, 0–1.
    pub part: f32,
    /// Spectral irradiance times the wavelength's Monte Carlo weight, W·m⁻².
    pub weighted: f32,
}

/// Light that lands in a row of the film: samples of all pixels, to which light is added in any order of pixels.
pub struct LandingRow {
    samples: Range<u32>,
    groups: usize,
    /// Values by pixel, sample and group of channels.
    values: Vec<Vec4>,
}

impl FilmResponses {
    /// Adds to `values`, one for each group, what one wavelength gives to each channel: w·R(λ)·E(λ).
    #[inline]
    fn respond_to_one(&self, light: &OneWavelength, values: &mut [Vec4]) {
        let groups = values.len();
        let entry = light.entry as usize;
        for (group, value) in values.iter_mut().enumerate() {
            let [low, high] = [entry, entry + 1].map(|entry| self.table[entry * groups + group]);
            *value += light.weighted * (low + (high - low) * light.part);
        }
    }
}

impl FilmBand<'_> {
    /// Row without light for these samples of each pixel.
    pub fn landing_row(&self, samples: Range<u32>) -> LandingRow {
        let groups = self.responses.groups();
        let values = vec![Vec4::ZERO; self.counts.len() * samples.len() * groups];
        LandingRow { samples, groups, values }
    }

    /// Adds light to a sample of a pixel of a row. Light of other samples is dropped.
    #[inline]
    pub fn land(&self, row: &mut LandingRow, pixel: usize, sample: u32, light: &OneWavelength) {
        if row.samples.contains(&sample) {
            let start = row.start(pixel, sample);
            self.responses.respond_to_one(light, &mut row.values[start..start + row.groups]);
        }
    }

    /// Adds to each pixel the samples of a row that it lacks, up to the number that `wanted` gives.
    pub fn add_row(&mut self, row: &LandingRow, wanted: impl Fn(usize) -> u32) {
        let channels = self.responses.len();
        for pixel in 0..self.counts.len() {
            let missing = self.counts[pixel].max(row.samples.start)..wanted(pixel).min(row.samples.end);
            if missing.is_empty() {
                continue;
            }
            let values = &row.values[row.start(pixel, missing.start)..row.start(pixel, missing.end)];
            add_values(&mut self.sums[pixel * channels..(pixel + 1) * channels], row.groups, values);
            self.counts[pixel] += missing.len() as u32;
        }
    }
}

impl LandingRow {
    fn start(&self, pixel: usize, sample: u32) -> usize {
        (pixel * self.samples.len() + (sample - self.samples.start) as usize) * self.groups
    }
}
