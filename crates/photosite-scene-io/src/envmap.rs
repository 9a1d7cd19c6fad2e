//! Environment maps in the layouts of OpenEXR's attribute `envmap`, turned into panoramas whose texel centres lie half
//! a texel from the edges.
//!
//! OpenEXR puts the centres of the outermost texels on the edges: on the poles and, twice, on the seam of a
//! latitude-longitude map, and on the edges of the faces of a cube, which so are stored with each of the two faces
//! ([`ImfEnvmap.h`](https://openexr.com/en/latest/TechnicalIntroduction.html)).

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use photosite_core::Invalid;

/// Texels in rows, with their columns and rows.
type Texels = (Vec<[f32; 3]>, [usize; 2]);

/// Panorama of a latitude-longitude map. The map's texels lie at the corners of the panorama's, each of which is the
/// mean of four, the bilinear interpolation at its centre.
pub(crate) fn of_latitude_longitude(texels: &[[f32; 3]], [width, height]: [usize; 2]) -> Texels {
    let size = [width, height].map(|side| side.max(2) - 1);
    let at = |x: usize, y: usize| Vec3::from(texels[y.min(height - 1) * width + x.min(width - 1)]);
    let texel = |i: usize| {
        let (x, y) = (i % size[0], i / size[0]);
        (0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))).to_array()
    };
    ((0..size[0] * size[1]).map(texel).collect(), size)
}

/// Panorama, four faces wide, of a cube map with faces +x, −x, +y, −y, +z and −z one below the other. A direction takes
/// the bilinear interpolation of the face that it meets.
///
/// # Errors
///
/// A size that six squares do not have.
pub(crate) fn of_cube(texels: &[[f32; 3]], [width, height]: [usize; 2]) -> Result<Texels, Invalid> {
    if height != 6 * width {
        let message =
            format!("says six faces of a cube one below the other, but the image has {width} × {height} pixels");
        return Err(Invalid::new("envmap", message).help("write six squares, or remove the attribute of a panorama"));
    }
    let size = [4 * width, 2 * width];
    let last = width as f64 - 1.0;
    let texel = |i: usize| {
        let [u, v] = [i % size[0], i / size[0]].map(|n| n as f64 + 0.5);
        let latitude = PI * (0.5 - v / size[1] as f64);
        let longitude = TAU * (0.5 - u / size[0] as f64);
        let towards = DVec3::new(longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos());
        let (face, [x, y]) = place_on_cube(towards);
        let [x, y] = [x, y].map(|part| (0.5 * (part + 1.0)).clamp(0.0, 1.0) * last);
        let at = |x: usize, y: usize| Vec3::from(texels[(face * width + y) * width + x]);
        let [x0, y0] = [x, y].map(|at| at.floor() as usize);
        let [x1, y1] = [x0, y0].map(|at| (at + 1).min(width - 1));
        let [across, down] = [x - x0 as f64, y - y0 as f64].map(|part| part as f32);
        let row = |y: usize| at(x0, y).lerp(at(x1, y), across);
        row(y0).lerp(row(y1), down).to_array()
    };
    Ok(((0..size[0] * size[1]).map(texel).collect(), size))
}

/// Face of a cube that a direction meets, and the place on it: column and row from −1 to 1.
fn place_on_cube(towards: DVec3) -> (usize, [f64; 2]) {
    let DVec3 { x, y, z } = towards;
    let most = towards.abs().max_element();
    let (face, place) = if x.abs() == most {
        if x > 0.0 { (0, [z, -y]) } else { (1, [-z, -y]) }
    } else if y.abs() == most {
        if y > 0.0 { (2, [x, -z]) } else { (3, [x, z]) }
    } else if z > 0.0 {
        (4, [-x, -y])
    } else {
        (5, [x, -y])
    };
    (face, place.map(|part| part / most))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radiance of a direction: smooth, and different along each axis.
    fn light(towards: DVec3) -> [f32; 3] {
        let d = towards.normalize();
        [2.0 + d.x, 2.0 + d.y, 2.0 + d.z].map(|value| value as f32)
    }

    /// Direction of a place of a panorama with edges at 0 and 1, its middle along +z, as in OpenEXR.
    fn direction(u: f64, v: f64) -> DVec3 {
        let (latitude, longitude) = (PI * (0.5 - v), TAU * (0.5 - u));
        DVec3::new(longitude.sin() * latitude.cos(), latitude.sin(), longitude.cos() * latitude.cos())
    }

    fn assert_is_panorama((texels, [width, height]): &Texels, tolerance: f64) {
        assert_eq!(texels.len(), width * height);
        for (i, found) in texels.iter().enumerate() {
            let [u, v] = [(i % width, width), (i / width, height)].map(|(n, side)| (n as f64 + 0.5) / *side as f64);
            for (found, expected) in found.iter().zip(light(direction(u, v))) {
                assert!(f64::from((found - expected).abs()) < tolerance, "{found} for {expected} at {u}, {v}");
            }
        }
    }

    #[test]
    fn texels_on_the_poles_and_the_seam_become_those_of_a_panorama() {
        let [width, height] = [65usize, 33];
        let place = |i: usize| [(i % width) as f64 / (width - 1) as f64, (i / width) as f64 / (height - 1) as f64];
        let texels: Vec<[f32; 3]> = (0..width * height).map(|i| light(direction(place(i)[0], place(i)[1]))).collect();
        let panorama = of_latitude_longitude(&texels, [width, height]);
        assert_eq!(panorama.1, [64, 32]);
        // The mean of the ends of a step h is off by h²/8 times the second derivative, which is 1, along each axis: h =
        // π/32 twice. Taken for a panorama without more, texels were off by h/2 = 0.05.
        assert_is_panorama(&panorama, 2.0 * (PI / 32.0).powi(2) / 8.0 + 1e-6);
        // One row or column is that everywhere.
        assert_eq!(of_latitude_longitude(&[[1.0; 3], [3.0; 3]], [2, 1]), (vec![[2.0; 3]], [1, 1]));
    }

    /// Directions of the texels by OpenEXR's documentation: x and y axes of each face.
    #[test]
    fn faces_of_a_cube_become_a_panorama() {
        const SIDE: usize = 33;
        let texel = |i: usize| {
            let (face, row, column) = (i / (SIDE * SIDE), i / SIDE % SIDE, i % SIDE);
            let [right, down] = [column, row].map(|n| 2.0 * n as f64 / (SIDE - 1) as f64 - 1.0);
            light(match face {
                0 => DVec3::new(1.0, -down, right),
                1 => DVec3::new(-1.0, -down, -right),
                2 => DVec3::new(right, 1.0, -down),
                3 => DVec3::new(right, -1.0, down),
                4 => DVec3::new(-right, -down, 1.0),
                _ => DVec3::new(right, -down, -1.0),
            })
        };
        let texels: Vec<[f32; 3]> = (0..6 * SIDE * SIDE).map(texel).collect();
        let panorama = of_cube(&texels, [SIDE, 6 * SIDE]).expect("a cube");
        assert_eq!(panorama.1, [4 * SIDE, 2 * SIDE]);
        // A step is 1/16 along a face at a distance of at least 1, where d/|d| bends by at most 1.
        assert_is_panorama(&panorama, 2.0 * (1.0f64 / 16.0).powi(2) / 8.0 * 2.0);
        let refused = of_cube(&texels, [2 * SIDE, 3 * SIDE]).expect_err("no squares");
        assert!(refused.key == "envmap" && refused.help.is_some(), "{refused}");
    }
}
