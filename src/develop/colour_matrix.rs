//! What the colours of a camera mean: the matrix between its channels and XYZ, and its response to white, both computed
//! from spectral responses.
//!
//! In: the responses of three channels (any common unit), as [`SensorModel::responses`] gives them, times the
//! transmittance of the lens where it has a colour; the spectrum of the light. Out: the numbers of a DNG file's
//! ColorMatrix1, ColorMatrix2 and AsShotNeutral ([Dng16](crate::references#dng16), chapter 6).
//!
//! [`SensorModel::responses`]: crate::sensor::SensorModel::responses

use glam::{DMat3, DVec3};

use crate::Invalid;
use crate::spectrum::{Spectrum, cie, illuminant, library};

/// The colour entries of a raw file's metadata.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraColour {
    /// XYZ → camera for colours under D65, rows per channel.
    pub matrix_d65: [[f64; 3]; 3],
    /// XYZ → camera for colours under CIE illuminant A.
    pub matrix_a: [[f64; 3]; 3],
    /// The camera's response to the scene's white, the largest component 1.
    pub neutral: [f64; 3],
}

/// Colour of a camera with these channels in a scene lit by `light` (any unit). `None` for a camera of one channel.
pub fn camera_colour(responses: &[(String, Spectrum)], light: &Spectrum) -> Result<Option<CameraColour>, Invalid> {
    match responses {
        [r, g, b] => {
            let channels = [&r.1, &g.1, &b.1];
            Ok(Some(CameraColour {
                matrix_d65: xyz_to_camera(channels, illuminant::d65())?,
                matrix_a: xyz_to_camera(channels, &illuminant::a())?,
                neutral: neutral(channels, light)?,
            }))
        }
        _ => Ok(None),
    }
}

/// The camera's response to `light` itself, the largest component 1.
pub fn neutral(channels: [&Spectrum; 3], light: &Spectrum) -> Result<[f64; 3], Invalid> {
    let response = channels.map(|channel| channel.product(light).integral());
    let largest = response.into_iter().fold(0.0, f64::max);
    if let Some(blind) = response.iter().position(|&r| r.is_nan() || r <= 0.0) {
        let message = format!("channel {} of the sensor does not see the light of the scene", ["R", "G", "B"][blind]);
        return Err(
            Invalid::new("channels", message).help("its white balance is undefined; use a light that all channels see")
        );
    }
    Ok(response.map(|r| r / largest))
}

/// XYZ → camera for colours under `light` (ColorMatrix1 and 2): the inverse of [`camera_to_xyz`], scaled so that the
/// largest response to the light's own white of Y = 1 is 1, as the specification asks.
pub fn xyz_to_camera(channels: [&Spectrum; 3], light: &Spectrum) -> Result<[[f64; 3]; 3], Invalid> {
    let balanced_to_xyz = camera_to_xyz(channels, light)?;
    let to_camera = DMat3::from_diagonal(DVec3::from_array(neutral(channels, light)?)) * balanced_to_xyz.inverse();
    let rows = to_camera.transpose().to_cols_array_2d();
    if rows.as_flattened().iter().all(|entry| entry.is_finite()) { Ok(rows) } else { Err(indistinct()) }
}

/// White-balanced camera channels → XYZ, for a white of Y = 1 under `light`: the matrix M that takes the camera's
/// colours of the 24 patches of a colour checker closest to their true ones. For each row m, with its component x of
/// the tristimulus values (X, Y or Z),
///
/// min Σᵢ (m·cᵢ − xᵢ)² · xᵢ^(−4/3), subject to m·(1, 1, 1) = x of white.
///
/// cᵢ are responses over the response to white. The weights turn errors into those of CIELAB, which is made of cube
/// roots: d(x^⅓) ∝ x^(−⅔) dx. Without them bright patches would be all that counts.
pub fn camera_to_xyz(channels: [&Spectrum; 3], light: &Spectrum) -> Result<DMat3, Invalid> {
    let white_response = channels.map(|channel| channel.product(light).integral());
    let [x, y, z] = cie::xyz(light);
    let white = [x / y, 1.0, z / y];
    let patches: Vec<(DVec3, [f64; 3])> = checker()
        .map(|reflectance| {
            let reflected = light.product(&reflectance);
            let response = channels.map(|channel| channel.product(&reflected).integral());
            let camera = DVec3::from_array(response) / DVec3::from_array(white_response);
            (camera, cie::xyz(&reflected).map(|component| component / y))
        })
        .collect();
    let row = |component: usize| {
        // Normal equations A·m = b. A Lagrange multiplier then shares out what m·1 lacks, along A⁻¹·1.
        let (mut a, mut b) = (DMat3::ZERO, DVec3::ZERO);
        for (camera, xyz) in &patches {
            let weight = xyz[component].powf(-4.0 / 3.0);
            a += DMat3::from_cols(*camera * camera.x, *camera * camera.y, *camera * camera.z) * weight;
            b += *camera * xyz[component] * weight;
        }
        let inverse = a.inverse();
        let free = inverse * b;
        let along = inverse * DVec3::ONE;
        free + along * (white[component] - free.element_sum()) / along.element_sum()
    };
    let matrix = DMat3::from_cols(row(0), row(1), row(2)).transpose();
    if matrix.is_finite() && matrix.determinant().abs() > 1e-9 { Ok(matrix) } else { Err(indistinct()) }
}

fn indistinct() -> Invalid {
    Invalid::new("channels", "the quantum efficiencies of R, G and B do not tell colours apart")
        .help("give each channel a curve of its own, or use cfa = \"mono\"")
}

/// Reflectances of the 24 patches.
fn checker() -> impl Iterator<Item = Spectrum> {
    library::names().filter(|name| name.starts_with("colour-checker/")).filter_map(library::spectrum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bell-shaped channels about where those of cameras are.
    fn camera() -> Vec<(String, Spectrum)> {
        let bell = |name: &str, centre: f64, height: f64| {
            let bell = |lambda: f64| height * (-0.5 * ((lambda - centre) / 35.0).powi(2)).exp();
            (name.to_owned(), Spectrum::from_fn(bell))
        };
        vec![bell("R", 600.0, 0.5), bell("G", 535.0, 0.7), bell("B", 465.0, 0.6)]
    }

    /// Channels that are a linear mixture of the observer: such a camera can be corrected exactly.
    fn luther_camera() -> ([Spectrum; 3], DMat3) {
        let mixture = DMat3::from_cols_array(&[0.9, 0.1, 0.0, 0.3, 1.1, 0.1, 0.0, 0.2, 0.8]);
        let [x, y, z] = cie::observer();
        let channel = |row: DVec3| {
            Spectrum::from_fn(|lambda| {
                let xyz = [x, y, z].map(|bar| f64::from(bar.eval(lambda as f32)));
                row.dot(DVec3::from_array(xyz))
            })
        };
        ([0, 1, 2].map(|i| channel(mixture.row(i))), mixture)
    }

    #[test]
    fn a_camera_that_mixes_the_observer_is_undone_exactly() {
        let (channels, mixture) = luther_camera();
        let matrix =
            DMat3::from_cols_array_2d(&xyz_to_camera(channels.each_ref(), illuminant::d65()).expect("distinct"))
                .transpose();
        let d65 = cie::xyz(illuminant::d65());
        let white = mixture * (DVec3::from_array(d65) / d65[1]);
        let expected = mixture * (1.0 / white.max_element());
        // Channel tables are rounded to f32; the fit's condition number is below 100.
        assert!((matrix - expected).to_cols_array().iter().all(|d| d.abs() < 1e-5), "{matrix} {expected}");
    }

    #[test]
    fn white_stays_white_under_any_light() {
        let [r, g, b] = &camera()[..] else { panic!("three channels") };
        for name in ["A", "D50", "D65", "FL11"] {
            let light = illuminant::illuminant(name).expect("known");
            let matrix = camera_to_xyz([&r.1, &g.1, &b.1], &light).expect("distinct");
            let [x, y, z] = cie::xyz(&light);
            assert!((matrix * DVec3::ONE).abs_diff_eq(DVec3::new(x, y, z) / y, 1e-12), "{name}");
        }
    }

    #[test]
    fn each_matrix_gives_the_neutral_of_its_light() {
        for name in ["A", "D65"] {
            let light = illuminant::illuminant(name).expect("known");
            let colour = camera_colour(&camera(), &light).expect("distinct").expect("colour");
            let [x, y, z] = cie::xyz(&light);
            let matrix = if name == "A" { colour.matrix_a } else { colour.matrix_d65 };
            for (row, neutral) in matrix.iter().zip(colour.neutral) {
                let response = row[0] * x / y + row[1] + row[2] * z / y;
                assert!((response - neutral).abs() < 1e-12, "{response} {neutral}");
            }
            assert_eq!(colour.neutral.into_iter().fold(0.0, f64::max), 1.0);
        }
    }

    #[test]
    fn colour_blind_cameras_are_refused() {
        let grey = Spectrum::constant(0.5);
        assert!(xyz_to_camera([&grey, &grey, &grey], illuminant::d65()).is_err());
        let infrared = Spectrum::from_fn(|lambda| if lambda > 900.0 { 1.0 } else { 0.0 });
        assert!(neutral([&grey, &grey, &infrared], illuminant::d65()).is_err());
        assert_eq!(camera_colour(&[("Y".to_owned(), grey)], illuminant::d65()), Ok(None));
    }
}
