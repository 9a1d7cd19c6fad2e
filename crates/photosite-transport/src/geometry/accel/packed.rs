//! Hierarchies as plain data, for devices.
//!
//! The nodes are those of `WideBvh` with boxes of eight bits a plane ([Ylitie17](photosite_core::references#ylitie17)
//! §3): a plane is `origin + q·2ᵉ`, rounded outwards, so that a box holds what it held. Children stand in the slots of
//! the octants that they lie in, so that a ray finds them roughly from near to far by its signs alone.

use glam::{Affine3A, Vec3};

use super::{Accel, Blas, InstanceTransform, PrimitiveBvh};
use crate::geometry::accel::leaf::Leaf;
use crate::geometry::near_hit::is_slender;
use crate::geometry::wide_bvh::{Child, WideBvh};
use crate::geometry::wide_node::WIDTH;
use crate::geometry::word::word;
pub use crate::geometry::word::{KEY_WORDS, NONE, QUADRIC_WORDS, Word};
use crate::geometry::{Geometry, Transform, bounds::Bounds};
use photosite_core::Invalid;

/// Words of a node.
pub const NODE_WORDS: usize = 6;
/// Words of a triangle.
pub const TRIANGLE_WORDS: usize = 3;
/// Words of an instance.
pub const INSTANCE_WORDS: usize = 7;

/// Bit of a child that is a leaf; the two bits below it tell its kind, three more its number of members less one, and
/// the others the first of them.
pub const LEAF: u32 = 1 << 31;
/// Kind of a leaf of triangles.
pub const TRIANGLES: u32 = 0;
/// Kind of a leaf of one quadric.
pub const QUADRIC: u32 = 1;
/// Kind of a leaf of instances.
pub const INSTANCES: u32 = 2;
/// Kinds of places of packed instances.
pub mod place {
    /// A fixed transform.
    pub const STILL: u32 = 0;
    /// The world, in which the corners are given.
    pub const WORLD: u32 = 1;
    /// A motion.
    pub const MOVING: u32 = 2;
    /// The world, with a root for each part of the time.
    pub const DEFORMING: u32 = 3;
}

/// Bits of the first member of a leaf.
pub const FIRST_BITS: u32 = 26;

/// Levels of nodes above one another at most, of both hierarchies together: what a traversal keeps for each ray.
pub const MAX_LEVELS: usize = 48;

/// Hierarchies of a scene, of which one node or leaf is the root of all.
#[derive(Clone, Debug, Default)]
pub struct PackedAccel {
    /// Nodes, [`NODE_WORDS`] each: origin and the exponents of the three axes; eight children; for each axis the low
    /// planes of the eight, then the high ones.
    pub nodes: Vec<Word>,
    /// Triangles in the order of the leaves, [`TRIANGLE_WORDS`] each: a corner in each, with the index of the triangle,
    /// whether it is slender, and its mesh. Triangles that change their shape are there twice: at the start of a part
    /// of the time, and some triangles later at its end. The bits above that of the slender ones tell how many later,
    /// and beside the first corner at the end is the number of parts.
    pub triangles: Vec<Word>,
    /// Quadrics in the order of the geometry, [`QUADRIC_WORDS`] each.
    pub quadrics: Vec<Word>,
    /// Instances in the order of the leaves, [`INSTANCE_WORDS`] each: rows of the transform to the world and of that to
    /// the object, or in the first word where its motion begins and the number of its segments, or where its roots
    /// begin and their number; root, kind of its [`place`], its index.
    pub instances: Vec<Word>,
    /// Motions of instances, [`KEY_WORDS`] for each of their keys; roots of what changes its shape, a word each.
    pub motions: Vec<Word>,
    /// Child that all begins with; 0 where the first node is, and none for a scene without geometry.
    pub root: Option<u32>,
}

impl Accel {
    /// Packs the hierarchies.
    ///
    /// # Errors
    ///
    /// Hierarchies that are deeper, or hold more, than the numbers of the packed form can tell.
    pub(crate) fn packed(&self, geometry: &Geometry) -> Result<PackedAccel, Invalid> {
        let mut packed = PackedAccel::default();
        for placed in &geometry.quadrics {
            packed.quadrics.extend(placed.quadric.words(placed.mesh));
        }
        let mut levels = 0;
        if let Some(top) = &self.top {
            // The root of all comes first; its leaves are known once the hierarchies below are packed.
            let (first, of_top) = packed.append_nodes(&top.bvh);
            let mut all = Vec::with_capacity(self.blas.len());
            for blas in self.blas.iter() {
                let (packed_blas, below) = packed.append_blas(geometry, blas)?;
                levels = levels.max(below);
                all.push(packed_blas);
            }
            levels += of_top;
            let children = packed.nodes[first * NODE_WORDS..][..top.bvh.len() * NODE_WORDS].chunks(NODE_WORDS);
            let numbered: Vec<u32> = children.flat_map(|node| [node[1], node[2]]).flatten().collect();
            let mut leaf = |number: u32| {
                let first = (packed.instances.len() / INSTANCE_WORDS) as u32;
                let members = top.leaves[number as usize].iter().flatten();
                let count = members.clone().count() as u32;
                for &instance in members {
                    let placed = &self.instances[instance as usize];
                    packed.append_instance(&placed.transform, all[placed.blas as usize], instance);
                }
                leaf_of(INSTANCES, count, first)
            };
            let numbered = numbered.into_iter().map(|child| match Child(child).leaf() {
                Some(number) => leaf(number),
                None => Ok(child),
            });
            let numbered: Vec<u32> = numbered.collect::<Result<_, _>>()?;
            for (node, children) in
                packed.nodes[first * NODE_WORDS..].chunks_mut(NODE_WORDS).zip(numbered.chunks(WIDTH))
            {
                node[1].copy_from_slice(&children[..4]);
                node[2].copy_from_slice(&children[4..]);
            }
            packed.root = Some(first as u32);
        } else if let (Some(instance), Some(blas)) = (self.instances.first(), self.blas.first()) {
            let (packed_blas, below) = packed.append_blas(geometry, blas)?;
            packed.append_instance(&instance.transform, packed_blas, 0);
            packed.root = packed_blas.root();
            levels = below;
        }
        if levels > MAX_LEVELS {
            let message = format!("its hierarchy is {levels} levels deep, and {MAX_LEVELS} are the most on a device");
            return Err(Invalid::new("scene", message));
        }
        Ok(packed)
    }
}

/// Packed hierarchies of an instance.
#[derive(Clone, Copy)]
enum PackedBlas {
    /// One of primitives that keep their shapes.
    Rigid { root: u32 },
    /// One for each part of the time, whose roots are motions from the first on.
    Deforming { first: u32, parts: u32 },
}

impl PackedBlas {
    /// The root at all times.
    fn root(self) -> Option<u32> {
        match self {
            Self::Rigid { root } => Some(root),
            Self::Deforming { .. } => None,
        }
    }
}

impl PackedAccel {
    /// Adds the hierarchies of a geometry; returns them with the number of their levels.
    fn append_blas(&mut self, geometry: &Geometry, blas: &Blas) -> Result<(PackedBlas, usize), Invalid> {
        match blas {
            Blas::Rigid(bvh) => {
                let (root, levels) = self.append_bvh(geometry, bvh, |triangle| [geometry.corners(triangle)], 1)?;
                Ok((PackedBlas::Rigid { root }, levels))
            }
            Blas::Deforming(parts) => {
                let (mut roots, mut levels) = (Vec::with_capacity(parts.len()), 0);
                for (part, bvh) in parts.iter().enumerate() {
                    let corners = |triangle| [part, part + 1].map(|shape| geometry.corners_in(triangle, shape));
                    let (root, below) = self.append_bvh(geometry, bvh, corners, parts.len())?;
                    levels = levels.max(below);
                    roots.push([root, 0, 0, 0]);
                }
                let first = self.motions.len() as u32;
                self.motions.extend(roots);
                Ok((PackedBlas::Deforming { first, parts: parts.len() as u32 }, levels))
            }
        }
    }

    /// Adds a hierarchy, whose triangles have these corners in its shapes, for one of so many parts of the time;
    /// returns its root and the number of its levels.
    fn append_bvh<const SHAPES: usize>(
        &mut self,
        geometry: &Geometry,
        PrimitiveBvh { bvh, blocks, quadrics, .. }: &PrimitiveBvh<SHAPES>,
        corners: impl Fn(u32) -> [[Vec3; 3]; SHAPES],
        parts: usize,
    ) -> Result<(u32, usize), Invalid> {
        // Triangles lie in the order of the blocks
        let mut firsts = Vec::with_capacity(blocks.len());
        for block in blocks {
            firsts.push((self.triangles.len() / TRIANGLE_WORDS) as u32);
            let count = block.triangles().count() as u32;
            for id in block.triangles() {
                let shapes = corners(id);
                let to_end = if SHAPES > 1 { count } else { 0 };
                let beside = u32::from(shapes.iter().any(is_slender)) | to_end << 1;
                let [a, b, c] = shapes[0];
                let mesh = geometry.triangles[id as usize].mesh;
                self.triangles.extend([word(a, id), word(b, beside), word(c, mesh)]);
            }
            for id in block.triangles().filter(|_| SHAPES > 1) {
                let [a, b, c] = corners(id)[SHAPES - 1];
                self.triangles.extend([word(a, parts as u32), word(b, 0), word(c, 0)]);
            }
        }
        let (first, levels) = self.append_nodes(bvh);
        let leaf = |child: u32| match Child(child).leaf().map(Leaf::of_number) {
            None => Ok(child),
            Some(Leaf::Triangles(block)) => {
                let count = blocks[block as usize].triangles().count() as u32;
                leaf_of(TRIANGLES, count, firsts[block as usize])
            }
            Some(Leaf::Quadric(quadric)) => leaf_of(QUADRIC, 1, quadrics[quadric as usize].0),
        };
        for node in self.nodes[first * NODE_WORDS..].chunks_mut(NODE_WORDS) {
            for child in node[1..3].iter_mut().flatten() {
                *child = leaf(*child)?;
            }
        }
        Ok((first as u32, levels))
    }

    /// Adds an instance of those hierarchies.
    fn append_instance(&mut self, transform: &InstanceTransform, blas: PackedBlas, index: u32) {
        let row = |m: &Affine3A, i: usize| {
            [m.matrix3.x_axis[i], m.matrix3.y_axis[i], m.matrix3.z_axis[i], m.translation[i]].map(f32::to_bits)
        };
        let rows = |to_world: &Affine3A, to_object: &Affine3A| {
            let ([a, b, c], [d, e, f]) = ([0, 1, 2].map(|i| row(to_world, i)), [0, 1, 2].map(|i| row(to_object, i)));
            [a, b, c, d, e, f]
        };
        let moving = |first: u32, parts: u32| [[first, parts, 0, 0], [0; 4], [0; 4], [0; 4], [0; 4], [0; 4]];
        let (words, kind) = match (blas, transform) {
            // What changes its shape has the world space of all times.
            (PackedBlas::Deforming { first, parts }, _) => (moving(first, parts), place::DEFORMING),
            (_, InstanceTransform::World) => (rows(&Affine3A::IDENTITY, &Affine3A::IDENTITY), place::WORLD),
            (_, InstanceTransform::Still(Transform { to_world, to_object })) => {
                (rows(to_world, to_object), place::STILL)
            }
            (_, InstanceTransform::Moving(motion)) => {
                let first = self.motions.len() as u32;
                self.motions.extend(motion.words());
                (moving(first, motion.segments()), place::MOVING)
            }
        };
        self.instances.extend(words);
        self.instances.push([blas.root().unwrap_or(NONE), kind, index, 0]);
    }

    /// Adds the nodes of a hierarchy, whose leaves keep their numbers; returns the index of its root and the number of its
    /// levels.
    fn append_nodes(&mut self, bvh: &WideBvh) -> (usize, usize) {
        let first = self.nodes.len() / NODE_WORDS;
        let mut levels = vec![0usize; bvh.len()];
        // A node comes before its children, or after them where hierarchies were grafted: levels are found from the root.
        let mut open = vec![(0usize, 1usize)];
        while let Some((index, level)) = open.pop() {
            levels[index] = level;
            let node = bvh.node(Child(index as u32));
            let inner = (0..WIDTH).filter(|&slot| node.bounds(slot).is_some());
            let inner = inner.filter(|&slot| Child(node.children[slot]).leaf().is_none());
            open.extend(inner.map(|slot| (node.children[slot] as usize, level + 1)));
        }
        for index in 0..bvh.len() {
            let node = bvh.node(Child(index as u32));
            let mut children = [(None, 0); WIDTH];
            for (slot, child) in children.iter_mut().enumerate() {
                let number = node.children[slot];
                let moved = if Child(number).leaf().is_some() { number } else { number + first as u32 };
                *child = (node.bounds(slot), moved);
            }
            self.nodes.extend(node_words(&in_octants(children)));
        }
        (first, levels.into_iter().max().unwrap_or(0))
    }
}

/// Number of a leaf.
fn leaf_of(kind: u32, count: u32, first: u32) -> Result<u32, Invalid> {
    if first >> FIRST_BITS != 0 {
        let message = format!(
            "its hierarchies have more than {} places for primitives, the most on a device",
            1u32 << FIRST_BITS
        );
        return Err(Invalid::new("scene", message));
    }
    Ok(LEAF | kind << 29 | (count - 1) << FIRST_BITS | first)
}

/// Children in the slots whose bits say on which side of the middle they lie, as far as that goes: the slot of the bits
/// x, y, z for those beyond the middle along each axis.
fn in_octants(children: [(Option<Bounds>, u32); WIDTH]) -> [(Option<Bounds>, u32); WIDTH] {
    let boxes = || children.iter().filter_map(|(bounds, _)| *bounds);
    let middle = |(low, high): Bounds| 0.5 * low + 0.5 * high;
    let Some(all) = boxes().reduce(crate::geometry::bounds::union) else { return children };
    let centre = middle(all);
    let mut pairs = Vec::with_capacity(WIDTH * WIDTH);
    for (child, (bounds, _)) in children.iter().enumerate() {
        let Some(bounds) = bounds else { continue };
        let aside = middle(*bounds) - centre;
        for slot in 0..WIDTH {
            let sign = |bit: usize| if slot & bit == 0 { -1.0 } else { 1.0 };
            pairs.push((aside.dot(Vec3::new(sign(1), sign(2), sign(4))), child, slot));
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut placed, mut is_placed) = ([(None, 0); WIDTH], [false; WIDTH]);
    for (_, child, slot) in pairs {
        if !is_placed[child] && placed[slot].0.is_none() {
            placed[slot] = children[child];
            is_placed[child] = true;
        }
    }
    placed
}

/// A node whose boxes are told by eight bits a plane.
fn node_words(children: &[(Option<Bounds>, u32); WIDTH]) -> [Word; NODE_WORDS] {
    let boxes = || children.iter().filter_map(|(bounds, _)| *bounds);
    let (origin, end) = boxes().reduce(crate::geometry::bounds::union).unwrap_or_default();
    let mut words = [[0; 4]; NODE_WORDS];
    let mut exponents = 0;
    for axis in 0..3 {
        let exponent = exponent_of(origin[axis], end[axis]);
        exponents |= exponent << (8 * axis);
        let place = |q: u32| origin[axis] + q as f32 * f32::from_bits(exponent << 23);
        for (slot, (bounds, _)) in children.iter().enumerate() {
            // An absent child has a box that no ray enters
            let (low, high) = bounds.map_or((255, 0), |(low, high)| {
                let near = |plane: f32| ((plane - origin[axis]) / f32::from_bits(exponent << 23)) as u32;
                let below = near(low[axis]).min(255);
                let below = (0..=below).rev().find(|&q| place(q) <= low[axis]).unwrap_or(0);
                let above = near(high[axis]).min(255);
                (below, (above..256).find(|&q| place(q) >= high[axis]).unwrap_or(255))
            });
            let shift = 8 * (slot % 4);
            words[3 + axis][slot / 4] |= low << shift;
            words[3 + axis][2 + slot / 4] |= high << shift;
        }
    }
    words[0] = word(origin, exponents);
    for (slot, (_, child)) in children.iter().enumerate() {
        words[1 + slot / 4][slot % 4] = *child;
    }
    words
}

/// Bits of the exponent of the smallest power of two of which 255 reach from one end to the other.
fn exponent_of(from: f32, to: f32) -> u32 {
    let reaches = |exponent: &u32| from + 255.0 * f32::from_bits(exponent << 23) >= to;
    (1..=254).find(reaches).unwrap_or(254)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::accel_tests::{Numbers, geometry, in_world};

    /// Lower and upper corner of the box of a child, as a device computes it.
    fn box_of(node: &[Word], slot: usize) -> Bounds {
        let head = node[0];
        let corner = |side: usize| {
            Vec3::from([0, 1, 2].map(|axis| {
                let scale = f32::from_bits((head[3] >> (8 * axis) & 255) << 23);
                let q = node[3 + axis][2 * side + slot / 4] >> (8 * (slot % 4)) & 255;
                f32::from_bits(head[axis]) + q as f32 * scale
            }))
        };
        (corner(0), corner(1))
    }

    #[test]
    fn boxes_hold_all_triangles_below_them() {
        let mut numbers = Numbers(5);
        for (size, place) in [(1.0, 0.0), (1e-3, 100.0), (1e4, -3.0), (0.0, 1.0)] {
            let triangles: Vec<[Vec3; 3]> = (0..3000)
                .map(|_| {
                    let corner = numbers.point() * size + place;
                    [corner, corner + numbers.point() * 0.1, corner + numbers.point() * 0.02]
                })
                .collect();
            let geometry = geometry(&triangles);
            let packed = in_world(&geometry).packed(&geometry).expect("triangles that stand still");
            let mut open = vec![(packed.root.expect("a root"), (Vec3::NEG_INFINITY, Vec3::INFINITY))];
            let mut seen = vec![false; triangles.len()];
            while let Some((child, (low, high))) = open.pop() {
                if child & LEAF == 0 {
                    let node = &packed.nodes[child as usize * NODE_WORDS..][..NODE_WORDS];
                    let children = (0..WIDTH).map(|slot| (slot, node[1 + slot / 4][slot % 4])).filter(|(_, c)| *c != 0);
                    // Boxes are within those above but for their own rounding outwards.
                    open.extend(children.map(|(slot, child)| (child, box_of(node, slot))));
                    continue;
                }
                let (count, first) = ((child >> FIRST_BITS & 7) + 1, child & ((1 << FIRST_BITS) - 1));
                for triangle in
                    packed.triangles[first as usize * TRIANGLE_WORDS..].chunks(TRIANGLE_WORDS).take(count as usize)
                {
                    seen[triangle[0][3] as usize] = true;
                    for corner in triangle {
                        let corner = Vec3::from([0, 1, 2].map(|axis| f32::from_bits(corner[axis])));
                        assert!(corner.cmpge(low).all() && corner.cmple(high).all(), "{corner} in {low}, {high}");
                    }
                }
            }
            assert!(seen.iter().all(|seen| *seen), "a triangle is in no leaf");
        }
    }
}
