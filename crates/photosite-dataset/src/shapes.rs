//! Shapes of a scene's objects, which can be placed or are obstacles.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use photosite_capture::GROUND;
use photosite_core::{Invalid, Result};
use photosite_placement::Shape;
use photosite_transport::geometry::QuadricKind;
use photosite_transport::scene::description::{MeshDescription, ObjectDescription, SceneDescription};

/// Number of parts into which a circle of a quadric is cut.
const SIDES: u32 = 96;

/// Shape of a scene's object, in the world's frame; `None` for an object without surface.
pub(super) fn shape(scene: &SceneDescription, object: &ObjectDescription) -> Result<Option<Shape>, Invalid> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for instance in &scene.instances[object.instances.clone()] {
        for mesh in &scene.meshes[instance.meshes.clone()] {
            add(mesh, &instance.to_world, &mut positions, &mut triangles);
        }
    }
    if triangles.is_empty() {
        return Ok(None);
    }
    Shape::new(&positions, &triangles).map(Some)
}

/// All objects of a scene with their names, without its ground, which is known as a plane.
pub(super) fn shapes(scene: &SceneDescription) -> Result<Vec<(String, Arc<Shape>)>, Invalid> {
    let of = |object: &ObjectDescription| {
        let shape = shape(scene, object).transpose()?;
        Some(shape.map(|shape| (object.name.clone(), Arc::new(shape))))
    };
    let is_ground =
        |object: &ObjectDescription| object.name == GROUND && scene.surroundings.contains(&object.instances.start);
    scene.all_objects().iter().filter(|object| !is_ground(object)).filter_map(of).collect()
}

fn add(mesh: &MeshDescription, to_world: &DAffine3, positions: &mut Vec<DVec3>, triangles: &mut Vec<[u32; 3]>) {
    let own: (Vec<Vec3>, Vec<[u32; 3]>);
    let (points, faces) = match mesh.quadric {
        None => (&mesh.positions, &mesh.triangles),
        Some(kind) => {
            own = facets(kind);
            (&own.0, &own.1)
        }
    };
    let first = positions.len() as u32;
    positions.extend(points.iter().map(|p| to_world.transform_point3(p.as_dvec3())));
    triangles.extend(faces.iter().map(|face| face.map(|corner| corner + first)));
}

/// Triangles around a quadric; none of them cuts it.
fn facets(kind: QuadricKind) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    // Sides that touch the circle.
    let out = 1.0 / (TAU / (2 * SIDES) as f32).cos();
    let on_circle = |i: u32, z: f32, r: f32| {
        let (sin, cos) = (TAU * (i % SIDES) as f32 / SIDES as f32).sin_cos();
        Vec3::new(r * cos, r * sin, z)
    };
    match kind {
        QuadricKind::Disk => {
            let points = (0..SIDES).map(|i| on_circle(i, 0.0, out)).collect();
            (points, (2..SIDES).map(|i| [0, i - 1, i]).collect())
        }
        QuadricKind::Cylinder => {
            let points = (0..SIDES).flat_map(|i| [on_circle(i, 0.0, out), on_circle(i, 1.0, out)]).collect();
            let side = |i: u32| {
                let (a, b) = (2 * i, 2 * ((i + 1) % SIDES));
                [[a, b, b + 1], [a, b + 1, a + 1]]
            };
            (points, (0..SIDES).flat_map(side).collect())
        }
        QuadricKind::Sphere => {
            let rows = SIDES / 2;
            let ring = |row: u32| {
                let (sin, cos) = (TAU / 2.0 * row as f32 / rows as f32).sin_cos();
                (0..SIDES).map(move |i| on_circle(i, out * out * cos, out * out * sin))
            };
            let points = (0..=rows).flat_map(ring).collect();
            let quad = |(row, i): (u32, u32)| {
                let at = |row: u32, i: u32| row * SIDES + i % SIDES;
                let [a, b, c, d] = [at(row, i), at(row + 1, i), at(row + 1, i + 1), at(row, i + 1)];
                [[a, b, c], [a, c, d]]
            };
            (points, (0..rows).flat_map(|row| (0..SIDES).map(move |i| (row, i))).flat_map(quad).collect())
        }
    }
}
