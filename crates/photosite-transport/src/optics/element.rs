//! Lens elements: how strongly a piece of glass bends light, at each wavelength.

use photosite_core::Invalid;
use photosite_core::spectrum::{Dispersion, dispersion};

/// The wavelength that focal lengths are stated at, nm: the d line.
pub(super) const NOMINAL_NM: f64 = dispersion::lines::D;

/// A lens that is ground of one piece of glass, with two spherical surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundLens {
    /// Radii of curvature of the front and the back surface, m: above 0 where the centre lies on the side of the
    /// sensor, infinite for a flat surface. A biconvex lens has R₁ > 0 and R₂ < 0.
    pub radii_m: [f64; 2],
    /// Thickness on the axis, m, 0 or more.
    pub thickness_m: f64,
    /// Refractive index.
    pub index: Dispersion,
}

impl GroundLens {
    /// The power P = 1/f at a wavelength in nm, m⁻¹, by the lensmaker's equation
    /// ([Born99](photosite_core::references#born99) §4.4.3),
    ///
    /// P = (n − 1)·[1/R₁ − 1/R₂ + (n − 1)·d/(n·R₁·R₂)].
    ///
    /// Distances of object and image count from the principal planes, which stand for one plane here.
    pub fn power(&self, lambda_nm: f64) -> f64 {
        let n = self.index.index(lambda_nm);
        let [c1, c2] = self.radii_m.map(f64::recip);
        (n - 1.0) * (c1 - c2 + (n - 1.0) * self.thickness_m * c1 * c2 / n)
    }

    /// Refuses radii of 0, a thickness below 0, and a piece of glass that bends nothing. Keys are those of the capture
    /// file's table.
    pub fn validate(&self) -> Result<(), Invalid> {
        if self.radii_m.iter().any(|r| r.is_nan() || *r == 0.0) {
            let message = format!("a radius cannot be {} mm", self.radii_m.map(|r| r * 1e3).map(as_text).join(", "));
            return Err(Invalid::new("radii_mm", message).help("for example radii_mm = [50, -50], or \"flat\" for one"));
        }
        if !(self.thickness_m.is_finite() && self.thickness_m >= 0.0) {
            let message = format!("must be 0 or more, got {} mm", self.thickness_m * 1e3);
            return Err(Invalid::new("thickness_mm", message));
        }
        if self.power(NOMINAL_NM).abs() < LEAST_POWER {
            let message = "these surfaces bend no light: the focal length is infinite";
            return Err(Invalid::new("radii_mm", message).help("for example radii_mm = [50, -50]"));
        }
        Ok(())
    }
}

/// A focal length of a kilometre is none.
const LEAST_POWER: f64 = 1e-3;

fn as_text(x: f64) -> String {
    x.to_string()
}

/// A thin lens before the main one: a close-up lens, or a diverging one.
#[derive(Clone, Debug, PartialEq)]
pub struct SupplementaryLens {
    /// Power, m⁻¹, that is dioptres; below 0 for a diverging lens.
    pub power: Power,
    /// Distance before the main lens, m, 0 or more.
    pub distance_m: f64,
}

/// The power of an element.
#[derive(Clone, Debug, PartialEq)]
pub enum Power {
    /// Constant power at all wavelengths, m⁻¹.
    Constant(f64),
    /// Power of a ground piece of glass.
    Ground(GroundLens),
}

impl Power {
    /// The power at a wavelength in nm, m⁻¹.
    pub fn at(&self, lambda_nm: f64) -> f64 {
        match self {
            Self::Constant(power) => *power,
            Self::Ground(ground) => ground.power(lambda_nm),
        }
    }

    /// Whether the power is the same at all wavelengths.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Ground(ground) => ground.index.is_constant(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Refraction at both surfaces, one after the other, with the transfer between them: the paraxial ray trace that the
    /// lensmaker's equation sums up.
    fn traced_power(lens: &GroundLens, lambda_nm: f64) -> f64 {
        let n = lens.index.index(lambda_nm);
        let (height, angle) = (1.0, 0.0);
        let inside = (angle - height * (n - 1.0) / lens.radii_m[0]) / n;
        let at_back = height + inside * lens.thickness_m;
        let outside = n * inside - at_back * (1.0 - n) / lens.radii_m[1];
        -outside / height
    }

    #[test]
    fn the_lensmakers_equation_is_the_paraxial_ray_trace() {
        let bk7 = Dispersion::from_abbe(1.5168, 64.17).expect("a glass");
        for (r1, r2, d) in [
            (0.05, -0.05, 0.0),
            (0.05, -0.05, 0.008),
            (0.03, f64::INFINITY, 0.004),
            (f64::INFINITY, -0.03, 0.004),
            (-0.04, 0.06, 0.002),
            (0.03, 0.02, 0.003),
        ] {
            let lens = GroundLens { radii_m: [r1, r2], thickness_m: d, index: bk7.clone() };
            lens.validate().expect("a lens");
            for lambda in [400.0, NOMINAL_NM, 700.0] {
                let (found, expected) = (lens.power(lambda), traced_power(&lens, lambda));
                assert!((found - expected).abs() < 1e-9, "{r1} {r2} {d} {lambda}: {found} {expected}");
            }
        }
        // The notes' symmetric lens of n = 1.5: f = R.
        let symmetric = GroundLens { radii_m: [0.05, -0.05], thickness_m: 0.0, index: Dispersion::constant(1.5) };
        assert!((symmetric.power(550.0) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_lens_is_refused() {
        let of = |radii_m, thickness_m| GroundLens { radii_m, thickness_m, index: Dispersion::constant(1.5) };
        for (lens, key) in [
            (of([0.0, 0.1], 0.0), "radii_mm"),
            (of([f64::NAN, 0.1], 0.0), "radii_mm"),
            (of([f64::INFINITY, f64::INFINITY], 0.001), "radii_mm"),
            (of([0.1, -0.1], -0.001), "thickness_mm"),
            (of([0.1, -0.1], f64::NAN), "thickness_mm"),
        ] {
            assert_eq!(lens.validate().expect_err("none").key, key, "{lens:?}");
        }
    }
}
