//! Rays that are asked for together take turns on their ways to the triangles, a node or a leaf each: while the memory brings
//! what one of them is to visit next, the others go on. In meshes larger than the caches that makes them 1.7 to 3.7 times as
//! fast, and where they go through placements on their way, 1.05 to 1.3 times. In small scenes they would take 1.1 to 1.3 times
//! as long.

use std::marker::PhantomData;
use std::ops::ControlFlow;

use glam::Vec3;

use super::query::{BlockVisitor, TriangleQuery};
use super::{Accel, Group, TopLevel, TriangleBvh};
use crate::geometry::Ray;
use crate::geometry::collapse::LEAF_SIZE;
use crate::geometry::mesh::segment;
use crate::geometry::traversal_stack::TraversalStack;
use crate::geometry::triangle_block::ShearedRay;
use crate::geometry::wide_bvh::LeafVisitor;
use crate::geometry::wide_node::SlabRay;
use photosite_simd::{Lanes, prefetch};

/// Rays that take turns.
const IN_TURN: usize = 24;

/// Whether so many blocks of triangles are far more than the caches have room for.
#[inline]
pub(super) fn exceed_caches(blocks: usize) -> bool {
    blocks > 1 << 16
}

const IDLE: &str = "only rays that have started have turns";

/// A ray on its way.
pub(super) trait Flight<Q: TriangleQuery> {
    /// What it goes through.
    type Hierarchy;
    /// That of no ray.
    const NONE: Self;

    /// Begins, where the last one has come to its end or was broken off.
    fn start(&mut self, ray: &Ray, query: Q);

    /// Visits the next node or leaf. Breaks where there is none, or the query has ended, which it tells.
    fn step<L: Lanes>(&mut self, hierarchy: &Self::Hierarchy) -> ControlFlow<bool>;

    /// What is asked.
    fn query(&self) -> &Q;
}

/// Asks of several rays, with a query of its own for each; so many take turns.
#[inline(always)]
pub(super) fn take_turns<'a, L: Lanes, F: Flight<Q>, Q: TriangleQuery>(
    hierarchy: &F::Hierarchy,
    rays: &'a [Ray],
    query: impl Fn(&'a Ray) -> Q,
    answers: &mut [Q::Answer],
) {
    let mut flights = [const { F::NONE }; IN_TURN];
    for (rays, answers) in rays.chunks(IN_TURN).zip(answers.chunks_mut(IN_TURN)) {
        for (flight, ray) in flights.iter_mut().zip(rays) {
            flight.start(ray, query(ray));
        }
        let mut in_flight = (1u32 << rays.len()) - 1;
        while in_flight != 0 {
            let mut turn = in_flight;
            while turn != 0 {
                let slot = turn.trailing_zeros() as usize;
                turn &= turn - 1;
                let flight = &mut flights[slot];
                if let ControlFlow::Break(is_ended) = flight.step::<L>(hierarchy) {
                    answers[slot] = flight.query().answer(is_ended);
                    in_flight &= !(1 << slot);
                }
            }
        }
    }
}

/// A ray on its way through a group.
pub(super) struct GroupFlight<Q> {
    within: Within,
    t_max: f32,
    query: Option<Q>,
}

/// How far a ray has come within a group.
struct Within {
    slab: SlabRay,
    sheared: ShearedRay,
    /// What it visits next.
    next: u32,
    /// What it has yet to visit.
    stack: TraversalStack,
}

impl Within {
    const NOTHING: Self =
        Self { slab: SlabRay::NONE, sheared: ShearedRay::NONE, next: 0, stack: TraversalStack::new() };

    /// Begins with a ray in the space of the group.
    #[inline(always)]
    fn start(&mut self, ray: &Ray) {
        self.slab = SlabRay::new(ray.origin, ray.direction);
        self.sheared = ShearedRay::new(ray.origin, ray.direction);
        self.next = 0;
        self.stack.clear();
    }

    /// `part` is how far the time is between two shapes. Breaks with whether the query has ended.
    #[inline(always)]
    fn step<L: Lanes, Q: TriangleQuery, const SHAPES: usize>(
        &mut self,
        group: &TriangleBvh<SHAPES>,
        (placement, part): (u32, f32),
        t_max: &mut f32,
        query: &mut Q,
    ) -> ControlFlow<bool> {
        let Self { slab, sheared, next, stack } = self;
        let mut visitor = BlockVisitor { blocks: &group.blocks, part, sheared, placement, query };
        group.bvh.step::<L, _, true>(&slab.in_lanes(), next, stack, t_max, &mut visitor)
    }
}

impl<Q: TriangleQuery> Flight<Q> for GroupFlight<Q> {
    type Hierarchy = TriangleBvh<1>;
    const NONE: Self = Self { within: Within::NOTHING, t_max: 0.0, query: None };

    #[inline(always)]
    fn start(&mut self, ray: &Ray, query: Q) {
        self.within.start(ray);
        self.t_max = ray.t_max;
        self.query = Some(query);
    }

    #[inline(always)]
    fn step<L: Lanes>(&mut self, group: &TriangleBvh<1>) -> ControlFlow<bool> {
        let Self { within, t_max, query: Some(query) } = self else { unreachable!("{IDLE}") };
        within.step::<L, Q, 1>(group, (0, 0.0), t_max, query)
    }

    #[inline(always)]
    fn query(&self) -> &Q {
        self.query.as_ref().expect(IDLE)
    }
}

/// A ray on its way through placements, and through the group of one of them.
pub(super) struct PlacedFlight<Q> {
    /// In the world.
    ray: Ray,
    slab: SlabRay,
    t_max: f32,
    /// What it visits next among the placements; `None` when it has visited all.
    next: Option<u32>,
    /// What it has yet to visit among them.
    stack: TraversalStack,
    /// Placements of the leaf that it has come to, with the first that it has yet to enter.
    leaf: [Option<u32>; LEAF_SIZE],
    entered: usize,
    /// Whose group it is in.
    placement: Option<u32>,
    within: Within,
    query: Option<Q>,
}

/// Finds the leaves of the hierarchy of placements.
struct LeafFinder<'a, Q> {
    top: &'a TopLevel,
    /// The one that was visited.
    leaf: Option<u32>,
    asked: PhantomData<Q>,
}

impl<Q: TriangleQuery> LeafVisitor for LeafFinder<'_, Q> {
    const ANY_ORDER: bool = Q::ANY_ORDER;

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, leaf: u32, _: &mut f32) -> bool {
        self.leaf = Some(leaf);
        false
    }

    #[inline(always)]
    fn prefetch(&self, leaf: u32) {
        prefetch(&self.top.leaves[leaf as usize]);
    }
}

impl<Q: TriangleQuery> PlacedFlight<Q> {
    /// Visits the next node or leaf among the placements. Breaks where there is none.
    #[inline(always)]
    fn step_above<L: Lanes>(&mut self, accel: &Accel) -> ControlFlow<bool> {
        let (Some(top), Some(next)) = (&accel.top, &mut self.next) else { return ControlFlow::Break(false) };
        let mut finder = LeafFinder { top, leaf: None, asked: PhantomData::<Q> };
        let lanes = self.slab.in_lanes();
        let step = top.bvh.step::<L, _, true>(&lanes, next, &mut self.stack, &mut self.t_max, &mut finder);
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

    /// Enters the group of the next placement of the leaf, if there is one.
    #[inline(always)]
    fn enter(&mut self, accel: &Accel) {
        self.placement = self.leaf.get(self.entered).copied().flatten();
        if let Some(placement) = self.placement {
            self.entered += 1;
            self.within.start(&accel.in_group(placement, &self.ray).1);
        }
    }
}

impl<Q: TriangleQuery> Flight<Q> for PlacedFlight<Q> {
    type Hierarchy = Accel;
    const NONE: Self = Self {
        ray: Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, t_max: 0.0, time: 0.0 },
        slab: SlabRay::NONE,
        t_max: 0.0,
        next: None,
        stack: TraversalStack::new(),
        leaf: [None; LEAF_SIZE],
        entered: 0,
        placement: None,
        within: Within::NOTHING,
        query: None,
    };

    #[inline(always)]
    fn start(&mut self, ray: &Ray, query: Q) {
        self.ray = *ray;
        self.slab = SlabRay::new(ray.origin, ray.direction);
        self.t_max = ray.t_max;
        self.next = Some(0);
        self.stack.clear();
        self.placement = None;
        self.query = Some(query);
    }

    #[inline(always)]
    fn step<L: Lanes>(&mut self, accel: &Accel) -> ControlFlow<bool> {
        let Some(placement) = self.placement else { return self.step_above::<L>(accel) };
        let Self { ray, within, t_max, query: Some(query), .. } = self else { unreachable!("{IDLE}") };
        let step = match &accel.groups[accel.placements[placement as usize].group as usize] {
            Group::Rigid(group) => within.step::<L, Q, 1>(group, (placement, 0.0), t_max, query),
            Group::Deforming(parts) => {
                let (index, part) = segment(ray.time, parts.len());
                within.step::<L, Q, 2>(&parts[index], (placement, part), t_max, query)
            }
        };
        if step != ControlFlow::Break(false) {
            return step;
        }
        self.enter(accel);
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn query(&self) -> &Q {
        self.query.as_ref().expect(IDLE)
    }
}
