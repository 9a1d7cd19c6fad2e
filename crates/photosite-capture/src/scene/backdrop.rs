//! Backdrop, `scene.backdrop`: a floor that curves up into a wall, as those of photographers' studios do.
//!
//! Its profile, seen from the side, is a line, a quarter of a circle and a line, which meet without a bend; it is as
//! wide everywhere. Shading normals make the curve smooth.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec2};

use super::super::tables::BackdropTable;
use super::floor_surface::{Subject, Surface, length};
use photosite_core::Invalid;

/// Pieces of the curve: a chord lies within 1/13 000 of its radius.
const PIECES: u32 = 64;
/// Lengths that nothing states, in radii of the subject.
const DISTANCE: f64 = 4.0;
const WIDTH: f64 = 40.0;
const WALL_HEIGHT: f64 = 10.0;
/// Length of the floor to the front, in widths: reflections in polished subjects shall not show its rim.
const FRONT: f64 = 5.0;

/// The backdrop of a subject, its wall towards −Z.
pub(crate) fn surface(subject: &Subject, table: &BackdropTable) -> Result<Surface, Invalid> {
    let radius = subject.sphere.radius;
    let distance = length("distance_m", table.distance_m, DISTANCE * radius)?;
    let curve = length("curve_radius_m", table.curve_radius_m, distance / 2.0)?;
    let half_width = length("width_m", table.width_m, WIDTH * radius)? / 2.0;
    let wall = length("wall_height_m", table.wall_height_m, (WALL_HEIGHT * radius).max(curve))?;
    if curve > distance {
        let message = format!("must be at most the distance of the wall, {distance} m, got {curve}");
        return Err(Invalid::new("curve_radius_m", message).help("make it smaller, or distance_m larger"));
    }
    if wall < curve {
        let message = format!("must be at least the radius of the curve, {curve} m, got {wall}");
        return Err(Invalid::new("wall_height_m", message).help("make it larger, or curve_radius_m smaller"));
    }
    let profile = profile(2.0 * FRONT * half_width, distance, curve, wall);
    let mut made = Surface { positions: vec![], normals: vec![], uvs: vec![], triangles: vec![] };
    let mut along = 0.0;
    for (i, point) in profile.iter().enumerate() {
        if i > 0 {
            along += point.place.distance(profile[i - 1].place);
            let right = 2 * i as u32;
            made.triangles.extend([[right - 2, right - 1, right + 1], [right - 2, right + 1, right]]);
        }
        for x in [-half_width, half_width] {
            made.positions.push(DVec3 { x, ..point.place });
            made.normals.push(point.normal.as_vec3());
            made.uvs.push(Vec2::new(x as f32, along as f32));
        }
    }
    Ok(made)
}

/// A point of the profile, at x = 0.
struct Point {
    place: DVec3,
    normal: DVec3,
}

/// Profile from the front of the floor to the top of the wall.
fn profile(front: f64, distance: f64, curve: f64, wall: f64) -> Vec<Point> {
    let on_curve = |i: u32| {
        let (sin, cos) = (f64::from(i) / f64::from(PIECES) * FRAC_PI_2).sin_cos();
        let place = DVec3::new(0.0, curve * (1.0 - cos), -(distance - curve) - curve * sin);
        Point { place, normal: DVec3::new(0.0, cos, sin) }
    };
    let front = Point { place: DVec3::new(0.0, 0.0, front), normal: DVec3::Y };
    let top = Point { place: DVec3::new(0.0, wall, -distance), normal: DVec3::Z };
    [front].into_iter().chain((0..=PIECES).map(on_curve)).chain([top]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::framing::Sphere;

    #[test]
    fn it_has_the_length_of_its_profile_and_faces_the_subject_without_a_bend() {
        let subject = Subject { sphere: Sphere { centre: DVec3::ZERO, radius: 0.5 }, lowest_m: 0.0 };
        let tables = [
            (BackdropTable::default(), [2.0, 1.0, 20.0, 5.0]),
            (
                BackdropTable {
                    distance_m: Some(3.0),
                    curve_radius_m: Some(0.25),
                    width_m: Some(4.0),
                    wall_height_m: Some(2.0),
                    ..BackdropTable::default()
                },
                [3.0, 0.25, 4.0, 2.0],
            ),
        ];
        for (table, [distance, curve, width, wall]) in tables {
            let made = surface(&subject, &table).expect("a backdrop");
            let mut area = 0.0;
            for corners in &made.triangles {
                let [a, b, c] = corners.map(|corner| made.positions[corner as usize]);
                let face = (b - a).cross(c - a) / 2.0;
                area += face.length();
                for corner in corners.map(|corner| made.normals[corner as usize].as_dvec3()) {
                    // Half a piece of the curve, 0.7°, lies between the normal of a chord and those of its ends.
                    assert!(face.normalize_or(corner).dot(corner) > 0.9999, "{face} {corner}");
                }
            }
            let expected = width * (5.0 * width + distance - curve + FRAC_PI_2 * curve + wall - curve);
            assert!((area / expected - 1.0).abs() < 1e-4, "{area} m², not {expected} m²");
        }
    }
}
