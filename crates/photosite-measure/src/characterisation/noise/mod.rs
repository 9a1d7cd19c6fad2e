//! Estimates of the noise of any image: from several images of the same scene, from a patch of even light, from a
//! patch with linear shading.
//!
//! In: values of the same patch in one or more images, in any unit. Out: a [`NoiseEstimate`], and on request the σ of
//! every pixel ([`sigma_map`]). All estimates are of the image as it is: fixed patterns count as noise unless several
//! images tell them apart.

mod autocovariance;
mod estimate;
mod figures;
mod knowledge;
mod neighbourhoods;
mod patch;
mod plane_fit;
mod sigma_distribution;
mod signal_to_noise;
mod temporal;

use photosite_core::Invalid;

pub use autocovariance::Autocovariance;
pub use estimate::{NoiseEstimate, Quantisation};
pub use figures::figures;
pub use knowledge::Knowledge;
pub use neighbourhoods::Neighbourhoods;
pub use patch::{Patch, Variance};
pub use plane_fit::{ChiSquared, PlaneFit};
pub use sigma_distribution::SigmaDistribution;
pub use signal_to_noise::{Contrast, SignalToNoise};
pub use temporal::TemporalNoise;

/// Settings of a noise estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Largest distance at which autocovariance is estimated, pixels.
    pub most_lag: usize,
    /// Side of the squares that get a plane of their own, pixels, from 2 on.
    pub side: usize,
}

/// σ of each pixel over two or more images of the same light, √(Σ(y_i − ȳ)²/(N − 1)), row by row
/// ([TruccoVerri98](photosite_core::references#truccoverri98), algorithm `EST_NOISE`).
pub fn sigma_map(patches: &[Patch]) -> Result<Vec<f64>, Invalid> {
    same_size(patches)?;
    if patches.len() < 2 {
        let invalid = Invalid::new("", "one image does not tell how each pixel changes");
        return Err(invalid.help("give two or more images of the same scene"));
    }
    Ok(temporal::sigma_map(patches, &temporal::average(patches)))
}

/// Columns and rows of all images.
fn same_size(patches: &[Patch]) -> Result<[usize; 2], Invalid> {
    let Some(first) = patches.first() else { return Err(Invalid::new("", "there is no image")) };
    let size = [first.width, first.height];
    match patches.iter().map(|p| [p.width, p.height]).find(|other| *other != size) {
        Some(other) => {
            Err(Invalid::new("", format!("images of {size:?} and of {other:?} pixels cannot be used together")))
        }
        None => Ok(size),
    }
}

/// Estimates the noise of a patch in one or more images of the same light.
pub fn estimate(patches: &[Patch], known: &Knowledge, request: Request) -> Result<NoiseEstimate, Invalid> {
    let size = same_size(patches)?;
    let temporal = TemporalNoise::new(patches);
    let average = temporal::average(patches);
    let mean = average.mean();
    let freedom = (average.values.len() - 1) as f64;
    let uniform = Variance::of(average.values.iter().map(|y| (y - mean).powi(2)).sum(), freedom);
    let found_variance = temporal.as_ref().map(|t| t.noise.variance);
    // A mean of several images has the variance of one of them divided by their number.
    let images = patches.len() as f64;
    let (plane, residuals) =
        PlaneFit::new(&average, known.variance.or(found_variance).map(|variance| variance / images));
    let autocovariance = if temporal.is_some() {
        Autocovariance::mean_of(&temporal::deviations(patches, &average), size, request.most_lag)
    } else {
        Autocovariance::mean_of(&[residuals], size, request.most_lag)
    };
    let noise = temporal.as_ref().map_or(plane.noise, |t| t.noise);
    // What averaging leaves of the noise is no signal.
    let left = if temporal.is_some() { noise.variance / images } else { noise.variance };
    let signal_variance = uniform.variance - left;
    let largest = temporal.as_ref().map(|t| t.largest_sigma);
    Ok(NoiseEstimate {
        pictures: patches.len(),
        size,
        mean,
        uniform,
        plane,
        neighbourhoods: Neighbourhoods::new(patches, request.side, known.variance.or(found_variance)),
        autocovariance,
        snr: SignalToNoise::new(known, mean, signal_variance, noise.sigma, largest),
        quantisation: known.step.map(|step| {
            let variance = step * step / 12.0;
            let part = 100.0 * variance / noise.variance;
            Quantisation { step, variance, part_percent: Some(part).filter(|x| x.is_finite() && *x > 0.0) }
        }),
        temporal,
    })
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use super::*;
    use photosite_core::math::philox::Philox;

    const REQUEST: Request = Request { most_lag: 4, side: 8 };
    const SIZE: [usize; 2] = [96, 64];
    const PIXELS: f64 = 96.0 * 64.0;

    /// A patch of a plane through 1000 with a fixed pattern and temporal noise.
    fn image(number: u64, slopes: [f64; 2], pattern: f64, noise: f64) -> Patch {
        let [width, height] = SIZE;
        let value = |i: usize| {
            let normal = |key: u64| Philox::new(key, i as u64).sample::<f64, _>(StandardNormal);
            let [x, y] = [i % width, i / width].map(|n| n as f64);
            1000.0 + slopes[0] * x + slopes[1] * y + pattern * normal(1) + noise * normal(2 + number)
        };
        Patch::new(width, height, (0..width * height).map(value).collect()).expect("a patch")
    }

    #[test]
    fn several_images_tell_noise_from_pattern() {
        let images: Vec<Patch> = (0..8).map(|i| image(i, [0.0; 2], 5.0, 3.0)).collect();
        let known = Knowledge { black: 100.0, white: Some(4095.0), step: Some(1.0), variance: None };
        let found = estimate(&images, &known, REQUEST).expect("a patch");
        // Standard errors: σ²·√(2/freedom) with 7 degrees of freedom a pixel; 5 of them.
        let temporal = found.temporal.clone().expect("several images");
        assert_relative_eq!(
            temporal.noise.error,
            temporal.noise.variance * (2.0 / (7.0 * PIXELS)).sqrt(),
            max_relative = 1e-9
        );
        assert!((temporal.noise.variance - 9.0).abs() < 5.0 * temporal.noise.error, "{temporal:?}");
        // The average has the pattern's variance and an eighth of the noise's.
        assert!((found.uniform.variance - (25.0 + 9.0 / 8.0)).abs() < 5.0 * found.uniform.error);
        let pattern = temporal.pattern.expect("larger than what averaging leaves");
        assert!((pattern.variance - 25.0).abs() < 5.0 * found.uniform.error, "{pattern:?}");
        // (1000 − 100)/3 = 300: 49.54 dB, 8.229 bits. Effective bits: log₂(3995/(3·√12)) = 8.587.
        let within = 5.0 * temporal.noise.error / temporal.noise.variance;
        assert_relative_eq!(found.snr.ratio.expect("a signal"), 300.0, max_relative = within);
        assert_relative_eq!(found.snr.db.expect("a signal"), 49.542, epsilon = 10.0 * within);
        assert_relative_eq!(found.snr.bits.expect("a signal"), 8.2288, epsilon = 2.0 * within);
        assert_relative_eq!(found.snr.effective_bits.expect("a range"), 8.5866, epsilon = 2.0 * within);
        assert_relative_eq!(found.quantisation.expect("steps").variance, 1.0 / 12.0);
        // Signal: the pattern of σ = 5 over noise of 3, in amplitudes: 10·log₁₀(5/3) = 2.218, 20·log₁₀(5/3) = 4.437.
        let contrast = found.snr.contrast.expect("a pattern");
        assert_relative_eq!(contrast.signal_sigma, 5.0, max_relative = 5.0 * found.uniform.error / 50.0);
        assert_relative_eq!(contrast.db_of_sigma, 10.0 * contrast.ratio.log10(), max_relative = 1e-12);
        assert_relative_eq!(contrast.db, 2.0 * contrast.db_of_sigma, max_relative = 1e-12);
        let worst = found.snr.worst_ratio.expect("several images");
        assert_relative_eq!(worst, 900.0 / temporal.largest_sigma, max_relative = 1e-3);
        // Each pixel's σ has seven degrees of freedom, and all have the same noise.
        assert_eq!((temporal.map.count, temporal.map.freedom), (96 * 64, 7.0));
        assert!(temporal.map.p_value > 1e-3, "{:?}", temporal.map.p_value);
        assert_eq!(sigma_map(&images).expect("several").iter().copied().fold(0.0, f64::max), temporal.largest_sigma);
        assert!(sigma_map(&images[..1]).is_err());
        // The pattern is no plane, and the noise is known: χ² tells.
        let chi = found.plane.chi_squared.expect("the noise is known");
        assert!(chi.reduced > 20.0 && chi.p_value < 1e-12, "{chi:?}");
    }

    #[test]
    fn a_plane_takes_linear_shading_away() {
        let patch = image(0, [0.5, -0.25], 0.0, 2.0);
        let known = Knowledge { variance: Some(4.0), ..Knowledge::default() };
        let found = estimate(std::slice::from_ref(&patch), &known, REQUEST).expect("a patch");
        // Taken as even, shading counts as noise: Σ(0.5·x)² = ¼·(96² − 1)/12 and 1/16·(64² − 1)/12 on top.
        let shading = 0.25 * (96.0f64.powi(2) - 1.0) / 12.0 + (64.0f64.powi(2) - 1.0) / (16.0 * 12.0);
        assert_relative_eq!(found.uniform.variance, 4.0 + shading, max_relative = 0.02);
        // Errors of slopes: σ/√(Σ(x − x̄)²) = 2/√(n·(N² − 1)/12).
        let plane = found.plane;
        let slope_error = |side: f64| 2.0 / (PIXELS * (side * side - 1.0) / 12.0).sqrt();
        assert!((plane.slope[0] - 0.5).abs() < 5.0 * slope_error(96.0), "{plane:?}");
        assert!((plane.slope[1] + 0.25).abs() < 5.0 * slope_error(64.0), "{plane:?}");
        assert!((plane.noise.variance - 4.0).abs() < 5.0 * plane.noise.error, "{plane:?}");
        let chi = plane.chi_squared.expect("the noise is known");
        assert_eq!(chi.freedom, PIXELS - 3.0);
        // σ of the reduced χ² is √(2/freedom).
        assert!((chi.reduced - 1.0).abs() < 5.0 * (2.0 / PIXELS).sqrt() && chi.p_value > 1e-6, "{chi:?}");
        assert!(found.temporal.is_none());
    }

    #[test]
    fn a_plane_without_noise_leaves_nothing() {
        let patch = image(0, [0.5, -0.25], 0.0, 0.0);
        let found = estimate(&[patch], &Knowledge::default(), REQUEST).expect("a patch");
        assert_relative_eq!(found.plane.slope[0], 0.5, max_relative = 1e-12);
        assert_relative_eq!(found.plane.slope[1], -0.25, max_relative = 1e-12);
        assert!(found.plane.noise.sigma < 1e-9);
        // In the middle of the patch: 1000 + 0.5·47.5 − 0.25·31.5.
        assert_relative_eq!(found.mean, 1015.875, max_relative = 1e-12);
    }

    #[test]
    fn rounding_adds_a_twelfth_of_a_step() {
        // Noise of 2 steps is rounded: 4 + 1/12.
        let rounded = |number| {
            let Patch { width, height, values } = image(number, [0.0; 2], 0.0, 2.0);
            Patch::new(width, height, values.iter().map(|v| v.round()).collect()).expect("a patch")
        };
        let images: Vec<Patch> = (0..16).map(rounded).collect();
        let found =
            estimate(&images, &Knowledge { step: Some(1.0), ..Knowledge::default() }, REQUEST).expect("a patch");
        let noise = found.temporal.expect("several images").noise;
        assert!((noise.variance - 4.0 - 1.0 / 12.0).abs() < 5.0 * noise.error, "{noise:?}");
        // An error of 5·√(2/(15·6144)) = 2.3 % is a third of 1/12: without it the test would fail, too.
        assert!((noise.variance - 4.0) > 0.0);
        let part = found.quantisation.expect("steps").part_percent.expect("noise");
        assert_relative_eq!(part, 100.0 / 12.0 / noise.variance, max_relative = 1e-9);
    }

    #[test]
    fn what_is_no_patch_is_refused() {
        assert!(Patch::new(1, 4, vec![0.0; 4]).is_err());
        assert!(Patch::new(2, 2, vec![0.0; 5]).is_err());
        assert!(Patch::new(2, 2, vec![0.0, 1.0, f64::NAN, 1.0]).is_err());
        assert!(estimate(&[], &Knowledge::default(), REQUEST).is_err());
    }
}
