//! Large meshes in parts: each gets a hierarchy of its own, which takes little memory while it is built, and several
//! are built at once.
//!
//! Parts are halved where the surface area heuristic says so, among planes at even distances (I. Wald, "On fast
//! Construction of SAH-based Bounding Volume Hierarchies", RT 2007).

use glam::Vec3;

use super::bounds::{Bounds, NOTHING, half_area, union};
use super::collapse::BinaryTree;
use crate::tuning::BUILD_CHUNK_SIZE;

/// Planes that are tried along each axis, and one.
const BINS: usize = 32;

/// Primitives in parts, and the binary tree of the cuts between them; its primitives are the parts.
pub(super) struct Chunks {
    primitives: Vec<u32>,
    nodes: Vec<Node>,
    chunks: Vec<std::ops::Range<usize>>,
}

#[derive(Clone, Copy)]
struct Node {
    bounds: Bounds,
    content: Content,
}

#[derive(Clone, Copy)]
enum Content {
    Children([u32; 2]),
    Chunk(u32),
}

impl Node {
    /// Node that is yet to be cut.
    const UNKNOWN: Self = Self { bounds: NOTHING, content: Content::Chunk(0) };
}

impl Chunks {
    /// Collects `count` primitives with their boxes.
    pub(super) fn new(count: u32, bounds: impl Fn(u32) -> Bounds) -> Self {
        let mut chunks = Self { primitives: (0..count).collect(), nodes: Vec::new(), chunks: Vec::new() };
        chunks.nodes.push(Node::UNKNOWN);
        let mut open = vec![(0, 0..count as usize)];
        while let Some((node, range)) = open.pop() {
            let primitives = &mut chunks.primitives[range.clone()];
            let all = primitives.iter().map(|&p| bounds(p)).fold(NOTHING, union);
            let content = if range.len() <= BUILD_CHUNK_SIZE {
                chunks.chunks.push(range);
                Content::Chunk(chunks.chunks.len() as u32 - 1)
            } else {
                let middle = range.start + cut(primitives, &bounds);
                let children = [0, 1].map(|side| (chunks.nodes.len() + side) as u32);
                open.extend([(children[1] as usize, middle..range.end), (children[0] as usize, range.start..middle)]);
                chunks.nodes.extend([Node::UNKNOWN; 2]);
                Content::Children(children)
            };
            chunks.nodes[node] = Node { bounds: all, content };
        }
        chunks
    }

    /// The primitives of each part.
    pub(super) fn parts(&self) -> Vec<&[u32]> {
        self.chunks.iter().map(|range| &self.primitives[range.clone()]).collect()
    }

    /// Bounds of all primitives.
    pub(super) fn bounds(&self) -> Bounds {
        self.nodes[0].bounds
    }
}

impl BinaryTree for Chunks {
    fn len(&self) -> usize {
        self.nodes.len()
    }

    fn bounds(&self, node: u32) -> Bounds {
        self.nodes[node as usize].bounds
    }

    fn children(&self, node: u32) -> Option<[u32; 2]> {
        match self.nodes[node as usize].content {
            Content::Children(children) => Some(children),
            Content::Chunk(_) => None,
        }
    }

    fn primitive(&self, leaf: u32) -> u32 {
        match self.nodes[leaf as usize].content {
            Content::Children(_) => u32::MAX,
            Content::Chunk(chunk) => chunk,
        }
    }
}

/// Sorts primitives into two parts, neither empty, and returns the size of the first.
fn cut(primitives: &mut [u32], bounds: &impl Fn(u32) -> Bounds) -> usize {
    let centre = |(low, high): Bounds| (low + high) * 0.5;
    let (low, high) = primitives.iter().map(|&p| centre(bounds(p))).fold(NOTHING, |all, c| union(all, (c, c)));
    let scale = BINS as f32 / (high - low);
    let bin = |c: Vec3| ((c - low) * scale).min(Vec3::splat(BINS as f32 - 1.0)).as_usizevec3();
    let mut bins = [[(0u32, NOTHING); BINS]; 3];
    for &p in primitives.iter() {
        let bounds = bounds(p);
        let bin = bin(centre(bounds));
        for axis in 0..3 {
            let (count, all) = &mut bins[axis][bin[axis]];
            (*count, *all) = (*count + 1, union(*all, bounds));
        }
    }
    // Cost of the cut before each bin, from the areas and counts of both sides.
    let mut best = (f32::INFINITY, 0, 0);
    for (axis, bins) in bins.iter().enumerate().filter(|(axis, _)| high[*axis] > low[*axis]) {
        let join = |a: (u32, Bounds), b: &(u32, Bounds)| (a.0 + b.0, union(a.1, b.1));
        let mut above = [(0, NOTHING); BINS + 1];
        for i in (0..BINS).rev() {
            above[i] = join(above[i + 1], &bins[i]);
        }
        let mut below = (0, NOTHING);
        for i in 1..BINS {
            below = join(below, &bins[i - 1]);
            let cost = |(count, bounds): (u32, Bounds)| half_area(bounds) * count as f32;
            if below.0 > 0 && above[i].0 > 0 && cost(below) + cost(above[i]) < best.0 {
                best = (cost(below) + cost(above[i]), axis, i);
            }
        }
    }
    let (cost, axis, first_above) = best;
    if cost == f32::INFINITY {
        return primitives.len() / 2;
    }
    let mut size = 0;
    for i in 0..primitives.len() {
        if bin(centre(bounds(primitives[i])))[axis] < first_above {
            primitives.swap(i, size);
            size += 1;
        }
    }
    size
}
