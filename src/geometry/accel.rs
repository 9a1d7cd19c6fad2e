//! The acceleration structure of a scene: one hierarchy of triangles for all geometry that stands where its file puts
//! it, one for each mesh that is instanced, and one over their placements.
//!
//! This is the only file that knows `obvhs`, which builds the binary hierarchies; traversal is that of [`wide_bvh`]
//! over their collapsed form, since obvhs's own is neither watertight nor scale-free.
//!
//! [`wide_bvh`]: super::wide_bvh

use std::ops::Range;

use glam::{Affine3A, Vec3, Vec3A};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::simd::{Lanes, with_widest_lanes};
use super::wide_bvh::{BinaryTree, LEAF_SIZE, ShearedRay, TriangleBlock, WideBvh};
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
    /// Over the placements; `None` where the only placement is in world space.
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
    /// Builds the hierarchies. `groups` are ranges of triangles of `geometry`, each not empty; there is at least one
    /// placement.
    pub fn build(geometry: &Geometry, groups: &[Range<u32>], placements: Vec<Placement>) -> Self {
        let groups: Vec<_> = groups.iter().map(|range| TriangleBvh::build(geometry, range.clone())).collect();
        let in_world_only = matches!(placements[..], [Placement { transform: None, .. }]);
        let top = (!in_world_only).then(|| TopLevel::build(&groups, &placements));
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

    /// Calls `visit` for every group that the ray may meet, with the ray in that group's space.
    #[inline(always)]
    fn traverse_placements<L: Lanes>(
        &self,
        ray: &Ray,
        mut visit: impl FnMut(u32, &TriangleBvh, &Ray, &mut f32) -> bool,
    ) -> bool {
        match &self.top {
            None => {
                let mut t_max = ray.t_max;
                visit(0, &self.groups[self.placements[0].group as usize], ray, &mut t_max)
            }
            Some(top) => top.bvh.traverse::<L>(ray.origin, ray.direction, ray.t_max, |leaf, t_max| {
                top.leaves[leaf as usize].iter().map_while(|p| *p).any(|placement| {
                    let Placement { group, transform } = &self.placements[placement as usize];
                    let mut local = Ray { t_max: *t_max, ..*ray };
                    if let Some(transform) = transform {
                        local.origin = transform.to_group.transform_point3(ray.origin);
                        local.direction = transform.to_group.transform_vector3(ray.direction);
                    }
                    visit(placement, &self.groups[*group as usize], &local, t_max)
                })
            }),
        }
    }
}

with_widest_lanes! {
    fn closest<F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> Option<Hit> = closest_in
}

#[inline(always)]
fn closest_in<L: Lanes, F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> Option<Hit> {
    let mut nearest = None;
    accel.traverse_placements::<L>(ray, |placement, group, local, t_max| {
        let sheared = ShearedRay::new(local.origin, local.direction);
        group.bvh.traverse::<L>(local.origin, local.direction, *t_max, |block, block_t_max| {
            let block = &group.blocks[block as usize];
            let hits = block.intersect::<L>(&sheared, *block_t_max);
            let mut mask = hits.mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                let (t, triangle) = (hits.t[lane], block.ids[lane]);
                let barycentric = hits.barycentric(lane);
                if t < *block_t_max && filter.accept(triangle, barycentric, ray) {
                    *block_t_max = t;
                    *t_max = t;
                    nearest = Some(Hit { t, barycentric, triangle, placement });
                }
            }
            false
        })
    });
    nearest
}

with_widest_lanes! {
    fn occluded<F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> bool = occluded_in
}

#[inline(always)]
fn occluded_in<L: Lanes, F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> bool {
    accel.traverse_placements::<L>(ray, |_, group, local, t_max| {
        let sheared = ShearedRay::new(local.origin, local.direction);
        group.bvh.traverse::<L>(local.origin, local.direction, *t_max, |block, block_t_max| {
            let block = &group.blocks[block as usize];
            let hits = block.intersect::<L>(&sheared, *block_t_max);
            let mut lanes = (0..8).filter(|lane| hits.mask & (1 << lane) != 0);
            hits.mask != 0 && lanes.any(|lane| filter.accept(block.ids[lane], hits.barycentric(lane), ray))
        })
    })
}

impl TriangleBvh {
    fn build(geometry: &Geometry, range: Range<u32>) -> Self {
        let boxes: Vec<Bounds> = range.clone().map(|triangle| Bounds::of(&geometry.corners(triangle))).collect();
        let bounds = boxes.iter().fold(Bounds::EMPTY, |all, b| all.union(b)).corners();
        let tree = build_binary(&boxes);
        drop(boxes);
        let mut blocks = Vec::with_capacity(tree.nodes.len() / 9);
        let bvh = WideBvh::collapse(&tree, tree.nodes.len(), |primitives| {
            let mut triangles = [(0, [Vec3::ZERO; 3]); LEAF_SIZE];
            for (slot, &primitive) in triangles.iter_mut().zip(primitives) {
                let triangle = range.start + primitive;
                *slot = (triangle, geometry.corners(triangle));
            }
            blocks.push(TriangleBlock::new(&triangles[..primitives.len()]));
            (blocks.len() - 1) as u32
        });
        blocks.shrink_to_fit();
        Self { bvh, blocks, bounds }
    }
}

impl TopLevel {
    fn build(groups: &[TriangleBvh], placements: &[Placement]) -> Self {
        let boxes: Vec<_> = placements.iter().map(|p| Bounds::from(p.bounds(groups))).collect();
        let tree = build_binary(&boxes);
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
        let bounds =
            corners.map(|c| to_world.transform_point3(c)).fold(Bounds::EMPTY, |b, p| b.union(&Bounds::of(&[p; 3])));
        let (low, high) = bounds.corners();
        let error = low.abs().max(high.abs()).max(Vec3::from(to_world.translation).abs()) * (4.0 * gamma(4));
        (low - error, high + error)
    }
}

/// An axis-aligned box in 24 bytes, as obvhs asks for it.
#[derive(Clone, Copy)]
struct Bounds {
    min: [f32; 3],
    max: [f32; 3],
}

impl Bounds {
    const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    fn of(corners: &[Vec3; 3]) -> Self {
        let [a, b, c] = *corners;
        Self { min: a.min(b).min(c).to_array(), max: a.max(b).max(c).to_array() }
    }

    fn union(&self, other: &Self) -> Self {
        let (a, b) = (self.corners(), other.corners());
        Self::from((a.0.min(b.0), a.1.max(b.1)))
    }

    fn corners(&self) -> (Vec3, Vec3) {
        (Vec3::from_array(self.min), Vec3::from_array(self.max))
    }
}

impl From<(Vec3, Vec3)> for Bounds {
    fn from((min, max): (Vec3, Vec3)) -> Self {
        Self { min: min.to_array(), max: max.to_array() }
    }
}

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(Vec3A::from_array(self.min), Vec3A::from_array(self.max))
    }
}

/// obvhs's medium quality without its own collapse: parallel-locally-ordered clustering and one round of reinsertion.
fn build_binary(boxes: &[Bounds]) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect();
    let search_depth_threshold = 3;
    let mut tree = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        boxes,
        indices,
        SortPrecision::U64,
        search_depth_threshold,
    );
    let reinserted_part = 0.05;
    ReinsertionOptimizer::default().run(&mut tree, reinserted_part, None);
    tree
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
