//! The two questions about a ray: its nearest hit, and whether it has any.

use super::HitFilter;
use crate::geometry::linear_scan::{ClosestLanes, LaneQuery, OccludedLanes};
use crate::geometry::triangle_block::{BLOCK_SIZE, BlockHits};
use crate::geometry::{Hit, Primitive, Quadric, Ray};
use photosite_core::math::Vector;
use photosite_simd::Simd;

/// State of one ray while it is traced: its hits so far.
pub(in crate::geometry) trait Query {
    /// Whether leaves may be visited in any order, since the ray is never shortened.
    const ANY_ORDER: bool;
    /// The result.
    type Answer;

    /// Takes the hits in a block of triangles; may shorten the ray. Returns whether the query has ended.
    fn on_hits(&mut self, ids: &[u32; BLOCK_SIZE], hits: &BlockHits, instance: u32, t_max: &mut f32) -> bool;
    /// Intersects a quadric, likewise.
    fn on_quadric(&mut self, id: u32, quadric: &Quadric, instance: u32, t_max: &mut f32) -> bool;
    /// The result of a query that has ended, or of one that has visited everything.
    fn answer(&self, has_ended: bool) -> Self::Answer;
}

/// A query that can be made for any ray.
pub(in crate::geometry) trait RayQuery<'a, F: HitFilter>: Query {
    /// Query for a ray in each of several lanes.
    type InLanes<S: Simd>: LaneQuery<S, Answer = Self::Answer>;

    /// Begins with no hit.
    fn new(ray: &'a Ray, filter: &'a F) -> Self;
}

/// The nearest hit. Of several at the same distance that of the lowest index, in whatever order they come.
pub(super) struct Closest<'a, F> {
    ray: &'a Ray,
    filter: &'a F,
    nearest: Option<Hit>,
}

impl<F> Closest<'_, F> {
    /// Whether a hit comes before the nearest one, which is at `t_max`.
    #[inline(always)]
    fn is_nearer(&self, t: f32, primitive: Primitive, t_max: f32) -> bool {
        t < t_max || t == t_max && self.nearest.is_some_and(|nearest| primitive < nearest.primitive)
    }
}

impl<'a, F: HitFilter> RayQuery<'a, F> for Closest<'a, F> {
    type InLanes<S: Simd> = ClosestLanes<S>;

    #[inline(always)]
    fn new(ray: &'a Ray, filter: &'a F) -> Self {
        Self { ray, filter, nearest: None }
    }
}

impl<F: HitFilter> Query for Closest<'_, F> {
    const ANY_ORDER: bool = false;
    type Answer = Option<Hit>;

    #[inline(always)]
    fn on_hits(&mut self, ids: &[u32; BLOCK_SIZE], hits: &BlockHits, instance: u32, t_max: &mut f32) -> bool {
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            let (t, primitive) = (hits.t[lane], Primitive::Triangle(ids[lane]));
            if self.is_nearer(t, primitive, *t_max) {
                let uv = hits.barycentric(lane);
                if self.filter.accept(primitive, uv, self.ray) {
                    *t_max = t;
                    self.nearest = Some(Hit { t, uv, primitive, instance });
                }
            }
        }
        false
    }

    #[inline(never)]
    fn on_quadric(&mut self, id: u32, quadric: &Quadric, instance: u32, t_max: &mut f32) -> bool {
        let primitive = Primitive::Quadric(id);
        let is_nearer = |t| self.is_nearer(t, primitive, *t_max);
        let hit = intersect_quadric(quadric, self.ray, is_nearer, |uv| self.filter.accept(primitive, uv, self.ray));
        if let Some((t, uv)) = hit {
            *t_max = t;
            self.nearest = Some(Hit { t, uv, primitive, instance });
        }
        false
    }

    #[inline(always)]
    fn answer(&self, _: bool) -> Option<Hit> {
        self.nearest
    }
}

/// Query whether there is any hit.
pub(super) struct Occluded<'a, F> {
    ray: &'a Ray,
    filter: &'a F,
}

impl<'a, F: HitFilter> RayQuery<'a, F> for Occluded<'a, F> {
    type InLanes<S: Simd> = OccludedLanes<S>;

    #[inline(always)]
    fn new(ray: &'a Ray, filter: &'a F) -> Self {
        Self { ray, filter }
    }
}

impl<F: HitFilter> Query for Occluded<'_, F> {
    const ANY_ORDER: bool = true;
    type Answer = bool;

    #[inline(always)]
    fn on_hits(&mut self, ids: &[u32; BLOCK_SIZE], hits: &BlockHits, _: u32, t_max: &mut f32) -> bool {
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            let primitive = Primitive::Triangle(ids[lane]);
            let is_before = hits.t[lane] < *t_max && ids[lane] != self.ray.to;
            if is_before && self.filter.accept(primitive, hits.barycentric(lane), self.ray) {
                return true;
            }
        }
        false
    }

    #[inline(never)]
    fn on_quadric(&mut self, id: u32, quadric: &Quadric, _: u32, t_max: &mut f32) -> bool {
        let (primitive, is_nearer) = (Primitive::Quadric(id), |t| t < *t_max);
        let is_there = |uv| self.filter.accept(primitive, uv, self.ray);
        primitive.target() != self.ray.to && intersect_quadric(quadric, self.ray, is_nearer, is_there).is_some()
    }

    #[inline(always)]
    fn answer(&self, has_ended: bool) -> bool {
        has_ended
    }
}

/// The first hit of a quadric that counts, as t and parameters: of the two sides the nearer may have a hole.
fn intersect_quadric(
    quadric: &Quadric,
    ray: &Ray,
    is_nearer: impl Fn(f32) -> bool,
    is_there: impl Fn([f32; 2]) -> bool,
) -> Option<(f32, [f32; 2])> {
    let sides = quadric.intersect(Vector::from(ray.origin), Vector::from(ray.direction));
    sides.into_iter().filter(|&t| 0.0 < t && is_nearer(t)).find_map(|t| {
        let uv = quadric.uv(ray.at(t));
        is_there(uv).then_some((t, uv))
    })
}
