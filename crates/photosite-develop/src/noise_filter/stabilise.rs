//! Variance stabilisation: shot noise grows with the signal; after the generalised Anscombe transform it is the same
//! everywhere, with a standard deviation of 1 ([Makitalo13](photosite_core::references#makitalo13)).
//!
//! For a variance of S·x + O: f(x) = (2/S)·√(S·x + ⅜·S² + O), and x/σ where there is no shot noise (S = 0). Below
//! black, to where read noise spreads, it goes on along its tangent there.

use photosite_core::rows::for_each_value;

/// Variance S·x + O of a plane.
pub(super) struct NoiseModel {
    s: f32,
    o: f32,
}

impl NoiseModel {
    /// Model of S and O, not both 0.
    pub(super) fn new(s: f64, o: f64) -> Self {
        Self { s: s as f32, o: o as f32 }
    }

    /// Noise of the same size everywhere, from what a mask that even gradients do not pass leaves of the image: the
    /// median of |v * (1 −2 1; −2 4 −2; 1 −2 1)| over 6·0.6745, of which 6σ is the standard deviation
    /// ([Immerkaer96](photosite_core::references#immerkaer96)).
    pub(super) fn estimated(plane: &[f32], [width, height]: [usize; 2]) -> Self {
        let mut left: Vec<f32> = Vec::new();
        for y in 1..height.max(1) - 1 {
            for x in 1..width.max(1) - 1 {
                let at = |dx: usize, dy: usize| plane[(y + dy - 1) * width + x + dx - 1];
                let corners = at(0, 0) + at(2, 0) + at(0, 2) + at(2, 2);
                let sides = at(1, 0) + at(0, 1) + at(2, 1) + at(1, 2);
                left.push((corners - 2.0 * sides + 4.0 * at(1, 1)).abs());
            }
        }
        let middle = left.len() / 2;
        let median = if left.is_empty() { 0.0 } else { *left.select_nth_unstable_by(middle, f32::total_cmp).1 };
        // An image without any noise needs no filter, and zero no division.
        let sigma = (median / (6.0 * 0.6745)).max(1e-6);
        Self { s: 0.0, o: sigma * sigma }
    }

    /// Values whose noise has a standard deviation of 1.
    pub(super) fn forward(&self, mut plane: Vec<f32>) -> Vec<f32> {
        let Self { s, o } = *self;
        let at_black = (0.375 * s * s + o).sqrt();
        for_each_value(&mut plane, |x| {
            *x = if s == 0.0 {
                *x / o.sqrt()
            } else if *x > 0.0 {
                2.0 / s * (s * *x + 0.375 * s * s + o).sqrt()
            } else {
                2.0 / s * at_black + *x / at_black
            };
        });
        plane
    }

    /// The values before the transform. What noise is left in f makes the mean of its squares too large, at most by
    /// S/4, a quarter of an electron.
    pub(super) fn inverse(&self, mut plane: Vec<f32>) -> Vec<f32> {
        let Self { s, o } = *self;
        let at_black = (0.375 * s * s + o).sqrt();
        for_each_value(&mut plane, |f| {
            *f = if s == 0.0 {
                *f * o.sqrt()
            } else if *f > 2.0 / s * at_black {
                0.25 * s * *f * *f - 0.375 * s - o / s
            } else {
                (*f - 2.0 / s * at_black) * at_black
            };
        });
        plane
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes_the_transform_and_noise_is_1() {
        for (s, o) in [(4e-4, 1e-6), (0.0, 1e-5), (1e-3, 0.0)] {
            let model = NoiseModel::new(s, o);
            let values: Vec<f32> = (-20..=1000).map(|i| i as f32 * 1e-3).collect();
            let back = model.inverse(model.forward(values.clone()));
            // Squares of f = 2/√S lose half the digits of a f32 below S.
            assert!(values.iter().zip(&back).all(|(v, b)| (v - b).abs() < 1e-5), "{s} {o}");
            for x in [0.05f32, 0.5] {
                let step = ((s as f32 * x + o as f32) as f64).sqrt() as f32;
                let pair = model.forward(vec![x - 0.5 * step, x + 0.5 * step]);
                // The transform is a straight line over one standard deviation but for (σ/x)², below 1 % here, and
                // ⅜·S² beneath the root.
                assert!((pair[1] - pair[0] - 1.0).abs() < 0.02, "{s} {o} {x}: {}", pair[1] - pair[0]);
            }
        }
    }
}
