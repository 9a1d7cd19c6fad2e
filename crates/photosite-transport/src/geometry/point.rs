//! The point of a surface that a ray meets: position with its rounding error, normals, tangent.

use glam::{DVec3, Vec2, Vec3, Vec3A};

use super::mesh::interpolate;
use super::quadric::QuadricPoint;
use super::{Accel, Facet, Geometry, Hit, Primitive, Ray, offset_origin};
use photosite_core::math::float::gamma;
use photosite_core::math::{Real, Vector};

/// A point on a surface, in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position, m.
    pub position: Vec3,
    /// Bound on the rounding error of the position, per axis, m.
    pub error: Vec3,
    /// Unit normal; the front of a triangle is where its corners run counter-clockwise.
    pub geometric_normal: Vec3,
    /// Unit shading normal, on the same side as the geometric one unless the file's normals say otherwise.
    pub shading_normal: Vec3,
    /// Tangent along +u, and the handedness of the bitangent; zero where the mesh has none.
    pub tangent: Vec3,
    /// Handedness, ±1: bitangent = handedness · normal × tangent.
    pub handedness: f32,
    /// Primitive that the point lies on.
    pub primitive: Primitive,
    /// Index of the primitive's instance in [`Accel`].
    pub instance: u32,
    /// Mesh of the primitive.
    pub mesh: u32,
    /// Material of the mesh.
    pub material: u32,
    /// Parameters of the point on the primitive, as a [`Hit`] tells it.
    pub parameters: [f32; 2],
    /// Time of the point, from 0 to 1.
    pub time: f32,
}

impl SurfacePoint {
    /// Surface point of a hit by a ray at `time`.
    #[inline]
    pub fn new(geometry: &Geometry, accel: &Accel, hit: &Hit, time: f32) -> Self {
        let triangle = match hit.primitive {
            Primitive::Triangle(triangle) => &geometry.triangles[triangle as usize],
            Primitive::Quadric(quadric) => return Self::on_quadric(geometry, quadric, hit, time),
        };
        let mesh = &geometry.meshes[triangle.mesh as usize];
        let [a, b, c] = geometry.corners_of(triangle, mesh, time);
        let (position, error, normal) = on_triangle([a, b, c].map(Vector::from), hit.uv);
        let (mut position, mut error, mut normal) = (Vec3::from(position), Vec3::from(error), Vec3::from(normal));
        let mut shading = geometry.corner_normals(triangle, mesh, time).map(|normals| interpolate(normals, hit.uv));
        let tangent = mesh.tangents_from.map(|from| {
            interpolate(triangle.corners.map(|corner| geometry.tangents[(corner - from) as usize]), hit.uv)
        });
        let mut along = tangent.map_or(Vec3::ZERO, |t| t.truncate());
        let mut handedness = tangent.map_or(1.0, |t| 1f32.copysign(t.w));

        if let Some(transform) = accel.instances()[hit.instance as usize].transform.at(time) {
            let (to_world, to_object) = (&transform.to_world, &transform.to_object);
            let magnitude = |m: &glam::Affine3A, v: Vec3| absolute(m) * Vec3A::from(v.abs());
            let local = position;
            position = to_world.transform_point3(local);
            // The error of the local point carried over, that of this transform, and that of taking the origin of the
            // next ray back into object space.
            let forward = Vec3::from(magnitude(to_world, local) + to_world.translation.abs()) * gamma(4);
            let back = Vec3::from(magnitude(to_object, position) + to_object.translation.abs()) * gamma(4);
            error = Vec3::from(magnitude(to_world, error + back)) + forward;
            // Normals go with the inverse transpose, so that what is outside stays outside in a mirrored instance.
            let inverse_transpose = to_object.matrix3.transpose();
            normal = inverse_transpose * normal;
            shading = shading.map(|shading| inverse_transpose * shading);
            along = to_world.transform_vector3(along);
            handedness *= 1f32.copysign(to_world.matrix3.determinant());
        }
        let geometric_normal = normal.normalize_or_zero();
        Self {
            position,
            error,
            geometric_normal,
            shading_normal: shading.and_then(Vec3::try_normalize).unwrap_or(geometric_normal),
            tangent: along,
            handedness,
            primitive: hit.primitive,
            instance: hit.instance,
            mesh: triangle.mesh,
            material: mesh.material,
            parameters: hit.uv,
            time,
        }
    }

    /// Quadrics are in world space: no transform follows.
    fn on_quadric(geometry: &Geometry, quadric: u32, hit: &Hit, time: f32) -> Self {
        let placed = &geometry.quadrics[quadric as usize];
        let mesh = &geometry.meshes[placed.mesh as usize];
        let QuadricPoint { position, error, normal, tangent } = placed.quadric.point(hit.uv);
        Self {
            position,
            error,
            geometric_normal: normal,
            shading_normal: normal,
            tangent: mesh.tangents_from.map_or(Vec3::ZERO, |_| tangent),
            handedness: 1.0,
            primitive: hit.primitive,
            instance: hit.instance,
            mesh: placed.mesh,
            material: mesh.material,
            parameters: hit.uv,
            time,
        }
    }

    /// Position of the point of a hit at a time, in the precision that equations for the time need: a smooth function
    /// of it, which rounding leaves at some 1e-16 of the coordinates.
    pub fn position_at(geometry: &Geometry, accel: &Accel, hit: &Hit, time: f64) -> DVec3 {
        match hit.primitive {
            Primitive::Triangle(triangle) => {
                let ([a, b, c], [b1, b2]) = (geometry.exact_corners_at(triangle, time), hit.uv.map(f64::from));
                let local = a * (1.0 - b1 - b2) + b * b1 + c * b2;
                accel.instances()[hit.instance as usize].transform.to_world(time).transform_point3(local)
            }
            // Quadrics stand still, in world space.
            Primitive::Quadric(quadric) => {
                geometry.quadrics[quadric as usize].quadric.point(hit.uv).position.as_dvec3()
            }
        }
    }

    /// Ray that leaves the point in a direction, at the time of the point.
    #[inline]
    pub fn spawn_ray(&self, direction: Vec3) -> Ray {
        let origin = offset_origin(self.position, self.error, self.geometric_normal, direction);
        Ray::new(origin, direction).at_time(self.time).leaving(Facet::of(self.instance, self.primitive))
    }

    /// UV coordinates of the point in a set.
    #[inline]
    pub fn uv(&self, geometry: &Geometry, set: usize) -> Vec2 {
        geometry.uv(self.primitive, self.parameters, set)
    }
}

/// The point of a triangle with these weights of the second and the third corner, the bound on its rounding error, and
/// a normal, not of unit length.
#[inline(always)]
pub(crate) fn on_triangle<R: Real>([a, b, c]: [Vector<R>; 3], [b1, b2]: [R; 2]) -> (Vector<R>, Vector<R>, Vector<R>) {
    // pbrt4 §6.8.5: seven roundings at most lie between the corners and their weighted sum.
    let of_first = (b1.broadcast(1.0) - b1 - b2).abs();
    let error = (a.abs() * of_first + b.abs() * b1 + c.abs() * b2) * b1.broadcast(gamma(7));
    (interpolate([a, b, c], [b1, b2]), error, (b - a).cross(c - a))
}

fn absolute(m: &glam::Affine3A) -> glam::Mat3A {
    glam::Mat3A::from_cols(m.matrix3.x_axis.abs(), m.matrix3.y_axis.abs(), m.matrix3.z_axis.abs())
}
