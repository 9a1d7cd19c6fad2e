//! The acceleration structure of a scene: one hierarchy of triangles for all geometry that stands where its file puts
//! it, one for each mesh that is instanced, and one over their placements.
//!
//! This is the only file that knows `obvhs`, which builds the binary hierarchies; traversal is that of [`wide_bvh`]
//! over their collapsed form, since obvhs's own is neither watertight nor scale-free.
//!
//! [`wide_bvh`]: super::wide_bvh

use std::ops::Range;

use glam::{Affine3A, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, SortPrecision};

use super::simd::{Lanes, with_widest_lanes};
use super::wide_bvh::{BinaryTree, BlockHits, LEAF_SIZE, LeafVisitor, ShearedRay, TriangleBlock, WideBvh};
use super::{Geometry, Hit, Ray};
use crate::math::float::gamma;

/// Decides whether a triangle that a ray meets is there at that point: alpha masks.
pub trait HitFilter {
    /// Whether the hit counts.
    fn accept(&self, triangle: u32, barycentric: [f32; 2], ray: &Ray) -> bool;
}

/// Every triangle is there.
#[derive(Clone, Copy, Debug)]
pub struct AcceptAll;

impl HitFilter for AcceptAll {
    #[inline(always)]
    fn accept(&self, _: u32, _: [f32; 2], _: &Ray) -> bool {
        true
    }
}

/// A group of triangles somewhere in the world.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Index of the group.
    pub group: u32,
    /// Group space → world; `None` where the group is given in world space.
    pub transform: Option<Transform>,
}

/// A transform with its inverse.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    /// Group space → world.
    pub to_world: Affine3A,
    /// World → group space.
    pub to_group: Affine3A,
}

/// Hierarchies over all triangles.
#[derive(Clone, Debug)]
pub struct Accel {
    groups: Vec<TriangleBvh>,
    placements: Vec<Placement>,
    /// Over the placements; `None` where there is none, or a single one in world space.
    top: Option<TopLevel>,
}

#[derive(Clone, Debug)]
struct TriangleBvh {
    bvh: WideBvh,
    blocks: Vec<TriangleBlock>,
    bounds: (Vec3, Vec3),
}

#[derive(Clone, Debug)]
struct TopLevel {
    bvh: WideBvh,
    /// Placements of each leaf.
    leaves: Vec<[Option<u32>; LEAF_SIZE]>,
}

impl Accel {
    /// Builds the hierarchies. `groups` are ranges of triangles of `geometry`, each not empty.
    pub fn build(geometry: &Geometry, groups: &[Range<u32>], placements: Vec<Placement>) -> Self {
        let groups: Vec<_> = groups.iter().map(|range| TriangleBvh::build(geometry, range.clone())).collect();
        let needs_top = !matches!(placements[..], [] | [Placement { transform: None, .. }]);
        let top = needs_top.then(|| TopLevel::build(&groups, &placements));
        Self { groups, placements, top }
    }

    /// The placements.
    pub fn placements(&self) -> &[Placement] {
        &self.placements
    }

    /// Lower and upper corner of everything, m.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let all = self.placements.iter().map(|p| p.bounds(&self.groups));
        all.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((Vec3::ZERO, Vec3::ZERO))
    }

    /// The nearest hit that `filter` accepts.
    #[inline]
    pub fn closest<F: HitFilter>(&self, ray: &Ray, filter: &F) -> Option<Hit> {
        closest(self, ray, filter)
    }

    /// Whether anything that `filter` accepts is in the ray's way.
    #[inline]
    pub fn occluded<F: HitFilter>(&self, ray: &Ray, filter: &F) -> bool {
        occluded(self, ray, filter)
    }

    /// Shows `query` every group that the ray may meet. Returns whether it broke off.
    #[inline(always)]
    fn traverse<L: Lanes>(&self, ray: &Ray, query: &mut impl TriangleQuery) -> bool {
        match &self.top {
            None => match self.placements.first() {
                Some(placement) => {
                    let group = &self.groups[placement.group as usize];
                    group.traverse::<L, _>(0, ray, &mut { ray.t_max }, query)
                }
                None => false,
            },
            Some(top) => {
                let mut visitor = PlacementVisitor { accel: self, top, ray, query };
                top.bvh.traverse::<L>(ray.origin, ray.direction, &mut { ray.t_max }, &mut visitor)
            }
        }
    }
}

with_widest_lanes! {
    fn closest<F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> Option<Hit> = closest_in
}

#[inline(always)]
fn closest_in<L: Lanes, F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> Option<Hit> {
    let mut query = Closest { ray, filter, nearest: None };
    accel.traverse::<L>(ray, &mut query);
    query.nearest
}

with_widest_lanes! {
    fn occluded<F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> bool = occluded_in
}

#[inline(always)]
fn occluded_in<L: Lanes, F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> bool {
    accel.traverse::<L>(ray, &mut Occluded { ray, filter })
}

/// What is asked of the triangles along a ray.
trait TriangleQuery {
    /// Looks at the hits in a block; may shorten the ray. Returning true ends the query.
    fn consider(&mut self, block: &TriangleBlock, hits: &BlockHits, placement: u32, t_max: &mut f32) -> bool;
}

/// The nearest hit.
struct Closest<'a, F> {
    ray: &'a Ray,
    filter: &'a F,
    nearest: Option<Hit>,
}

impl<F: HitFilter> TriangleQuery for Closest<'_, F> {
    #[inline(always)]
    fn consider(&mut self, block: &TriangleBlock, hits: &BlockHits, placement: u32, t_max: &mut f32) -> bool {
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            let (t, triangle) = (hits.t[lane], block.ids[lane]);
            if t < *t_max {
                let barycentric = hits.barycentric(lane);
                if self.filter.accept(triangle, barycentric, self.ray) {
                    *t_max = t;
                    self.nearest = Some(Hit { t, barycentric, triangle, placement });
                }
            }
        }
        false
    }
}

/// Any hit.
struct Occluded<'a, F> {
    ray: &'a Ray,
    filter: &'a F,
}

impl<F: HitFilter> TriangleQuery for Occluded<'_, F> {
    #[inline(always)]
    fn consider(&mut self, block: &TriangleBlock, hits: &BlockHits, _: u32, _: &mut f32) -> bool {
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            if self.filter.accept(block.ids[lane], hits.barycentric(lane), self.ray) {
                return true;
            }
        }
        false
    }
}

/// Takes a query from the placements into their groups.
struct PlacementVisitor<'a, Q> {
    accel: &'a Accel,
    top: &'a TopLevel,
    ray: &'a Ray,
    query: &'a mut Q,
}

impl<Q: TriangleQuery> LeafVisitor for PlacementVisitor<'_, Q> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, leaf: u32, t_max: &mut f32) -> bool {
        for &placement in &self.top.leaves[leaf as usize] {
            let Some(placement) = placement else { break };
            let Placement { group, transform } = &self.accel.placements[placement as usize];
            let mut local = *self.ray;
            if let Some(transform) = transform {
                local.origin = transform.to_group.transform_point3(self.ray.origin);
                local.direction = transform.to_group.transform_vector3(self.ray.direction);
            }
            if self.accel.groups[*group as usize].traverse::<L, _>(placement, &local, t_max, self.query) {
                return true;
            }
        }
        false
    }
}

/// Takes a query from the leaves of a group to their triangles.
struct BlockVisitor<'a, Q> {
    blocks: &'a [TriangleBlock],
    sheared: ShearedRay,
    placement: u32,
    query: &'a mut Q,
}

impl<Q: TriangleQuery> LeafVisitor for BlockVisitor<'_, Q> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, leaf: u32, t_max: &mut f32) -> bool {
        let block = &self.blocks[leaf as usize];
        let hits = block.intersect::<L>(&self.sheared, *t_max);
        hits.mask != 0 && self.query.consider(block, &hits, self.placement, t_max)
    }
}

impl TriangleBvh {
    /// `ray` is in the group's space; `t_max` is shortened to the nearest hit that the query keeps.
    #[inline(always)]
    fn traverse<L: Lanes, Q: TriangleQuery>(&self, placement: u32, ray: &Ray, t_max: &mut f32, query: &mut Q) -> bool {
        let sheared = ShearedRay::new(ray.origin, ray.direction);
        let mut visitor = BlockVisitor { blocks: &self.blocks, sheared, placement, query };
        self.bvh.traverse::<L>(ray.origin, ray.direction, t_max, &mut visitor)
    }

    fn build(geometry: &Geometry, range: Range<u32>) -> Self {
        let boxes = range.clone().map(|triangle| bounds_of(&geometry.corners(triangle)));
        let (tree, bounds) = build_binary(boxes);
        let mut blocks = Vec::with_capacity(tree.nodes.len() / 9);
        let mut bvh = WideBvh::collapse(&tree, tree.nodes.len(), |primitives| {
            let mut triangles = [(0, [Vec3::ZERO; 3]); LEAF_SIZE];
            for (slot, &primitive) in triangles.iter_mut().zip(primitives) {
                let triangle = range.start + primitive;
                *slot = (triangle, geometry.corners(triangle));
            }
            blocks.push(TriangleBlock::new(&triangles[..primitives.len()]));
            (blocks.len() - 1) as u32
        });
        // Shrinking copies, for which the memory of the binary tree will do.
        drop(tree);
        blocks.shrink_to_fit();
        bvh.shrink_to_fit();
        Self { bvh, blocks, bounds: (bounds.min.into(), bounds.max.into()) }
    }
}

impl TopLevel {
    fn build(groups: &[TriangleBvh], placements: &[Placement]) -> Self {
        let boxes = placements.iter().map(|p| {
            let (min, max) = p.bounds(groups);
            Aabb::new(min.into(), max.into())
        });
        let (tree, _) = build_binary(boxes);
        let mut leaves = Vec::new();
        let bvh = WideBvh::collapse(&tree, tree.nodes.len(), |primitives| {
            leaves.push(std::array::from_fn(|slot| primitives.get(slot).copied()));
            (leaves.len() - 1) as u32
        });
        Self { bvh, leaves }
    }
}

impl Placement {
    /// World bounds, widened by the rounding of both transforms.
    fn bounds(&self, groups: &[TriangleBvh]) -> (Vec3, Vec3) {
        let (min, max) = groups[self.group as usize].bounds;
        let Some(Transform { to_world, .. }) = self.transform else { return (min, max) };
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
/// Returns the bounds of all boxes too.
///
/// The leaves are handed over as nodes, since obvhs would otherwise want the boxes in an array of their own: with it the
/// most memory in use would be 24 bytes a triangle more.
fn build_binary(boxes: impl Iterator<Item = Aabb>) -> (Bvh2, Aabb) {
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
    (tree, bounds)
}

impl BinaryTree for Bvh2 {
    fn bounds(&self, node: u32) -> (Vec3, Vec3) {
        let aabb = self.nodes[node as usize].aabb();
        (aabb.min.into(), aabb.max.into())
    }

    fn children(&self, node: u32) -> Option<[u32; 2]> {
        let node = &self.nodes[node as usize];
        (!node.is_leaf()).then_some([node.first_index, node.first_index + 1])
    }

    fn primitives(&self, leaf: u32) -> &[u32] {
        let node = &self.nodes[leaf as usize];
        &self.primitive_indices[node.first_index as usize..(node.first_index + node.prim_count) as usize]
    }
}
