//! White balance: the light of the scene becomes equal values in all channels.

use rayon::prelude::*;

use photosite_core::rows::for_each_row;

use super::choices::WhiteBalance;
use super::colour;
use super::settings::DevelopSettings;
use photosite_core::Invalid;
use photosite_core::colour::temperature;
use photosite_core::spectrum::cie;
use photosite_raw::{Cfa, RawImage};

/// The camera's response to what counts as white, per channel, the largest 1. `signal` is that of the raw image after
/// the steps before.
pub(super) fn neutral(raw: &RawImage, signal: &[f32], settings: &DevelopSettings) -> Result<Vec<f64>, Invalid> {
    let channels = raw.cfa.channels().len();
    let neutral = match settings.white_balance {
        WhiteBalance::AsShot => match (&raw.metadata.as_shot_neutral, raw.metadata.as_shot_white_xy) {
            (Some(neutral), _) => neutral.clone(),
            (None, Some(white)) => response_to(white, raw)?,
            (None, None) => vec![1.0; channels],
        },
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
        lamp @ (WhiteBalance::Candle
        | WhiteBalance::Incandescent
        | WhiteBalance::Halogen
        | WhiteBalance::Fluorescent
        | WhiteBalance::D50
        | WhiteBalance::Flash
        | WhiteBalance::Daylight
        | WhiteBalance::Overcast
        | WhiteBalance::Shade
        | WhiteBalance::BlueSky) => response_to(lamp.lamp().expect("lamps have a colour"), raw)?,
    };
    if neutral.len() != channels || neutral.iter().any(|n| !(n.is_finite() && *n > 0.0)) {
        let key = if settings.white_balance == WhiteBalance::AsShot { "AsShotNeutral" } else { "white_balance" };
        let message = format!("{neutral:?} is not a response to white of {channels} channels");
        return Err(Invalid::new(key, message).help("choose another white_balance, for example \"grey-world\""));
    }
    let largest = neutral.iter().copied().fold(0.0, f64::max);
    Ok(neutral.into_iter().map(|n| n / largest).collect())
}

/// Divides the signal by the response to white.
pub(super) fn apply(signal: &mut [f32], raw: &RawImage, neutral: &[f64], ceiling: f32) {
    let factors = factors(neutral);
    for_channels(&raw.cfa, signal, raw.row_length(), |channel, values| {
        let factor = factors[channel];
        for value in values {
            *value = (*value * factor).min(ceiling);
        }
    });
}

/// Factor of each channel.
pub(super) fn factors(neutral: &[f64]) -> Vec<f32> {
    neutral.iter().map(|n| (1.0 / n) as f32).collect()
}

/// Hands the values of each place of the tile in every row to `change`, with their channel.
fn for_channels(
    cfa: &Cfa,
    signal: &mut [f32],
    row_length: usize,
    change: impl Fn(usize, std::iter::StepBy<std::iter::Skip<std::slice::IterMut<'_, f32>>>) + Sync,
) {
    let columns = cfa.tile_size().0;
    for_each_row(signal, row_length, |y, row| {
        for column in 0..columns.min(row.len()) {
            change(cfa.channel_at(column, y), row.iter_mut().skip(column).step_by(columns));
        }
    });
}

/// Signal from which on a pixel counts as saturated: noise takes some of the full ones below 1.
const SATURATED: f32 = 0.98;
/// Part of the tiles of a cell that may be saturated, as those of hot pixels are. Where there are more, noise decides
/// which of the others are, and those that are left are too dark.
const MOST_SATURATED: f64 = 1.0 / 16.0;
/// Pixels along a cell, about. Images have six cells along their shorter side at least.
const CELL: usize = 16;
/// Number of cells of which one is white.
const WHITE_CELLS: usize = 100;
/// Number of white cells in images of few cells: one in the second figure of all, from 1 up to the first.
const FEW_WHITE_CELLS: [usize; 2] = [16, 16];

/// Sums and counts of the channels.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sums(Vec<(f64, u64)>);

impl Sums {
    fn of(channels: usize) -> Self {
        Self(vec![(0.0, 0); channels])
    }

    fn add(&mut self, other: &Self) {
        for ((sum, count), (more, number)) in self.0.iter_mut().zip(&other.0) {
            (*sum, *count) = (*sum + more, *count + number);
        }
    }

    /// The mean of each channel, where all of them saw light.
    fn means(&self) -> Option<Vec<f64>> {
        let means: Vec<f64> = self.0.iter().map(|(sum, count)| sum / *count as f64).collect();
        means.iter().all(|mean| *mean > 0.0).then_some(means)
    }
}

/// A square of whole tiles, every other of which is counted in each of two sums.
type Cell = [Sums; 2];

/// Cells of a rectangle: columns and rows of its first pixel, columns and rows. A tile that is saturated in one channel
/// is left out in all, and a cell with many of them altogether: of blown highlights the other channels would stay.
fn cells(raw: &RawImage, signal: &[f32], [x, y, columns, rows]: [usize; 4]) -> Vec<Cell> {
    let (samples, row_length, channels) = (raw.cfa.samples_per_pixel(), raw.row_length(), raw.cfa.channels().len());
    let (tile_numbers, tile_rows) = raw.cfa.tile_size();
    let tile = [tile_numbers / samples, tile_rows];
    let wanted = (columns.min(rows) / 6).clamp(1, CELL);
    // Two tiles at least, one for each sum.
    let side = tile.map(|tile| tile * wanted.div_ceil(tile).max(2));
    let of_cell = |left: usize, top: usize, seen: &mut Sums| -> Option<Cell> {
        let mut cell = [Sums::of(channels), Sums::of(channels)];
        let (mut tiles, mut saturated) = (0, 0);
        let [right, bottom] = [(left + side[0]).min(x + columns), (top + side[1]).min(y + rows)];
        for (j, first_row) in (top..bottom).step_by(tile[1]).enumerate() {
            for (i, first) in (left..right).step_by(tile[0]).enumerate() {
                let mut is_full = false;
                seen.0.fill((0.0, 0));
                for row in first_row..(first_row + tile[1]).min(bottom) {
                    for number in first * samples..(first + tile[0]).min(right) * samples {
                        let value = signal[row * row_length + number];
                        is_full |= value >= SATURATED;
                        let (sum, count) = &mut seen.0[raw.cfa.channel_at(number, row)];
                        (*sum, *count) = (*sum + f64::from(value), *count + 1);
                    }
                }
                tiles += 1;
                if is_full {
                    saturated += 1;
                } else {
                    cell[(i + j) % 2].add(seen);
                }
            }
        }
        (f64::from(saturated) <= f64::from(tiles) * MOST_SATURATED).then_some(cell)
    };
    let tops: Vec<usize> = (y..y + rows).step_by(side[1]).collect();
    let of_row = |top: usize| {
        let mut seen = Sums::of(channels);
        (x..x + columns).step_by(side[0]).filter_map(|left| of_cell(left, top, &mut seen)).collect::<Vec<_>>()
    };
    tops.into_par_iter().flat_map_iter(of_row).collect()
}

fn total<'a>(sums: impl Iterator<Item = &'a Sums>, channels: usize) -> Sums {
    sums.fold(Sums::of(channels), |mut total, sums| {
        total.add(sums);
        total
    })
}

/// Mean of each channel over a rectangle, without what is saturated.
fn means(raw: &RawImage, signal: &[f32], rectangle: [usize; 4]) -> Result<Vec<f64>, Invalid> {
    let cells = cells(raw, signal, rectangle);
    total(cells.iter().flatten(), raw.cfa.channels().len()).means().ok_or_else(nothing_to_balance)
}

/// Mean of the brightest cells that are not saturated. The channels count for brightness by what they are of their
/// means, so that none rules by being sensitive. Noise would make bright cells of those in which it adds up; so one
/// half of each tells how bright it is, and the other what is white.
fn brightest(raw: &RawImage, signal: &[f32]) -> Result<Vec<f64>, Invalid> {
    let channels = raw.cfa.channels().len();
    let cells = cells(raw, signal, [0, 0, raw.width, raw.height]);
    let grey = total(cells.iter().flatten(), channels).means().ok_or_else(nothing_to_balance)?;
    let brightness = |[judged, measured]: &Cell| -> Option<f64> {
        measured.means()?;
        Some(judged.means()?.iter().zip(&grey).map(|(mean, grey)| mean / grey).sum())
    };
    let mut bright: Vec<(f64, &Cell)> = cells.iter().filter_map(|cell| Some((brightness(cell)?, cell))).collect();
    bright.sort_by(|a, b| b.0.total_cmp(&a.0));
    let [at_most, one_in] = FEW_WHITE_CELLS;
    let white = (bright.len() / WHITE_CELLS).max((bright.len() / one_in).clamp(1, at_most));
    let measured = bright.iter().take(white).map(|(_, [_, measured])| measured);
    total(measured, channels).means().ok_or_else(nothing_to_balance)
}

fn nothing_to_balance() -> Invalid {
    let message = "a channel has seen no light there, or only too much";
    Invalid::new("white_balance", message).help("choose another white_balance, for example \"as-shot\"")
}

/// The response to a light of a colour temperature, by the matrix that the file gives for that temperature.
fn of_temperature(raw: &RawImage, settings: &DevelopSettings) -> Result<Vec<f64>, Invalid> {
    let (kelvin, tint) = (settings.temperature_k.unwrap_or(f64::NAN), settings.tint.unwrap_or(0.0));
    let Some(white) = temperature::chromaticity(kelvin, tint) else {
        let message = format!("{kelvin} K with a tint of {tint} is not a colour of light");
        return Err(Invalid::new("temperature_k", message).help("for example temperature_k = 5000 and tint = 0"));
    };
    response_to(white, raw)
}

/// The response to a white of this chromaticity.
fn response_to(white: [f64; 2], raw: &RawImage) -> Result<Vec<f64>, Invalid> {
    let Some(matrices) = colour::CameraMatrices::new(&raw.metadata)? else {
        let message = "the raw file has no colour matrix, so a colour of light does not determine its channels";
        return Err(Invalid::new("white_balance", message).help("for example white_balance = \"grey-world\""));
    };
    let white = cie::xyz_of_chromaticity(white);
    Ok(matrices.at(white).iter().map(|row| row.dot(white)).collect())
}
