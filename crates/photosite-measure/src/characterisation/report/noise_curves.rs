//! Plots of estimates of noise.

use plotters::prelude::RGBColor;

use super::chart::{Axis, BLUE, Chart, Curve, GREEN, GREY, Mark, ORANGE};
use super::plot::{Plot, digits};
use crate::characterisation::Histogram;
use crate::characterisation::noise::{Autocovariance, NoiseEstimate, SigmaDistribution};

/// Most bins of a histogram; of n values it has 2·∛n, where that is fewer.
const MOST_BINS: f64 = 64.0;
/// Colours of curves that belong together.
const FAMILY: [RGBColor; 4] = [BLUE, ORANGE, GREEN, GREY];
/// Points of an expected curve.
const POINTS: u32 = 200;

/// All plots of an estimate, with names for their files.
pub(super) fn plots(estimate: &NoiseEstimate, unit: &str) -> Vec<(&'static str, Plot)> {
    let mut plots = Vec::new();
    if let Some(temporal) = &estimate.temporal {
        let title = "Standard deviations of the pixels";
        let caption = format!(
            "Of {} images, the temporal noise of every pixel, beside what it would be if all pixels had the same normal \
             noise: σ·√(χ²/k) with k = {}. {}",
            estimate.pictures,
            temporal.map.freedom,
            distance(&temporal.map)
        );
        plots.push(("sigma-map", distribution(title, caption, &temporal.map, "pixels", unit)));
    }
    if let Some(neighbourhoods) = &estimate.neighbourhoods {
        let title = "Standard deviations of neighbourhoods";
        let caption = format!(
            "Of squares of {side} × {side} pixels, what a plane leaves of each, beside what it would be of even noise: \
             σ·√(χ²/k) with k = {side}² − 3 = {}. {}",
            neighbourhoods.sigmas.freedom,
            distance(&neighbourhoods.sigmas),
            side = neighbourhoods.side,
        );
        plots.push(("neighbourhoods", distribution(title, caption, &neighbourhoods.sigmas, "squares", unit)));
    }
    plots.extend(autocovariance(&estimate.autocovariance, unit).map(|plot| ("autocovariance", plot)));
    plots.extend(both_ways(&estimate.autocovariance).map(|plot| ("correlation", plot)));
    plots
}

fn distance(sigmas: &SigmaDistribution) -> String {
    let p = if sigmas.p_value < 1e-4 { format!("{:.0e}", sigmas.p_value) } else { digits(sigmas.p_value, 2) };
    format!("Kolmogorov–Smirnov distance {}, p = {p}.", digits(sigmas.distance, 3))
}

/// A histogram of standard deviations beside the expected density.
fn distribution(title: &'static str, caption: String, sigmas: &SigmaDistribution, counted: &str, unit: &str) -> Plot {
    let (low, high) = (sigmas.smallest, sigmas.largest);
    let bins = (2.0 * (sigmas.count as f64).cbrt()).ceil().min(MOST_BINS);
    let width = if high > low { (high - low) / bins } else { 1.0 };
    let histogram = Histogram::new(&sigmas.sorted, width, bins as usize);
    let half = 0.5 * histogram.width;
    let steps = histogram.bins().flat_map(|(x, count)| [(x - half, count as f64), (x + half, count as f64)]);
    let scale = sigmas.count as f64 * histogram.width;
    let at = |i: u32| low + (high - low) * f64::from(i) / f64::from(POINTS);
    let expected: Vec<(f64, f64)> = (0..=POINTS).map(|i| (at(i), scale * sigmas.expected_density(at(i)))).collect();
    let most = histogram.counts.iter().copied().max().unwrap_or(1).max(1) as f64;
    let top = 1.1 * expected.iter().map(|(_, count)| *count).fold(most, f64::max);
    let mean = vec![(sigmas.mean, 0.0), (sigmas.mean, top)];
    Plot {
        title,
        caption,
        chart: Chart {
            x: Axis::linear(in_unit("standard deviation", unit)),
            y: Axis::linear(counted).within(0.0, top),
            curves: vec![
                Curve::new("found", Mark::Line, BLUE, steps.collect()),
                Curve::new(format!("σ·√(χ²/k), σ = {}", digits(sigmas.sigma, 4)), Mark::Line, ORANGE, expected),
                Curve::new(format!("mean {}", digits(sigmas.mean, 4)), Mark::Dashes, GREEN, mean),
            ],
        },
    }
}

/// Covariance over distance, along rows and along columns; `None` where no distance was asked for.
fn autocovariance(found: &Autocovariance, unit: &str) -> Option<Plot> {
    let last = found.along_rows.len().max(found.along_columns.len()) - 1;
    if last == 0 {
        return None;
    }
    let points =
        |values: &[f64]| -> Vec<(f64, f64)> { values.iter().enumerate().map(|(i, &c)| (i as f64, c)).collect() };
    let [rows, columns] = [&found.along_rows, &found.along_columns].map(|values| points(values));
    // Two standard errors of noise without correlation.
    let error = 2.0 * found.correlation_error * found.along_rows[0];
    let ends = |level: f64| vec![(0.0, level), (last as f64, level)];
    let unit = if unit.is_empty() { String::new() } else { format!("({unit})²") };
    Some(Plot {
        title: "Autocovariance",
        caption:
            "Of noise at pixels so far apart, along rows and along columns; noise without correlation stays within \
                  the dashed lines at 95 % of the distances."
                .to_owned(),
        chart: Chart {
            x: Axis::linear("distance in pixels"),
            y: Axis::linear(in_unit("covariance", &unit)),
            curves: vec![
                Curve::new("", Mark::Dashes, GREY, ends(error)),
                Curve::new("", Mark::Dashes, GREY, ends(-error)),
                Curve::new("", Mark::Points, BLUE, rows.clone()),
                Curve::new("along rows", Mark::Line, BLUE, rows),
                Curve::new("", Mark::Points, ORANGE, columns.clone()),
                Curve::new("along columns", Mark::Line, ORANGE, columns),
            ],
        },
    })
}

/// Correlation over distances along both, a curve for each distance along columns; `None` where there is but one.
fn both_ways(found: &Autocovariance) -> Option<Plot> {
    let variance = found.along_rows[0];
    if found.along_rows.len() < 2 || found.along_columns.len() < 2 || variance <= 0.0 {
        return None;
    }
    let curve = |(rows, covariances): (usize, &Vec<f64>)| {
        let points = covariances.iter().enumerate().map(|(columns, c)| (columns as f64, c / variance)).collect();
        let mark = if rows < FAMILY.len() { Mark::Line } else { Mark::Dashes };
        Curve::new(format!("{rows} rows apart"), mark, FAMILY[rows % FAMILY.len()], points)
    };
    Some(Plot {
        title: "Correlation both ways",
        caption: format!(
            "Autocovariance C(Δr, Δc) over C(0, 0). From the product of the correlations along rows and along columns it \
             differs by {} at most.",
            digits(found.inseparability, 2)
        ),
        chart: Chart {
            x: Axis::linear("distance along rows in pixels"),
            y: Axis::linear("correlation"),
            curves: found.covariances.iter().enumerate().take(2 * FAMILY.len()).map(curve).collect(),
        },
    })
}

fn in_unit(what: &str, unit: &str) -> String {
    if unit.is_empty() { what.to_owned() } else { format!("{what} in {unit}") }
}
