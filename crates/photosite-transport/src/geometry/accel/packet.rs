//! Rays that run close together, such as those of a pixel or those to a small lamp, go through the hierarchy as one: a beam
//! around them finds the boxes that some of them may enter, and each of these is shown to all of them, a ray in each lane. Rays
//! of a camera take half the time that they take alone, or in turns in a mesh of 1.3 million triangles.

use std::ops::Range;

use super::TriangleBvh;
use super::query::{SPHERE, TriangleQuery};
use crate::geometry::Ray;
use crate::geometry::triangle_block::ShearedRay;
use crate::geometry::wide_bvh::Child;
use crate::geometry::wide_node::{SlabPacket, beyond_rounding};
use photosite_simd::{LaneMask, MOST_LANES, ManyLanes, prefetch};

/// Rays that are looked at together.
const TOGETHER: usize = MOST_LANES;

/// How far from the first they may begin, as a part of the diagonal of the group.
const NEAR: f32 = 0.01;

/// Consecutive rays that run close together through the group, or do not, with whether they do.
pub(super) fn runs(group: &TriangleBvh<1>, rays: &[Ray]) -> impl Iterator<Item = (Range<usize>, bool)> {
    let (low, high) = group.bounds;
    let near = (high - low).length() * NEAR;
    let mut all = rays.chunks(TOGETHER).map(move |rays| run_together(rays, near)).peekable();
    let mut start = 0;
    std::iter::from_fn(move || {
        let is_close = all.next()?;
        let mut chunks = 1;
        while all.next_if_eq(&is_close).is_some() {
            chunks += 1;
        }
        let run = start..rays.len().min(start + chunks * TOGETHER);
        start = run.end;
        Some((run, is_close))
    })
}

/// Whether so many rays begin near the first, within a cube of twice that size, and run within a degree of it, none of them
/// along a plane between two axes.
fn run_together(rays: &[Ray], near: f32) -> bool {
    /// Square of the cosine of a degree. In fine meshes rays that are farther from each other soon go ways of their own, and
    /// take less time in turns: through 10 million triangles half of it, where the first of sixteen is 2° from the last.
    const LEAST: f32 = 0.9997;
    let Ray { origin, direction: first, .. } = rays[0];
    let least = LEAST * first.length_squared();
    let is_close = |ray: &Ray| {
        let along = ray.direction.dot(first);
        along > 0.0
            && along * along > least * ray.direction.length_squared()
            && ray.direction.is_negative_bitmask() == first.is_negative_bitmask()
            && ray.direction.abs().min_element() >= f32::MIN_POSITIVE
            && (ray.origin - origin).abs().max_element() <= near
    };
    rays.len() == TOGETHER && rays.iter().all(is_close)
}

/// Asks of rays that run close together, with a query of its own for each.
#[inline(always)]
pub(super) fn ask_together<'a, L: ManyLanes, Q: TriangleQuery>(
    group: &TriangleBvh<1>,
    rays: &'a [Ray],
    query: impl Fn(&'a Ray) -> Q,
    answers: &mut [Q::Answer],
) {
    let mut packet = Packet::<L, Q>::empty();
    for (rays, answers) in rays.chunks(L::COUNT).zip(answers.chunks_mut(L::COUNT)) {
        packet.start(rays, &query);
        while packet.step(group) {}
        for (answer, (query, is_ended)) in answers.iter_mut().zip(packet.queries.iter().flatten()) {
            *answer = query.answer(*is_ended);
        }
    }
}

/// Rays on their way.
struct Packet<L, Q> {
    slabs: SlabPacket<L>,
    sheared: [ShearedRay; MOST_LANES],
    /// What is asked along each, and whether that has ended.
    queries: [Option<(Q, bool)>; MOST_LANES],
    /// Where each ends; below 0 where its query has ended.
    t_max: [f32; MOST_LANES],
    /// What they have yet to visit, the next one last.
    stack: Vec<Visit>,
}

/// A child that some rays enter.
#[derive(Clone, Copy)]
struct Visit {
    child: Child,
    /// Which rays do.
    rays: u32,
    /// Where each of them does.
    near: [f32; MOST_LANES],
    /// Where the first of all that entered the node does, by which its children are in order.
    order: f32,
}

impl<L: ManyLanes, Q: TriangleQuery> Packet<L, Q> {
    fn empty() -> Self {
        Self {
            slabs: SlabPacket::nothing(),
            sheared: [ShearedRay::NONE; MOST_LANES],
            queries: [const { None }; MOST_LANES],
            t_max: [-1.0; MOST_LANES],
            stack: Vec::with_capacity(64),
        }
    }

    /// Begins with a ray for each lane.
    #[inline(always)]
    fn start<'a>(&mut self, rays: &'a [Ray], query: &impl Fn(&'a Ray) -> Q) {
        self.slabs = SlabPacket::new(rays);
        for (lane, ray) in rays.iter().enumerate() {
            self.sheared[lane] = ShearedRay::new(ray.origin, ray.direction);
            self.queries[lane] = Some((query(ray), false));
            self.t_max[lane] = ray.t_max;
        }
        self.stack.push(Visit {
            child: Child::ROOT,
            rays: u32::MAX >> (32 - L::COUNT),
            near: [0.0; MOST_LANES],
            order: 0.0,
        });
    }

    /// Visits the next node or leaf; returns whether there was one.
    #[inline(always)]
    fn step(&mut self, group: &TriangleBvh<1>) -> bool {
        let t_max = L::load_many(&self.t_max);
        let reach = beyond_rounding(t_max);
        while let Some(Visit { child, rays, near, .. }) = self.stack.pop() {
            let rays = rays & L::load_many(&near).is_at_most(reach).bits();
            if rays == 0 {
                continue;
            }
            match child.leaf() {
                Some(leaf) => self.visit_leaf(group, leaf, rays),
                None => self.visit_node(group, child, rays, reach),
            }
            return true;
        }
        false
    }

    #[inline(always)]
    fn visit_leaf(&mut self, group: &TriangleBvh<1>, leaf: u32, mut rays: u32) {
        let block = &group.blocks[(leaf & !SPHERE) as usize];
        while rays != 0 {
            let lane = rays.trailing_zeros() as usize % MOST_LANES;
            rays &= rays - 1;
            let Some((query, is_ended)) = &mut self.queries[lane] else { continue };
            let t_max = &mut self.t_max[lane];
            if leaf & SPHERE != 0 {
                *is_ended = query.consider_sphere(block.ids[0], &block.sphere(), 0, t_max);
            } else if let Some(hits) = block.intersect::<L::Eight>(&self.sheared[lane], 0.0, *t_max) {
                *is_ended = query.consider(&block.ids, &hits, 0, t_max);
            }
            if *is_ended {
                *t_max = -1.0;
            }
        }
    }

    #[inline(always)]
    fn visit_node(&mut self, group: &TriangleBvh<1>, node: Child, rays: u32, reach: L) {
        let node = group.bvh.node(node);
        let first = rays.trailing_zeros() as usize % MOST_LANES;
        let children = self.stack.len();
        let mut slots = node.enter_any(&self.slabs);
        while slots != 0 {
            let slot = slots.trailing_zeros() as usize;
            slots &= slots - 1;
            let (entering, near) = node.enter_slot(slot, &self.slabs, reach);
            let rays = entering & rays;
            if rays != 0 {
                let near = near.store_many();
                let (child, order) = (Child(node.children[slot]), near[first]);
                match child.leaf() {
                    Some(leaf) => prefetch(&group.blocks[(leaf & !SPHERE) as usize]),
                    None => prefetch(group.bvh.node(child)),
                }
                let place = self.stack[children..].partition_point(|other| other.order >= order);
                self.stack.insert(children + place, Visit { child, rays, near, order });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::accel::query::{closest_together_in, occluded_together_in};
    use crate::geometry::accel_tests::{Numbers, Sieve, geometry, in_world, mixed};
    use crate::geometry::{Accel, AcceptAll, HitFilter};
    use photosite_simd::Portable;

    /// Rays of pixels that look at the unit cube, in groups of sixteen; every seventh group goes in all directions.
    fn rays(numbers: &mut Numbers, count: usize) -> Vec<Ray> {
        let mut ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let next = |i: usize| {
            let (group, is_wild) = (i / TOGETHER, i / TOGETHER % 7 == 6);
            if i.is_multiple_of(TOGETHER) {
                ray.origin = numbers.point() * 5.0 - 2.0;
                ray.direction = numbers.point() - ray.origin;
                // Along a plane between axes.
                if group % 5 == 4 {
                    ray.direction[group % 3] = 0.0;
                }
            }
            let spread = if is_wild { 2.0 } else { 0.008 * (group % 4) as f32 };
            let jitter = |numbers: &mut Numbers| (numbers.point() - 0.5) * spread;
            let origin = ray.origin + jitter(numbers) * 0.1;
            let direction = ray.direction * (1.0 + numbers.next()) + jitter(numbers);
            Ray { t_max: if i.is_multiple_of(3) { 0.6 } else { f32::INFINITY }, ..Ray::new(origin, direction) }
        };
        (0..count).map(next).collect()
    }

    /// What packets find of all lanes, and what each ray does alone.
    fn compare<F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, what: &str) -> usize {
        let alone: Vec<_> = rays.iter().map(|ray| accel.closest(ray, filter)).collect();
        let is_occluded: Vec<_> = rays.iter().map(|ray| accel.occluded(ray, filter)).collect();
        let (mut hits, mut occluded) = (vec![], vec![]);
        accel.closest_each(rays, filter, &mut hits);
        accel.occluded_each(rays, filter, &mut occluded);
        assert_eq!(hits, alone, "{what}");
        assert_eq!(occluded, is_occluded, "{what}");
        let group = accel.alone().expect("one group");
        for (run, _) in runs(group, rays).filter(|&(_, is_close)| is_close) {
            let (alone, is_occluded) = (&alone[run.clone()], &is_occluded[run.clone()]);
            let (mut hits, mut occluded) = (vec![None; run.len()], vec![false; run.len()]);
            closest_together_in::<Portable, F>(group, &rays[run.clone()], filter, &mut hits);
            occluded_together_in::<Portable, F>(group, &rays[run], filter, &mut occluded);
            assert_eq!(hits, alone, "{what}, portable");
            assert_eq!(occluded, is_occluded, "{what}, portable");
        }
        alone.iter().flatten().count()
    }

    #[test]
    fn rays_that_run_close_together_meet_what_each_meets_alone() {
        let mut numbers = Numbers(31);
        // Every triangle twice: which of them is met must not depend on the rays beside.
        let mut soup: Vec<_> = (0..600)
            .map(|_| {
                let centre = numbers.point();
                [0, 1, 2].map(|_| centre + (numbers.point() - 0.5) * 0.2)
            })
            .collect();
        soup.extend_from_within(..);
        let (with_spheres, _) = mixed(&mut numbers, 400, 60);
        for (what, accel) in [("twice", in_world(&geometry(&soup))), ("with spheres", in_world(&with_spheres))] {
            for count in [0, 1, 15, 16, 17, 100, 5000] {
                let rays = rays(&mut numbers, count);
                let hits = compare(&accel, &rays, &AcceptAll, what);
                compare(&accel, &rays, &Sieve, what);
                let group = accel.alone().expect("one group");
                let close: usize = runs(group, &rays).filter(|(_, is_close)| *is_close).map(|(run, _)| run.len()).sum();
                let is_mixed = (1000..4500).contains(&close) && hits > 1000;
                assert!(count < 5000 || is_mixed, "{what}: {close} close of {count}, {hits} hits");
            }
        }
    }

    #[test]
    fn runs_are_all_rays_in_their_order() {
        let accel = in_world(&geometry(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]));
        let group = accel.alone().expect("one group");
        let along = |direction: Vec3| vec![Ray::new(Vec3::ZERO, direction); TOGETHER];
        let (forward, right) = (Vec3::new(0.1, 0.2, 1.0), Vec3::new(1.0, 0.2, 0.1));
        let (mut wild, mut elsewhere) = (along(forward), along(forward));
        wild[7].direction = right;
        elsewhere[9].origin.y = 0.5;
        let mut through_zero = along(Vec3::new(1e-4, 1.0, 1.0));
        through_zero[3].direction.x = -1e-4;
        let all =
            [along(forward), along(right), wild, elsewhere, along(Vec3::X), through_zero, along(-forward)].concat();
        let found: Vec<_> = runs(group, &all[..all.len() - 1]).collect();
        assert_eq!(found, [(0..32, true), (32..111, false)]);
        assert_eq!(runs(group, &all).last(), Some((96..112, true)));
        assert_eq!(runs(group, &[]).next(), None);
    }
}
