//! Histograms of planes.

use serde::Serialize;

use photosite_core::image::Channel;

/// Histogram: the number of values in each bin, with their mean, standard deviation and percentiles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Histogram {
    /// Name of the plane.
    pub channel: String,
    /// Lower edge of the first bin and upper edge of the last; the last bin includes its upper edge.
    pub range: [f64; 2],
    /// Values in each bin.
    pub counts: Vec<u64>,
    /// Values below the range.
    pub below: u64,
    /// Values above the range.
    pub above: u64,
    /// Values that are not finite.
    pub not_finite: u64,
    /// Mean of all finite values.
    pub mean: f64,
    /// Standard deviation of all finite values.
    pub standard_deviation: f64,
    /// Percentiles: values that 1, 5, 25, 50, 75, 95 and 99 % of the finite values lie at or below.
    pub percentiles: [f64; 7],
}

const PERCENT: [f64; 7] = [1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0];

/// Histogram of a plane with `bins` bins of equal width, at least 1, over a range, or over all its values.
pub fn histogram(channel: &Channel, bins: usize, range: Option<[f64; 2]>) -> Histogram {
    let mut sorted: Vec<f64> = channel.data.iter().filter(|v| v.is_finite()).map(|&v| f64::from(v)).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let [low, high] = range.unwrap_or([sorted.first().copied().unwrap_or(0.0), sorted.last().copied().unwrap_or(1.0)]);
    let mut counts = vec![0; bins.max(1)];
    let (mut below, mut above) = (0, 0);
    for &value in &sorted {
        if value < low {
            below += 1;
        } else if value > high {
            above += 1;
        } else {
            let place = (value - low) / (high - low) * counts.len() as f64;
            // 0/0 where all values are the same; a cast takes it to 0.
            let bin = (place as usize).min(counts.len() - 1);
            counts[bin] += 1;
        }
    }
    let n = sorted.len().max(1) as f64;
    let mean = sorted.iter().sum::<f64>() / n;
    let variance = sorted.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    let at = |percent: f64| {
        let rank = (percent / 100.0 * n).ceil() as usize;
        sorted.get(rank.clamp(1, sorted.len().max(1)) - 1).copied().unwrap_or(0.0)
    };
    Histogram {
        channel: channel.name.clone(),
        range: [low, high],
        counts,
        below,
        above,
        not_finite: (channel.data.len() - sorted.len()) as u64,
        mean,
        standard_deviation: variance.sqrt(),
        percentiles: PERCENT.map(at),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(data: &[f32], bins: usize, range: Option<[f64; 2]>) -> Histogram {
        histogram(&Channel { name: "Y".to_owned(), data: data.to_vec() }, bins, range)
    }

    #[test]
    fn counts_by_hand() {
        let found = of(&[0.0, 0.1, 0.5, 0.99, 1.0, 1.5, -2.0, f32::NAN], 2, Some([0.0, 1.0]));
        assert_eq!((found.counts, found.below, found.above, found.not_finite), (vec![2, 3], 1, 1, 1));
        let found = of(&(1..=100).map(|v| v as f32).collect::<Vec<_>>(), 10, None);
        assert_eq!((found.counts, found.range), (vec![10; 10], [1.0, 100.0]));
        assert_eq!(found.percentiles, PERCENT);
        assert_eq!((found.mean, found.standard_deviation), (50.5, (9999.0f64 / 12.0).sqrt()));
    }

    #[test]
    fn one_value_and_none() {
        assert_eq!(of(&[3.0; 5], 4, None).counts, [5, 0, 0, 0]);
        let none = of(&[], 4, None);
        assert_eq!((none.counts, none.mean), (vec![0; 4], 0.0));
    }
}
