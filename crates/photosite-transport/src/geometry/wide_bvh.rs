//! An eight-wide bounding volume hierarchy, and how a ray goes through it.

use std::ops::ControlFlow;

use glam::Vec3;

use super::bounds::half_area;
use super::collapse::{BinaryTree, Collapse, LEAF_SIZE, Member};
use super::traversal_stack::{Entry, TraversalStack};
use super::wide_node::{SlabLanes, SlabRay, WideNode, beyond_rounding};
use photosite_simd::{Lanes, Simd, compact, prefer_huge_pages, prefetch};

/// Bit set in the number of a child that is a leaf, beside the number by which the leaf visitor knows it.
const LEAF: u32 = 1 << 31;

/// Child in a slot of a node: a node or a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Child(pub(super) u32);

impl Child {
    /// The node that all begins with.
    pub(super) const ROOT: Self = Self(0);

    /// Number by which the leaf visitor knows the leaf; `None` for a node.
    #[inline(always)]
    pub(super) fn leaf(self) -> Option<u32> {
        (self.0 & LEAF != 0).then_some(self.0 & !LEAF)
    }
}

/// The hierarchy; leaves are known by a number that the builder of the leaf chose.
#[derive(Clone, Debug)]
pub(super) struct WideBvh {
    nodes: Vec<WideNode>,
}

impl WideBvh {
    /// Collapses a binary tree. `fits` says whether primitives, at most [`LEAF_SIZE`], can make a leaf, for which
    /// `make_leaf` returns a number below 2³¹.
    pub(super) fn collapse(
        tree: &impl BinaryTree,
        fits: impl FnMut(&[u32]) -> bool,
        mut make_leaf: impl FnMut(&[u32]) -> u32,
    ) -> Self {
        let collapse = Collapse::new(tree, fits);
        let mut nodes = vec![WideNode::EMPTY];
        let mut open = vec![(0u32, 0usize)];
        let mut primitives = Vec::with_capacity(LEAF_SIZE);
        let mut boxes = Vec::new();
        while let Some((binary, wide)) = open.pop() {
            let mut members = collapse.members(binary);
            let area = |member: &Member| half_area(tree.bounds(member.node));
            members.sort_by(|a, b| area(b).total_cmp(&area(a)));
            boxes.clear();
            boxes.extend(members.iter().map(|member| tree.bounds(member.node)));
            nodes[wide] = WideNode::new(&boxes);
            for (slot, &member) in members.iter().enumerate() {
                nodes[wide].children[slot] = if member.is_leaf {
                    collapse.primitives(member, &mut primitives);
                    LEAF | make_leaf(&primitives)
                } else {
                    nodes.push(WideNode::EMPTY);
                    open.push((member.node, nodes.len() - 1));
                    (nodes.len() - 1) as u32
                };
            }
        }
        Self { nodes }
    }

    /// Returns the hierarchy without the memory that building reserved.
    pub(super) fn compact(self) -> Self {
        Self { nodes: compact(&self.nodes) }
    }

    /// Makes room for `nodes` nodes of hierarchies to be [`append`](Self::append)ed.
    pub(super) fn reserve(&mut self, nodes: usize) {
        self.nodes.reserve_exact(nodes);
        prefer_huge_pages(&self.nodes);
    }

    /// Takes in another hierarchy, whose leaves get the numbers that `renumbered` gives for theirs; returns its root.
    pub(super) fn append(&mut self, other: &Self, renumbered: impl Fn(u32) -> u32) -> u32 {
        let root = self.nodes.len() as u32;
        let moved = |child: u32| if child & LEAF != 0 { LEAF | renumbered(child & !LEAF) } else { child + root };
        self.nodes.extend(other.nodes.iter().map(|node| node.with_children(moved)));
        root
    }

    /// Puts roots of hierarchies that were appended in the places of leaves of this one, its first nodes.
    pub(super) fn graft(&mut self, own_nodes: usize, roots: &[u32]) {
        for child in self.nodes[..own_nodes].iter_mut().flat_map(|node| &mut node.children) {
            if *child & LEAF != 0 {
                *child = roots[(*child & !LEAF) as usize];
            }
        }
    }

    /// A child that is no leaf.
    #[inline(always)]
    pub(super) fn node(&self, child: Child) -> &WideNode {
        &self.nodes[child.0 as usize]
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Visits the leaves that the ray origin + t·direction, 0 < t < t_max, may meet, roughly from near to far unless
    /// the visitor takes any order, and returns whether the visitor ended the traversal. The visitor may shorten
    /// `t_max`, unless it takes any order.
    #[inline(always)]
    pub(super) fn traverse<S: Simd, V: LeafVisitor>(
        &self,
        simd: S,
        origin: Vec3,
        direction: Vec3,
        t_max: &mut f32,
        visitor: &mut V,
    ) -> bool {
        let ray = SlabRay::new(origin, direction).in_lanes(simd);
        let (mut next, mut stack) = (0, TraversalStack::new());
        loop {
            match self.step::<S, V, false>(simd, &ray, &mut next, &mut stack, t_max, visitor) {
                ControlFlow::Continue(()) => {}
                ControlFlow::Break(is_ended) => return is_ended,
            }
        }
    }

    /// Makes one step of a traversal: visits the node or leaf that is `next`, at first number 0, and puts what comes
    /// then in its place. Breaks with whether the visitor has ended the traversal.
    ///
    /// `INTERLEAVED` says whether other rays make steps between two of this one: then the next node is prefetched, and
    /// later ones can wait.
    #[inline(always)]
    pub(super) fn step<S: Simd, V: LeafVisitor, const INTERLEAVED: bool>(
        &self,
        simd: S,
        ray: &SlabLanes<S>,
        next: &mut u32,
        stack: &mut TraversalStack,
        t_max: &mut f32,
        visitor: &mut V,
    ) -> ControlFlow<bool> {
        match self.visit::<S, V, INTERLEAVED>(simd, ray, *next, stack, t_max, visitor) {
            ControlFlow::Continue(Some(child)) => *next = child,
            ControlFlow::Continue(None) => loop {
                match stack.pop() {
                    Some(entry) if V::ANY_ORDER || entry.near() <= beyond_rounding(*t_max) => {
                        *next = entry.child();
                        break;
                    }
                    Some(_) => {}
                    None => return ControlFlow::Break(false),
                }
            },
            ControlFlow::Break(()) => return ControlFlow::Break(true),
        }
        if INTERLEAVED {
            self.prefetch(*next, visitor);
        }
        ControlFlow::Continue(())
    }

    /// Visits a node, of which it returns the child to visit first if the ray enters any, or a leaf. Breaks where the
    /// visitor ends the traversal.
    #[inline(always)]
    fn visit<S: Simd, V: LeafVisitor, const INTERLEAVED: bool>(
        &self,
        simd: S,
        ray: &SlabLanes<S>,
        current: u32,
        stack: &mut TraversalStack,
        t_max: &mut f32,
        visitor: &mut V,
    ) -> ControlFlow<(), Option<u32>> {
        if current & LEAF != 0 {
            let is_ended = visitor.visit(simd, current & !LEAF, t_max);
            return if is_ended { ControlFlow::Break(()) } else { ControlFlow::Continue(None) };
        }
        let node = &self.nodes[current as usize];
        let (hits, near) = node.enter(simd, ray, *t_max);
        if hits == 0 {
            return ControlFlow::Continue(None);
        }
        ControlFlow::Continue(Some(if V::ANY_ORDER {
            self.choose_largest::<V, INTERLEAVED>(node, hits, stack, visitor)
        } else {
            self.choose_nearest::<S::Lanes, V, INTERLEAVED>(node, hits, near, stack, visitor)
        }))
    }

    /// The largest child that the ray enters, which is the likeliest to hold a hit. The others are left for later.
    #[inline(always)]
    fn choose_largest<V: LeafVisitor, const INTERLEAVED: bool>(
        &self,
        node: &WideNode,
        mut hits: u32,
        stack: &mut TraversalStack,
        visitor: &V,
    ) -> u32 {
        let largest = node.children[hits.trailing_zeros() as usize];
        hits &= hits - 1;
        stack.make_room();
        while hits != 0 {
            let child = node.children[hits.trailing_zeros() as usize];
            hits &= hits - 1;
            if !INTERLEAVED {
                self.prefetch(child, visitor);
            }
            stack.push(Entry::new(0.0, child));
        }
        largest
    }

    /// The nearest child that the ray enters. The others are left for later, sorted.
    #[inline(always)]
    fn choose_nearest<L: Lanes, V: LeafVisitor, const INTERLEAVED: bool>(
        &self,
        node: &WideNode,
        mut hits: u32,
        near: L,
        stack: &mut TraversalStack,
        visitor: &V,
    ) -> u32 {
        let near = near.store();
        let first = hits.trailing_zeros() as usize;
        let mut nearest = Entry::new(near[first], node.children[first]);
        hits &= hits - 1;
        if hits != 0 {
            stack.make_room();
            let base = stack.base();
            while hits != 0 {
                let slot = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                let entry = Entry::new(near[slot], node.children[slot]);
                let farther = nearest.max(entry);
                nearest = nearest.min(entry);
                if !INTERLEAVED {
                    self.prefetch(farther.child(), visitor);
                }
                stack.push_sorted(base, farther);
            }
        }
        nearest.child()
    }

    /// Asks the memory for a child that may be visited soon.
    #[inline(always)]
    fn prefetch(&self, child: u32, visitor: &impl LeafVisitor) {
        if child & LEAF != 0 {
            visitor.prefetch(child & !LEAF);
        } else {
            prefetch(&self.nodes[child as usize]);
        }
    }
}

/// Actions of a traversal at its leaves.
///
/// A trait rather than a closure, since only what is `#[inline(always)]` all the way down is compiled for wide
/// registers (see [`simd`](photosite_simd)).
pub(super) trait LeafVisitor {
    /// Whether leaves may come in any order, since the ray is never shortened.
    const ANY_ORDER: bool;
    /// Visits a leaf; may shorten the ray. Returning true ends the traversal.
    fn visit<S: Simd>(&mut self, simd: S, leaf: u32, t_max: &mut f32) -> bool;
    /// Asks the memory for a leaf that may be visited soon.
    fn prefetch(&self, leaf: u32);
}
