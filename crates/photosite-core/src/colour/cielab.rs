//! CIE 1976 L\*a\*b\* and CIE 1931 xyY ([Cie15](crate::references#cie15), 8.2.1 and 7.3).

use glam::DVec3;

/// (6/29)³: where the cube root gives way to a straight line.
const EPSILON: f64 = 216.0 / 24_389.0;
/// (29/3)³: the slope of that line, in L\*.
const KAPPA: f64 = 24_389.0 / 27.0;

/// XYZ → (L\*, a\*, b\*) relative to a white of the same scale:
/// L\* = 116·f(Y/Yₙ) − 16, a\* = 500·(f(X/Xₙ) − f(Y/Yₙ)), b\* = 200·(f(Y/Yₙ) − f(Z/Zₙ)).
pub fn from_xyz(xyz: DVec3, white: DVec3) -> DVec3 {
    let f = |t: f64| if t > EPSILON { t.cbrt() } else { (KAPPA * t + 16.0) / 116.0 };
    let [x, y, z] = (xyz / white).to_array().map(f);
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// (L\*, a\*, b\*) → XYZ in the scale of the white.
pub fn to_xyz(lab: DVec3, white: DVec3) -> DVec3 {
    let y = (lab.x + 16.0) / 116.0;
    let inverse = |f: f64| if f.powi(3) > EPSILON { f.powi(3) } else { (116.0 * f - 16.0) / KAPPA };
    white * DVec3::from_array([y + lab.y / 500.0, y, y - lab.z / 200.0].map(inverse))
}

/// XYZ → (x, y, Y). Black has no chromaticity and is given that of `white`.
pub fn xyy_from_xyz(xyz: DVec3, white: DVec3) -> DVec3 {
    let colour = if xyz.element_sum() == 0.0 { white } else { xyz };
    let sum = colour.element_sum();
    DVec3::new(colour.x / sum, colour.y / sum, xyz.y)
}

/// (x, y, Y) → XYZ, for y other than 0.
pub fn xyy_to_xyz(xyy: DVec3) -> DVec3 {
    let DVec3 { x, y, z: luminance } = xyy;
    DVec3::new(x, y, 1.0 - x - y) * (luminance / y)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: DVec3 = DVec3::new(0.950_47, 1.0, 1.088_83);

    #[test]
    fn white_black_and_middle_grey_are_where_they_belong() {
        assert!(from_xyz(WHITE, WHITE).abs_diff_eq(DVec3::new(100.0, 0.0, 0.0), 1e-12));
        assert!(from_xyz(DVec3::ZERO, WHITE).abs_diff_eq(DVec3::ZERO, 1e-12));
        // 116·0.18^(1/3) − 16 by a calculator.
        assert!((from_xyz(0.18 * WHITE, WHITE).x - 49.496_1).abs() < 1e-4);
    }

    #[test]
    fn both_ways_undo_each_other_on_both_sides_of_the_bend() {
        for xyz in [[0.2, 0.3, 0.4], [1e-3, 2e-3, 5e-4], [0.5, 0.008_8, 0.01], [-0.01, 0.02, 0.9]] {
            let xyz = DVec3::from_array(xyz);
            assert!(to_xyz(from_xyz(xyz, WHITE), WHITE).abs_diff_eq(xyz, 1e-14));
            assert!(xyy_to_xyz(xyy_from_xyz(xyz, WHITE)).abs_diff_eq(xyz, 1e-14));
        }
        assert_eq!(xyy_to_xyz(xyy_from_xyz(DVec3::ZERO, WHITE)), DVec3::ZERO);
    }
}
