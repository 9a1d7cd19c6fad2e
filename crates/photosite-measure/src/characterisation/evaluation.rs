//! Evaluation: from statistics of images to the figures of the standard.

use serde::Serialize;

use photosite_core::Invalid;
use photosite_core::math::float::rounded;
use photosite_core::units::Seconds;

use super::figures::{Figures, SpatialFigures, sensitivity_threshold_e};
use super::fit::{Line, line, slope_error, through_origin};
use super::spatial::SpatialVariances;

/// A bright pair and the dark pair of the same exposure time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemporalPoint {
    /// Exposure time; 0 where it is not known.
    pub time: Seconds,
    /// μ_p, photons per pixel.
    pub photons: f64,
    /// μ_y, DN.
    pub mean: f64,
    /// σ_y², DN².
    pub variance: f64,
    /// μ_y.dark, DN.
    pub dark_mean: f64,
    /// σ_y.dark², DN².
    pub dark_variance: f64,
}

/// Mean and variance of the dark images of one exposure time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DarkPoint {
    /// Exposure time; 0 where it is not known.
    pub time: Seconds,
    /// μ_y.dark, DN.
    pub mean: f64,
    /// σ_y.dark², DN².
    pub variance: f64,
}

impl TemporalPoint {
    /// μ_y − μ_y.dark, DN.
    pub fn signal(&self) -> f64 {
        self.mean - self.dark_mean
    }

    /// σ_y² − σ_y.dark², DN²: the light's own noise.
    pub fn photon_noise(&self) -> f64 {
        self.variance - self.dark_variance
    }
}

/// Evaluation of an image set: the figures of the standard with their curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// The figures.
    pub figures: Figures,
    /// The points, from dark to bright.
    pub points: Vec<TemporalPoint>,
    /// The dark images of all exposure times, from the shortest to the longest, whether or not a bright pair has them.
    pub darks: Vec<DarkPoint>,
    /// Number of the point at which the sensor saturates.
    pub saturation: usize,
    /// Number of the last point of the fits for K and R.
    pub last_fitted: usize,
    /// Linearity between 5 and 95 % of saturation, where there are points.
    pub linearity: Option<Linearity>,
    /// Lines through dark mean and variance over exposure time, where there are at least three times.
    pub dark_current: Option<DarkCurrentFit>,
    /// Spatial variances of the dark and the bright stack.
    pub spatial: Option<[SpatialVariances; 2]>,
}

/// Measurement that an image set does not allow.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotMeasured {
    /// The figure.
    pub figure: &'static str,
    /// Reason why the figure is missing.
    pub reason: String,
}

impl Evaluation {
    /// The figures that the set does not tell, by name.
    pub fn not_measured(&self) -> Vec<NotMeasured> {
        let mut missing = Vec::new();
        let mut tell = |figure, reason: &str| missing.push(NotMeasured { figure, reason: reason.to_owned() });
        if self.dark_current.is_none() {
            let is_unknown = self.points.iter().all(|point| point.time.0 == 0.0);
            let reason = if is_unknown {
                "the exposure times are not known: the descriptor states 0"
            } else {
                "the dark images have fewer than three exposure times"
            };
            tell("dark current", reason);
            tell("dark noise at no exposure time (that of the shortest stands for it)", reason);
        }
        if self.dark_current.is_some_and(|fit| fit.variance.is_none()) {
            tell("dark current from the variance", "quantisation hides it: all dark variances are below 0.24 DN²");
        }
        let currents = ["dark current from the mean", "dark current from the variance"];
        for (name, (symbol, bound)) in currents.into_iter().zip(self.figures.dark_current_bounds()) {
            if let Some(bound) = bound {
                let bound = rounded(bound, 3);
                tell(name, &format!("not told apart from 0: |{symbol}| < {bound} e⁻/s at 95 %"));
            }
        }
        if self.linearity.is_none() {
            tell("linearity error", "fewer than two pairs lie between 5 and 95 % of saturation");
        }
        if self.spatial.is_none() {
            tell("DSNU and PRNU", "there is no dark and bright stack of more than two images");
        } else {
            let Figures { dsnu_e, prnu_percent, .. } = self.figures;
            let parts = |f: SpatialFigures| [f.total, f.row, f.column, f.pixel];
            let dsnu = ["DSNU", "DSNU of rows", "DSNU of columns", "DSNU of pixels"];
            let prnu = ["PRNU", "PRNU of rows", "PRNU of columns", "PRNU of pixels"];
            let figures = dsnu.into_iter().zip(parts(dsnu_e)).chain(prnu.into_iter().zip(parts(prnu_percent)));
            for (name, _) in figures.filter(|(_, figure)| figure.is_none()) {
                tell(name, "temporal noise hides it");
            }
        }
        missing
    }
}

/// Linearity: the deviation of the response from a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearity {
    /// μ_y − μ_y.dark over photons, fitted with equal weight for equal relative deviations.
    pub fit: Line,
    /// (photons, deviation from the fit in percent) of the points between 5 and 95 % of saturation.
    pub deviations_percent: Vec<(f64, f64)>,
}

/// The dark signal over exposure time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DarkCurrentFit {
    /// μ_y.dark in DN over s.
    pub mean: Line,
    /// σ_y.dark² in DN² over s; `None` where all of it is below 0.24 DN², where quantisation hides it.
    pub variance: Option<Line>,
    /// Standard error of the slope of the mean, DN/s.
    pub mean_error: f64,
    /// Standard error of the slope of the variance, DN²/s.
    pub variance_error: f64,
}

/// Least σ_y.dark² that can be distinguished from quantisation, DN².
const LEAST_DARK_VARIANCE: f64 = 0.24;

/// Evaluates an image set ([Emva1288](photosite_core::references#emva1288) release 4.0 linear).
///
/// - The sensor saturates where σ_y² has its maximum: from the brightest pair, at the first with a larger variance than
///   both next darker ones. Noise thus moves it less than the largest of many alike would. Pairs with less than half the
///   largest variance are beyond saturation.
/// - K is the slope through the origin of σ_y² − σ_y.dark² over μ_y − μ_y.dark, R that of μ_y − μ_y.dark over μ_p, both
///   up to 70 % of saturation; η = R/K.
/// - σ_y.dark² is the offset of the line through the dark variances over exposure time, those of dark images without
///   bright ones (`more_dark`) among them; with fewer than three exposure times it is that of the shortest. Below 0.24 DN² quantisation hides the noise, and 0.24 stands for it.
///   σ_d² = (σ_y.dark² − 1/12)/K².
/// - DSNU = s_y.dark/K, PRNU = √(s_y² − s_y.dark²)/(μ_y − μ_y.dark), from the stacks (dark, bright).
/// - Linearity errors are the deviations, in percent of the fit, from the line that fits the points between 5 and 95 %
///   of saturation with weights 1/(μ_y − μ_y.dark)².
/// - Dark current: slopes of μ_y.dark/K and σ_y.dark²/K² over exposure time, with the standard errors that deviations
///   from the lines leave.
pub fn evaluate(
    mut points: Vec<TemporalPoint>,
    more_dark: &[DarkPoint],
    stacks: Option<[SpatialVariances; 2]>,
) -> Result<Evaluation, Invalid> {
    points
        .sort_by(|a, b| (a.time.0, a.photons).partial_cmp(&(b.time.0, b.photons)).unwrap_or(std::cmp::Ordering::Equal));
    let saturation = saturation_point(&points)?;
    let last_fitted = last_fitted(&points, saturation)?;
    let fitted = &points[..=last_fitted];
    let gain = through_origin(fitted.iter().map(|p| (p.signal(), p.photon_noise())));
    let responsivity = through_origin(fitted.iter().map(|p| (p.photons, p.signal())));
    if !(gain > 0.0 && responsivity > 0.0) {
        return Err(Invalid::new("", "neither the signal nor its noise grow with the photons"));
    }
    let efficiency = responsivity / gain;

    let darks = darks(&points, more_dark);
    let dark_current = dark_current_fit(&darks);
    let shortest = darks.first().map_or(0.0, |dark| dark.variance);
    let at_no_time = dark_current.and_then(|fit| fit.variance).map_or(shortest, |fit| fit.offset);
    let dark_variance = at_no_time.max(LEAST_DARK_VARIANCE);
    let threshold = sensitivity_threshold_e(dark_variance.sqrt() / gain);
    let saturation_p = points[saturation].photons;
    let linearity = linearity(&points, saturation);
    let errors = linearity.iter().flat_map(|l| l.deviations_percent.iter().map(|&(_, error)| error));
    let figures = Figures {
        system_gain_dn_per_e: gain,
        responsivity_dn_per_p: responsivity,
        quantum_efficiency: efficiency,
        dark_noise_e: (dark_variance - 1.0 / 12.0).sqrt() / gain,
        dark_noise_dn: dark_variance.sqrt(),
        saturation_e: efficiency * saturation_p,
        saturation_p,
        sensitivity_threshold_p: threshold / efficiency,
        sensitivity_threshold_e: threshold,
        snr_max: (efficiency * saturation_p).sqrt(),
        dynamic_range: efficiency * saturation_p / threshold,
        dsnu_e: non_uniformity(stacks, |[dark, _], part| part(dark), gain),
        prnu_percent: match stacks {
            Some([dark, bright]) => non_uniformity(
                stacks,
                |[dark, bright], part| part(bright) - part(dark),
                (bright.mean - dark.mean) / 100.0,
            ),
            None => non_uniformity(None, |_, _| 0.0, 1.0),
        },
        linearity_error_min_percent: errors.clone().reduce(f64::min),
        linearity_error_max_percent: errors.reduce(f64::max),
        dark_current_mean_e_per_s: dark_current.map(|fit| fit.mean.slope / gain),
        dark_current_variance_e_per_s: dark_current.and_then(|fit| fit.variance).map(|line| line.slope / (gain * gain)),
        dark_current_mean_error_e_per_s: dark_current.map(|fit| fit.mean_error / gain),
        dark_current_variance_error_e_per_s: dark_current
            .and_then(|fit| fit.variance.map(|_| fit.variance_error / (gain * gain))),
    };
    Ok(Evaluation { figures, darks, saturation, last_fitted, linearity, dark_current, spatial: stacks, points })
}

/// R in DN per photon of a set of few points, such as that of one wavelength of a sweep: the slope through the origin
/// up to 70 % of the brightest point, which need not saturate.
pub fn responsivity(points: &[TemporalPoint]) -> Result<f64, Invalid> {
    let brightest = (0..points.len()).max_by(|&a, &b| points[a].signal().total_cmp(&points[b].signal()));
    let last = last_fitted(points, brightest.ok_or_else(|| Invalid::new("", "no bright images"))?)?;
    Ok(through_origin(points[..=last].iter().map(|p| (p.photons, p.signal()))))
}

/// The rise of temperature, K, that doubles a dark current known at several temperatures: 1 over the slope of
/// log₂ I(T), by least squares. `None` unless two temperatures with a dark current are known.
pub fn doubling_temperature(currents: impl Iterator<Item = (f64, f64)> + Clone) -> Option<f64> {
    let points =
        currents.filter(|&(_, current)| current > 0.0).map(|(celsius, current)| (celsius, current.log2(), 1.0));
    line(points).map(|fit| 1.0 / fit.slope)
}

/// The number of the pair at which the sensor saturates.
fn saturation_point(points: &[TemporalPoint]) -> Result<usize, Invalid> {
    if points.len() < 3 {
        let message = format!("{} pairs of bright images are too few for a photon transfer curve", points.len());
        return Err(Invalid::new("", message).help("take at least 3, better 50, up to saturation"));
    }
    let by_variance = |&a: &usize, &b: &usize| points[a].variance.total_cmp(&points[b].variance);
    let largest = (0..points.len()).max_by(by_variance).unwrap_or(0);
    // Beyond saturation hardly a pixel is below it, and tiny variances come in any order.
    let is_before = |point: &TemporalPoint| point.variance >= 0.5 * points[largest].variance;
    let is_top = |&at: &usize| {
        let darker = points[at.saturating_sub(2)..at].iter();
        is_before(&points[at]) && darker.clone().all(|point| point.variance < points[at].variance)
    };
    Ok((largest..points.len()).rev().find(is_top).unwrap_or(largest))
}

/// The last point whose signal is at most 70 % of that of the saturated one.
fn last_fitted(points: &[TemporalPoint], saturation: usize) -> Result<usize, Invalid> {
    let most = 0.7 * points[saturation].signal();
    points[..saturation].iter().rposition(|p| p.signal() <= most).ok_or_else(|| {
        Invalid::new("", "no bright images below 70 % of saturation").help("take pairs from dark to past saturation")
    })
}

fn linearity(points: &[TemporalPoint], saturation: usize) -> Option<Linearity> {
    let top = points[saturation].signal();
    let within: Vec<&TemporalPoint> =
        points[..=saturation].iter().filter(|p| (0.05 * top..=0.95 * top).contains(&p.signal())).collect();
    let fit = line(within.iter().map(|p| (p.photons, p.signal(), p.signal().powi(-2))))?;
    let deviation = |p: &&TemporalPoint| (p.photons, 100.0 * (p.signal() / fit.at(p.photons) - 1.0));
    Some(Linearity { fit, deviations_percent: within.iter().map(deviation).collect() })
}

/// Dark images of all exposure times. Points of the same time share theirs.
fn darks(points: &[TemporalPoint], more_dark: &[DarkPoint]) -> Vec<DarkPoint> {
    let of_point = |p: &TemporalPoint| DarkPoint { time: p.time, mean: p.dark_mean, variance: p.dark_variance };
    let mut darks: Vec<DarkPoint> = points.iter().map(of_point).chain(more_dark.iter().copied()).collect();
    darks.sort_by(|a, b| a.time.0.total_cmp(&b.time.0));
    darks.dedup_by_key(|dark| dark.time.0);
    darks
}

fn dark_current_fit(darks: &[DarkPoint]) -> Option<DarkCurrentFit> {
    if darks.len() < 3 {
        return None;
    }
    let through = |value: fn(&DarkPoint) -> f64| {
        let points = darks.iter().map(|dark| (dark.time.0, value(dark)));
        let fit = line(points.clone().map(|(x, y)| (x, y, 1.0)))?;
        Some((fit, slope_error(fit, points)))
    };
    let ((mean, mean_error), (variance, variance_error)) = (through(|d| d.mean)?, through(|d| d.variance)?);
    let is_seen = darks.iter().any(|dark| dark.variance >= LEAST_DARK_VARIANCE);
    Some(DarkCurrentFit { mean, variance: is_seen.then_some(variance), mean_error, variance_error })
}

/// √variance/scale for all parts; `None` where the variance is negative, as temporal noise hides the pattern.
fn non_uniformity(
    stacks: Option<[SpatialVariances; 2]>,
    variance: impl Fn([SpatialVariances; 2], fn(SpatialVariances) -> f64) -> f64,
    scale: f64,
) -> SpatialFigures {
    let figure = |part: fn(SpatialVariances) -> f64| {
        let variance = variance(stacks?, part);
        (variance >= 0.0).then(|| variance.sqrt() / scale)
    };
    SpatialFigures {
        total: figure(|v| v.total),
        row: figure(|v| v.row),
        column: figure(|v| v.column),
        pixel: figure(|v| v.pixel),
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::super::figures::bound_at_95_percent;
    use super::*;

    const GAIN: f64 = 0.25;
    const EFFICIENCY: f64 = 0.5;
    const CURRENT: f64 = 40.0;
    const READ: f64 = 6.0;

    /// Mean response of a linear sensor: 64 DN of black, saturation at 10⁴ e⁻, which step 46 of 50 reaches.
    fn exact_points() -> Vec<TemporalPoint> {
        let point = |step: u32| {
            let time = f64::from(step) * 0.01;
            let photons = 440.0 * f64::from(step);
            let electrons = (EFFICIENCY * photons).min(1e4 - CURRENT * time);
            let dark_variance = GAIN * GAIN * (READ * READ + CURRENT * time) + 1.0 / 12.0;
            let is_saturated = EFFICIENCY * photons + CURRENT * time > 1e4;
            TemporalPoint {
                time: Seconds(time),
                photons,
                mean: 64.0 + GAIN * (electrons + CURRENT * time),
                variance: if is_saturated { 0.01 } else { dark_variance + GAIN * GAIN * electrons },
                dark_mean: 64.0 + GAIN * CURRENT * time,
                dark_variance,
            }
        };
        // Their order in a file means nothing.
        (1..=50).rev().map(point).collect()
    }

    fn variances(mean: f64, parts: [f64; 3]) -> SpatialVariances {
        let [row, column, pixel] = parts;
        SpatialVariances { mean, temporal: 1.0, total: row + column + pixel, row, column, pixel }
    }

    #[test]
    fn exact_moments_give_the_figures_that_they_were_made_of() {
        // DSNU of 2 e⁻ in rows and columns of 1 and √2 and pixels of 1 e⁻; PRNU of 1 % of 4000 e⁻.
        let [dark, bright] = [[1.0, 2.0, 1.0], [1.0, 2.0, 1601.0]].map(|parts| parts.map(|v| v * GAIN * GAIN));
        let stacks = [variances(66.0, dark), variances(66.0 + GAIN * 4000.0, bright)];
        let found = evaluate(exact_points(), &[], Some(stacks)).expect("a set");
        let f = found.figures;
        let saturation = 440.0 * 45.0 * EFFICIENCY;
        let threshold = (READ * READ + 1.0 / (12.0 * GAIN * GAIN) + 0.25f64).sqrt() + 0.5;
        for (name, value, expected) in [
            ("K", f.system_gain_dn_per_e, GAIN),
            ("R", f.responsivity_dn_per_p, GAIN * EFFICIENCY),
            ("η", f.quantum_efficiency, EFFICIENCY),
            ("σ_d", f.dark_noise_e, READ),
            ("σ_y.dark", f.dark_noise_dn, (GAIN * GAIN * READ * READ + 1.0 / 12.0f64).sqrt()),
            ("μ_e.sat", f.saturation_e, saturation),
            ("SNR", f.snr_max, saturation.sqrt()),
            ("threshold", f.sensitivity_threshold_e, threshold),
            ("DR", f.dynamic_range, saturation / threshold),
            ("DSNU", f.dsnu_e.total.expect("not negative"), 2.0),
            ("DSNU of columns", f.dsnu_e.column.expect("not negative"), 2.0f64.sqrt()),
            ("PRNU", f.prnu_percent.total.expect("not negative"), 1.0),
            ("μ_I.mean", f.dark_current_mean_e_per_s.expect("times"), CURRENT),
            ("μ_I.var", f.dark_current_variance_e_per_s.expect("times"), CURRENT),
        ] {
            assert!((value / expected - 1.0).abs() < 1e-9, "{name}: {value} instead of {expected}");
        }
        assert!(f.linearity_error_max_percent.expect("points") < 1e-9);
        assert!(f.linearity_error_min_percent.expect("points") > -1e-9);
        // 70 % of the signal of point 45 (from 0 at 44) is that of point 31.5.
        assert_eq!((found.saturation, found.last_fitted), (44, 30));
    }

    #[test]
    fn without_exposure_times_the_dark_current_alone_is_missing() {
        let known = evaluate(exact_points(), &[], None).expect("a set");
        assert_eq!(known.not_measured().iter().map(|n| n.figure).collect::<Vec<_>>(), ["DSNU and PRNU"]);
        // One exposure time, that of the first point, and light that varies.
        let at = |time: f64| {
            let points = exact_points().into_iter().map(|p| {
                let dark = 64.0 + GAIN * CURRENT * 0.01;
                let dark_variance = GAIN * GAIN * (READ * READ + CURRENT * 0.01) + 1.0 / 12.0;
                TemporalPoint {
                    time: Seconds(time),
                    mean: p.mean - p.dark_mean + dark,
                    variance: if p.variance < 1.0 { p.variance } else { p.variance - p.dark_variance + dark_variance },
                    dark_mean: dark,
                    dark_variance,
                    ..p
                }
            });
            evaluate(points.collect(), &[], None).expect("a set")
        };
        let (unknown, one) = (at(0.0), at(0.01));
        assert_eq!(unknown.figures, one.figures, "no figure takes 0 for a time");
        let f = unknown.figures;
        let dark_noise = (READ * READ + CURRENT * 0.01f64).sqrt();
        for (value, expected) in [
            (f.system_gain_dn_per_e, GAIN),
            (f.quantum_efficiency, EFFICIENCY),
            (f.dark_noise_e, dark_noise),
            (f.saturation_p, 440.0 * 45.0),
        ] {
            assert_relative_eq!(value, expected, max_relative = 1e-9);
        }
        assert_eq!((f.dark_current_mean_e_per_s, f.dark_current_variance_e_per_s), (None, None));
        let reason = |e: &Evaluation| e.not_measured()[..2].iter().map(|n| n.reason.clone()).collect::<Vec<_>>();
        assert_eq!(reason(&unknown), ["the exposure times are not known: the descriptor states 0"; 2]);
        assert_eq!(reason(&one), ["the dark images have fewer than three exposure times"; 2]);
    }

    #[test]
    fn a_nonlinear_response_shows_in_the_linearity_error() {
        let mut points = exact_points();
        points.sort_by(|a, b| a.time.0.total_cmp(&b.time.0));
        let nonlinear = |p: &TemporalPoint| 1.0 - 0.02 * p.signal() / points[44].signal();
        let nonlinear: Vec<TemporalPoint> =
            points.iter().map(|p| TemporalPoint { mean: p.dark_mean + nonlinear(p) * p.signal(), ..*p }).collect();
        let found = evaluate(nonlinear, &[], None).expect("a set");
        let linearity = found.linearity.expect("points");
        // The same fit by brute force: no line has a smaller sum of squared relative deviations.
        let squares = |line: Line| -> f64 {
            let inside = linearity.deviations_percent.iter().map(|&(photons, _)| photons);
            let point = |photons: f64| found.points.iter().find(|p| p.photons == photons).expect("one of them");
            inside.map(|photons| (line.at(photons) / point(photons).signal() - 1.0).powi(2)).sum()
        };
        let best = squares(linearity.fit);
        for (slope, offset) in [(1e-4, 0.0), (-1e-4, 0.0), (0.0, 1e-3), (0.0, -1e-3), (1e-4, -1e-2), (-1e-4, 1e-2)] {
            let Line { slope: a, offset: b } = linearity.fit;
            assert!(squares(Line { slope: a * (1.0 + slope), offset: b + offset }) > best);
        }
        assert!(found.figures.linearity_error_max_percent.expect("points") > 0.1);
    }

    #[test]
    fn noise_beyond_saturation_is_not_its_top() {
        let mut points = exact_points();
        points.sort_by(|a, b| a.time.0.total_cmp(&b.time.0));
        points[49].variance = 0.02;
        points[48].variance = 5.0;
        assert_eq!(evaluate(points, &[], None).expect("a set").saturation, 44);
    }

    /// Signal and variance about the maximum in a public set of an 8-bit CMOS camera (EMVA1288/datasets, 002): from the
    /// brightest, the first that both next darker ones are below is the one that the standard's tool takes.
    #[test]
    fn saturation_is_the_first_maximum_from_the_bright_end() {
        let variances = [3.8915, 3.9345, 3.9185, 3.9147, 3.9312, 3.9044, 3.8928, 3.8895, 3.8657, 3.8159, 3.829, 1.1];
        let mut points = exact_points();
        points.sort_by(|a, b| a.time.0.total_cmp(&b.time.0));
        points.truncate(variances.len());
        points.iter_mut().zip(variances).for_each(|(point, variance)| point.variance = variance);
        assert_eq!(saturation_point(&points), Ok(4));
    }

    /// Dark images of times that no bright pair has count, whatever their order.
    #[test]
    fn dark_images_without_bright_ones_tell_the_dark_current() {
        let light = exact_points().into_iter().map(|p| {
            let dark_variance = GAIN * GAIN * (READ * READ + CURRENT * 0.01) + 1.0 / 12.0;
            let dark_mean = 64.0 + GAIN * CURRENT * 0.01;
            let (mean, variance) = (dark_mean + p.signal(), dark_variance + p.photon_noise());
            TemporalPoint { time: Seconds(0.01), mean, variance, dark_mean, dark_variance, ..p }
        });
        let dark = |time: f64| DarkPoint {
            time: Seconds(time),
            mean: 64.0 + GAIN * CURRENT * time,
            variance: GAIN * GAIN * (READ * READ + CURRENT * time) + 1.0 / 12.0,
        };
        let found = evaluate(light.collect(), &[1.0, 0.3, 0.1].map(dark), None).expect("a set");
        assert_eq!(found.darks.iter().map(|dark| dark.time.0).collect::<Vec<_>>(), [0.01, 0.1, 0.3, 1.0]);
        let f = found.figures;
        for current in [f.dark_current_mean_e_per_s, f.dark_current_variance_e_per_s] {
            assert_relative_eq!(current.expect("four times"), CURRENT, max_relative = 1e-9);
        }
        assert_relative_eq!(f.dark_noise_e, READ, max_relative = 1e-9);
        assert!(!found.not_measured().iter().any(|missing| missing.figure.contains("dark current")));
    }

    /// Means of 64 DN that scatter by d at four times 0, 1, 2, 3 as d·(1, −1, −1, 1) have a slope of 0 with a standard
    /// error of √(4d²/2/5) DN/s.
    #[test]
    fn a_dark_current_that_is_not_told_apart_from_none_is_named() {
        let dark = |(time, sign): (f64, f64)| DarkPoint { time: Seconds(time), mean: 64.0 + 0.5 * sign, variance: 0.1 };
        let darks = [(0.0, 1.0), (1.0, -1.0), (2.0, -1.0), (3.0, 1.0)].map(dark);
        let fit = dark_current_fit(&darks).expect("four times");
        assert_relative_eq!(fit.mean.slope, 0.0, epsilon = 1e-12);
        assert_relative_eq!(fit.mean_error, (4.0 * 0.25 / 2.0 / 5.0f64).sqrt(), max_relative = 1e-12);
        assert_eq!(fit.variance, None, "quantisation hides variances below 0.24 DN²");
        let mut points = exact_points();
        points.retain(|p| p.time.0 > 0.005);
        for (p, sign) in points.iter_mut().zip([1.0, -1.0, -1.0, 1.0].into_iter().cycle()) {
            (p.mean, p.dark_mean) = (p.mean - p.dark_mean + 64.0 + 0.5 * sign, 64.0 + 0.5 * sign);
        }
        let found = evaluate(points, &[], None).expect("a set");
        let named: Vec<_> =
            found.not_measured().into_iter().filter(|n| n.figure == "dark current from the mean").collect();
        assert_eq!(named.len(), 1);
        assert!(named[0].reason.starts_with("not told apart from 0: |μ_I.mean| < "), "{named:?}");
        let Figures { dark_current_mean_e_per_s: current, dark_current_mean_error_e_per_s: error, .. } = found.figures;
        let bound = current.expect("times").abs() + 1.96 * error.expect("times");
        let rows = found.figures.rows();
        let row = rows.iter().find(|row| row.symbol == "μ_I.mean").expect("a row");
        assert_eq!(row.bound, Some(bound));
        assert_eq!(row.cell(|x| x.to_string()), format!("not told apart from 0 (< {bound})"));
        // Others are as they are, and so is a current of many errors.
        assert!(rows.iter().all(|row| row.bound.is_none() || row.symbol.starts_with("μ_I")));
        for (current, error, told) in [(3.1, 1.0, true), (2.9, 1.0, false), (-582_040.0, 1e5, false), (0.0, 0.0, false)]
        {
            assert_eq!(bound_at_95_percent(current, error).is_none(), told, "{current} ± {error}");
        }
    }

    #[test]
    fn what_tells_nothing_is_refused() {
        assert!(evaluate(Vec::new(), &[], None).is_err());
        assert!(evaluate(exact_points()[..2].to_vec(), &[], None).is_err());
        let flat = exact_points().into_iter().map(|p| TemporalPoint { mean: 64.0, dark_mean: 64.0, ..p });
        assert!(evaluate(flat.collect(), &[], None).is_err());
        assert!(responsivity(&[]).is_err());
    }

    #[test]
    fn doubling_temperatures() {
        let currents = [15.0, 25.0, 45.0].map(|t: f64| (t, 3.0 * ((t - 20.0) / 7.5).exp2()));
        assert_relative_eq!(doubling_temperature(currents.into_iter()).expect("three"), 7.5, max_relative = 1e-12);
        assert_eq!(doubling_temperature([(25.0, 3.0), (35.0, 0.0)].into_iter()), None);
    }
}
