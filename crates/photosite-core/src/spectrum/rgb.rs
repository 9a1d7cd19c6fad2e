//! The sRGB colour space of IEC 61966-2-1 ([Srgb](crate::references#srgb)): XYZ ↔ linear RGB, and the transfer
//! function between linear and encoded values.
//!
//! The white point is the chromaticity of the tabulated D65, not the rounded (0.3127, 0.3290) of the standard, so that
//! a white surface under D65 is exactly (1, 1, 1).

use std::sync::OnceLock;

use glam::{DMat3, DVec3};

use super::{cie, illuminant};

/// Chromaticities (x, y) of the primaries: red, green, blue.
pub const PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// Linear sRGB → XYZ, scaled so that RGB (1, 1, 1) has Y = 1. The columns are the primaries, each scaled so that their
/// sum is the white point.
pub fn rgb_to_xyz() -> &'static DMat3 {
    static MATRIX: OnceLock<DMat3> = OnceLock::new();
    MATRIX.get_or_init(|| {
        let white = cie::chromaticity(illuminant::d65()).expect("D65 is not black");
        matrix(PRIMARIES, cie::xyz_of_chromaticity(white))
    })
}

/// Linear RGB → XYZ for other primaries (x, y) and another white XYZ, Y = 1.
pub fn matrix(primaries: [[f64; 2]; 3], white: DVec3) -> DMat3 {
    let [r, g, b] = primaries.map(cie::xyz_of_chromaticity);
    let primaries = DMat3::from_cols(r, g, b);
    primaries * DMat3::from_diagonal(primaries.inverse() * white)
}

/// XYZ with Y = 1 for white → linear sRGB; the inverse of [`rgb_to_xyz`].
pub fn xyz_to_rgb() -> &'static DMat3 {
    static MATRIX: OnceLock<DMat3> = OnceLock::new();
    MATRIX.get_or_init(|| rgb_to_xyz().inverse())
}

/// Relative luminance Y of linear sRGB, 1 for white: the second row of [`rgb_to_xyz`] (about 0.2126, 0.7152, 0.0722).
pub fn luminance(rgb: [f64; 3]) -> f64 {
    rgb_to_xyz().row(1).dot(DVec3::from_array(rgb))
}

/// Encoded sRGB value in [0, 1] → linear. Negative values are mirrored, as scRGB does.
pub fn decode(encoded: f32) -> f32 {
    let v = encoded.abs();
    let linear = if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    linear.copysign(encoded)
}

/// Linear value in [0, 1] → encoded sRGB; the inverse of [`decode`].
pub fn encode(linear: f32) -> f32 {
    let v = linear.abs();
    let encoded = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    encoded.copysign(linear)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_are_those_of_the_standard() {
        // IEC 61966-2-1, computed there from the rounded white point; the two differ by less than 3e-4.
        let published =
            DMat3::from_cols_array_2d(&[[0.4124, 0.2126, 0.0193], [0.3576, 0.7152, 0.1192], [0.1805, 0.0722, 0.9505]]);
        assert!((*rgb_to_xyz() - published).to_cols_array().iter().all(|d| d.abs() < 3e-4), "{:?}", rgb_to_xyz());
        assert!((*rgb_to_xyz() * *xyz_to_rgb()).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn d65_is_white() {
        let [x, y, z] = cie::xyz(illuminant::d65());
        let rgb = *xyz_to_rgb() * (DVec3::new(x, y, z) / y);
        assert!(rgb.abs_diff_eq(DVec3::ONE, 1e-12), "{rgb}");
    }

    #[test]
    fn transfer_function_is_continuous_and_inverts() {
        for i in 0..=1000 {
            let v = i as f32 / 1000.0;
            // Two powf of one ulp each, amplified by at most 12.92 at the dark end.
            assert!((encode(decode(v)) - v).abs() < 2e-6, "{v}");
        }
        // The published break points meet within 1e-7 of each other, relative to slopes of 1/12.92 and 12.92.
        assert!((decode(0.040_451) - decode(0.040_449)).abs() < 1e-6);
        // Half of full scale, by the formula with a calculator.
        assert!((decode(0.5) - 0.214_041_14).abs() < 1e-7);
        assert_eq!([decode(0.0), decode(1.0), encode(0.0)], [0.0, 1.0, 0.0]);
        assert!((encode(-0.5) + encode(0.5)).abs() < 1e-9);
    }
}
