//! Chromatic adaptation: from a colour under one white to the colour that looks the same under another.

use glam::{DMat3, DVec3};

/// XYZ of D50, the white of ICC profiles and of forward matrices, as both specifications round it.
pub const D50: DVec3 = DVec3::new(0.9642, 1.0, 0.8249);

/// XYZ under the white `from` → XYZ that looks the same under `to`: the Bradford transform in its linear form, as the
/// ICC ([Icc4](crate::references#icc4), annex E) and DNG ([Dng16](crate::references#dng16)) specifications have it. The
/// whites are XYZ of any common scale, all components above 0.
pub fn bradford(from: DVec3, to: DVec3) -> DMat3 {
    let cones = DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);
    cones.inverse() * DMat3::from_diagonal((cones * to) / (cones * from)) * cones
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_becomes_white_and_the_way_back_undoes_it() {
        let (a, d65) = (DVec3::new(1.098_5, 1.0, 0.355_8), DVec3::new(0.950_47, 1.0, 1.088_83));
        assert!((bradford(a, d65) * a).abs_diff_eq(d65, 1e-12));
        assert!((bradford(d65, a) * bradford(a, d65)).abs_diff_eq(DMat3::IDENTITY, 1e-12));
    }

    #[test]
    fn the_matrix_from_d65_to_d50_is_the_published_one() {
        let (d65, d50) = (DVec3::new(0.950_47, 1.0, 1.088_83), DVec3::new(0.964_22, 1.0, 0.825_21));
        // Lindbloom, "Chromatic Adaptation", Bradford D65 → D50, seven decimals.
        let published = DMat3::from_cols_array(&[
            1.047_811_2,
            0.029_542_4,
            -0.009_234_5,
            0.022_886_6,
            0.990_484_4,
            0.015_043_6,
            -0.050_127_0,
            -0.017_049_1,
            0.752_131_6,
        ]);
        assert!(bradford(d65, d50).abs_diff_eq(published, 1e-6), "{}", bradford(d65, d50));
    }
}
