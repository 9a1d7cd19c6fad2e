//! Ground, `scene.ground`: a level square under everything, out to the horizon.
//!
//! It is made of triangles that get larger with the distance from the middle. The digits of single precision are shared
//! by all of a triangle, or of a disk: on a single one that reaches to the horizon, a shadow would begin millimetres
//! beside the foot that throws it.

use glam::{DVec3, Vec2};

use super::floor_surface::{Subject, Surface, length};
use photosite_core::Invalid;

/// Half the sides of the square in the middle, which shadows of the subject mostly fall on, in radii of the subject.
const MIDDLE: f64 = 4.0;
/// Ratio of each square's size to that of the one inside it.
const GROWTH: f64 = 4.0;
/// Half the sides of the whole ground, in radii of the subject, where nothing states its size.
const REACH: f64 = 1e6;

/// The ground under a subject, with sides of the stated length.
pub(crate) fn surface(subject: &Subject, size_m: Option<f64>) -> Result<Surface, Invalid> {
    let radius = subject.sphere.radius;
    let reach = length("size_m", size_m, 2.0 * REACH * radius)? / 2.0;
    let mut halves = vec![(MIDDLE * radius).min(reach)];
    let mut last = halves[0];
    while last < reach {
        last = (last * GROWTH).min(reach);
        halves.push(last);
    }
    // Counter-clockwise seen from above.
    let corners = |half: f64| [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| [x * half, z * half]);
    let places: Vec<[f64; 2]> = halves.iter().flat_map(|&half| corners(half)).collect();
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    for inner in (0..4 * (halves.len() as u32 - 1)).step_by(4) {
        for (side, next) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let [a, b, c, d] = [inner + side, inner + 4 + side, inner + 4 + next, inner + next];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Ok(Surface {
        positions: places.iter().map(|&[x, z]| DVec3::new(x, 0.0, z)).collect(),
        normals: Vec::new(),
        uvs: places.iter().map(|&[x, z]| Vec2::new(x as f32, -z as f32)).collect(),
        triangles,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::framing::Sphere;

    #[test]
    fn it_faces_up_and_covers_its_square_once_whatever_its_size() {
        for (radius, size) in [(1.0, None), (0.01, Some(3.0)), (1.0, Some(1.0)), (1.0, Some(8.0)), (2e-9, None)] {
            let subject = Subject { sphere: Sphere { centre: DVec3::ZERO, radius }, lowest_m: 0.0 };
            let Surface { positions, triangles, .. } = surface(&subject, size).expect("a size");
            let sides = size.unwrap_or(2e6 * radius);
            let mut area = 0.0;
            for corners in triangles {
                let [a, b, c] = corners.map(|corner| positions[corner as usize]);
                let normal = (b - a).cross(c - a) / 2.0;
                assert!(normal.y > 0.0 && normal.x == 0.0 && normal.z == 0.0, "{normal}");
                area += normal.y;
            }
            assert!((area / (sides * sides) - 1.0).abs() < 1e-12, "{area} m² of {sides} m");
            let farthest = positions.iter().fold(0.0, |far: f64, p| far.max(p.x.abs()).max(p.z.abs()));
            assert!((2.0 * farthest / sides - 1.0).abs() < 1e-12);
        }
    }
}
