//! Layout of the meshes of a description: into the world, with the shapes that they go through, or into a space of
//! their own with instances.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::{Arc, Weak};

use glam::{DAffine3, Vec3};

use super::description::{InstanceDescription, MeshDescription, ShapeDescription};
use crate::geometry::{
    Accel, Deformation, Geometry, Instance, InstanceTransform, MeshRange, Motion, PlacedQuadric, PrimitiveRange,
    Transform, Triangle, segment,
};

/// A transform and those that follow, if any differs from it.
pub(super) fn moves_from(first: &DAffine3, later: &[DAffine3]) -> Option<Vec<DAffine3>> {
    let moves = later.iter().any(|pose| pose != first);
    moves.then(|| [first].into_iter().chain(later).copied().collect())
}

/// Meshes laid out: the tables of the geometry with hierarchies over them.
pub(super) struct LaidOut {
    pub(super) geometry: Arc<Geometry>,
    pub(super) accel: Accel,
    pub(super) instances: InstanceTable,
    pub(super) kept: Kept,
}

/// Record by which the next scene tells whether geometry and hierarchies are the same, and which it takes over then.
#[derive(Clone, Debug, Default)]
pub(super) struct Kept {
    /// Meshes of the description. They may be gone, but no other has their place in memory.
    meshes: Vec<Weak<MeshDescription>>,
    /// Meshes in world space and their places.
    in_world: Vec<(usize, DAffine3)>,
    /// Whether any mesh has several shapes, of which nothing is taken over.
    deforms: bool,
    /// Indices of the meshes in each hierarchy with a space of its own.
    groups: Vec<Vec<usize>>,
    /// Whether each mesh in world space emits light.
    shining: Vec<bool>,
    /// The primitives of each hierarchy.
    ranges: Vec<PrimitiveRange>,
    /// Primitives of each mesh that emits light.
    pub(super) emitters: Vec<PrimitiveRange>,
}

impl Kept {
    /// Number of meshes in each hierarchy with a space of its own.
    pub(super) fn group_sizes(&self) -> impl Iterator<Item = usize> {
        self.groups.iter().map(Vec::len)
    }

    /// Whether the scene was laid out from these very meshes.
    pub(super) fn has_meshes(&self, meshes: &[Arc<MeshDescription>]) -> bool {
        let pairs = || self.meshes.iter().zip(meshes);
        self.meshes.len() == meshes.len() && pairs().all(|(own, other)| std::ptr::eq(own.as_ptr(), Arc::as_ptr(other)))
    }

    /// Whether geometry and hierarchies are the same.
    fn is_same(&self, other: &Self) -> bool {
        let same_meshes = self.meshes.len() == other.meshes.len()
            && self.meshes.iter().zip(&other.meshes).all(|(own, other)| own.ptr_eq(other));
        same_meshes
            && !(self.deforms || other.deforms)
            && self.in_world == other.in_world
            && self.groups == other.groups
            && self.shining == other.shining
    }
}

/// A mesh of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Part {
    /// Index of the instance.
    pub(super) instance: u32,
    /// Number of the mesh among those of the instance.
    pub(super) number: u32,
}

/// Table of the description's instances, to which the surfaces belong.
#[derive(Clone, Debug, Default)]
pub(super) struct InstanceTable {
    /// Parts of instances that the first meshes of the geometry are, those in world space.
    pub(super) of_mesh: Vec<Part>,
    /// Instances of the description for those of the geometry: `None` for those in world space.
    pub(super) of_placed: Vec<Option<u32>>,
    /// Numbers, among the meshes of an instance, of the geometry's further meshes, which have spaces of their own.
    pub(super) numbers: Vec<u32>,
}

/// Parts of an earlier scene that another may share.
#[derive(Clone, Copy)]
pub(super) struct Earlier<'a> {
    pub(super) geometry: &'a Arc<Geometry>,
    pub(super) accel: &'a Accel,
    pub(super) kept: &'a Kept,
}

/// Lays meshes out: those placed once, and all emitters, in world space in one hierarchy; the others in hierarchies of
/// their own, one for all meshes of an instance, with an instance for each that shares them. What deforms, emitters
/// that move included, has the world space of all times. What an earlier scene has in common is shared with it.
pub(super) fn lay_out(
    meshes: Vec<Arc<MeshDescription>>,
    instances: &[InstanceDescription],
    emits: impl Fn(usize) -> bool,
    earlier: Option<Earlier<'_>>,
) -> LaidOut {
    let parts = Parts::of(&meshes, instances, &emits);
    let kept = Kept {
        meshes: meshes.iter().map(Arc::downgrade).collect(),
        in_world: parts
            .in_world
            .iter()
            .map(|&(part, mesh)| (mesh, instances[part.instance as usize].to_world))
            .collect(),
        deforms: !parts.deforming.is_empty(),
        groups: parts.groups.keys().cloned().collect(),
        shining: parts.in_world.iter().map(|&(_, mesh)| emits(meshes[mesh].material)).collect(),
        ..Kept::default()
    };
    let earlier = earlier.filter(|earlier| earlier.kept.is_same(&kept));
    let (geometry, kept) = match earlier {
        Some(Earlier { geometry, kept, .. }) => (Arc::clone(geometry), kept.clone()),
        None => {
            let (geometry, ranges, emitters) = tables(&meshes, instances, &parts, &emits);
            (Arc::new(geometry), Kept { ranges, emitters, ..kept })
        }
    };
    // The hierarchies take much of the memory, so this is free before they are built.
    drop(meshes);
    let (placed, table) = place(instances, parts, &kept);
    let accel = match earlier {
        Some(earlier) => earlier.accel.with_instances(&geometry, &kept.ranges, placed),
        None => Accel::build(&geometry, &kept.ranges, placed),
    };
    LaidOut { geometry, accel, instances: table, kept }
}

/// Destinations of the meshes of all instances.
struct Parts {
    /// Parts that go into the world, with others, and the indices of their meshes.
    in_world: Vec<(Part, usize)>,
    /// Parts that go into the world in several shapes.
    deforming: Vec<(Part, usize)>,
    /// Groups that go into spaces of their own: the meshes that have one together, and the instances that share it.
    groups: BTreeMap<Vec<usize>, Vec<u32>>,
}

impl Parts {
    fn of(meshes: &[Arc<MeshDescription>], instances: &[InstanceDescription], emits: impl Fn(usize) -> bool) -> Self {
        let mut uses: HashMap<&Range<usize>, usize> = HashMap::new();
        for instance in instances {
            *uses.entry(&instance.meshes).or_default() += 1;
        }
        let mut parts = Self { in_world: Vec::new(), deforming: Vec::new(), groups: BTreeMap::new() };
        for (index, instance) in (0..).zip(instances) {
            let moves = moves_from(&instance.to_world, &instance.later).is_some();
            let is_alone = uses[&instance.meshes] == 1 && !instance.is_movable;
            let mut group = Vec::new();
            for (number, mesh) in (0..).zip(instance.meshes.clone()) {
                let part = Part { instance: index, number };
                let shines = emits(meshes[mesh].material);
                if !meshes[mesh].later_shapes.is_empty() || moves && shines {
                    parts.deforming.push((part, mesh));
                } else if !moves && (is_alone || shines) {
                    parts.in_world.push((part, mesh));
                } else {
                    group.push(mesh);
                }
            }
            if !group.is_empty() {
                parts.groups.entry(group).or_default().push(index);
            }
        }
        parts
    }
}

/// The tables of the geometry, the primitives of each hierarchy, and those of each mesh that shines.
fn tables(
    meshes: &[Arc<MeshDescription>],
    instances: &[InstanceDescription],
    parts: &Parts,
    emits: impl Fn(usize) -> bool,
) -> (Geometry, Vec<PrimitiveRange>, Vec<PrimitiveRange>) {
    let mut geometry = Geometry::default();
    let (mut emitters, mut light_count) = (Vec::new(), 0);
    let mut add = |geometry: &mut Geometry, &(part, mesh): &(Part, usize)| {
        let mesh = &*meshes[mesh];
        let emitting = emits(mesh.material);
        let to_world = &instances[part.instance as usize].to_world;
        let range = append(geometry, mesh, to_world, emitting.then_some(light_count));
        if emitting && range.len() > 0 {
            light_count += range.len() as u32;
            emitters.push(range.clone());
        }
        range
    };
    let all = |geometry: &Geometry| [geometry.triangles.len() as u32, geometry.quadrics.len() as u32];
    let since = |geometry: &Geometry, [triangles, quadrics]: [u32; 2]| {
        let [last_triangle, last_quadric] = all(geometry);
        PrimitiveRange { triangles: triangles..last_triangle, quadrics: quadrics..last_quadric }
    };
    let mut ranges = Vec::new();
    for part in &parts.in_world {
        add(&mut geometry, part);
    }
    let in_world = since(&geometry, [0, 0]);
    if in_world != PrimitiveRange::default() {
        ranges.push(in_world);
    }
    for part in &parts.deforming {
        let range = add(&mut geometry, part);
        deform(&mut geometry, &meshes[part.1], &instances[part.0.instance as usize]);
        ranges.push(range);
    }
    for group in parts.groups.keys() {
        let before = all(&geometry);
        for &mesh in group {
            append(&mut geometry, &meshes[mesh], &DAffine3::IDENTITY, None);
        }
        ranges.push(since(&geometry, before));
    }
    (geometry, ranges, emitters)
}

/// The instances of the hierarchies, and whose surfaces they have.
fn place(instances: &[InstanceDescription], parts: Parts, kept: &Kept) -> (Vec<Instance>, InstanceTable) {
    let Parts { in_world, deforming, groups } = parts;
    let count = usize::from(!in_world.is_empty()) + deforming.len() + groups.values().map(Vec::len).sum::<usize>();
    let mut placed = Vec::with_capacity(count);
    let mut table = InstanceTable { of_placed: Vec::with_capacity(count), ..InstanceTable::default() };
    let has_world = kept.ranges.len() > deforming.len() + groups.len();
    let not_instanced = usize::from(has_world) + deforming.len();
    for blas in 0..not_instanced as u32 {
        placed.push(Instance { blas, transform: InstanceTransform::World });
        table.of_placed.push(None);
    }
    table.of_mesh = in_world.iter().chain(&deforming).map(|&(part, _)| part).collect();
    for (blas, (group, members)) in (not_instanced as u32..).zip(groups) {
        for &index in &members {
            let instance = &instances[index as usize];
            let transform = match moves_from(&instance.to_world, &instance.later) {
                Some(poses) => InstanceTransform::Moving(Box::new(Motion::new(&poses))),
                None => InstanceTransform::Still(Transform::new(&instance.to_world)),
            };
            placed.push(Instance { blas, transform });
            table.of_placed.push(Some(index));
        }
        let first = instances[members[0] as usize].meshes.start;
        table.numbers.extend(group.iter().map(|mesh| (mesh - first) as u32));
    }
    (placed, table)
}

/// Gives the mesh that was added last the shapes that it goes through in the world.
fn deform(geometry: &mut Geometry, mesh: &MeshDescription, instance: &InstanceDescription) {
    let first = ShapeDescription { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    let shapes: Vec<&ShapeDescription> = [&first].into_iter().chain(&mesh.later_shapes).collect();
    let corner_count = mesh.positions.len() as u32;
    let mut deformation = Deformation {
        first_corner: geometry.positions.len() as u32 - corner_count,
        corner_count,
        positions: Vec::new(),
        normals: Vec::new(),
    };
    // One of both may stand still, or have fewer times than the other.
    let parts = mesh.later_shapes.len().max(instance.later.len());
    for i in 0..=parts {
        let time = i as f32 / parts.max(1) as f32;
        let (shape, part) = segment(time, mesh.later_shapes.len().max(1));
        let [from, to] = [shape, shape + 1].map(|shape| shapes[shape.min(shapes.len() - 1)]);
        let pose = instance.at(f64::from(time));
        let normal_matrix = pose.matrix3.inverse().transpose();
        let position = |(a, b): (&Vec3, &Vec3)| pose.transform_point3(a.lerp(*b, part).as_dvec3()).as_vec3();
        deformation.positions.extend(from.positions.iter().zip(&to.positions).map(position));
        let normal =
            |(a, b): (&Vec3, &Vec3)| (normal_matrix * a.lerp(*b, part).as_dvec3()).normalize_or_zero().as_vec3();
        deformation.normals.extend(from.normals.iter().zip(&to.normals).map(normal));
    }
    let handle = geometry.deformations.len() as u32;
    geometry.deformations.push(deformation);
    if let Some(range) = geometry.meshes.last_mut() {
        range.deformation = Some(handle);
    }
}

/// Adds a mesh, transformed, and returns its primitives.
fn append(
    geometry: &mut Geometry,
    mesh: &MeshDescription,
    to_world: &DAffine3,
    first_light: Option<u32>,
) -> PrimitiveRange {
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
        let quadric = geometry.quadrics.len() as u32;
        geometry.meshes.push(MeshRange { quadric: Some(quadric), ..range });
        geometry.quadrics.push(PlacedQuadric::new(kind, to_world, mesh_handle));
        return PrimitiveRange { triangles: first_triangle..first_triangle, quadrics: quadric..quadric + 1 };
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
    PrimitiveRange::from(first_triangle..geometry.triangles.len() as u32)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::description::{
        Colour, Diffuse, EmissionDescription, MaterialDescription, MaterialModel, SceneDescription, TexturedColour,
    };
    use super::super::{Scene, build, build_after};
    use super::*;
    use crate::geometry::Ray;
    use photosite_core::math::hash::{hash64, unit_f32};
    use photosite_core::spectrum::Spectrum;

    fn triangle(material: usize, at: f32) -> Arc<MeshDescription> {
        Arc::new(MeshDescription {
            material,
            positions: [[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, at)).to_vec(),
            triangles: vec![[0, 1, 2]],
            ..MeshDescription::default()
        })
    }

    /// A wall in the world, two triangles that are one instance and can move, another instance of them, and one that
    /// is alone.
    fn description(meshes: &[Arc<MeshDescription>], moved: f64, shines: bool) -> SceneDescription {
        let reflectance = TexturedColour::plain(Colour::Rgb([0.5; 3]));
        let model = MaterialModel::Diffuse(Diffuse { reflectance });
        let emission =
            shines.then_some(EmissionDescription { colour: Colour::Rgb([1.0; 3]), level: Some(1.0), texture: None });
        let at = |x: f64| DAffine3::from_translation(DVec3::new(x, moved, 0.0));
        let movable = |meshes: Range<usize>, x: f64| InstanceDescription {
            meshes,
            is_movable: true,
            ..InstanceDescription::of_mesh("movable", 0, at(x))
        };
        SceneDescription {
            materials: vec![
                MaterialDescription::new("wall", model.clone()),
                MaterialDescription { emission, ..MaterialDescription::new("other", model) },
            ],
            meshes: meshes.to_vec(),
            instances: vec![
                InstanceDescription::of_mesh("wall", 0, DAffine3::IDENTITY),
                movable(1..3, 0.5),
                movable(1..3, -1.5),
                movable(3..4, 2.0),
            ],
            ..SceneDescription::default()
        }
    }

    fn built(description: SceneDescription, earlier: Option<&Scene>) -> Scene {
        build_after(description, &Spectrum::constant(1.0), earlier)
    }

    /// Asserts that the same rays find the same surfaces in both scenes.
    fn assert_same_hits(found: &Scene, expected: &Scene) {
        let mut hits = 0;
        for i in 0..2000 {
            let random = |dimension| 6.0 * unit_f32(hash64(i, dimension) as u32) - 3.0;
            let ray = Ray::new(Vec3::new(random(0), random(1), 5.0), Vec3::new(0.1 * random(2), 0.1 * random(3), -1.0));
            let facts = |scene: &Scene| {
                scene.closest(&ray).map(|hit| (hit.t.to_bits(), scene.object(&hit), scene.point(&hit, 0.0).material))
            };
            assert_eq!(facts(found), facts(expected), "ray {i}");
            hits += usize::from(facts(found).is_some());
        }
        assert!(hits > 200, "{hits}");
    }

    #[test]
    fn a_scene_that_moved_shares_geometry_and_is_as_if_it_were_new() {
        let meshes = [triangle(0, -2.0), triangle(0, 0.0), triangle(1, -0.5), triangle(1, 0.5)];
        let first = build(description(&meshes, 0.0, false), &Spectrum::constant(1.0));
        let next = built(description(&meshes, 0.7, false), Some(&first));
        assert!(Arc::ptr_eq(&first.geometry, &next.geometry));
        assert_same_hits(&next, &built(description(&meshes, 0.7, false), None));
        // A point of the first scene has gone along in the next.
        let ray = Ray::new(Vec3::new(0.5, 0.1, 5.0), Vec3::NEG_Z);
        let hit = first.closest(&ray).expect("an instance in front of the wall");
        let moved = next.point(&first.hit_in(&hit, &next).expect("it is there"), 0.0);
        let way = moved.position - first.point(&hit, 0.0).position;
        assert!((way - Vec3::Y * 0.7).length() < 1e-6, "{way}");
    }

    #[test]
    fn shapes_and_poses_have_their_own_times() {
        for (shapes, poses) in [(2, 4), (4, 2), (2, 2), (0, 2), (2, 0)] {
            assert_carried(shapes, poses);
        }
    }

    fn assert_carried(shapes: usize, poses: usize) {
        // A shape that grows upwards as time², and a way to the right as time², both straight from time to time.
        let up = |time: f64| if shapes == 0 { 0.0 } else { 2.0 * time * time };
        let right = |time: f64| if poses == 0 { 0.0 } else { 3.0 * time * time };
        let straight = |time: f64, parts: usize, at: &dyn Fn(f64) -> f64| {
            let (from, count) = ((time * parts as f64).floor(), parts as f64);
            at(from / count) + (at((from + 1.0) / count) - at(from / count)) * (time * count - from)
        };
        let mut mesh = MeshDescription { positions: vec![Vec3::ZERO], ..MeshDescription::default() };
        let shape = |i: usize| ShapeDescription {
            positions: vec![Vec3::Y * up(i as f64 / shapes as f64) as f32],
            normals: Vec::new(),
        };
        mesh.later_shapes = (1..=shapes).map(shape).collect();
        let pose = |i: usize| DAffine3::from_translation(DVec3::X * right(i as f64 / poses as f64));
        let mut instance = InstanceDescription::of_mesh("moving", 0, DAffine3::IDENTITY);
        instance.later = (1..=poses).map(pose).collect();
        let mut geometry = Geometry::default();
        append(&mut geometry, &mesh, &instance.to_world, None);
        deform(&mut geometry, &mesh, &instance);
        let parts = shapes.max(poses);
        let positions = &geometry.deformations[0].positions;
        assert_eq!(positions.len(), parts + 1);
        for (i, found) in positions.iter().enumerate() {
            let time = i as f64 / parts as f64;
            let x = if poses == 0 { 0.0 } else { straight(time, poses, &right) };
            let y = if shapes == 0 { 0.0 } else { straight(time, shapes, &up) };
            assert!(
                found.as_dvec3().distance(DVec3::new(x, y, 0.0)) < 1e-6,
                "{shapes}, {poses}, {time}: {found} for {x}, {y}"
            );
        }
    }

    #[test]
    fn what_differs_is_built_anew() {
        let meshes = [triangle(0, -2.0), triangle(0, 0.0), triangle(1, -0.5), triangle(1, 0.5)];
        let first = build(description(&meshes, 0.0, false), &Spectrum::constant(1.0));
        let others = [triangle(0, -2.0), triangle(0, 0.0), triangle(1, -0.5), triangle(1, 0.4)];
        let mut wall_moved = description(&meshes, 0.0, false);
        wall_moved.instances[0].to_world = DAffine3::from_translation(DVec3::X);
        let mut one_more = description(&meshes, 0.0, false);
        one_more.instances.push(InstanceDescription::of_mesh("more", 0, DAffine3::from_translation(DVec3::Y)));
        for (what, changed) in [
            ("other meshes", description(&others, 0.0, false)),
            ("a lamp", description(&meshes, 0.0, true)),
            ("the wall", wall_moved),
            ("the wall twice", one_more),
        ] {
            let expected = built(changed.clone(), None);
            let found = built(changed, Some(&first));
            assert!(!Arc::ptr_eq(&first.geometry, &found.geometry), "{what}");
            assert_same_hits(&found, &expected);
        }
    }
}
