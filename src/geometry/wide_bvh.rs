//! An eight-wide bounding volume hierarchy: collapsed from a binary one, traversed eight boxes and eight triangles at a
//! time.
//!
//! Boxes are tested by slabs with the far plane widened by the bound on rounding (T. Ize, "Robust BVH Ray Traversal",
//! JCGT 2013), triangles in a space sheared along the ray, where the signs that decide are exact (S. Woop, C. Benthin,
//! I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2013): no ray slips through an edge or a corner.

use glam::Vec3;

use super::simd::Lanes;
use super::traversal_stack::TraversalStack;
use crate::math::float::gamma;

/// The binary hierarchy that a wide one is made from.
pub(super) trait BinaryTree {
    /// Lower and upper corner of a node's box.
    fn bounds(&self, node: u32) -> (Vec3, Vec3);
    /// Both children, unless the node is a leaf.
    fn children(&self, node: u32) -> Option<[u32; 2]>;
    /// The primitives of a leaf.
    fn primitives(&self, leaf: u32) -> &[u32];
}

/// Primitives in a leaf, at most: as many as are tested at once.
pub(super) const LEAF_SIZE: usize = 8;

const LEAF: u32 = 1 << 31;

/// Boxes of up to eight children and where they are.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
struct WideNode {
    /// min x, max x, min y, max y, min z, max z of each child; an absent child has an inverted box.
    planes: [[f32; 8]; 6],
    /// Index of a node, or [`LEAF`] | what the leaf callback knows it by.
    children: [u32; 8],
}

impl WideNode {
    const EMPTY: Self = {
        let (min, max) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
        Self { planes: [min, max, min, max, min, max], children: [LEAF; 8] }
    };
}

/// The hierarchy; leaves are known by a number that the builder of the leaf chose.
#[derive(Clone, Debug)]
pub(super) struct WideBvh {
    nodes: Vec<WideNode>,
}

impl WideBvh {
    /// Collapses a binary tree with root 0: a node adopts the children of the child for which that pays most until it has
    /// eight. Subtrees of at most [`LEAF_SIZE`] primitives become leaves, for which `make_leaf` returns a number below 2³¹.
    pub(super) fn collapse(
        tree: &impl BinaryTree,
        node_count: usize,
        mut make_leaf: impl FnMut(&[u32]) -> u32,
    ) -> Self {
        let sizes = subtree_sizes(tree, node_count);
        let is_leaf = |node: u32| usize::from(sizes[node as usize]) <= LEAF_SIZE;
        let mut nodes = vec![WideNode::EMPTY];
        let mut open = vec![(0u32, 0usize)];
        let mut primitives = Vec::with_capacity(LEAF_SIZE);
        while let Some((binary, wide)) = open.pop() {
            let mut members = vec![binary];
            while members.len() < 8 {
                let gains = members.iter().map(|&member| gain(tree, member, is_leaf(member)));
                let largest = gains.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
                let Some((opened, _)) = largest.filter(|(_, gain)| *gain > 0.0) else { break };
                let Some([left, right]) = tree.children(members[opened]) else { break };
                members[opened] = left;
                members.push(right);
            }
            for (slot, &member) in members.iter().enumerate() {
                let (min, max) = tree.bounds(member);
                for axis in 0..3 {
                    nodes[wide].planes[2 * axis][slot] = min[axis];
                    nodes[wide].planes[2 * axis + 1][slot] = max[axis];
                }
                nodes[wide].children[slot] = if is_leaf(member) {
                    primitives.clear();
                    gather_primitives(tree, member, &mut primitives);
                    LEAF | make_leaf(&primitives)
                } else {
                    nodes.push(WideNode::EMPTY);
                    open.push((member, nodes.len() - 1));
                    (nodes.len() - 1) as u32
                };
            }
        }
        Self { nodes }
    }

    /// Gives back memory that building reserved.
    pub(super) fn shrink_to_fit(&mut self) {
        self.nodes.shrink_to_fit();
    }

    /// Visits the leaves that the ray origin + t·direction, 0 < t < t_max, may meet, roughly from near to far, and
    /// returns whether the visitor ended the traversal. The visitor shortens `t_max`.
    #[inline(always)]
    pub(super) fn traverse<L: Lanes>(
        &self,
        origin: Vec3,
        direction: Vec3,
        t_max: &mut f32,
        visitor: &mut impl LeafVisitor,
    ) -> bool {
        let inverse = direction.recip();
        let near_plane =
            [usize::from(inverse.x < 0.0), 2 + usize::from(inverse.y < 0.0), 4 + usize::from(inverse.z < 0.0)];
        let (o, r) = (splat::<L>(origin), splat::<L>(inverse));
        let widen = L::splat(1.0 + 2.0 * gamma(3));

        let mut stack = TraversalStack::new();
        let mut current = 0;
        loop {
            if current & LEAF != 0 {
                if visitor.visit::<L>(current & !LEAF, t_max) {
                    return true;
                }
            } else {
                let node = &self.nodes[current as usize];
                // A direction component of 0 gives ±∞ · 0 = NaN where the origin lies on the plane; min and max then
                // keep their second operand, which counts the origin as inside that slab.
                let mut near = L::splat(0.0);
                let mut far = L::splat(f32::INFINITY);
                for axis in 0..3 {
                    let n = near_plane[axis];
                    near = L::load(&node.planes[n]).sub(o[axis]).mul(r[axis]).max(near);
                    far = L::load(&node.planes[n ^ 1]).sub(o[axis]).mul(r[axis]).min(far);
                }
                let mut hits = near.le(far.mul(widen).min(L::splat(*t_max)));
                if hits != 0 {
                    if hits & (hits - 1) == 0 {
                        current = node.children[hits.trailing_zeros() as usize];
                        continue;
                    }
                    let near = near.store();
                    let base = stack.len();
                    while hits != 0 {
                        let slot = hits.trailing_zeros() as usize;
                        hits &= hits - 1;
                        stack.push_sorted(base, near[slot], node.children[slot]);
                    }
                }
            }
            current = loop {
                match stack.pop() {
                    Some((near, child)) if near < *t_max => break child,
                    Some(_) => {}
                    None => return false,
                }
            };
        }
    }
}

/// What a traversal does at its leaves.
///
/// A trait rather than a closure, since only what is `#[inline(always)]` all the way down is compiled for wide
/// registers (see [`simd`](super::simd)).
pub(super) trait LeafVisitor {
    /// Visits a leaf; may shorten the ray. Returning true ends the traversal.
    fn visit<L: Lanes>(&mut self, leaf: u32, t_max: &mut f32) -> bool;
}

/// Up to eight triangles, corner by corner and axis by axis.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct TriangleBlock {
    corners: [[[f32; 8]; 3]; 3],
    /// What each triangle is called; unused lanes are never hit.
    pub(super) ids: [u32; 8],
}

/// Where a ray meets the triangles of a block.
pub(super) struct BlockHits {
    /// Lanes that are hit at 0 < t < t_max, at least one.
    pub(super) mask: u32,
    /// Ray parameter of each lane.
    pub(super) t: [f32; 8],
    /// Barycentric weights of the second and third corner, not yet divided by their sum.
    weights: [[f32; 8]; 2],
    sum: [f32; 8],
}

impl BlockHits {
    /// Barycentric weights of the second and third corner.
    #[inline(always)]
    pub(super) fn barycentric(&self, lane: usize) -> [f32; 2] {
        let sum = self.sum[lane];
        [self.weights[0][lane] / sum, self.weights[1][lane] / sum]
    }
}

impl TriangleBlock {
    /// From at least one and at most eight triangles.
    pub(super) fn new(triangles: &[(u32, [Vec3; 3])]) -> Self {
        let mut block = Self { corners: [[[0.0; 8]; 3]; 3], ids: [0; 8] };
        for lane in 0..8 {
            // Unused lanes are degenerate: all corners coincide, so no ray ever meets them.
            let (id, corners) = triangles.get(lane).copied().unwrap_or((triangles[0].0, [triangles[0].1[0]; 3]));
            block.ids[lane] = id;
            for (corner, p) in corners.iter().enumerate() {
                for axis in 0..3 {
                    block.corners[corner][axis][lane] = p[axis];
                }
            }
        }
        block
    }

    /// The triangles on their way from one place to another.
    #[inline(always)]
    pub(super) fn between([from, to]: &[Self; 2], part: f32) -> Self {
        let mut block = *from;
        for (corner, ends) in block.corners.iter_mut().zip(&to.corners) {
            for (axis, ends) in corner.iter_mut().zip(ends) {
                for (value, end) in axis.iter_mut().zip(ends) {
                    *value = *value * (1.0 - part) + end * part;
                }
            }
        }
        block
    }

    /// Where the ray meets the triangles, from either side; `None` where it does not.
    #[inline(always)]
    pub(super) fn intersect<L: Lanes>(&self, ray: &ShearedRay, t_max: f32) -> Option<BlockHits> {
        let a = ray.shear::<L>(&self.corners[0]);
        let b = ray.shear::<L>(&self.corners[1]);
        let c = ray.shear::<L>(&self.corners[2]);
        let (u, v, w) = (double_area(c, b), double_area(a, c), double_area(b, a));
        let (smallest, largest) = (u.min(v).min(w), u.max(v).max(w));
        let zero = L::splat(0.0);
        let inside = zero.le(smallest) | largest.le(zero);
        if inside == 0 {
            return None;
        }
        let sum = u.add(v).add(w);
        let t = u.mul(a[2]).add(v.mul(b[2])).add(w.mul(c[2])).div(sum);
        let edge_on = sum.le(zero) & zero.le(sum);
        let mut mask = inside & !edge_on & zero.lt(t) & t.lt(L::splat(t_max));
        if mask == 0 {
            return None;
        }
        // Hits nearer than rounding can tell from 0 are those of the surface that the ray leaves.
        mask &= distance_error([a, b, c], [u, v, w], sum, ray.shear[2]).lt(t);
        if mask == 0 {
            return None;
        }
        Some(BlockHits { mask, t: t.store(), weights: [v.store(), w.store()], sum: sum.store() })
    }
}

/// Twice the signed area between the ray and an edge. The difference of two rounded products has the sign of the exact
/// one or is zero, and zero counts as inside, so no point of a mesh is outside all its triangles.
#[inline(always)]
fn double_area<L: Lanes>(p: [L; 3], q: [L; 3]) -> L {
    p[0].mul(q[1]).sub(p[1].mul(q[0]))
}

/// Bound on the rounding error of t = (u·a_z + v·b_z + w·c_z)/sum ([pbrt4](crate::references#pbrt4) §6.8.7), for
/// directions of any length: `scale` is what z was multiplied by after the shear.
#[inline(always)]
fn distance_error<L: Lanes>([a, b, c]: [[L; 3]; 3], [u, v, w]: [L; 3], sum: L, scale: f32) -> L {
    let (g2, g3, g5) = (L::splat(gamma(2)), L::splat(gamma(3)), L::splat(gamma(5)));
    let x = largest_magnitude(a[0], b[0], c[0]);
    let y = largest_magnitude(a[1], b[1], c[1]);
    let z = largest_magnitude(a[2], b[2], c[2]);
    let e = largest_magnitude(u, v, w);
    let before_scaling = z.mul(L::splat(1.0 / scale.abs()));
    let dx = x.add(before_scaling).mul(g5);
    let dy = y.add(before_scaling).mul(g5);
    let dz = z.mul(g3);
    let de = g2.mul(x).mul(y).add(dy.mul(x)).add(dx.mul(y)).mul(L::splat(2.0));
    let numerator = g3.mul(e).mul(z).add(de.mul(z)).add(dz.mul(e)).mul(L::splat(3.0));
    numerator.div(magnitude(sum))
}

#[inline(always)]
fn magnitude<L: Lanes>(a: L) -> L {
    a.max(L::splat(0.0).sub(a))
}

#[inline(always)]
fn largest_magnitude<L: Lanes>(a: L, b: L, c: L) -> L {
    magnitude(a).max(magnitude(b)).max(magnitude(c))
}

#[inline(always)]
fn splat<L: Lanes>(v: Vec3) -> [L; 3] {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

/// A ray with the shear and the axis order that turn its direction into +Z of length 1, made once per ray.
pub(super) struct ShearedRay {
    origin: [f32; 3],
    /// Where x, y and z of the sheared space come from; z is the direction's largest component.
    axes: [usize; 3],
    shear: [f32; 3],
}

impl ShearedRay {
    #[inline(always)]
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Self {
        let size = direction.abs();
        let kz = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let scale = 1.0 / direction[kz];
        let shear = [direction[kx] * scale, direction[ky] * scale, scale];
        Self { origin: origin.to_array(), axes: [kx, ky, kz], shear }
    }

    /// Corners relative to the origin, sheared so that the ray runs along z.
    #[inline(always)]
    fn shear<L: Lanes>(&self, corners: &[[f32; 8]; 3]) -> [L; 3] {
        let [kx, ky, kz] = self.axes;
        let x = L::load(&corners[kx]).sub(L::splat(self.origin[kx]));
        let y = L::load(&corners[ky]).sub(L::splat(self.origin[ky]));
        let z = L::load(&corners[kz]).sub(L::splat(self.origin[kz]));
        let [sx, sy, sz] = self.shear;
        [x.sub(L::splat(sx).mul(z)), y.sub(L::splat(sy).mul(z)), L::splat(sz).mul(z)]
    }
}

/// What it saves to put the children of a node in its place, in tests of a block of triangles: rays meet boxes in proportion
/// to their areas. Where the node would be one of its own, its test. Where it would be a leaf, the blocks that are met less
/// often than it: some for things that stand apart, none for the patches of a surface.
fn gain(tree: &impl BinaryTree, node: u32, is_leaf: bool) -> f32 {
    const NODE_TEST: f32 = 0.5;
    let area = |node| half_area(tree.bounds(node));
    match tree.children(node) {
        Some([left, right]) if is_leaf => area(node) - area(left) - area(right),
        // Even where it has no area, it is to be taken apart some time.
        Some(_) => (NODE_TEST * area(node)).max(f32::MIN_POSITIVE),
        None => 0.0,
    }
}

fn half_area((min, max): (Vec3, Vec3)) -> f32 {
    let d = max - min;
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// Primitives below every node, counted up to 255.
fn subtree_sizes(tree: &impl BinaryTree, node_count: usize) -> Vec<u8> {
    let mut sizes = vec![0u8; node_count];
    let mut stack = vec![(0u32, false)];
    while let Some((node, children_done)) = stack.pop() {
        match tree.children(node) {
            None => sizes[node as usize] = tree.primitives(node).len().min(255) as u8,
            Some([left, right]) if children_done => {
                sizes[node as usize] = sizes[left as usize].saturating_add(sizes[right as usize]);
            }
            Some([left, right]) => stack.extend([(node, true), (left, false), (right, false)]),
        }
    }
    sizes
}

fn gather_primitives(tree: &impl BinaryTree, node: u32, primitives: &mut Vec<u32>) {
    match tree.children(node) {
        None => primitives.extend_from_slice(tree.primitives(node)),
        Some(children) => children.into_iter().for_each(|child| gather_primitives(tree, child, primitives)),
    }
}
