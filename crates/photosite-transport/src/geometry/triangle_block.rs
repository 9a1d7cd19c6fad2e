//! Triangles of a leaf, tested against a ray eight at a time.
//!
//! They are tested in a space sheared along the ray, where the signs that decide are exact (S. Woop, C. Benthin, I.
//! Wald, "Watertight Ray/Triangle Intersection", JCGT 2013): no ray slips through an edge or a corner.
//!
//! Neighbours on a surface share vertices: a block holds each once, which takes half the memory that triangles of their
//! own corners would, and shears it once.

use glam::Vec3;

use super::Ray;
use super::near_hit::{is_slender, near_hit};
use photosite_core::math::Real;
use photosite_core::math::float::gamma;
use photosite_simd::{LaneMask, Lanes, Simd};

/// Triangles in a block, at most, and vertices.
pub(super) const BLOCK_SIZE: usize = 8;

/// Block of up to eight triangles of up to eight vertices, each in `SHAPES` shapes: one, or those that it goes between.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct TriangleBlock<const SHAPES: usize> {
    /// Axis by axis.
    vertices: [[[f32; BLOCK_SIZE]; 3]; SHAPES],
    /// Vertices of each triangle, corner by corner; those of unused lanes coincide, so that no ray meets them.
    corners: [[u8; BLOCK_SIZE]; 3],
    /// Ids of the triangles.
    pub(super) ids: [u32; BLOCK_SIZE],
    /// Lanes of the triangles that [`is_slender`].
    slender: u32,
}

/// Hits of a ray on the triangles of a block.
pub(super) struct BlockHits {
    /// Lanes that are hit at 0 < t ≤ t_max, at least one.
    pub(super) mask: u32,
    /// Ray parameter of each lane.
    pub(super) t: [f32; BLOCK_SIZE],
    /// Barycentric weights of the second and third corner, not yet divided by their sum.
    weights: [[f32; BLOCK_SIZE]; 2],
    sum: [f32; BLOCK_SIZE],
}

impl BlockHits {
    /// Barycentric weights of the second and third corner.
    #[inline(always)]
    pub(super) fn barycentric(&self, lane: usize) -> [f32; 2] {
        let sum = self.sum[lane];
        [self.weights[0][lane] / sum, self.weights[1][lane] / sum]
    }
}

impl<const SHAPES: usize> TriangleBlock<SHAPES> {
    /// Packs triangles with their corners in each shape; `None` where they do not fit into a block.
    pub(super) fn new(triangles: impl Iterator<Item = (u32, [[Vec3; 3]; SHAPES])>) -> Option<Self> {
        let vertices = [[[0.0; BLOCK_SIZE]; 3]; SHAPES];
        let mut block = Self { vertices, corners: [[0; BLOCK_SIZE]; 3], ids: [0; BLOCK_SIZE], slender: 0 };
        let mut vertices = [[[0; 3]; SHAPES]; BLOCK_SIZE];
        let mut count = 0;
        for (lane, (id, shapes)) in triangles.enumerate() {
            *block.ids.get_mut(lane)? = id;
            block.slender |= u32::from(shapes.iter().any(is_slender)) << lane;
            for corner in 0..3 {
                let vertex = shapes.map(|corners| corners[corner].to_array().map(f32::to_bits));
                let index = vertices[..count].iter().position(|other| *other == vertex).unwrap_or(count);
                if index == count {
                    *vertices.get_mut(count)? = vertex;
                    for (to, from) in block.vertices.iter_mut().zip(vertex) {
                        (0..3).for_each(|axis| to[axis][count] = f32::from_bits(from[axis]));
                    }
                    count += 1;
                }
                block.corners[corner][lane] = index as u8;
            }
        }
        Some(block)
    }

    /// Ids of the triangles.
    pub(super) fn triangles(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        // Vertices of unused lanes coincide.
        let is_used = |lane: &usize| (0..3).any(|corner| self.corners[corner][*lane] != self.corners[0][*lane]);
        (0..BLOCK_SIZE).filter(is_used).map(|lane| self.ids[lane])
    }

    /// Vertices along an axis, so far on the way from the first shape to the second.
    #[inline(always)]
    fn along<S: Simd>(&self, simd: S, axis: usize, part: f32) -> S::Lanes {
        let from = simd.load(&self.vertices[0][axis]);
        if SHAPES == 1 {
            return from;
        }
        from * simd.broadcast(1.0 - part) + simd.load(&self.vertices[1][axis]) * simd.broadcast(part)
    }

    /// Vertices relative to the origin of the ray, sheared so that it runs along z.
    #[inline(always)]
    fn shear<S: Simd>(&self, simd: S, ray: &ShearedRay, part: f32) -> [S::Lanes; 3] {
        let [kx, ky, kz] = ray.axes;
        let x = self.along(simd, kx, part) - simd.broadcast(ray.origin[kx]);
        let y = self.along(simd, ky, part) - simd.broadcast(ray.origin[ky]);
        let z = self.along(simd, kz, part) - simd.broadcast(ray.origin[kz]);
        let [sx, sy, sz] = ray.shear;
        [x - simd.broadcast(sx) * z, y - simd.broadcast(sy) * z, simd.broadcast(sz) * z]
    }

    /// Intersects the ray with the triangles, from either side; `None` where it meets none.
    #[inline(always)]
    pub(super) fn intersect<S: Simd>(&self, simd: S, ray: &ShearedRay, part: f32, t_max: f32) -> Option<BlockHits> {
        let vertices = self.shear(simd, ray, part);
        // Each vertex is sheared once; the triangles pick theirs.
        let a = permute(simd, vertices, &self.corners[0]);
        let b = permute(simd, vertices, &self.corners[1]);
        let c = permute(simd, vertices, &self.corners[2]);
        // Edge functions: all of one sign where the ray passes inside.
        let (u, v, w) = (double_area(c, b), double_area(a, c), double_area(b, a));
        let (smallest, largest) = (u.min(v).min(w), u.max(v).max(w));
        let zero = simd.broadcast(0.0);
        let mut inside = zero.le(smallest).bits() | largest.le(zero).bits();
        if inside == 0 {
            return None;
        }
        inside &= !simd.find(&self.ids, ray.from);
        if inside == 0 {
            return None;
        }
        let sum = u + v + w;
        let t = (u * a[2] + v * b[2] + w * c[2]) / sum;
        let edge_on = sum.le(zero) & zero.le(sum);
        inside &= !edge_on.bits() & (t.le(simd.broadcast(t_max)).bits() | self.slender);
        if inside == 0 {
            return None;
        }
        // Hits nearer than rounding can tell from 0, or of triangles on which it reaches far, need a closer look.
        let inverse_scale = simd.broadcast(1.0 / ray.shear[2].abs());
        let error = distance_error([a, b, c], [u, v, w], sum, inverse_scale);
        let near = inside & (-error).le(t).bits() & (t.le(error).bits() | self.slender);
        let mask = inside & !near & zero.lt(t).bits();
        if mask | near == 0 {
            return None;
        }
        let mut hits = BlockHits { mask, t: t.store(), weights: [v.store(), w.store()], sum: sum.store() };
        if near != 0 {
            self.look_closer(near, ray, part, t_max, &mut hits);
        }
        (hits.mask != 0).then_some(hits)
    }

    /// Decides about lanes in double precision.
    #[inline(never)]
    fn look_closer(&self, mut near: u32, ray: &ShearedRay, part: f32, t_max: f32, hits: &mut BlockHits) {
        while near != 0 {
            let lane = near.trailing_zeros() as usize;
            near &= near - 1;
            let corners = [0, 1, 2].map(|corner| self.vertex(usize::from(self.corners[corner][lane]), part));
            let hit = near_hit(corners, Vec3::from(ray.origin), ray.direction).filter(|(t, _)| *t <= t_max);
            let Some((t, [b1, b2])) = hit else { continue };
            hits.mask |= 1 << lane;
            hits.t[lane] = t;
            (hits.weights[0][lane], hits.weights[1][lane], hits.sum[lane]) = (b1, b2, 1.0);
        }
    }

    /// A vertex, as [`Self::along`] has its coordinates.
    fn vertex(&self, index: usize, part: f32) -> Vec3 {
        Vec3::from([0, 1, 2].map(|axis| {
            let from = self.vertices[0][axis][index];
            if SHAPES == 1 { from } else { from * (1.0 - part) + self.vertices[1][axis][index] * part }
        }))
    }
}

/// A function rather than a closure, which would not be inlined into a function for wide registers.
#[inline(always)]
fn permute<S: Simd>(simd: S, [x, y, z]: [S::Lanes; 3], indices: &[u8; BLOCK_SIZE]) -> [S::Lanes; 3] {
    let indices = simd.indices(indices);
    [x.permute(indices), y.permute(indices), z.permute(indices)]
}

/// Twice the signed area between the ray and an edge. The difference of two rounded products has the sign of the exact
/// one or is zero, and zero counts as inside, so no point of a mesh is outside all its triangles.
#[inline(always)]
pub(super) fn double_area<R: Real>(p: [R; 3], q: [R; 3]) -> R {
    p[0] * q[1] - p[1] * q[0]
}

/// Bound on the rounding error of t = (u·a_z + v·b_z + w·c_z)/sum ([pbrt4](photosite_core::references#pbrt4) §6.8.7),
/// for directions of any length: `inverse_scale` is one over the magnitude that z was multiplied by after the shear.
#[inline(always)]
pub(super) fn distance_error<R: Real>([a, b, c]: [[R; 3]; 3], [u, v, w]: [R; 3], sum: R, inverse_scale: R) -> R {
    let x = largest_magnitude(a[0], b[0], c[0]);
    let y = largest_magnitude(a[1], b[1], c[1]);
    let z = largest_magnitude(a[2], b[2], c[2]);
    let e = largest_magnitude(u, v, w);
    error_of_sum([x, y, z], e, inverse_scale) / sum.abs()
}

/// Bound on the rounding error of u·a_z + v·b_z + w·c_z, from the largest magnitudes of the corners' coordinates and of
/// the areas: with larger ones it is not smaller.
#[inline(always)]
pub(super) fn error_of_sum<R: Real>([x, y, z]: [R; 3], e: R, inverse_scale: R) -> R {
    let (g2, g3, g5) = (e.broadcast(gamma(2)), e.broadcast(gamma(3)), e.broadcast(gamma(5)));
    let before_scaling = z * inverse_scale;
    let dx = (x + before_scaling) * g5;
    let dy = (y + before_scaling) * g5;
    let dz = z * g3;
    let de = (g2 * x * y + dy * x + dx * y) * e.broadcast(2.0);
    (g3 * e * z + de * z + dz * e) * e.broadcast(3.0)
}

#[inline(always)]
fn largest_magnitude<R: Real>(a: R, b: R, c: R) -> R {
    a.abs().max(b.abs()).max(c.abs())
}

/// The axis along which a direction is longest.
#[inline(always)]
pub(super) fn longest_axis(direction: Vec3) -> usize {
    let size = direction.abs();
    if size.x > size.y && size.x > size.z {
        0
    } else if size.y > size.z {
        1
    } else {
        2
    }
}

/// A ray in an instance with the shear and the axis order that turn its direction into +Z of length 1, made once per
/// ray.
pub(super) struct ShearedRay {
    origin: [f32; 3],
    direction: Vec3,
    /// The triangle that it leaves.
    from: u32,
    /// World axes that become x, y and z of the sheared space; z is the direction's largest component.
    axes: [usize; 3],
    shear: [f32; 3],
}

impl ShearedRay {
    pub(super) const NONE: Self =
        Self { origin: [0.0; 3], direction: Vec3::ZERO, from: 0, axes: [0; 3], shear: [0.0; 3] };

    #[inline(always)]
    pub(super) fn new(&Ray { origin, direction, from, .. }: &Ray, instance: u32) -> Self {
        let kz = longest_axis(direction);
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let scale = 1.0 / direction[kz];
        let shear = [direction[kx] * scale, direction[ky] * scale, scale];
        Self { origin: origin.to_array(), direction, from: from.within(instance), axes: [kx, ky, kz], shear }
    }
}
