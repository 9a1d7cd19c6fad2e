//! Discrete and piecewise-constant distributions, which choose a light, or a direction in an environment map.

/// A function on [0, 1) that is constant on n equal pieces, normalised to a density, sampled by inverting its
/// cumulative sum. Samples keep the stratification of their input. A guide table makes a sample cost O(1) on average
/// ([Devroye86](crate::references#devroye86) §III.2.4).
#[derive(Clone, Debug)]
pub struct PiecewiseConstant1D {
    /// cdf[i] = ∫ of the first i pieces; n + 1 values from 0 to 1.
    cdf: Vec<f32>,
    /// Density on each piece; its mean is 1.
    density: Vec<f32>,
    /// Guide table: for each of n equal parts of [0, 1), the piece that its first number leads to or an earlier one.
    guide: Vec<u32>,
    integral: f64,
}

impl PiecewiseConstant1D {
    /// Distribution in proportion to non-negative, finite values, at least one. Where all are zero the distribution is
    /// uniform.
    pub fn new(values: &[f32]) -> Self {
        let n = values.len();
        assert!(n > 0 && values.iter().all(|v| v.is_finite() && *v >= 0.0), "values must be finite and not negative");
        let sum: f64 = values.iter().map(|&v| f64::from(v)).sum();
        let mut cdf = Vec::with_capacity(n + 1);
        let mut running = 0.0;
        cdf.push(0.0);
        for (i, &v) in values.iter().enumerate() {
            running += if sum > 0.0 { f64::from(v) / sum } else { 1.0 / n as f64 };
            cdf.push(if i + 1 == n { 1.0 } else { running as f32 });
        }
        // The density follows from the rounded cdf, so that a sample and its density agree exactly.
        let density = cdf.windows(2).map(|w| (w[1] - w[0]) * n as f32).collect();
        // A product u·n may be rounded up to the next part, whose guide must not be past the piece of u then.
        let first = |part: usize| part as f32 / n as f32 * (1.0 - 2.0 * f32::EPSILON);
        let piece = |u: f32| cdf.partition_point(|&c| c <= u).saturating_sub(1) as u32;
        let guide = (0..n).map(|part| piece(first(part))).collect();
        Self { cdf, density, guide, integral: sum / n as f64 }
    }

    /// Integrals of the first pieces: none, one, and so on up to all, which is 1.
    pub fn cdf(&self) -> &[f32] {
        &self.cdf
    }

    /// Number of pieces.
    pub fn len(&self) -> usize {
        self.density.len()
    }

    /// Always false: a distribution has at least one piece.
    pub fn is_empty(&self) -> bool {
        self.density.is_empty()
    }

    /// Integral over [0, 1) of the function that was given, which is its mean.
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// Sample for u in [0, 1): x in [0, 1), its density, and its piece.
    #[inline]
    pub fn sample(&self, u: f32) -> (f32, f32, usize) {
        let n = self.len();
        let mut piece = self.guide[((u * n as f32) as usize).min(n - 1)] as usize;
        while piece + 1 < n && self.cdf[piece + 1] <= u {
            piece += 1;
        }
        // Rounding can land on a piece of no width at the very end.
        while self.density[piece] == 0.0 && piece > 0 {
            piece -= 1;
        }
        let width = self.cdf[piece + 1] - self.cdf[piece];
        let within = if width > 0.0 { ((u - self.cdf[piece]) / width).clamp(0.0, 1.0 - f32::EPSILON) } else { 0.5 };
        let x = ((piece as f32 + within) / n as f32).min(1.0 - f32::EPSILON / 2.0);
        (x, self.density[piece], piece)
    }

    /// Density at x in [0, 1).
    #[inline]
    pub fn pdf(&self, x: f32) -> f32 {
        self.density[((x * self.len() as f32) as usize).min(self.len() - 1)]
    }
}

/// A function on the unit square, constant on a grid of cells, sampled row first.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant2D {
    rows: Vec<PiecewiseConstant1D>,
    marginal: PiecewiseConstant1D,
}

impl PiecewiseConstant2D {
    /// Distribution in proportion to `values[row * width + column]`, non-negative and finite.
    pub fn new(values: &[f32], width: usize) -> Self {
        let rows: Vec<_> = values.chunks_exact(width).map(PiecewiseConstant1D::new).collect();
        let sums: Vec<f32> = rows.iter().map(|row| row.integral() as f32).collect();
        Self { marginal: PiecewiseConstant1D::new(&sums), rows }
    }

    /// Distribution along each row.
    pub fn rows(&self) -> &[PiecewiseConstant1D] {
        &self.rows
    }

    /// Distribution of the rows.
    pub fn marginal(&self) -> &PiecewiseConstant1D {
        &self.marginal
    }

    /// Mean of the function over the square.
    pub fn integral(&self) -> f64 {
        self.marginal.integral()
    }

    /// Sample for (u, v) in the unit square: (x, y) and its density.
    #[inline]
    pub fn sample(&self, [u, v]: [f32; 2]) -> ([f32; 2], f32) {
        let (y, row_density, row) = self.marginal.sample(v);
        let (x, density, _) = self.rows[row].sample(u);
        ([x, y], density * row_density)
    }

    /// Density at (x, y).
    #[inline]
    pub fn pdf(&self, [x, y]: [f32; 2]) -> f32 {
        let row = ((y * self.rows.len() as f32) as usize).min(self.rows.len() - 1);
        self.marginal.density[row] * self.rows[row].pdf(x)
    }
}

/// Remainder of a random number after a choice: the fraction of the interval [from, from + length) that lies below the
/// number `u` in it. It lies in [0, 1), whatever the rounding.
#[inline]
pub fn rest(u: f32, from: f32, length: f32) -> f32 {
    ((u - from) / length).clamp(0.0, 1.0 - f32::EPSILON / 2.0)
}

/// Choice of one of n things in proportion to their weights in O(1): Walker's alias method as built by
/// M. Vose, "A Linear Algorithm for Generating Random Numbers with a Given Distribution" (1991).
#[derive(Clone, Debug)]
pub struct AliasTable {
    bins: Vec<AliasBin>,
}

#[derive(Clone, Copy, Debug)]
struct AliasBin {
    /// Probability of staying in this bin once it is drawn.
    keep: f32,
    /// Entry drawn otherwise.
    alias: u32,
    /// Probability of this entry as a whole.
    probability: f32,
}

impl AliasTable {
    /// Table of non-negative, finite weights. Where all are zero the choice is uniform; an empty list gives an empty
    /// table.
    pub fn new(weights: &[f64]) -> Self {
        let n = weights.len();
        let sum: f64 = weights.iter().sum();
        let probability = |i: usize| if sum > 0.0 { weights[i] / sum } else { 1.0 / n as f64 };
        let mut bins: Vec<_> =
            (0..n).map(|i| AliasBin { keep: 1.0, alias: i as u32, probability: probability(i) as f32 }).collect();
        let mut scaled: Vec<f64> = (0..n).map(|i| probability(i) * n as f64).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| scaled[i] < 1.0);
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            bins[s].keep = scaled[s] as f32;
            bins[s].alias = l as u32;
            scaled[l] -= 1.0 - scaled[s];
            if scaled[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        Self { bins }
    }

    /// Bins as plain data: bits of the probability of staying in one, its alias, bits of its probability as a whole.
    pub fn bin_words(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.bins.iter().map(|bin| [bin.keep.to_bits(), bin.alias, bin.probability.to_bits()])
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.bins.len()
    }

    /// Whether the table has no entries.
    pub fn is_empty(&self) -> bool {
        self.bins.is_empty()
    }

    /// Sample for u in [0, 1): entry, its probability, and the remainder of u in [0, 1). The table must not be empty.
    #[inline]
    pub fn sample(&self, u: f32) -> (u32, f32, f32) {
        let scaled = u * self.bins.len() as f32;
        let number = (scaled as usize).min(self.bins.len() - 1);
        let (bin, within) = (&self.bins[number], scaled - number as f32);
        let (entry, rest) = if within < bin.keep {
            (number as u32, rest(within, 0.0, bin.keep))
        } else {
            (bin.alias, rest(within, bin.keep, 1.0 - bin.keep))
        };
        (entry, self.bins[entry as usize].probability, rest)
    }

    /// Probability of an entry.
    #[inline]
    pub fn probability(&self, entry: u32) -> f32 {
        self.bins[entry as usize].probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn piecewise_constant_inverts_its_cumulative_sum() {
        let d = PiecewiseConstant1D::new(&[1.0, 0.0, 3.0, 4.0]);
        assert!((d.integral() - 2.0).abs() < 1e-12);
        // Each of 4096 equally spaced u stands for 1/4096 of the probability.
        let mut counts = [0u32; 4];
        for i in 0..4096 {
            let (x, pdf, piece) = d.sample((i as f32 + 0.5) / 4096.0);
            assert_eq!((x * 4.0) as usize, piece);
            assert_eq!(pdf, d.pdf(x));
            counts[piece] += 1;
        }
        assert_eq!(counts, [512, 0, 1536, 2048]);
        assert!(d.sample(1.0 - f32::EPSILON / 2.0).0 < 1.0);
    }

    #[test]
    fn two_dimensions_sample_cells_in_proportion() {
        let d = PiecewiseConstant2D::new(&[0.0, 1.0, 2.0, 5.0], 2);
        let mut counts = [0u32; 4];
        for i in 0..256 * 256 {
            let u = [((i % 256) as f32 + 0.5) / 256.0, ((i / 256) as f32 + 0.5) / 256.0];
            let ([x, y], pdf) = d.sample(u);
            assert!((pdf - d.pdf([x, y])).abs() < 1e-6);
            counts[usize::from(y >= 0.5) * 2 + usize::from(x >= 0.5)] += 1;
        }
        // One row of the 256 × 256 grid falls at most on either side of each boundary.
        for (count, expected) in counts.into_iter().zip([0.0, 0.125, 0.25, 0.625]) {
            assert!((f64::from(count) / 65536.0 - expected).abs() <= 2.0 / 256.0, "{counts:?}");
        }
    }

    #[test]
    fn alias_table_has_exactly_the_probabilities_it_was_given() {
        let weights = [0.1, 5.0, 0.0, 2.0, 0.9];
        let table = AliasTable::new(&weights);
        let sum: f64 = weights.iter().sum();
        let mut counts = [0.0f64; 5];
        let n = 1 << 20;
        for i in 0..n {
            let (entry, probability, rest) = table.sample((i as f32 + 0.5) / n as f32);
            assert!((0.0..1.0).contains(&rest));
            assert_eq!(probability, table.probability(entry));
            counts[entry as usize] += 1.0 / f64::from(n);
        }
        // Equally spaced numbers: each of at most two intervals per entry is off by one step at either end.
        for (count, weight) in counts.into_iter().zip(weights) {
            assert!((count - weight / sum).abs() < 10.0 / f64::from(n) + 1e-6, "{counts:?}");
        }
    }
}
