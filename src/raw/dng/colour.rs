//! What the colours mean (chapter 6 of the specification).

use std::io::{Seek, Write};

use glam::{DMat3, DVec3};
use tiff::TiffResult;
use tiff::encoder::SRational;

use super::{Ifd, tag};
use crate::colour::adaptation::bradford;
use crate::raw::RawMetadata;
use crate::raw::rational::{rational, srational};
use crate::spectrum::{cie, illuminant};

/// XYZ of D50, the white of profiles, as ICC has it.
const D50: DVec3 = DVec3::new(0.9642, 1.0, 0.8249);

pub(super) fn write<W: Write + Seek>(metadata: &RawMetadata, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    let [d65, a] = [cie::xyz(illuminant::d65()), cie::xyz(&illuminant::a())];
    let first = [tag::COLOR_MATRIX_1, tag::CALIBRATION_ILLUMINANT_1, tag::FORWARD_MATRIX_1, tag::CAMERA_CALIBRATION_1];
    let second = [tag::COLOR_MATRIX_2, tag::CALIBRATION_ILLUMINANT_2, tag::FORWARD_MATRIX_2, tag::CAMERA_CALIBRATION_2];
    // Developers that use one matrix only look for that of D65; dcraw takes the last.
    let places = if metadata.colour_matrix_a.is_some() { [first, second] } else { [second, first] };
    for ((matrix, light, white), [matrix_tag, light_tag, forward_tag, calibration_tag]) in
        [(&metadata.colour_matrix_a, tag::STANDARD_LIGHT_A, a), (&metadata.colour_matrix_d65, tag::D65, d65)]
            .into_iter()
            .zip(places)
    {
        let Some(matrix) = matrix else { continue };
        ifd.write_tag(matrix_tag, &entries(matrix.as_flattened())[..])?;
        ifd.write_tag(light_tag, light)?;
        if let Some(forward) = forward_matrix(matrix, white) {
            ifd.write_tag(forward_tag, &entries(&forward.transpose().to_cols_array())[..])?;
        }
        // This camera is like all of its model.
        let side = matrix.len();
        let identity: Vec<f64> = (0..side * side).map(|i| if i % (side + 1) == 0 { 1.0 } else { 0.0 }).collect();
        ifd.write_tag(calibration_tag, &entries(&identity)[..])?;
    }
    if let Some(neutral) = &metadata.as_shot_neutral {
        let neutral: Vec<_> = neutral.iter().map(|&component| rational(component)).collect();
        ifd.write_tag(tag::AS_SHOT_NEUTRAL, &neutral[..])?;
    }
    Ok(())
}

fn entries(numbers: &[f64]) -> Vec<SRational> {
    numbers.iter().map(|&number| srational(number)).collect()
}

/// White-balanced camera → XYZ under D50, of a camera of three channels: what the colour matrix says for colours under
/// its own light, adapted to D50 by the Bradford transform. White becomes D50 exactly.
fn forward_matrix(colour_matrix: &[[f64; 3]], white: [f64; 3]) -> Option<DMat3> {
    let rows: [[f64; 3]; 3] = colour_matrix.try_into().ok()?;
    let from_xyz = DMat3::from_cols_array_2d(&rows).transpose();
    let white = DVec3::from_array(white) / white[1];
    let forward = bradford(white, D50) * from_xyz.inverse() * DMat3::from_diagonal(from_xyz * white);
    forward.is_finite().then_some(forward)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forward_matrices_take_white_to_d50() {
        let matrix = [[0.8, -0.25, -0.1], [-0.4, 1.2, 0.2], [-0.05, 0.15, 0.6]];
        for light in [illuminant::d65(), &illuminant::a()] {
            let forward = forward_matrix(&matrix, cie::xyz(light)).expect("three channels");
            assert!((forward * DVec3::ONE).abs_diff_eq(D50, 1e-12), "{forward}");
        }
        assert!(forward_matrix(&matrix[..2], [1.0; 3]).is_none());
        assert!(forward_matrix(&[[0.0; 3]; 3], [1.0; 3]).is_none());
    }
}
