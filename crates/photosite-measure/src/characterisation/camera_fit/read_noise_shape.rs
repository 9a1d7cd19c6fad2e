//! Shape of the read noise: how unequal the pixels are, and how heavy their tails.
//!
//! Differences D of pairs of dark images are taken, without what rows and columns share. A pixel of the standard
//! deviation σ·f has ⟨|D|⟩ = c·σ·f, where c depends on the distribution alone. So the covariance of |D| of two
//! pairs over the pixels, divided by the squared mean, is the variance of f over its squared mean, whatever the tails:
//!
//! s² = Cov(|D₁|, |D₂|)/⟨|D|⟩²
//!
//! and what is left of ⟨|D|⟩ against √⟨D²⟩ tells the degrees of freedom ν of Student's t distribution. Both moments
//! are finite where ν > 2, while the kurtosis is infinite up to ν = 4. Rounding and the noise of the dark current, the
//! same in all pixels, count in the expected moments by their variance and fourth cumulant κ: with a normal number, to
//! the variance V together, they have ⟨|D|⟩ = √(2V/π)·(1 − κ/(24·V²)), the Gram–Charlier series to its second term.

use rand::RngExt;

use photosite_core::Result;
use photosite_core::math::float::rounded;
use photosite_core::math::philox::Philox;

use super::measured::Measured;
use super::patterns::MendedFrames;

/// Fewest images of two pairs.
pub(super) const FEWEST_IMAGES: usize = 4;
/// Degrees of freedom of the heaviest tails that are looked for: near 2 no standard deviation settles.
const FEWEST_FREEDOM: f64 = 2.75;
/// Largest spread that is looked for, the largest that a sensor file may state.
const MOST_SPREAD: f64 = 10.0;

/// Shape of the read noise, each figure 0 for pixels that are alike and normally distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReadNoiseShape {
    /// s², squared spatial standard deviation of the pixels' read noise over its mean.
    pub(super) squared_spread: Measured,
    /// 1/ν, reciprocal degrees of freedom of Student's t distribution.
    pub(super) tails: Measured,
}

/// Part of the dark numbers that may be 0 where no converter or camera clips them.
const MOST_CLIPPED: f64 = 0.001;

/// A shape, or the reason why the images do not tell it.
pub(super) type Found = std::result::Result<ReadNoiseShape, String>;

/// Noise of a number beside the read noise, the same in all pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OtherNoise {
    /// Variance, DN².
    pub(super) variance: f64,
    /// Standard error of the variance, DN².
    pub(super) error: f64,
    /// Fourth cumulant, DN⁴.
    pub(super) fourth_cumulant: f64,
    /// Standard deviation of the variance over the pixels, DN².
    pub(super) uneven: f64,
}

impl OtherNoise {
    /// No other noise.
    pub(super) const NONE: Self = Self { variance: 0.0, error: 0.0, fourth_cumulant: 0.0, uneven: 0.0 };
    /// Even noise of a step of the converter, DN.
    fn rounding(step: f64) -> Self {
        Self { variance: step.powi(2) / 12.0, fourth_cumulant: -step.powi(4) / 120.0, ..Self::NONE }
    }

    /// Noise of the dark current: electrons of a Poisson distribution, whose variance in DN² is known, times K. `uneven` is
    /// the standard deviation of the dark signal over the pixels, DN.
    pub(super) fn of_dark_current(variance: Measured, uneven: f64, system_gain: f64) -> Self {
        let Measured { value, standard_error } = variance;
        let fourth_cumulant = value * system_gain.powi(2);
        Self { variance: value, error: standard_error, fourth_cumulant, uneven: uneven * system_gain }
    }

    /// The sum of two independent noises.
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            variance: self.variance + other.variance,
            error: self.error.hypot(other.error),
            fourth_cumulant: self.fourth_cumulant + other.fourth_cumulant,
            uneven: self.uneven.hypot(other.uneven),
        }
    }

    /// The noise with a variance that is wrong by its standard error.
    fn off_by_an_error(self) -> Self {
        Self { variance: self.variance + self.error, ..self }
    }
}

/// Means over all pixels of moments of |D|, DN and DN².
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moments {
    /// ⟨|D|⟩.
    absolute: f64,
    /// ⟨D²⟩.
    square: f64,
    /// ⟨|D₁|·|D₂|⟩ of two pairs.
    product: f64,
}

impl ReadNoiseShape {
    /// Shape in the images of a group, of which there must be [`FEWEST_IMAGES`], with other noise beside the read noise;
    /// the inner `Err` says why the images do not tell it.
    pub(super) fn of(frames: &MendedFrames<'_>, group: usize, other: OtherNoise) -> Result<Found> {
        let [width, height] = frames.frames.size;
        let images = frames.frames.groups[group].images.len();
        let mut sums = vec![[0f32; 2]; width * height];
        let (mut step, mut clipped) = (0, 0);
        for pair in 0..images / 2 {
            let [first, second] = [frames.image(group, 2 * pair)?, frames.image(group, 2 * pair + 1)?];
            if pair == 0 {
                step = step_of(&first, &second);
            }
            clipped += first.iter().chain(&second).filter(|&&number| number == 0).count();
            let difference = difference(&first, &second, width, step, pair);
            sums.iter_mut().zip(&difference).for_each(|(sums, d)| {
                sums[0] += d.abs();
                sums[1] += d * d;
            });
        }
        let part = clipped as f64 / (width * height * (images / 2) * 2) as f64;
        if part > MOST_CLIPPED {
            let percent = rounded(100.0 * part, 2);
            return Ok(Err(format!(
                "{percent} % of the dark numbers are 0, where noise ends: there is more than is found"
            )));
        }
        // Of the converter, and of the noise that hides its steps.
        let rounding = OtherNoise::rounding(step.into());
        let other = other.plus(rounding).plus(rounding);
        let shared = 1.0 / width as f64 + 1.0 / height as f64;
        let squares: f64 = sums.iter().map(|[_, square]| f64::from(*square)).sum();
        let all = squares / (2 * sums.len() * (images / 2)) as f64;
        if all - other.variance < f64::from(step).powi(2) {
            return Ok(Err("quantisation hides it".to_owned()));
        }
        let shape = Self::of_sums(&sums, images / 2, shared, other);
        if shape.squared_spread.value > (0.99 * MOST_SPREAD).powi(2) || shape.tails.value > 0.99 / FEWEST_FREEDOM {
            let reason = format!(
                "its tails are heavier than those of {FEWEST_FREEDOM} degrees of freedom, or pixels too unequal"
            );
            return Ok(Err(reason));
        }
        Ok(Ok(shape))
    }

    /// Relative standard error of the mean square over so many pixels, which are some of those that the sensor could have:
    /// of the log-normal factors, ⟨f⁴⟩ = (1 + s²)⁴.
    pub(super) fn error_of_sample(&self, pixels: usize) -> f64 {
        (((1.0 + self.squared_spread.value.max(0.0)).powi(4) - 1.0) / pixels as f64).sqrt()
    }

    /// Shape from Σ|D| and Σ D² over the pairs of each pixel. `shared` is the part a of a pixel's variance that went off
    /// with the means of its row and column.
    fn of_sums(sums: &[[f32; 2]], pairs: usize, shared: f64, other: OtherNoise) -> Self {
        let [n, k] = [sums.len(), pairs].map(|count| count as f64);
        let of_pixel = |&[absolute, square]: &[f32; 2]| {
            let [absolute, square] = [absolute, square].map(f64::from);
            [absolute / k, square / k, (absolute * absolute - square) / (k * (k - 1.0))]
        };
        let (mut means, mut products) = ([0.0; 3], [[0.0; 3]; 3]);
        for values in sums.iter().map(of_pixel) {
            for i in 0..3 {
                means[i] += values[i];
                (0..3).for_each(|j| products[i][j] += values[i] * values[j]);
            }
        }
        let means = means.map(|sum| sum / n);
        let covariance = |i: usize, j: usize| (products[i][j] / n - means[i] * means[j]) / n;
        let solve = |means: [f64; 3]| Moments::from(means).shape(other, shared);
        // Errors of the figures by those of the moments: gᵀ·C·g, with derivatives over two standard errors; and by that of
        // the other noise.
        let gradient: [[f64; 2]; 3] = std::array::from_fn(|i| {
            let step = covariance(i, i).max(0.0).sqrt().max(f64::MIN_POSITIVE);
            let at = |sign: f64| solve(std::array::from_fn(|j| means[j] + if i == j { sign * step } else { 0.0 }));
            let [above, below] = [at(1.0), at(-1.0)];
            std::array::from_fn(|figure| (above[figure] - below[figure]) / (2.0 * step))
        });
        let value = solve(means);
        let off = Moments::from(means).shape(other.off_by_an_error(), shared);
        let [squared_spread, tails]: [Measured; 2] = std::array::from_fn(|figure| {
            let pairs = (0..9).map(|ij| (ij / 3, ij % 3));
            let variance =
                pairs.map(|(i, j)| gradient[i][figure] * covariance(i, j) * gradient[j][figure]).sum::<f64>();
            let of_other = off[figure] - value[figure];
            Measured::new(value[figure], variance.max(0.0).sqrt().hypot(of_other))
        });
        // Dark currents that differ from pixel to pixel pass for read noise that does: by (u/σ²)²/4, with the standard
        // deviation u of their variance.
        let read = (means[1] / 2.0 / (1.0 - shared) - other.variance).max(f64::MIN_POSITIVE);
        let of_uneven = (other.uneven / read).powi(2) / 4.0;
        let squared_spread =
            Measured { standard_error: squared_spread.standard_error.hypot(of_uneven), ..squared_spread };
        Self { squared_spread, tails }
    }
}

impl From<[f64; 3]> for Moments {
    fn from([absolute, square, product]: [f64; 3]) -> Self {
        Self { absolute, square, product }
    }
}

impl Moments {
    /// s² and 1/ν that give these moments, with other noise beside the read noise. Where chance makes pixels
    /// more than alike or tails less than normal, the figures are below 0.
    ///
    /// Taking off the means of rows and columns leaves (1 − a)²·V_p of the variance V_p of a pixel's D, and adds
    /// a·(1 − a)·V of the other pixels, with the mean V over all.
    fn shape(self, other: OtherNoise, shared: f64) -> [f64; 2] {
        let own = 1.0 - shared;
        let all = self.square / 2.0 / own;
        let noise = Noise {
            variance: (all - other.variance).max(0.0) * own * own,
            other: OtherNoise {
                variance: other.variance * own * own + shared * own * all,
                fourth_cumulant: other.fourth_cumulant * own.powi(4),
                ..other
            },
        };
        let covariance = self.product / self.absolute.powi(2) - 1.0;
        let spread_of = |tails| {
            let scales = Scales::of(tails);
            rising_root([0.0, MOST_SPREAD], |spread| noise.moments(spread, &scales).1 - covariance)
        };
        let (mut spread, mut tails) = (spread_of(0.0), 0.0);
        // The spread hardly depends on the tails, so that few rounds do.
        for _ in 0..3 {
            let missing = |tails| 1.0 - noise.moments(spread, &Scales::of(tails)).0 / self.absolute;
            tails = rising_root([0.0, 1.0 / FEWEST_FREEDOM], missing);
            if tails == 0.0 {
                // ⟨|D|⟩ falls by the excess kurtosis of D over 24, which for small 1/ν is 3/ν.
                tails = -8.0 * missing(0.0);
                break;
            }
            spread = spread_of(tails);
        }
        [if spread == 0.0 { covariance.min(0.0) } else { spread * spread }, tails]
    }
}

/// Noise of a pixel, DN².
#[derive(Clone, Copy)]
struct Noise {
    /// Mean square of the read noise over all pixels.
    variance: f64,
    other: OtherNoise,
}

impl Noise {
    /// ⟨|D|⟩ in DN, and Cov(|D₁|, |D₂|)/⟨|D|⟩² over the pixels. The logarithm of the pixels' factors f is normal with
    /// the variance t² = ln(1 + s²), ⟨f²⟩ = 1.
    fn moments(self, spread: f64, scales: &Scales) -> (f64, f64) {
        // Trapezoids over a smooth function that ends in zeros converge faster than any power of the step.
        const STEP: f64 = 0.5;
        const REACH: i32 = 12;
        let t = (spread * spread).ln_1p().sqrt();
        let (mut weights, mut mean, mut square) = (0.0, 0.0, 0.0);
        for i in -REACH..=REACH {
            let n = f64::from(i) * STEP;
            let weight = (-0.5 * n * n).exp();
            let of_pixel = self.variance * (2.0 * t * n - 2.0 * t * t).exp();
            let absolute = scales.mean_root(of_pixel, self.other);
            weights += weight;
            mean += weight * absolute;
            square += weight * absolute * absolute;
        }
        let (mean, square) = (mean / weights, square / weights);
        // Of a normal number, ⟨|x|⟩ = √(2/π)·σ.
        (mean * std::f64::consts::FRAC_2_PI.sqrt(), square / (mean * mean) - 1.0)
    }
}

/// Student's t distribution of standard deviation 1 as a mixture of normal ones: variances of the difference of two
/// numbers, with their weights.
struct Scales(Vec<(f64, f64)>);

impl Scales {
    /// Scales for reciprocal degrees of freedom; 0 and below are normal.
    fn of(tails: f64) -> Self {
        if tails < 1e-3 {
            return Self(vec![(2.0, 1.0)]);
        }
        // t = n/√g with g = e^u following χ²/ν, whose density over u goes with exp(ν/2·(u − e^u)).
        let freedom = 1.0 / tails;
        let log_weight = |u: f64| 0.5 * freedom * (u - u.exp() + 1.0);
        let step = 0.5 * (2.0 * tails).sqrt().min(1.0);
        // A root of 1/g goes to infinity as g goes to 0, and its weight to 0 faster.
        let is_part = |u: f64| log_weight(u) + (-0.5 * u).max(0.0) > -16.0;
        let points = |sign: f64| (0..).map(move |i| sign * step * f64::from(i)).take_while(|&u| is_part(u));
        let variances: Vec<(f64, f64)> = points(-1.0)
            .chain(points(1.0).skip(1))
            .map(|u| ((1.0 - 2.0 * tails) / u.exp(), log_weight(u).exp()))
            .collect();
        let total: f64 = variances.iter().map(|(_, weight)| weight).sum();
        let mut pairs = Vec::new();
        for (i, (first, weight)) in variances.iter().enumerate() {
            for (j, (second, other)) in variances[..=i].iter().enumerate() {
                let times = if i == j { 1.0 } else { 2.0 };
                pairs.push((first + second, times * weight * other / (total * total)));
            }
        }
        Self(pairs)
    }

    /// √(π/2)·⟨|D|⟩ of the difference of two numbers with read noise of this variance and other noise.
    fn mean_root(&self, variance: f64, other: OtherNoise) -> f64 {
        let of = |&(scale, weight): &(f64, f64)| {
            let all = variance * scale + 2.0 * other.variance;
            weight * (all.sqrt() - 2.0 * other.fourth_cumulant / (24.0 * all.powf(1.5)))
        };
        self.0.iter().map(of).sum()
    }
}

/// Place where a rising function is 0; the end that is nearer where it is nowhere.
fn rising_root([mut low, mut high]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
    if of(low) >= 0.0 {
        return low;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if of(middle) < 0.0 { low = middle } else { high = middle }
    }
    low
}

/// Largest step of which all numbers of two images are multiples, but for an offset: more than 1 where a camera has
/// shifted its numbers to more bits.
fn step_of(first: &[u16], second: &[u16]) -> u16 {
    let gcd = |mut a: u16, mut b: u16| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let from = first.first().copied().unwrap_or_default();
    first.iter().chain(second).fold(0, |step, number| gcd(step, number.abs_diff(from))).max(1)
}

/// Difference of two images without what their rows and columns share. Even noise of a step is added to each, without
/// which the mean of |D| would hang on where between two numbers the difference of their rows and columns lies.
fn difference(first: &[u16], second: &[u16], width: usize, step: u16, pair: usize) -> Vec<f32> {
    let mut random = Philox::new(pair as u64, 0x7a11);
    let step = f32::from(step);
    let mut dithered = |y: u16| f32::from(y) + step * random.random::<f32>();
    let mut difference: Vec<f32> = first.iter().zip(second).map(|(&a, &b)| dithered(a) - dithered(b)).collect();
    let mean = |sum: f64, count: usize| (sum / count as f64) as f32;
    let height = difference.len() / width;
    let mut columns = vec![0f64; width];
    for line in difference.chunks_exact_mut(width) {
        let of_row = mean(line.iter().map(|&d| f64::from(d)).sum(), width);
        line.iter_mut().zip(&mut columns).for_each(|(d, column)| {
            *d -= of_row;
            *column += f64::from(*d);
        });
    }
    for line in difference.chunks_exact_mut(width) {
        line.iter_mut().zip(&columns).for_each(|(d, &column)| *d -= mean(column, height));
    }
    difference
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal, StudentT};
    use rstest::rstest;

    use super::*;
    use crate::characterisation::camera_fit::frame_group::{CameraFrames, FrameGroup, FrameLight};

    const SIZE: [usize; 2] = [256, 200];

    /// Numbers of an image: read noise of 3 DN, normal noise of 0.2 DN², noise of rows and columns, rounding.
    fn image(image: usize, spread: f64, freedom: Option<f64>) -> Vec<u16> {
        let mut random = Philox::new(image as u64, 1);
        let mut pixels = Philox::new(0, 2);
        let mut normal = |sigma: f64| sigma * random.sample::<f64, _>(StandardNormal);
        let [rows, columns] = [SIZE[1], SIZE[0]].map(|count| (0..count).map(|_| normal(1.3)).collect::<Vec<_>>());
        let t = (spread * spread).ln_1p().sqrt();
        let tails =
            freedom.map(|freedom| (StudentT::new(freedom).expect("above 0"), ((freedom - 2.0) / freedom).sqrt()));
        let pixel = |(row, column): (&f64, &f64)| {
            let factor = (t * pixels.sample::<f64, _>(StandardNormal) - t * t).exp();
            let own: f64 = match tails {
                Some((distribution, scale)) => scale * distribution.sample(&mut random),
                None => random.sample(StandardNormal),
            };
            let other = 0.2f64.sqrt() * random.sample::<f64, _>(StandardNormal);
            (200.0 + row + column + 3.0 * factor * own + other).round().max(0.0) as u16
        };
        rows.iter().flat_map(|row| columns.iter().map(move |column| (row, column))).map(pixel).collect()
    }

    /// Shape in some images.
    fn found(images: usize, other: OtherNoise, number: impl Fn(usize) -> Vec<u16>) -> Found {
        let group = FrameGroup {
            name: String::new(),
            time: None,
            light: FrameLight::Dark,
            temperature: None,
            images: vec![String::new(); images],
        };
        let read = |_, image| Ok(number(image));
        let frames = CameraFrames { groups: &[group], size: SIZE, bits: 16, read: &read };
        let mended = MendedFrames { frames: &frames, replacements: Vec::new() };
        ReadNoiseShape::of(&mended, 0, other).expect("images")
    }

    /// A shape that is hidden is told to be, and has no tails: by few levels, shifted to more bits or not, by blacks that
    /// are clipped, by images that are copies.
    #[rstest]
    #[case::shifted(|y: u16| y / 6 * 96, "quantisation")]
    #[case::clipped(|y: u16| y.saturating_sub(198), "% of the dark numbers are 0")]
    #[case::constant(|_: u16| 64, "quantisation")]
    fn what_hides_the_shape_is_told(#[case] change: fn(u16) -> u16, #[case] said: &str) {
        let found = found(4, OtherNoise::NONE, |number| image(number, 0.0, None).into_iter().map(change).collect());
        assert!(found.clone().is_err_and(|reason| reason.contains(said)), "{found:?}");
    }

    /// Numbers that are shifted to more bits have the shape of those that they were.
    #[test]
    fn shifted_numbers_have_the_same_shape() {
        let other = OtherNoise { variance: 0.2 * 256.0, ..OtherNoise::NONE };
        let shape = found(8, other, |number| image(number, 0.3, Some(6.0)).iter().map(|y| 16 * y).collect());
        let ReadNoiseShape { squared_spread, tails } = shape.expect("a shape");
        for (found, wanted) in [(squared_spread, 0.09), (tails, 1.0 / 6.0)] {
            assert!((found.value - wanted).abs() < 5.0 * found.standard_error, "{found:?} {wanted}");
        }
    }

    /// Dark currents that differ make the error as large as what they add.
    #[test]
    fn uneven_dark_currents_are_not_read_noise() {
        let uneven = |of: f64| OtherNoise { variance: 0.2, uneven: of, ..OtherNoise::NONE };
        let spread = |of: f64| {
            found(8, uneven(of), |number| image(number, 0.3, None)).expect("a shape").squared_spread.root().is_ok()
        };
        // (u/σ²)²/4 = 0.06 of 9 DN² against 0.09.
        assert!(spread(0.0) && !spread(4.4));
    }

    /// The shape that the noise was made with is found within five standard errors, which are small.
    #[rstest]
    #[case::alike(0.0, None, 8)]
    #[case::unequal(0.3, None, 4)]
    #[case::very_unequal(0.8, None, 8)]
    #[case::light_tails(0.0, Some(15.0), 8)]
    #[case::heavy_tails(0.0, Some(4.0), 8)]
    #[case::both(0.3, Some(6.0), 9)]
    #[case::without_kurtosis(0.5, Some(3.0), 8)]
    fn unequal_pixels_are_told_from_heavy_tails(
        #[case] spread: f64,
        #[case] freedom: Option<f64>,
        #[case] images: usize,
    ) {
        let other = OtherNoise { variance: 0.2, ..OtherNoise::NONE };
        let found = found(images, other, |number| image(number, spread, freedom)).expect("a shape");
        let wanted = [spread * spread, freedom.map_or(0.0, f64::recip)];
        for (found, wanted) in [found.squared_spread, found.tails].into_iter().zip(wanted) {
            let Measured { value, standard_error } = found;
            assert!((value - wanted).abs() < 5.0 * standard_error, "{found:?} {wanted}");
            assert!(standard_error < 0.02 + 0.1 * wanted, "{found:?}");
        }
    }

    /// ⟨|D|⟩ of Student's t distribution with three degrees of freedom, by its characteristic function
    /// (1 + √3·u)·exp(−√3·u): (2/π)∫(1 − (1 + √3·u)²·exp(−2√3·u))/u² du = 3√3/π, with the standard deviation √3.
    #[test]
    fn mixtures_have_the_moments_of_the_distribution() {
        let of = |tails: f64| Scales::of(tails).mean_root(1.0, OtherNoise::NONE) * std::f64::consts::FRAC_2_PI.sqrt();
        assert!((of(0.0) - 2.0 / std::f64::consts::PI.sqrt()).abs() < 1e-12);
        assert!((of(1.0 / 3.0) - 3.0 / std::f64::consts::PI).abs() < 1e-6, "{}", of(1.0 / 3.0));
    }
}
