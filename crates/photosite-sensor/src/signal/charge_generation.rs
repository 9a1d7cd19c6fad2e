//! Charge generation: each pixel takes the electrons that light frees behind its own colour filter.
//!
//! How many those are on average is known already: quantum efficiency, fill factor and filters are in the mean
//! electrons (see [`SensorModel::responses`](crate::SensorModel::responses)).

use rayon::prelude::*;

use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_raw::Cfa;

use super::charge_plane::ChargePlane;

/// The mean electrons of each pixel's own channel, or of all channels beside each other where every pixel has them, e⁻:
/// finite and not negative, or an error says where they are not.
pub(crate) fn collect(mean_electrons: &Planes, cfa: &Cfa) -> Result<ChargePlane, Invalid> {
    let channels = channel_planes(mean_electrons, cfa)?;
    let samples = cfa.samples_per_pixel();
    let mut charge = ChargePlane::empty(mean_electrons.width() * samples, mean_electrons.height(), samples);
    let (width, row_length) = (mean_electrons.width(), charge.width);
    charge.for_each_row(|row| {
        let tile_width = cfa.tile_size().0;
        // Numbers of one column of the tile share a channel, so the inner loop needs no look-up.
        for column in 0..tile_width.min(row_length) {
            let plane = &channels[cfa.channel_at(column, row.y)][row.y * width..][..width];
            for x in (column..row_length).step_by(tile_width) {
                row.values[x] = plane[x / samples];
            }
        }
    });
    Ok(charge)
}

/// The planes of the CFA's channels, in its order, checked to hold electrons.
fn channel_planes<'a>(planes: &'a Planes, cfa: &Cfa) -> Result<Vec<&'a [f32]>, Invalid> {
    let find = |name: &String| {
        let Some(plane) = planes.plane(name) else {
            let held: Vec<&str> = planes.channels().iter().map(|c| c.name.as_str()).collect();
            let message = format!("the sensor needs a channel {name}, but the image has {}", held.join(", "));
            return Err(Invalid::new("", message));
        };
        match first_impossible(plane) {
            Some(pixel) => {
                let (x, y) = (pixel % planes.width(), pixel / planes.width());
                let message = format!("channel {name} holds {} electrons at column {x}, row {y}", plane[pixel]);
                Err(Invalid::new("", message).help("mean electrons are finite numbers of 0 and more"))
            }
            None => Ok(plane),
        }
    };
    cfa.channels().iter().map(find).collect()
}

/// The first pixel that holds no number of electrons.
fn first_impossible(plane: &[f32]) -> Option<usize> {
    const BLOCK: usize = 1 << 14;
    let possible = |e: f32| (0.0..f32::INFINITY).contains(&e);
    // Whole blocks without an early end, which the compiler turns into vector instructions.
    let block =
        plane.par_chunks(BLOCK).position_first(|block| !block.iter().fold(true, |all, &e| all & possible(e)))?;
    plane[block * BLOCK..].iter().position(|&e| !possible(e)).map(|i| block * BLOCK + i)
}
