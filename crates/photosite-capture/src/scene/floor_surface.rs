//! Floors as triangles, and the subjects that they are laid under.

use glam::{DVec3, Vec2, Vec3};

use super::super::camera::framing::{Sphere, bounding_sphere, to_power};
use super::geometry::FARTHEST_M;
use super::quadrics::SMALLEST_SIZE_M;
use photosite_core::Invalid;
use photosite_transport::scene::description::{MeshDescription, SceneDescription};

/// Subject: the geometry that is surrounded.
pub(crate) struct Subject {
    pub(crate) sphere: Sphere,
    /// Height of the subject's lowest point, m.
    pub(crate) lowest_m: f64,
}

impl Subject {
    /// Subject of a scene: all that is in it; a ball of 1 m on the origin where there is nothing.
    pub(crate) fn of(scene: &SceneDescription) -> Self {
        let Some(sphere) = bounding_sphere(scene) else {
            return Self { sphere: Sphere { centre: DVec3::Y, radius: 1.0 }, lowest_m: 0.0 };
        };
        let lowest_m = scene.subject_points().fold(f64::INFINITY, |lowest, point| lowest.min(point.y));
        // Below that nothing is left of a triangle in single precision.
        Self { sphere: Sphere { radius: sphere.radius.max(1e-9), ..sphere }, lowest_m }
    }

    /// The height of a floor that no face of the subject lies in: from 1/10000 to 2/10000 of the radius below it, with
    /// as few digits as that takes.
    pub(crate) fn floor_m(&self) -> f64 {
        let power = (self.sphere.radius * 1e-4).log10().floor() as i32;
        // Half a step lower, so that rounding leaves it below.
        to_power(self.lowest_m - self.sphere.radius * 1e-4 - 0.5 * 10f64.powi(power), power)
    }
}

/// Corners and triangles in the space of a mesh, whose origin lies under the middle of the subject, at the height of
/// the floor.
pub(crate) struct Surface {
    pub(crate) positions: Vec<DVec3>,
    /// Normals, one for each corner, or none.
    pub(crate) normals: Vec<Vec3>,
    /// UV coordinates: metres along the surface.
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Mesh of the surface, of that material.
    pub(crate) fn into_mesh(self, name: String, material: usize) -> MeshDescription {
        let Self { positions, normals, uvs, triangles } = self;
        let positions: Vec<Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
        // Of what is much smaller than the rest, rounding may leave nothing.
        let has_area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| positions[corner as usize]);
            (b - a).cross(c - a).length_squared() > 0.0
        };
        let triangles = triangles.into_iter().filter(has_area).collect();
        MeshDescription { name, material, positions, normals, uvs: vec![uvs], triangles, ..MeshDescription::default() }
    }
}

/// A stated length, which must be above 0, or its default.
pub(crate) fn length(key: &str, stated: Option<f64>, default: f64) -> Result<f64, Invalid> {
    match stated {
        None => Ok(default.min(FARTHEST_M)),
        Some(length) if (SMALLEST_SIZE_M..=FARTHEST_M).contains(&length) => Ok(length),
        Some(length) => {
            let message = format!("must lie between {SMALLEST_SIZE_M:e} and {FARTHEST_M:e} m, got {length}");
            Err(Invalid::new(key, message).help(format!("for example {key} = 10.0")))
        }
    }
}
