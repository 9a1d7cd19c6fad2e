//! Pixels that do not work as the others, found in averages and in the slope of the dark signal over time.

use serde::Serialize;

use super::measured::Measured;

/// Defective pixel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Defect {
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// Kind.
    pub kind: DefectKind,
    /// What a hot pixel has more of dark signal than others, DN/s, or the number of a stuck one, DN.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
}

/// Kinds of defective pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DefectKind {
    /// Much more dark current than others.
    Hot,
    /// No answer to light.
    Dead,
    /// Always the same number.
    Stuck,
    /// A response or an offset far from that of the others.
    Odd,
}

/// Standard deviations of a pattern beyond which a pixel is no part of it. Of normal numbers, one in 10¹⁵ lies there.
const FAR: f64 = 8.0;

/// Deviations of an image from its rows' and columns' medians, with their robust standard deviation.
pub(super) struct Outliers {
    /// Deviation of every pixel.
    pub deviations: Vec<f64>,
    /// 1.4826 times the median of their absolute values.
    pub sigma: f64,
}

impl Outliers {
    /// Deviations in an image of this width.
    pub(super) fn of(image: &[f64], width: usize) -> Self {
        let mut deviations = image.to_vec();
        for line in deviations.chunks_exact_mut(width) {
            let middle = median(&mut line.to_vec());
            line.iter_mut().for_each(|value| *value -= middle);
        }
        for x in 0..width {
            let middle = median(&mut deviations[x..].iter().step_by(width).copied().collect::<Vec<_>>());
            deviations[x..].iter_mut().step_by(width).for_each(|value| *value -= middle);
        }
        let sigma = 1.4826 * median(&mut deviations.iter().map(|d| d.abs()).collect::<Vec<_>>());
        Self { deviations, sigma }
    }

    /// Deviation beyond which pixels are no part of the pattern. `step` is what numbers of so many images differ by at
    /// least: a pattern below it is hidden by quantisation.
    pub(super) fn threshold(&self, step: f64) -> f64 {
        FAR * self.sigma.max(step)
    }

    /// The same of dark currents, whose pattern is log-normal and reaches farther where it is wide. `noise` is the
    /// standard deviation that temporal noise leaves.
    pub(super) fn uneven_threshold(&self, image: &[f64], noise: f64) -> f64 {
        let middle = median(&mut image.to_vec());
        let pattern = (self.sigma.powi(2) - noise.powi(2)).max(0.0).sqrt();
        let reach = (FAR_LOGARITHM * (pattern / middle).ln_1p()).exp_m1() * middle;
        let threshold = self.threshold(0.0);
        if middle > self.sigma { threshold.max(reach) } else { threshold }
    }
}

/// Standard deviations of the logarithm beyond which a dark current is no part of a log-normal pattern. Of normal
/// numbers, one in 10⁸ lies there.
const FAR_LOGARITHM: f64 = 5.6;

/// Middle value; 0 for none.
fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Part of the pixels that are hot and what each has more on average, in the unit of the deviations; `Err` with their
/// number where these are too few. Of an exponential distribution, the part beyond a threshold T has the mean T + m: so
/// m is known of those, and n of them stand for n·exp(T/m) of all.
pub(super) fn hot_pixels(deviations: &[f64], threshold: f64) -> Result<[Measured; 2], usize> {
    const FEWEST: usize = 20;
    let beyond: Vec<f64> = deviations.iter().filter(|&&d| d > threshold).map(|d| d - threshold).collect();
    if beyond.len() < FEWEST {
        return Err(beyond.len());
    }
    let count = beyond.len() as f64;
    let mean = beyond.iter().sum::<f64>() / count;
    let mean = Measured::new(mean, mean / count.sqrt());
    let part = count / deviations.len() as f64 * (threshold / mean.value).exp();
    let relative = ((1.0 + (threshold / mean.value).powi(2)) / count).sqrt();
    Ok([Measured::new(part, part * relative), mean])
}

/// Gives each defective pixel the number of the good one that stands for it.
pub(super) fn mend(image: &mut [u16], replacements: &[(usize, usize)]) {
    for &(defective, good) in replacements {
        image[defective] = image[good];
    }
}

/// The good pixel of its row that stands for each defective one, the nearest.
pub(super) fn replacements(defects: &[Defect], width: usize) -> Vec<(usize, usize)> {
    let mut places: Vec<usize> = defects.iter().map(|d| d.y * width + d.x).collect();
    places.sort_unstable();
    places.dedup();
    let good = |place: usize| {
        let row = place - place % width;
        let near = (1..width).flat_map(|step| [place.checked_add(step), place.checked_sub(step)]);
        near.flatten().find(|&other| (row..row + width).contains(&other) && places.binary_search(&other).is_err())
    };
    places.iter().filter_map(|&place| Some((place, good(place)?))).collect()
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::{Exp1, StandardNormal};

    use super::*;
    use photosite_core::math::philox::Philox;

    #[test]
    fn hot_pixels_are_counted_beyond_the_threshold_too() {
        let [part, mean] = [0.01, 30.0];
        let value = |i: u64| {
            let mut random = Philox::new(3, i);
            let is_hot = random.random::<f64>() < part;
            let more = if is_hot { mean * random.sample::<f64, _>(Exp1) } else { 0.0 };
            100.0 + more + random.sample::<f64, _>(StandardNormal)
        };
        let image: Vec<f64> = (0..200 * 200).map(value).collect();
        let outliers = Outliers::of(&image, 200);
        assert!((outliers.sigma - 1.0).abs() < 0.03, "{}", outliers.sigma);
        let [found_part, found_mean] = hot_pixels(&outliers.deviations, outliers.threshold(0.0)).expect("many");
        assert!((found_part.value - part).abs() < 4.0 * found_part.standard_error, "{found_part:?}");
        assert!((found_mean.value - mean).abs() < 4.0 * found_mean.standard_error, "{found_mean:?}");
        assert!(found_part.standard_error < 0.1 * part && found_mean.standard_error < 0.1 * mean);
        assert_eq!(hot_pixels(&[0.0, 9.0], 8.0), Err(1));
    }

    #[test]
    fn good_neighbours_stand_for_defective_pixels() {
        let defect = |x, y| Defect { x, y, kind: DefectKind::Odd, value: None };
        let found = replacements(&[defect(1, 0), defect(2, 0), defect(3, 1)], 4);
        assert_eq!(found, [(1, 0), (2, 3), (7, 6)]);
        let mut image = [1, 2, 3, 4, 5, 6, 7, 8];
        mend(&mut image, &found);
        assert_eq!(image, [1, 1, 4, 4, 5, 6, 7, 7]);
    }
}
