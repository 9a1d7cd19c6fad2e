//! One ray on its way from the root to the triangles: through the placements, into their groups, down to the blocks.

use super::leaf::Leaf;
use super::query::Query;
use super::{Accel, Group, Placement, TopLevel, TriangleBvh};
use crate::geometry::Ray;
use crate::geometry::mesh::segment;
use crate::geometry::triangle_block::ShearedRay;
use crate::geometry::wide_bvh::LeafVisitor;
use photosite_simd::{Simd, prefetch};

impl Accel {
    /// Answers a query about one ray.
    #[inline(always)]
    pub(super) fn intersect<S: Simd, Q: Query>(&self, simd: S, ray: &Ray, mut query: Q) -> Q::Answer {
        let has_ended = match &self.top {
            None => match self.single_bvh() {
                Some(bvh) => bvh.traverse(simd, 0, ray, 0.0, &mut { ray.t_max }, &mut query),
                None => false,
            },
            Some(top) => {
                let mut visitor = PlacementVisitor { accel: self, top, ray, query: &mut query };
                top.bvh.traverse(simd, ray.origin, ray.direction, &mut { ray.t_max }, &mut visitor)
            }
        };
        query.answer(has_ended)
    }

    /// The only hierarchy, where everything keeps its shape and stands in world space.
    #[inline(always)]
    pub(super) fn single_bvh(&self) -> Option<&TriangleBvh<1>> {
        let (None, Some(placement)) = (&self.top, self.placements.first()) else { return None };
        match &self.groups[placement.group as usize] {
            Group::Rigid(bvh) => Some(bvh),
            Group::Deforming(_) => None,
        }
    }

    /// The group of a placement, and a ray in its space.
    #[inline(always)]
    pub(super) fn in_group(&self, placement: u32, ray: &Ray) -> (&Group, Ray) {
        let Placement { group, place } = &self.placements[placement as usize];
        let mut local = *ray;
        if let Some(transform) = place.at(ray.time) {
            local.origin = transform.to_group.transform_point3(ray.origin);
            local.direction = transform.to_group.transform_vector3(ray.direction);
        }
        (&self.groups[*group as usize], local)
    }
}

/// Takes a query from the leaves over the placements into the placements' groups.
struct PlacementVisitor<'a, Q> {
    accel: &'a Accel,
    top: &'a TopLevel,
    ray: &'a Ray,
    query: &'a mut Q,
}

impl<Q: Query> LeafVisitor for PlacementVisitor<'_, Q> {
    const ANY_ORDER: bool = Q::ANY_ORDER;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, t_max: &mut f32) -> bool {
        for &placement in &self.top.leaves[leaf as usize] {
            let Some(placement) = placement else { break };
            let (group, local) = self.accel.in_group(placement, self.ray);
            if group.traverse(simd, placement, &local, t_max, self.query) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn prefetch(&self, _: u32) {}
}

/// Takes a query from the leaves of a group to their primitives.
pub(super) struct PrimitiveVisitor<'a, Q, const SHAPES: usize> {
    pub(super) bvh: &'a TriangleBvh<SHAPES>,
    /// Position of the ray's time between two shapes, from 0 to 1.
    pub(super) part: f32,
    pub(super) sheared: &'a ShearedRay,
    pub(super) placement: u32,
    pub(super) query: &'a mut Q,
}

impl<Q: Query, const SHAPES: usize> LeafVisitor for PrimitiveVisitor<'_, Q, SHAPES> {
    const ANY_ORDER: bool = Q::ANY_ORDER;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, t_max: &mut f32) -> bool {
        match Leaf::of_number(leaf) {
            Leaf::Triangles(block) => {
                let block = &self.bvh.blocks[block as usize];
                match block.intersect(simd, self.sheared, self.part, *t_max) {
                    Some(hits) => self.query.on_hits(&block.ids, &hits, self.placement, t_max),
                    None => false,
                }
            }
            Leaf::Quadric(quadric) => {
                let (id, quadric) = &self.bvh.quadrics[quadric as usize];
                self.query.on_quadric(*id, quadric, self.placement, t_max)
            }
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        self.bvh.prefetch(leaf);
    }
}

impl Group {
    /// Traces a ray in the group's space; `t_max` is shortened to the nearest hit that the query keeps. Returns whether the query
    /// has ended.
    #[inline(always)]
    fn traverse<S: Simd, Q: Query>(&self, simd: S, placement: u32, ray: &Ray, t_max: &mut f32, query: &mut Q) -> bool {
        match self {
            Self::Rigid(bvh) => bvh.traverse(simd, placement, ray, 0.0, t_max, query),
            Self::Deforming(parts) => {
                let (index, part) = segment(ray.time, parts.len());
                parts[index].traverse(simd, placement, ray, part, t_max, query)
            }
        }
    }
}

impl<const SHAPES: usize> TriangleBvh<SHAPES> {
    /// Asks the memory for a leaf.
    #[inline(always)]
    pub(super) fn prefetch(&self, leaf: u32) {
        match Leaf::of_number(leaf) {
            Leaf::Triangles(block) => prefetch(&self.blocks[block as usize]),
            Leaf::Quadric(quadric) => prefetch(&self.quadrics[quadric as usize]),
        }
    }

    /// The same in one hierarchy; `part` is the position of the ray's time between two shapes.
    #[inline(always)]
    fn traverse<S: Simd, Q: Query>(
        &self,
        simd: S,
        placement: u32,
        ray: &Ray,
        part: f32,
        t_max: &mut f32,
        query: &mut Q,
    ) -> bool {
        let sheared = ShearedRay::new(ray.origin, ray.direction);
        let mut visitor = PrimitiveVisitor { bvh: self, part, sheared: &sheared, placement, query };
        self.bvh.traverse(simd, ray.origin, ray.direction, t_max, &mut visitor)
    }
}
