//! White balance: the light of the scene becomes equal numbers in all channels.

use glam::DVec3;
use rayon::prelude::*;

use super::colour;
use super::settings::{DevelopSettings, WhiteBalance};
use crate::Invalid;
use crate::colour::temperature;
use crate::raw::{Cfa, RawImage};

/// The camera's response to what counts as white, per channel, the largest 1. `signal` is that of the raw picture after
/// the steps before.
pub(super) fn neutral(raw: &RawImage, signal: &[f32], settings: &DevelopSettings) -> Result<Vec<f64>, Invalid> {
    let channels = raw.cfa.channels().len();
    let neutral = match settings.white_balance {
        WhiteBalance::AsShot => raw.metadata.as_shot_neutral.clone().unwrap_or_else(|| vec![1.0; channels]),
        WhiteBalance::None => vec![1.0; channels],
        WhiteBalance::GreyWorld => means(raw, signal, [0, 0, raw.width, raw.height])?,
        WhiteBalance::WhitePatch => brightest(raw, signal)?,
        WhiteBalance::Patch => {
            let [x, y, columns, rows] = settings.patch_px.unwrap_or_default();
            let fits = |first: usize, n: usize, side| n > 0 && first.checked_add(n).is_some_and(|end| end <= side);
            if !(fits(x, columns, raw.width) && fits(y, rows, raw.height)) {
                let message = format!("does not lie within {} × {} pixels", raw.width, raw.height);
                let help = "give column and row of its first pixel, then columns and rows: [100, 80, 20, 20]";
                return Err(Invalid::new("patch_px", message).help(help));
            }
            means(raw, signal, [x, y, columns, rows])?
        }
        WhiteBalance::Temperature => of_temperature(raw, settings)?,
    };
    if neutral.len() != channels || neutral.iter().any(|n| !(n.is_finite() && *n > 0.0)) {
        let key = if settings.white_balance == WhiteBalance::AsShot { "AsShotNeutral" } else { "white_balance" };
        let message = format!("{neutral:?} is no response to white of {channels} channels");
        return Err(Invalid::new(key, message).help("choose another white_balance, for example \"grey-world\""));
    }
    let largest = neutral.iter().copied().fold(0.0, f64::max);
    Ok(neutral.into_iter().map(|n| n / largest).collect())
}

/// Divides the signal by the response to white.
pub(super) fn apply(signal: &mut [f32], raw: &RawImage, neutral: &[f64], ceiling: f32) {
    let factors: Vec<f32> = neutral.iter().map(|n| (1.0 / n) as f32).collect();
    for_channels(&raw.cfa, signal, raw.row_length(), |channel, values| {
        let factor = factors[channel];
        for value in values {
            *value = (*value * factor).min(ceiling);
        }
    });
}

/// Hands every row's numbers of each place of the tile to `change`, with their channel.
fn for_channels(
    cfa: &Cfa,
    signal: &mut [f32],
    row_length: usize,
    change: impl Fn(usize, std::iter::StepBy<std::iter::Skip<std::slice::IterMut<'_, f32>>>) + Sync,
) {
    let columns = cfa.tile_size().0;
    signal.par_chunks_mut(row_length.max(1)).enumerate().for_each(|(y, row)| {
        for column in 0..columns.min(row.len()) {
            change(cfa.channel_at(column, y), row.iter_mut().skip(column).step_by(columns));
        }
    });
}

/// Signal from which on a pixel counts as saturated: noise takes some of the full ones below 1.
const SATURATED: f32 = 0.98;

/// Mean of each channel over a rectangle, without saturated pixels.
fn means(raw: &RawImage, signal: &[f32], [x, y, columns, rows]: [usize; 4]) -> Result<Vec<f64>, Invalid> {
    let (samples, row_length) = (raw.cfa.samples_per_pixel(), raw.row_length());
    let of_row = |y: usize| {
        let mut sums = vec![(0.0, 0u64); raw.cfa.channels().len()];
        for i in x * samples..(x + columns) * samples {
            let value = signal[y * row_length + i];
            if value < SATURATED {
                let (sum, count) = &mut sums[raw.cfa.channel_at(i, y)];
                (*sum, *count) = (*sum + f64::from(value), *count + 1);
            }
        }
        sums
    };
    let rows: Vec<Vec<(f64, u64)>> = (y..y + rows).into_par_iter().map(of_row).collect();
    let mean = |channel: usize| {
        let (sum, count) = rows.iter().fold((0.0, 0), |(s, n), row| (s + row[channel].0, n + row[channel].1));
        sum / count as f64
    };
    let means: Vec<f64> = (0..raw.cfa.channels().len()).map(mean).collect();
    if means.iter().all(|mean| *mean > 0.0) { Ok(means) } else { Err(nothing_to_balance()) }
}

/// What only one in a thousand pixels of each channel exceeds, saturated ones aside.
fn brightest(raw: &RawImage, signal: &[f32]) -> Result<Vec<f64>, Invalid> {
    const BINS: usize = 4096;
    let row_length = raw.row_length();
    let of_row = |(y, row): (usize, &[f32])| {
        let mut histogram = vec![0u32; BINS * raw.cfa.channels().len()];
        for (i, &value) in row.iter().enumerate().filter(|(_, value)| **value < SATURATED) {
            // A cast takes negative values to 0.
            histogram[raw.cfa.channel_at(i, y) * BINS + (value * BINS as f32) as usize] += 1;
        }
        histogram
    };
    let add = |mut a: Vec<u32>, b: Vec<u32>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    let zero = || vec![0u32; BINS * raw.cfa.channels().len()];
    let histogram = signal.par_chunks(row_length.max(1)).enumerate().map(of_row).reduce(zero, add);
    let level = |counts: &[u32]| {
        let mut left = counts.iter().sum::<u32>() / 1000;
        let bin = counts.iter().rposition(|&count| {
            let is_here = count > left;
            left = left.saturating_sub(count);
            is_here
        });
        (bin.unwrap_or(0) as f64 + 0.5) / BINS as f64
    };
    let levels: Vec<f64> = histogram.chunks(BINS).map(level).collect();
    if levels.iter().all(|level| *level > 1.0 / BINS as f64) { Ok(levels) } else { Err(nothing_to_balance()) }
}

fn nothing_to_balance() -> Invalid {
    let message = "a channel has seen no light there, or only too much";
    Invalid::new("white_balance", message).help("choose another white_balance, for example \"as-shot\"")
}

/// The response to a light of a colour temperature, by the matrix that the file gives for that temperature.
fn of_temperature(raw: &RawImage, settings: &DevelopSettings) -> Result<Vec<f64>, Invalid> {
    let (kelvin, tint) = (settings.temperature_k.unwrap_or(f64::NAN), settings.tint.unwrap_or(0.0));
    let Some([x, y]) = temperature::chromaticity(kelvin, tint) else {
        let message = format!("{kelvin} K with a tint of {tint} is no colour of light");
        return Err(Invalid::new("temperature_k", message).help("for example temperature_k = 5000 and tint = 0"));
    };
    let Some(matrices) = colour::CameraMatrices::new(&raw.metadata)? else {
        let message = "the raw file has no colour matrix, so a temperature says nothing of its channels";
        return Err(Invalid::new("white_balance", message).help("for example white_balance = \"grey-world\""));
    };
    let white = DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    Ok(matrices.at(white).iter().map(|row| row.dot(white)).collect())
}
