//! The table of fitted polynomials, and its interpolation for textures.
//!
//! A colour is placed by its largest channel m, by the value z of that channel, and by the two others relative to it, x
//! = (next channel)/z and y = (the one after)/z, as in [JakobHanika19](crate::references#jakobhanika19) §4.1. Along
//! each of the three axes the nodes are at z = s²/(s² + (1 − s)²) for evenly spaced s: near 0 and near 1, where the
//! coefficients of saturated spectra run off like 1/√z and 1/√(1 − z), they lie dense in proportion. Stored and
//! interpolated are homogeneous coordinates (see [`SigmoidPolynomial`]), which stay finite there, and are nearly linear
//! in s.

use std::sync::OnceLock;

use glam::{DVec3, DVec4, Vec4};

use super::SigmoidPolynomial;
use super::fit::fit;

/// Nodes along each axis, a power of two.
const NODES: usize = 32;
/// Distance in the table from one node to the next along x, y, z and to the next largest channel.
const STRIDE: [usize; 4] = [1, NODES, NODES * NODES, NODES * NODES * NODES];
/// 1.5·2²³: sums of this and a small number of either sign have a last bit worth 1, and low bits all 0 for 0.
const INTEGER_PART: f32 = 12_582_912.0;
/// Value that stands for the node at z = 0, where only the limit exists.
const NEARLY_BLACK: f64 = 1e-6;

/// The file: four little-endian f32 (b₀, b₁, b₂, w) a node, x fastest, then y, z, m.
const FILE: &[u8] = include_bytes!("../../../assets/spectra/jakob-hanika-srgb.bin");

pub(super) fn nodes() -> &'static [Vec4] {
    static TABLE: OnceLock<Vec<Vec4>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        let node = |bytes: &[u8]| Vec4::from_array(std::array::from_fn(|i| number(&bytes[4 * i..])));
        let nodes: Vec<_> = FILE.chunks_exact(16).map(node).collect();
        assert_eq!(nodes.len(), 3 * STRIDE[3], "jakob-hanika-srgb.bin is part of the program");
        nodes
    })
}

/// The polynomial of a linear sRGB reflectance with channels in [0, 1], not all equal, by trilinear interpolation.
#[inline]
pub(super) fn look_up(rgb: [f32; 3]) -> SigmoidPolynomial {
    let [r, g, b] = rgb;
    let (largest, [z, x, y]) = if r >= g && r >= b {
        (0, [r, g, b])
    } else if g >= b {
        (1, [g, b, r])
    } else {
        (2, [b, r, g])
    };
    // The inverse of `node_value`, on all axes at once.
    let value = Vec4::new(x / z, y / z, z, 0.0);
    let (near, far) = (value.sqrt(), (1.0 - value).sqrt());
    let position = near / (near + far) * (NODES - 1) as f32;
    // Adding a number whose last bit is worth 1 rounds to an integer, which then stands in the low bits; ties go either
    // way, to a node that two cells share. Faster by a third than `floor` and a cast of each lane.
    let rounded = (position - 0.5) + INTEGER_PART;
    let within = position - (rounded - INTEGER_PART);
    let [i, j, k, _] = rounded.to_array().map(|lane| lane.to_bits() as usize % NODES);

    let start = largest * STRIDE[3] + k * STRIDE[2] + j * STRIDE[1] + i;
    let corners = &nodes()[start..start + STRIDE[2] + STRIDE[1] + 2];
    let edge = |offset: usize| corners[offset].lerp(corners[offset + 1], within.x);
    let face = |offset: usize| edge(offset).lerp(edge(offset + STRIDE[1]), within.y);
    SigmoidPolynomial::from_homogeneous(face(0).lerp(face(STRIDE[2]), within.z))
}

/// Position of a node along any axis, 0–1.
fn node_value(index: usize) -> f64 {
    let s = index as f64 / (NODES - 1) as f64;
    s * s / (s * s + (1.0 - s) * (1.0 - s))
}

/// Linear sRGB of the node with these indices along x, y, z.
fn node_colour(largest: usize, [i, j, k]: [usize; 3]) -> DVec3 {
    let z = node_value(k).max(NEARLY_BLACK);
    let mut rgb = DVec3::ZERO;
    rgb[largest] = z;
    rgb[(largest + 1) % 3] = z * node_value(i);
    rgb[(largest + 2) % 3] = z * node_value(j);
    rgb
}

/// The content of `assets/spectra/jakob-hanika-srgb.bin`, fitted anew. The fit takes some seconds.
///
/// Returns the bytes and the largest error of a channel relative to the colour's largest channel.
pub(super) fn fit_all() -> (Vec<u8>, f64) {
    let mut bytes = Vec::with_capacity(FILE.len());
    let mut worst = 0.0f64;
    for largest in 0..3 {
        for k in 0..NODES {
            // From grey, where the solution is known, to more and more saturated colours.
            let mut plane = vec![DVec4::ZERO; STRIDE[2]];
            for (j, i) in (0..NODES).rev().flat_map(|j| (0..NODES).rev().map(move |i| (j, i))) {
                let target = node_colour(largest, [i, j, k]);
                let at = j * STRIDE[1] + i;
                plane[at] = if target.x == target.y && target.y == target.z {
                    SigmoidPolynomial::constant(target.x as f32).homogeneous().as_dvec4()
                } else {
                    let mut start = if i + 1 < NODES { plane[at + STRIDE[0]] } else { plane[at + STRIDE[1]] };
                    // White, w = 0, is a stationary point that no step leaves.
                    start.w = start.w.max(0.02);
                    let fit = fit(target, start, 200);
                    worst = worst.max(fit.error / target.max_element());
                    fit.v
                };
            }
            for mut v in plane {
                if k == 0 {
                    v.w = 0.0;
                }
                // The length is free. This choice, found by trial, interpolates with half the error of unit length.
                let v = (v / (v.z * v.z + 2.0 * v.w * v.w).sqrt()).as_vec4();
                bytes.extend(v.to_array().iter().flat_map(|coordinate| coordinate.to_le_bytes()));
            }
        }
    }
    (bytes, worst)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::upsampling::fit::colour;

    #[test]
    fn nodes_of_the_file_have_their_colours() {
        // Every 41st node, a number without a factor in common with the strides. The coordinates are f32, and
        // colours where the polynomial crosses 0 steeply react by up to 100 times as much.
        for node in (0..3 * STRIDE[3]).step_by(41) {
            let index = |axis: usize| node / STRIDE[axis] % NODES;
            if index(2) == 0 {
                continue;
            }
            let target = node_colour(node / STRIDE[3], [index(0), index(1), index(2)]);
            let error = (colour(nodes()[node].as_dvec4()) - target).abs().max_element();
            assert!(error < 1e-5, "{node}: {error}");
        }
    }

    #[test]
    fn look_up_finds_the_nodes_themselves() {
        for (largest, ijk) in [(0, [3, 17, 20]), (1, [31, 2, 31]), (2, [0, 0, 9]), (2, [31, 30, 1])] {
            let [r, g, b] = node_colour(largest, ijk).as_vec3().to_array();
            let node = nodes()[largest * STRIDE[3] + ijk[2] * STRIDE[2] + ijk[1] * STRIDE[1] + ijk[0]];
            // The position is found to a few f32 roundings of 31, and coordinates differ by at most a few units from
            // node to node.
            assert!(look_up([r, g, b]).homogeneous().abs_diff_eq(node, 1e-4), "{largest} {ijk:?}");
        }
    }
}
