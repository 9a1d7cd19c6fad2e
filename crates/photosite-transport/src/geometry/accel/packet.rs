//! Packets: rays that run close together, such as those of a pixel or those to a small light, go through the hierarchy
//! as one. A beam around them finds the boxes that some of them may enter, and each of these boxes is tested against
//! all of them, a ray in each lane. Rays of a camera take half the time that they take alone, or interleaved in a mesh
//! of 1.3 million triangles; whole renders are 1.03 to 1.06 times as fast.

use std::ops::Range;

use super::leaf::Leaf;
use super::query::{Query, RayQuery};
use super::{HitFilter, PrimitiveBvh};
use crate::geometry::Ray;
use crate::geometry::triangle_block::ShearedRay;
use crate::geometry::wide_bvh::Child;
use crate::geometry::wide_node::{SlabPacket, beyond_rounding};
use crate::tuning::{PACKET_MAX_DISTANCE, PACKET_MIN_COSINE_SQUARED};
use photosite_core::math::Real;
use photosite_simd::{LaneMask, MAX_LANES, Simd, WideLanes, prefetch};

/// Rays that are coherent or not together: as many as a packet has on any machine, so that a run is whole packets.
const GROUP: usize = MAX_LANES;

/// Runs of consecutive rays, each with whether they are coherent.
pub(super) fn coherent_runs(bvh: &PrimitiveBvh<1>, rays: &[Ray]) -> impl Iterator<Item = (Range<usize>, bool)> {
    let (low, high) = bvh.bounds;
    let max_distance = (high - low).length() * PACKET_MAX_DISTANCE;
    let mut groups = rays.chunks(GROUP).map(move |rays| are_coherent(rays, max_distance)).peekable();
    let mut start = 0;
    std::iter::from_fn(move || {
        let is_coherent = groups.next()?;
        let mut count = 1;
        while groups.next_if_eq(&is_coherent).is_some() {
            count += 1;
        }
        let run = start..rays.len().min(start + count * GROUP);
        start = run.end;
        Some((run, is_coherent))
    })
}

/// Whether a full group of rays begin near the first of them and run in nearly its direction, none of them along a
/// plane between two axes.
fn are_coherent(rays: &[Ray], max_distance: f32) -> bool {
    let Ray { origin, direction: first, .. } = rays[0];
    let min_squared = PACKET_MIN_COSINE_SQUARED * first.length_squared();
    let is_close = |ray: &Ray| {
        let along = ray.direction.dot(first);
        along > 0.0
            && along * along > min_squared * ray.direction.length_squared()
            && ray.direction.is_negative_bitmask() == first.is_negative_bitmask()
            && ray.direction.abs().min_element() >= f32::MIN_POSITIVE
            && (ray.origin - origin).abs().max_element() <= max_distance
    };
    rays.len() == GROUP && rays.iter().all(is_close)
}

/// Answers a query about each of several coherent rays.
#[inline(always)]
pub(super) fn trace_packets<'a, S: Simd, Q: RayQuery<'a, F>, F: HitFilter>(
    simd: S,
    bvh: &PrimitiveBvh<1>,
    rays: &'a [Ray],
    filter: &'a F,
    answers: &mut [Q::Answer],
) {
    let mut packet = Packet::<S, Q>::empty(simd);
    for (rays, answers) in rays.chunks(S::Wide::COUNT).zip(answers.chunks_mut(S::Wide::COUNT)) {
        packet.start(rays, filter);
        while packet.step(bvh) {}
        for (answer, (query, has_ended)) in answers.iter_mut().zip(packet.queries.iter().flatten()) {
            *answer = query.answer(*has_ended);
        }
    }
}

/// Traversal state of a packet.
struct Packet<S: Simd, Q> {
    simd: S,
    slabs: SlabPacket<S>,
    sheared: [ShearedRay; MAX_LANES],
    /// The query of each ray, and whether it has ended.
    queries: [Option<(Q, bool)>; MAX_LANES],
    /// Parameter t at which each ray ends; negative where its query has ended.
    t_max: [f32; MAX_LANES],
    /// Children to visit, the next one last.
    stack: Vec<Visit>,
}

/// A child that some rays enter.
#[derive(Clone, Copy)]
struct Visit {
    child: Child,
    /// A bit for each of the rays.
    rays: u32,
    /// Parameter t at which each ray enters the box.
    near: [f32; MAX_LANES],
    /// Parameter t at which the first active ray enters the box: children of a node are visited in this order.
    order: f32,
}

impl<S: Simd, Q: Query> Packet<S, Q> {
    fn empty(simd: S) -> Self {
        Self {
            simd,
            slabs: SlabPacket::none(simd),
            sheared: [ShearedRay::NONE; MAX_LANES],
            queries: [const { None }; MAX_LANES],
            t_max: [-1.0; MAX_LANES],
            stack: Vec::with_capacity(64),
        }
    }

    /// Begins at the root with a ray for each lane.
    #[inline(always)]
    fn start<'a, F: HitFilter>(&mut self, rays: &'a [Ray], filter: &'a F)
    where
        Q: RayQuery<'a, F>,
    {
        self.slabs = SlabPacket::new(self.simd, rays);
        for (lane, ray) in rays.iter().enumerate() {
            self.sheared[lane] = ShearedRay::new(ray, 0);
            self.queries[lane] = Some((Q::new(ray, filter), false));
            self.t_max[lane] = ray.t_max;
        }
        self.stack.push(Visit {
            child: Child::ROOT,
            rays: u32::MAX >> (32 - S::Wide::COUNT),
            near: [0.0; MAX_LANES],
            order: 0.0,
        });
    }

    /// Visits the next node or leaf; returns whether there was one.
    #[inline(always)]
    fn step(&mut self, bvh: &PrimitiveBvh<1>) -> bool {
        let reach = beyond_rounding(self.simd.load_wide(&self.t_max));
        while let Some(Visit { child, rays, near, .. }) = self.stack.pop() {
            // Rays that have been shortened since no longer enter it.
            let rays = rays & self.simd.load_wide(&near).le(reach).bits();
            if rays == 0 {
                continue;
            }
            match child.leaf() {
                Some(leaf) => self.visit_leaf(bvh, leaf, rays),
                None => self.visit_node(bvh, child, rays, reach),
            }
            return true;
        }
        false
    }

    /// Tests the triangles of a leaf against one ray after the other: eight triangles fill the lanes.
    #[inline(always)]
    fn visit_leaf(&mut self, bvh: &PrimitiveBvh<1>, leaf: u32, mut rays: u32) {
        let leaf = Leaf::of_number(leaf);
        while rays != 0 {
            let lane = rays.trailing_zeros() as usize % MAX_LANES;
            rays &= rays - 1;
            let Some((query, has_ended)) = &mut self.queries[lane] else { continue };
            let t_max = &mut self.t_max[lane];
            match leaf {
                Leaf::Triangles(block) => {
                    let block = &bvh.blocks[block as usize];
                    if let Some(hits) = block.intersect(self.simd, &self.sheared[lane], 0.0, *t_max) {
                        *has_ended = query.on_hits(&block.ids, &hits, 0, t_max);
                    }
                }
                Leaf::Quadric(quadric) => {
                    let (id, quadric) = &bvh.quadrics[quadric as usize];
                    *has_ended = query.on_quadric(*id, quadric, 0, t_max);
                }
            }
            if *has_ended {
                *t_max = -1.0;
            }
        }
    }

    /// Finds the children that the rays enter and puts them on the stack, the nearest last.
    #[inline(always)]
    fn visit_node(&mut self, bvh: &PrimitiveBvh<1>, node: Child, rays: u32, reach: S::Wide) {
        let node = bvh.bvh.node(node);
        let first = rays.trailing_zeros() as usize % MAX_LANES;
        let children = self.stack.len();
        // Eight children at a time against the beam, then each that it enters against all rays.
        let mut slots = node.enter_any(self.simd, &self.slabs);
        while slots != 0 {
            let slot = slots.trailing_zeros() as usize;
            slots &= slots - 1;
            let (entering, near) = node.enter_slot(self.simd, slot, &self.slabs, reach);
            let rays = entering & rays;
            if rays != 0 {
                let near = near.store_wide();
                let (child, order) = (Child(node.children[slot]), near[first]);
                match child.leaf() {
                    Some(leaf) => bvh.prefetch(leaf),
                    None => prefetch(bvh.bvh.node(child)),
                }
                let position = self.stack[children..].partition_point(|other| other.order >= order);
                self.stack.insert(children + position, Visit { child, rays, near, order });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::accel::query::{Closest, Occluded};
    use crate::geometry::accel_tests::{Numbers, Sieve, geometry, in_world, mixed};
    use crate::geometry::{Accel, AcceptAll, HitFilter};
    use photosite_simd::Portable;

    /// Rays of pixels that look at the unit cube, in groups of sixteen; every seventh group goes in all directions.
    fn rays(numbers: &mut Numbers, count: usize) -> Vec<Ray> {
        let mut ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let next = |i: usize| {
            let (group, is_wild) = (i / GROUP, i / GROUP % 7 == 6);
            if i.is_multiple_of(GROUP) {
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

    /// Compares the hits of packets with those of each ray alone.
    fn compare<F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, what: &str) -> usize {
        let alone: Vec<_> = rays.iter().map(|ray| accel.closest(ray, filter)).collect();
        let is_occluded: Vec<_> = rays.iter().map(|ray| accel.occluded(ray, filter)).collect();
        let (mut hits, mut occluded) = (vec![], vec![]);
        accel.closest_each(rays, filter, &mut hits);
        accel.occluded_each(rays, filter, &mut occluded);
        assert_eq!(hits, alone, "{what}");
        assert_eq!(occluded, is_occluded, "{what}");
        let bvh = accel.single_bvh().expect("one hierarchy");
        for (run, _) in coherent_runs(bvh, rays).filter(|&(_, is_close)| is_close) {
            let (alone, is_occluded) = (&alone[run.clone()], &is_occluded[run.clone()]);
            let (mut hits, mut occluded) = (vec![None; run.len()], vec![false; run.len()]);
            trace_packets::<_, Closest<_>, F>(Portable, bvh, &rays[run.clone()], filter, &mut hits);
            trace_packets::<_, Occluded<_>, F>(Portable, bvh, &rays[run], filter, &mut occluded);
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
                let bvh = accel.single_bvh().expect("one hierarchy");
                let close: usize =
                    coherent_runs(bvh, &rays).filter(|(_, is_close)| *is_close).map(|(run, _)| run.len()).sum();
                let is_mixed = (1000..4500).contains(&close) && hits > 1000;
                assert!(count < 5000 || is_mixed, "{what}: {close} close of {count}, {hits} hits");
            }
        }
    }

    #[test]
    fn runs_are_all_rays_in_their_order() {
        let accel = in_world(&geometry(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]));
        let bvh = accel.single_bvh().expect("one hierarchy");
        let along = |direction: Vec3| vec![Ray::new(Vec3::ZERO, direction); GROUP];
        let (forward, right) = (Vec3::new(0.1, 0.2, 1.0), Vec3::new(1.0, 0.2, 0.1));
        let (mut wild, mut elsewhere) = (along(forward), along(forward));
        wild[7].direction = right;
        elsewhere[9].origin.y = 0.5;
        let mut through_zero = along(Vec3::new(1e-4, 1.0, 1.0));
        through_zero[3].direction.x = -1e-4;
        let all =
            [along(forward), along(right), wild, elsewhere, along(Vec3::X), through_zero, along(-forward)].concat();
        let found: Vec<_> = coherent_runs(bvh, &all[..all.len() - 1]).collect();
        assert_eq!(found, [(0..32, true), (32..111, false)]);
        assert_eq!(coherent_runs(bvh, &all).last(), Some((96..112, true)));
        assert_eq!(coherent_runs(bvh, &[]).next(), None);
    }
}
