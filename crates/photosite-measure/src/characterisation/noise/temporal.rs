//! Noise from several images of the same light: what changes from one to the next at each pixel.

use serde::Serialize;

use super::patch::{Patch, Variance};
use super::sigma_distribution::SigmaDistribution;

/// Noise that changes from image to image ([TruccoVerri98](photosite_core::references#truccoverri98), algorithm
/// `EST_NOISE`).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TemporalNoise {
    /// Mean over all pixels of each pixel's sample variance over N images, Σ(y_i − ȳ)²/(N − 1).
    pub noise: Variance,
    /// Largest σ of a single pixel: the worst case of `EST_NOISE`, of which the mean of `map` is the other figure.
    pub largest_sigma: f64,
    /// The σ map, √(Σ(y_i − ȳ)²/(N − 1)) of each pixel, as a distribution of N − 1 degrees of freedom.
    pub map: SigmaDistribution,
    /// Fixed pattern: sample variance of the average image less noise/N; `None` where that is negative.
    pub pattern: Option<Variance>,
}

impl TemporalNoise {
    /// `None` for a single image.
    pub(super) fn new(patches: &[Patch]) -> Option<Self> {
        if patches.len() < 2 {
            return None;
        }
        let average = average(patches);
        let (images, pixels) = (patches.len() as f64, average.values.len() as f64);
        let freedom = images - 1.0;
        let sigmas = sigma_map(patches, &average);
        let noise = Variance::of(sigmas.iter().map(|s| freedom * s * s).sum(), pixels * freedom);
        let mean = average.mean();
        let spread: f64 = average.values.iter().map(|y| (y - mean).powi(2)).sum();
        let pattern = spread / (pixels - 1.0) - noise.variance / images;
        Some(Self {
            noise,
            largest_sigma: sigmas.iter().copied().fold(0.0, f64::max),
            map: SigmaDistribution::new(sigmas, freedom, noise.sigma),
            pattern: (pattern >= 0.0).then(|| Variance {
                // What averaging leaves is known much better than the spread.
                error: Variance::of(spread, pixels - 1.0).error,
                variance: pattern,
                sigma: pattern.sqrt(),
            }),
        })
    }
}

/// σ of each pixel over two or more images, √(Σ(y_i − ȳ)²/(N − 1)).
pub(super) fn sigma_map(patches: &[Patch], average: &Patch) -> Vec<f64> {
    let freedom = (patches.len() - 1) as f64;
    let squares = |(i, mean): (usize, &f64)| patches.iter().map(|p| (p.values[i] - mean).powi(2)).sum::<f64>();
    average.values.iter().enumerate().map(|pixel| (squares(pixel) / freedom).sqrt()).collect()
}

/// The average image.
pub(super) fn average(patches: &[Patch]) -> Patch {
    let mut average = patches[0].clone();
    for patch in &patches[1..] {
        average.values.iter_mut().zip(&patch.values).for_each(|(sum, y)| *sum += y);
    }
    let images = patches.len() as f64;
    average.values.iter_mut().for_each(|sum| *sum /= images);
    average
}

/// Deviations of each image from the average, scaled to the variance that they would have from the true mean.
pub(super) fn deviations(patches: &[Patch], average: &Patch) -> Vec<Vec<f64>> {
    let images = patches.len() as f64;
    let scale = (images / (images - 1.0)).sqrt();
    let deviation = |p: &Patch| p.values.iter().zip(&average.values).map(|(y, mean)| scale * (y - mean)).collect();
    patches.iter().map(deviation).collect()
}
