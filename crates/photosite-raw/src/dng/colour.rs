//! Colour tags (chapter 6 of the specification).
//!
//! A file may give the matrices of a model and, beside them, what sets the single camera apart: its calibration (n × n)
//! and analogue balance, XYZ → camera being AnalogBalance · CameraCalibration · ColorMatrix. In an image's metadata
//! they are one.

use std::io::{Seek, Write};

use tiff::encoder::SRational;
use tiff::tags::Tag;
use tiff::{Directory, TiffResult};

use super::ifd::Ifd;
use crate::rational::{rational, srational};
use crate::tag;
use crate::tags::Tags;
use crate::{ColourCalibration, LightSource, RawMetadata};
use photosite_core::Invalid;

/// The tags of a light's matrices.
struct MatrixTags {
    colour: Tag,
    light: Tag,
    forward: Tag,
    calibration: Tag,
}

const MATRIX_TAGS: [MatrixTags; 3] = [
    MatrixTags {
        colour: tag::COLOR_MATRIX_1,
        light: tag::CALIBRATION_ILLUMINANT_1,
        forward: tag::FORWARD_MATRIX_1,
        calibration: tag::CAMERA_CALIBRATION_1,
    },
    MatrixTags {
        colour: tag::COLOR_MATRIX_2,
        light: tag::CALIBRATION_ILLUMINANT_2,
        forward: tag::FORWARD_MATRIX_2,
        calibration: tag::CAMERA_CALIBRATION_2,
    },
    MatrixTags {
        colour: tag::COLOR_MATRIX_3,
        light: tag::CALIBRATION_ILLUMINANT_3,
        forward: tag::FORWARD_MATRIX_3,
        calibration: tag::CAMERA_CALIBRATION_3,
    },
];

pub(super) fn write<W: Write + Seek>(metadata: &RawMetadata, ifd: &mut Ifd<'_, W>) -> TiffResult<()> {
    for (lit, places) in metadata.calibrations.iter().zip(&MATRIX_TAGS) {
        ifd.write_tag(places.colour, &entries(lit.colour_matrix.as_flattened())[..])?;
        ifd.write_tag(places.light, lit.light.0)?;
        if let Some(columns) = &lit.forward_matrix {
            let rows: Vec<f64> = (0..3).flat_map(|row| columns.iter().map(move |column| column[row])).collect();
            ifd.write_tag(places.forward, &entries(&rows)[..])?;
        }
        // This camera is like all of its model.
        ifd.write_tag(places.calibration, &entries(&identity(lit.colour_matrix.len()))[..])?;
    }
    if let Some(neutral) = &metadata.as_shot_neutral {
        let neutral: Vec<_> = neutral.iter().map(|&component| rational(component)).collect();
        ifd.write_tag(tag::AS_SHOT_NEUTRAL, &neutral[..])?;
    } else if let Some(white) = metadata.as_shot_white_xy {
        ifd.write_tag(tag::AS_SHOT_WHITE_XY, &white.map(rational)[..])?;
    }
    Ok(())
}

fn entries(numbers: &[f64]) -> Vec<SRational> {
    numbers.iter().map(|&number| srational(number)).collect()
}

/// The identity of n rows and columns.
fn identity(n: usize) -> Vec<f64> {
    (0..n * n).map(|i| if i % (n + 1) == 0 { 1.0 } else { 0.0 }).collect()
}

/// Puts into the metadata what the main directory says of colours.
pub(super) fn read(file: &mut Tags<'_>, main: &Directory, metadata: &mut RawMetadata) -> Result<(), Invalid> {
    let balance = file.numbers(main, tag::ANALOG_BALANCE)?;
    // A calibration is one to the matrices of its own signature.
    let [camera, profile] = [tag::CAMERA_CALIBRATION_SIGNATURE, tag::PROFILE_CALIBRATION_SIGNATURE]
        .map(|signature| file.text_or_bytes(main, signature));
    let is_calibrated = camera? == profile?;
    let mut lit = |places: &MatrixTags| -> Result<Option<ColourCalibration>, Invalid> {
        let entries = file.numbers(main, places.colour)?;
        let (rows, rest) = entries.as_chunks::<3>();
        if rows.is_empty() || !rest.is_empty() {
            return Ok(None);
        }
        let forward = file.numbers(main, places.forward)?;
        let calibration = if is_calibrated { file.numbers(main, places.calibration)? } else { Vec::new() };
        let (colour_matrix, is_diagonal) = calibrated(rows, &balance, &calibration);
        // Forward matrices are for the balanced channels of the model, which those of the camera are unless they mix.
        let forward_matrix = (forward.len() == 3 * rows.len() && is_diagonal)
            .then(|| (0..rows.len()).map(|c| [0, 1, 2].map(|row| forward[row * rows.len() + c])).collect());
        let light = LightSource(file.number(main, places.light)?.unwrap_or_default() as u16);
        Ok(Some(ColourCalibration { light, colour_matrix, forward_matrix }))
    };
    for places in &MATRIX_TAGS {
        metadata.calibrations.extend(lit(places)?);
    }
    let neutral = file.numbers(main, tag::AS_SHOT_NEUTRAL)?;
    metadata.as_shot_neutral = (!neutral.is_empty()).then_some(neutral);
    metadata.as_shot_white_xy = file.array(main, tag::AS_SHOT_WHITE_XY)?;
    Ok(())
}

/// XYZ → this camera, from XYZ → its model, with what is missing taken for 1; and whether its channels are those of the
/// model but for factors.
fn calibrated(model: &[[f64; 3]], balance: &[f64], calibration: &[f64]) -> (Vec<[f64; 3]>, bool) {
    let n = model.len();
    let calibration = if calibration.len() == n * n { calibration.to_vec() } else { identity(n) };
    let factor = |channel: usize| if balance.len() == n { balance[channel] } else { 1.0 };
    let row = |channel: usize| {
        let of = &calibration[channel * n..(channel + 1) * n];
        [0, 1, 2].map(|i| factor(channel) * of.iter().zip(model).map(|(part, row)| part * row[i]).sum::<f64>())
    };
    let is_diagonal = (0..n * n).all(|i| i % (n + 1) == 0 || calibration[i] == 0.0);
    ((0..n).map(row).collect(), is_diagonal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_is_its_model_times_what_sets_it_apart() {
        let model = [[1.0, 0.0, 0.5], [0.0, 2.0, 0.0], [0.25, 0.0, 1.0]];
        assert_eq!(calibrated(&model, &[], &[]), (model.to_vec(), true));
        let scaled = [[2.0, 0.0, 1.0], [0.0, 2.0, 0.0], [0.75, 0.0, 3.0]];
        let diagonal = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.5];
        assert_eq!(calibrated(&model, &[2.0, 1.0, 2.0], &diagonal), (scaled.to_vec(), true));
        let mixing = [1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let mixed = [[1.0, 1.0, 0.5], [0.0, 2.0, 0.0], [0.25, 0.0, 1.0]];
        assert_eq!(calibrated(&model, &[1.0], &mixing), (mixed.to_vec(), false));
    }
}
