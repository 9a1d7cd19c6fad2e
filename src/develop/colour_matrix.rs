//! What the colours of a camera mean: the matrix between its channels and XYZ, and its response to white, both computed
//! from spectral responses.
//!
//! In: the responses of three channels or more (any common unit), as [`SensorModel::responses`] gives them, times the
//! transmittance of the lens where it has a colour; the spectrum of the light. Out: the numbers of a DNG file's
//! ColorMatrix1, ColorMatrix2 and AsShotNeutral ([Dng16](crate::references#dng16), chapter 6).
//!
//! [`SensorModel::responses`]: crate::sensor::SensorModel::responses

use glam::{DMat3, DVec3};

use crate::Invalid;
use crate::colour::{cielab, difference};
use crate::math::linear::solve;
use crate::math::minimise::nelder_mead;
use crate::spectrum::{Spectrum, cie, illuminant, library};

/// The colour entries of a raw file's metadata.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraColour {
    /// XYZ → camera for colours under D65, rows per channel.
    pub matrix_d65: Vec<[f64; 3]>,
    /// XYZ → camera for colours under CIE illuminant A.
    pub matrix_a: Vec<[f64; 3]>,
    /// The camera's response to the scene's white, the largest component 1.
    pub neutral: Vec<f64>,
}

/// Colour of a camera with these channels in a scene lit by `light` (any unit). `None` for a camera of less than three
/// channels, which sees no colours.
pub fn camera_colour(responses: &[(String, Spectrum)], light: &Spectrum) -> Result<Option<CameraColour>, Invalid> {
    if responses.len() < 3 {
        return Ok(None);
    }
    Ok(Some(CameraColour {
        matrix_d65: xyz_to_camera(responses, illuminant::d65())?,
        matrix_a: xyz_to_camera(responses, &illuminant::a())?,
        neutral: neutral(responses, light)?,
    }))
}

/// The camera's response to `light` itself, the largest component 1.
pub fn neutral(channels: &[(String, Spectrum)], light: &Spectrum) -> Result<Vec<f64>, Invalid> {
    let response: Vec<f64> = channels.iter().map(|(_, channel)| channel.product(light).integral()).collect();
    let largest = response.iter().copied().fold(0.0, f64::max);
    if let Some(blind) = response.iter().position(|&r| r.is_nan() || r <= 0.0) {
        let message = format!("channel {} of the sensor does not see the light of the scene", channels[blind].0);
        return Err(
            Invalid::new("channels", message).help("its white balance is undefined; use a light that all channels see")
        );
    }
    Ok(response.into_iter().map(|r| r / largest).collect())
}

/// XYZ → camera for colours under `light` (ColorMatrix1 and 2), scaled so that the largest response to the light's own
/// white of Y = 1 is 1, as the specification asks: the (Moore–Penrose) inverse of [`camera_to_xyz`], of which a reader
/// takes the inverse again.
pub fn xyz_to_camera(channels: &[(String, Spectrum)], light: &Spectrum) -> Result<Vec<[f64; 3]>, Invalid> {
    let neutral = neutral(channels, light)?;
    let to_xyz: Vec<DVec3> =
        camera_to_xyz(channels, light)?.into_iter().zip(neutral).map(|(column, n)| column / n).collect();
    let square: DMat3 = to_xyz.iter().map(|c| DMat3::from_cols(*c * c.x, *c * c.y, *c * c.z)).sum();
    let inverse = square.inverse();
    let rows: Vec<[f64; 3]> = to_xyz.iter().map(|column| (inverse * *column).to_array()).collect();
    if rows.as_flattened().iter().all(|entry| entry.is_finite()) { Ok(rows) } else { Err(indistinct()) }
}

/// White-balanced camera channels → XYZ, for a white of Y = 1 under `light`, a column per channel: the matrix M that takes
/// the camera's colours of the 24 patches of a colour checker closest to their true ones. For each row m, with its
/// component x of the tristimulus values (X, Y or Z),
///
/// min Σᵢ (m·cᵢ − xᵢ)² · xᵢ^(−4/3), subject to m·(1, 1, 1 …) = x of white.
///
/// cᵢ are responses over the response to white. The weights turn errors into those of CIELAB, which is made of cube
/// roots: d(x^⅓) ∝ x^(−⅔) dx. Without them bright patches would be all that counts. From there, a simplex search lessens
/// the mean ΔE₀₀ of the patches, which has no closed form, white kept. With more than three channels the
/// patches leave combinations of them open; a part of 10⁻⁶ of the mean square is added for each, which decides for small
/// entries and so for little noise.
pub fn camera_to_xyz(channels: &[(String, Spectrum)], light: &Spectrum) -> Result<Vec<DVec3>, Invalid> {
    let n = channels.len();
    let respond = |light: &Spectrum| -> Vec<f64> {
        channels.iter().map(|(_, channel)| channel.product(light).integral()).collect()
    };
    let white_response = respond(light);
    let [x, y, z] = cie::xyz(light);
    let white = [x / y, 1.0, z / y];
    let patches: Vec<(Vec<f64>, [f64; 3])> = checker()
        .map(|reflectance| {
            let reflected = light.product(&reflectance);
            let camera = respond(&reflected).iter().zip(&white_response).map(|(r, white)| r / white).collect();
            (camera, cie::xyz(&reflected).map(|component| component / y))
        })
        .collect();
    let row = |component: usize| -> Option<Vec<f64>> {
        // Normal equations A·m = b. A Lagrange multiplier then shares out what m·1 lacks, along A⁻¹·1.
        let (mut a, mut b) = (vec![vec![0.0; n]; n], vec![0.0; n]);
        for (camera, xyz) in &patches {
            let weight = xyz[component].powf(-4.0 / 3.0);
            for i in 0..n {
                b[i] += weight * camera[i] * xyz[component];
                a[i].iter_mut().zip(camera).for_each(|(sum, other)| *sum += weight * camera[i] * other);
            }
        }
        if n > 3 {
            let mean_square = (0..n).map(|i| a[i][i]).sum::<f64>() / n as f64;
            (0..n).for_each(|i| a[i][i] += 1e-6 * mean_square);
        }
        let free = solve(a.clone(), b)?;
        let along = solve(a, vec![1.0; n])?;
        let lack = (white[component] - free.iter().sum::<f64>()) / along.iter().sum::<f64>();
        Some(free.iter().zip(&along).map(|(free, along)| free + along * lack).collect())
    };
    let [Some(x), Some(y), Some(z)] = [0, 1, 2].map(row) else { return Err(indistinct()) };
    let columns: Vec<DVec3> = (0..n).map(|i| DVec3::new(x[i], y[i], z[i])).collect();
    let columns = refined(columns, &patches, DVec3::from_array(white));
    let volume = columns.iter().map(|c| DMat3::from_cols(*c * c.x, *c * c.y, *c * c.z)).sum::<DMat3>().determinant();
    // The squared determinant of three columns.
    if columns.iter().all(|column| column.is_finite()) && volume > 1e-18 { Ok(columns) } else { Err(indistinct()) }
}

/// The matrix nearby that lessens the mean ΔE₀₀ of the patches, white kept: the last column is what the others leave of it.
fn refined(columns: Vec<DVec3>, patches: &[(Vec<f64>, [f64; 3])], white: DVec3) -> Vec<DVec3> {
    let Some((last, free)) = columns.split_last().filter(|(_, free)| free.iter().all(|c| c.is_finite())) else {
        return columns;
    };
    let references: Vec<DVec3> =
        patches.iter().map(|(_, xyz)| cielab::from_xyz(DVec3::from_array(*xyz), white)).collect();
    let complete = |free: &[f64]| -> Vec<DVec3> {
        let mut columns: Vec<DVec3> = free.as_chunks::<3>().0.iter().map(|c| DVec3::from_array(*c)).collect();
        columns.push(white - columns.iter().sum::<DVec3>());
        columns
    };
    let error = |free: &[f64]| {
        let columns = complete(free);
        let difference = |((camera, _), reference): (&(Vec<f64>, _), &DVec3)| {
            let xyz: DVec3 = camera.iter().zip(&columns).map(|(c, column)| *column * *c).sum();
            difference::delta_e_2000(*reference, cielab::from_xyz(xyz, white))
        };
        patches.iter().zip(&references).map(difference).sum::<f64>() / patches.len() as f64
    };
    let start: Vec<f64> = free.iter().flat_map(|column| column.to_array()).collect();
    // The edge of the simplex is of the size that entries change by; 100 steps a variable settle the mean to 1e-3.
    let best = nelder_mead(&start, 0.02, 100 * start.len(), error);
    // A camera that is right already would only gather rounding.
    if error(&start) - error(&best) < 1e-3 { free.iter().copied().chain([*last]).collect() } else { complete(&best) }
}

fn indistinct() -> Invalid {
    Invalid::new("channels", "the quantum efficiencies of the channels do not tell colours apart")
        .help("give each channel a curve of its own, or use cfa = \"mono\"")
}

/// Reflectances of the 24 patches.
fn checker() -> impl Iterator<Item = Spectrum> {
    library::names().filter(|name| name.starts_with("colour-checker/")).filter_map(library::spectrum)
}

#[cfg(test)]
mod tests {
    use super::*;

    type Channels = Vec<(String, Spectrum)>;

    fn bell(name: &str, centre: f64, height: f64, width: f64) -> (String, Spectrum) {
        let bell = |lambda: f64| height * (-0.5 * ((lambda - centre) / width).powi(2)).exp();
        (name.to_owned(), Spectrum::from_fn(bell))
    }

    /// Bell-shaped channels about where those of cameras are.
    fn camera() -> Channels {
        vec![bell("R", 600.0, 0.5, 35.0), bell("G", 535.0, 0.7, 35.0), bell("B", 465.0, 0.6, 35.0)]
    }

    /// Channels that are a linear mixture of the observer: such a camera can be corrected exactly.
    fn luther_camera() -> (Channels, DMat3) {
        let mixture = DMat3::from_cols_array(&[0.9, 0.1, 0.0, 0.3, 1.1, 0.1, 0.0, 0.2, 0.8]);
        let [x, y, z] = cie::observer();
        let channel = |row: DVec3| {
            Spectrum::from_fn(|lambda| {
                let xyz = [x, y, z].map(|bar| f64::from(bar.eval(lambda as f32)));
                row.dot(DVec3::from_array(xyz))
            })
        };
        ([0, 1, 2].map(|i| (["R", "G", "B"][i].to_owned(), channel(mixture.row(i)))).into(), mixture)
    }

    #[test]
    fn a_camera_that_mixes_the_observer_is_undone_exactly() {
        let (channels, mixture) = luther_camera();
        let matrix = xyz_to_camera(&channels, illuminant::d65()).expect("distinct");
        let d65 = cie::xyz(illuminant::d65());
        let white = mixture * (DVec3::from_array(d65) / d65[1]);
        let expected = mixture * (1.0 / white.max_element());
        // Channel tables are rounded to f32; the fit's condition number is below 100.
        for (i, row) in matrix.iter().enumerate() {
            assert!(expected.row(i).abs_diff_eq(DVec3::from_array(*row), 1e-5), "{row:?} {expected}");
        }
    }

    #[test]
    fn a_fourth_channel_makes_colours_no_worse() {
        // Mean ΔE₀₀ of the patches under D65.
        let error = |channels: &Channels| {
            let light = illuminant::d65();
            let columns = camera_to_xyz(channels, light).expect("distinct");
            let response =
                |light: &Spectrum| channels.iter().map(|(_, c)| c.product(light).integral()).collect::<Vec<_>>();
            let white = response(light);
            let xyz = |light: &Spectrum| DVec3::from_array(cie::xyz(light));
            let lab = |colour: DVec3| cielab::from_xyz(colour, xyz(light) / xyz(light).y);
            let differences = checker().map(|reflectance| {
                let reflected = light.product(&reflectance);
                let found: DVec3 = response(&reflected)
                    .iter()
                    .zip(&white)
                    .zip(&columns)
                    .map(|((r, w), column)| *column * (r / w))
                    .sum();
                difference::delta_e_2000(lab(xyz(&reflected) / xyz(light).y), lab(found))
            });
            differences.sum::<f64>() / 24.0
        };
        let mut four = camera();
        four.push(bell("E", 500.0, 0.6, 30.0));
        let (three, four) = (error(&camera()), error(&four));
        assert!(four < three, "{four} {three}");
    }

    #[test]
    fn white_stays_white_under_any_light() {
        let mut four = camera();
        four.push(bell("W", 550.0, 0.8, 120.0));
        for channels in [camera(), four] {
            for name in ["A", "D50", "D65", "FL11"] {
                let light = illuminant::illuminant(name).expect("known");
                let white: DVec3 = camera_to_xyz(&channels, &light).expect("distinct").iter().sum();
                let [x, y, z] = cie::xyz(&light);
                assert!(white.abs_diff_eq(DVec3::new(x, y, z) / y, 1e-9), "{name}");
            }
        }
    }

    #[test]
    fn each_matrix_gives_the_neutral_of_its_light() {
        for name in ["A", "D65"] {
            let light = illuminant::illuminant(name).expect("known");
            let colour = camera_colour(&camera(), &light).expect("distinct").expect("colour");
            let [x, y, z] = cie::xyz(&light);
            let matrix = if name == "A" { colour.matrix_a } else { colour.matrix_d65 };
            assert_eq!(colour.neutral.iter().copied().fold(0.0, f64::max), 1.0);
            for (row, neutral) in matrix.iter().zip(colour.neutral) {
                let response = row[0] * x / y + row[1] + row[2] * z / y;
                assert!((response - neutral).abs() < 1e-9, "{response} {neutral}");
            }
        }
    }

    #[test]
    fn colour_blind_cameras_are_refused() {
        let grey = |name: &str| (name.to_owned(), Spectrum::constant(0.5));
        let same = ["R", "G", "B"].map(grey);
        assert!(xyz_to_camera(&same, illuminant::d65()).is_err());
        let infrared = Spectrum::from_fn(|lambda| if lambda > 900.0 { 1.0 } else { 0.0 });
        assert!(neutral(&[grey("R"), ("I".to_owned(), infrared)], illuminant::d65()).is_err());
        assert_eq!(camera_colour(&same[..1], illuminant::d65()), Ok(None));
    }
}
