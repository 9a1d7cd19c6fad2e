//! Brown–Conrady distortion, from ideal to distorted image coordinates: OpenCV's standard model, without its tilted
//! sensor.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2};
use serde::{Deserialize, Serialize};

use super::reach::FLAT_ANGLE;
use super::rising::{first_loss, solve};

/// Radial, rational, tangential and thin-prism coefficients of OpenCV, which names and orders them as here
/// ([Brown71](crate::references#brown71), [OpenCv](crate::references#opencv)):
///
/// x' = x·R + 2p₁xy + p₂(r² + 2x²) + s₁r² + s₂r⁴
///
/// y' = y·R + p₁(r² + 2y²) + 2p₂xy + s₃r² + s₄r⁴
///
/// R = (1 + k₁r² + k₂r⁴ + k₃r⁶)/(1 + k₄r² + k₅r⁴ + k₆r⁶), r² = x² + y².
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BrownConrady {
    /// k₁ … k₆.
    pub k: [f64; 6],
    /// p₁, p₂.
    pub p: [f64; 2],
    /// s₁ … s₄.
    pub s: [f64; 4],
}

impl BrownConrady {
    /// Whether all coefficients are 0.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    fn is_radial(&self) -> bool {
        self.p == [0.0; 2] && self.s == [0.0; 4]
    }

    /// R and dR/d(r²); not positive beyond a pole.
    #[inline]
    fn radial(&self, r2: f64) -> (f64, f64) {
        let [k1, k2, k3, k4, k5, k6] = self.k;
        let over = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let under = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
        if under <= 0.0 {
            return (f64::NAN, f64::NAN);
        }
        let (d_over, d_under) = (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3), k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6));
        let radial = over / under;
        (radial, (d_over - radial * d_under) / under)
    }

    /// Ideal → distorted.
    #[inline]
    pub fn distort(&self, ideal: DVec2) -> DVec2 {
        let DVec2 { x, y } = ideal;
        let ([p1, p2], [s1, s2, s3, s4]) = (self.p, self.s);
        let r2 = x * x + y * y;
        let radial = self.radial(r2).0;
        DVec2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + r2 * s2),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s3 + r2 * s4),
        )
    }

    /// The derivative of [`distort`](Self::distort), columns d/dx and d/dy.
    #[inline]
    fn jacobian(&self, DVec2 { x, y }: DVec2) -> DMat2 {
        let ([p1, p2], [s1, s2, s3, s4]) = (self.p, self.s);
        let r2 = x * x + y * y;
        let (radial, slope) = self.radial(r2);
        let (prism_x, prism_y) = (2.0 * (s1 + 2.0 * r2 * s2), 2.0 * (s3 + 2.0 * r2 * s4));
        let mixed = 2.0 * slope * x * y;
        DMat2::from_cols(
            DVec2::new(
                radial + 2.0 * slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x + prism_x * x,
                mixed + 2.0 * p1 * x + 2.0 * p2 * y + prism_y * x,
            ),
            DVec2::new(
                mixed + 2.0 * p1 * x + 2.0 * p2 * y + prism_x * y,
                radial + 2.0 * slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x + prism_y * y,
            ),
        )
    }

    /// Radius of the largest disk of the ideal image in which the map does not fold back: the determinant of its
    /// Jacobian stays above 0. `None` where that holds up to 90° from the axis.
    pub(super) fn fold(&self) -> Option<f64> {
        // A function of the radius alone is looked at closely; otherwise in many directions.
        let (directions, steps) = if self.is_radial() { (1, 8192) } else { (128, 1024) };
        let folds = (0..directions).filter_map(|i| {
            let along = DVec2::from_angle(TAU * f64::from(i) / f64::from(directions));
            let rises = |angle: f64| self.jacobian(along * angle.tan()).determinant() > 0.0;
            first_loss(rises, FLAT_ANGLE, steps)
        });
        folds.min_by(f64::total_cmp).map(f64::tan)
    }

    /// Distorted → ideal within a radius of the ideal image, and the determinant of the Jacobian there: area in the
    /// distorted over area in the ideal image. `None` where the model has no inverse.
    ///
    /// The radial part is solved first, exactly; Newton's method in two dimensions, which steps back where it does not
    /// get nearer, goes on from there.
    #[inline]
    pub(super) fn undistort(&self, distorted: DVec2, radius: f64) -> Option<(DVec2, f64)> {
        let distance = distorted.length();
        if distance == 0.0 && self.is_radial() {
            return Some((distorted, 1.0));
        }
        let along_radius = |r: f64| {
            let (radial, slope) = self.radial(r * r);
            (r * radial, radial + 2.0 * r * r * slope)
        };
        let of_radius = |distance: f64| solve(along_radius, distance, distance, radius);
        let mut ideal = if self.is_radial() {
            distorted * (of_radius(distance)? / distance)
        } else {
            // Tangential parts may bring back what the radial part alone does not reach.
            let start = of_radius(distance.min(along_radius(radius).0)).unwrap_or(0.0);
            self.newton(distorted, distorted.normalize_or_zero() * start, radius)?
        };
        let determinant = self.jacobian(ideal).determinant();
        if ideal.length() > radius {
            ideal *= radius / ideal.length();
        }
        (determinant > 0.0).then_some((ideal, determinant))
    }

    fn newton(&self, distorted: DVec2, start: DVec2, radius: f64) -> Option<DVec2> {
        let mut ideal = start;
        let mut residual = self.distort(ideal) - distorted;
        for _ in 0..60 {
            let step = self.jacobian(ideal).inverse() * residual;
            if !step.is_finite() {
                return None;
            }
            // Residuals of a few roundings cannot be made smaller.
            if step.length() <= 2.0 * f64::EPSILON * (1.0 + ideal.length()) {
                break;
            }
            let better = (0..30).find_map(|halvings| {
                let next = ideal - step * 0.5_f64.powi(halvings);
                let left = self.distort(next) - distorted;
                (next.length() <= radius * (1.0 + 1e-12) && left.length() < residual.length()).then_some((next, left))
            });
            let Some((next, left)) = better else { break };
            (ideal, residual) = (next, left);
        }
        (residual.length() < 1e-13 * (1.0 + distorted.length())).then_some(ideal)
    }
}
