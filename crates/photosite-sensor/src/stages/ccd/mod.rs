//! Charge-coupled devices (CCD): the charge of every pixel is shifted out, row by row and then pixel by pixel, to one
//! amplifier and one converter.
//!
//! Rows leave upwards, the top one first, into a register that they leave to the left. What goes wrong on the way has a
//! file each: charge that overflows ([`blooming`]), light during the shift ([`smear`]), and electrons that stay behind
//! ([`transfer`]). Wells that come out before the first and after the last pixel hold no light (prescan, overscan) and
//! show what was left behind.

mod blooming;
mod smear;
mod transfer;

use rayon::prelude::*;

use super::shot_noise::poisson;
use crate::model::{Ccd, CcdArchitecture, Overscan};
use crate::signal::charge_plane::ChargePlane;
use crate::signal::effects::Stage;
use crate::stages::frame::Frame;
use crate::stages::full_well::FullWell;

/// Adds smear to the mean electrons of the pixels. Returns what a well that passes through a whole column collects, for
/// each column.
pub(crate) fn smear(ccd: &Ccd, frame: &Frame<'_>, mean_electrons: &mut ChargePlane) -> Vec<f32> {
    if ccd.smear_row_time.0 == 0.0 || !frame.stages.has(Stage::Smear) {
        return Vec::new();
    }
    let ratio = ccd.smear_row_time.0 / frame.exposure.time.0;
    let own_row = match ccd.architecture {
        CcdArchitecture::Interline => true,
        CcdArchitecture::FrameTransfer | CcdArchitecture::FullFrame => false,
    };
    smear::add(&mut mean_electrons.electrons, mean_electrons.width, ratio, own_row)
}

/// Lets full wells overflow along their columns.
pub(crate) fn bloom(ccd: &Ccd, frame: &Frame<'_>, charge: &mut ChargePlane) {
    let full_well = frame.sensor.full_well.0;
    let overflows = |charge: &ChargePlane| charge.electrons.par_iter().any(|&e| f64::from(e) > full_well);
    if !frame.stages.has(Stage::Blooming) || !overflows(charge) {
        return;
    }
    let drain = (ccd.anti_blooming_factor - 1.0) * full_well;
    *charge = charge.map_columns(charge.height, |_, column| {
        blooming::overflow(column, full_well, drain);
    });
}

/// Shifts all charge out. `passing`: what [`smear`] leaves in a well from beyond the last row. The plane that comes out
/// has the wells before and after those of the pixels, too.
pub(crate) fn shift_out(ccd: &Ccd, frame: &Frame<'_>, charge: ChargePlane, passing: &[f32]) -> ChargePlane {
    let Overscan { prescan_columns, columns, rows } = ccd.overscan;
    // Within, `None` for mean charge.
    let stays_behind =
        |inefficiency: f64, stage| (inefficiency > 0.0 && frame.stages.has(stage)).then(|| frame.temporal(stage));

    let vertical = stays_behind(ccd.vertical_inefficiency, Stage::VerticalTransfer);
    let shot_noise = frame.temporal(Stage::ShotNoise);
    let holds = FullWell::new(frame).map_or(f64::INFINITY, |full_well| full_well.capacity_e.into());
    let storage_rows = match ccd.architecture {
        CcdArchitecture::FrameTransfer => charge.height,
        CcdArchitecture::Interline | CcdArchitecture::FullFrame => 0,
    };
    let pixel_rows = charge.height;
    let charge = if vertical.is_none() && rows == 0 {
        charge
    } else {
        charge.map_columns(pixel_rows + rows, |x, column| {
            if let Some(&mean) = passing.get(x) {
                for (y, well) in column.iter_mut().enumerate().skip(pixel_rows) {
                    let random = shot_noise.as_ref().map(|streams| streams.pixel(x, y));
                    let collected = random.map_or(mean.into(), |mut random| poisson(mean.into(), &mut random));
                    *well = collected.min(holds);
                }
            }
            if let Some(streams) = &vertical {
                let random = |y| streams.map(|streams| streams.pixel(x, y));
                transfer::shift_out(column, ccd.vertical_inefficiency, storage_rows + 1, random);
            }
        })
    };

    let horizontal = stays_behind(ccd.horizontal_inefficiency, Stage::HorizontalTransfer);
    if horizontal.is_none() && prescan_columns + columns == 0 {
        return charge;
    }
    // The registers of several chips work side by side.
    charge.map_rows(prescan_columns, columns, |[first, step], y, line| {
        if let Some(streams) = &horizontal {
            let random = |i| streams.map(|streams| streams.pixel(first + i * step, y));
            transfer::shift_out(line, ccd.horizontal_inefficiency, prescan_columns + 1, random);
        }
    })
}
