//! Colour: white-balanced camera channels become linear sRGB.

use glam::{DMat3, DVec3, Mat3, Vec3};
use rayon::prelude::*;

use crate::Invalid;
use crate::image::Planes;
use crate::raw::RawMetadata;
use crate::spectrum::rgb;

/// White-balanced camera → linear sRGB, in which white (1, 1, 1) stays white. The identity for a raw file that has no
/// matrix.
///
/// After the DNG specification ([Dng16](crate::references#dng16), chapter 6): the matrix of the scene's light lies
/// between those of D65 and illuminant A, by reciprocal colour temperature; that matrix and the response to white give
/// the scene's white point, from which colours are adapted to sRGB's.
pub(super) fn camera_to_srgb(metadata: &RawMetadata, neutral: [f64; 3]) -> Result<DMat3, Invalid> {
    let Some(d65) = three_channels(&metadata.colour_matrix_d65, "ColorMatrix1")? else { return Ok(DMat3::IDENTITY) };
    let a = three_channels(&metadata.colour_matrix_a, "ColorMatrix2")?.unwrap_or(d65);
    let neutral = DVec3::from_array(neutral);
    let mut camera_to_xyz = interpolated(d65, a, 0.0).inverse();
    // The matrix depends on the white point and the white point on the matrix: a fixed point, reached within a few rounds.
    for _ in 0..ROUNDS {
        let part_of_a = part_of_a(camera_to_xyz * neutral);
        camera_to_xyz = interpolated(d65, a, part_of_a).inverse();
    }
    let white = camera_to_xyz * neutral;
    let balanced_to_srgb = *rgb::xyz_to_rgb()
        * adaptation(white / white.y, *rgb::rgb_to_xyz() * DVec3::ONE)
        * camera_to_xyz
        * DMat3::from_diagonal(neutral / white.y);
    if balanced_to_srgb.is_finite() {
        Ok(balanced_to_srgb)
    } else {
        let message = format!("{d65:?} and the response to white {neutral} do not give a colour");
        Err(Invalid::new("ColorMatrix1", message).help("the file is damaged, or its camera cannot tell colours apart"))
    }
}

/// The matrix of a camera of three channels.
fn three_channels(matrix: &Option<Vec<[f64; 3]>>, key: &str) -> Result<Option<[[f64; 3]; 3]>, Invalid> {
    let Some(rows) = matrix else { return Ok(None) };
    let refused = |_| Invalid::new(key, format!("a matrix of {} channels instead of 3", rows.len()));
    rows.as_slice().try_into().map(Some).map_err(refused)
}

/// Enough for the fixed point to settle to 1e-6: the matrices differ little, so each round gains a digit or more.
const ROUNDS: usize = 12;

/// XYZ → camera, `part` of the way from the first matrix to the second.
fn interpolated(first: [[f64; 3]; 3], second: [[f64; 3]; 3], part: f64) -> DMat3 {
    let matrix = |rows: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&rows).transpose();
    matrix(first) * (1.0 - part) + matrix(second) * part
}

/// How far the white XYZ lies from D65 to illuminant A in reciprocal correlated colour temperature, 0–1.
fn part_of_a(white: DVec3) -> f64 {
    let [x, y] = [white.x, white.y].map(|component| component / white.element_sum());
    // McCamy (1992), good to a few kelvin between the two, which is all that counts here.
    let n = (x - 0.3320) / (0.1858 - y);
    let temperature = ((449.0 * n + 3525.0) * n + 6823.3) * n + 5520.33;
    let part = (1.0 / temperature - 1.0 / 6504.0) / (1.0 / 2856.0 - 1.0 / 6504.0);
    if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) }
}

/// XYZ seen under one white → XYZ that looks the same under another: the Bradford transform, as the DNG and ICC
/// specifications have it.
fn adaptation(from: DVec3, to: DVec3) -> DMat3 {
    let cones = DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);
    cones.inverse() * DMat3::from_diagonal((cones * to) / (cones * from)) * cones
}

/// Applies a matrix to three planes, pixel by pixel. Demosaicking may have overshot white, which is 1 in all channels;
/// it would become a colour.
pub(super) fn apply(picture: &mut Planes, matrix: DMat3) {
    let matrix: Mat3 = matrix.as_mat3();
    if let [r, g, b] = picture.channels_mut() {
        let pixels = r.data.par_iter_mut().zip(&mut g.data).zip(&mut b.data);
        pixels.for_each(|((r, g), b)| [*r, *g, *b] = (matrix * Vec3::new(*r, *g, *b).min(Vec3::ONE)).to_array());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::{cie, illuminant};

    #[test]
    fn the_light_is_placed_between_the_two_matrices() {
        let part = |name: &str| {
            let [x, y, z] = cie::xyz(&illuminant::illuminant(name).expect("known"));
            part_of_a(DVec3::new(x, y, z))
        };
        // In mired: 153.8 for D65, 199.9 for D50 at 5003 K, 350.1 for A. McCamy is good to a few kelvin.
        assert!(part("D65") < 1e-3);
        assert!((part("D50") - (199.9 - 153.75) / (350.14 - 153.75)).abs() < 2e-3, "{}", part("D50"));
        assert!(part("A") > 1.0 - 1e-3);
        assert_eq!([part("D75"), part("2000K")], [0.0, 1.0]);
        assert_eq!(part_of_a(DVec3::NAN), 0.0);
    }

    #[test]
    fn white_stays_white_whatever_the_neutral_is() {
        let metadata = RawMetadata {
            colour_matrix_d65: Some(vec![[0.8, -0.25, -0.1], [-0.4, 1.2, 0.2], [-0.05, 0.15, 0.6]]),
            colour_matrix_a: Some(vec![[0.9, -0.35, -0.15], [-0.3, 1.1, 0.25], [0.0, 0.1, 0.7]]),
            ..RawMetadata::default()
        };
        for neutral in [[0.5, 1.0, 0.7], [1.0, 0.9, 0.2], [0.2, 1.0, 1.0]] {
            let matrix = camera_to_srgb(&metadata, neutral).expect("finite");
            assert!((matrix * DVec3::ONE).abs_diff_eq(DVec3::ONE, 1e-12), "{matrix}");
        }
    }
}
