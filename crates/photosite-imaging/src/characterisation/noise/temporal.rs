//! Noise from several pictures of the same light: what changes from one to the next at each pixel.

use serde::Serialize;

use super::patch::{Patch, Variance};

/// Noise that changes from picture to picture ([TruccoVerri98](photosite_core::references#truccoverri98), algorithm
/// `EST_NOISE`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TemporalNoise {
    /// Mean over all pixels of each pixel's sample variance over N pictures, Σ(y_i − ȳ)²/(N − 1).
    pub noise: Variance,
    /// Largest σ of a single pixel.
    pub largest_sigma: f64,
    /// Fixed pattern: sample variance of the average picture less noise/N; `None` where that is negative.
    pub pattern: Option<Variance>,
}

impl TemporalNoise {
    /// `None` for a single picture.
    pub(super) fn new(patches: &[Patch]) -> Option<Self> {
        if patches.len() < 2 {
            return None;
        }
        let average = average(patches);
        let (pictures, pixels) = (patches.len() as f64, average.values.len() as f64);
        let of_pixel = |(i, mean): (usize, &f64)| patches.iter().map(|p| (p.values[i] - mean).powi(2)).sum::<f64>();
        let squares = || average.values.iter().enumerate().map(of_pixel);
        let noise = Variance::of(squares().sum(), pixels * (pictures - 1.0));
        let largest = squares().fold(0.0, f64::max);
        let mean = average.mean();
        let spread: f64 = average.values.iter().map(|y| (y - mean).powi(2)).sum();
        let pattern = spread / (pixels - 1.0) - noise.variance / pictures;
        Some(Self {
            noise,
            largest_sigma: (largest / (pictures - 1.0)).sqrt(),
            pattern: (pattern >= 0.0).then(|| Variance {
                // What averaging leaves is known much better than the spread.
                error: Variance::of(spread, pixels - 1.0).error,
                variance: pattern,
                sigma: pattern.sqrt(),
            }),
        })
    }
}

/// The average picture.
pub(super) fn average(patches: &[Patch]) -> Patch {
    let mut average = patches[0].clone();
    for patch in &patches[1..] {
        average.values.iter_mut().zip(&patch.values).for_each(|(sum, y)| *sum += y);
    }
    let pictures = patches.len() as f64;
    average.values.iter_mut().for_each(|sum| *sum /= pictures);
    average
}

/// Deviations of each picture from the average, scaled to the variance that they would have from the true mean.
pub(super) fn deviations(patches: &[Patch], average: &Patch) -> Vec<Vec<f64>> {
    let pictures = patches.len() as f64;
    let scale = (pictures / (pictures - 1.0)).sqrt();
    let deviation = |p: &Patch| p.values.iter().zip(&average.values).map(|(y, mean)| scale * (y - mean)).collect();
    patches.iter().map(deviation).collect()
}
