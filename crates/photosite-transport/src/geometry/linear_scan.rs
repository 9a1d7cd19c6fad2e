//! The strategy for scenes of few primitives: every primitive is tested against as many rays at a time as a register
//! has lanes, which takes less time than to find those that may be in the way of each ray ([`LINEAR_SCAN_MAX`]).
//!
//! The tests are those of [`triangle_block`](super::triangle_block) and [`Quadric`], operation by operation, so that a
//! ray meets a primitive at the same distance in either way.

use glam::Vec3;

use super::accel::HitFilter;
use super::bounds::Bounds;
use super::triangle_block::{distance_error, double_area, error_of_sum, longest_axis};
use super::{Geometry, Hit, Primitive, PrimitiveRange, Quadric, Ray};
use crate::tuning::{LINEAR_SCAN_BATCH, LINEAR_SCAN_MAX};
use photosite_core::math::{Real, Vector};
use photosite_simd::{IdLanes, LaneMask, MAX_LANES, Simd, WideLanes};

/// All primitives of a small scene.
#[derive(Clone, Debug)]
pub(super) struct LinearScan {
    /// Each once.
    vertices: Vec<Vec3>,
    triangles: Vec<PackedTriangle>,
    /// With their indices in the geometry.
    quadrics: Vec<(u32, Quadric)>,
    bounds: Bounds,
}

/// A triangle by the indices of its vertices.
#[derive(Clone, Copy, Debug)]
struct PackedTriangle {
    vertices: [u8; 3],
    /// Index in the geometry.
    id: u32,
}

/// The primitive of a lane that has no hit.
const NONE: u32 = u32::MAX;

impl LinearScan {
    /// Of a range of primitives, all within `bounds`; `None` where they are too many.
    pub(super) fn new(geometry: &Geometry, range: &PrimitiveRange, bounds: Bounds) -> Option<Self> {
        if range.len() > LINEAR_SCAN_MAX {
            return None;
        }
        let mut scan = Self { vertices: Vec::new(), triangles: Vec::new(), quadrics: Vec::new(), bounds };
        let quadric = |id: u32| (id, geometry.quadrics[id as usize].quadric);
        scan.quadrics.extend(range.quadrics.clone().map(quadric));
        for id in range.triangles.clone() {
            let mut index = |corner: Vec3| {
                let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
                let known = scan.vertices.iter().position(|vertex| bits(vertex) == bits(&corner));
                known.unwrap_or_else(|| {
                    scan.vertices.push(corner);
                    scan.vertices.len() - 1
                }) as u8
            };
            let vertices = geometry.corners(id).map(&mut index);
            scan.triangles.push(PackedTriangle { vertices, id });
        }
        (scan.vertices.len() <= LINEAR_SCAN_MAX).then_some(scan)
    }

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
                let packet = RayPacket::new(simd, rays, members, axis);
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
            let inside = zero.le(smallest) | largest.le(zero);
            let sum = u + v + w;
            let along = u * a[2] + v * b[2] + w * c[2];
            // NaN for a triangle that is seen edge on: no comparison holds.
            let t = along / sum;
            let mut hit = inside & zero.lt(t) & t.lt(query.t_max());
            if hit.bits() == 0 {
                continue;
            }
            // Hits nearer than rounding can tell from 0 are those of the surface that the ray leaves. Most need no
            // closer look.
            if (hit & !sheared.sure.lt(along.abs())).bits() != 0 {
                hit = hit & distance_error([a, b, c], [u, v, w], sum, packet.inverse_scale).lt(t);
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

/// A query about a ray in each lane.
pub(super) trait LaneQuery<S: Simd> {
    /// The result for one ray.
    type Answer;

    /// Begins with no hits.
    fn new(simd: S, packet: &RayPacket<'_, S>) -> Self;
    /// Where the rays end.
    fn t_max(&self) -> S::Wide;
    /// Takes the hits of a primitive, with the weights of a triangle's second and third corner and what to divide them
    /// by. Returns whether all rays have their answer.
    fn on_hits(&mut self, hit: Mask<S>, primitive: u32, t: S::Wide, weights: [S::Wide; 3]) -> bool;
    /// Writes the result of each ray.
    fn store(&self, scan: &LinearScan, packet: &RayPacket<'_, S>, answers: &mut [Self::Answer]);
}

type Mask<S> = <<S as Simd>::Wide as Real>::Mask;

/// The nearest hits.
pub(super) struct ClosestLanes<S: Simd> {
    simd: S,
    nearest: S::Wide,
    weights: [S::Wide; 3],
    /// Index of the primitive: the triangles of the scan, then its quadrics.
    primitive: <S::Wide as WideLanes>::Ids,
}

impl<S: Simd> LaneQuery<S> for ClosestLanes<S> {
    type Answer = Option<Hit>;

    #[inline(always)]
    fn new(simd: S, packet: &RayPacket<'_, S>) -> Self {
        let weights = [simd.broadcast_wide(0.0); 3];
        Self { simd, nearest: packet.t_max, weights, primitive: simd.broadcast_id(NONE) }
    }

    #[inline(always)]
    fn t_max(&self) -> S::Wide {
        self.nearest
    }

    #[inline(always)]
    fn on_hits(&mut self, hit: Mask<S>, primitive: u32, t: S::Wide, weights: [S::Wide; 3]) -> bool {
        self.nearest = Real::select(hit, t, self.nearest);
        self.primitive = IdLanes::select(hit, self.simd.broadcast_id(primitive), self.primitive);
        for (own, weight) in self.weights.iter_mut().zip(weights) {
            *own = Real::select(hit, weight, *own);
        }
        false
    }

    #[inline(always)]
    fn store(&self, scan: &LinearScan, packet: &RayPacket<'_, S>, answers: &mut [Option<Hit>]) {
        let [v, w, sum] = self.weights;
        let (t, b1, b2) = (self.nearest.store_wide(), (v / sum).store_wide(), (w / sum).store_wide());
        let primitives = self.primitive.store_wide();
        for (lane, &member) in packet.members.iter().enumerate() {
            let (index, t) = (primitives[lane] as usize, t[lane]);
            let hit = match scan.triangles.get(index) {
                Some(triangle) => Some((Primitive::Triangle(triangle.id), [b1[lane], b2[lane]])),
                None => scan.quadrics.get(index.wrapping_sub(scan.triangles.len())).map(|(id, quadric)| {
                    let point = packet.rays[usize::from(member)].at(t);
                    (Primitive::Quadric(*id), quadric.uv(point))
                }),
            };
            if let Some((primitive, uv)) = hit {
                answers[usize::from(member)] = Some(Hit { t, uv, primitive, instance: 0 });
            }
        }
    }
}

/// Whether there are any hits.
pub(super) struct OccludedLanes<S: Simd> {
    t_max: S::Wide,
    /// Lanes that have a hit.
    occluded: u32,
    /// Lanes with rays of their own.
    active: u32,
}

impl<S: Simd> LaneQuery<S> for OccludedLanes<S> {
    type Answer = bool;

    #[inline(always)]
    fn new(_: S, packet: &RayPacket<'_, S>) -> Self {
        Self { t_max: packet.t_max, occluded: 0, active: u32::MAX >> (32 - packet.members.len()) }
    }

    #[inline(always)]
    fn t_max(&self) -> S::Wide {
        self.t_max
    }

    #[inline(always)]
    fn on_hits(&mut self, hit: Mask<S>, _: u32, _: S::Wide, _: [S::Wide; 3]) -> bool {
        self.occluded |= hit.bits();
        self.occluded & self.active == self.active
    }

    #[inline(always)]
    fn store(&self, _: &LinearScan, packet: &RayPacket<'_, S>, answers: &mut [bool]) {
        for (lane, &member) in packet.members.iter().enumerate() {
            answers[usize::from(member)] = self.occluded >> lane & 1 != 0;
        }
    }
}

/// The indices of rays, at most [`LINEAR_SCAN_BATCH`], by the axis along which their direction is longest.
struct ByAxis {
    indices: [[u8; LINEAR_SCAN_BATCH]; 3],
    counts: [usize; 3],
}

impl ByAxis {
    #[inline(always)]
    fn new(rays: &[Ray]) -> Self {
        let mut sorted = Self { indices: [[0; LINEAR_SCAN_BATCH]; 3], counts: [0; 3] };
        for (index, ray) in rays.iter().enumerate() {
            let axis = longest_axis(ray.direction);
            sorted.indices[axis][sorted.counts[axis]] = index as u8;
            sorted.counts[axis] += 1;
        }
        sorted
    }

    /// Rays of one axis, at most `size` at a time, with the axis.
    #[inline(always)]
    fn packets(&self, size: usize) -> impl Iterator<Item = (usize, &[u8])> {
        let lists = self.indices.iter().zip(self.counts).enumerate();
        lists
            .flat_map(move |(axis, (indices, count))| indices[..count].chunks(size).map(move |members| (axis, members)))
    }
}

/// Rays of one axis, one in each lane.
pub(super) struct RayPacket<'a, S: Simd> {
    simd: S,
    rays: &'a [Ray],
    /// Indices of the rays in the first lanes. The others hold copies of the first ray.
    members: &'a [u8],
    origin: [S::Wide; 3],
    direction: [S::Wide; 3],
    /// The axes that become x, y and z of the sheared space.
    axes: [usize; 3],
    shear: [S::Wide; 3],
    /// |1/shear z|.
    inverse_scale: S::Wide,
    t_max: S::Wide,
}

impl<'a, S: Simd> RayPacket<'a, S> {
    #[inline(always)]
    fn new(simd: S, rays: &'a [Ray], members: &'a [u8], kz: usize) -> Self {
        let mut columns = [[0.0; MAX_LANES]; 7];
        for lane in 0..S::Wide::COUNT {
            let Ray { origin, direction, t_max, .. } = &rays[usize::from(*members.get(lane).unwrap_or(&members[0]))];
            columns[0][lane] = origin.x;
            columns[1][lane] = origin.y;
            columns[2][lane] = origin.z;
            columns[3][lane] = direction.x;
            columns[4][lane] = direction.y;
            columns[5][lane] = direction.z;
            columns[6][lane] = *t_max;
        }
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let direction = [simd.load_wide(&columns[3]), simd.load_wide(&columns[4]), simd.load_wide(&columns[5])];
        let one = simd.broadcast_wide(1.0);
        let scale = one / direction[kz];
        Self {
            simd,
            rays,
            members,
            origin: [simd.load_wide(&columns[0]), simd.load_wide(&columns[1]), simd.load_wide(&columns[2])],
            direction,
            axes: [kx, ky, kz],
            shear: [direction[kx] * scale, direction[ky] * scale, scale],
            inverse_scale: one / scale.abs(),
            t_max: simd.load_wide(&columns[6]),
        }
    }

    /// Lanes of `hit` in which `filter` accepts the hit of a quadric at t.
    #[inline(always)]
    fn accepted_on<F: HitFilter>(
        &self,
        filter: &F,
        quadric: &Quadric,
        id: u32,
        hit: u32,
        t: &[f32; MAX_LANES],
    ) -> Mask<S> {
        let mut uv = [[0.0; MAX_LANES]; 2];
        for (lane, &member) in self.members.iter().enumerate() {
            [uv[0][lane], uv[1][lane]] = quadric.uv(self.rays[usize::from(member)].at(t[lane]));
        }
        self.accepted(filter, Primitive::Quadric(id), hit, &uv)
    }

    /// Lanes of `hit` in which `filter` accepts a hit.
    #[inline(always)]
    fn accepted<F: HitFilter>(
        &self,
        filter: &F,
        primitive: Primitive,
        hit: u32,
        [u, v]: &[[f32; MAX_LANES]; 2],
    ) -> Mask<S> {
        let mut accepted = [0.0; MAX_LANES];
        for (lane, &member) in self.members.iter().enumerate() {
            let is_hit = hit >> lane & 1 != 0;
            if is_hit && filter.accept(primitive, [u[lane], v[lane]], &self.rays[usize::from(member)]) {
                accepted[lane] = 1.0;
            }
        }
        self.simd.broadcast_wide(0.0).lt(self.simd.load_wide(&accepted))
    }
}

/// The vertices of a scan as a packet of rays sees them.
struct ShearedVertices<S: Simd> {
    vertices: [[S::Wide; 3]; LINEAR_SCAN_MAX],
    /// Hits with a larger t·|sum| are farther than twice their rounding error.
    sure: S::Wide,
}

impl<S: Simd> ShearedVertices<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        let zero = simd.broadcast_wide(0.0);
        Self { vertices: [[zero; 3]; LINEAR_SCAN_MAX], sure: zero }
    }

    /// Shears all vertices so that each ray of a packet runs along z.
    #[inline(always)]
    fn shear(&mut self, scan: &LinearScan, packet: &RayPacket<'_, S>) {
        let simd = packet.simd;
        let [kx, ky, kz] = packet.axes;
        let [sx, sy, sz] = packet.shear;
        for (sheared, vertex) in self.vertices.iter_mut().zip(&scan.vertices) {
            let x = simd.broadcast_wide(vertex[kx]) - packet.origin[kx];
            let y = simd.broadcast_wide(vertex[ky]) - packet.origin[ky];
            let z = simd.broadcast_wide(vertex[kz]) - packet.origin[kz];
            *sheared = [x - sx * z, y - sy * z, sz * z];
        }
        // The largest distance of a vertex from an origin along any axis.
        let (low, high) = scan.bounds;
        let mut reach = simd.broadcast_wide(0.0);
        for axis in 0..3 {
            let origin = packet.origin[axis];
            let (to_low, to_high) = (simd.broadcast_wide(low[axis]) - origin, simd.broadcast_wide(high[axis]) - origin);
            reach = reach.max(to_low.abs()).max(to_high.abs());
        }
        // Shears are at most 1. What is beyond that pays for roundings.
        let two = simd.broadcast_wide(2.01);
        let across = reach * two;
        let largest = [across, across, reach * sz.abs() * simd.broadcast_wide(1.01)];
        let error = error_of_sum(largest, across * across * two, packet.inverse_scale);
        self.sure = error * simd.broadcast_wide(2.0);
    }
}

#[cfg(test)]
mod tests {
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

    /// What each set of registers finds, and what the hierarchy does.
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

    /// Everything is there only here and there.
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
