//! Tables by which a card draws random numbers: those of the ziggurats of [`StandardNormal`] and [`Exp1`], and powers
//! of e.
//!
//! The library does not hand its tables out. They are found from what it draws: of a word whose fraction is the least
//! power of two, a ziggurat makes the edge of a layer times that power.

use std::convert::Infallible;

use rand::{RngExt, TryRng};
use rand_distr::{Exp1, StandardNormal};

/// Layers of a ziggurat.
const LAYERS: usize = 256;
/// Bits of the fraction of an edge.
const EDGE_BITS: i32 = 56;
/// Bits of the fraction of a density.
const DENSITY_BITS: i32 = 63;
/// Bits of the fraction of a power of e.
const POWER_BITS: i32 = 62;
/// Powers e^(i/32) up to 3/4, which is beyond ln 2; and e^(i/1024) up to 1/32.
const POWERS: [usize; 2] = [25, 32];

/// Places of the tables by their names in WGSL: edges and densities of both ziggurats, and both tables of powers. Every
/// number takes two words, the lower half first.
pub const PLACES: [(&str, u32); 6] = {
    let list = 2 * (LAYERS as u32 + 1);
    [
        ("NORMAL_EDGES", 0),
        ("NORMAL_DENSITIES", list),
        ("EXPONENTIAL_EDGES", 2 * list),
        ("EXPONENTIAL_DENSITIES", 3 * list),
        ("COARSE_POWERS", 4 * list),
        ("FINE_POWERS", 4 * list + 2 * POWERS[0] as u32),
    ]
};

/// The tables as words, one after the other.
pub fn random_tables() -> Vec<u32> {
    let normal = |layer: u64| 2f64.powi(51) * Words::new(1 << 63 | 1 << 12 | layer).sample::<f64, _>(StandardNormal);
    let exponential = |layer: u64| 2f64.powi(53) * Words::new(layer).sample::<f64, _>(Exp1);
    let mut words = Vec::new();
    let mut add = |numbers: &[f64], bits: i32| {
        words.extend(numbers.iter().flat_map(|number| {
            let fixed = (number * 2f64.powi(bits)) as u64;
            [fixed as u32, (fixed >> 32) as u32]
        }));
    };
    let densities: [fn(f64) -> f64; 2] = [|x| (-0.5 * x * x).exp(), |x| (-x).exp()];
    for (edge, density) in [&normal as &dyn Fn(u64) -> f64, &exponential].into_iter().zip(densities) {
        // The last edge is that of the top.
        let edges: Vec<f64> = (0..LAYERS as u64).map(edge).chain([0.0]).collect();
        add(&edges, EDGE_BITS);
        add(&edges.iter().map(|&x| density(x)).collect::<Vec<_>>(), DENSITY_BITS);
    }
    for (count, steps) in POWERS.into_iter().zip([32.0, 1024.0]) {
        add(&(0..count).map(|i| (i as f64 / steps).exp()).collect::<Vec<_>>(), POWER_BITS);
    }
    words
}

/// Source of one word, and of ones after it, which a ziggurat takes for the top of a layer.
struct Words {
    next: u64,
}

impl Words {
    fn new(first: u64) -> Self {
        Self { next: first }
    }
}

impl TryRng for Words {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.try_next_u64()? as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(std::mem::replace(&mut self.next, u64::MAX))
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(8) {
            let word = self.try_next_u64()?.to_le_bytes();
            chunk.copy_from_slice(&word[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges and densities of both ziggurats.
    fn number(place: usize, index: usize, bits: i32) -> f64 {
        let words = random_tables();
        let at = PLACES[place].1 as usize + 2 * index;
        (f64::from(words[at]) + f64::from(words[at + 1]) * 2f64.powi(32)) / 2f64.powi(bits)
    }

    #[test]
    fn layers_have_the_same_area() {
        // Marsaglia and Tsang 2000: x(i)·(f(x(i+1)) − f(x(i))) is the same for all layers, and for the base with its
        // tail; to the rounding of differences of numbers near 1, 2⁻⁵³ of them for areas of 2⁻⁸.
        for (edges, right) in [(0, 3.654_152_885_361_009), (2, 7.697_117_470_131_05)] {
            assert_eq!(number(edges, 1, EDGE_BITS), right);
            let density = |i| number(edges + 1, i, DENSITY_BITS);
            let area = number(edges, 0, EDGE_BITS) * density(1);
            for i in 1..LAYERS {
                let layer = number(edges, i, EDGE_BITS) * (density(i + 1) - density(i));
                // The top gets what ten digits of the area leave.
                let error = if i + 1 < LAYERS { 1e-12 } else { 1e-9 };
                assert!((layer / area - 1.0).abs() < error, "layer {i} of {edges}: {layer} for {area}");
            }
        }
    }
}
