//! Curves of all channels, with their errors.

use serde::Serialize;

use photosite_core::Invalid;
use photosite_core::math::minimise::nelder_mead;
use photosite_core::spectrum::Spectrum;

use super::chart::PatchMean;
use super::log_process::{LogProcess, Measurements, Posterior};

/// First and last wavelength, nm, and the step: the range of published reflectances of charts.
const RANGE_NM: [f64; 2] = [380.0, 780.0];
const STEP_NM: f64 = 10.0;

/// Prior of a curve over its mean. With it, 92 to 95 % of the values of known curves lie within two standard errors (tests below).
const PRIOR: LogProcess = LogProcess { mean: -1.5, deviation: 2.5, length: 70.0 };

/// Range of the relative error of the patches that is looked for.
const ERRORS: [f64; 2] = [1e-3, 0.3];
/// Part of the brightest patch below which errors do not become smaller.
const DARK: f64 = 0.02;
/// Error of a patch over the brightest one that is always there.
const LEAST_ERROR: f64 = 3e-4;

/// Chart in light that is known.
#[derive(Clone, Debug)]
pub struct LitChart {
    /// Spectral power of the light, in any unit.
    pub light: Spectrum,
    /// Means of the patches in each channel.
    pub means: Vec<Vec<PatchMean>>,
}

/// Spectral sensitivities of all channels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivities {
    /// Wavelengths of the values, nm.
    pub wavelengths_nm: Vec<f64>,
    /// Channels in the order of the colour filter array.
    pub channels: Vec<Sensitivity>,
    /// Relative error by which patches depart from the curves, beyond what their pixels tell: light that is uneven, glare, charts
    /// that have faded.
    pub patch_error: f64,
    /// Patches with saturated pixels, which are left out, over all channels and images.
    pub saturated: usize,
}

/// Spectral sensitivity of a channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Channel.
    pub channel: String,
    /// Signal per photon, 1 at the largest value of all channels.
    pub values: Vec<f64>,
    /// Standard errors of the logarithms of the values: 0.1 is a factor of 1.1 up or down.
    pub log_errors: Vec<f64>,
    /// Wavelength of the largest value, nm.
    pub peak_nm: f64,
    /// Wavelengths between which the curve is at least half as large, nm.
    pub half_maximum_nm: [f64; 2],
}

/// Measurements of a channel: rows of weights, values, and the standard errors that pixels tell.
struct Signals {
    weights: Vec<Vec<f64>>,
    values: Vec<f64>,
    errors: Vec<f64>,
    /// Image that each is of.
    images: Vec<usize>,
    /// Signal per photon of the value 1, DN over photons in the unit of the light.
    unit: f64,
}

/// Sensitivities of a camera that took these charts, whose patches have these reflectances. The signal of patch p in a
/// channel is ∝ ∫ E(λ)·R_p(λ)·q(λ)·λ dλ, with the power E of the light. Each curve q is the most probable one of a positive prior,
/// smooth on the scale of logarithms; the error of the patches and the exposures of further images
/// over that of the first are those that make the measurements most probable.
///
/// # Errors
///
/// Charts of other patches, reflectances outside 0 to 1, light that is dark or negative, images without enough patches, and patches
/// that no curves explain.
pub fn sensitivities(
    charts: &[LitChart],
    reflectances: &[Spectrum],
    channels: &[String],
) -> Result<Sensitivities, Invalid> {
    for (number, reflectance) in reflectances.iter().enumerate() {
        if let Some((nm, value)) = in_range(reflectance).find(|(_, value)| !(0.0..=1.0).contains(value)) {
            let message = format!("the reflectance of patch {} is {value} at {nm} nm", number + 1);
            return Err(Invalid::new("reflectances", message).help("write reflectances from 0 to 1, not percent"));
        }
    }
    for LitChart { light, .. } in charts {
        if let Some((nm, value)) = in_range(light).find(|(_, value)| *value < 0.0) {
            let message = format!("the power of the light is {value} at {nm} nm");
            return Err(Invalid::new("light", message).help("write power from 0 on"));
        }
    }
    let steps = ((RANGE_NM[1] - RANGE_NM[0]) / STEP_NM) as usize;
    let wavelengths_nm: Vec<f64> = (0..=steps).map(|i| RANGE_NM[0] + STEP_NM * i as f64).collect();
    let signals: Vec<Signals> = (0..channels.len())
        .map(|channel| Signals::of(charts, reflectances, channel, &wavelengths_nm))
        .collect::<Result<_, _>>()?;
    let factor = PRIOR.factor(&wavelengths_nm);
    let posteriors = |unknowns: &[f64]| -> Vec<Posterior> {
        let error = unknowns[0].exp().clamp(ERRORS[0], ERRORS[1]);
        signals.iter().map(|signals| signals.posterior(error, &unknowns[1..], &factor)).collect()
    };
    // Logarithms of the error and of the exposures: 0.5 of the logarithm is the first step of the search.
    let mut start = vec![0.01f64.ln()];
    start.extend((1..charts.len()).map(|image| exposure_over_first(&signals, image).ln()));
    let found = nelder_mead(&start, 0.5, 25 * start.len(), |unknowns| {
        let beyond = (unknowns[0] - unknowns[0].clamp(ERRORS[0].ln(), ERRORS[1].ln())).abs();
        beyond - posteriors(unknowns).iter().map(|posterior| posterior.evidence).sum::<f64>()
    });
    let patch_error = found[0].exp().clamp(ERRORS[0], ERRORS[1]);
    if patch_error > 0.99 * ERRORS[1] {
        let message = format!("the patches depart by more than {:.0} % from all curves", 100.0 * ERRORS[1]);
        return Err(Invalid::new("corners", message).help(
            "write the corners in the order of reading; look at the light and at the reflectances of the chart",
        ));
    }
    let posteriors = posteriors(&found);
    let peaks = posteriors.iter().zip(&signals).map(|(p, s)| p.curve[largest(&p.curve)] * s.unit);
    let top = peaks.fold(0.0, f64::max);
    let curves = channels.iter().zip(&posteriors).zip(&signals).map(|((channel, posterior), signals)| {
        let values: Vec<f64> = posterior.curve.iter().map(|q| q * signals.unit / top).collect();
        let (peak_nm, half_maximum_nm) = shape(&wavelengths_nm, &values);
        let log_errors = posterior.log_errors.clone();
        Sensitivity { channel: channel.clone(), values, log_errors, peak_nm, half_maximum_nm }
    });
    let means = charts.iter().flat_map(|chart| &chart.means).flatten();
    Ok(Sensitivities {
        channels: curves.collect(),
        wavelengths_nm,
        patch_error,
        saturated: means.filter(|mean| mean.saturated > 0).count(),
    })
}

/// Wavelengths and values of a spectrum within the range.
fn in_range(spectrum: &Spectrum) -> impl Iterator<Item = (f64, f64)> + '_ {
    spectrum.iter().filter(|(nm, _)| (RANGE_NM[0]..=RANGE_NM[1]).contains(nm))
}

/// Weights of the values of a curve, straight between its wavelengths, in the integral of its product with a spectrum.
fn weights(spectrum: &Spectrum, count: usize) -> Vec<f64> {
    let mut weights = vec![0.0; count];
    for step in 0..=(RANGE_NM[1] - RANGE_NM[0]) as usize {
        let value = f64::from(spectrum.eval((RANGE_NM[0] + step as f64) as f32));
        let place = step as f64 / STEP_NM;
        let (first, part) = ((place as usize).min(count - 2), place - (place as usize).min(count - 2) as f64);
        weights[first] += value * (1.0 - part);
        weights[first + 1] += value * part;
    }
    weights
}

/// Exposure of an image over that of the first, as if all curves were flat.
fn exposure_over_first(signals: &[Signals], image: usize) -> f64 {
    let sum = |of: usize| -> f64 {
        let ratio = |s: &Signals| {
            let seen = (0..s.values.len()).filter(|&i| s.images[i] == of);
            let [value, flat] =
                seen.fold([0.0; 2], |[value, flat], i| [value + s.values[i], flat + s.weights[i].iter().sum::<f64>()]);
            value / flat
        };
        signals.iter().map(ratio).sum()
    };
    let ratio = sum(image) / sum(0);
    if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
}

/// Place of the largest value.
fn largest(values: &[f64]) -> usize {
    (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0)
}

/// Wavelength of the peak and the ends of the range about it with at least half of the value.
fn shape(wavelengths_nm: &[f64], values: &[f64]) -> (f64, [f64; 2]) {
    let peak = largest(values);
    let is_low = |i: &usize| values[*i] < 0.5 * values[peak];
    let first = (0..peak).rev().find(is_low).map_or(0, |i| i + 1);
    let last = (peak..values.len()).find(is_low).map_or(values.len(), |i| i) - 1;
    (wavelengths_nm[peak], [wavelengths_nm[first], wavelengths_nm[last]])
}

impl Signals {
    fn of(
        charts: &[LitChart],
        reflectances: &[Spectrum],
        channel: usize,
        wavelengths_nm: &[f64],
    ) -> Result<Self, Invalid> {
        let mut signals =
            Self { weights: Vec::new(), values: Vec::new(), errors: Vec::new(), images: Vec::new(), unit: 1.0 };
        for (image, LitChart { light, means }) in charts.iter().enumerate() {
            if means.len() != reflectances.len() {
                let message = format!("{} patches, and {} reflectances", means.len(), reflectances.len());
                return Err(Invalid::new("reflectances", message).help("give the grid of the chart, columns x rows"));
            }
            let photons = light.map(|nm, power| power * nm);
            let all: f64 = weights(&photons, wavelengths_nm.len()).iter().sum();
            if all.is_nan() || all <= 0.0 {
                let message = format!("is dark from {} to {} nm", RANGE_NM[0], RANGE_NM[1]);
                return Err(Invalid::new("light", message));
            }
            for (mean, reflectance) in means.iter().map(|patch| &patch[channel]).zip(reflectances) {
                if mean.saturated == 0 {
                    let mut row = weights(&photons.product(reflectance), wavelengths_nm.len());
                    row.iter_mut().for_each(|weight| *weight /= all);
                    signals.weights.push(row);
                    signals.values.push(mean.signal_dn);
                    signals.errors.push(mean.standard_error_dn);
                    signals.images.push(image);
                }
            }
        }
        /// Fewest patches that tell a curve.
        const FEWEST: usize = 6;
        let light = signals.values.iter().filter(|value| **value > 0.0).count();
        match (light >= FEWEST).then(|| largest(&signals.values)) {
            Some(brightest) => {
                // A curve of 1 makes the brightest patch 1.
                let (flat, signal): (f64, f64) = (signals.weights[brightest].iter().sum(), signals.values[brightest]);
                signals.weights.iter_mut().flatten().for_each(|weight| *weight /= flat);
                signals.values.iter_mut().chain(&mut signals.errors).for_each(|value| *value /= signal);
                Ok(Self { unit: signal / flat, ..signals })
            }
            None => {
                let message =
                    format!("{light} patches of a channel are light and not saturated, and {FEWEST} are needed");
                Err(Invalid::new("", message).help("expose so that the white patch lies below saturation"))
            }
        }
    }

    /// The curve for a relative error of the patches, and logarithms of exposures over that of the first image.
    fn posterior(&self, error: f64, exposures: &[f64], factor: &[Vec<f64>]) -> Posterior {
        let exposure = |image: usize| image.checked_sub(1).map_or(1.0, |further| exposures[further].exp());
        let weights: Vec<Vec<f64>> = (self.weights.iter().zip(&self.images))
            .map(|(row, &image)| row.iter().map(|weight| weight * exposure(image)).collect())
            .collect();
        let of = |(value, own): (&f64, &f64)| own.hypot(error * value.max(DARK)).hypot(LEAST_ERROR);
        let errors: Vec<f64> = self.values.iter().zip(&self.errors).map(of).collect();
        PRIOR.posterior(factor, &Measurements { weights: &weights, values: &self.values, errors: &errors })
    }
}

impl Sensitivities {
    /// Whether the patches depart no more from the curves than is looked for.
    pub fn is_exact(&self) -> bool {
        self.patch_error <= ERRORS[0]
    }
}

impl Sensitivity {
    /// Values as a spectrum, 0 beyond the range that the chart tells.
    ///
    /// # Errors
    ///
    /// Wavelengths that are not those of the values.
    pub fn spectrum(&self, wavelengths_nm: &[f64]) -> Result<Spectrum, Invalid> {
        Spectrum::from_samples(wavelengths_nm, &self.values, photosite_core::spectrum::Outside::Zero)
    }

    /// Standard error at the peak, as a part of the value.
    pub fn error_at_peak(&self) -> f64 {
        self.log_errors[largest(&self.values)]
    }
}

#[cfg(test)]
mod tests {
    use photosite_core::math::philox::Philox;
    use photosite_core::spectrum::{illuminant, library};
    use rand::RngExt;
    use rand_distr::StandardNormal;
    use rstest::rstest;

    use super::*;

    fn patches() -> Vec<Spectrum> {
        library::colour_checker().map(|(_, patch)| patch).collect()
    }

    /// Sensitivity behind an infrared filter.
    fn curve(camera: &str, channel: &str) -> Spectrum {
        let of = |name: &str| library::spectrum(name).expect("listed");
        of(&format!("quantum-efficiency/{camera}-{channel}")).product(&of("filters/ir-cut-650"))
    }

    /// Means of a chart with errors of 0.3 % at an exposure.
    fn chart(camera: &str, light: &str, exposure: f64, seed: u64) -> LitChart {
        let light = illuminant::illuminant(light).expect("known");
        let photons = light.map(|nm, power| nm * power);
        let white = photons.integral();
        let mean = |p: usize, c: usize, reflectance: &Spectrum, channel: &str| {
            let signal = photons.product(reflectance).product(&curve(camera, channel)).integral() / white * exposure;
            let normal: f64 = Philox::new(seed, (3 * p + c) as u64).sample(StandardNormal);
            PatchMean { signal_dn: signal * (1.0 + 0.003 * normal), standard_error_dn: 0.01, pixels: 900, saturated: 0 }
        };
        let patch = |(p, reflectance): (usize, &Spectrum)| {
            ["r", "g", "b"].iter().enumerate().map(|(c, channel)| mean(p, c, reflectance, channel)).collect()
        };
        LitChart { light, means: patches().iter().enumerate().map(patch).collect() }
    }

    fn channels() -> Vec<String> {
        ["R", "G", "B"].map(str::to_owned).to_vec()
    }

    /// Root mean square of the deviations over the peak of each channel, and the part of all values within two standard
    /// errors and 0.5 % of the peak.
    fn compared(found: &Sensitivities, camera: &str) -> (Vec<f64>, f64) {
        let truth: Vec<Spectrum> = ["r", "g", "b"].iter().map(|channel| curve(camera, channel)).collect();
        // Relative curves: the factor of least squares over all channels.
        let pairs = |c: usize| {
            let values = found.wavelengths_nm.iter().zip(&found.channels[c].values);
            values.map(|(nm, value)| (f64::from(truth[c].eval(*nm as f32)), *value)).collect::<Vec<_>>()
        };
        let all: Vec<Vec<(f64, f64)>> = (0..3).map(pairs).collect();
        let sum = |of: fn(&(f64, f64)) -> f64| all.iter().flatten().map(of).sum::<f64>();
        let factor = sum(|(t, q)| t * q) / sum(|(_, q)| q * q);
        let (mut deviations, mut within) = (Vec::new(), 0);
        for (channel, pairs) in found.channels.iter().zip(&all) {
            let peak = pairs.iter().map(|(t, _)| *t).fold(0.0, f64::max);
            let square: f64 = pairs.iter().map(|(t, q)| (t - factor * q).powi(2)).sum();
            deviations.push((square / pairs.len() as f64).sqrt() / peak);
            within += pairs
                .iter()
                .zip(&channel.log_errors)
                .filter(|((t, q), error)| {
                    let (q, spread, slack) = (factor * q, (2.0 * *error).exp(), 0.005 * peak);
                    (q / spread - slack..=q * spread + slack).contains(t)
                })
                .count();
        }
        (deviations, within as f64 / (3 * found.wavelengths_nm.len()) as f64)
    }

    #[rstest]
    #[case::one_light("generic-cmos-color", &["D50"])]
    #[case::incandescent("sony-imx249", &["A"])]
    #[case::two_lights("generic-cmos-color", &["A", "D65"])]
    #[case::three_lights("sony-imx249", &["A", "D65", "LED-B3"])]
    fn known_curves_are_found(#[case] camera: &str, #[case] lights: &[&str]) {
        let mut covered = Vec::new();
        for seed in 0..4 {
            let lit = lights.iter().enumerate().map(|(i, light)| chart(camera, light, 900.0 * (1.0 + i as f64), seed));
            let found = sensitivities(&lit.collect::<Vec<_>>(), &patches(), &channels()).expect("curves");
            let (deviations, within) = compared(&found, camera);
            assert!(deviations.iter().all(|deviation| *deviation < 0.1), "{deviations:?}");
            assert!((0.001..0.01).contains(&found.patch_error), "{}", found.patch_error);
            covered.push(within);
        }
        let mean = covered.iter().sum::<f64>() / covered.len() as f64;
        assert!(mean > 0.9, "{covered:?}");
    }

    #[test]
    fn what_no_curves_explain_is_refused() {
        let lit = chart("generic-cmos-color", "D50", 900.0, 1);
        let mut turned = lit.clone();
        turned.means.reverse();
        let with =
            |lit: LitChart, patches: &[Spectrum]| sensitivities(&[lit], patches, &channels()).expect_err("refused");
        assert!(with(turned, &patches()).message.contains("depart by more than 30 %"));
        let percent: Vec<Spectrum> = patches().iter().map(|patch| patch.scale(100.0)).collect();
        assert!(with(lit.clone(), &percent).message.contains("reflectance of patch 1 is"));
        let negative = LitChart { light: lit.light.map(|nm, power| if nm < 500.0 { -power } else { power }), ..lit };
        assert!(with(negative, &patches()).message.contains("power of the light is -"));
    }

    #[test]
    fn saturated_patches_do_not_count() {
        let mut lit = chart("generic-cmos-color", "D50", 900.0, 1);
        let whole = sensitivities(std::slice::from_ref(&lit), &patches(), &channels()).expect("curves");
        lit.means[18].iter_mut().for_each(|mean| (mean.saturated, mean.signal_dn) = (3, 5.0));
        let found = sensitivities(std::slice::from_ref(&lit), &patches(), &channels()).expect("curves");
        assert_eq!((whole.saturated, found.saturated), (0, 3));
        // Channels keep their proportions where patches are saturated in one of them.
        let mut green = chart("generic-cmos-color", "D50", 900.0, 1);
        for patch in [18, 15, 11, 19] {
            green.means[patch][1].saturated = 1;
        }
        let green = sensitivities(&[green], &patches(), &channels()).expect("curves");
        assert!(compared(&green, "generic-cmos-color").0.iter().all(|deviation| *deviation < 0.1));
        assert!(compared(&found, "generic-cmos-color").0.iter().all(|deviation| *deviation < 0.1));
        lit.means.iter_mut().flatten().for_each(|mean| mean.saturated = 1);
        let invalid = sensitivities(&[lit], &patches(), &channels()).expect_err("refused");
        assert!(invalid.message.contains("0 patches of a channel"), "{invalid:?}");
    }
}
