//! Random numbers of a variation in a frame, and their joint distribution over all frames.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

use super::SamplingDescription;
use photosite_core::math::hash::hash64;
use photosite_core::math::normal;
use photosite_core::math::philox::Philox;

/// Random numbers for one value of a variation in a frame, one after the other. They follow from the seed of the value
/// and the number of the frame, so that any frame can be made alone.
#[derive(Clone, Debug)]
pub(super) struct Draws {
    random: Philox,
    strata: Option<Strata>,
}

/// Latin hypercube ([McKay79](photosite_core::references#mckay79)): along each dimension the range from 0 to 1 is cut
/// into as many parts as there are frames, and each part is that of one frame.
#[derive(Clone, Debug)]
struct Strata {
    seed: u64,
    frame: u32,
    frames: u32,
    /// Number of dimensions drawn so far.
    dimensions: u64,
}

impl Draws {
    /// Random numbers of a seed in frame `frame` of `frames`.
    pub(super) fn new(sampling: SamplingDescription, seed: u64, frame: u32, frames: u32) -> Self {
        let strata = match sampling {
            SamplingDescription::Independent => None,
            SamplingDescription::LatinHypercube => Some(Strata { seed, frame, frames, dimensions: 0 }),
        };
        Self { random: Philox::new(seed, u64::from(frame)), strata }
    }

    /// Draws a uniform number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;
        let within: f64 = self.random.random();
        match &mut self.strata {
            None => within,
            Some(strata) => ((strata.next() as f64 + within) / f64::from(strata.frames)).min(BELOW_ONE),
        }
    }

    /// Draws from the standard normal distribution.
    pub(super) fn normal(&mut self) -> f64 {
        match self.strata {
            None => StandardNormal.sample(&mut self.random),
            // The smallest number that `unit` can be but 0.
            Some(_) => normal::quantile(self.unit().max(f64::EPSILON / 2.0)),
        }
    }

    /// Draws an index below `count`.
    pub(super) fn index(&mut self, count: usize) -> usize {
        match self.strata {
            None => self.random.random_range(0..count),
            Some(_) => ((self.unit() * count as f64) as usize).min(count - 1),
        }
    }

    /// Draws a subset of `wanted` out of `of` elements, as flags of membership. The choice is no dimension of a Latin
    /// hypercube.
    pub(super) fn subset(&mut self, wanted: usize, of: usize) -> Vec<bool> {
        let mut order: Vec<usize> = (0..of).collect();
        let mut is_chosen = vec![false; of];
        for i in 0..wanted.min(of) {
            order.swap(i, self.random.random_range(i..of));
            is_chosen[order[i]] = true;
        }
        is_chosen
    }
}

impl Strata {
    /// Stratum of the frame in the next dimension.
    fn next(&mut self) -> u64 {
        self.dimensions += 1;
        permuted(u64::from(self.frame), u64::from(self.frames.max(1)), hash64(self.seed, self.dimensions))
    }
}

/// Position of `number` in the permutation of the numbers below `count` that belongs to `key`: a Feistel network
/// ([LubyRackoff88](photosite_core::references#lubyrackoff88)) over the next power of four, repeated until it leads
/// below `count`.
fn permuted(number: u64, count: u64, key: u64) -> u64 {
    const ROUNDS: u64 = 8;
    let half = (u64::BITS - (count - 1).leading_zeros()).div_ceil(2);
    let mask = (1 << half) - 1;
    let mut place = number;
    loop {
        let (mut left, mut right) = (place >> half, place & mask);
        for round in 0..ROUNDS {
            (left, right) = (right, left ^ hash64(hash64(key, round), right) & mask);
        }
        place = left << half | right;
        if place < count {
            break;
        }
    }
    // Of few numbers a network reaches some orders more often than others; turned round, each place is as likely.
    (place + hash64(key, ROUNDS) % count) % count
}

#[cfg(test)]
mod tests {
    use photosite_core::math::chi_squared::survival;
    use photosite_core::math::statistics::{chi_squared, kolmogorov_smirnov, kolmogorov_smirnov_p_value};

    use super::*;

    /// Significance level of the tests of this file: at fixed seeds none may fail by chance, so a smaller p-value is a
    /// mistake.
    const LEAST_P: f64 = 1e-4;

    fn p_of_counts(observed: &[f64]) -> f64 {
        let mean = observed.iter().sum::<f64>() / observed.len() as f64;
        let (statistic, freedom) = chi_squared(observed, &vec![mean; observed.len()]);
        survival(statistic, f64::from(freedom))
    }

    #[test]
    fn every_number_has_a_place_of_its_own() {
        for count in (1..=70).chain([255, 256, 257, 1000, 4096, 10_007]) {
            for key in 0..5 {
                let mut places: Vec<u64> = (0..count).map(|number| permuted(number, count, key)).collect();
                places.sort_unstable();
                assert!(places.iter().copied().eq(0..count), "{count} {key}");
            }
        }
    }

    #[test]
    fn places_are_as_likely_as_each_other_and_pairs_of_them_too() {
        const KEYS: u64 = 20_000;
        for count in [2, 3, 5, 16, 37] {
            let mut first = vec![0.0; count];
            let mut pairs = vec![0.0; count * count];
            for key in 0..KEYS {
                let [a, b] = [0, 1].map(|number| permuted(number, count as u64, hash64(7, key)) as usize);
                first[a] += 1.0;
                pairs[a * count + b] += 1.0;
            }
            assert!(p_of_counts(&first) > LEAST_P, "{count}");
            let apart = |i: &usize| i / count != i % count;
            let pairs: Vec<f64> = (0..count * count).filter(apart).map(|i| pairs[i]).collect();
            assert!(p_of_counts(&pairs) > LEAST_P, "{count}: {pairs:?}");
        }
    }

    #[test]
    fn each_part_of_every_dimension_is_hit_by_one_frame() {
        for frames in [1, 2, 7, 100, 1001] {
            for dimension in 0..4 {
                let stratum = |frame| {
                    let mut draws = Draws::new(SamplingDescription::LatinHypercube, 11, frame, frames);
                    let value = (0..=dimension).map(|_| draws.unit()).last().expect("one");
                    assert!((0.0..1.0).contains(&value));
                    (value * f64::from(frames)) as u32
                };
                let mut strata: Vec<u32> = (0..frames).map(stratum).collect();
                strata.sort_unstable();
                assert!(strata.iter().copied().eq(0..frames), "{frames} frames, dimension {dimension}");
            }
        }
    }

    #[test]
    fn dimensions_do_not_go_together() {
        const FRAMES: u32 = 10_000;
        const SIDE: usize = 10;
        for sampling in [SamplingDescription::Independent, SamplingDescription::LatinHypercube] {
            let mut cells = vec![0.0; SIDE * SIDE];
            for frame in 0..FRAMES {
                let mut draws = Draws::new(sampling, 5, frame, FRAMES);
                let [x, y] = [draws.unit(), draws.unit()].map(|u| (u * SIDE as f64) as usize);
                cells[x * SIDE + y] += 1.0;
            }
            // With the rows and columns of a Latin hypercube fixed, the statistic is smaller than that of free counts.
            assert!(p_of_counts(&cells) > LEAST_P, "{sampling:?}: {cells:?}");
            assert!(cells.iter().any(|count| *count != f64::from(FRAMES) / cells.len() as f64));
        }
    }

    #[test]
    fn numbers_follow_their_distributions() {
        const FRAMES: u32 = 5000;
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        };
        for sampling in [SamplingDescription::Independent, SamplingDescription::LatinHypercube] {
            let draws = |frame| Draws::new(sampling, 3, frame, FRAMES);
            let p = |values: &[f64], cdf: fn(f64) -> f64| {
                kolmogorov_smirnov_p_value(kolmogorov_smirnov(values, cdf), values.len())
            };
            let units = sorted((0..FRAMES).map(|frame| draws(frame).unit()).collect());
            assert!(p(&units, |u| u) > LEAST_P, "{sampling:?}");
            let normals = sorted((0..FRAMES).map(|frame| draws(frame).normal()).collect());
            assert!(p(&normals, normal::cdf) > LEAST_P, "{sampling:?}");
            let mut counts = [0.0; 7];
            (0..FRAMES).for_each(|frame| counts[draws(frame).index(7)] += 1.0);
            assert!(p_of_counts(&counts) > LEAST_P, "{sampling:?}: {counts:?}");
        }
        // Of a Latin hypercube, numbers of frames differ by no more than the parts that a border cuts.
        let mut counts = [0u32; 7];
        (0..FRAMES).for_each(|f| counts[Draws::new(SamplingDescription::LatinHypercube, 3, f, FRAMES).index(7)] += 1);
        assert!(counts.iter().all(|count| count.abs_diff(FRAMES / 7) <= 2), "{counts:?}");
    }

    #[test]
    fn subsets_have_their_size_and_all_things_the_same_odds() {
        let mut counts = [0.0; 6];
        for frame in 0..6000 {
            let subset = Draws::new(SamplingDescription::Independent, 9, frame, 6000).subset(2, 6);
            assert_eq!(subset.iter().filter(|is_chosen| **is_chosen).count(), 2);
            (0..6).filter(|&i| subset[i]).for_each(|i| counts[i] += 1.0);
        }
        assert!(p_of_counts(&counts) > LEAST_P, "{counts:?}");
    }
}
