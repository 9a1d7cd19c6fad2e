//! Wavelengths that the paths of each pixel carry.
//!
//! One density A for all pixels serves all filters, up to four of them: four wavelengths that share it evenly tell of
//! red, green and blue what wavelengths of their own would, if it is the one that [`importance`] finds. It does not
//! serve more filters that are narrow, as those of multispectral sensors, nor paths that dispersion leaves with one
//! wavelength: most of them carry what the filter above the pixel does not let transmitted. An image of raw numbers
//! alone needs what the pixel's own filter sees. With the response R of that filter and what arrives of the light L
//! through the lens τ, wavelengths are then drawn by
//!
//! p(λ) ∝ (1 − f)·RLτ/∫RLτ dλ + f·A/∫A dλ,   f = 0.02,
//!
//! of which the [`WavelengthSampler`] spreads another 5 % evenly: what the other filters would see of the pixel's light
//! stays right on average.
//!
//! Bands of spectral irradiance that are stored beside the image ([`Response::is_secondary`](crate::film::Response))
//! must not make it noisier. With the density A of the image and the density B of the bands, each of integral 1,
//! wavelengths are then drawn by
//!
//! p(λ) ∝ max(A, b·B),   b = 0.2:
//!
//! where the sensor sees well, p is A as without bands, and at most the part b of all wavelengths goes to where it sees
//! little.

use super::job::{FilterTile, RenderJob};
use super::settings::WavelengthChoice;
use crate::film::Response;
use photosite_core::spectrum::{Spectrum, WavelengthSampler, importance};

/// A sampler of wavelengths for each pixel.
pub(super) struct PixelWavelengths {
    samplers: Vec<WavelengthSampler>,
    filters: Vec<usize>,
    width: usize,
}

impl PixelWavelengths {
    /// Makes the samplers of all pixels. `all` is the [importance for all](RenderJob::importance_for_all).
    pub(super) fn new(job: &RenderJob<'_>, all: &Spectrum) -> Self {
        match (job.settings.wavelengths, job.filters) {
            (WavelengthChoice::OwnFilter, Some(FilterTile { responses, filters, width })) => {
                let sampler = |response| WavelengthSampler::new(&mostly(&useful(job, response), all));
                Self { samplers: responses.iter().map(sampler).collect(), filters: filters.clone(), width: *width }
            }
            (WavelengthChoice::AllFilters, _) | (WavelengthChoice::OwnFilter, None) => {
                Self { samplers: vec![WavelengthSampler::new(all)], filters: vec![0], width: 1 }
            }
        }
    }

    /// Whether all pixels have the same sampler.
    pub(super) fn are_the_same_everywhere(&self) -> bool {
        self.samplers.len() == 1
    }

    /// Samplers of all pixels; the number of that of each pixel of a tile, row by row; and the tile's width.
    pub(super) fn tile(&self) -> (&[WavelengthSampler], &[usize], usize) {
        (&self.samplers, &self.filters, self.width)
    }

    /// Sampler of a pixel.
    #[inline]
    pub(super) fn at(&self, column: usize, row: usize) -> &WavelengthSampler {
        let height = self.filters.len() / self.width;
        &self.samplers[self.filters[row % height * self.width + column % self.width]]
    }
}

impl RenderJob<'_> {
    /// Importance of each wavelength to the image, and to the bands that are stored beside it, in any unit.
    pub fn importance_for_all(&self) -> Spectrum {
        let (secondary, primary): (Vec<&Response>, Vec<&Response>) =
            self.responses.iter().partition(|response| response.is_secondary);
        let [image, bands] = [primary, secondary].map(|responses| {
            let responses: Vec<Spectrum> = responses.iter().map(|response| useful(self, &response.spectrum)).collect();
            importance(&responses)
        });
        with_bands(image, &bands)
    }
}

/// The module's b.
const FOR_BANDS: f64 = 0.2;

/// The importance of the image, and at least the part b of that of the bands. Any unit; either may be zero
/// everywhere.
fn with_bands(image: Spectrum, bands: &Spectrum) -> Spectrum {
    let (of_image, of_bands) = (image.integral(), bands.integral());
    if of_bands <= 0.0 {
        return image;
    }
    if of_image <= 0.0 {
        return bands.clone();
    }
    let scale = FOR_BANDS * of_image / of_bands;
    image.map_with(bands, |image, band| image.max(scale * band))
}

/// Response weighted by the light of the scene and the transmittance of the lens, since samples of dark wavelengths are
/// wasted.
fn useful(job: &RenderJob<'_>, response: &Spectrum) -> Spectrum {
    response.product(job.scene.light_spectrum()).product(job.transmittance)
}

/// The density's f: no wavelength that matters to any filter is left out.
const FOR_ALL: f64 = 0.02;

/// Importance to one filter with a little of the importance to all; the latter alone where the filter lets no light
/// transmitted.
fn mostly(own: &Spectrum, all: &Spectrum) -> Spectrum {
    let (part, whole) = (own.integral(), all.integral());
    if part <= 0.0 {
        return all.clone();
    }
    own.map_with(all, |own, all| (1.0 - FOR_ALL) * own / part + FOR_ALL * all / whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn band(from: f64, to: f64) -> Spectrum {
        Spectrum::from_fn(|l| if (from..=to).contains(&l) { 3.0 } else { 0.0 })
    }

    #[test]
    fn most_is_for_the_own_filter_and_some_for_each_other() {
        let (own, all) = (band(500.0, 520.0), band(400.0, 700.0));
        let mixed = mostly(&own, &all);
        assert!((mixed.integral() - 1.0).abs() < 1e-6);
        let within = mixed.product(&band(500.0, 520.0)).integral() / 3.0;
        // Of the band for all, 301 entries of a nanometre, 21 are within.
        assert!((within - (0.98 + 0.02 * 21.0 / 301.0)).abs() < 1e-6, "{within}");
        assert!(all.iter().zip(mixed.iter()).all(|((_, all), (_, mixed))| (all > 0.0) == (mixed > 0.0)));
    }

    #[test]
    fn bands_take_a_fifth_of_the_wavelengths_at_most_and_none_where_the_image_has_enough() {
        let part_beyond = |image: &Spectrum, bands: &Spectrum| {
            let drawn = with_bands(image.clone(), bands);
            let beyond = drawn.map_with(image, |drawn, image| if image > 0.0 { 0.0 } else { drawn });
            beyond.integral() / drawn.integral()
        };
        // A fifth of the integral of the image is added beyond it, so that it is 1/6 of the whole; edges of 1 nm
        // aside.
        let (image, beyond) = (band(400.0, 700.0), band(800.0, 1000.0));
        let part = part_beyond(&image, &beyond);
        assert!((part - 1.0 / 6.0).abs() < 2e-3, "{part}");
        // Bands within what the image has are drawn as often as it is.
        assert_eq!(with_bands(image.clone(), &band(450.0, 650.0)).values(), image.values());
        let dark = Spectrum::constant(0.0);
        assert_eq!(with_bands(dark.clone(), &beyond).values(), beyond.values());
        assert_eq!(with_bands(image.clone(), &dark).values(), image.values());
    }

    #[test]
    fn a_filter_without_light_has_the_wavelengths_of_all() {
        let all = band(400.0, 700.0);
        assert_eq!(mostly(&Spectrum::constant(0.0), &all).values(), all.values());
        // In the dark any will do.
        let dark = Spectrum::constant(0.0);
        let drawn = WavelengthSampler::new(&mostly(&dark, &dark)).sample(0.5);
        assert!((0..4).all(|lane| drawn.lambda_nm(lane).is_finite() && drawn.weights()[lane].is_finite()));
    }
}
