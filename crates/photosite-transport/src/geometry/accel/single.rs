//! Traversal by one ray from the root to the triangles: through the instances, into their hierarchies, down to the
//! blocks.

use super::leaf::Leaf;
use super::query::Query;
use super::{Accel, Blas, Instance, PrimitiveBvh, Tlas};
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
                let mut visitor = InstanceVisitor { accel: self, top, ray, query: &mut query };
                top.bvh.traverse(simd, ray.origin, ray.direction, &mut { ray.t_max }, &mut visitor)
            }
        };
        query.answer(has_ended)
    }

    /// Answers a query about one ray and one instance.
    #[inline(always)]
    pub(super) fn intersect_instance<S: Simd, Q: Query>(
        &self,
        simd: S,
        instance: u32,
        ray: &Ray,
        mut query: Q,
    ) -> Q::Answer {
        let (blas, local) = self.local_ray(instance, ray);
        let has_ended = blas.traverse(simd, instance, &local, &mut { ray.t_max }, &mut query);
        query.answer(has_ended)
    }

    /// The only hierarchy, where everything keeps its shape and stands in world space.
    #[inline(always)]
    pub(super) fn single_bvh(&self) -> Option<&PrimitiveBvh<1>> {
        let (None, Some(instance)) = (&self.top, self.instances.first()) else { return None };
        match &self.blas[instance.blas as usize] {
            Blas::Rigid(bvh) => Some(bvh),
            Blas::Deforming(_) => None,
        }
    }

    /// The hierarchy of an instance, and a ray in its space.
    #[inline(always)]
    pub(super) fn local_ray(&self, instance: u32, ray: &Ray) -> (&Blas, Ray) {
        let Instance { blas, transform } = &self.instances[instance as usize];
        let mut local = *ray;
        if let Some(transform) = transform.at(ray.time) {
            local.origin = transform.to_object.transform_point3(ray.origin);
            local.direction = transform.to_object.transform_vector3(ray.direction);
        }
        (&self.blas[*blas as usize], local)
    }
}

/// Takes a query from the leaves over the instances into the instances' blas.
struct InstanceVisitor<'a, Q> {
    accel: &'a Accel,
    top: &'a Tlas,
    ray: &'a Ray,
    query: &'a mut Q,
}

impl<Q: Query> LeafVisitor for InstanceVisitor<'_, Q> {
    const ANY_ORDER: bool = Q::ANY_ORDER;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, t_max: &mut f32) -> bool {
        for &instance in &self.top.leaves[leaf as usize] {
            let Some(instance) = instance else { break };
            let (blas, local) = self.accel.local_ray(instance, self.ray);
            if blas.traverse(simd, instance, &local, t_max, self.query) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn prefetch(&self, _: u32) {}
}

/// Takes a query from the leaves of a hierarchy to their primitives.
pub(super) struct PrimitiveVisitor<'a, Q, const SHAPES: usize> {
    pub(super) bvh: &'a PrimitiveBvh<SHAPES>,
    /// Position of the ray's time between two shapes, from 0 to 1.
    pub(super) part: f32,
    pub(super) sheared: &'a ShearedRay,
    pub(super) instance: u32,
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
                    Some(hits) => self.query.on_hits(&block.ids, &hits, self.instance, t_max),
                    None => false,
                }
            }
            Leaf::Quadric(quadric) => {
                let (id, quadric) = &self.bvh.quadrics[quadric as usize];
                self.query.on_quadric(*id, quadric, self.instance, t_max)
            }
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        self.bvh.prefetch(leaf);
    }
}

impl Blas {
    /// Traces a ray in the space of the hierarchy; `t_max` is shortened to the nearest hit that the query keeps.
    /// Returns whether the query has ended.
    #[inline(always)]
    fn traverse<S: Simd, Q: Query>(&self, simd: S, instance: u32, ray: &Ray, t_max: &mut f32, query: &mut Q) -> bool {
        match self {
            Self::Rigid(bvh) => bvh.traverse(simd, instance, ray, 0.0, t_max, query),
            Self::Deforming(parts) => {
                let (index, part) = segment(ray.time, parts.len());
                parts[index].traverse(simd, instance, ray, part, t_max, query)
            }
        }
    }
}

impl<const SHAPES: usize> PrimitiveBvh<SHAPES> {
    /// Asks the memory for a leaf.
    #[inline(always)]
    pub(super) fn prefetch(&self, leaf: u32) {
        match Leaf::of_number(leaf) {
            Leaf::Triangles(block) => prefetch(&self.blocks[block as usize]),
            Leaf::Quadric(quadric) => prefetch(&self.quadrics[quadric as usize]),
        }
    }

    /// Traverses one hierarchy; `part` is the position of the ray's time between two shapes.
    #[inline(always)]
    fn traverse<S: Simd, Q: Query>(
        &self,
        simd: S,
        instance: u32,
        ray: &Ray,
        part: f32,
        t_max: &mut f32,
        query: &mut Q,
    ) -> bool {
        let sheared = ShearedRay::new(ray, instance);
        let mut visitor = PrimitiveVisitor { bvh: self, part, sheared: &sheared, instance, query };
        self.bvh.traverse(simd, ray.origin, ray.direction, t_max, &mut visitor)
    }
}
