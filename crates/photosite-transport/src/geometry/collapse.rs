//! Collapse of a binary hierarchy into one with eight children a node.
//!
//! Of all wide trees that a binary one can be collapsed to, the one in which a random ray costs least by the surface
//! area heuristic (Ylitie, Karras, Laine 2017, §3): found from the leaves up, since the cheapest way to put a subtree
//! below at most k slots of a node is made of those of its children.

use super::bounds::{Bounds, half_area};
use super::triangle_block::BLOCK_SIZE;
use super::wide_node::WIDTH;
use crate::tuning::LEAF_COST;

/// A binary hierarchy; its root is node 0.
pub(super) trait BinaryTree {
    /// Number of nodes.
    fn len(&self) -> usize;
    /// Lower and upper corner of a node's box.
    fn bounds(&self, node: u32) -> Bounds;
    /// Returns both children, unless the node is a leaf.
    fn children(&self, node: u32) -> Option<[u32; 2]>;
    /// The primitive of a leaf.
    fn primitive(&self, leaf: u32) -> u32;
}

/// Primitives in a leaf of the wide tree, at most: as many as are tested at once.
pub(super) const LEAF_SIZE: usize = BLOCK_SIZE;

/// The wide tree that costs least.
pub(super) struct Collapse<'a, T> {
    tree: &'a T,
    choices: Vec<Choice>,
}

/// Best way to put a subtree below at most k slots.
#[derive(Clone, Copy, Default)]
struct Choice {
    /// Costs for k from 1 to 7.
    costs: [f32; WIDTH - 1],
    /// Number of the k slots, k from 2 to 7, that the left child gets; 0 where k − 1 slots are as good. The first
    /// stands for the eight slots that the node has where it is one of the wide tree.
    left: [u8; WIDTH - 1],
    /// Whether the subtree is a leaf of the wide tree where it takes one slot.
    is_leaf: bool,
}

impl Choice {
    fn of_leaf(area: f32) -> Self {
        Self { costs: [LEAF_COST * area; WIDTH - 1], is_leaf: true, ..Self::default() }
    }

    /// Finds the choice of a node from those of both children.
    fn of_node(area: f32, may_be_leaf: bool, [left, right]: [&Self; 2]) -> Self {
        // The cheapest way to share k slots, and how many the left child gets.
        let share = |k: usize| {
            let cost = |i: usize| left.costs[i - 1] + right.costs[k - i - 1];
            let cheapest = (1..k).map(|i| (cost(i), i as u8)).min_by(|a, b| a.0.total_cmp(&b.0));
            cheapest.unwrap_or((f32::INFINITY, 1))
        };
        let mut choice = Self::default();
        let (below, own) = share(WIDTH);
        let (as_leaf, as_node) = (LEAF_COST * area, area + below);
        choice.is_leaf = may_be_leaf && as_leaf <= as_node;
        choice.costs[0] = if choice.is_leaf { as_leaf } else { as_node };
        choice.left[0] = own;
        for k in 2..WIDTH {
            let (cost, left) = share(k);
            let pays = cost < choice.costs[k - 2];
            choice.costs[k - 1] = if pays { cost } else { choice.costs[k - 2] };
            choice.left[k - 1] = if pays { left } else { 0 };
        }
        choice
    }
}

/// Subtree in a slot of a wide node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    /// Root of the binary subtree.
    pub(super) node: u32,
    /// Whether the primitives of the subtree are a leaf of the wide tree.
    pub(super) is_leaf: bool,
}

impl<'a, T: BinaryTree> Collapse<'a, T> {
    /// Finds the choices of all nodes. `fits` says whether primitives, at most [`LEAF_SIZE`], can make a leaf; a single
    /// one must.
    pub(super) fn new(tree: &'a T, mut fits: impl FnMut(&[u32]) -> bool) -> Self {
        let mut choices = vec![Choice::default(); tree.len()];
        let mut sizes = vec![0u8; tree.len()];
        let mut primitives = Vec::with_capacity(LEAF_SIZE);
        let mut open = vec![(0u32, false)];
        while let Some((node, children_done)) = open.pop() {
            let area = half_area(tree.bounds(node));
            match tree.children(node) {
                None => {
                    sizes[node as usize] = 1;
                    choices[node as usize] = Choice::of_leaf(area);
                }
                Some([left, right]) if !children_done => open.extend([(node, true), (left, false), (right, false)]),
                Some([left, right]) => {
                    // No leaf contains what does not fit by itself.
                    let size = sizes[left as usize].saturating_add(sizes[right as usize]);
                    let may_fit = usize::from(size) <= LEAF_SIZE && {
                        primitives.clear();
                        gather(tree, node, &mut primitives);
                        fits(&primitives)
                    };
                    sizes[node as usize] = if may_fit { size } else { u8::MAX };
                    let children = [left, right].map(|child| &choices[child as usize]);
                    choices[node as usize] = Choice::of_node(area, may_fit, children);
                }
            }
        }
        Self { tree, choices }
    }

    /// Members in the slots of the wide node that stands for a binary one.
    pub(super) fn members(&self, node: u32) -> Vec<Member> {
        let Some([left, right]) = self.tree.children(node) else { return vec![Member { node, is_leaf: true }] };
        let mut members = Vec::with_capacity(WIDTH);
        let share = self.choices[node as usize].left[0];
        let mut open = vec![(right, WIDTH as u8 - share), (left, share)];
        while let Some((node, mut slots)) = open.pop() {
            let choice = &self.choices[node as usize];
            while slots > 1 && choice.left[usize::from(slots) - 1] == 0 {
                slots -= 1;
            }
            match self.tree.children(node) {
                Some([left, right]) if slots > 1 => {
                    let share = choice.left[usize::from(slots) - 1];
                    open.extend([(right, slots - share), (left, share)]);
                }
                _ => members.push(Member { node, is_leaf: choice.is_leaf }),
            }
        }
        members
    }

    /// The primitives of a leaf.
    pub(super) fn primitives(&self, leaf: Member, primitives: &mut Vec<u32>) {
        primitives.clear();
        gather(self.tree, leaf.node, primitives);
    }
}

fn gather(tree: &impl BinaryTree, node: u32, primitives: &mut Vec<u32>) {
    match tree.children(node) {
        None => primitives.push(tree.primitive(node)),
        Some(children) => children.into_iter().for_each(|child| gather(tree, child, primitives)),
    }
}
