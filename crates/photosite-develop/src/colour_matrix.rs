//! Colour matrices of a camera: those between its channels and XYZ, and its response to white, all computed from
//! spectral responses.
//!
//! In: the responses of three channels or more (any common unit), as [`SensorModel::responses`] gives them, times the
//! transmittance of the lens where it has a colour; the spectrum of the light. Out: the numbers of a DNG file's
//! ColorMatrix, ForwardMatrix and AsShotNeutral ([Dng16](photosite_core::references#dng16), chapter 6).
//!
//! Both kinds of matrix are made for colours as readers show them: the mean ΔE₀₀ of the 24 patches of a colour checker.
//! It has no closed form; a simplex search lessens it, white kept. Of three channels a colour matrix is the inverse of
//! a forward matrix. Of more, no colour matrix has an inverse that is as good: those that keep white take the sum of
//! all channels for a brightness. So it is found by itself, for readers that know no forward matrix and to tell the
//! scene's white.
//!
//! Matrices of A and D65 alone would be mixed for lights between them. Where the channels overlap much, what is best
//! for D50 lies beside that mixture, so D50 has matrices of its own.
//!
//! [`SensorModel::responses`]: photosite_sensor::SensorModel::responses

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::colour::{camera_to_rgb, inverse};
use photosite_core::Invalid;
use photosite_core::colour::adaptation::{D50, bradford};
use photosite_core::colour::{ColourSpace, cielab, difference};
use photosite_core::math::minimise::nelder_mead;
use photosite_core::spectrum::{Spectrum, cie, illuminant, library};
use photosite_raw::{ColourCalibration, LightSource, RawMetadata};

/// Colour calibrations of three channels or more in A, D65 and D50: of the sensor and its lens alone, whatever the
/// light of the scene.
pub(super) fn calibrations(responses: &[(String, Spectrum)]) -> Result<Vec<ColourCalibration>, Invalid> {
    let d50 = illuminant::illuminant("D50").unwrap_or_else(|| illuminant::d65().clone());
    let lights = [(LightSource::A, &illuminant::a()), (LightSource::D65, illuminant::d65()), (LightSource::D50, &d50)];
    lights.into_par_iter().map(|(light, spectrum)| calibration(responses, light, spectrum)).collect()
}

/// Colour calibration of channels in one light.
fn calibration(
    responses: &[(String, Spectrum)],
    light: LightSource,
    spectrum: &Spectrum,
) -> Result<ColourCalibration, Invalid> {
    let chart = Chart::new(responses, spectrum, neutral(responses, spectrum)?);
    let start = chart.regression();
    let forward = chart.forward_matrix(&start);
    let colour = if start.len() == 3 { chart.colour_matrix_of(&forward) } else { chart.colour_matrix(&start) };
    // The squared determinant of three rows.
    let tells_colours = |rows: &Vec<DVec3>| {
        let square: DMat3 = rows.iter().map(|c| DMat3::from_cols(*c * c.x, *c * c.y, *c * c.z)).sum();
        rows.iter().all(|row| row.is_finite()) && square.determinant() > 1e-9
    };
    if !([&start, &colour].into_iter().all(tells_colours) && forward.iter().all(|column| column.is_finite())) {
        return Err(Invalid::new("channels", "the quantum efficiencies of the channels do not tell colours apart")
            .help("give each channel a curve of its own, or use cfa = \"mono\""));
    }
    let arrays = |rows: Vec<DVec3>| rows.iter().map(DVec3::to_array).collect();
    Ok(ColourCalibration { light, colour_matrix: arrays(colour), forward_matrix: Some(arrays(forward)) })
}

/// Mean ΔE₀₀ of the 24 patches of a colour checker in a light, as a camera with these channels shows them by the colour
/// calibrations of a raw file. `None` where there are none.
///
/// # Errors
///
/// Light that a channel does not see, and calibrations that give no colour.
pub fn chart_error(
    channels: &[(String, Spectrum)],
    calibrations: &[ColourCalibration],
    light: &Spectrum,
) -> Result<Option<f64>, Invalid> {
    let chart = Chart::new(channels, light, neutral(channels, light)?);
    let metadata = RawMetadata { calibrations: calibrations.to_vec(), ..RawMetadata::default() };
    let columns = camera_to_rgb(&metadata, &chart.neutral, SCREEN)?;
    // White-balanced camera → XYZ adapted to D50, as a forward matrix has it.
    let to_forward = chart.to_screen.inverse() * SCREEN.to_xyz();
    Ok(columns.map(|columns| chart.error(&columns.into_iter().map(|column| to_forward * column).collect::<Vec<_>>())))
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

/// All columns of a forward matrix but the last, which is what the others leave of white.
fn free(columns: &[DVec3]) -> Vec<f64> {
    columns.iter().take(columns.len().saturating_sub(1)).flat_map(DVec3::to_array).collect()
}

fn complete(free: &[f64]) -> Vec<DVec3> {
    let mut columns: Vec<DVec3> = free.as_chunks::<3>().0.iter().map(|column| DVec3::from_array(*column)).collect();
    columns.push(D50 - columns.iter().sum::<DVec3>());
    columns
}

/// Variables nearby that lessen an error. A camera that is right already would only gather rounding.
fn searched(start: &[f64], error: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    const ROUNDS: usize = 12;
    let first = error(start);
    let (mut best, mut least) = (start.to_vec(), first);
    // The edge of the simplex is of the size that entries change by. It gets thin before it gets small; a new one goes
    // on from where it stopped, until that gains next to nothing.
    for _ in 0..ROUNDS {
        let found = nelder_mead(&best, 0.02, 100 * start.len(), &error);
        let gain = least - error(&found);
        (best, least) = (found, least - gain);
        if gain < 1e-3 {
            break;
        }
    }
    if first - least < 1e-3 { start.to_vec() } else { best }
}

/// A space of screens, for its white: the difference of two colours depends on what they are adapted to.
const SCREEN: ColourSpace = ColourSpace::Srgb;

/// ΔE₀₀ for a noise that is as large in XYZ as in a channel that sees most.
const NOISE_PRICE: f64 = 0.2;

/// A colour checker in a light: what the camera responds, and what the observer sees.
struct Chart {
    /// XYZ of the light, Y = 1.
    white: DVec3,
    /// The camera's response to it, the largest component 1.
    neutral: Vec<f64>,
    /// XYZ adapted to D50 → to D65, in which screens show colours.
    to_screen: DMat3,
    patches: Vec<Patch>,
}

struct Patch {
    /// The camera's response over that to white.
    camera: Vec<f64>,
    /// XYZ, Y = 1 for white.
    xyz: DVec3,
    /// Luminance Y after adaptation to D65, 1 for white.
    luminance: f64,
    /// CIELAB adapted to D65.
    lab: DVec3,
}

impl Chart {
    fn new(channels: &[(String, Spectrum)], light: &Spectrum, neutral: Vec<f64>) -> Self {
        let respond = |light: &Spectrum| channels.iter().map(|(_, c)| c.product(light).integral()).collect::<Vec<_>>();
        let full = respond(light);
        let white = DVec3::from_array(cie::xyz(light));
        let adaptation = bradford(white / white.y, SCREEN.white());
        let patch = |reflectance: Spectrum| {
            let reflected = light.product(&reflectance);
            let xyz = DVec3::from_array(cie::xyz(&reflected)) / white.y;
            let camera = respond(&reflected).iter().zip(&full).map(|(r, full)| r / full).collect();
            let adapted = adaptation * xyz;
            Patch { camera, xyz, luminance: adapted.y, lab: cielab::from_xyz(adapted, SCREEN.white()) }
        };
        let to_screen = bradford(D50, SCREEN.white());
        Self { white: white / white.y, neutral, to_screen, patches: checker().map(patch).collect() }
    }

    /// Mean ΔE₀₀ of the patches as a forward matrix shows them, their brightness brought to that of the chart: how
    /// bright an image is, is a matter of exposure.
    fn error(&self, columns: &[DVec3]) -> f64 {
        let shown =
            |camera: &[f64]| self.to_screen * camera.iter().zip(columns).map(|(c, column)| *column * *c).sum::<DVec3>();
        // Least squares of luminance.
        let (product, square) = self.patches.iter().fold((0.0, 0.0), |(product, square), patch| {
            let found = shown(&patch.camera).y;
            (product + patch.luminance * found, square + found * found)
        });
        let difference = |patch: &Patch| {
            difference::delta_e_2000(
                patch.lab,
                cielab::from_xyz(shown(&patch.camera) * (product / square), SCREEN.white()),
            )
        };
        self.patches.iter().map(difference).sum::<f64>() / self.patches.len() as f64
    }

    /// Cost of a forward matrix: its [`Self::error`], with a price on noise where there are more than three channels.
    /// There the patches leave combinations of channels open, of which those with large entries of both signs would
    /// show more noise than colour. Shot noise of a balanced channel has a variance in proportion to 1/n.
    fn cost(&self, columns: &[DVec3]) -> f64 {
        if columns.len() == 3 {
            return self.error(columns);
        }
        let noise =
            columns.iter().zip(&self.neutral).map(|(column, n)| column.length_squared() / n).sum::<f64>().sqrt();
        self.error(columns) + NOISE_PRICE * noise
    }

    /// A colour matrix to begin with: each row c is min Σᵢ (c·xᵢ − rᵢ)² rᵢ^(−4/3), subject to c·w = n, with the
    /// responses rᵢ to the patches xᵢ. The weights turn errors into those of CIELAB, which is made of cube roots:
    /// d(r^⅓) ∝ r^(−⅔) dr. Without them bright patches would be all that counts.
    fn regression(&self) -> Vec<DVec3> {
        let row = |(channel, neutral): (usize, &f64)| {
            // Normal equations A·c = b. A Lagrange multiplier then shares out what c·w lacks, along A⁻¹·w.
            let (mut a, mut b) = (DMat3::ZERO, DVec3::ZERO);
            for Patch { camera, xyz, .. } in &self.patches {
                let weight = camera[channel].powf(-4.0 / 3.0);
                a += DMat3::from_cols(*xyz * xyz.x, *xyz * xyz.y, *xyz * xyz.z) * weight;
                b += *xyz * (weight * camera[channel]);
            }
            let (free, along) = (a.inverse() * b, a.inverse() * self.white);
            (free + along * ((1.0 - free.dot(self.white)) / along.dot(self.white))) * *neutral
        };
        self.neutral.iter().enumerate().map(row).collect()
    }

    /// The forward matrix that shows the patches best, near that of a colour matrix, white kept.
    fn forward_matrix(&self, start: &[DVec3]) -> Vec<DVec3> {
        complete(&searched(&free(&self.forward_matrix_of(start)), |free| self.cost(&complete(free))))
    }

    /// The colour matrix nearby whose inverse shows the patches best, white kept: the middle of each row is what white
    /// leaves it.
    fn colour_matrix(&self, start: &[DVec3]) -> Vec<DVec3> {
        let complete = |free: &[f64]| -> Vec<DVec3> {
            let row = |([x, z], neutral): (&[f64; 2], &f64)| {
                DVec3::new(*x, (neutral - x * self.white.x - z * self.white.z) / self.white.y, *z)
            };
            free.as_chunks::<2>().0.iter().zip(&self.neutral).map(row).collect()
        };
        let free: Vec<f64> = start.iter().flat_map(|row| [row.x, row.z]).collect();
        complete(&searched(&free, |free| self.error(&self.forward_matrix_of(&complete(free)))))
    }

    /// White-balanced camera → XYZ adapted to D50, by the inverse of a colour matrix.
    fn forward_matrix_of(&self, colour_matrix: &[DVec3]) -> Vec<DVec3> {
        let adaptation = bradford(self.white, D50);
        inverse(colour_matrix).into_iter().zip(&self.neutral).map(|(column, n)| adaptation * column * *n).collect()
    }

    /// Colour matrix of a forward matrix, for three channels.
    fn colour_matrix_of(&self, forward: &[DVec3]) -> Vec<DVec3> {
        let [r, g, b] = [0, 1, 2].map(|i| forward[i]);
        let rows = (DMat3::from_cols(r, g, b).inverse() * bradford(self.white, D50)).transpose();
        [rows.x_axis, rows.y_axis, rows.z_axis].iter().zip(&self.neutral).map(|(row, n)| *row * *n).collect()
    }
}

/// Reflectances of the 24 patches.
fn checker() -> impl Iterator<Item = Spectrum> {
    library::colour_checker().map(|(_, patch)| patch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera_colour::{CameraColour, camera_colour};

    #[test]
    fn calibrations_of_a_camera_show_its_charts_best() {
        let (own, other) = (camera(), luther_camera().0);
        let d50 = illuminant::illuminant("D50").expect("known");
        let of = |camera: &Channels| camera_colour(camera, &d50).expect("colours").expect("three").calibrations;
        let error = |camera: &Channels, by: &[ColourCalibration]| {
            chart_error(camera, by, &d50).expect("colours").expect("calibrations")
        };
        let (by_own, by_other) = (of(&own), of(&other));
        let (own_by_own, other_by_other) = (error(&own, &by_own), error(&other, &by_other));
        assert!(other_by_other < 0.1 && own_by_own < 4.0, "{other_by_other} {own_by_own}");
        assert!(error(&own, &by_other) > own_by_own + 1.0 && error(&other, &by_own) > other_by_other + 1.0);
        assert_eq!(chart_error(&own, &[], &d50), Ok(None));
    }

    type Channels = Vec<(String, Spectrum)>;

    fn bell(name: &str, centre: f64, height: f64, width: f64) -> (String, Spectrum) {
        let bell = |lambda: f64| height * (-0.5 * ((lambda - centre) / width).powi(2)).exp();
        (name.to_owned(), Spectrum::from_fn(bell))
    }

    /// Camera with bell-shaped channels at usual wavelengths.
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

    fn colour(channels: &Channels, light: &Spectrum) -> CameraColour {
        camera_colour(channels, light).expect("distinct").expect("colour")
    }

    fn in_light(colour: &CameraColour, light: LightSource) -> ColourCalibration {
        colour.calibrations.iter().find(|calibration| calibration.light == light).expect("known").clone()
    }

    #[test]
    fn a_camera_that_mixes_the_observer_is_undone_exactly() {
        let (channels, mixture) = luther_camera();
        let matrix = in_light(&colour(&channels, illuminant::d65()), LightSource::D65).colour_matrix;
        let d65 = cie::xyz(illuminant::d65());
        let white = mixture * (DVec3::from_array(d65) / d65[1]);
        let expected = mixture * (1.0 / white.max_element());
        // Channel tables are rounded to f32; the fit's condition number is below 100.
        for (i, row) in matrix.iter().enumerate() {
            assert!(expected.row(i).abs_diff_eq(DVec3::from_array(*row), 1e-5), "{row:?} {expected}");
        }
    }

    /// Mean ΔE₀₀ of the patches under D65 by the forward matrix and by the inverse of the colour matrix.
    fn errors(channels: &Channels) -> [f64; 2] {
        let light = illuminant::d65();
        let chart = Chart::new(channels, light, neutral(channels, light).expect("seen"));
        let of_d65 = in_light(&colour(channels, light), LightSource::D65);
        let vectors = |rows: Vec<[f64; 3]>| rows.into_iter().map(DVec3::from_array).collect::<Vec<_>>();
        let forward = vectors(of_d65.forward_matrix.expect("always there"));
        [forward, chart.forward_matrix_of(&vectors(of_d65.colour_matrix))].map(|m| chart.error(&m))
    }

    #[test]
    fn more_channels_make_colours_no_worse() {
        let [three, by_inverse] = errors(&camera());
        assert!((three - by_inverse).abs() < 1e-9, "one and the same matrix");
        for (name, centre, width) in [("E", 500.0, 30.0), ("W", 550.0, 120.0)] {
            let mut channels = camera();
            channels.push(bell(name, centre, 0.6, width));
            let [four, by_inverse] = errors(&channels);
            println!("{name}: {four:.3}, by the inverse {by_inverse:.3}, without it {three:.3}");
            // Less noise may cost a little; the inverse takes the sum of all channels for a brightness.
            assert!(four < three + 0.1 && by_inverse < 2.0, "{name}: {four} {by_inverse}, {three} without it");
        }
    }

    #[test]
    fn each_matrix_gives_the_neutral_of_its_light() {
        let mut four = camera();
        four.push(bell("W", 550.0, 0.8, 120.0));
        let mut five = four.clone();
        five.push(bell("E", 500.0, 0.6, 30.0));
        for channels in [camera(), four, five] {
            for (name, source) in [("A", LightSource::A), ("D50", LightSource::D50), ("D65", LightSource::D65)] {
                let light = illuminant::illuminant(name).expect("known");
                let colour = colour(&channels, &light);
                let [x, y, z] = cie::xyz(&light);
                let calibration = in_light(&colour, source);
                assert_eq!(colour.neutral.iter().copied().fold(0.0, f64::max), 1.0);
                for (row, neutral) in calibration.colour_matrix.iter().zip(colour.neutral) {
                    let response = row[0] * x / y + row[1] + row[2] * z / y;
                    assert!((response - neutral).abs() < 1e-9, "{response} {neutral}");
                }
                let forward = calibration.forward_matrix.expect("always there");
                let white: DVec3 = forward.into_iter().map(DVec3::from_array).sum();
                assert!(white.abs_diff_eq(D50, 1e-9), "{white}");
            }
        }
    }

    #[test]
    fn colour_blind_cameras_are_refused() {
        let grey = |name: &str| (name.to_owned(), Spectrum::constant(0.5));
        let same = ["R", "G", "B"].map(grey);
        assert!(camera_colour(&same, illuminant::d65()).is_err());
        let infrared = Spectrum::from_fn(|lambda| if lambda > 900.0 { 1.0 } else { 0.0 });
        let lamp = illuminant::illuminant("FL2").expect("known");
        assert!(neutral(&[grey("R"), ("I".to_owned(), infrared)], &lamp).is_err());
        assert_eq!(camera_colour(&same[..1], illuminant::d65()), Ok(None));
    }
}
