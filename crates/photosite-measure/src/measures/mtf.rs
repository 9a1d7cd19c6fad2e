//! Modulation transfer function from a slanted edge (e-SFR, [Iso12233](photosite_core::references#iso12233), annex D).
//!
//! The edge is found row by row as the centroid of the derivative, and a straight line is fitted through it. Every
//! pixel lies at some distance from that line; gathered in bins of a quarter of a pixel, the pixels give the edge
//! spread function four times finer than the pixels are. The Fourier transform of its derivative is the transfer
//! function, after what the bins and the finite difference take from it is put back. That of the pixels' own area
//! stays, since it is part of what is measured.
//!
//! Noise of the pixels is what they differ by from the edge spread function at their distance. The modulation is a linear
//! function of the bins, up to a phase, so that its standard error follows from the variances of their means. Pixels are
//! taken to be independent: where a filter or demosaicking has mixed neighbours, the error is larger than is said.

use std::f64::consts::PI;

use photosite_fft::Complex64;
use serde::Serialize;

use photosite_core::Invalid;

/// Bins a pixel.
const OVERSAMPLING: f64 = 4.0;
/// Bins to each side that tell the variance of one.
const POOLED: usize = 4;

/// Edge response: sharpness across an edge.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EdgeResponse {
    /// Angle between the edge and the pixels' columns, or rows, degrees.
    pub angle_deg: f64,
    /// Whether the edge runs along the columns.
    pub is_vertical: bool,
    /// Spatial frequencies across the edge, cycles per pixel.
    pub frequency_cy_per_px: Vec<f64>,
    /// Modulation at each, 1 at frequency 0.
    pub mtf: Vec<f64>,
    /// Frequency at which the modulation first falls to 0.5, cycles per pixel.
    pub mtf50_cy_per_px: Option<f64>,
    /// Frequency at which the modulation first falls to 0.1, cycles per pixel.
    pub mtf10_cy_per_px: Option<f64>,
    /// Modulation at half a cycle per pixel.
    pub at_nyquist: f64,
    /// Standard error that the noise of the pixels leaves in each modulation.
    pub standard_error: Vec<f64>,
    /// Standard error of the modulation at a quarter of a cycle per pixel, half the Nyquist frequency.
    pub standard_error_at_half_nyquist: f64,
}

impl EdgeResponse {
    /// Cycles per mm of a cycle per pixel across this edge, for pixels so wide and so high.
    pub fn cycles_per_mm(&self, pitch_m: [f64; 2]) -> f64 {
        let [across, along] = if self.is_vertical { pitch_m } else { [pitch_m[1], pitch_m[0]] };
        let (sin, cos) = self.angle_deg.to_radians().sin_cos();
        f64::hypot(cos / across, sin / along) * 1e-3
    }
}

/// The response of an edge within the region (column, row, columns, rows) of a plane of linear values. The edge must
/// run through all of the region's rows, or through all of its columns, and not along them.
pub fn slanted_edge(
    plane: &[f32],
    [width, height]: [usize; 2],
    [left, top, columns, rows]: [usize; 4],
) -> Result<EdgeResponse, Invalid> {
    let fits = |first: usize, n: usize, side| first.checked_add(n).is_some_and(|end| end <= side);
    if columns < 16 || rows < 16 || !(fits(left, columns, width) && fits(top, rows, height)) {
        let message = format!("{columns} × {rows} pixels at {left}, {top} of {width} × {height}");
        return Err(Invalid::new("region", message).help("give at least 16 × 16 pixels within the image"));
    }
    let at = |x: usize, y: usize| f64::from(plane[(top + y) * width + left + x]);
    let change = |x: usize, y: usize, dx: usize, dy: usize| (at(x + dx, y + dy) - at(x, y)).abs();
    let inner = || (0..rows - 1).flat_map(|y| (0..columns - 1).map(move |x| (x, y)));
    let along_rows: f64 = inner().map(|(x, y)| change(x, y, 1, 0)).sum();
    let along_columns: f64 = inner().map(|(x, y)| change(x, y, 0, 1)).sum();
    let is_vertical = along_rows >= along_columns;
    let lines: Vec<Vec<f64>> = if is_vertical {
        (0..rows).map(|y| (0..columns).map(|x| at(x, y)).collect()).collect()
    } else {
        (0..columns).map(|x| (0..rows).map(|y| at(x, y)).collect()).collect()
    };
    let (offset, slope) = fit_edge(&lines)?;
    Ok(response(&EdgeSpread::new(&lines, offset, slope)?, slope, is_vertical))
}

fn no_edge(message: &str) -> Invalid {
    Invalid::new("region", message)
        .help("choose a region with one straight edge, a few degrees off the pixels' columns or rows")
}

/// Position of the edge in the first line, and its change from line to line.
fn fit_edge(lines: &[Vec<f64>]) -> Result<(f64, f64), Invalid> {
    let mut line: Option<(f64, f64)> = None;
    // The second time near the edge only, so that noise far from it does not count.
    for _ in 0..3 {
        let centre = |(y, values): (usize, &Vec<f64>)| {
            let middle = line.map(|(offset, slope)| offset + slope * y as f64);
            let (mut sum, mut weights) = (0.0, 0.0);
            for x in 1..values.len() - 1 {
                let distance = middle.map_or(0.0, |middle| (x as f64 - middle) / (values.len() as f64 / 4.0).max(6.0));
                let window = if distance.abs() < 1.0 { 0.5 + 0.5 * (PI * distance).cos() } else { 0.0 };
                let derivative = 0.5 * (values[x + 1] - values[x - 1]) * window;
                (sum, weights) = (sum + derivative * x as f64, weights + derivative);
            }
            sum / weights
        };
        let centres: Vec<f64> = lines.iter().enumerate().map(centre).collect();
        if centres.iter().any(|c| !c.is_finite()) {
            return Err(no_edge("there is a row without any edge"));
        }
        let n = lines.len() as f64;
        let (mean_y, mean_x) = ((n - 1.0) / 2.0, centres.iter().sum::<f64>() / n);
        let covariance: f64 = centres.iter().enumerate().map(|(y, x)| (y as f64 - mean_y) * (x - mean_x)).sum();
        let variance: f64 = (0..lines.len()).map(|y| (y as f64 - mean_y).powi(2)).sum();
        let slope = covariance / variance;
        line = Some((mean_x - slope * mean_y, slope));
    }
    let Some((offset, slope)) = line else { return Err(no_edge("there is no edge")) };
    let ends = [offset, offset + slope * (lines.len() - 1) as f64];
    if ends.iter().any(|x| !(2.0..lines[0].len() as f64 - 3.0).contains(x)) {
        return Err(no_edge("the edge leaves the region at a side"));
    }
    if slope.abs() * (lines.len() as f64) < 1.0 {
        return Err(no_edge("the edge runs along the pixels, so that all of it lies at the same part of a pixel"));
    }
    Ok((offset, slope))
}

/// The edge spread function.
struct EdgeSpread {
    /// Mean value in each bin of distance from the edge.
    mean: Vec<f64>,
    /// Variance of the mean in each bin.
    variance: Vec<f64>,
}

impl EdgeSpread {
    fn new(lines: &[Vec<f64>], offset: f64, slope: f64) -> Result<Self, Invalid> {
        let cosine = 1.0 / (1.0 + slope * slope).sqrt();
        // As far as the edge is from the sides in every line.
        let ends = [offset, offset + slope * (lines.len() - 1) as f64];
        let columns = lines[0].len() as f64;
        let reach = ends.iter().map(|x| x.min(columns - 1.0 - x)).fold(f64::INFINITY, f64::min) * cosine;
        let half = (reach * OVERSAMPLING).floor().max(0.0);
        let bins = 2 * half as usize + 1;
        // Values with their places, in bins.
        let pixels = || {
            let of_line = |(y, line): (usize, &Vec<f64>)| {
                let place = move |x: usize| (x as f64 - offset - slope * y as f64) * cosine * OVERSAMPLING + half;
                line.iter().enumerate().map(move |(x, &value)| (place(x), value)).collect::<Vec<_>>()
            };
            let of_bin = |(place, value): (f64, f64)| {
                let bin = place.round();
                (bin >= 0.0 && bin < bins as f64).then_some((bin as usize, place, value))
            };
            lines.iter().enumerate().flat_map(of_line).filter_map(of_bin)
        };
        let mut sums = vec![(0.0, 0u32); bins];
        for (bin, _, value) in pixels() {
            sums[bin].0 += value;
            sums[bin].1 += 1;
        }
        if sums.iter().any(|(_, count)| *count == 0) || bins < 16 {
            return Err(no_edge("the edge is too short, or too steep, to fill every quarter of a pixel"));
        }
        let mean: Vec<f64> = sums.iter().map(|(sum, count)| sum / f64::from(*count)).collect();
        let mut squares = vec![0.0; bins];
        for (bin, place, value) in pixels() {
            // Along a straight line from bin to bin, so that the rise of the edge within a bin is no noise.
            let left = (place.floor().max(0.0) as usize).min(bins - 2);
            let expected = mean[left] + (mean[left + 1] - mean[left]) * (place - left as f64);
            squares[bin] += (value - expected).powi(2);
        }
        // A few pixels in a bin tell their variance badly; within a pixel it changes little.
        let variance = (0..bins).map(|bin| {
            let near = bin.saturating_sub(POOLED)..(bin + POOLED + 1).min(bins);
            let count: u32 = sums[near.clone()].iter().map(|(_, count)| count).sum();
            let freedom = count.saturating_sub(near.len() as u32).max(1);
            squares[near].iter().sum::<f64>() / f64::from(freedom) / f64::from(sums[bin].1)
        });
        Ok(Self { variance: variance.collect(), mean })
    }
}

fn response(spread: &EdgeSpread, slope: f64, is_vertical: bool) -> EdgeResponse {
    let EdgeSpread { mean, variance } = spread;
    let middle = (mean.len() / 2) as f64;
    // A Tukey window that leaves the middle half alone takes noise away from the ends and nothing from the edge.
    let window = |k: usize| {
        let part = ((k as f64 - middle) / middle).abs();
        if part < 0.5 { 1.0 } else { 0.5 + 0.5 * (PI * (part - 0.5) / 0.5).cos() }
    };
    // The terms of the derivative's transform are window(k)·e^(−2πi·f·d)·(mean[k + 1] − mean[k − 1])/2.
    let factor = |f: f64, k: usize| {
        let (sin, cos) = (2.0 * PI * f * (k as f64 - middle) / OVERSAMPLING).sin_cos();
        Complex64::new(cos, -sin) * (0.5 * window(k))
    };
    let inner = 1..mean.len() - 1;
    let transform = |f: f64| -> Complex64 { inner.clone().map(|k| factor(f, k) * (mean[k + 1] - mean[k - 1])).sum() };
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let whole = transform(0.0).re;
    // The difference spans two bins, and each bin is a mean over its width.
    let of_bins = |f: f64| sinc(2.0 * f / OVERSAMPLING) * sinc(f / OVERSAMPLING);
    let modulation = |f: f64| transform(f).norm() / whole.abs() / of_bins(f);
    let standard_error = |f: f64| {
        let value = transform(f);
        let phase = value.conj() / value.norm().max(f64::MIN_POSITIVE);
        // What the transform gains by the mean of a bin, which is in the differences of both its neighbours.
        let gain = |f: f64, bin: usize| {
            let term = |k: Option<usize>| k.filter(|k| inner.contains(k)).map_or(Complex64::ZERO, |k| factor(f, k));
            term(bin.checked_sub(1)) - term(Some(bin + 1))
        };
        let change =
            |bin: usize| (phase * gain(f, bin)).re / whole - value.norm() * gain(0.0, bin).re / (whole * whole);
        let sum: f64 = variance.iter().enumerate().map(|(bin, variance)| variance * change(bin).powi(2)).sum();
        sum.sqrt() / of_bins(f)
    };
    let frequency: Vec<f64> = (0..=100).map(|i| f64::from(i) / 100.0).collect();
    let mtf: Vec<f64> = frequency.iter().map(|f| modulation(*f)).collect();
    let falls_to = |level: f64| {
        let i = mtf.iter().position(|m| *m < level).filter(|i| *i > 0)?;
        let part = (mtf[i - 1] - level) / (mtf[i - 1] - mtf[i]);
        Some(frequency[i - 1] + part * (frequency[i] - frequency[i - 1]))
    };
    EdgeResponse {
        angle_deg: slope.atan().to_degrees(),
        is_vertical,
        mtf50_cy_per_px: falls_to(0.5),
        mtf10_cy_per_px: falls_to(0.1),
        at_nyquist: modulation(0.5),
        standard_error: frequency.iter().map(|f| standard_error(*f)).collect(),
        standard_error_at_half_nyquist: standard_error(0.25),
        frequency_cy_per_px: frequency,
        mtf,
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_images::{Even, normal, truth};
    use super::*;

    const WIDTH: usize = 80;
    const HEIGHT: usize = 100;

    /// An edge blurred by a Gaussian, averaged over each pixel's area by 16 × 16 points.
    fn edge(angle_deg: f64, sigma: f64) -> Vec<f32> {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let value = |i: usize| {
            let mut sum = 0.0;
            for k in 0..256 {
                let (dx, dy) = ((f64::from(k % 16) + 0.5) / 16.0 - 0.5, (f64::from(k / 16) + 0.5) / 16.0 - 0.5);
                let x = (i % WIDTH) as f64 + dx - 39.3;
                let y = (i / WIDTH) as f64 + dy - 49.5;
                sum += normal((x * cos - y * sin) / sigma);
            }
            (0.1 + 0.7 * sum / 256.0) as f32
        };
        (0..WIDTH * HEIGHT).map(value).collect()
    }

    #[test]
    fn analytic_edges_have_their_transfer_function() {
        for angle in [5.0, -8.0, 12.0] {
            for sigma in [0.3, 0.5, 1.0] {
                let found = slanted_edge(&edge(angle, sigma), [WIDTH, HEIGHT], [4, 2, 72, 96]).expect("an edge");
                assert!((found.angle_deg - angle).abs() < 0.02 && found.is_vertical, "{}", found.angle_deg);
                for (f, m) in found.frequency_cy_per_px.iter().zip(&found.mtf).filter(|(f, _)| **f <= 0.6) {
                    let expected = truth(*f, angle, sigma);
                    // 96 rows cross a pixel at 96 places, about 0.01 px apart, so that the mean place of a bin's pixels
                    // is off its middle by half of that at most, 0.003 px as a standard deviation d. Over bins of Δ =
                    // 0.25 px across a line of at least s = 0.42 px (the Gaussian and the pixel) that leaves an error
                    // of 2πf·d·√(Δ/(2√π·s)) = 0.005 at f = 0.6; twice that.
                    assert!((m - expected).abs() < 0.01, "{angle}° σ {sigma}: {m} at {f}, must be {expected}");
                }
                let exact = (0..10_000).map(|i| f64::from(i) * 1e-4).find(|f| truth(*f, angle, sigma) < 0.5);
                let ratio = found.mtf50_cy_per_px.expect("falls") / exact.expect("falls");
                assert!((ratio - 1.0).abs() < 0.01, "{angle}° σ {sigma}: MTF50 {ratio} of what it must be");
            }
        }
    }

    /// The predicted standard error beside the spread of many images that differ in their noise alone.
    #[test]
    fn the_standard_error_is_the_spread_of_repeated_measurements() {
        const REPEATS: usize = 200;
        let clean = edge(6.0, 0.5);
        let of = |plane: &[f32]| slanted_edge(plane, [WIDTH, HEIGHT], [4, 2, 72, 96]).expect("an edge");
        // What is left without noise is the curvature of the edge within bins: a tenth of what is warned of.
        assert!(of(&clean).standard_error_at_half_nyquist < 2e-3, "{}", of(&clean).standard_error_at_half_nyquist);
        for (noise, falls) in [(0.01, false), (0.03, true)] {
            let mut random = Even(7);
            let mut found = vec![Vec::new(); 3];
            let mut predicted = [0.0; 3];
            for _ in 0..REPEATS {
                let noisy = |&value: &f32| (if falls { 1.0 - value } else { value }) + noise * random.next() as f32;
                let noisy: Vec<f32> = clean.iter().map(noisy).collect();
                let response = of(&noisy);
                for (i, frequency) in [10, 25, 40].into_iter().enumerate() {
                    found[i].push(response.mtf[frequency]);
                    predicted[i] += response.standard_error[frequency] / REPEATS as f64;
                }
            }
            for (found, predicted) in found.iter().zip(predicted) {
                let mean = found.iter().sum::<f64>() / REPEATS as f64;
                let variance = found.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (REPEATS - 1) as f64;
                // The standard deviation of n values has the relative standard error 1/√(2n), 0.05; three of it, and 0.1 for
                // the line that is fitted to the noisy edge, which the prediction takes as given.
                assert!((variance.sqrt() / predicted - 1.0).abs() < 0.25, "{} for {predicted}", variance.sqrt());
            }
        }
    }

    #[test]
    fn frequencies_in_mm_are_those_along_the_normal() {
        let response = |is_vertical, angle_deg: f64| EdgeResponse {
            angle_deg,
            is_vertical,
            ..slanted_edge(&edge(5.0, 0.5), [WIDTH, HEIGHT], [4, 2, 72, 96]).expect("an edge")
        };
        // A square pixel of 5 µm has 200 of them in a mm, in every direction.
        for (is_vertical, angle) in [(true, 5.0), (false, -12.0), (true, 40.0)] {
            assert!((response(is_vertical, angle).cycles_per_mm([5e-6; 2]) - 200.0).abs() < 1e-9);
        }
        assert!((response(true, 0.0).cycles_per_mm([4e-6, 8e-6]) - 250.0).abs() < 1e-9);
        assert!((response(false, 0.0).cycles_per_mm([4e-6, 8e-6]) - 125.0).abs() < 1e-9);
    }

    #[test]
    fn the_direction_of_the_edge_makes_no_difference() {
        let upright = edge(6.0, 0.6);
        let turned: Vec<f32> = (0..WIDTH * HEIGHT).map(|i| upright[i % HEIGHT * WIDTH + i / HEIGHT]).collect();
        let falling: Vec<f32> = upright.iter().map(|v| 1.0 - v).collect();
        let of = |plane: &[f32], size, region| slanted_edge(plane, size, region).expect("an edge").mtf50_cy_per_px;
        let expected = of(&upright, [WIDTH, HEIGHT], [0, 0, WIDTH, HEIGHT]).expect("falls");
        for found in
            [of(&turned, [HEIGHT, WIDTH], [0, 0, HEIGHT, WIDTH]), of(&falling, [WIDTH, HEIGHT], [0, 0, WIDTH, HEIGHT])]
        {
            assert!((found.expect("falls") - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn regions_without_a_slanted_edge_are_refused() {
        let region = [0, 0, WIDTH, HEIGHT];
        for plane in [vec![0.5; WIDTH * HEIGHT], edge(0.0, 0.5), edge(45.0, 0.5)] {
            assert_eq!(slanted_edge(&plane, [WIDTH, HEIGHT], region).expect_err("refused").key, "region");
        }
        assert!(slanted_edge(&edge(5.0, 0.5), [WIDTH, HEIGHT], [0, 0, WIDTH + 1, 20]).is_err());
        assert!(slanted_edge(&edge(5.0, 0.5), [WIDTH, HEIGHT], [0, 0, 8, 8]).is_err());
    }
}
