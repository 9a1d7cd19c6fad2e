//! Rays, triangle meshes, spheres, disks, cylinders, and where they meet.
//!
//! In: meshes and instances in metres. Out: the nearest [`Hit`] of a ray, or whether anything is in its way, and the
//! [`SurfacePoint`] of a hit. What a surface does to light is left to [`bsdf`](crate::bsdf) and
//! [`scene`](crate::scene).
//!
//! Intersection with triangles is watertight: a ray through a closed mesh cannot slip between two triangles that share
//! an edge, at any scale. Rays leave a surface from a point moved by the bound on its own rounding error, so no epsilon
//! depends on the size of the scene.

mod accel;
#[cfg(test)]
pub(crate) mod accel_tests;
mod bounds;
mod chunks;
mod collapse;
#[cfg(test)]
mod exact_tests;
mod linear_scan;
mod mesh;
mod motion;
mod near_hit;
mod point;
mod primitive;
mod quadric;
mod ray;
mod spline;
mod timed_pose;
mod trajectory;
mod traversal_stack;
mod triangle_block;
mod wide_bvh;
mod wide_node;
mod word;

pub use accel::packed;
pub use accel::{Accel, AcceptAll, HitFilter, Instance, InstanceTransform};
pub use mesh::{Deformation, Geometry, MeshRange, Triangle};
pub(crate) use mesh::{interpolate, segment};
pub use motion::{Motion, Transform};
pub use point::SurfacePoint;
pub(crate) use point::on_triangle;
pub use primitive::{Facet, Primitive, PrimitiveRange};
pub(crate) use quadric::QuadricPoint;
pub use quadric::{Cylinder, Disk, PlacedQuadric, Quadric, QuadricKind, Sphere};
pub(crate) use ray::offset;
pub use ray::{Hit, Ray, offset_origin};
pub use spline::Spline;
pub use timed_pose::TimedPose;
pub use trajectory::{Interpolation, Trajectory};
pub(crate) use word::{NONE, Word, word};
