//! The choice among many lights by what they may do for a point.

use super::bounds::{Cluster, LightBounds};
use super::choice::Choice;
use super::light_sample_context::LightSampleContext;
use crate::geometry::{Word, word};
use glam::Vec3A;
use photosite_core::math::distribution::rest;

/// A binary tree over lights: from its root down a light is found by the importance of either half for the point
/// ([Conty18](photosite_core::references#conty18), [pbrt4](photosite_core::references#pbrt4) §12.6.3).
///
/// Its cost grows with the logarithm of the number of lights. A single light costs nothing, and neither do two
/// neighbours that their bounds hardly tell apart, as the triangles of a rectangle: they are one leaf, and chosen by
/// their intensities alone.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    /// The root first; the two halves of a node lie side by side.
    nodes: Vec<Node>,
    /// Number of leaves to the left of each light's own; [`DARK`] for a light without one.
    ranks: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    cluster: Cluster,
    link: Link,
}

#[derive(Clone, Copy, Debug)]
enum Link {
    Leaf(Leaf),
    /// Node of two halves.
    Inner {
        /// Index of the left one; the right one follows.
        left: u32,
        /// Rank of the first leaf of the right one.
        middle: u32,
    },
}

/// Leaf of one light, or of two that are alike.
#[derive(Clone, Copy, Debug)]
struct Leaf {
    lights: [u32; 2],
    probabilities: [f32; 2],
}

/// Rank of lights that the tree does not hold.
const DARK: u32 = u32::MAX;

impl LightTree {
    /// Builds the tree of all lights that have bounds.
    pub(super) fn new(bounds: impl Iterator<Item = Option<LightBounds>>) -> Self {
        let mut ranks = Vec::new();
        let mut items: Vec<Item> = Vec::new();
        for (light, bounds) in (0..).zip(bounds) {
            ranks.push(DARK);
            let Some(bounds) = bounds else { continue };
            match items.last_mut().and_then(|before| before.with(light, &bounds)) {
                Some(pair) => *items.last_mut().expect("it has been looked at") = pair,
                None => items.push(Item { bounds, leaf: Leaf { lights: [light; 2], probabilities: [1.0, 0.0] } }),
            }
        }
        let Some(first) = items.first() else { return Self { nodes: Vec::new(), ranks } };
        // Any intensity of all is as good as 1, which cannot overflow.
        let scale = 1.0 / items.iter().map(|item| item.bounds.intensity).sum::<f32>();
        let blank = Node { cluster: first.bounds.cluster(scale), link: Link::Leaf(first.leaf) };
        let mut nodes = vec![blank; 2 * items.len() - 1];
        if let [root, below @ ..] = nodes.as_mut_slice() {
            build(&mut items, root, below, 1, 0, scale);
        }
        for (rank, item) in (0..).zip(&items) {
            for light in item.leaf.lights {
                ranks[light as usize] = rank;
            }
        }
        Self { nodes, ranks }
    }

    /// Number of leaves to the left of a light's own; [`DARK`] for one that the tree does not hold.
    pub(super) fn rank(&self, light: u32) -> u32 {
        self.ranks[light as usize]
    }

    /// Nodes as plain data, four words each. The last has two bits, whether it is a leaf and whether lights shine to both
    /// sides; then the left half and the rank of the first leaf of the right one, or both lights of a leaf and the
    /// probability of the first.
    pub(super) fn words(&self) -> Vec<Word> {
        let words = |node: &Node| {
            let Cluster { centre, half, axis, cos_cone, cos_beyond, intensity, two_sided } = node.cluster;
            let sides = u32::from(two_sided) << 1;
            let last = match node.link {
                Link::Leaf(Leaf { lights: [a, b], probabilities: [of_first, _] }) => {
                    [1 | sides, a, b, of_first.to_bits()]
                }
                Link::Inner { left, middle } => [sides, left, middle, 0],
            };
            let part = |v: Vec3A, beside: f32| word(v.into(), beside.to_bits());
            [part(centre, intensity), part(half, cos_cone), part(axis, cos_beyond), last]
        };
        self.nodes.iter().flat_map(words).collect()
    }

    /// Whether the tree holds no light.
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Importance of all lights together, see [`LightSampleContext::importance`], in parts of the intensity of all.
    #[inline]
    pub(super) fn importance(&self, ctx: &LightSampleContext) -> f32 {
        self.nodes.first().map_or(0.0, |root| ctx.importance(&root.cluster))
    }

    /// A light, from a number in [0, 1). `None` where no light of the part that it leads to can reach the point.
    #[inline]
    pub(super) fn sample(&self, ctx: &LightSampleContext, mut u: f32) -> Option<Choice> {
        let mut node = self.nodes.first()?;
        let mut probability = 1.0;
        loop {
            match node.link {
                Link::Leaf(Leaf { lights, probabilities }) => {
                    // Without a branch, which nothing could guess.
                    let number = usize::from(u >= probabilities[0]);
                    let (light, part) = (lights[number], probabilities[number]);
                    let rest = rest(u, number as f32 * probabilities[0], part);
                    return Some(Choice { light, probability: probability * part, rest });
                }
                Link::Inner { left, .. } => {
                    let halves = &self.nodes[left as usize..][..2];
                    let of_left = probability_of_left(halves, ctx)?;
                    let is_right = u >= of_left;
                    let part = if is_right { 1.0 - of_left } else { of_left };
                    u = rest(u, if is_right { of_left } else { 0.0 }, part);
                    probability *= part;
                    node = &halves[usize::from(is_right)];
                }
            }
        }
    }

    /// Probability with which [`Self::sample`] finds a light.
    #[inline]
    pub(super) fn probability(&self, ctx: &LightSampleContext, light: u32) -> f32 {
        let rank = self.ranks[light as usize];
        let Some(mut node) = self.nodes.first().filter(|_| rank != DARK) else { return 0.0 };
        let mut probability = 1.0;
        loop {
            match node.link {
                Link::Leaf(Leaf { lights: [first, _], probabilities: [of_first, of_second] }) => {
                    return probability * if light == first { of_first } else { of_second };
                }
                Link::Inner { left, middle } => {
                    let halves = &self.nodes[left as usize..][..2];
                    let Some(of_left) = probability_of_left(halves, ctx) else { return 0.0 };
                    let is_right = rank >= middle;
                    probability *= if is_right { 1.0 - of_left } else { of_left };
                    node = &halves[usize::from(is_right)];
                }
            }
        }
    }
}

/// Probability of the left half; `None` where neither half can reach the point. One that can is never left out, however
/// dim it is beside the other.
#[inline]
fn probability_of_left(halves: &[Node], ctx: &LightSampleContext) -> Option<f32> {
    let [left, right] = [0, 1].map(|i| ctx.importance(&halves[i].cluster));
    if left == 0.0 || right == 0.0 {
        return (left + right > 0.0).then_some(if left > 0.0 { 1.0 } else { 0.0 });
    }
    const LEAST: f32 = 1e-6;
    Some((left / (left + right)).clamp(LEAST, 1.0 - LEAST))
}

/// A leaf that is to find its place.
#[derive(Clone, Copy)]
struct Item {
    bounds: LightBounds,
    leaf: Leaf,
}

impl Item {
    /// A leaf of two lights, where this one has one that is like the other: a rectangle's triangles have boxes as large
    /// as its own.
    fn with(&self, light: u32, other: &LightBounds) -> Option<Self> {
        let [first, second] = self.leaf.lights;
        let both = self.bounds.union(other);
        let is_alike = self.bounds.cost() + other.cost() > 0.5 * both.cost();
        let of_first = self.bounds.intensity / both.intensity;
        let leaf = Leaf { lights: [first, light], probabilities: [of_first, 1.0 - of_first] };
        (first == second && is_alike).then_some(Self { bounds: both, leaf })
    }
}

/// Fills a node and all below it, which lie from index `first` on; `rank` is that of its first light.
fn build(items: &mut [Item], node: &mut Node, below: &mut [Node], first: u32, rank: u32, scale: f32) -> LightBounds {
    if let [item] = items {
        *node = Node { cluster: item.bounds.cluster(scale), link: Link::Leaf(item.leaf) };
        return item.bounds;
    }
    let count = items.len();
    let middle = split(items);
    let (items_left, items_right) = items.split_at_mut(middle);
    let (halves, below) = below.split_at_mut(2);
    let (below_left, below_right) = below.split_at_mut(2 * middle - 2);
    let (left, right) = halves.split_at_mut(1);
    let first_right = first + 2 + below_left.len() as u32;
    let rank_right = rank + middle as u32;
    let mut build_left = || build(items_left, &mut left[0], below_left, first + 2, rank, scale);
    let mut build_right = || build(items_right, &mut right[0], below_right, first_right, rank_right, scale);
    // Smaller tasks are not worth their start.
    let bounds = if count > 4096 { rayon::join(build_left, build_right) } else { (build_left(), build_right()) };
    let all = bounds.0.union(&bounds.1);
    *node = Node { cluster: all.cluster(scale), link: Link::Inner { left: first, middle: rank_right } };
    all
}

/// Sorts at least two lights into two parts, where the costs of both together are least among twelve places along each
/// axis ([Conty18](photosite_core::references#conty18) §4.4), and returns the length of the first.
fn split(items: &mut [Item]) -> usize {
    const BUCKETS: usize = 12;
    let (mut low, mut high) = (items[0].bounds.centre(), items[0].bounds.centre());
    for item in items.iter() {
        (low, high) = (low.min(item.bounds.centre()), high.max(item.bounds.centre()));
    }
    let extent = high - low;
    let bucket = |axis: usize, item: &Item| {
        let part = (item.bounds.centre()[axis] - low[axis]) / extent[axis];
        ((part * BUCKETS as f32) as usize).min(BUCKETS - 1)
    };
    let both = |a: Option<LightBounds>, b: Option<LightBounds>| match (a, b) {
        (Some(a), Some(b)) => Some(a.union(&b)),
        (a, b) => a.or(b),
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        if extent[axis] <= 0.0 {
            continue;
        }
        let mut buckets = [None; BUCKETS];
        for item in items.iter() {
            let bucket = &mut buckets[bucket(axis, item)];
            *bucket = both(*bucket, Some(item.bounds));
        }
        let mut from_right = [None; BUCKETS];
        let mut right = None;
        for i in (1..BUCKETS).rev() {
            right = both(right, buckets[i]);
            from_right[i] = right;
        }
        let mut left = None;
        for (i, right) in from_right.iter().enumerate().skip(1) {
            left = both(left, buckets[i - 1]);
            let (Some(left), Some(right)) = (left, right) else { continue };
            // Slices across a long side are better than slivers along it.
            let cost = (left.cost() + right.cost()) * (extent.max_element() / extent[axis]);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, i));
            }
        }
    }
    let Some((_, axis, border)) = best else { return items.len() / 2 };
    items.sort_unstable_by_key(|item| bucket(axis, item) >= border);
    items.partition_point(|item| bucket(axis, item) < border)
}
