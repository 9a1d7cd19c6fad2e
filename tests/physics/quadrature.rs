//! Numerical integrals over directions, the second route of the BSDF tests.

use std::f64::consts::PI;

use glam::Vec3;

/// The direction of cosine `z` and azimuth `phi`.
pub(crate) fn direction(z: f64, phi: f64) -> Vec3 {
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new((radius * phi.cos()) as f32, (radius * phi.sin()) as f32, z as f32)
}

/// Three-point Gauss–Legendre rule on [−1, 1].
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// See [`Cell::integrate`].
const LARGEST_PART: f64 = 2e-4;

/// A rectangle in (z, φ): its area is a solid angle.
#[derive(Clone, Copy)]
pub(crate) struct Cell {
    pub(crate) z: [f64; 2],
    pub(crate) phi: [f64; 2],
}

impl Cell {
    /// `rows` × `columns` cells over the whole sphere, lowest z first.
    pub(crate) fn sphere(rows: usize, columns: usize) -> Vec<Self> {
        let z = |i: usize| 2.0 * i as f64 / rows as f64 - 1.0;
        let phi = |i: usize| 2.0 * PI * i as f64 / columns as f64;
        let cell =
            |i: usize| Self { z: [z(i / columns), z(i / columns + 1)], phi: [phi(i % columns), phi(i % columns + 1)] };
        (0..rows * columns).map(cell).collect()
    }

    /// The nodes of a rule over the cell with their weights, which sum up to its solid angle.
    pub(crate) fn visit(&self, mut f: impl FnMut(Vec3, f64)) {
        let [(z, half_z), (phi, half_phi)] =
            [self.z, self.phi].map(|[low, high]| (0.5 * (low + high), 0.5 * (high - low)));
        for (node_z, weight_z) in GAUSS {
            for (node_phi, weight_phi) in GAUSS {
                let w = direction(z + node_z * half_z, phi + node_phi * half_phi);
                f(w, weight_z * weight_phi * half_z * half_phi);
            }
        }
    }

    fn rule(&self, f: &impl Fn(Vec3) -> f64) -> f64 {
        let mut sum = 0.0;
        self.visit(|w, weight| sum += weight * f(w));
        sum
    }

    /// The cell cut across z.
    pub(crate) fn slices(&self, count: usize) -> Vec<Self> {
        let [low, high] = self.z;
        let z = |i: usize| low + (high - low) * i as f64 / count as f64;
        (0..count).map(|i| Self { z: [z(i), z(i + 1)], phi: self.phi }).collect()
    }

    fn quarters(&self) -> [Self; 4] {
        let [z, phi] = [self.z, self.phi].map(|[low, high]| [low, 0.5 * (low + high), high]);
        std::array::from_fn(|i| Self { z: [z[i / 2], z[i / 2 + 1]], phi: [phi[i % 2], phi[i % 2 + 1]] })
    }

    /// ∫ f dω over the cell, split until the rule on the parts agrees with the rule on the whole to `tolerance`, an
    /// upper bound of the error where f is smooth, shared among the parts; and until no part holds more than
    /// [`LARGEST_PART`], since a jump of f between the nodes goes unseen.
    pub(crate) fn integrate(&self, f: &impl Fn(Vec3) -> f64, tolerance: f64) -> f64 {
        self.refine(f, self.rule(f), tolerance, 7)
    }

    fn refine(&self, f: &impl Fn(Vec3) -> f64, whole: f64, tolerance: f64, splits_left: u32) -> f64 {
        let quarters = self.quarters();
        let parts = quarters.map(|quarter| quarter.rule(f));
        let sum = parts.iter().sum::<f64>();
        if splits_left == 0 || (sum - whole).abs() <= tolerance && sum <= LARGEST_PART {
            return sum;
        }
        let refine = |(quarter, &part): (&Self, &f64)| quarter.refine(f, part, 0.25 * tolerance, splits_left - 1);
        quarters.iter().zip(&parts).map(refine).sum()
    }
}

/// ∫ f dω over the whole sphere with an error of some 1e-5 for lobes wider than 0.03 rad and integrals of order 1.
pub(crate) fn integrate_sphere(f: impl Fn(Vec3) -> f64) -> f64 {
    // 1152 cells of 1e-7, most of them far from any lobe.
    Cell::sphere(24, 48).iter().map(|cell| cell.integrate(&f, 1e-7)).sum()
}

#[test]
fn moments_of_the_sphere() {
    assert!((integrate_sphere(|_| 1.0) - 4.0 * PI).abs() < 1e-9);
    assert!((integrate_sphere(|w| f64::from(w.x).powi(2)) - 4.0 * PI / 3.0).abs() < 1e-6);
}

#[test]
fn a_narrow_lobe_is_not_missed() {
    // ∫ exp(κ(cos γ − 1)) dω = 2π(1 − e^(−2κ))/κ for any axis; κ = 1000 is a lobe 0.03 rad wide.
    let axis = direction(0.3, 1.234);
    let integral = integrate_sphere(|w| (1000.0 * f64::from(w.dot(axis) - 1.0)).exp());
    assert!((integral - 2.0 * PI / 1000.0).abs() < 1e-5, "{integral}");
}
