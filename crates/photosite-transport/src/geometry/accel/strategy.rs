//! The ways to trace rays, and the choice among them. All give the same hits; they differ in time.

use std::marker::PhantomData;

use super::interleaved::{BvhState, InstancesState, trace_interleaved};
use super::packet::{coherent_runs, trace_packets};
use super::query::{Closest, Occluded, RayQuery};
use super::{Accel, HitFilter, PrimitiveBvh};
use crate::geometry::linear_scan::LinearScan;
use crate::geometry::{Hit, Ray};
use photosite_simd::{Simd, WithSimd, dispatch, dispatch_wide};

/// Ways to trace rays.
pub(super) enum Strategy<'a> {
    /// Test of every primitive against a ray in each lane, without a hierarchy: scenes of few primitives.
    LinearScan(&'a LinearScan),
    /// A ray in each lane down one hierarchy together: neighbouring rays.
    Packet(&'a PrimitiveBvh<1>),
    /// Interleaved traversal by several rays in turns, a step each, so that one goes on while the memory brings what
    /// another needs: hierarchies larger than the caches.
    Interleaved(&'a PrimitiveBvh<1>),
    /// Interleaved traversal through instances.
    InterleavedInstances,
    /// Traversal of one ray after the other.
    OneByOne,
}

impl Accel {
    /// The nearest hit that `filter` accepts.
    #[inline]
    pub fn closest<F: HitFilter>(&self, ray: &Ray, filter: &F) -> Option<Hit> {
        self.run_one::<Closest<_>, F>(ray, filter)
    }

    /// Whether anything that `filter` accepts is in the ray's way.
    #[inline]
    pub fn occluded<F: HitFilter>(&self, ray: &Ray, filter: &F) -> bool {
        self.run_one::<Occluded<_>, F>(ray, filter)
    }

    /// The nearest hits of several rays that `filter` accepts, in the order of the rays.
    pub fn closest_each<F: HitFilter>(&self, rays: &[Ray], filter: &F, hits: &mut Vec<Option<Hit>>) {
        hits.clear();
        hits.resize(rays.len(), None);
        self.run::<Closest<_>, F>(rays, filter, hits);
    }

    /// Whether anything that `filter` accepts is in the way of each of several rays.
    pub fn occluded_each<F: HitFilter>(&self, rays: &[Ray], filter: &F, occluded: &mut Vec<bool>) {
        occluded.clear();
        occluded.resize(rays.len(), false);
        self.run::<Occluded<_>, F>(rays, filter, occluded);
    }

    /// The fastest way to trace rays; `are_coherent` says whether they are [`coherent_runs`].
    #[inline]
    fn strategy(&self, are_coherent: bool) -> Strategy<'_> {
        match (&self.linear_scan, self.single_bvh(), self.exceeds_caches) {
            (Some(scan), ..) => Strategy::LinearScan(scan),
            (None, Some(bvh), _) if are_coherent => Strategy::Packet(bvh),
            (None, Some(bvh), true) => Strategy::Interleaved(bvh),
            (None, None, true) => Strategy::InterleavedInstances,
            (None, _, false) => Strategy::OneByOne,
        }
    }

    /// Answers a query about each of several rays.
    fn run<'a, Q: RayQuery<'a, F>, F: HitFilter>(
        &'a self,
        rays: &'a [Ray],
        filter: &'a F,
        answers: &'a mut [Q::Answer],
    ) {
        // Only packets need to know which rays are coherent.
        match (&self.linear_scan, self.single_bvh()) {
            (None, Some(bvh)) => {
                for (run, are_coherent) in coherent_runs(bvh, rays) {
                    let batch = Batch::<Q, F>::new(self, &rays[run.clone()], filter, &mut answers[run]);
                    batch.run(self.strategy(are_coherent));
                }
            }
            _ => Batch::<Q, F>::new(self, rays, filter, answers).run(self.strategy(false)),
        }
    }

    /// Whether anything of an instance that `filter` accepts is in the ray's way, whatever else is.
    pub fn meets<F: HitFilter>(&self, instance: u32, ray: &Ray, filter: &F) -> bool {
        dispatch(OneInstance { accel: self, instance, ray, filter })
    }

    #[inline]
    fn run_one<'a, Q: RayQuery<'a, F>, F: HitFilter>(&'a self, ray: &'a Ray, filter: &'a F) -> Q::Answer {
        dispatch(OneRay::<Q, F> { accel: self, ray, filter, query: PhantomData })
    }
}

/// Rays that are traced in the same way, with room for the answers about them.
struct Batch<'a, 'b, Q: RayQuery<'a, F>, F: HitFilter> {
    accel: &'a Accel,
    rays: &'a [Ray],
    filter: &'a F,
    answers: &'b mut [Q::Answer],
}

impl<'a, 'b, Q: RayQuery<'a, F>, F: HitFilter> Batch<'a, 'b, Q, F> {
    fn new(accel: &'a Accel, rays: &'a [Ray], filter: &'a F, answers: &'b mut [Q::Answer]) -> Self {
        Self { accel, rays, filter, answers }
    }

    // Each way is compiled as an operation of its own: in one function with the others they are slower.
    fn run(self, strategy: Strategy<'a>) {
        match strategy {
            Strategy::LinearScan(scan) => dispatch_wide(LinearScanOf(self, scan)),
            Strategy::Packet(bvh) => dispatch_wide(PacketsOf(self, bvh)),
            Strategy::Interleaved(bvh) => dispatch(InterleavedOf(self, bvh)),
            Strategy::InterleavedInstances => dispatch(InterleavedInstancesOf(self)),
            Strategy::OneByOne => dispatch(OneByOneOf(self)),
        }
    }
}

/// [`Strategy::OneByOne`] of a batch.
struct OneByOneOf<'a, 'b, Q: RayQuery<'a, F>, F: HitFilter>(Batch<'a, 'b, Q, F>);

impl<'a, Q: RayQuery<'a, F>, F: HitFilter> WithSimd for OneByOneOf<'a, '_, Q, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(Batch { accel, rays, filter, answers }) = self;
        for (answer, ray) in answers.iter_mut().zip(rays) {
            *answer = accel.intersect(simd, ray, Q::new(ray, filter));
        }
    }
}

/// A query about a single ray.
struct OneRay<'a, Q, F> {
    accel: &'a Accel,
    ray: &'a Ray,
    filter: &'a F,
    query: PhantomData<Q>,
}

impl<'a, Q: RayQuery<'a, F>, F: HitFilter> WithSimd for OneRay<'a, Q, F> {
    type Output = Q::Answer;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Q::Answer {
        self.accel.intersect(simd, self.ray, Q::new(self.ray, self.filter))
    }
}

/// A single ray and a single instance.
struct OneInstance<'a, F> {
    accel: &'a Accel,
    instance: u32,
    ray: &'a Ray,
    filter: &'a F,
}

impl<F: HitFilter> WithSimd for OneInstance<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        self.accel.intersect_instance(simd, self.instance, self.ray, Occluded::new(self.ray, self.filter))
    }
}

/// [`Strategy::LinearScan`] of a batch.
struct LinearScanOf<'a, 'b, Q: RayQuery<'a, F>, F: HitFilter>(Batch<'a, 'b, Q, F>, &'a LinearScan);

impl<'a, Q: RayQuery<'a, F>, F: HitFilter> WithSimd for LinearScanOf<'a, '_, Q, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(Batch { rays, filter, answers, .. }, scan) = self;
        scan.trace::<S, Q::InLanes<S>, F>(simd, rays, filter, answers);
    }
}

/// [`Strategy::Packet`] of a batch.
struct PacketsOf<'a, 'b, Q: RayQuery<'a, F>, F: HitFilter>(Batch<'a, 'b, Q, F>, &'a PrimitiveBvh<1>);

impl<'a, Q: RayQuery<'a, F>, F: HitFilter> WithSimd for PacketsOf<'a, '_, Q, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(Batch { rays, filter, answers, .. }, bvh) = self;
        trace_packets::<S, Q, F>(simd, bvh, rays, filter, answers);
    }
}

/// [`Strategy::Interleaved`] of a batch.
struct InterleavedOf<'a, 'b, Q: RayQuery<'a, F>, F: HitFilter>(Batch<'a, 'b, Q, F>, &'a PrimitiveBvh<1>);

impl<'a, Q: RayQuery<'a, F>, F: HitFilter> WithSimd for InterleavedOf<'a, '_, Q, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(Batch { rays, filter, answers, .. }, bvh) = self;
        trace_interleaved::<S, BvhState<Q>, Q, F>(simd, bvh, rays, filter, answers);
    }
}

/// [`Strategy::InterleavedInstances`] of a batch.
struct InterleavedInstancesOf<'a, 'b, Q: RayQuery<'a, F>, F: HitFilter>(Batch<'a, 'b, Q, F>);

impl<'a, Q: RayQuery<'a, F>, F: HitFilter> WithSimd for InterleavedInstancesOf<'a, '_, Q, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self(Batch { accel, rays, filter, answers }) = self;
        trace_interleaved::<S, InstancesState<Q>, Q, F>(simd, accel, rays, filter, answers);
    }
}
