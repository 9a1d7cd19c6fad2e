//! Crosstalk: light that passes the filter of one pixel and electrons that light frees deep in the silicon end in a
//! neighbour. It mixes the colours of a mosaic.
//!
//! A kernel says where the mean electrons of a pixel are collected. What would leave the image stays where it came
//! from, so that none is lost.

use photosite_raw::Cfa;

use crate::SensorModel;
use crate::model::Kernel;
use crate::signal::charge_plane::ChargePlane;
use crate::signal::effects::{Stage, Stages};
use crate::signal::words::{NONE, Tables, words};

impl SensorModel {
    /// Columns and rows of pixels that crosstalk reaches over.
    pub fn crosstalk_reach(&self) -> [usize; 2] {
        let reach =
            |side: fn(&Kernel) -> usize| self.crosstalk.iter().flatten().map(|k| side(k) / 2).max().unwrap_or(0);
        [reach(Kernel::width), reach(Kernel::height)]
    }

    /// Electrons that are collected on average in the values of column x, row y (see [`Cfa::channel_at`]), far from the
    /// edges, in even light that frees `freed` electrons in each pixel, one number for each of the CFA's channels.
    pub fn collected(&self, freed: &[f64], x: usize, y: usize) -> f64 {
        let Some(kernels) = &self.crosstalk else { return freed[self.cfa.channel_at(x, y)] };
        let (columns, rows) = self.cfa.tile_size();
        let at = |from: isize, size: usize| from.rem_euclid(size as isize) as usize;
        let step = self.cfa.samples_per_pixel() as isize;
        let from = |(channel, kernel): (usize, &Kernel)| -> f64 {
            let parts = kernel.displacements().filter(|&(dx, dy, _)| {
                let (x, y) = (at(x as isize - dx * step, columns), at(y as isize - dy, rows));
                self.cfa.channel_at(x, y) == channel
            });
            freed[channel] * parts.map(|(_, _, part)| f64::from(part)).sum::<f64>()
        };
        kernels.iter().enumerate().map(from).sum()
    }
}

words! {
    /// Crosstalk: displacements, and the tile of channels.
    CrosstalkWords {
        /// Place of channel, columns, rows and part of each displacement.
        displacements: u32,
        count: u32,
        /// Place of the channels of the tile, row by row.
        tile: u32,
        tile_width: u32,
        tile_height: u32,
    }
}

/// Kernels of the sensor's channels; `None` where each pixel collects its own electrons.
fn kernels(sensor: &SensorModel, stages: Stages) -> Option<&[Kernel]> {
    sensor.crosstalk.as_deref().filter(|_| stages.has(Stage::Crosstalk))
}

/// Words of the crosstalk of a sensor.
pub(crate) fn crosstalk_words(sensor: &SensorModel, stages: Stages, tables: &mut Tables) -> CrosstalkWords {
    let Some(kernels) = kernels(sensor, stages) else {
        return CrosstalkWords { displacements: NONE, ..CrosstalkWords::default() };
    };
    let cfa = &sensor.cfa;
    let displacements = displacements(kernels, cfa.samples_per_pixel() as isize);
    let words = displacements
        .iter()
        .flat_map(|&(channel, dx, dy, part)| [channel as u32, dx as i32 as u32, dy as i32 as u32, part.to_bits()]);
    let (tile_width, tile_height) = cfa.tile_size();
    let channels = (0..tile_height).flat_map(|y| (0..tile_width).map(move |x| cfa.channel_at(x, y) as u32));
    CrosstalkWords {
        count: displacements.len() as u32,
        displacements: tables.add(words),
        tile: tables.add(channels),
        tile_width: tile_width as u32,
        tile_height: tile_height as u32,
    }
}

/// Displacements of all channels' electrons with the parts that go there. Where each pixel has a number of every
/// channel, the next one of the same channel is `step` values further.
fn displacements(kernels: &[Kernel], step: isize) -> Vec<(usize, isize, isize, f32)> {
    let of_channel = |(channel, kernel): (usize, &'_ Kernel)| -> Vec<_> {
        kernel.displacements().map(|(dx, dy, part)| (channel, dx * step, dy, part)).collect()
    };
    kernels.iter().enumerate().flat_map(of_channel).collect()
}

/// Spreads mean electrons to neighbours.
pub(crate) fn spread(charge: &mut ChargePlane, sensor: &SensorModel, stages: Stages) {
    if let Some(kernels) = kernels(sensor, stages) {
        *charge = spread_by(charge, kernels, &sensor.cfa);
    }
}

/// Spreads charge by the kernels of the channels, one for each of the CFA's.
fn spread_by(charge: &ChargePlane, kernels: &[Kernel], cfa: &Cfa) -> ChargePlane {
    let (width, height) = (charge.width as isize, charge.height as isize);
    let displacements = displacements(kernels, charge.samples as isize);
    let inside = |x: isize, y: isize| (0..width).contains(&x) && (0..height).contains(&y);
    let at = |x: isize, y: isize| charge.electrons[(y * width + x) as usize];
    let mut spread = ChargePlane::empty(charge.width, charge.height, charge.samples);
    spread.for_each_row(|row| {
        let y = row.y as isize;
        for (x, collected) in (0..width).zip(row.values.iter_mut()) {
            for &(channel, dx, dy, part) in &displacements {
                let (from_x, from_y) = (x - dx, y - dy);
                if inside(from_x, from_y) && cfa.channel_at(from_x as usize, from_y as usize) == channel {
                    *collected += part * at(from_x, from_y);
                }
                if !inside(x + dx, y + dy) && cfa.channel_at(x as usize, y as usize) == channel {
                    *collected += part * at(x, y);
                }
            }
        }
    });
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel(rows: &[&[f64]]) -> Kernel {
        Kernel::new(&rows.iter().map(|row| row.to_vec()).collect::<Vec<_>>()).expect("a kernel")
    }

    #[test]
    fn electrons_go_where_the_kernel_of_their_channel_says_and_none_is_lost() {
        let cfa = Cfa::parse("RGGB").expect("a tile");
        let kernels = [
            kernel(&[&[0.0, 0.125, 0.0], &[0.0, 0.5, 0.25], &[0.0, 0.125, 0.0]]),
            kernel(&[&[1.0]]),
            kernel(&[&[0.25, 0.75, 0.0]]),
        ];
        let mut charge = ChargePlane::empty(5, 4, 1);
        charge.electrons[2 * 5 + 2] = 800.0; // R
        charge.electrons[1] = 64.0; // G
        charge.electrons[3 * 5 + 3] = 400.0; // B
        let spread = spread_by(&charge, &kernels, &cfa);
        let mut expected = ChargePlane::empty(5, 4, 1);
        for (x, y, electrons) in
            [(2, 2, 400.0), (3, 2, 200.0), (2, 1, 100.0), (2, 3, 200.0), (1, 0, 64.0), (3, 3, 300.0)]
        {
            expected.electrons[y * 5 + x] = electrons;
        }
        assert_eq!(spread, expected);
    }

    #[test]
    fn channels_of_one_pixel_do_not_mix() {
        let cfa = Cfa::full(["R", "G"]).expect("two channels");
        let mut charge = ChargePlane::empty(6, 1, 2);
        charge.electrons.copy_from_slice(&[0.0, 0.0, 64.0, 8.0, 0.0, 0.0]);
        let spread = spread_by(&charge, &[kernel(&[&[0.25, 0.5, 0.25]]), Kernel::keep()], &cfa);
        assert_eq!(spread.electrons, [16.0, 0.0, 32.0, 8.0, 16.0, 0.0]);
    }

    #[test]
    fn flat_light_stays_flat_up_to_the_edges() {
        let mut charge = ChargePlane::empty(7, 5, 1);
        charge.electrons.fill(128.0);
        let spread =
            spread_by(&charge, &[kernel(&[&[1.0, 2.0, 1.0], &[2.0, 4.0, 2.0], &[1.0, 2.0, 1.0]])], &Cfa::mono());
        assert_eq!(spread, charge);
    }
}
