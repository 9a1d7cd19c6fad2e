//! The CIE 1931 standard colorimetric observer (2°): colour and luminance of spectra.
//!
//! Spectra per nm become tristimulus values and photometric quantities (lm, cd, lx, nt for W, W·sr⁻¹, W·m⁻²,
//! W·m⁻²·sr⁻¹). Colour spaces are left to [`rgb`](super::rgb). [Cie15](crate::references#cie15)

use std::sync::OnceLock;

use glam::DVec3;

use super::{Spectrum, library};
use crate::units::LUMINOUS_EFFICACY;

/// The colour-matching functions x̄, ȳ, z̄, dimensionless; zero outside 360–830 nm.
pub fn observer() -> &'static [Spectrum; 3] {
    static OBSERVER: OnceLock<[Spectrum; 3]> = OnceLock::new();
    OBSERVER.get_or_init(|| {
        let table = library::table(library::OBSERVER).expect("the observer is part of the library");
        ["x", "y", "z"].map(|name| table.column(name).expect("the observer has columns x, y, z"))
    })
}

/// x̄(λ).
pub fn x_bar() -> &'static Spectrum {
    &observer()[0]
}

/// ȳ(λ), which is V(λ): the spectral luminous efficiency for photopic vision, 1 at 555 nm.
pub fn y_bar() -> &'static Spectrum {
    &observer()[1]
}

/// z̄(λ).
pub fn z_bar() -> &'static Spectrum {
    &observer()[2]
}

/// ∫ s·(x̄, ȳ, z̄) dλ, in the unit of `s` times nm, as a sum in steps of 1 nm over 360–830 nm (CIE 015:2018, eq. 7.1
/// without its factor k).
pub fn xyz(s: &Spectrum) -> [f64; 3] {
    observer().each_ref().map(|bar| inner_product(s, bar))
}

/// K_cd ∫ V(λ)·s(λ) dλ with K_cd = 683 lm/W: luminance (nt) of a radiance, illuminance (lx) of an irradiance, luminous
/// intensity (cd) of a radiant intensity, all per nm.
pub fn luminous(s: &Spectrum) -> f64 {
    LUMINOUS_EFFICACY * inner_product(s, y_bar())
}

/// Chromaticity (x, y) of a spectrum; `None` where it gives no response at all.
pub fn chromaticity(s: &Spectrum) -> Option<[f64; 2]> {
    let [x, y, z] = xyz(s);
    let sum = x + y + z;
    (sum > 0.0).then(|| [x / sum, y / sum])
}

/// XYZ with Y = 1 of a chromaticity (x, y): x/y, 1, (1 − x − y)/y.
pub fn xyz_of_chromaticity([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// Inner product Σ a·b·Δλ with Δλ = 1 nm.
fn inner_product(a: &Spectrum, b: &Spectrum) -> f64 {
    a.values().iter().zip(b.values()).map(|(&a, &b)| f64::from(a) * f64::from(b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_energy_has_equal_tristimulus_values() {
        let [x, y, z] = xyz(&Spectrum::constant(1.0));
        // Sums of the published table (ISO/CIE 11664-1): 106.865469, 106.856917, 106.892251 nm.
        for (sum, published) in [(x, 106.865_469), (y, 106.856_917), (z, 106.892_251)] {
            assert!((sum - published).abs() < 2e-5, "{sum} {published}");
        }
        let [x, y] = chromaticity(&Spectrum::constant(3.0)).expect("not black");
        assert!((x - 1.0 / 3.0).abs() < 1e-4 && (y - 1.0 / 3.0).abs() < 1e-4);
    }

    #[test]
    fn a_watt_at_555_nm_is_683_lumens() {
        let line = Spectrum::from_fn(|lambda| if lambda == 555.0 { 1.0 } else { 0.0 });
        assert!((luminous(&line) - 683.0).abs() < 1e-3);
        // V(λ) as printed in every textbook, to three decimals.
        for (lambda, v) in [(450.0, 0.038), (510.0, 0.503), (600.0, 0.631), (650.0, 0.107)] {
            assert!((y_bar().eval(lambda) - v).abs() < 5e-4, "{lambda}");
        }
    }

    #[test]
    fn darkness_has_no_chromaticity() {
        assert_eq!(chromaticity(&Spectrum::constant(0.0)), None);
        // Infra-red is dark too.
        assert_eq!(chromaticity(&Spectrum::from_fn(|lambda| if lambda > 900.0 { 1.0 } else { 0.0 })), None);
    }
}
