//! Rays side by side, and the vertices of a scan as they see them.

use super::primitives::LinearScan;
use crate::geometry::accel::HitFilter;
use crate::geometry::triangle_block::{error_of_sum, longest_axis};
use crate::geometry::{Primitive, Quadric, Ray};
use crate::tuning::{LINEAR_SCAN_BATCH, LINEAR_SCAN_MAX};
use photosite_core::math::Real;
use photosite_simd::{MAX_LANES, Simd, WideLanes};

/// The result of a comparison in each lane.
pub(in crate::geometry) type Mask<S> = <<S as Simd>::Wide as Real>::Mask;

/// The indices of rays, at most [`LINEAR_SCAN_BATCH`], by the axis along which their direction is longest.
pub(super) struct ByAxis {
    indices: [[u8; LINEAR_SCAN_BATCH]; 3],
    counts: [usize; 3],
}

impl ByAxis {
    #[inline(always)]
    pub(super) fn new(rays: &[Ray]) -> Self {
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
    pub(super) fn packets(&self, size: usize) -> impl Iterator<Item = (usize, &[u8])> {
        let lists = self.indices.iter().zip(self.counts).enumerate();
        lists
            .flat_map(move |(axis, (indices, count))| indices[..count].chunks(size).map(move |members| (axis, members)))
    }
}

/// Rays of one axis, one in each lane.
pub(in crate::geometry) struct RayPacket<'a, S: Simd> {
    pub(super) simd: S,
    pub(super) rays: &'a [Ray],
    /// Indices of the rays in the first lanes. The others hold copies of the first ray.
    pub(super) members: &'a [u8],
    pub(super) origin: [S::Wide; 3],
    pub(super) direction: [S::Wide; 3],
    /// The axes that become x, y and z of the sheared space.
    pub(super) axes: [usize; 3],
    pub(super) shear: [S::Wide; 3],
    /// |1/shear z|.
    pub(super) inverse_scale: S::Wide,
    pub(super) t_max: S::Wide,
    /// Indices in the scan of the triangles that the rays leave; of no triangle where they begin anywhere else.
    pub(super) from: S::Wide,
    /// Indices of the primitives that they end at.
    pub(super) to: S::Wide,
}

impl<'a, S: Simd> RayPacket<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, scan: &LinearScan, rays: &'a [Ray], members: &'a [u8], kz: usize) -> Self {
        let mut columns = [[0.0; MAX_LANES]; 9];
        for lane in 0..S::Wide::COUNT {
            let Ray { origin, direction, t_max, from, to, .. } =
                &rays[usize::from(*members.get(lane).unwrap_or(&members[0]))];
            columns[0][lane] = origin.x;
            columns[1][lane] = origin.y;
            columns[2][lane] = origin.z;
            columns[3][lane] = direction.x;
            columns[4][lane] = direction.y;
            columns[5][lane] = direction.z;
            columns[6][lane] = *t_max;
            columns[7][lane] = scan.index_of(from.within(0)) as f32;
            columns[8][lane] = scan.index_of_target(*to) as f32;
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
            from: simd.load_wide(&columns[7]),
            to: simd.load_wide(&columns[8]),
        }
    }

    /// Lanes of `hit` in which `filter` accepts the hit of a quadric at t.
    #[inline(always)]
    pub(super) fn accepted_on<F: HitFilter>(
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
    pub(super) fn accepted<F: HitFilter>(
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
pub(super) struct ShearedVertices<S: Simd> {
    pub(super) vertices: [[S::Wide; 3]; LINEAR_SCAN_MAX],
    /// Bound on t·|sum| above which hits are farther than twice their rounding error.
    pub(super) sure: S::Wide,
}

impl<S: Simd> ShearedVertices<S> {
    #[inline(always)]
    pub(super) fn none(simd: S) -> Self {
        let zero = simd.broadcast_wide(0.0);
        Self { vertices: [[zero; 3]; LINEAR_SCAN_MAX], sure: zero }
    }

    /// Shears all vertices so that each ray of a packet runs along z.
    #[inline(always)]
    pub(super) fn shear(&mut self, scan: &LinearScan, packet: &RayPacket<'_, S>) {
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
