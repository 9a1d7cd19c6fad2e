//! Histograms of averaged images: how many pixels deviate how far.

/// Counts of evenly spaced bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Lower end of the first bin.
    pub start: f64,
    /// Width of a bin.
    pub width: f64,
    /// Values in each bin.
    pub counts: Vec<u64>,
    /// Mean of all values.
    pub mean: f64,
    /// Standard deviation of all values.
    pub standard_deviation: f64,
}

impl Histogram {
    /// Counts finite values in at most `most` bins, or one more. Values that were averaged from whole numbers lie
    /// `quantum` apart, or some multiple of it: so must the bins, or some would collect more values than others.
    pub fn new(values: &[f64], quantum: f64, most: usize) -> Self {
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let standard_deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let steps = if high > low { (high - low) / quantum } else { 0.0 };
        let width = quantum * (steps / most.max(1) as f64).ceil().max(1.0);
        // The first bin has the smallest value of its quanta in the middle.
        let low = low - 0.5 * quantum;
        let bins = (((high - low) / width) as usize + 1).min(most + 1);
        let mut counts = vec![0; bins];
        for value in values {
            counts[(((value - low) / width) as usize).min(bins - 1)] += 1;
        }
        let start = if values.is_empty() { 0.0 } else { low };
        Self { start, width, counts, mean, standard_deviation }
    }

    /// Centre and count of each bin.
    pub fn bins(&self) -> impl Iterator<Item = (f64, u64)> + '_ {
        self.counts.iter().enumerate().map(|(i, &count)| (self.start + (i as f64 + 0.5) * self.width, count))
    }

    /// Values that a bin around `x` would hold of a normal distribution of the same mean and standard deviation.
    pub fn normal(&self, x: f64) -> f64 {
        let total: u64 = self.counts.iter().sum();
        let z = (x - self.mean) / self.standard_deviation;
        let density = (-0.5 * z * z).exp() / ((2.0 * std::f64::consts::PI).sqrt() * self.standard_deviation);
        total as f64 * self.width * density
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_counted_once() {
        let values: Vec<f64> = (0..1000).map(|i| f64::from(i * i % 997)).collect();
        let histogram = Histogram::new(&values, 1.0, 64);
        assert!((60..=65).contains(&histogram.counts.len()));
        assert_eq!(histogram.counts.iter().sum::<u64>(), 1000);
        let same = Histogram::new(&[2.0; 5], 1.0, 64);
        assert_eq!((same.counts, same.mean, same.standard_deviation), (vec![5], 2.0, 0.0));
    }

    #[test]
    fn bins_hold_as_many_quanta_as_each_other() {
        // Every value from 0 to 49.9 in steps of 0.1, twice: bins of 8 quanta hold 16 values each, but for the last.
        let values: Vec<f64> = (0..1000).map(|i| f64::from(i / 2) * 0.1).collect();
        let histogram = Histogram::new(&values, 0.1, 64);
        assert!((histogram.width - 0.8).abs() < 1e-12);
        assert!(histogram.counts[..62].iter().all(|&count| count == 16), "{:?}", histogram.counts);
        let (centre, _) = histogram.bins().next().expect("bins");
        assert!((centre - 0.35).abs() < 1e-12, "the middle of 0, 0.1 … 0.7");
    }
}
