//! Lens distortion at ray level: a pixel's distorted position is undistorted before its ray is made, so that nothing is
//! resampled and the corners are filled.

use glam::DVec2;

use super::Distortion;

impl Distortion {
    /// Ideal → distorted normalised coordinates (x/z, y/z with y down), OpenCV's `distortPoints`:
    /// x' = x·(1 + k₁r² + k₂r⁴ + k₃r⁶) + 2p₁xy + p₂(r² + 2x²), and y' likewise with p₁ and p₂ exchanged.
    pub fn distort(&self, p: DVec2) -> DVec2 {
        match *self {
            Self::None => p,
            Self::BrownConrady { k, p: [p1, p2] } => {
                let (x, y, r2) = (p.x, p.y, p.length_squared());
                let radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]));
                DVec2::new(
                    x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                    y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
                )
            }
        }
    }

    /// Distorted → ideal coordinates by Newton's method with a numerical Jacobian, from the distorted point. `None`
    /// where the model has no inverse there: beyond the radius at which it folds back.
    pub fn undistort(&self, distorted: DVec2) -> Option<DVec2> {
        if *self == Self::None {
            return Some(distorted);
        }
        let step = 1e-6;
        let mut p = distorted;
        for _ in 0..50 {
            let residual = self.distort(p) - distorted;
            let dx = (self.distort(p + DVec2::X * step) - self.distort(p - DVec2::X * step)) / (2.0 * step);
            let dy = (self.distort(p + DVec2::Y * step) - self.distort(p - DVec2::Y * step)) / (2.0 * step);
            let determinant = dx.perp_dot(dy);
            // A fold: the map turns space inside out.
            if determinant.is_nan() || determinant <= 0.0 {
                return None;
            }
            if residual.length_squared() < 1e-24 {
                return Some(p);
            }
            p -= DVec2::new(residual.perp_dot(dy), dx.perp_dot(residual)) / determinant;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undistortion_inverts_distortion() {
        for (k, p) in
            [([-0.12, 0.03, 0.0], [0.0, 0.0]), ([0.2, -0.05, 0.01], [1e-3, -2e-3]), ([-0.3, 0.1, 0.0], [0.0, 1e-3])]
        {
            let model = Distortion::BrownConrady { k, p };
            for i in 0..=10 {
                for j in 0..=10 {
                    let ideal = DVec2::new(f64::from(i) * 0.12 - 0.6, f64::from(j) * 0.1 - 0.5);
                    let found = model.undistort(model.distort(ideal)).expect("within the fold");
                    assert!((found - ideal).length() < 1e-10, "{model:?} {ideal}: {found}");
                }
            }
        }
    }

    #[test]
    fn beyond_the_fold_there_is_no_ray() {
        // r·(1 − 0.3r²) is largest at r = 1.054 with value 0.70.
        let model = Distortion::BrownConrady { k: [-0.3, 0.0, 0.0], p: [0.0, 0.0] };
        assert!(model.undistort(DVec2::new(0.8, 0.0)).is_none());
        assert!(model.undistort(DVec2::new(0.65, 0.0)).is_some());
    }
}
