//! Interleaved traversal: several rays take turns, a node or a leaf each. While the memory brings what one of them is
//! to visit next, the others go on. In meshes larger than the caches that makes rays 1.7 to 3.7 times as fast, and
//! through instances 1.05 to 1.3 times. In small scenes they would take 1.1 to 1.3 times as long.

use std::marker::PhantomData;
use std::ops::ControlFlow;

use super::query::{Query, RayQuery};
use super::single::PrimitiveVisitor;
use super::{Accel, Blas, HitFilter, PrimitiveBvh, Tlas};
use crate::geometry::Ray;
use crate::geometry::collapse::LEAF_SIZE;
use crate::geometry::mesh::segment;
use crate::geometry::traversal_stack::TraversalStack;
use crate::geometry::triangle_block::ShearedRay;
use crate::geometry::wide_bvh::LeafVisitor;
use crate::geometry::wide_node::SlabRay;
use crate::tuning::INTERLEAVE;
use photosite_simd::{Simd, prefetch};

const IDLE: &str = "only rays that have started take turns";

/// Traversal state of one ray.
pub(super) trait RayState<Q: Query> {
    /// The hierarchy that is traversed.
    type Hierarchy;
    /// Placeholder of no ray.
    const NONE: Self;

    /// Begins with a ray at the root, whatever became of the last one.
    fn start(&mut self, ray: &Ray, query: Q);

    /// Visits the next node or leaf. Breaks where there is none or the query has ended, with whether it has ended.
    fn step<S: Simd>(&mut self, simd: S, hierarchy: &Self::Hierarchy) -> ControlFlow<bool>;

    /// The query of this ray.
    fn query(&self) -> &Q;
}

/// Answers a query about each of several rays, [`INTERLEAVE`] of them at a time.
#[inline(always)]
pub(super) fn trace_interleaved<'a, S: Simd, R: RayState<Q>, Q: RayQuery<'a, F>, F: HitFilter>(
    simd: S,
    hierarchy: &R::Hierarchy,
    rays: &'a [Ray],
    filter: &'a F,
    answers: &mut [Q::Answer],
) {
    let mut states = [const { R::NONE }; INTERLEAVE];
    for (rays, answers) in rays.chunks(INTERLEAVE).zip(answers.chunks_mut(INTERLEAVE)) {
        for (state, ray) in states.iter_mut().zip(rays) {
            state.start(ray, Q::new(ray, filter));
        }
        // A bit for each ray that has not come to its end.
        let mut active = (1u32 << rays.len()) - 1;
        while active != 0 {
            // One step of each of them.
            let mut turn = active;
            while turn != 0 {
                let slot = turn.trailing_zeros() as usize;
                turn &= turn - 1;
                let state = &mut states[slot];
                if let ControlFlow::Break(has_ended) = state.step(simd, hierarchy) {
                    answers[slot] = state.query().answer(has_ended);
                    active &= !(1 << slot);
                }
            }
        }
    }
}

/// State of a ray in a single hierarchy.
pub(super) struct BvhState<Q> {
    within: WithinBvh,
    t_max: f32,
    query: Option<Q>,
}

/// The progress of a ray in one hierarchy of triangles.
struct WithinBvh {
    slab: SlabRay,
    sheared: ShearedRay,
    /// Child to visit next.
    next: u32,
    /// Children to visit later.
    stack: TraversalStack,
}

impl WithinBvh {
    const NONE: Self = Self { slab: SlabRay::NONE, sheared: ShearedRay::NONE, next: 0, stack: TraversalStack::new() };

    /// Begins at the root with a ray in the space of the instance.
    #[inline(always)]
    fn start(&mut self, ray: &Ray, instance: u32) {
        self.slab = SlabRay::new(ray.origin, ray.direction);
        self.sheared = ShearedRay::new(ray, instance);
        self.next = 0;
        self.stack.clear();
    }

    /// Visits the next node or leaf; `part` is the position of the ray's time between two shapes. Breaks with whether
    /// the query has ended.
    #[inline(always)]
    fn step<S: Simd, Q: Query, const SHAPES: usize>(
        &mut self,
        simd: S,
        bvh: &PrimitiveBvh<SHAPES>,
        instance: u32,
        part: f32,
        t_max: &mut f32,
        query: &mut Q,
    ) -> ControlFlow<bool> {
        let Self { slab, sheared, next, stack } = self;
        let mut visitor = PrimitiveVisitor { bvh, part, sheared, instance, query };
        bvh.bvh.step::<S, _, true>(simd, &slab.in_lanes(simd), next, stack, t_max, &mut visitor)
    }
}

impl<Q: Query> RayState<Q> for BvhState<Q> {
    type Hierarchy = PrimitiveBvh<1>;
    const NONE: Self = Self { within: WithinBvh::NONE, t_max: 0.0, query: None };

    #[inline(always)]
    fn start(&mut self, ray: &Ray, query: Q) {
        self.within.start(ray, 0);
        self.t_max = ray.t_max;
        self.query = Some(query);
    }

    #[inline(always)]
    fn step<S: Simd>(&mut self, simd: S, bvh: &PrimitiveBvh<1>) -> ControlFlow<bool> {
        let Self { within, t_max, query: Some(query) } = self else { unreachable!("{IDLE}") };
        within.step(simd, bvh, 0, 0.0, t_max, query)
    }

    #[inline(always)]
    fn query(&self) -> &Q {
        self.query.as_ref().expect(IDLE)
    }
}

/// State of a ray among instances, and in the hierarchy of one of them.
pub(super) struct InstancesState<Q> {
    /// Ray in world space.
    ray: Ray,
    slab: SlabRay,
    t_max: f32,
    /// Child of the top level to visit next; `None` when all are visited.
    next: Option<u32>,
    /// Children of the top level to visit later.
    stack: TraversalStack,
    /// Placements of the leaf that was visited last, and how many of them have been entered.
    leaf: [Option<u32>; LEAF_SIZE],
    entered: usize,
    /// The instance whose hierarchy is traversed; `None` at the top level.
    instance: Option<u32>,
    within: WithinBvh,
    query: Option<Q>,
}

/// Remembers which leaf of the top level was visited.
struct LeafFinder<'a, Q> {
    top: &'a Tlas,
    leaf: Option<u32>,
    query: PhantomData<Q>,
}

impl<Q: Query> LeafVisitor for LeafFinder<'_, Q> {
    const ANY_ORDER: bool = Q::ANY_ORDER;

    #[inline(always)]
    fn visit<S: Simd>(&mut self, _: S, leaf: u32, _: &mut f32) -> bool {
        self.leaf = Some(leaf);
        false
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        prefetch(&self.top.leaves[leaf as usize]);
    }
}

impl<Q: Query> InstancesState<Q> {
    /// Visits the next node or leaf of the top level. Breaks where there is none.
    #[inline(always)]
    fn step_top<S: Simd>(&mut self, simd: S, accel: &Accel) -> ControlFlow<bool> {
        let (Some(top), Some(next)) = (&accel.top, &mut self.next) else { return ControlFlow::Break(false) };
        let mut finder = LeafFinder { top, leaf: None, query: PhantomData::<Q> };
        let slab = self.slab.in_lanes(simd);
        let step = top.bvh.step::<S, _, true>(simd, &slab, next, &mut self.stack, &mut self.t_max, &mut finder);
        if step.is_break() {
            self.next = None;
        }
        if let Some(leaf) = finder.leaf {
            self.leaf = top.leaves[leaf as usize];
            self.entered = 0;
            self.enter(accel);
        }
        ControlFlow::Continue(())
    }

    /// Enters the hierarchy of the leaf's next instance, if there is one.
    #[inline(always)]
    fn enter(&mut self, accel: &Accel) {
        self.instance = self.leaf.get(self.entered).copied().flatten();
        if let Some(instance) = self.instance {
            self.entered += 1;
            self.within.start(&accel.local_ray(instance, &self.ray).1, instance);
        }
    }
}

impl<Q: Query> RayState<Q> for InstancesState<Q> {
    type Hierarchy = Accel;
    const NONE: Self = Self {
        ray: Ray::NONE,
        slab: SlabRay::NONE,
        t_max: 0.0,
        next: None,
        stack: TraversalStack::new(),
        leaf: [None; LEAF_SIZE],
        entered: 0,
        instance: None,
        within: WithinBvh::NONE,
        query: None,
    };

    #[inline(always)]
    fn start(&mut self, ray: &Ray, query: Q) {
        self.ray = *ray;
        self.slab = SlabRay::new(ray.origin, ray.direction);
        self.t_max = ray.t_max;
        self.next = Some(0);
        self.stack.clear();
        self.instance = None;
        self.query = Some(query);
    }

    #[inline(always)]
    fn step<S: Simd>(&mut self, simd: S, accel: &Accel) -> ControlFlow<bool> {
        // At the top level there is no query to answer.
        let Some(instance) = self.instance else { return self.step_top(simd, accel) };
        // Within a hierarchy, a step of that.
        let Self { ray, within, t_max, query: Some(query), .. } = self else { unreachable!("{IDLE}") };
        let step = match &accel.blas[accel.instances[instance as usize].blas as usize] {
            Blas::Rigid(bvh) => within.step(simd, bvh, instance, 0.0, t_max, query),
            Blas::Deforming(parts) => {
                let (index, part) = segment(ray.time, parts.len());
                within.step(simd, &parts[index], instance, part, t_max, query)
            }
        };
        if step != ControlFlow::Break(false) {
            return step;
        }
        // The hierarchy is done: on to the leaf's next instance, or back to the top level.
        self.enter(accel);
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn query(&self) -> &Q {
        self.query.as_ref().expect(IDLE)
    }
}
