//! The curves of EMVA 1288, each from an evaluation.

use super::chart::{Axis, BLUE, Chart, Curve, GREEN, GREY, Mark, ORANGE};
use super::plot::{Plot, digits};
use super::points::{SpectralPoint, ThermalPoint};
use crate::characterisation::{
    DarkPoint, Direction, Evaluation, Figures, Histogram, Line, SpatialStack, SpatialVariances, Spectrogram,
    TemporalPoint,
};

/// Bins of a histogram.
const BINS: usize = 256;

/// Variance over mean: the photon transfer curve.
pub(super) fn photon_transfer(e: &Evaluation) -> Plot {
    let points: Vec<_> = e.points.iter().map(|p| (p.signal(), p.photon_noise())).collect();
    let [fitted, saturated] = [e.last_fitted, e.saturation].map(|i| points[i].0);
    let gain = e.figures.system_gain_dn_per_e;
    let top = points.iter().map(|p| p.1).fold(0.0, f64::max).max(gain * saturated) * 1.08;
    let curves = vec![
        Curve::new("measured", Mark::Points, BLUE, points),
        Curve::new(
            format!("slope K = {}", digits(gain, 4)),
            Mark::Line,
            ORANGE,
            vec![(0.0, 0.0), (fitted, gain * fitted)],
        ),
        Curve::new("", Mark::Dashes, ORANGE, vec![(fitted, gain * fitted), (saturated, gain * saturated)]),
        Curve::new("saturation", Mark::Dashes, GREY, vec![(saturated, 0.0), (saturated, top)]),
    ];
    Plot {
        title: "Photon transfer curve",
        caption:
            "Temporal variance over mean signal, both without their dark parts. The slope up to 70 % of saturation is \
                  the system gain."
                .to_owned(),
        chart: Chart {
            x: Axis::linear("mean signal above dark in DN"),
            y: Axis::linear("temporal variance above dark in DN²").within(0.0, top),
            curves,
        },
    }
}

/// Signal-to-noise ratio over photons.
pub(super) fn snr(e: &Evaluation) -> Plot {
    let f = &e.figures;
    let measured = |p: &TemporalPoint| (p.photons, p.signal() / p.variance.sqrt());
    let [low, high] = [0.5 * f.sensitivity_threshold_p, 1.5 * f.saturation_p];
    let photons: Vec<f64> = (0..=200).map(|i| low * (f.saturation_p / low).powf(f64::from(i) / 200.0)).collect();
    let dark = (f.dark_noise_dn / f.system_gain_dn_per_e).powi(2);
    let line = |noise: &dyn Fn(f64) -> f64| {
        let snr = |&p: &f64| (p, f.quantum_efficiency * p / noise(f.quantum_efficiency * p).sqrt());
        photons.iter().map(snr).collect::<Vec<_>>()
    };
    let mut curves = vec![
        Curve::new("measured", Mark::Points, BLUE, e.points[..=e.saturation].iter().map(measured).collect()),
        Curve::new("from the figures", Mark::Line, ORANGE, line(&|electrons| dark + electrons)),
        Curve::new("shot noise alone", Mark::Dashes, GREY, line(&|electrons| electrons)),
    ];
    if let (Some(dsnu), Some(prnu)) = (f.dsnu_e.total, f.prnu_percent.total) {
        let total = |electrons: f64| dark + dsnu * dsnu + electrons + (prnu / 100.0 * electrons).powi(2);
        curves.push(Curve::new("with non-uniformities", Mark::Line, GREEN, line(&total)));
    }
    let top = 2.0 * (f.quantum_efficiency * f.saturation_p).sqrt();
    curves.push(Curve::new("saturation", Mark::Dashes, BLUE, vec![(f.saturation_p, 0.5), (f.saturation_p, top)]));
    Plot {
        title: "Signal-to-noise ratio",
        caption: "Over the photons on a pixel, from the absolute sensitivity threshold, where it is 1, to saturation."
            .to_owned(),
        chart: Chart {
            x: Axis::logarithmic("photons per pixel").within(low, high),
            y: Axis::logarithmic("signal-to-noise ratio").within(0.5, top),
            curves,
        },
    }
}

/// Mean signal over photons.
pub(super) fn responsivity(e: &Evaluation) -> Plot {
    let points: Vec<_> = e.points.iter().map(|p| (p.photons, p.signal())).collect();
    let slope = e.figures.responsivity_dn_per_p;
    let end = e.figures.saturation_p;
    Plot {
        title: "Responsivity",
        caption: "Mean signal over photons. The slope up to 70 % of saturation is R = K·η.".to_owned(),
        chart: Chart {
            x: Axis::linear("photons per pixel"),
            y: Axis::linear("mean signal above dark in DN"),
            curves: vec![
                Curve::new("measured", Mark::Points, BLUE, points),
                Curve::new(
                    format!("slope R = {}", digits(slope, 4)),
                    Mark::Line,
                    ORANGE,
                    vec![(0.0, 0.0), (end, slope * end)],
                ),
            ],
        },
    }
}

/// Relative deviation from the line of linearity.
pub(super) fn linearity(e: &Evaluation) -> Option<Plot> {
    let linearity = e.linearity.as_ref()?;
    let points = linearity.deviations_percent.clone();
    let ends = [points.first()?.0, points.last()?.0];
    let most = points.iter().map(|p| p.1.abs()).fold(0.0, f64::max).max(1e-4) * 1.2;
    Some(Plot {
        title: "Linearity error",
        caption: "Deviation of the mean signal from the line that fits 5 to 95 % of saturation best.".to_owned(),
        chart: Chart {
            x: Axis::linear("photons per pixel"),
            y: Axis::linear("deviation in %").within(-most, most),
            curves: vec![
                Curve::new("", Mark::Dashes, GREY, ends.map(|x| (x, 0.0)).to_vec()),
                Curve::new("", Mark::Points, BLUE, points.clone()),
                Curve::new("", Mark::Line, BLUE, points),
            ],
        },
    })
}

/// Dark mean and variance over exposure time.
pub(super) fn dark_signal(e: &Evaluation) -> Vec<Plot> {
    let Some(fits) = e.dark_current else { return Vec::new() };
    let plot = |title, y: &str, value: fn(&DarkPoint) -> f64, fit: Line| {
        let points: Vec<_> = e.darks.iter().map(|p| (p.time.0, value(p))).collect();
        let end = points.last().map_or(1.0, |p| p.0);
        Plot {
            title,
            caption: "Over exposure time; the slope is the dark current.".to_owned(),
            chart: Chart {
                x: Axis::linear("exposure time in s").within(0.0, 1.04 * end),
                y: Axis::linear(y),
                curves: vec![
                    Curve::new("measured", Mark::Points, BLUE, points),
                    Curve::new("fit", Mark::Line, ORANGE, vec![(0.0, fit.at(0.0)), (end, fit.at(end))]),
                ],
            },
        }
    };
    let mean = plot("Dark signal", "mean dark signal in DN", |p| p.mean, fits.mean);
    let noise = |fit| plot("Dark noise", "temporal dark variance in DN²", |p| p.variance, fit);
    std::iter::once(mean).chain(fits.variance.map(noise)).collect()
}

/// Histograms and spectrograms of the stacks.
pub(super) fn non_uniformity(f: &Figures, stacks: &[SpatialStack; 2], variances: &[SpatialVariances; 2]) -> Vec<Plot> {
    let [dark, bright] = stacks;
    let [dark_variances, bright_variances] = variances;
    let size = dark.size();
    let gain = f.system_gain_dn_per_e;
    let dark_image: Vec<f64> = dark.average().iter().map(|y| (y - dark_variances.mean) / gain).collect();
    let signal = bright_variances.mean - dark_variances.mean;
    let response: Vec<f64> =
        bright.average().iter().zip(dark.average()).map(|(b, d)| 100.0 * ((b - d) / signal - 1.0)).collect();
    // White noise that averaging leaves.
    let dark_floor = (dark_variances.temporal / f64::from(dark.count())).sqrt() / gain;
    let left =
        bright_variances.temporal / f64::from(bright.count()) + dark_variances.temporal / f64::from(dark.count());
    let response_floor = 100.0 * left.sqrt() / signal;
    // Averages of whole numbers lie so far apart.
    let step = 1.0 / f64::from(dark.count());
    vec![
        histogram("DSNU histogram", "deviation of the dark signal in e⁻", &dark_image, step / gain),
        histogram("PRNU histogram", "deviation of the response in %", &response, 100.0 * step / signal),
        spectrogram("DSNU spectrogram", "e⁻", &dark_image, size, dark_floor),
        spectrogram("PRNU spectrogram", "%", &response, size, response_floor),
    ]
}

fn histogram(title: &'static str, label: &str, values: &[f64], quantum: f64) -> Plot {
    let histogram = Histogram::new(values, quantum, BINS);
    let (normal, counts): (Vec<_>, Vec<_>) =
        histogram.bins().map(|(x, count)| ((x, histogram.normal(x)), (x, count as f64))).unzip();
    let top = counts.iter().map(|p| p.1).fold(1.0, f64::max) * 2.0;
    Plot {
        title,
        caption: "Pixels of the averaged images, and the normal distribution of the same mean and spread.".to_owned(),
        chart: Chart {
            x: Axis::linear(label),
            y: Axis::logarithmic("pixels").within(0.5, top),
            curves: vec![
                Curve::new("measured", Mark::Points, BLUE, counts),
                Curve::new(
                    format!("normal, σ = {}", digits(histogram.standard_deviation, 4)),
                    Mark::Line,
                    ORANGE,
                    normal.into_iter().filter(|p| p.1 > 0.5).collect(),
                ),
            ],
        },
    }
}

fn spectrogram(title: &'static str, unit: &str, image: &[f64], size: [usize; 2], floor: f64) -> Plot {
    let line = |direction| -> Vec<_> {
        Spectrogram::new(image, size, direction).points().map(|(f, power)| (f, power.sqrt())).collect()
    };
    let [rows, columns] = [Direction::Horizontal, Direction::Vertical].map(line);
    let values = || rows.iter().chain(&columns).map(|p| p.1).chain([floor]).filter(|&v| v > 0.0);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    let label = format!("√power in {unit}");
    // Room for the legend above; decades only where there are any.
    let y = if high > 20.0 * low {
        Axis::logarithmic(label).within(low / 2.0, high * 8.0)
    } else {
        Axis::linear(label).within(0.0, 1.5 * high)
    };
    Plot {
        title,
        caption: "Along rows, where patterns of columns show, and along columns, where patterns of rows show. White noise is \
                  level."
            .to_owned(),
        chart: Chart {
            x: Axis::linear("cycles per pixel").within(0.0, 0.5),
            y,
            curves: vec![
                Curve::new("along rows", Mark::Line, BLUE, rows),
                Curve::new("along columns", Mark::Line, ORANGE, columns),
                Curve::new("temporal noise left by averaging", Mark::Dashes, GREY, vec![(0.0, floor), (0.5, floor)]),
            ],
        },
    }
}

/// Quantum efficiency over wavelength.
pub(super) fn quantum_efficiency(points: &[SpectralPoint]) -> Option<Plot> {
    if points.is_empty() {
        return None;
    }
    let measured = points.iter().filter_map(|p| Some((p.wavelength_nm, 100.0 * p.measured?))).collect();
    let expected: Vec<_> = points.iter().map(|p| (p.wavelength_nm, 100.0 * p.expected)).collect();
    let top = expected.iter().map(|p| p.1).fold(1.0, f64::max) * 1.15;
    Some(Plot {
        title: "Quantum efficiency",
        caption: "Over wavelength, in electrons per photon on the pixel's whole area.".to_owned(),
        chart: Chart {
            x: Axis::linear("wavelength in nm"),
            y: Axis::linear("quantum efficiency in %").within(0.0, top),
            curves: vec![
                Curve::new("expected", Mark::Line, ORANGE, expected),
                Curve::new("measured", Mark::Points, BLUE, measured),
            ],
        },
    })
}

/// Dark current over temperature.
pub(super) fn temperature(points: &[ThermalPoint]) -> Option<Plot> {
    if points.len() < 2 {
        return None;
    }
    let curve = |value: fn(&ThermalPoint) -> Option<f64>| {
        points.iter().filter_map(|p| Some((p.temperature_c, value(p)?))).collect()
    };
    Some(Plot {
        title: "Dark current",
        caption: "Over temperature, from the mean and from the variance of the dark signal.".to_owned(),
        chart: Chart {
            x: Axis::linear("temperature in °C"),
            y: Axis::logarithmic("dark current in e⁻/s"),
            curves: vec![
                Curve::new("expected", Mark::Line, ORANGE, curve(|p| Some(p.expected))),
                Curve::new("from the variance", Mark::Points, GREEN, curve(|p| p.from_variance)),
                Curve::new("from the mean", Mark::Points, BLUE, curve(|p| p.from_mean)),
            ],
        },
    })
}
