//! Spectrograms: at which spatial frequencies an image varies.

use photosite_fft::{Complex, forward_f64};

/// The direction of the frequencies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Along rows: patterns of columns show.
    Horizontal,
    /// Along columns: patterns of rows show.
    Vertical,
}

/// Mean power spectrum of the rows or columns of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrogram {
    /// Power at k/N cycles per pixel for k = 0 … N/2, in the squared unit of the image.
    pub power: Vec<f64>,
    /// Length N of the transform.
    pub length: usize,
}

impl Spectrogram {
    /// p\[k\] = ⟨|Σ_n (y\[n\] − μ)·exp(−2πi·k·n/N)|²⟩/N, averaged over the lines of the image, whose mean is μ
    /// ([Emva1288](photosite_core::references#emva1288), section on spectrograms). White noise has its variance at
    /// every frequency.
    pub fn new(image: &[f64], [width, height]: [usize; 2], direction: Direction) -> Self {
        let mean = image.iter().sum::<f64>() / image.len().max(1) as f64;
        let (length, lines) = match direction {
            Direction::Horizontal => (width, height),
            Direction::Vertical => (height, width),
        };
        let transform = forward_f64(length);
        let mut scratch = vec![Complex::default(); transform.get_inplace_scratch_len()];
        let mut line = vec![Complex::default(); length];
        let mut power = vec![0.0; length / 2 + 1];
        for i in 0..lines {
            for (k, value) in line.iter_mut().enumerate() {
                let at = match direction {
                    Direction::Horizontal => i * width + k,
                    Direction::Vertical => k * width + i,
                };
                *value = Complex::new(image[at] - mean, 0.0);
            }
            transform.process_with_scratch(&mut line, &mut scratch);
            power.iter_mut().zip(&line).for_each(|(sum, value)| *sum += value.norm_sqr());
        }
        let scale = 1.0 / (length.max(1) * lines.max(1)) as f64;
        power.iter_mut().for_each(|p| *p *= scale);
        Self { power, length }
    }

    /// (cycles per pixel, power) without the mean.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.power.iter().enumerate().skip(1).map(|(k, &power)| (k as f64 / self.length as f64, power))
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn a_wave_has_its_power_at_its_frequency() {
        // cos(2π·3·x/16) along rows: |Σ|² = (16/2)² at k = 3, over N = 16: 4. Along columns it is constant: each column
        // deviates from the mean by the wave, whose mean square is ½, times N = 8 at k = 0.
        let image: Vec<f64> =
            (0..16 * 8).map(|i| 5.0 + (std::f64::consts::TAU * 3.0 * f64::from(i % 16) / 16.0).cos()).collect();
        let along = Spectrogram::new(&image, [16, 8], Direction::Horizontal);
        assert_eq!(along.power.len(), 9);
        for (k, &power) in along.power.iter().enumerate() {
            assert_relative_eq!(power, if k == 3 { 4.0 } else { 0.0 }, epsilon = 1e-12);
        }
        let across = Spectrogram::new(&image, [16, 8], Direction::Vertical);
        assert_relative_eq!(across.power[0], 4.0, epsilon = 1e-12);
        assert!(across.points().all(|(_, power)| power < 1e-12));
    }

    #[test]
    fn power_sums_to_the_variance() {
        // Parseval: (p[0] + 2·Σ p[k] + p[N/2])/N is the mean square deviation.
        let image: Vec<f64> = (0..12 * 5).map(|i| f64::from(i * i % 17)).collect();
        let spectrum = Spectrogram::new(&image, [12, 5], Direction::Horizontal);
        let mean = image.iter().sum::<f64>() / 60.0;
        let variance = image.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / 60.0;
        let inner: f64 = spectrum.power[1..6].iter().sum();
        assert_relative_eq!(
            (spectrum.power[0] + 2.0 * inner + spectrum.power[6]) / 12.0,
            variance,
            max_relative = 1e-12
        );
    }
}
