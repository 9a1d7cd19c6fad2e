//! Images of edges for tests, and their exact transfer function.

use std::f64::consts::{PI, SQRT_2};

/// The standard normal distribution: the edge spread function of a Gaussian.
pub(super) fn normal(x: f64) -> f64 {
    0.5 * (1.0 + libm::erf(x / SQRT_2))
}

/// The transform of a Gaussian times those of the pixel's sides, seen along the normal of an edge.
pub(super) fn truth(f: f64, angle_deg: f64, sigma: f64) -> f64 {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    (-2.0 * (PI * sigma * f).powi(2)).exp() * sinc(f * cos) * sinc(f * sin)
}

/// Random numbers of an even distribution with mean 0 and standard deviation 1.
pub(super) struct Even(pub(super) u64);

impl Even {
    pub(super) fn next(&mut self) -> f64 {
        // Knuth's linear congruential generator, of whose bits the upper ones serve.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as f64 / f64::from(1u32 << 31) - 0.5) * 12f64.sqrt()
    }
}
