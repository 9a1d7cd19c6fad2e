//! Comparison of two images by figures.

use serde::Serialize;

use photosite_core::Invalid;
use photosite_core::math::normal;
use photosite_core::math::statistics::sidak_p_value;

use super::compared_image::ComparedImage;
use super::pair::{Pair, VarianceOf, once, pairs};
use super::z_scores::ZScores;

/// Settings of a comparison.
#[derive(Clone, Debug)]
pub struct ComparisonSettings {
    /// The channels to compare; `None`: all, which both images must then have.
    pub channels: Option<Vec<String>>,
    /// The probability α, 0–1, with which images that agree are said to differ.
    pub alpha: f64,
    /// ε of the relative mean squared error, not negative.
    pub epsilon: f64,
    /// The value that counts as white for the PSNR; `None`: the reference's full scale, or else its largest value.
    pub peak: Option<f64>,
    /// Number of pixels that are listed, those that differ most.
    pub worst: usize,
}

impl Default for ComparisonSettings {
    fn default() -> Self {
        Self { channels: None, alpha: 0.01, epsilon: 0.01, peak: None, worst: 5 }
    }
}

/// Comparison of two images a and b; b is the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Columns and rows.
    pub resolution_px: [usize; 2],
    /// ε of the relative mean squared errors.
    pub epsilon: f64,
    /// Channel by channel.
    pub channels: Vec<ChannelDifference>,
    /// The pixels that differ most, the worst first: those that are no numbers, then by |z|, or by |a − b| where no
    /// channel has the variances of both.
    pub worst: Vec<PixelDifference>,
    /// Whether noise explains the differences; `None` where no channel has the variances of both images.
    pub verdict: Option<Verdict>,
}

/// Difference of a channel. Errors are those of the finite pixels, in the images' unit. Numbers that do not exist or
/// are infinite are `null` in JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelDifference {
    /// Name of the channel.
    pub channel: String,
    /// Pixels of the channel.
    pub pixels: usize,
    /// Pixels left out because one side is no finite number, or its variance none that is possible.
    pub non_finite: usize,
    /// Mean of a.
    pub mean_a: f64,
    /// Mean of b.
    pub mean_b: f64,
    /// Mean of a − b.
    pub mean_difference: f64,
    /// Difference in percent of the mean of b.
    pub mean_difference_percent: f64,
    /// Root of the mean squared error, √(mean of (a − b)²).
    pub rmse: f64,
    /// Mean of (a − b)²/(b² + ε·(mean of b)²): that of [Rousselle11](photosite_core::references#rousselle11), whose ε
    /// is a radiance squared, made independent of the unit.
    pub relative_mse: f64,
    /// Mean of |a − b|.
    pub mae: f64,
    /// The value that counts as white for the PSNR.
    pub peak: f64,
    /// Peak signal-to-noise ratio 20·log₁₀(peak/RMSE), dB; infinite for equal images.
    pub psnr_db: f64,
    /// Images whose variance is known.
    pub variance_of: VarianceOf,
    /// Distribution of the z-scores, where the variances of both images are known.
    pub z_scores: Option<ZScores>,
}

/// Difference of a pixel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PixelDifference {
    /// Column, from the left.
    pub x: usize,
    /// Row, from the top.
    pub y: usize,
    /// Name of the channel.
    pub channel: String,
    /// Pixel value in a.
    pub a: f64,
    /// Pixel value in b.
    pub b: f64,
    /// z-score, where it is known; infinite (`null` in JSON) where values without variance differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
    /// Two-sided p-value of z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_value: Option<f64>,
}

/// Whether noise explains the differences. All pixels of all channels are tested at once, and with them each channel's
/// mean, which shows what is too faint for a pixel alone. Images that agree are said to differ with probability α,
/// however many pixels they have (Šidák's correction, [Sidak67](photosite_core::references#sidak67)). Valid for
/// variances from many samples; see [`ZScores`] for few.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The probability of a wrong "differ".
    pub alpha: f64,
    /// Number n of z-scores tested: those of pixels, and one a channel.
    pub tests: usize,
    /// A test fails below this two-sided p-value, 1 − (1 − α)^(1/n).
    pub p_bound: f64,
    /// Limit of |z|: a test fails above it.
    pub z_bound: f64,
    /// Pixels that fail, those of every channel counted.
    pub pixels_past_bound: usize,
    /// Channels whose mean fails.
    pub channels_past_bound: Vec<String>,
    /// Whether all tests pass.
    pub agree: bool,
}

/// Compares two images of one size and unit that have the same channels. The second is the reference.
pub fn compare(a: &ComparedImage, b: &ComparedImage, settings: &ComparisonSettings) -> Result<Comparison, Invalid> {
    let pairs = pairs(a, b, settings.channels.as_deref())?;
    let channels: Vec<_> = pairs.iter().map(|pair| channel_difference(pair, b.full_scale, settings)).collect();
    let width = a.mean.width();
    Ok(Comparison {
        resolution_px: [width, a.mean.height()],
        epsilon: settings.epsilon,
        verdict: verdict(&pairs, &channels, settings.alpha),
        channels,
        worst: worst(&pairs, width, settings.worst),
    })
}

fn channel_difference(pair: &Pair<'_>, full_scale: Option<f64>, settings: &ComparisonSettings) -> ChannelDifference {
    let pixels = pair.pixels().count();
    let finite = pair.finite_pixels().count();
    let n = finite as f64;
    let mean = |value: &dyn Fn(usize) -> f64| pair.finite_pixels().map(value).sum::<f64>() / n;
    let (mean_a, mean_b) = (mean(&|i| pair.a(i)), mean(&|i| pair.b(i)));
    let mean_difference = mean(&|i| pair.difference(i));
    let rmse = mean(&|i| pair.difference(i).powi(2)).sqrt();
    let largest = || pair.finite_pixels().map(|i| pair.b(i)).fold(f64::NEG_INFINITY, f64::max);
    let peak = settings.peak.or(full_scale).unwrap_or_else(largest);
    ChannelDifference {
        channel: pair.name.to_owned(),
        pixels,
        non_finite: pixels - finite,
        mean_a,
        mean_b,
        mean_difference,
        mean_difference_percent: if mean_difference == 0.0 { 0.0 } else { 100.0 * mean_difference / mean_b.abs() },
        rmse,
        relative_mse: mean(&|i| relative_difference(pair, i, mean_b, settings.epsilon).powi(2)),
        mae: mean(&|i| pair.difference(i).abs()),
        peak,
        psnr_db: 20.0 * (peak / rmse).log10(),
        variance_of: pair.variance_of(),
        z_scores: pair
            .has_variance()
            .then(|| ZScores::new(pair.finite_pixels().map(|i| (pair.difference(i), pair.variance(i))))),
    }
}

/// (a − b)/√(b² + ε·(mean of b)²), the signed root of what the relative mean squared error is the mean of.
pub(super) fn relative_difference(pair: &Pair<'_>, i: usize, mean_b: f64, epsilon: f64) -> f64 {
    let difference = pair.difference(i);
    if difference == 0.0 { 0.0 } else { difference / (pair.b(i).powi(2) + epsilon * mean_b.powi(2)).sqrt() }
}

fn verdict(pairs: &[Pair<'_>], channels: &[ChannelDifference], alpha: f64) -> Option<Verdict> {
    let known: Vec<_> = channels.iter().filter_map(|c| Some((&c.channel, c.z_scores.as_ref()?))).collect();
    if known.is_empty() {
        return None;
    }
    let tests = known.iter().map(|(_, z)| z.tests + 1).sum();
    let p_bound = sidak_p_value(alpha, tests);
    let z_bound = normal::two_sided_bound(p_bound);
    let past = |pair: &Pair<'_>| pair.finite_pixels().filter(|&i| pair.z(i).is_some_and(|z| z.abs() > z_bound)).count();
    let pixels_past_bound = pairs.iter().map(past).sum();
    let channels_past_bound: Vec<_> =
        known.iter().filter(|(_, z)| z.of_mean.abs() > z_bound).map(|&(name, _)| name.clone()).collect();
    let agree = pixels_past_bound == 0 && channels_past_bound.is_empty();
    Some(Verdict { alpha, tests, p_bound, z_bound, pixels_past_bound, channels_past_bound, agree })
}

/// The `count` pixels that differ most.
fn worst(pairs: &[Pair<'_>], width: usize, count: usize) -> Vec<PixelDifference> {
    let tested = pairs.iter().any(Pair::has_variance);
    let mut found: Vec<(f64, &Pair<'_>, usize)> = Vec::new();
    for pair in once(pairs).filter(|pair| pair.has_variance() == tested) {
        for i in pair.pixels() {
            let difference = if tested { pair.z(i).unwrap_or(0.0) } else { pair.difference(i) };
            let badness = if pair.is_finite(i) { difference.abs() } else { f64::INFINITY };
            if badness > 0.0 && (found.len() < count || found.last().is_some_and(|last| badness > last.0)) {
                let place = found.partition_point(|other| other.0 >= badness);
                found.insert(place, (badness, pair, i));
                found.truncate(count);
            }
        }
    }
    let pixel = |(_, pair, i): (f64, &Pair<'_>, usize)| {
        let z = if pair.is_finite(i) { pair.z(i) } else { None };
        PixelDifference {
            x: i % width,
            y: i / width,
            channel: pair.name.to_owned(),
            a: pair.a(i),
            b: pair.b(i),
            z,
            p_value: z.map(normal::two_sided_p_value),
        }
    };
    found.into_iter().map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use proptest::prelude::*;
    use rand::RngExt;
    use rand_distr::StandardNormal;
    use rstest::rstest;
    use statrs::distribution::{ContinuousCDF, Normal};

    use super::*;
    use crate::validation::compared_image::tests::image;
    use photosite_core::math::philox::Philox;

    fn compared(a: &ComparedImage, b: &ComparedImage) -> Comparison {
        compare(a, b, &ComparisonSettings::default()).expect("comparable")
    }

    /// Comparison of one channel `a` of constant variance 1 with a reference of exactly 100.
    fn against_100(width: usize, height: usize, a: &[f32]) -> Comparison {
        let b = image(width, height, &[("Y", &vec![100.0; a.len()])]).with_constant_variance(0.0);
        compared(&image(width, height, &[("Y", a)]).with_variances(&[("Y", &vec![1.0; a.len()])]), &b)
    }

    #[test]
    fn errors_by_hand() {
        let a = image(2, 2, &[("Y", &[1.0, 2.0, 5.0, 4.0])]);
        let b = image(2, 2, &[("Y", &[1.0, 4.0, 4.0, 3.0])]);
        let found = compared(&a, &b);
        let c = &found.channels[0];
        assert_eq!((c.mean_a, c.mean_b, c.mean_difference, c.mean_difference_percent), (3.0, 3.0, 0.0, 0.0));
        assert_eq!((c.rmse, c.mae, c.peak), (1.5f64.sqrt(), 1.0, 4.0));
        // Squared differences 0, 4, 1, 1 over b² + 0.01·3².
        assert_relative_eq!(c.relative_mse, (4.0 / 16.09 + 1.0 / 16.09 + 1.0 / 9.09) / 4.0, max_relative = 1e-12);
        assert_relative_eq!(c.psnr_db, 10.0 * (16.0 / 1.5f64).log10(), max_relative = 1e-12);
        assert!(c.z_scores.is_none() && found.verdict.is_none());
        let worst: Vec<_> = found.worst.iter().map(|p| (p.x, p.y, p.a, p.b)).collect();
        assert_eq!(worst, [(1, 0, 2.0, 4.0), (0, 1, 5.0, 4.0), (1, 1, 4.0, 3.0)], "equal pixels are not listed");
    }

    #[rstest]
    #[case::full_scale(Some(255.0), None, 255.0)]
    #[case::what_the_user_says(Some(255.0), Some(2.0), 2.0)]
    #[case::the_largest(None, None, 3.0)]
    fn the_peak_is(#[case] full_scale: Option<f64>, #[case] peak: Option<f64>, #[case] expected: f64) {
        let b = ComparedImage { full_scale, ..image(2, 1, &[("Y", &[1.0, 3.0])]) };
        let found = compare(&b, &b, &ComparisonSettings { peak, ..ComparisonSettings::default() }).expect("comparable");
        assert_eq!((found.channels[0].peak, found.channels[0].psnr_db), (expected, f64::INFINITY));
    }

    #[test]
    fn a_black_reference_is_infinitely_different_from_light() {
        let (a, b) = (image(1, 1, &[("Y", &[1.0])]), image(1, 1, &[("Y", &[0.0])]));
        let c = &compared(&a, &b).channels[0];
        assert_eq!((c.mean_difference_percent, c.relative_mse), (f64::INFINITY, f64::INFINITY));
        let c = &compared(&b, &b).channels[0];
        assert_eq!((c.mean_difference_percent, c.relative_mse), (0.0, 0.0));
    }

    proptest! {
        #[test]
        fn other_units_change_nothing_but_the_unit(
            values in prop::collection::vec((0u16..1000, 0u16..1000, 1u16..50), 12),
            exponent in -20i32..20,
        ) {
            let scale = 2f32.powi(exponent);
            let plane = |of: fn(&(u16, u16, u16)) -> u16, scale: f32| {
                values.iter().map(|v| f32::from(of(v)) * scale).collect::<Vec<_>>()
            };
            let compared = |scale: f32| {
                let a = image(4, 3, &[("Y", &plane(|v| v.0, scale))]);
                let b = image(4, 3, &[("Y", &plane(|v| v.1, scale))]);
                let a = a.with_variances(&[("Y", &plane(|v| v.2, scale * scale))]);
                compared(&a, &b.with_constant_variance(0.0))
            };
            // Powers of two scale without rounding, but logarithms and squares of ε may round.
            let ([unit, scaled], s) = ([compared(1.0), compared(scale)], f64::from(scale));
            let [u, c] = [&unit, &scaled].map(|found| &found.channels[0]);
            prop_assert_eq!([c.mean_a, c.mean_difference, c.rmse, c.mae], [u.mean_a, u.mean_difference, u.rmse, u.mae].map(|x| x * s));
            prop_assert_eq!((c.mean_difference_percent, &c.z_scores), (u.mean_difference_percent, &u.z_scores));
            prop_assert!((c.relative_mse - u.relative_mse).abs() <= 1e-12 * u.relative_mse);
            prop_assert!((c.psnr_db - u.psnr_db).abs() <= 1e-9 || c.psnr_db == u.psnr_db);
            prop_assert_eq!(scaled.verdict, unit.verdict);
        }
    }

    #[rstest]
    #[case::just_inside(0.999, true)]
    #[case::just_outside(1.001, false)]
    #[case::just_inside_below(-0.999, true)]
    #[case::just_outside_below(-1.001, false)]
    fn a_pixel_at_the_bound(#[case] bounds: f64, #[case] agree: bool) {
        // 40 × 25 pixels and their mean are 1001 tests at α = 1 %.
        let p = 1.0 - 0.99f64.powf(1.0 / 1001.0);
        let bound = -Normal::new(0.0, 1.0).expect("valid").inverse_cdf(p / 2.0);
        let mut a = vec![100.0; 1000];
        a[7 * 40 + 3] += (bounds * bound) as f32;
        let found = against_100(40, 25, &a);
        let verdict = found.verdict.expect("variances are known");
        assert_relative_eq!(verdict.z_bound, bound, max_relative = 1e-6);
        assert_eq!((verdict.agree, verdict.pixels_past_bound, verdict.tests), (agree, usize::from(!agree), 1001));
        let worst = &found.worst[0];
        assert_eq!((worst.x, worst.y, &worst.channel[..], worst.b), (3, 7, "Y", 100.0));
        assert_relative_eq!(worst.z.expect("known"), bounds * bound, max_relative = 1e-5);
    }

    #[test]
    fn what_is_too_faint_for_a_pixel_shows_in_the_mean() {
        // A tenth of a standard deviation everywhere is 0.1·√10 000 = 10 standard errors of the mean.
        let found = against_100(100, 100, &[100.1; 10_000]);
        let verdict = found.verdict.expect("variances are known");
        assert_eq!((verdict.pixels_past_bound, &verdict.channels_past_bound[..]), (0, &["Y".to_owned()][..]));
        assert!(!verdict.agree);
        assert_relative_eq!(found.channels[0].z_scores.as_ref().expect("known").of_mean, 10.0, max_relative = 1e-4);
    }

    #[test]
    fn variances_of_both_sides_add() {
        let a = image(1, 1, &[("Y", &[5.0])]).with_variances(&[("Y", &[9.0])]);
        let b = image(1, 1, &[("Y", &[0.0])]).with_variances(&[("Y", &[16.0])]);
        assert_eq!(compared(&a, &b).worst[0].z, Some(1.0));
        let exact = image(1, 1, &[("Y", &[0.0])]).with_constant_variance(0.0);
        assert_eq!(compared(&exact, &b).worst, [], "0 of 4");
        assert_eq!(compared(&b, &a).worst[0].z, Some(-1.0));
    }

    #[test]
    fn images_that_agree_pass_as_often_as_alpha_says() {
        let mut random = Philox::new(11, 0);
        let mut noise = || (0..200).map(|_| random.sample::<f32, _>(StandardNormal)).collect::<Vec<_>>();
        let settings = ComparisonSettings { alpha: 0.2, ..ComparisonSettings::default() };
        let ones = [1.0; 200];
        let mut differ = 0;
        for _ in 0..1000 {
            let mut noisy = || {
                let (r, g) = (noise(), noise());
                image(20, 10, &[("R", &r), ("G", &g)]).with_variances(&[("R", &ones), ("G", &ones)])
            };
            let verdict = compare(&noisy(), &noisy(), &settings).expect("comparable").verdict;
            differ += u32::from(!verdict.expect("variances are known").agree);
        }
        // Binomial: 200 ± √(1000·0.2·0.8) = 13; 4 of them.
        assert!((200 - 52..=200 + 52).contains(&differ), "{differ} of 1000");
    }

    #[test]
    fn pixels_that_are_no_numbers_are_counted_and_come_first() {
        let a = image(2, 2, &[("Y", &[1.0, f32::NAN, 3.0, 4.0])]);
        let b = image(2, 2, &[("Y", &[f32::INFINITY, 2.0, 3.0, 8.0])]);
        let noisy = a.clone().with_variances(&[("Y", &[1.0, 1.0, -1.0, 1.0])]);
        let found = compared(&noisy, &b.clone().with_constant_variance(0.0));
        let c = &found.channels[0];
        assert_eq!((c.pixels, c.non_finite, c.mean_difference, c.rmse), (4, 3, -4.0, 4.0));
        assert_eq!(c.z_scores.as_ref().map(|z| z.tests), Some(1));
        assert!(found.worst[..3].iter().all(|p| p.z.is_none()) && found.worst[3].z == Some(-4.0));
        assert_eq!(compared(&a, &b).channels[0].non_finite, 2);
    }

    #[test]
    fn pixels_without_variance_that_differ_fail_however_little() {
        let a = image(2, 1, &[("Y", &[1.0, 2.0])]).with_variances(&[("Y", &[0.0, 0.0])]);
        let verdict = |b: &ComparedImage| compared(&a, b).verdict.expect("variances are known");
        assert!(verdict(&a).agree);
        let other = image(2, 1, &[("Y", &[1.0, 2.0 + f32::EPSILON * 2.0])]);
        let found = verdict(&other.with_constant_variance(0.0));
        assert_eq!((found.agree, found.pixels_past_bound), (false, 1));
    }

    #[test]
    fn channels_without_variances_are_compared_but_not_tested() {
        let a = image(1, 1, &[("R", &[1.0]), ("G", &[90.0])]).with_variances(&[("R", &[1.0])]);
        let b = image(1, 1, &[("R", &[1.5]), ("G", &[1.0])]).with_constant_variance(0.0);
        let found = compared(&a, &b);
        assert_eq!(found.channels.iter().map(|c| c.variance_of).collect::<Vec<_>>(), [VarianceOf::Both, VarianceOf::B]);
        assert_eq!(found.channels.iter().map(|c| c.z_scores.is_some()).collect::<Vec<_>>(), [true, false]);
        assert_eq!(found.verdict.expect("variances are known").tests, 2);
        assert_eq!(found.worst.iter().map(|p| &p.channel[..]).collect::<Vec<_>>(), ["R"]);
    }

    #[test]
    fn a_variance_that_is_not_known_is_not_0() {
        // Both with noise of variance 1, of which one alone is known: reckoned with that one, z would spread by √2 and
        // among 4000 numbers lie beyond the bound.
        let mut random = Philox::new(3, 0);
        let mut noise = || (0..4000).map(|_| random.sample::<f32, _>(StandardNormal)).collect::<Vec<_>>();
        let mut noisy = || image(80, 50, &[("Y", &noise())]);
        let (a, b) = (noisy().with_constant_variance(1.0), noisy());
        for (found, known) in [(compared(&a, &b), VarianceOf::A), (compared(&b, &a), VarianceOf::B)] {
            let channel = &found.channels[0];
            assert_eq!((channel.variance_of, &channel.z_scores, &found.verdict), (known, &None, &None));
            assert!(found.worst.iter().all(|pixel| pixel.z.is_none() && (pixel.a - pixel.b).abs() > 3.0));
        }
        assert!(!compared(&a, &b.clone().with_constant_variance(0.0)).verdict.expect("both are known").agree);
        let both = compared(&a, &b.with_constant_variance(1.0));
        assert!(both.verdict.expect("both are known").agree);
        // A spread of n numbers errs by 1/√(2n); 4 of that.
        let spread = both.channels[0].z_scores.as_ref().expect("both are known").spread;
        assert!((spread - 1.0).abs() < 4.0 / 8000f64.sqrt(), "{spread}");
    }
}
