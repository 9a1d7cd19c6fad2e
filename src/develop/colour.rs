//! Colour: white-balanced camera channels become linear RGB of a colour space.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::Invalid;
use crate::colour::adaptation::D50;
use crate::colour::{ColourSpace, temperature};
use crate::image::{Channel, Planes};
use crate::raw::RawMetadata;

/// What a raw file says of its colours under D65 and under illuminant A.
pub(super) struct CameraMatrices {
    /// XYZ → camera, a row per channel.
    d65: Vec<DVec3>,
    a: Vec<DVec3>,
    /// White-balanced camera → XYZ adapted to D50, a column per channel, where the file has such.
    forward: Option<[Vec<DVec3>; 2]>,
}

impl CameraMatrices {
    /// The matrices of a raw file, if it has any.
    pub(super) fn new(metadata: &RawMetadata) -> Result<Option<Self>, Invalid> {
        let Some(d65) = &metadata.colour_matrix_d65 else { return Ok(None) };
        let a = metadata.colour_matrix_a.as_ref().unwrap_or(d65);
        if a.len() != d65.len() {
            let message = format!("{} rows, while ColorMatrix1 has {}", a.len(), d65.len());
            return Err(Invalid::new("ColorMatrix2", message));
        }
        let vectors = |matrix: &[[f64; 3]]| matrix.iter().map(|&row| DVec3::from_array(row)).collect::<Vec<_>>();
        let forward_d65 = metadata.forward_matrix_d65.as_ref();
        let forward_a = metadata.forward_matrix_a.as_ref().or(forward_d65);
        let forward = forward_d65.zip(forward_a).filter(|(of_d65, of_a)| [of_d65.len(), of_a.len()] == [d65.len(); 2]);
        let forward = forward.map(|(d65, a)| [vectors(d65), vectors(a)]);
        Ok(Some(Self { d65: vectors(d65), a: vectors(a), forward }))
    }

    /// The matrix for a scene whose white has this XYZ: it lies between those of D65 and illuminant A by reciprocal
    /// colour temperature ([Dng16](crate::references#dng16), chapter 6).
    pub(super) fn at(&self, white: DVec3) -> Vec<DVec3> {
        between(&self.d65, &self.a, white)
    }

    /// The scene's white in XYZ, Y = 1, for the camera's response to it, with camera → XYZ, a column per channel. The
    /// matrix depends on the white point and the white point on the matrix: a fixed point.
    pub(super) fn scene_white(&self, neutral: &[f64]) -> (DVec3, Vec<DVec3>) {
        let mut to_xyz = inverse(&self.d65);
        let mut white = DVec3::ONE;
        for _ in 0..ROUNDS {
            white = to_xyz.iter().zip(neutral).map(|(column, n)| *column * *n).sum();
            to_xyz = inverse(&self.at(white));
        }
        (white, to_xyz)
    }
}

/// The mean of a matrix for D65 and one for A that holds for a white of this XYZ.
fn between(d65: &[DVec3], a: &[DVec3], white: DVec3) -> Vec<DVec3> {
    let part = part_of_a(white);
    d65.iter().zip(a).map(|(d65, a)| *d65 * (1.0 - part) + *a * part).collect()
}

/// Enough for the fixed point to settle to 1e-6: the matrices differ little, so each round gains a digit or more.
const ROUNDS: usize = 12;

/// The least-squares inverse (CᵀC)⁻¹Cᵀ of a matrix given by rows, by columns; with three channels the inverse.
pub(super) fn inverse(rows: &[DVec3]) -> Vec<DVec3> {
    let normal: DMat3 = rows.iter().map(|row| DMat3::from_cols(*row * row.x, *row * row.y, *row * row.z)).sum();
    let inverse = normal.inverse();
    rows.iter().map(|row| inverse * *row).collect()
}

/// White-balanced camera → linear RGB of the space, a column per channel, in which white (1, 1, 1 …) is white. `None` for
/// a raw file that has no matrix.
pub(super) fn camera_to_rgb(
    metadata: &RawMetadata,
    neutral: &[f64],
    space: ColourSpace,
) -> Result<Option<Vec<DVec3>>, Invalid> {
    let Some(matrices) = CameraMatrices::new(metadata)? else { return Ok(None) };
    let wrong = || {
        let message = format!("{:?} and the response to white {neutral:?} do not give a colour", matrices.d65);
        Invalid::new("ColorMatrix1", message).help("the file is damaged, or its camera cannot tell colours apart")
    };
    if matrices.d65.len() != neutral.len() {
        return Err(wrong());
    }
    let (white, to_xyz) = matrices.scene_white(neutral);
    let columns: Vec<DVec3> = match &matrices.forward {
        // The way that the specification prefers. Of three channels the inverse of the colour matrix is as exact, and between
        // two lights it is nearer to the colours of a third.
        Some([d65, a]) if neutral.len() > 3 => {
            between(d65, a, white).into_iter().map(|column| space.from_xyz(D50) * column).collect()
        }
        Some(_) | None => {
            let from_xyz = space.from_xyz(white / white.y);
            to_xyz.iter().zip(neutral).map(|(xyz, n)| from_xyz * (*xyz * (n / white.y))).collect()
        }
    };
    if white.is_finite() && columns.iter().all(|column| column.is_finite()) { Ok(Some(columns)) } else { Err(wrong()) }
}

/// How far the white XYZ lies from D65 to illuminant A in reciprocal correlated colour temperature, 0–1.
pub(super) fn part_of_a(white: DVec3) -> f64 {
    let [x, y] = [white.x, white.y].map(|component| component / white.element_sum());
    // McCamy (1992), good to a few kelvin between the two, which is all that counts here.
    let n = (x - 0.3320) / (0.1858 - y);
    let temperature = ((449.0 * n + 3525.0) * n + 6823.3) * n + 5520.33;
    let part = (1.0 / temperature - 1.0 / 6504.0) / (1.0 / 2856.0 - 1.0 / 6504.0);
    if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) }
}

/// Colour temperature (K) and tint of the light that a camera responds to so.
pub(super) fn temperature_of(metadata: &RawMetadata, neutral: &[f64]) -> Option<(f64, f64)> {
    let matrices = CameraMatrices::new(metadata).ok().flatten().filter(|m| m.d65.len() == neutral.len())?;
    let (white, _) = matrices.scene_white(neutral);
    let sum = white.element_sum();
    (sum > 0.0).then(|| temperature::temperature_and_tint([white.x / sum, white.y / sum]))
}

/// Turns camera planes into planes R, G and B (X, Y and Z) by a matrix and a factor.
pub(super) fn apply(mut camera: Planes, columns: &[DVec3], space: ColourSpace, factor: f64) -> Planes {
    let (width, height) = (camera.width(), camera.height());
    let names = if space == ColourSpace::Xyz { ["X", "Y", "Z"] } else { ["R", "G", "B"] };
    let columns: Vec<[f32; 3]> = columns.iter().map(|column| (*column * factor).as_vec3().to_array()).collect();
    let planes: Vec<Vec<f32>> = camera.channels_mut().iter_mut().map(|c| std::mem::take(&mut c.data)).collect();
    let planes = match <[Vec<f32>; 3]>::try_from(planes) {
        Ok(planes) => in_place(planes, &columns, width),
        Err(planes) => from_many(&planes, &columns),
    };
    let channels = names.into_iter().zip(planes).map(|(name, data)| Channel { name: name.to_owned(), data });
    Planes::new(width, height, channels.collect()).expect("planes keep their size")
}

/// Three channels to three, without another copy of the picture.
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
        let rows = |extra: bool| {
            let mut d65 = vec![[0.8, -0.25, -0.1], [-0.4, 1.2, 0.2], [-0.05, 0.15, 0.6]];
            let mut a = vec![[0.9, -0.35, -0.15], [-0.3, 1.1, 0.25], [0.0, 0.1, 0.7]];
            if extra {
                d65.push([0.3, 0.5, 0.2]);
                a.push([0.35, 0.45, 0.2]);
            }
            RawMetadata { colour_matrix_d65: Some(d65), colour_matrix_a: Some(a), ..RawMetadata::default() }
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
