//! The acceleration structure of a scene: one hierarchy of primitives for all geometry that stands where its file puts
//! it, one for each mesh that is instanced, and one over their instances.
//!
//! This is the only file that knows `obvhs`, which builds the binary hierarchies; traversal is that of [`wide_bvh`]
//! over their collapsed form, since obvhs's own is neither watertight nor scale-free.
//!
//! [`wide_bvh`]: super::wide_bvh

mod filter;
mod interleaved;
mod leaf;
pub mod packed;
mod packet;
pub(super) mod query;
mod single;
mod strategy;

use std::sync::Arc;

use glam::{DAffine3, DMat3, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, SortPrecision};
use rayon::prelude::*;

use super::bounds::{Bounds, union};
use super::chunks::Chunks;
use super::collapse::{BinaryTree, LEAF_SIZE};
use super::linear_scan::LinearScan;
use super::motion::{Motion, Transform};
use super::triangle_block::TriangleBlock;
use super::wide_bvh::WideBvh;
use super::{Geometry, PrimitiveRange, Quadric};
use crate::tuning::BLOCKS_BEYOND_CACHES;
use leaf::Leaf;
use photosite_core::math::float::gamma;
use photosite_simd::{compact, prefer_huge_pages};

pub use filter::{AcceptAll, HitFilter};

/// Instance of primitives somewhere in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index of the bottom-level hierarchy of the primitives.
    pub blas: u32,
    /// Place of the instance in the world.
    pub transform: InstanceTransform,
}

/// Place of the primitives of an instance.
#[derive(Clone, Debug)]
pub enum InstanceTransform {
    /// World space, in which the corners are given.
    World,
    /// Fixed transform.
    Still(Transform),
    /// Moving transform.
    Moving(Box<Motion>),
}

impl InstanceTransform {
    /// The transform at a time from 0 to 1; `None` in world space.
    #[inline]
    pub fn at(&self, time: f32) -> Option<Transform> {
        match self {
            Self::World => None,
            Self::Still(transform) => Some(*transform),
            Self::Moving(motion) => Some(motion.at(time)),
        }
    }

    /// Object space → world at a time from 0 to 1, without the rounding of the time to single precision.
    pub(super) fn to_world(&self, time: f64) -> DAffine3 {
        match self {
            Self::World => DAffine3::IDENTITY,
            Self::Still(Transform { to_world, .. }) => DAffine3 {
                matrix3: DMat3::from_cols_array(&to_world.matrix3.to_cols_array().map(f64::from)),
                translation: to_world.translation.as_dvec3(),
            },
            Self::Moving(motion) => motion.to_world(time),
        }
    }
}

/// Acceleration structure of a scene: hierarchies over all primitives.
#[derive(Clone, Debug)]
pub struct Accel {
    /// Shared by the scenes in which the same geometry stands elsewhere.
    blas: Arc<[Blas]>,
    instances: Vec<Instance>,
    /// Hierarchy over the instances; `None` where there is none, or a single one of rigid primitives in world space.
    top: Option<Tlas>,
    /// Table of all primitives, where they are so few that several rays together need no hierarchy.
    pub(super) linear_scan: Option<LinearScan>,
    /// Whether rays often wait for the memory.
    pub(super) exceeds_caches: bool,
}

/// Bottom-level acceleration structure: the primitives of an instance, in object space.
#[derive(Clone, Debug)]
enum Blas {
    /// Primitives that keep their shapes.
    Rigid(PrimitiveBvh<1>),
    /// Triangles that change their shapes: one hierarchy for each part of the time, in which corners move on straight
    /// lines, over triangles at its start and at its end.
    Deforming(Vec<PrimitiveBvh<2>>),
}

/// Hierarchy of primitives.
#[derive(Clone, Debug)]
struct PrimitiveBvh<const SHAPES: usize> {
    /// Hierarchy whose leaves are known by the numbers of [`Leaf`].
    bvh: WideBvh,
    blocks: Vec<TriangleBlock<SHAPES>>,
    /// Quadrics with their indices in the geometry.
    quadrics: Vec<(u32, Quadric)>,
    bounds: Bounds,
}

/// Top-level acceleration structure: the instances, in world space.
#[derive(Clone, Debug)]
struct Tlas {
    bvh: WideBvh,
    /// Instances of each leaf.
    leaves: Box<[[Option<u32>; LEAF_SIZE]]>,
}

impl Accel {
    /// Builds the hierarchies. `ranges` are the primitives of each bottom-level hierarchy, none empty. The triangles of
    /// a mesh that deforms have one of their own.
    pub fn build(geometry: &Geometry, ranges: &[PrimitiveRange], instances: Vec<Instance>) -> Self {
        let blas = ranges.iter().map(|range| Blas::build(geometry, range)).collect();
        Self::over(blas, geometry, ranges, instances)
    }

    /// Builds the hierarchy over other instances of the same primitives; the bottom-level hierarchies are shared.
    pub fn with_instances(&self, geometry: &Geometry, ranges: &[PrimitiveRange], instances: Vec<Instance>) -> Self {
        Self::over(Arc::clone(&self.blas), geometry, ranges, instances)
    }

    fn over(blas: Arc<[Blas]>, geometry: &Geometry, ranges: &[PrimitiveRange], instances: Vec<Instance>) -> Self {
        let is_single = matches!(
            (&instances[..], &blas[..]),
            ([Instance { transform: InstanceTransform::World, .. }], [Blas::Rigid(_)])
        );
        let top = (!instances.is_empty() && !is_single).then(|| Tlas::build(&blas, &instances));
        let linear_scan = is_single.then(|| {
            let range = &ranges[instances[0].blas as usize];
            LinearScan::new(geometry, range, blas[0].bounds())
        });
        let linear_scan = linear_scan.flatten();
        let exceeds_caches = blas.iter().map(Blas::blocks).sum::<usize>() > BLOCKS_BEYOND_CACHES;
        Self { blas, instances, top, linear_scan, exceeds_caches }
    }

    /// Instances in the order of their indices.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// Lower and upper corner of the box around everything, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let all = self.instances.iter().map(|p| p.bounds(&self.blas));
        all.reduce(union).unwrap_or_default()
    }
}

impl Blas {
    fn build(geometry: &Geometry, range: &PrimitiveRange) -> Self {
        let first = geometry.triangles.get(range.triangles.start as usize).filter(|_| !range.triangles.is_empty());
        let Some(deformation) = first.and_then(|triangle| geometry.meshes[triangle.mesh as usize].deformation) else {
            let corners = |triangle| [geometry.corners(triangle)];
            return Self::Rigid(PrimitiveBvh::build(geometry, range, |[corners]| bounds_of(corners), corners));
        };
        let deformation = &geometry.deformations[deformation as usize];
        let part = |shape: usize| {
            let corners =
                |t: u32| [shape, shape + 1].map(|shape| deformation.corners(shape, &geometry.triangles[t as usize]));
            // Rounding between the shapes may leave their box by a unit in the last place or two.
            let boxes = |[from, to]: &[_; 2]| widened(&bounds_of(from).union(&bounds_of(to)));
            PrimitiveBvh::build(geometry, range, boxes, corners)
        };
        Self::Deforming((0..deformation.shape_count() - 1).map(part).collect())
    }

    /// Number of blocks of triangles.
    fn blocks(&self) -> usize {
        match self {
            Self::Rigid(bvh) => bvh.blocks.len(),
            Self::Deforming(parts) => parts.iter().map(|part| part.blocks.len()).sum(),
        }
    }

    fn bounds(&self) -> Bounds {
        match self {
            Self::Rigid(bvh) => bvh.bounds,
            Self::Deforming(parts) => parts.iter().map(|part| part.bounds).reduce(union).unwrap_or_default(),
        }
    }
}

fn widened(aabb: &Aabb) -> Aabb {
    let (min, max) = (Vec3::from(aabb.min), Vec3::from(aabb.max));
    let error = min.abs().max(max.abs()) * gamma(3);
    Aabb::new((min - error).into(), (max + error).into())
}

impl<const SHAPES: usize> PrimitiveBvh<SHAPES> {
    /// Builds the hierarchy. `corners` are those of a triangle in its shapes, `bounds` the box of them all.
    fn build(
        geometry: &Geometry,
        range: &PrimitiveRange,
        bounds: impl Fn(&[[Vec3; 3]; SHAPES]) -> Aabb + Sync,
        corners: impl Fn(u32) -> [[Vec3; 3]; SHAPES] + Sync,
    ) -> Self {
        // Primitives of the range are numbered from 0: triangles, then quadrics.
        let triangle_count = range.triangles.len() as u32;
        let quadric = |primitive: u32| Some(range.quadrics.start + primitive.checked_sub(triangle_count)?);
        let box_of = |primitive: u32| match quadric(primitive) {
            None => bounds(&corners(range.triangles.start + primitive)),
            Some(quadric) => {
                let (low, high) = geometry.quadrics[quadric as usize].bounds;
                Aabb::new(low.into(), high.into())
            }
        };
        let chunks = Chunks::new(range.len() as u32, |primitive| {
            let aabb = box_of(primitive);
            (aabb.min.into(), aabb.max.into())
        });
        let part = |primitives: &[u32]| {
            let tree = build_binary(primitives.iter().map(|&primitive| box_of(primitive)));
            // A leaf is a block of triangles or a single quadric.
            let content = |members: &[u32]| {
                let members = || members.iter().map(|&member| primitives[member as usize]);
                match (members().find_map(quadric), members().len()) {
                    (Some(quadric), 1) => Some(LeafContent::Quadric(quadric)),
                    (Some(_), _) => None,
                    (None, _) => {
                        let triangles = members().map(|member| range.triangles.start + member);
                        TriangleBlock::new(triangles.map(|triangle| (triangle, corners(triangle))))
                            .map(LeafContent::Triangles)
                    }
                }
            };
            let mut blocks = Vec::new();
            let mut quadrics = Vec::new();
            let bvh = WideBvh::collapse(
                &tree,
                |members| content(members).is_some(),
                |members| match content(members).expect("members that fit") {
                    LeafContent::Triangles(block) => {
                        blocks.push(block);
                        Leaf::Triangles(blocks.len() as u32 - 1).number()
                    }
                    LeafContent::Quadric(quadric) => {
                        quadrics.push((quadric, geometry.quadrics[quadric as usize].quadric));
                        Leaf::Quadric(quadrics.len() as u32 - 1).number()
                    }
                },
            );
            Self { bvh, blocks, quadrics, bounds: chunks.bounds() }
        };
        let parts = chunks.parts();
        if let [all] = parts[..] {
            let Self { bvh, blocks, quadrics, bounds } = part(all);
            return Self { bvh: bvh.compact(), blocks: compact(&blocks), quadrics, bounds };
        }
        let mut bvh = WideBvh::collapse(&chunks, |parts| parts.len() == 1, |parts| parts[0]);
        let (own_nodes, mut blocks, mut quadrics) = (bvh.len(), Vec::new(), Vec::new());
        let mut roots = Vec::with_capacity(parts.len());
        for batch in parts.chunks(rayon::current_num_threads()) {
            let built: Vec<Self> = batch.par_iter().map(|primitives| part(primitives)).collect();
            if roots.is_empty() {
                // Room that turns out not to be needed is never written to, and takes no memory.
                let room = |count: usize| count * (parts.len() + 1) / batch.len() * 5 / 4;
                bvh.reserve(room(built.iter().map(|part| part.bvh.len()).sum()));
                blocks.reserve_exact(room(built.iter().map(|part| part.blocks.len()).sum()));
                prefer_huge_pages(&blocks);
            }
            for part in built {
                let renumbered = |leaf| Leaf::of_number(leaf).moved(blocks.len(), quadrics.len()).number();
                roots.push(bvh.append(&part.bvh, renumbered));
                blocks.extend(part.blocks);
                quadrics.extend(part.quadrics);
            }
        }
        bvh.graft(own_nodes, &roots);
        Self { bvh, blocks, quadrics, bounds: chunks.bounds() }
    }
}

/// Content of a leaf.
enum LeafContent<const SHAPES: usize> {
    Triangles(TriangleBlock<SHAPES>),
    /// Index in the geometry.
    Quadric(u32),
}

impl Tlas {
    fn build(blas: &[Blas], instances: &[Instance]) -> Self {
        let boxes = instances.iter().map(|p| {
            let (min, max) = p.bounds(blas);
            Aabb::new(min.into(), max.into())
        });
        let tree = build_binary(boxes);
        let mut leaves = Vec::new();
        let bvh = WideBvh::collapse(
            &tree,
            |_| true,
            |primitives| {
                leaves.push(std::array::from_fn(|slot| primitives.get(slot).copied()));
                (leaves.len() - 1) as u32
            },
        );
        Self { bvh: bvh.compact(), leaves: leaves.into_boxed_slice() }
    }
}

impl Instance {
    /// World bounds, widened by the rounding of both transforms.
    fn bounds(&self, blas: &[Blas]) -> Bounds {
        let (min, max) = blas[self.blas as usize].bounds();
        let to_world = match &self.transform {
            InstanceTransform::World => return (min, max),
            InstanceTransform::Still(transform) => transform.to_world,
            InstanceTransform::Moving(motion) => {
                let (low, high) = motion.bounds((min, max));
                let reach = low.abs().max(high.abs()).max(high - low) * (8.0 * gamma(4));
                return (low - reach, high + reach);
            }
        };
        let corners = (0..8).map(|i| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), max, min));
        let bounds = corners.map(|c| to_world.transform_point3(c)).fold(Aabb::empty(), |mut all, corner| {
            all.extend(corner.into());
            all
        });
        let (low, high) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
        let error = low.abs().max(high.abs()).max(Vec3::from(to_world.translation).abs()) * (4.0 * gamma(4));
        (low - error, high + error)
    }
}

fn bounds_of([a, b, c]: &[Vec3; 3]) -> Aabb {
    Aabb::new(a.min(*b).min(*c).into(), a.max(*b).max(*c).into())
}

/// obvhs's medium quality without its own collapse: parallel-locally-ordered clustering and one round of reinsertion.
///
/// The leaves are handed over as nodes, since obvhs would otherwise want the boxes in an array of their own: with it
/// the most memory in use would be 24 bytes a triangle more.
fn build_binary(boxes: impl Iterator<Item = Aabb>) -> Bvh2 {
    let mut builder = PlocBuilder::new();
    builder.current_nodes = boxes.zip(0..).map(|(aabb, index)| Bvh2Node::new(aabb, 1, index)).collect();
    let bounds = builder.current_nodes.iter().fold(Aabb::empty(), |all, node| all.union(node.aabb()));
    let primitive_indices = (0..builder.current_nodes.len() as u32).collect();
    let mut tree = Bvh2 { primitive_indices, ..Bvh2::default() };
    const SEARCH_DISTANCE: usize = 14;
    let search_depth_threshold = 3;
    builder.build_ploc_from_leaves::<SEARCH_DISTANCE, false>(
        &mut tree,
        bounds,
        SortPrecision::U64,
        search_depth_threshold,
    );
    drop(builder);
    let reinserted_part = 0.05;
    ReinsertionOptimizer::default().run(&mut tree, reinserted_part, None);
    tree.parents = Vec::new();
    tree
}

impl BinaryTree for Bvh2 {
    fn len(&self) -> usize {
        self.nodes.len()
    }

    fn bounds(&self, node: u32) -> Bounds {
        let aabb = self.nodes[node as usize].aabb();
        (aabb.min.into(), aabb.max.into())
    }

    fn children(&self, node: u32) -> Option<[u32; 2]> {
        let node = &self.nodes[node as usize];
        (!node.is_leaf()).then_some([node.first_index, node.first_index + 1])
    }

    fn primitive(&self, leaf: u32) -> u32 {
        self.primitive_indices[self.nodes[leaf as usize].first_index as usize]
    }
}
