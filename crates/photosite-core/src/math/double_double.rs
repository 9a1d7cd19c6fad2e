//! Sums in 106 bits, as pairs of 53-bit numbers, exact enough that the order of the terms makes no difference.
//!
//! A sum is high + low with |low| ≤ ulp(high)/2. Adding a term keeps what rounding loses of it (by Knuth's
//! algorithm [Knuth97](crate::references#knuth97), and that of products of [Dekker71](crate::references#dekker71)). A
//! sum whose bits lie within 106 of each other is exact, in whatever order and by whatever partial sums it came about.

/// A number of 106 bits, high + low.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    /// The number, rounded to 53 bits.
    pub high: f64,
    /// Remainder beyond the rounded number, at most half of its last bit.
    pub low: f64,
}

/// Four numbers of 106 bits side by side.
#[derive(Clone, Copy, Debug, Default)]
pub struct DoubleDoubles {
    high: [f64; 4],
    low: [f64; 4],
}

impl DoubleDoubles {
    /// One of the four.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> DoubleDouble {
        DoubleDouble { high: self.high[lane], low: self.low[lane] }
    }

    /// Puts a number in its place.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, number: DoubleDouble) {
        (self.high[lane], self.low[lane]) = (number.high, number.low);
    }

    /// Adds a term to each number.
    // A loop rather than a closure, which would not be inlined into a function for wide registers.
    #[inline(always)]
    pub fn add(&mut self, terms: [f64; 4]) {
        for (lane, term) in terms.into_iter().enumerate() {
            let mut number = self.get(lane);
            number.add(term);
            self.set(lane, number);
        }
    }
}

/// a + b as its rounded value and the error of that.
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// a·b as its rounded value and the error of that, in a range where neither overflows nor underflows.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl DoubleDouble {
    /// The number high + low, normalised so that |low| ≤ ulp(high)/2. Where high overflows, the low part is
    /// meaningless.
    #[inline(always)]
    fn of(high: f64, low: f64) -> Self {
        let (sum, rest) = two_sum(high, low);
        if rest.is_finite() { Self { high: sum, low: rest } } else { Self { high, low: 0.0 } }
    }

    /// Adds a term.
    #[inline(always)]
    pub fn add(&mut self, term: f64) {
        let (sum, rest) = two_sum(self.high, term);
        *self = Self::of(sum, self.low + rest);
    }

    /// Adds another sum.
    pub fn add_sum(&mut self, other: Self) {
        let (sum, rest) = two_sum(self.high, other.high);
        let (low, rest_low) = two_sum(self.low, other.low);
        let Self { high, low } = Self::of(sum, rest + low);
        *self = Self::of(high, low + rest_low);
    }

    /// The square.
    #[must_use]
    pub fn squared(self) -> Self {
        let (high, low) = two_product(self.high, self.high);
        Self::of(high, low + 2.0 * self.high * self.low)
    }

    /// The product with a number.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        let (high, low) = two_product(self.high, factor);
        Self::of(high, low + self.low * factor)
    }

    /// The difference, rounded to 53 bits.
    pub fn minus(mut self, other: Self) -> f64 {
        self.add_sum(Self { high: -other.high, low: -other.low });
        self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::hash64;

    fn sum(terms: &[f64]) -> DoubleDouble {
        let mut sum = DoubleDouble::default();
        terms.iter().for_each(|&term| sum.add(term));
        sum
    }

    /// Whole numbers of up to 24 bits, times powers of two from 2⁰ to 2⁵⁰: their sum has at most 24 + 50 + 10 bits.
    fn terms() -> Vec<f64> {
        let term = |i: u64| {
            let bits = hash64(i, 7);
            f64::from((bits >> 40) as u32) * f64::from((bits % 51) as u32).exp2()
        };
        (0..1000).map(term).collect()
    }

    #[test]
    fn sums_are_exact_in_any_order_and_in_parts() {
        let terms = terms();
        let exact: i128 = terms.iter().map(|&term| term as i128).sum();
        let whole = sum(&terms);
        assert_eq!(whole.high as i128 + whole.low as i128, exact);
        // A plain sum has lost something.
        assert_ne!(terms.iter().sum::<f64>() as i128, exact);
        let backwards: Vec<f64> = terms.iter().rev().copied().collect();
        assert_eq!(sum(&backwards), whole);
        for cut in [1, 64, 500, 999] {
            let mut parts = sum(&terms[..cut]);
            parts.add_sum(sum(&terms[cut..]));
            assert_eq!(parts, whole, "cut at {cut}");
        }
    }

    #[test]
    fn squares_and_differences_keep_what_plain_numbers_lose() {
        // (2⁵² + 1 + 2⁻³⁰)² − 2¹⁰⁴ − 2⁵³ = 1 + 2²³ + 2⁻²⁹ + 2⁻⁶⁰.
        let number = sum(&[52f64.exp2() + 1.0, (-30f64).exp2()]);
        let rest = number.squared().minus(sum(&[104f64.exp2(), 53f64.exp2()]));
        // Its smallest digits lie beyond the 106th of the square.
        assert!((rest - (1.0 + 23f64.exp2())).abs() < 0.5, "{rest}");
        assert_eq!(number.times(3.0).minus(sum(&[3.0 * 52f64.exp2()])), 3.0 + 3.0 * (-30f64).exp2());
    }

    #[test]
    fn beyond_all_numbers_a_sum_is_infinite() {
        let mut sum = sum(&[1.0, f64::MAX, f64::MAX, 1.0]);
        assert_eq!(sum, DoubleDouble { high: f64::INFINITY, low: 0.0 });
        sum.add_sum(sum);
        assert_eq!(sum.high, f64::INFINITY);
    }
}
