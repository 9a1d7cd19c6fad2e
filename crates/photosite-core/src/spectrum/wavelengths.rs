//! The wavelengths that a path carries, and how they are drawn: hero-wavelength sampling
//! ([Wilkie14](crate::references#wilkie14)).

use glam::Vec4;

use super::table::place_in_table;
use super::{LAMBDA_MAX_NM, LAMBDA_MIN_NM, LANES, SampledSpectrum, Spectrum, TABLE_LEN};

/// Four wavelengths with their densities. The first, the hero, decides wherever a direction depends on wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelengths {
    lambda_nm: [f32; LANES],
    /// nm⁻¹; zero for a lane that the path no longer carries.
    pdf: [f32; LANES],
    /// The entry of a spectral table at or below each wavelength, but for the last.
    entry: [u32; LANES],
    /// How far each wavelength is from there to the next entry, 0 to 1.
    part: [f32; LANES],
}

impl Wavelengths {
    /// From wavelengths in nm, 300 to 1100, and their densities in nm⁻¹.
    #[inline]
    pub fn new(lambda_nm: [f32; LANES], pdf: [f32; LANES]) -> Self {
        debug_assert!(lambda_nm.iter().all(|lambda| (LAMBDA_MIN_NM..=LAMBDA_MAX_NM).contains(lambda)));
        let places = lambda_nm.map(place_in_table);
        Self { lambda_nm, pdf, entry: places.map(|(entry, _)| entry), part: places.map(|(_, part)| part) }
    }

    /// Wavelength of a lane, nm.
    #[inline]
    pub fn lambda_nm(&self, lane: usize) -> f32 {
        self.lambda_nm[lane]
    }

    /// All four wavelengths, nm.
    #[inline]
    pub fn lambdas_nm(&self) -> [f32; LANES] {
        self.lambda_nm
    }

    /// Where the wavelength of a lane lies in a spectral table: the entry before it, at most the last but one, and how far it
    /// is from there to the next.
    #[inline]
    pub fn place_in_table(&self, lane: usize) -> (usize, f32) {
        (self.entry[lane] as usize, self.part[lane])
    }

    /// Drops all but the hero, after a refraction whose direction is right for the hero alone. The hero then stands for
    /// all four: its density falls to a quarter ([pbrt4](crate::references#pbrt4) §4.5.4). Idempotent.
    pub fn terminate_secondary(&mut self) {
        if self.is_hero_alone() {
            return;
        }
        self.pdf = [self.pdf[0] / LANES as f32, 0.0, 0.0, 0.0];
    }

    /// Whether only the hero is left.
    #[inline]
    pub fn is_hero_alone(&self) -> bool {
        self.pdf[1..].iter().all(|&pdf| pdf == 0.0)
    }

    /// The densities of `other`, of which these are a part, over these, zero for dropped lanes: what a value is to be
    /// multiplied by that goes with these weights, to go with those of the other.
    #[inline]
    pub fn densities_over(&self, other: &Self) -> SampledSpectrum {
        SampledSpectrum::from_lanes(|i| if self.pdf[i] > 0.0 { other.pdf[i] / self.pdf[i] } else { 0.0 })
    }

    /// Monte Carlo weights 1/(4·p(λᵢ)) in nm, zero for dropped lanes: Σᵢ wᵢ·g(λᵢ) estimates ∫ g dλ.
    #[inline]
    pub fn weights(&self) -> SampledSpectrum {
        let pdf = Vec4::from_array(self.pdf);
        let weights = Vec4::ONE / (LANES as f32 * pdf);
        SampledSpectrum(Vec4::select(pdf.cmpgt(Vec4::ZERO), weights, Vec4::ZERO))
    }
}

/// The part of the probability that is spread evenly over where the importance is not zero, so that a dim wavelength is
/// never left out for good.
const EVEN_PART: f64 = 0.05;

/// Pieces of a density, each a nanometre long: the intervals between the entries of a table.
pub(super) const PIECES: usize = TABLE_LEN - 1;

/// The probability of each piece, for importances at the entries, of which those below zero count as zero: a factor times the
/// mean of its two ends, and the even part. With that factor. A piece counts as useful where either end does; where none
/// is, all are.
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
    /// From short waves to long ones, each a nanometre long, and one where the last ends.
    pieces: Vec<Piece>,
    /// For each of [`PARTS`](Self::PARTS) equal parts of the probability, the piece that it begins in, and [`MANY`] where it goes
    /// on beyond the next. So fine are they that most lie in one piece ([Devroye86](crate::references#devroye86) §III.2.4).
    guide: Vec<u16>,
}

/// Set in the guide for a part with more than two pieces.
const MANY: u16 = 1 << 15;

#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Probability of all before.
    before: f32,
    start_nm: f32,
    /// Its probability, and as it is a nanometre long, its density in nm⁻¹.
    density: f32,
    /// The reciprocal.
    nm_per_probability: f32,
}

impl WavelengthSampler {
    const PARTS: usize = 2048;

    /// From an importance (any unit, not negative): typically what the sensor makes of the light. Wavelengths where it
    /// is zero are never drawn, so it must be positive wherever the response and the light both are.
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

    /// Number of the piece in which u in [0, 1) of the probability has come.
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
