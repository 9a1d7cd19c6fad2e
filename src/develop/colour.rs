//! Colour: white-balanced camera channels become linear sRGB.

use glam::{DMat3, DVec3, Mat3, Vec3};
use rayon::prelude::*;

use crate::Invalid;
use crate::image::Planes;
use crate::spectrum::rgb;

/// White-balanced camera → linear sRGB, from a raw file's matrix (XYZ → camera under D65).
///
/// The rows of camera ← sRGB, each brought to a sum of 1, so that equal channels are white whatever the light was:
/// the white balance is the adaptation. LibRaw and dcraw do the same. It is exact for D65, and an approximation for
/// other light, as any single matrix is.
pub(super) fn camera_to_srgb(xyz_to_camera: [[f64; 3]; 3]) -> Result<DMat3, Invalid> {
    let from_srgb = DMat3::from_cols_array_2d(&xyz_to_camera).transpose() * *rgb::rgb_to_xyz();
    let sums = from_srgb * DVec3::ONE;
    let inverse = (DMat3::from_diagonal(sums.recip()) * from_srgb).inverse();
    if inverse.is_finite() {
        Ok(inverse)
    } else {
        let message = format!("{xyz_to_camera:?} cannot be undone");
        Err(Invalid::new("ColorMatrix1", message).help("the file is damaged, or its camera cannot tell colours apart"))
    }
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
