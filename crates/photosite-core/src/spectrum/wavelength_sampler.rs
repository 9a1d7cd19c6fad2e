//! Sampling of wavelengths in proportion to their importance, four from one number.

use super::{LAMBDA_MIN_NM, LANES, Spectrum, TABLE_LEN, Wavelengths};

/// Fraction of the probability that is spread evenly over wavelengths of importance above zero, so that a dim
/// wavelength is never left out for good.
const EVEN_PART: f64 = 0.05;

/// Number of pieces of a density, each a nanometre long: the intervals between the entries of a table.
pub(super) const PIECES: usize = TABLE_LEN - 1;

/// Probability of each piece for importances at the entries, where negative ones count as zero: a factor times the mean
/// of its two ends, plus the even part. Returned with that factor. A piece is useful where either end is above zero;
/// where none is, all count as useful.
pub(super) fn probabilities(importances: &[f64]) -> (Vec<f64>, f64) {
    let mut masses: Vec<f64> = importances.windows(2).map(|ends| 0.5 * (ends[0].max(0.0) + ends[1].max(0.0))).collect();
    if masses.iter().all(|&mass| mass == 0.0) {
        masses.fill(1.0);
    }
    let useful = masses.iter().filter(|&&mass| mass > 0.0).count() as f64;
    let sum: f64 = masses.iter().sum();
    assert!(sum.is_finite(), "importances must be finite");
    let scale = (1.0 - EVEN_PART) / sum;
    let probability = |&mass: &f64| if mass > 0.0 { scale * mass + EVEN_PART / useful } else { 0.0 };
    (masses.iter().map(probability).collect(), scale)
}

/// Draws wavelengths with a density proportional to an importance spectrum, constant between whole nanometres.
#[derive(Clone, Debug)]
pub struct WavelengthSampler {
    /// Pieces from short waves to long ones, each a nanometre long, and one where the last ends.
    pieces: Vec<Piece>,
    /// Guide table: for each of [`PARTS`](Self::PARTS) equal parts of the probability, the piece that it begins in,
    /// with [`MANY`] set where it extends beyond the next piece. Parts are fine enough that most lie in one piece
    /// ([Devroye86](crate::references#devroye86) §III.2.4).
    guide: Vec<u16>,
}

/// Flag in the guide of a part with more than two pieces.
const MANY: u16 = 1 << 15;

#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Probability of all pieces before.
    before: f32,
    start_nm: f32,
    /// Probability of the piece and, as it is a nanometre long, its density in nm⁻¹.
    density: f32,
    /// Reciprocal of the density, nm.
    nm_per_probability: f32,
}

impl WavelengthSampler {
    const PARTS: usize = 2048;

    /// Sampler of an importance (any unit, not negative), typically the sensor's response times the light. Wavelengths
    /// of importance zero are never drawn, so it must be positive wherever both the response and the light are.
    pub fn new(importance: &Spectrum) -> Self {
        let (probabilities, _) = probabilities(&importance.values().map(f64::from));
        let mut running = 0.0;
        let mut before = vec![0.0];
        for probability in probabilities {
            running += probability;
            before.push(running as f32);
        }
        // Off by some 10⁻¹³, which f32 does not see: all below 1 belongs to a piece.
        debug_assert_eq!(running as f32, 1.0);
        // Densities follow from the rounded sums, so that they agree exactly.
        let piece = |i: usize| {
            let density = before.get(i + 1).map_or(0.0, |end| end - before[i]);
            // No number leads to a piece of density 0.
            Piece { before: before[i], start_nm: LAMBDA_MIN_NM + i as f32, density, nm_per_probability: 1.0 / density }
        };
        let first = |part: usize| before.partition_point(|&b| b <= part as f32 / Self::PARTS as f32) - 1;
        let guide = |part: usize| {
            let (first, next) = (first(part), first(part + 1));
            first as u16 | if next > first + 1 { MANY } else { 0 }
        };
        Self { pieces: (0..TABLE_LEN).map(piece).collect(), guide: (0..Self::PARTS).map(guide).collect() }
    }

    /// Pieces of a nanometre each as plain data, and one where the last ends: the probability of all pieces before, the
    /// density in nm⁻¹, and its reciprocal.
    pub fn pieces(&self) -> impl Iterator<Item = [f32; 3]> {
        self.pieces.iter().map(|piece| [piece.before, piece.density, piece.nm_per_probability])
    }

    /// Four wavelengths from one number in [0, 1): the hero at u, the others at u + ¼, u + ½, u + ¾ (mod 1) of the
    /// cumulative distribution, each therefore with density p(λ).
    #[inline]
    pub fn sample(&self, u: f32) -> Wavelengths {
        let [mut lambda_nm, mut pdf, mut part] = [[0.0; LANES]; 3];
        let mut entry = [0; LANES];
        for lane in 0..LANES {
            let shifted = u + lane as f32 / LANES as f32;
            let u = if shifted >= 1.0 { shifted - 1.0 } else { shifted };
            let number = self.piece(u);
            let Piece { before, start_nm, density, nm_per_probability } = self.pieces[number];
            lambda_nm[lane] = start_nm + ((u - before) * nm_per_probability).min(1.0);
            pdf[lane] = density;
            entry[lane] = number as u32;
            part[lane] = lambda_nm[lane] - start_nm;
        }
        Wavelengths { lambda_nm, pdf, entry, part }
    }

    /// Piece that the cumulative probability u in [0, 1) falls into.
    #[inline]
    fn piece(&self, u: f32) -> usize {
        // Conversions to signed numbers cost less.
        let guide = self.guide[(u * Self::PARTS as f32) as i32 as usize];
        let mut number = usize::from(guide & !MANY);
        // The first step is made without a branch, which would often be guessed wrong; more are rare.
        number += usize::from(self.pieces[number + 1].before <= u);
        if guide & MANY != 0 {
            while self.pieces[number + 1].before <= u {
                number += 1;
            }
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bump() -> Spectrum {
        Spectrum::from_fn(|lambda| (1.0 - ((lambda - 550.0) / 150.0).powi(2)).max(0.0))
    }

    #[test]
    fn the_estimator_integrates_what_it_should() {
        let sampler = WavelengthSampler::new(&bump());
        let n = 4096;
        let estimate: f64 = (0..n)
            .map(|i| {
                let w = sampler.sample((i as f32 + 0.5) / n as f32);
                f64::from((w.weights() * bump().sample(&w)).0.element_sum()) / f64::from(n)
            })
            .sum();
        // 4096 × 4 stratified points on a piecewise linear ratio: error of order 1/n² per piece, f32 sums.
        assert!((estimate / bump().integral() - 1.0).abs() < 1e-3, "{estimate}");
    }

    #[test]
    fn a_lone_hero_stands_for_all_four() {
        let sampler = WavelengthSampler::new(&bump());
        let mut w = sampler.sample(0.3);
        let before = w.weights()[0];
        w.terminate_secondary();
        w.terminate_secondary();
        assert_eq!(w.weights().to_array(), [4.0 * before, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn a_nanometre_at_either_end_is_enough() {
        for lit in [300.0f32, 1100.0] {
            let only = |lambda| if lambda == f64::from(lit) { 1.0 } else { 0.0 };
            let sampler = WavelengthSampler::new(&Spectrum::from_fn(only));
            for u in [0.0, 0.25, 0.5, 1.0 - f32::EPSILON / 2.0] {
                let w = sampler.sample(u);
                assert!(w.lambdas_nm().iter().all(|lambda| (lambda - lit).abs() <= 1.0), "{lit}, {u}: {w:?}");
                assert_eq!(w.weights().to_array(), [0.25; 4]);
            }
        }
    }

    #[test]
    fn useless_wavelengths_are_never_drawn() {
        let sampler = WavelengthSampler::new(&bump());
        for i in 0..1000 {
            for lambda in sampler.sample(i as f32 / 1000.0).lambdas_nm() {
                assert!((399.0..=701.0).contains(&lambda), "{lambda}");
            }
        }
    }
}
