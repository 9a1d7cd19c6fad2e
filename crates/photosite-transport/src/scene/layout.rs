//! Where the meshes of a description go: into the world, with the shapes that they go through, or into a space of
//! their own with instances.

use std::ops::Range;

use glam::{DAffine3, Vec3};

use super::InstanceTable;
use super::description::{InstanceDescription, MeshDescription, ShapeDescription};
use crate::geometry::{
    Accel, Deformation, Geometry, Instance, InstanceTransform, MeshRange, Motion, PlacedQuadric, PrimitiveRange,
    Transform, Triangle,
};

/// A transform and those that follow, if any differs from it.
pub(super) fn moves_from(first: &DAffine3, later: &[DAffine3]) -> Option<Vec<DAffine3>> {
    let moves = later.iter().any(|pose| pose != first);
    moves.then(|| [first].into_iter().chain(later).copied().collect())
}

/// Lays meshes out: those placed once, and all emitters, in world space in one hierarchy; the others in hierarchies of
/// their own with an instance for each. What deforms, emitters that move included, has the world space of all times.
/// Returns the triangle ranges of emitters too.
pub(super) fn lay_out(
    meshes: Vec<MeshDescription>,
    instances: &[InstanceDescription],
    emits: impl Fn(usize) -> bool,
) -> (Geometry, Accel, InstanceTable, Vec<Range<u32>>) {
    let mut uses = vec![0usize; meshes.len()];
    for instance in instances {
        uses[instance.mesh] += 1;
    }
    let layout = |instance: &InstanceDescription| {
        let mesh = &meshes[instance.mesh];
        let moves = moves_from(&instance.to_world, &instance.later).is_some();
        if !mesh.later_shapes.is_empty() || moves && emits(mesh.material) {
            Layout::Deforming
        } else if !moves && (uses[instance.mesh] == 1 || emits(mesh.material)) {
            Layout::World
        } else {
            Layout::Instanced
        }
    };
    let laid_out = |wanted| instances.iter().enumerate().filter(move |(_, instance)| layout(instance) == wanted);
    let mut geometry = Geometry::default();
    let surfaces = vec![[u32::MAX; 2]; instances.len()];
    let mut table = InstanceTable { surfaces, ..InstanceTable::default() };
    let (mut ranges, mut placed) = (Vec::new(), Vec::new());
    let (mut emitters, mut light_count) = (Vec::new(), 0);
    let mut add = |geometry: &mut Geometry, table: &mut InstanceTable, index: usize| {
        let instance = &instances[index];
        table.of_mesh.push(index as u32);
        let mesh = &meshes[instance.mesh];
        let emitting = emits(mesh.material);
        let range = append(geometry, mesh, &instance.to_world, emitting.then_some(light_count));
        if emitting && !range.is_empty() {
            light_count += range.len() as u32;
            emitters.push(range.clone());
        }
        range
    };
    for (index, _) in laid_out(Layout::World) {
        add(&mut geometry, &mut table, index);
        // All of these have the first instance.
        table.surfaces[index] = [geometry.meshes.len() as u32 - 1, 0];
    }
    let in_world =
        PrimitiveRange { triangles: 0..geometry.triangles.len() as u32, quadrics: 0..geometry.quadrics.len() as u32 };
    if in_world != PrimitiveRange::default() {
        ranges.push(in_world);
        placed.push(Instance { blas: 0, transform: InstanceTransform::World });
        table.of_instance.push(None);
    }
    for (index, instance) in laid_out(Layout::Deforming) {
        let range = add(&mut geometry, &mut table, index);
        deform(&mut geometry, &meshes[instance.mesh], instance);
        table.surfaces[index] = [geometry.meshes.len() as u32 - 1, placed.len() as u32];
        placed.push(Instance { blas: ranges.len() as u32, transform: InstanceTransform::World });
        table.of_instance.push(None);
        ranges.push(range.into());
    }
    for (index, mesh) in meshes.iter().enumerate().filter(|&(index, _)| uses[index] > 0) {
        let mut blas = None;
        for (number, i) in laid_out(Layout::Instanced).filter(|(_, i)| i.mesh == index) {
            let blas = *blas.get_or_insert_with(|| {
                ranges.push(append(&mut geometry, mesh, &DAffine3::IDENTITY, None).into());
                (ranges.len() - 1) as u32
            });
            let transform = match moves_from(&i.to_world, &i.later) {
                Some(poses) => InstanceTransform::Moving(Box::new(Motion::new(&poses))),
                None => InstanceTransform::Still(Transform::new(&i.to_world)),
            };
            // No other is added to the geometry until all instances of this mesh are placed.
            table.surfaces[number] = [geometry.meshes.len() as u32 - 1, placed.len() as u32];
            placed.push(Instance { blas, transform });
            table.of_instance.push(Some(number as u32));
        }
    }
    drop(meshes);
    let accel = Accel::build(&geometry, &ranges, placed);
    (geometry, accel, table, emitters)
}

/// Where the triangles of an instance go.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Layout {
    /// Into the world, with others.
    World,
    /// Into the world in several shapes.
    Deforming,
    /// Into their own space, as an instance.
    Instanced,
}

/// Gives the mesh that was added last the shapes that it goes through in the world.
fn deform(geometry: &mut Geometry, mesh: &MeshDescription, instance: &InstanceDescription) {
    let first = ShapeDescription { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    let shapes: Vec<&ShapeDescription> = [&first].into_iter().chain(&mesh.later_shapes).collect();
    let poses: Vec<&DAffine3> = [&instance.to_world].into_iter().chain(&instance.later).collect();
    let corner_count = mesh.positions.len() as u32;
    let mut deformation = Deformation {
        first_corner: geometry.positions.len() as u32 - corner_count,
        corner_count,
        positions: Vec::new(),
        normals: Vec::new(),
    };
    // One of both may stand still.
    for i in 0..shapes.len().max(poses.len()) {
        let (shape, pose) = (shapes[i.min(shapes.len() - 1)], poses[i.min(poses.len() - 1)]);
        let normal_matrix = pose.matrix3.inverse().transpose();
        deformation.positions.extend(shape.positions.iter().map(|p| pose.transform_point3(p.as_dvec3()).as_vec3()));
        let normal = |n: &Vec3| (normal_matrix * n.as_dvec3()).normalize_or_zero().as_vec3();
        deformation.normals.extend(shape.normals.iter().map(normal));
    }
    let handle = geometry.deformations.len() as u32;
    geometry.deformations.push(deformation);
    if let Some(range) = geometry.meshes.last_mut() {
        range.deformation = Some(handle);
    }
}

/// Adds a mesh, transformed, and returns its triangles.
fn append(
    geometry: &mut Geometry,
    mesh: &MeshDescription,
    to_world: &DAffine3,
    first_light: Option<u32>,
) -> Range<u32> {
    let identity = *to_world == DAffine3::IDENTITY;
    let point = |p: &Vec3| if identity { *p } else { to_world.transform_point3(p.as_dvec3()).as_vec3() };
    let normal_matrix = to_world.matrix3.inverse().transpose();
    let normal = |n: &Vec3| if identity { *n } else { (normal_matrix * n.as_dvec3()).normalize_or_zero().as_vec3() };
    let base = geometry.positions.len() as u32;
    let first_triangle = geometry.triangles.len() as u32;
    let from = |present: bool, at: usize| present.then_some(base.wrapping_sub(at as u32));
    let range = MeshRange {
        material: mesh.material as u32,
        first_primitive: first_triangle + geometry.quadrics.len() as u32,
        first_triangle,
        triangle_count: mesh.triangles.len() as u32,
        first_light,
        normals_from: from(!mesh.normals.is_empty(), geometry.normals.len()),
        tangents_from: from(!mesh.tangents.is_empty(), geometry.tangents.len()),
        uvs_from: [0, 1].map(|set| from(mesh.uvs.len() > set, geometry.uvs[set].len())),
        colours_from: from(!mesh.colours.is_empty(), geometry.colours.len()),
        deformation: None,
        quadric: None,
    };
    let mesh_handle = geometry.meshes.len() as u32;
    if let Some(kind) = mesh.quadric {
        geometry.meshes.push(MeshRange { quadric: Some(geometry.quadrics.len() as u32), ..range });
        geometry.quadrics.push(PlacedQuadric::new(kind, to_world, mesh_handle));
        return first_triangle..first_triangle;
    }
    geometry.positions.extend(mesh.positions.iter().map(point));
    geometry.normals.extend(mesh.normals.iter().map(normal));
    let mirrored = to_world.matrix3.determinant() < 0.0;
    let handedness = if mirrored { -1.0 } else { 1.0 };
    geometry.tangents.extend(mesh.tangents.iter().map(|t| {
        let along = to_world.transform_vector3(t.truncate().as_dvec3()).normalize_or_zero().as_vec3();
        along.extend(t.w * handedness)
    }));
    for (all, own) in geometry.uvs.iter_mut().zip(&mesh.uvs) {
        all.extend_from_slice(own);
    }
    geometry.colours.extend_from_slice(&mesh.colours);
    geometry.triangles.extend(mesh.triangles.iter().map(|&[a, b, c]| {
        // A mirroring transform turns corners clockwise; the front stays the front.
        let corners = if mirrored { [a, c, b] } else { [a, b, c] };
        Triangle { corners: corners.map(|corner| base + corner), mesh: mesh_handle }
    }));
    geometry.meshes.push(range);
    first_triangle..geometry.triangles.len() as u32
}
