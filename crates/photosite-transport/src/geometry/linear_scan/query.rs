//! Queries about rays that are scanned side by side.

use super::packet::{Mask, RayPacket};
use super::primitives::LinearScan;
use crate::geometry::{Hit, Primitive};
use photosite_core::math::Real;
use photosite_simd::{IdLanes, LaneMask, Simd, WideLanes};

/// The primitive of a lane that has no hit.
const NONE: u32 = u32::MAX;

/// A query about a ray in each lane.
pub(in crate::geometry) trait LaneQuery<S: Simd> {
    /// The result for one ray.
    type Answer;

    /// Begins with no hits.
    fn new(simd: S, packet: &RayPacket<'_, S>) -> Self;
    /// Parameters t at which the rays end.
    fn t_max(&self) -> S::Wide;
    /// Takes the hits of a primitive, with the weights of a triangle's second and third corner and what to divide them
    /// by. Returns whether all rays have their answer.
    fn on_hits(&mut self, hit: Mask<S>, primitive: u32, t: S::Wide, weights: [S::Wide; 3]) -> bool;
    /// Writes the result of each ray.
    fn store(&self, scan: &LinearScan, packet: &RayPacket<'_, S>, answers: &mut [Self::Answer]);
}

/// The nearest hits.
pub(in crate::geometry) struct ClosestLanes<S: Simd> {
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

/// Query whether there is any hit, a ray in each lane.
pub(in crate::geometry) struct OccludedLanes<S: Simd> {
    t_max: S::Wide,
    /// Indices of the primitives that the rays end at.
    to: S::Wide,
    /// Lanes that have a hit.
    occluded: u32,
    /// Lanes with rays of their own.
    active: u32,
}

impl<S: Simd> LaneQuery<S> for OccludedLanes<S> {
    type Answer = bool;

    #[inline(always)]
    fn new(_: S, packet: &RayPacket<'_, S>) -> Self {
        Self { t_max: packet.t_max, to: packet.to, occluded: 0, active: u32::MAX >> (32 - packet.members.len()) }
    }

    #[inline(always)]
    fn t_max(&self) -> S::Wide {
        self.t_max
    }

    #[inline(always)]
    fn on_hits(&mut self, hit: Mask<S>, primitive: u32, _: S::Wide, _: [S::Wide; 3]) -> bool {
        let own = self.to.broadcast(primitive as f32);
        self.occluded |= (hit & !(own.le(self.to) & self.to.le(own))).bits();
        self.occluded & self.active == self.active
    }

    #[inline(always)]
    fn store(&self, _: &LinearScan, packet: &RayPacket<'_, S>, answers: &mut [bool]) {
        for (lane, &member) in packet.members.iter().enumerate() {
            answers[usize::from(member)] = self.occluded >> lane & 1 != 0;
        }
    }
}
