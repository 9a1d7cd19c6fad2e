//! The strategy for scenes of few primitives: every primitive is tested against as many rays at a time as a register
//! has lanes, which takes less time than to find those that may be in the way of each ray ([`LINEAR_SCAN_MAX`]).
//!
//! The tests are those of [`triangle_block`](super::triangle_block) and [`Quadric`](super::Quadric), operation by
//! operation, so that a ray meets a primitive at the same distance in either way.

mod packet;
mod primitives;
mod query;

use super::accel::HitFilter;
use super::near_hit::near_hit;
use super::triangle_block::{distance_error, double_area};
use super::{Primitive, Ray};
use crate::tuning::{LINEAR_SCAN_BATCH, LINEAR_SCAN_MAX};
use packet::{ByAxis, RayPacket, ShearedVertices};
use photosite_core::math::{Real, Vector};
use photosite_simd::{LaneMask, MAX_LANES, Simd, WideLanes};

pub(super) use primitives::LinearScan;
use primitives::PackedTriangle;
pub(super) use query::{ClosestLanes, LaneQuery, OccludedLanes};

impl LinearScan {
    /// Answers a query about each of several rays.
    #[inline(always)]
    pub(super) fn trace<S: Simd, Q: LaneQuery<S>, F: HitFilter>(
        &self,
        simd: S,
        rays: &[Ray],
        filter: &F,
        answers: &mut [Q::Answer],
    ) {
        let mut sheared = ShearedVertices::none(simd);
        for (rays, answers) in rays.chunks(LINEAR_SCAN_BATCH).zip(answers.chunks_mut(LINEAR_SCAN_BATCH)) {
            // Rays of one axis have the same permutation of coordinates and fill the lanes together.
            let by_axis = ByAxis::new(rays);
            for (axis, members) in by_axis.packets(S::Wide::COUNT) {
                let packet = RayPacket::new(simd, self, rays, members, axis);
                sheared.shear(self, &packet);
                let mut query = Q::new(simd, &packet);
                self.intersect(&sheared, &packet, filter, &mut query);
                query.store(self, &packet, answers);
            }
        }
    }

    /// Intersects a packet with all primitives.
    #[inline(always)]
    fn intersect<S: Simd, Q: LaneQuery<S>, F: HitFilter>(
        &self,
        sheared: &ShearedVertices<S>,
        packet: &RayPacket<'_, S>,
        filter: &F,
        query: &mut Q,
    ) {
        let zero = packet.simd.broadcast_wide(0.0);
        let ([ox, oy, oz], [dx, dy, dz]) = (packet.origin, packet.direction);
        let (origin, direction) = (Vector::new(ox, oy, oz), Vector::new(dx, dy, dz));
        for (index, (id, quadric)) in (self.triangles.len()..).zip(&self.quadrics) {
            // The nearer side first: the query has shortened the rays before the farther one is looked at.
            for t in quadric.intersect(origin, direction) {
                let mut hit = zero.lt(t) & t.lt(query.t_max());
                if !F::ACCEPTS_ALL {
                    hit = hit & packet.accepted_on(filter, quadric, *id, hit.bits(), &t.store_wide());
                }
                if hit.bits() != 0 && query.on_hits(hit, index as u32, t, [zero; 3]) {
                    return;
                }
            }
        }
        for (index, triangle) in self.triangles.iter().enumerate() {
            let [i, j, k] = triangle.vertices;
            // The remainder tells the compiler that the indices are in range.
            let a = sheared.vertices[usize::from(i) % LINEAR_SCAN_MAX];
            let b = sheared.vertices[usize::from(j) % LINEAR_SCAN_MAX];
            let c = sheared.vertices[usize::from(k) % LINEAR_SCAN_MAX];
            // Edge functions: all of one sign where the ray passes inside.
            let (u, v, w) = (double_area(c, b), double_area(a, c), double_area(b, a));
            let (smallest, largest) = (u.min(v).min(w), u.max(v).max(w));
            let scanned = packet.simd.broadcast_wide(index as f32);
            let leaves = scanned.le(packet.from) & packet.from.le(scanned);
            let inside = (zero.le(smallest) | largest.le(zero)) & !leaves;
            let sum = u + v + w;
            let along = u * a[2] + v * b[2] + w * c[2];
            // NaN for a triangle that is seen edge on: no comparison holds.
            let mut t = along / sum;
            let mut hit = inside & zero.lt(t) & t.lt(query.t_max());
            let [mut v, mut w, mut sum] = [v, w, sum];
            // Hits nearer than rounding can tell from 0, or of triangles on which it reaches far, need a closer look. Most
            // triangles have none.
            let sure = if triangle.is_slender { packet.t_max.broadcast(f32::INFINITY) } else { sheared.sure };
            if (inside & along.abs().le(sure)).bits() != 0 {
                let error = distance_error([a, b, c], [u, v, w], sum, packet.inverse_scale);
                let mut near = inside & (-error).le(t);
                if !triangle.is_slender {
                    near = near & t.le(error);
                }
                if near.bits() != 0 {
                    let closer = self.look_closer(triangle, packet, near.bits(), &query.t_max().store_wide());
                    let is_hit = zero.lt(packet.simd.load_wide(&closer.t));
                    hit = hit & !near | is_hit;
                    t = Real::select(is_hit, packet.simd.load_wide(&closer.t), t);
                    v = Real::select(is_hit, packet.simd.load_wide(&closer.weights[0]), v);
                    w = Real::select(is_hit, packet.simd.load_wide(&closer.weights[1]), w);
                    sum = Real::select(is_hit, packet.simd.broadcast_wide(1.0), sum);
                }
            }
            if hit.bits() == 0 {
                continue;
            }
            if !F::ACCEPTS_ALL {
                let uv = [(v / sum).store_wide(), (w / sum).store_wide()];
                let primitive = Primitive::Triangle(triangle.id);
                hit = hit & packet.accepted(filter, primitive, hit.bits(), &uv);
            }
            if query.on_hits(hit, index as u32, t, [v, w, sum]) {
                return;
            }
        }
    }
}

/// Hits decided in double precision: t where there is one, 0 elsewhere, with the weights of the second and third corner.
struct NearHits {
    t: [f32; MAX_LANES],
    weights: [[f32; MAX_LANES]; 2],
}

impl LinearScan {
    /// Decides about lanes that may hit a triangle in double precision.
    #[inline(never)]
    fn look_closer<S: Simd>(
        &self,
        triangle: &PackedTriangle,
        packet: &RayPacket<'_, S>,
        near: u32,
        t_max: &[f32; MAX_LANES],
    ) -> NearHits {
        let corners = triangle.vertices.map(|vertex| self.vertices[usize::from(vertex)]);
        let mut hits = NearHits { t: [0.0; MAX_LANES], weights: [[0.0; MAX_LANES]; 2] };
        for (lane, &member) in packet.members.iter().enumerate().filter(|(lane, _)| near >> lane & 1 != 0) {
            let ray = &packet.rays[usize::from(member)];
            let hit = near_hit(corners, ray.origin, ray.direction).filter(|(t, _)| *t < t_max[lane]);
            let Some((t, [b1, b2])) = hit else { continue };
            (hits.t[lane], hits.weights[0][lane], hits.weights[1][lane]) = (t, b1, b2);
        }
        hits
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::accel_tests::{Numbers, Sieve, geometry, in_world, mixed};
    use crate::geometry::{Accel, AcceptAll};
    use photosite_core::math::warp;
    use photosite_simd::Portable;

    /// A scene without its linear scan.
    fn hierarchy(accel: &Accel) -> Accel {
        let mut accel = accel.clone();
        accel.linear_scan = None;
        accel
    }

    /// Rays in all directions, some of which are short or run along axes, and some of which start in a triangle.
    fn rays(numbers: &mut Numbers, count: usize, triangles: &[[Vec3; 3]]) -> Vec<Ray> {
        let ray = |i: usize| {
            let mut direction = warp::uniform_sphere([numbers.next(), numbers.next()]);
            if i.is_multiple_of(5) {
                direction[i / 5 % 3] = if i.is_multiple_of(2) { 0.0 } else { -0.0 };
            }
            if i.is_multiple_of(7) {
                direction *= 1e3;
            }
            let origin = match i % 4 {
                0 => {
                    let [a, b, c] = triangles[i / 4 % triangles.len()];
                    a * 0.3 + b * 0.3 + c * 0.4
                }
                _ => numbers.point() * 2.0 - 0.5,
            };
            let t_max = if i.is_multiple_of(3) { 0.7 } else { f32::INFINITY };
            Ray { t_max, ..Ray::new(origin, direction) }
        };
        (0..count).map(ray).collect()
    }

    /// Compares the hits found by each set of registers with those of the hierarchy.
    fn compare<F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, what: &str) -> usize {
        let scan = accel.linear_scan.as_ref().expect("few triangles");
        let (mut expected, mut occluded) = (vec![], vec![]);
        hierarchy(accel).closest_each(rays, filter, &mut expected);
        hierarchy(accel).occluded_each(rays, filter, &mut occluded);
        let (mut hits, mut is_occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
        accel.closest_each(rays, filter, &mut hits);
        accel.occluded_each(rays, filter, &mut is_occluded);
        assert_eq!(hits, expected, "{what}, most lanes");
        assert_eq!(is_occluded, occluded, "{what}, most lanes");
        let (mut hits, mut is_occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
        scan.trace::<Portable, ClosestLanes<Portable>, F>(Portable, rays, filter, &mut hits);
        scan.trace::<Portable, OccludedLanes<Portable>, F>(Portable, rays, filter, &mut is_occluded);
        assert_eq!(hits, expected, "{what}, portable");
        assert_eq!(is_occluded, occluded, "{what}, portable");
        expected.iter().flatten().count()
    }

    #[test]
    fn a_linear_scan_hits_what_the_hierarchy_hits() {
        let mut numbers = Numbers(19);
        for (count, scale, offset) in
            [(1, 1.0, 0.0), (16, 1.0, 0.0), (16, 1e-6, 0.0), (16, 1e6, 0.0), (16, 1.0, 1000.0)]
        {
            let triangles: Vec<_> = (0..count)
                .map(|_| {
                    let centre = numbers.point();
                    [0, 1, 2].map(|_| centre + (numbers.point() - 0.5) * 0.8)
                })
                .collect();
            for ray_count in [0, 1, 15, 16, 17, 300, 3000] {
                let mut rays = rays(&mut numbers, ray_count, &triangles);
                for ray in &mut rays {
                    ray.origin = ray.origin * scale + offset;
                    ray.direction *= scale;
                }
                let placed: Vec<_> = triangles.iter().map(|t| t.map(|corner| corner * scale + offset)).collect();
                let accel = in_world(&geometry(&placed));
                let what = format!("{count} triangles, scale {scale}, offset {offset}, {ray_count} rays");
                let hits = compare(&accel, &rays, &AcceptAll, &what);
                assert!(hits > 0 || ray_count < 300, "{what}: {hits} hits");
                compare(&accel, &rays, &Sieve, &format!("{what}, sieve"));
            }
        }
    }

    #[test]
    fn spheres_are_scanned_too() {
        let mut numbers = Numbers(29);
        for (triangles, spheres) in [(8, 3), (0, 5)] {
            let (g, _) = mixed(&mut numbers, triangles, spheres);
            let accel = in_world(&g);
            // Some rays start in a triangle, and some in a sphere.
            let mut corners: Vec<_> = (0..g.triangles.len() as u32).map(|triangle| g.corners(triangle)).collect();
            corners.extend(g.quadrics.iter().map(|placed| [placed.bounds.0, placed.bounds.1, placed.bounds.0]));
            let rays = rays(&mut numbers, 3000, &corners);
            let what = format!("{triangles} triangles, {spheres} spheres");
            let hits = compare(&accel, &rays, &AcceptAll, &what);
            assert!(hits > 100, "{what}: {hits} hits");
            // One side may have a hole where the other has none.
            compare(&accel, &rays, &Patches, &format!("{what}, patches"));
        }
    }

    /// Filter that accepts hits in patches only.
    struct Patches;

    impl HitFilter for Patches {
        fn accept(&self, _: Primitive, [u, v]: [f32; 2], _: &Ray) -> bool {
            (u * 7.0).sin() * (v * 5.0).cos() > 0.0
        }
    }

    #[test]
    fn few_triangles_are_scanned_and_many_are_not() {
        let mut numbers = Numbers(2);
        for (count, is_scanned) in [(16, true), (17, false), (49, false)] {
            let triangles: Vec<_> = (0..count).map(|_| [0, 1, 2].map(|_| numbers.point())).collect();
            assert_eq!(
                in_world(&geometry(&triangles)).linear_scan.is_some(),
                is_scanned,
                "{count} triangles of their own vertices"
            );
        }
        let corner = |i: u32| Vec3::new((i % 2) as f32, (i / 2) as f32, 0.0);
        let strip = |count: u32| (0..count).map(|i| [corner(i), corner(i + 1), corner(i + 2)]).collect::<Vec<_>>();
        assert!(in_world(&geometry(&strip(46))).linear_scan.is_some());
        assert!(in_world(&geometry(&strip(47))).linear_scan.is_none());
    }
}
