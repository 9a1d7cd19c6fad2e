//! Colour: white-balanced camera channels become linear RGB of a colour space.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use photosite_core::Invalid;
use photosite_core::colour::ColourSpace;
use photosite_core::colour::adaptation::D50;
use photosite_core::colour::temperature::temperature_and_tint;
use photosite_core::image::{Channel, Planes};
use photosite_raw::{ColourCalibration, RawMetadata};

/// Camera matrices of a raw file in some lights, the reddest first.
pub(super) struct CameraMatrices(Vec<LightMatrices>);

struct LightMatrices {
    /// Reciprocal colour temperature of the light, 1/K.
    reciprocal_temperature: f64,
    /// XYZ → camera, a row per channel.
    colour: Vec<DVec3>,
    /// White-balanced camera → XYZ adapted to D50, a column per channel, where the file has such.
    forward: Option<Vec<DVec3>>,
}

impl CameraMatrices {
    /// The matrices of a raw file, if it has any.
    pub(super) fn new(metadata: &RawMetadata) -> Result<Option<Self>, Invalid> {
        let Some(first) = metadata.calibrations.first() else { return Ok(None) };
        let channels = first.colour_matrix.len();
        if let Some(i) = metadata.calibrations.iter().position(|lit| lit.colour_matrix.len() != channels) {
            let rows = metadata.calibrations[i].colour_matrix.len();
            let message = format!("{rows} rows, while ColorMatrix1 has {channels}");
            return Err(Invalid::new(format!("ColorMatrix{}", i + 1), message));
        }
        let vectors = |matrix: &Vec<[f64; 3]>| matrix.iter().map(|&row| DVec3::from_array(row)).collect::<Vec<_>>();
        let lit = |lit: &ColourCalibration| LightMatrices {
            reciprocal_temperature: 1.0 / lit.light.temperature_k(),
            colour: vectors(&lit.colour_matrix),
            forward: lit.forward_matrix.as_ref().filter(|forward| forward.len() == channels).map(vectors),
        };
        let mut lit: Vec<LightMatrices> = metadata.calibrations.iter().map(lit).collect();
        lit.sort_by(|a, b| b.reciprocal_temperature.total_cmp(&a.reciprocal_temperature));
        Ok(Some(Self(lit)))
    }

    /// Number of channels.
    pub(super) fn channels(&self) -> usize {
        self.0.first().map_or(0, |lit| lit.colour.len())
    }

    /// The colour matrix for a scene whose white has this XYZ.
    pub(super) fn at(&self, white: DVec3) -> Vec<DVec3> {
        self.between(white, |lit| Some(&lit.colour)).unwrap_or_default()
    }

    /// The forward matrix for such a scene, where the file has one in all lights.
    fn forward_at(&self, white: DVec3) -> Option<Vec<DVec3>> {
        self.0
            .iter()
            .all(|lit| lit.forward.is_some())
            .then(|| self.between(white, |lit| lit.forward.as_ref()))
            .flatten()
    }

    /// The mean of the matrices in the two lights next to a white of this XYZ, by reciprocal colour temperature
    /// ([Dng16](photosite_core::references#dng16), chapter 6, which has it so for two lights).
    fn between<'a>(
        &'a self,
        white: DVec3,
        of: impl Fn(&'a LightMatrices) -> Option<&'a Vec<DVec3>>,
    ) -> Option<Vec<DVec3>> {
        let reciprocal = 1.0 / temperature(white);
        let bluer = self.0.iter().position(|lit| lit.reciprocal_temperature <= reciprocal);
        // Beyond the last, or with a white that has no temperature, that of the bluest.
        let bluer = bluer.unwrap_or(self.0.len().saturating_sub(1));
        let (red, blue) = (self.0.get(bluer.saturating_sub(1))?, self.0.get(bluer)?);
        let span = red.reciprocal_temperature - blue.reciprocal_temperature;
        let part = (reciprocal - blue.reciprocal_temperature) / span;
        let part = if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) };
        Some(of(blue)?.iter().zip(of(red)?).map(|(blue, red)| *blue * (1.0 - part) + *red * part).collect())
    }

    /// The scene's white in XYZ, Y = 1, for the camera's response to it, with camera → XYZ, a column per channel. The
    /// matrix depends on the white point and the white point on the matrix: a fixed point.
    pub(super) fn scene_white(&self, neutral: &[f64]) -> (DVec3, Vec<DVec3>) {
        let mut white = DVec3::ONE;
        let mut to_xyz = inverse(&self.at(white));
        for _ in 0..ROUNDS {
            white = to_xyz.iter().zip(neutral).map(|(column, n)| *column * *n).sum();
            to_xyz = inverse(&self.at(white));
        }
        (white, to_xyz)
    }
}

/// Enough for the fixed point to settle to 1e-6: the matrices differ little, so each round gains a digit or more.
const ROUNDS: usize = 12;

/// The least-squares inverse (CᵀC)⁻¹Cᵀ of a matrix given by rows, by columns; with three channels the inverse.
pub(super) fn inverse(rows: &[DVec3]) -> Vec<DVec3> {
    let normal: DMat3 = rows.iter().map(|row| DMat3::from_cols(*row * row.x, *row * row.y, *row * row.z)).sum();
    let inverse = normal.inverse();
    rows.iter().map(|row| inverse * *row).collect()
}

/// White-balanced camera → linear RGB of the space, a column per channel, in which white (1, 1, 1 …) is white. `None`
/// for a raw file that has no matrix.
pub(super) fn camera_to_rgb(
    metadata: &RawMetadata,
    neutral: &[f64],
    space: ColourSpace,
) -> Result<Option<Vec<DVec3>>, Invalid> {
    let Some(matrices) = CameraMatrices::new(metadata)? else { return Ok(None) };
    let wrong = || {
        let message = format!("with the response to white {neutral:?} gives no colour");
        Invalid::new("ColorMatrix1", message).help("the file is damaged, or its camera cannot tell colours apart")
    };
    if matrices.channels() != neutral.len() {
        return Err(wrong());
    }
    let (white, to_xyz) = matrices.scene_white(neutral);
    let columns: Vec<DVec3> = match matrices.forward_at(white) {
        // The way that the specification prefers. Of three channels the inverse of the colour matrix is as exact, and
        // between two lights it is nearer to the colours of a third.
        Some(forward) if neutral.len() > 3 => forward.into_iter().map(|column| space.from_xyz(D50) * column).collect(),
        Some(_) | None => {
            let from_xyz = space.from_xyz(white / white.y);
            to_xyz.iter().zip(neutral).map(|(xyz, n)| from_xyz * (*xyz * (n / white.y))).collect()
        }
    };
    if white.is_finite() && columns.iter().all(|column| column.is_finite()) { Ok(Some(columns)) } else { Err(wrong()) }
}

/// Correlated colour temperature, K, of a white of this XYZ: McCamy (1992), good to a few kelvin from A to D65, which
/// is all that counts here.
fn temperature(white: DVec3) -> f64 {
    let [x, y] = [white.x, white.y].map(|component| component / white.element_sum());
    let n = (x - 0.3320) / (0.1858 - y);
    ((449.0 * n + 3525.0) * n + 6823.3) * n + 5520.33
}

/// Colour temperature (K) and tint of the light that a camera responds to so.
pub(super) fn temperature_of(metadata: &RawMetadata, neutral: &[f64]) -> Option<(f64, f64)> {
    let matrices = CameraMatrices::new(metadata).ok().flatten().filter(|m| m.channels() == neutral.len())?;
    let (white, _) = matrices.scene_white(neutral);
    let sum = white.element_sum();
    (sum > 0.0).then(|| temperature_and_tint([white.x / sum, white.y / sum]))
}

/// Turns camera planes into planes R, G and B (X, Y and Z) by a matrix and a factor.
pub(super) fn apply(mut camera: Planes, columns: &[DVec3], space: ColourSpace, factor: f64) -> Planes {
    let (width, height) = (camera.width(), camera.height());
    let names = space.channels();
    let columns = scaled(columns, factor);
    let planes: Vec<Vec<f32>> = camera.channels_mut().iter_mut().map(|c| std::mem::take(&mut c.data)).collect();
    let planes = match <[Vec<f32>; 3]>::try_from(planes) {
        Ok(planes) => in_place(planes, &columns, width),
        Err(planes) => from_many(&planes, &columns),
    };
    let channels = names.into_iter().zip(planes).map(|(name, data)| Channel { name: name.to_owned(), data });
    Planes::new(width, height, channels.collect()).expect("planes keep their size")
}

/// Columns of a matrix times a factor, as pixels are multiplied by them.
pub(super) fn scaled(columns: &[DVec3], factor: f64) -> Vec<[f32; 3]> {
    columns.iter().map(|column| (*column * factor).as_vec3().to_array()).collect()
}

/// Three channels to three, without another copy of the image.
fn in_place(mut planes: [Vec<f32>; 3], columns: &[[f32; 3]], width: usize) -> [Vec<f32>; 3] {
    let [Some(a), Some(b), Some(c)] = [0, 1, 2].map(|i| columns.get(i).copied()) else { return planes };
    let [r, g, b_plane] = &mut planes;
    let width = width.max(1);
    let rows = r.par_chunks_mut(width).zip(g.par_chunks_mut(width)).zip(b_plane.par_chunks_mut(width));
    rows.for_each(|((r, g), blue)| {
        for ((r, g), blue) in r.iter_mut().zip(g).zip(blue) {
            let (x, y, z) = (*r, *g, *blue);
            *r = a[0] * x + b[0] * y + c[0] * z;
            *g = a[1] * x + b[1] * y + c[1] * z;
            *blue = a[2] * x + b[2] * y + c[2] * z;
        }
    });
    planes
}

fn from_many(planes: &[Vec<f32>], columns: &[[f32; 3]]) -> [Vec<f32>; 3] {
    let pixels = planes.first().map_or(0, Vec::len);
    [0, 1, 2].map(|row| {
        let value = |i: usize| planes.iter().zip(columns).map(|(plane, column)| column[row] * plane[i]).sum();
        (0..pixels).into_par_iter().map(value).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::spectrum::{cie, illuminant};
    use photosite_raw::LightSource;

    /// A file with a matrix that is that many times the identity in each of these lights.
    fn lit(lights: &[(LightSource, f64)]) -> RawMetadata {
        let scaled = |&(light, factor): &(LightSource, f64)| ColourCalibration {
            light,
            colour_matrix: DMat3::from_diagonal(DVec3::splat(factor)).to_cols_array_2d().to_vec(),
            forward_matrix: None,
        };
        RawMetadata { calibrations: lights.iter().map(scaled).collect(), ..RawMetadata::default() }
    }

    #[test]
    fn matrices_are_mixed_by_reciprocal_temperature() {
        let at = |lights: &[(LightSource, f64)], light: &str| {
            let white = DVec3::from_array(cie::xyz(&illuminant::illuminant(light).expect("known")));
            CameraMatrices::new(&lit(lights)).expect("alike").expect("some").at(white)[0].x
        };
        let (a, d50, d65) = ((LightSource::A, 2.0), (LightSource::D50, 5.0), (LightSource::D65, 1.0));
        // In mired: 153.8 for D65, 199.9 for D50 at 5003 K, 350.1 for A. McCamy is good to a few kelvin.
        let between = 1.0 + (199.9 - 153.75) / (350.14 - 153.75);
        for (lights, light, expected) in [
            (&[a, d65][..], "D65", 1.0),
            (&[a, d65], "D50", between),
            (&[d65, a], "A", 2.0),
            (&[a, d65], "D75", 1.0),
            (&[a, d65], "2000K", 2.0),
            (&[a, d65, d50], "D50", 5.0),
            (&[a, d65, d50], "A", 2.0),
            (&[a, d65, d50], "D65", 1.0),
            (&[d50], "A", 5.0),
        ] {
            let found = at(lights, light);
            assert!((found - expected).abs() < 0.02, "{light} of {lights:?}: {found}");
        }
        let matrices = CameraMatrices::new(&lit(&[a, d50, d65])).expect("alike").expect("some");
        assert_eq!(matrices.at(DVec3::NAN)[0].x, 1.0);
        let mut unlike = lit(&[a, d65]);
        unlike.calibrations[1].colour_matrix.pop();
        assert_eq!(CameraMatrices::new(&unlike).err().map(|invalid| invalid.key), Some("ColorMatrix2".to_owned()));
    }

    #[test]
    fn white_stays_white_whatever_the_neutral_is() {
        let rows = |extra: bool| {
            let mut d65 = vec![[0.8, -0.25, -0.1], [-0.4, 1.2, 0.2], [-0.05, 0.15, 0.6]];
            let mut a = vec![[0.9, -0.35, -0.15], [-0.3, 1.1, 0.25], [0.0, 0.1, 0.7]];
            if extra {
                d65.push([0.3, 0.5, 0.2]);
                a.push([0.35, 0.45, 0.2]);
            }
            let of = |light, colour_matrix| ColourCalibration { light, colour_matrix, forward_matrix: None };
            let calibrations = vec![of(LightSource::A, a), of(LightSource::D65, d65)];
            RawMetadata { calibrations, ..RawMetadata::default() }
        };
        for (extra, neutrals) in [
            (false, [vec![0.5, 1.0, 0.7], vec![1.0, 0.9, 0.2], vec![0.2, 1.0, 1.0]]),
            (true, [vec![0.5, 1.0, 0.7, 0.9], vec![1.0, 0.9, 0.2, 0.8], vec![0.4, 1.0, 0.9, 0.9]]),
        ] {
            for neutral in neutrals {
                for space in ColourSpace::ALL {
                    let columns = camera_to_rgb(&rows(extra), &neutral, space).expect("finite").expect("a matrix");
                    let white: DVec3 = columns.iter().sum();
                    let expected = if space == ColourSpace::Xyz { space.white() } else { DVec3::ONE };
                    // Four channels cannot all be right; the inverse is that of least squares.
                    assert!(white.abs_diff_eq(expected, 1e-6), "{space:?} {neutral:?}: {white}");
                }
            }
        }
    }

    #[test]
    fn planes_are_multiplied() {
        let channel = |name: &str, v: f32| Channel { name: name.to_owned(), data: vec![v; 2] };
        let columns = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.0, 0.0, 1.0), DVec3::ONE];
        for (n, expected) in [(3, [2.0, 2.0, 7.0]), (4, [5.0, 5.0, 10.0])] {
            let channels = [("R", 1.0), ("G", 2.0), ("B", 4.0), ("W", 3.0)].map(|(name, v)| channel(name, v));
            let planes = Planes::new(2, 1, channels[..n].to_vec()).expect("right sizes");
            let found = apply(planes, &columns[..n], ColourSpace::Srgb, 1.0);
            assert_eq!([0, 1, 2].map(|c| found.channels()[c].data[1]), expected);
        }
    }
}
