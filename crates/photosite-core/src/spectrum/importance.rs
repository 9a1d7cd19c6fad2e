//! Importance of wavelengths for several responses to the same light.
//!
//! Four wavelengths λ₀…λ₃, stratified in a density p ([`WavelengthSampler`]), estimate the response R to light L by
//!
//! g(u) = ¼·Σₖ f(λₖ)/p(λₖ),   f = R·L,   λₖ where the cumulative distribution of p is u + k/4 (mod 1).
//!
//! Where p is the mean of all f, each scaled to an integral of 1, g varies by some tenths of its mean with u: of four
//! wavelengths one or two are in the red, which gives pixels colour noise. But p may be any density. For three
//! overlapping responses there is one for which each of the three g is nearly constant in u: where red is steep, so is
//! p, such that the next of the four comes in as one leaves. This module finds it. With the responses of a camera the
//! variance of g falls to a hundredth.
//!
//! The density is p ∝ exp(h)·Σ f/∫f dλ with h linear between knots, an even part added by the sampler. Gradient descent
//! over h minimises
//!
//! J = Σ over responses of ln r + G·max(0, r − 1)²,   r = v/v₀,   v = V₄ + κ·(V₁ + 1),
//!
//! where v₀ is v at h = 0, V₄ the variance of g relative to its mean squared, and V₁ that of a single wavelength, which
//! paths carry after dispersion. V₁ keeps p near the best density for one wavelength, and allows for reflectances,
//! which change f from pixel to pixel. The logarithm weighs relative reductions of the variance, so that a narrow band,
//! whose variance cannot fall, does not dominate. The term with G is for more responses than four wavelengths can
//! estimate: no response is given up for others.

use super::wavelength_sampler::{PIECES, probabilities};
use super::{LANES, Spectrum, TABLE_LEN};

/// Number of equal parts of the range of u in which g is known, a multiple of [`LANES`].
const CELLS: usize = 512;
/// Number of knots of h.
const KNOTS: usize = 32;
/// Number of steps of descent; later ones change the third digit of the remaining V₄.
const STEPS: usize = 64;
/// Length of the first steps of descent.
const STEP: f64 = 0.1;
/// Weight κ of a single wavelength: a tenth of it leaves half of V₄, but makes single wavelengths of a camera's red 4 %
/// noisier.
const LONE_PART: f64 = 0.005;
/// Weight G: with it no variance grows by more than some hundredths; without it the variance of five bands of 30 nm
/// grows by up to eight times.
const GROWTH: f64 = 10.0;

/// Importance of each wavelength for the responses (any units, not negative, the light included): a
/// [`WavelengthSampler`](super::WavelengthSampler) of it estimates each response with little variance. Positive
/// wherever one of the responses is, and zero if all are.
pub fn importance(responses: &[Spectrum]) -> Spectrum {
    let responses: Vec<&Spectrum> = responses.iter().filter(|response| response.max() > 0.0).collect();
    match *responses.as_slice() {
        [] => Spectrum::constant(0.0),
        [only] => only.clone(),
        _ => Problem::new(&responses).solved(),
    }
}

/// Several responses that share one density.
struct Problem {
    /// Σ f/∫f dλ, entry by entry of a spectral table.
    sum: Vec<f64>,
    /// Fraction of each response in each nanometre, and the sum of fractions before it.
    parts: Vec<Vec<f64>>,
    before: Vec<Vec<f64>>,
    /// Variance v₀ of each response where h is 0.
    start: Vec<f64>,
    /// Knot at or before each entry, and the fraction of the way to the next knot.
    knots: Vec<(usize, f64)>,
}

/// J and its derivatives by h at the knots.
struct Cost {
    value: f64,
    slopes: [f64; KNOTS],
}

impl Problem {
    fn new(responses: &[&Spectrum]) -> Self {
        let masses = |response: &Spectrum| -> Vec<f64> {
            let values = response.values().map(|value| f64::from(value.max(0.0)));
            let masses: Vec<f64> = values.windows(2).map(|ends| 0.5 * (ends[0] + ends[1])).collect();
            let all: f64 = masses.iter().sum();
            masses.iter().map(|mass| mass / all).collect()
        };
        let integrals: Vec<f64> = responses.iter().map(|response| response.integral()).collect();
        let share =
            |i: usize| responses.iter().zip(&integrals).map(move |(r, all)| f64::from(r.values()[i].max(0.0)) / all);
        let sum: Vec<f64> = (0..TABLE_LEN).map(|i| share(i).sum()).collect();
        let parts: Vec<Vec<f64>> = responses.iter().map(|response| masses(response)).collect();
        let before: Vec<_> = parts.iter().map(|parts| sums_before(parts)).collect();
        let (p, _) = probabilities(&sum);
        let ends = Ends::new(&p);
        let start = parts.iter().zip(&before).map(|(parts, before)| variance(&ends.excess(parts, before), parts, &p));
        let first = sum.iter().position(|&value| value > 0.0).unwrap_or(0);
        let last = sum.iter().rposition(|&value| value > 0.0).unwrap_or(0);
        let knot = |i: usize| {
            let at = i.clamp(first, last) - first;
            let place = at as f64 / (last - first).max(1) as f64 * (KNOTS - 1) as f64;
            let knot = (place as usize).min(KNOTS - 2);
            (knot, place - knot as f64)
        };
        Self { start: start.collect(), sum, parts, before, knots: (0..TABLE_LEN).map(knot).collect() }
    }

    /// The best importance that [`STEPS`] find, by the method of [KingmaBa15](crate::references#kingmaba15).
    fn solved(&self) -> Spectrum {
        const DECAY: [f64; 2] = [0.9, 0.99];
        let (mut heights, mut slopes, mut squares) = ([0.0; KNOTS], [0.0; KNOTS], [0.0; KNOTS]);
        let mut best = (f64::INFINITY, heights);
        for step in 1..=STEPS {
            let cost = self.cost(&heights);
            if cost.value < best.0 {
                best = (cost.value, heights);
            }
            let [slope_part, square_part] = DECAY.map(|decay| 1.0 - decay.powi(step as i32));
            for knot in 0..KNOTS {
                let slope = cost.slopes[knot];
                slopes[knot] = DECAY[0] * slopes[knot] + (1.0 - DECAY[0]) * slope;
                squares[knot] = DECAY[1] * squares[knot] + (1.0 - DECAY[1]) * slope * slope;
                heights[knot] -= STEP * (slopes[knot] / slope_part) / ((squares[knot] / square_part).sqrt() + 1e-9);
            }
        }
        let seen = self.sum.iter().map(|&sum| sum > 0.0);
        let mut values = self.importances(&best.1).into_iter().zip(seen);
        // What is next to nothing is not rounded to nothing.
        let least = |(value, is_seen): (f64, bool)| if is_seen { value.max(f64::from(f32::MIN_POSITIVE)) } else { 0.0 };
        Spectrum::from_fn(|_| values.next().map_or(0.0, least))
    }

    /// Importance at the entries of a table, for values of h at the knots.
    fn importances(&self, heights: &[f64; KNOTS]) -> Vec<f64> {
        let importance = |(&sum, &(knot, part)): (&f64, &(usize, f64))| {
            // That of the system need not be the same on every machine.
            sum * libm::exp(heights[knot] * (1.0 - part) + heights[knot + 1] * part)
        };
        self.sum.iter().zip(&self.knots).map(importance).collect()
    }

    fn cost(&self, heights: &[f64; KNOTS]) -> Cost {
        let importances = self.importances(heights);
        let (p, scale) = probabilities(&importances);
        let ends = Ends::new(&p);
        let mut value = 0.0;
        // Derivatives of J by the probability of each nanometre, and by that of all before it.
        let (mut by_piece, mut by_before) = (vec![0.0; PIECES], vec![0.0; PIECES + 1]);
        for ((parts, before), &start) in self.parts.iter().zip(&self.before).zip(&self.start) {
            let excess = ends.excess(parts, before);
            let variance = variance(&excess, parts, &p);
            let growth = (variance / start - 1.0).max(0.0);
            value += libm::log(variance / start) + GROWTH * growth * growth;
            let by_variance = 1.0 / variance + 2.0 * GROWTH * growth / start;
            for (cell, &(piece, t)) in ends.0.iter().enumerate() {
                // ∂V₄/∂F where cell ends, F being the part of the response up to there.
                let [this, next] = [cell, cell + 1].map(|cell| excess[cell % excess.len()]);
                let by_place = 2.0 * (this - next) * by_variance * parts[piece] / p[piece];
                by_before[piece] -= by_place * (1.0 - t);
                by_before[piece + 1] -= by_place * t;
            }
            for ((by, &part), &p) in by_piece.iter_mut().zip(parts).zip(&p) {
                if part > 0.0 {
                    *by -= LONE_PART * (part / p).powi(2) * by_variance;
                }
            }
        }
        // All before a later one grows with each.
        let mut later = by_before[PIECES];
        for piece in (0..PIECES).rev() {
            by_piece[piece] += later;
            later += by_before[piece];
        }
        Cost { value, slopes: self.slopes(&importances, &by_piece, scale) }
    }

    /// Derivatives of J by h at the knots, from those by probabilities, which are proportional to importances up to
    /// normalisation.
    fn slopes(&self, importances: &[f64], by_piece: &[f64], scale: f64) -> [f64; KNOTS] {
        let masses = importances.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]));
        let all: f64 = masses.clone().sum();
        let mean = masses.zip(by_piece).map(|(mass, by)| mass * by).sum::<f64>() / all;
        let mut slopes = [0.0; KNOTS];
        for (i, (&importance, &(knot, part))) in importances.iter().zip(&self.knots).enumerate() {
            let around = [i.checked_sub(1), (i < PIECES).then_some(i)].into_iter().flatten();
            let by = around.map(|piece| 0.5 * (by_piece[piece] - mean)).sum::<f64>() * importance * scale;
            slopes[knot] += by * (1.0 - part);
            slopes[knot + 1] += by * part;
        }
        slopes
    }
}

/// Variance v of a response: from g − 1, from the response's fractions in each nanometre, and from the probabilities of
/// nanometres.
fn variance(excess: &[f64], parts: &[f64], p: &[f64]) -> f64 {
    let of_four = excess.iter().map(|r| r * r).sum::<f64>() / excess.len() as f64;
    let squares = |(&part, &p): (&f64, &f64)| if part > 0.0 { part * part / p } else { 0.0 };
    of_four + LONE_PART * parts.iter().zip(p).map(squares).sum::<f64>()
}

/// End of each cell of u except the last: the nanometre, and the fraction of its probability.
struct Ends(Vec<(usize, f64)>);

impl Ends {
    fn new(p: &[f64]) -> Self {
        let before = sums_before(p);
        let mut piece = 0;
        let end = |cell: usize| {
            let u = cell as f64 / CELLS as f64;
            while piece + 1 < PIECES && before[piece + 1] <= u {
                piece += 1;
            }
            (piece, ((u - before[piece]) / p[piece]).clamp(0.0, 1.0))
        };
        Self((1..CELLS).map(end).collect())
    }

    /// g − 1 for each quarter of the cells.
    fn excess(&self, parts: &[f64], before: &[f64]) -> Vec<f64> {
        const QUARTER: usize = CELLS / LANES;
        let mut excess = vec![-1.0; QUARTER];
        let up_to = self.0.iter().map(|&(piece, t)| before[piece] + parts[piece] * t).chain([1.0]);
        let mut last = 0.0;
        for (cell, up_to) in up_to.enumerate() {
            excess[cell % QUARTER] += QUARTER as f64 * (up_to - last);
            last = up_to;
        }
        excess
    }
}

/// Sums of all values before each, and of all values.
fn sums_before(values: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let sums = values.iter().map(|value| {
        sum += value;
        sum
    });
    std::iter::once(0.0).chain(sums).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::{WavelengthSampler, illuminant};

    fn bell(centre: f64, width: f64) -> Spectrum {
        Spectrum::from_fn(|lambda| (-((lambda - centre) / width).powi(2)).exp())
    }

    /// Responses of red, green and blue in daylight.
    fn camera() -> Vec<Spectrum> {
        let cut = Spectrum::from_fn(|lambda| 1.0 / (1.0 + ((lambda - 670.0) / 8.0).exp()));
        let filters = [bell(610.0, 45.0), bell(540.0, 55.0), bell(460.0, 40.0)];
        filters.map(|filter| filter.product(&cut).product(illuminant::d65())).into()
    }

    /// Variance of the estimate of a response by single draws of a sampler, relative to the mean squared.
    fn variance(importance: &Spectrum, response: &Spectrum, is_alone: bool) -> f64 {
        let sampler = WavelengthSampler::new(importance);
        let n = 10_000;
        let values = (0..n).map(|i| {
            let mut wavelengths = sampler.sample((i as f32 + 0.5) / n as f32);
            if is_alone {
                wavelengths.terminate_secondary();
            }
            f64::from((wavelengths.weights() * response.sample(&wavelengths)).0.element_sum())
        });
        let (mean, squares) =
            values.fold((0.0, 0.0), |(sum, squares), v| (sum + v / f64::from(n), squares + v * v / f64::from(n)));
        // A band of 10 nm has some 500 of the points, and loses or gains one at either edge.
        assert!((mean / response.integral() - 1.0).abs() < 5e-3, "{mean}");
        squares / (mean * mean) - 1.0
    }

    fn sum(responses: &[Spectrum]) -> Spectrum {
        let integrals: Vec<f64> = responses.iter().map(Spectrum::integral).collect();
        Spectrum::from_fn(|l| responses.iter().zip(&integrals).map(|(r, all)| f64::from(r.eval(l as f32)) / all).sum())
    }

    /// Variances of all filters of a camera together in some light, without descent and with it.
    fn variances(light: &Spectrum, is_alone: bool) -> [f64; 2] {
        let of_all = |importance: &Spectrum| {
            camera().iter().map(|response| variance(importance, &response.product(light), is_alone)).sum()
        };
        [sum(&camera()), importance(&camera())].map(|importance| of_all(&importance))
    }

    #[test]
    fn four_wavelengths_tell_each_filter_of_a_camera() {
        let [before, after] = variances(&Spectrum::constant(1.0), false);
        assert!(before > 0.02 && after < 0.03 * before, "{before} {after}");
        // Those that are left alone by dispersion pay a little.
        let [before, after] = variances(&Spectrum::constant(1.0), true);
        assert!(after < 1.2 * before, "{before} {after}");
    }

    /// Light from surfaces that are not grey, and from illuminants other than the mean.
    #[test]
    fn other_light_is_told_better_too() {
        let step = |from: f64, to: f64| Spectrum::from_fn(|l| 0.05 + (1.0 / (1.0 + ((from - l) / (to - from)).exp())));
        let ramp =
            |low: f64, high: f64| Spectrum::from_fn(|l| (low + (high - low) * (l - 400.0) / 300.0).clamp(0.05, 1.0));
        for (name, light, most) in [
            ("reddish", ramp(0.1, 0.9), 0.3),
            ("bluish", ramp(0.9, 0.1), 0.3),
            ("yellow", step(520.0, 532.0), 0.3),
            ("red", step(600.0, 610.0), 0.8),
            // What little red and blue see of it is noisier.
            ("green", bell(540.0, 60.0), 2.0),
        ] {
            let [before, after] = variances(&light, false);
            assert!(after < most * before, "{name}: {before} {after}");
        }
    }

    #[test]
    fn the_slopes_are_those_of_the_cost() {
        let camera = camera();
        let problem = Problem::new(&camera.iter().collect::<Vec<_>>());
        let heights: [f64; KNOTS] = std::array::from_fn(|knot| 0.2 * (1.7 * knot as f64).sin());
        let slopes = problem.cost(&heights).slopes;
        for knot in 5..20 {
            const STEP: f64 = 1e-7;
            let at = |step: f64| {
                let mut heights = heights;
                heights[knot] += step;
                problem.cost(&heights).value
            };
            let expected = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            // Slopes jump where an end of a cell passes into another nanometre.
            assert!(
                (slopes[knot] - expected).abs() < 1e-3 * (1.0 + expected.abs()),
                "{knot}: {} {expected}",
                slopes[knot]
            );
        }
    }

    #[test]
    fn nothing_that_is_seen_is_left_out() {
        let band = Spectrum::from_fn(|lambda| f64::from(u8::from((830.0..840.0).contains(&lambda))));
        let all = [camera(), vec![band]].concat();
        for (lambda, value) in importance(&all).iter() {
            assert_eq!(value > 0.0, all.iter().any(|r| r.eval(lambda as f32) > 0.0), "{lambda}");
        }
    }

    /// Filters of cameras with more of them than a path has wavelengths, evenly and unevenly spaced.
    #[test]
    fn no_response_is_given_up_for_others() {
        let even = |count: u8, width: f64| -> Vec<Spectrum> {
            let step = 280.0 / f64::from(count - 1);
            (0..count).map(|i| bell(420.0 + step * f64::from(i), width)).collect()
        };
        let near_infrared = [camera(), vec![bell(850.0, 30.0)]].concat();
        for (name, responses, most) in [
            ("near infrared", near_infrared, 0.4),
            ("five", even(5, 15.0), 1.0),
            ("six", even(6, 20.0), 1.0),
            ("nine", even(9, 25.0), 1.0),
            ("camera and bands", [camera(), even(6, 5.0)].concat(), 1.0),
        ] {
            let [before, after] = [sum(&responses), importance(&responses)]
                .map(|importance| responses.iter().map(|r| variance(&importance, r, false)).collect::<Vec<_>>());
            // The hundredth stands for what is hardly any variance.
            let ratios: Vec<_> =
                before.iter().zip(&after).map(|(before, after)| (after + 0.01) / (before + 0.01)).collect();
            assert!(ratios.iter().all(|&ratio| ratio < 1.1), "{name}: {ratios:?}");
            let mean = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64;
            assert!(mean.exp() <= most, "{name}: {} {ratios:?}", mean.exp());
        }
    }

    #[test]
    fn one_response_is_drawn_as_it_is_and_darkness_as_nothing() {
        let dark = Spectrum::constant(0.0);
        assert_eq!(importance(&[dark.clone(), bell(500.0, 30.0)]), bell(500.0, 30.0));
        assert_eq!(importance(&[dark.clone(), dark.clone()]), dark);
        assert_eq!(importance(&[]), dark);
    }
}
