//! What is asked along rays, and how it is taken to the triangles: through the placements, into their groups, down to blocks.

use super::packet::{ask_together, runs};
use super::turns::{GroupFlight, PlacedFlight, take_turns};
use super::{Accel, Group, Placement, TopLevel, TriangleBvh};
use crate::geometry::mesh::segment;
use crate::geometry::triangle_block::{BLOCK_SIZE, BlockHits, ShearedRay, TriangleBlock};
use crate::geometry::wide_bvh::LeafVisitor;
use crate::geometry::{Hit, Ray, Sphere};
use photosite_core::math::Vector;
use photosite_simd::{Lanes, ManyLanes, prefetch, with_most_lanes, with_widest_lanes};

/// Set in the number of a leaf whose block holds a sphere.
pub(super) const SPHERE: u32 = 1 << 30;

/// Decides whether a triangle that a ray meets is there at that point: alpha masks.
pub trait HitFilter {
    /// Whether every hit counts.
    const ACCEPTS_ALL: bool = false;

    /// Whether the hit counts.
    fn accept(&self, triangle: u32, barycentric: [f32; 2], ray: &Ray) -> bool;
}

/// Every triangle is there.
#[derive(Clone, Copy, Debug)]
pub struct AcceptAll;

impl HitFilter for AcceptAll {
    const ACCEPTS_ALL: bool = true;

    #[inline(always)]
    fn accept(&self, _: u32, _: [f32; 2], _: &Ray) -> bool {
        true
    }
}

impl Accel {
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

    /// The nearest hits of several rays that `filter` accepts, in the order of the rays.
    pub fn closest_each<F: HitFilter>(&self, rays: &[Ray], filter: &F, hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        hits.resize(rays.len(), None);
        if let Some(sweep) = &self.sweep {
            return sweep.closest_each(rays, filter, hits);
        }
        match self.alone() {
            Some(group) => {
                for (run, is_close) in runs(group, rays) {
                    let (rays, hits) = (&rays[run.clone()], &mut hits[run]);
                    match (is_close, self.exceeds_caches) {
                        (true, _) => closest_together(group, rays, filter, hits),
                        (false, true) => closest_each(group, rays, filter, hits),
                        (false, false) => closest_alone(self, rays, filter, hits),
                    }
                }
            }
            None if self.exceeds_caches => closest_each_placed(self, rays, filter, hits),
            None => closest_alone(self, rays, filter, hits),
        }
    }

    /// Whether anything that `filter` accepts is in the way of each of several rays.
    pub fn occluded_each<F: HitFilter>(&self, rays: &[Ray], filter: &F, occluded: &mut Vec<bool>) {
        occluded.clear();
        occluded.resize(rays.len(), false);
        if let Some(sweep) = &self.sweep {
            return sweep.occluded_each(rays, filter, occluded);
        }
        match self.alone() {
            Some(group) => {
                for (run, is_close) in runs(group, rays) {
                    let (rays, occluded) = (&rays[run.clone()], &mut occluded[run]);
                    match (is_close, self.exceeds_caches) {
                        (true, _) => occluded_together(group, rays, filter, occluded),
                        (false, true) => occluded_each(group, rays, filter, occluded),
                        (false, false) => occluded_alone(self, rays, filter, occluded),
                    }
                }
            }
            None if self.exceeds_caches => occluded_each_placed(self, rays, filter, occluded),
            None => occluded_alone(self, rays, filter, occluded),
        }
    }

    #[inline(always)]
    fn ask<L: Lanes, Q: TriangleQuery>(&self, ray: &Ray, mut query: Q) -> Q::Answer {
        let is_ended = self.traverse::<L>(ray, &mut query);
        query.answer(is_ended)
    }

    /// The group that is all there is.
    #[inline(always)]
    pub(super) fn alone(&self) -> Option<&TriangleBvh<1>> {
        let (None, Some(placement)) = (&self.top, self.placements.first()) else { return None };
        match &self.groups[placement.group as usize] {
            Group::Rigid(group) => Some(group),
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

    /// Shows `query` every group that the ray may meet. Returns whether it broke off.
    #[inline(always)]
    fn traverse<L: Lanes>(&self, ray: &Ray, query: &mut impl TriangleQuery) -> bool {
        match &self.top {
            None => match self.alone() {
                Some(group) => group.traverse::<L, _>(0, ray, 0.0, &mut { ray.t_max }, query),
                None => false,
            },
            Some(top) => {
                let mut visitor = PlacementVisitor { accel: self, top, ray, query };
                top.bvh.traverse::<L, _>(ray.origin, ray.direction, &mut { ray.t_max }, &mut visitor)
            }
        }
    }
}

with_widest_lanes! {
    fn closest<F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> Option<Hit> = closest_in
}

#[inline(always)]
fn closest_in<L: Lanes, F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> Option<Hit> {
    accel.ask::<L, _>(ray, Closest { ray, filter, nearest: None })
}

fn closest_alone<F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) {
    hits.iter_mut().zip(rays).for_each(|(hit, ray)| *hit = accel.closest(ray, filter));
}

with_widest_lanes! {
    fn occluded<F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> bool = occluded_in
}

#[inline(always)]
fn occluded_in<L: Lanes, F: HitFilter>(accel: &Accel, ray: &Ray, filter: &F) -> bool {
    accel.ask::<L, _>(ray, Occluded { ray, filter })
}

fn occluded_alone<F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, occluded: &mut [bool]) {
    occluded.iter_mut().zip(rays).for_each(|(is_occluded, ray)| *is_occluded = accel.occluded(ray, filter));
}

// Functions of their own for rays in one group, which are slower in one function with the others.
with_widest_lanes! {
    fn closest_each<F: HitFilter>(group: &TriangleBvh<1>, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) -> () =
        closest_each_in
}

#[inline(always)]
fn closest_each_in<L: Lanes, F: HitFilter>(group: &TriangleBvh<1>, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) {
    let query = |ray| Closest { ray, filter, nearest: None };
    take_turns::<L, GroupFlight<_>, _>(group, rays, query, hits);
}

with_most_lanes! {
    fn closest_together<F: HitFilter>(group: &TriangleBvh<1>, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) -> () =
        closest_together_in
}

#[inline(always)]
pub(super) fn closest_together_in<L: ManyLanes, F: HitFilter>(
    group: &TriangleBvh<1>,
    rays: &[Ray],
    filter: &F,
    hits: &mut [Option<Hit>],
) {
    ask_together::<L, _>(group, rays, |ray| Closest { ray, filter, nearest: None }, hits);
}

with_most_lanes! {
    fn occluded_together<F: HitFilter>(group: &TriangleBvh<1>, rays: &[Ray], filter: &F, occluded: &mut [bool]) -> () =
        occluded_together_in
}

#[inline(always)]
pub(super) fn occluded_together_in<L: ManyLanes, F: HitFilter>(
    group: &TriangleBvh<1>,
    rays: &[Ray],
    filter: &F,
    occluded: &mut [bool],
) {
    ask_together::<L, _>(group, rays, |ray| Occluded { ray, filter }, occluded);
}

with_widest_lanes! {
    fn closest_each_placed<F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) -> () =
        closest_each_placed_in
}

#[inline(always)]
fn closest_each_placed_in<L: Lanes, F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) {
    take_turns::<L, PlacedFlight<_>, _>(accel, rays, |ray| Closest { ray, filter, nearest: None }, hits);
}

with_widest_lanes! {
    fn occluded_each<F: HitFilter>(group: &TriangleBvh<1>, rays: &[Ray], filter: &F, occluded: &mut [bool]) -> () =
        occluded_each_in
}

#[inline(always)]
fn occluded_each_in<L: Lanes, F: HitFilter>(group: &TriangleBvh<1>, rays: &[Ray], filter: &F, occluded: &mut [bool]) {
    take_turns::<L, GroupFlight<_>, _>(group, rays, |ray| Occluded { ray, filter }, occluded);
}

with_widest_lanes! {
    fn occluded_each_placed<F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, occluded: &mut [bool]) -> () =
        occluded_each_placed_in
}

#[inline(always)]
fn occluded_each_placed_in<L: Lanes, F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, occluded: &mut [bool]) {
    take_turns::<L, PlacedFlight<_>, _>(accel, rays, |ray| Occluded { ray, filter }, occluded);
}

/// What is asked of the triangles along a ray.
pub(super) trait TriangleQuery {
    /// Whether triangles may come in any order, since the ray is never shortened.
    const ANY_ORDER: bool;
    /// What is known in the end.
    type Answer;
    /// Looks at the hits in a block; may shorten the ray. Returning true ends the query.
    fn consider(&mut self, ids: &[u32; BLOCK_SIZE], hits: &BlockHits, placement: u32, t_max: &mut f32) -> bool;
    /// Looks at a sphere in the world likewise.
    fn consider_sphere(&mut self, id: u32, sphere: &Sphere, placement: u32, t_max: &mut f32) -> bool;
    /// The answer of a query that was ended, or of one that has seen all.
    fn answer(&self, is_ended: bool) -> Self::Answer;
}

/// The nearest hit, of several at the same distance that of the triangle with the lowest number, in whatever order they come.
struct Closest<'a, F> {
    ray: &'a Ray,
    filter: &'a F,
    nearest: Option<Hit>,
}

impl<F> Closest<'_, F> {
    /// Whether a hit comes before what is known, which ends at `t_max`.
    #[inline(always)]
    fn is_first(&self, t: f32, triangle: u32, t_max: f32) -> bool {
        t < t_max || t == t_max && self.nearest.is_some_and(|nearest| triangle < nearest.triangle)
    }
}

impl<F: HitFilter> TriangleQuery for Closest<'_, F> {
    const ANY_ORDER: bool = false;
    type Answer = Option<Hit>;

    #[inline(always)]
    fn consider(&mut self, ids: &[u32; BLOCK_SIZE], hits: &BlockHits, placement: u32, t_max: &mut f32) -> bool {
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            let (t, triangle) = (hits.t[lane], ids[lane]);
            if self.is_first(t, triangle, *t_max) {
                let barycentric = hits.barycentric(lane);
                if self.filter.accept(triangle, barycentric, self.ray) {
                    *t_max = t;
                    self.nearest = Some(Hit { t, barycentric, triangle, placement });
                }
            }
        }
        false
    }

    #[inline(never)]
    fn consider_sphere(&mut self, id: u32, sphere: &Sphere, placement: u32, t_max: &mut f32) -> bool {
        let is_first = |t| self.is_first(t, id, *t_max);
        let found = meet_sphere(sphere, self.ray, is_first, |numbers| self.filter.accept(id, numbers, self.ray));
        if let Some((t, barycentric)) = found {
            *t_max = t;
            self.nearest = Some(Hit { t, barycentric, triangle: id, placement });
        }
        false
    }

    #[inline(always)]
    fn answer(&self, _: bool) -> Option<Hit> {
        self.nearest
    }
}

/// Any hit.
struct Occluded<'a, F> {
    ray: &'a Ray,
    filter: &'a F,
}

impl<F: HitFilter> TriangleQuery for Occluded<'_, F> {
    const ANY_ORDER: bool = true;
    type Answer = bool;

    #[inline(always)]
    fn consider(&mut self, ids: &[u32; BLOCK_SIZE], hits: &BlockHits, _: u32, t_max: &mut f32) -> bool {
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            if hits.t[lane] < *t_max && self.filter.accept(ids[lane], hits.barycentric(lane), self.ray) {
                return true;
            }
        }
        false
    }

    #[inline(never)]
    fn consider_sphere(&mut self, id: u32, sphere: &Sphere, _: u32, t_max: &mut f32) -> bool {
        let is_before = |t| t < *t_max;
        meet_sphere(sphere, self.ray, is_before, |numbers| self.filter.accept(id, numbers, self.ray)).is_some()
    }

    #[inline(always)]
    fn answer(&self, is_ended: bool) -> bool {
        is_ended
    }
}

/// Where a ray meets a sphere first that is there, with the numbers that tell the direction from its centre: of the two sides
/// the nearer may have a hole.
fn meet_sphere(
    sphere: &Sphere,
    ray: &Ray,
    is_before: impl Fn(f32) -> bool,
    is_there: impl Fn([f32; 2]) -> bool,
) -> Option<(f32, [f32; 2])> {
    let sides = sphere.sides(Vector::from(ray.origin), Vector::from(ray.direction));
    sides.into_iter().filter(|&t| 0.0 < t && is_before(t)).find_map(|t| {
        let numbers = sphere.numbers(ray.at(t));
        is_there(numbers).then_some((t, numbers))
    })
}

/// Takes a query from the placements into their groups.
struct PlacementVisitor<'a, Q> {
    accel: &'a Accel,
    top: &'a TopLevel,
    ray: &'a Ray,
    query: &'a mut Q,
}

impl<Q: TriangleQuery> LeafVisitor for PlacementVisitor<'_, Q> {
    const ANY_ORDER: bool = Q::ANY_ORDER;

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, leaf: u32, t_max: &mut f32) -> bool {
        for &placement in &self.top.leaves[leaf as usize] {
            let Some(placement) = placement else { break };
            let (group, local) = self.accel.in_group(placement, self.ray);
            if group.traverse::<L, _>(placement, &local, t_max, self.query) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn prefetch(&self, _: u32) {}
}

/// Takes a query from the leaves of a group to their triangles.
pub(super) struct BlockVisitor<'a, Q, const SHAPES: usize> {
    pub(super) blocks: &'a [TriangleBlock<SHAPES>],
    /// How far the time is between two shapes.
    pub(super) part: f32,
    pub(super) sheared: &'a ShearedRay,
    pub(super) placement: u32,
    pub(super) query: &'a mut Q,
}

impl<Q: TriangleQuery, const SHAPES: usize> LeafVisitor for BlockVisitor<'_, Q, SHAPES> {
    const ANY_ORDER: bool = Q::ANY_ORDER;

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, leaf: u32, t_max: &mut f32) -> bool {
        if leaf & SPHERE != 0 {
            let block = &self.blocks[(leaf & !SPHERE) as usize];
            return self.query.consider_sphere(block.ids[0], &block.sphere(), self.placement, t_max);
        }
        let block = &self.blocks[leaf as usize];
        match block.intersect::<L>(self.sheared, self.part, *t_max) {
            Some(hits) => self.query.consider(&block.ids, &hits, self.placement, t_max),
            None => false,
        }
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        prefetch(&self.blocks[(leaf & !SPHERE) as usize]);
    }
}

impl Group {
    /// `ray` is in the group's space; `t_max` is shortened to the nearest hit that the query keeps.
    #[inline(always)]
    fn traverse<L: Lanes, Q: TriangleQuery>(&self, placement: u32, ray: &Ray, t_max: &mut f32, query: &mut Q) -> bool {
        match self {
            Self::Rigid(bvh) => bvh.traverse::<L, _>(placement, ray, 0.0, t_max, query),
            Self::Deforming(parts) => {
                let (index, part) = segment(ray.time, parts.len());
                parts[index].traverse::<L, _>(placement, ray, part, t_max, query)
            }
        }
    }
}

impl<const SHAPES: usize> TriangleBvh<SHAPES> {
    /// `part` is how far the time is between two shapes.
    #[inline(always)]
    fn traverse<L: Lanes, Q: TriangleQuery>(
        &self,
        placement: u32,
        ray: &Ray,
        part: f32,
        t_max: &mut f32,
        query: &mut Q,
    ) -> bool {
        let sheared = ShearedRay::new(ray.origin, ray.direction);
        let mut visitor = BlockVisitor { blocks: &self.blocks, part, sheared: &sheared, placement, query };
        self.bvh.traverse::<L, _>(ray.origin, ray.direction, t_max, &mut visitor)
    }
}
