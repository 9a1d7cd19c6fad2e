//! Image lag: charge that does not leave the pixel when it is read out, and comes with later frames. Barriers and
//! pockets between a pinned photodiode and its transfer gate cause it, and in interline CCDs the same at the gate to
//! the register ([Fossum14](photosite_core::references#fossum14), section V).
//!
//! A pixel reads out what light and heat have freed in the frame, q, less what it keeps of it, plus what comes out of
//! what it has kept before, s:
//!
//! signal = q − k(q) + (1 − d)·s,  s' = k(q) + d·s,  k(q) = ℓ·q + min(L, (1 − ℓ)·q)
//!
//! with the lag ℓ, a number of electrons L that stay whatever the signal, and the part d of the kept charge that stays
//! once more. Under steady light s is k/(1 − d), so that the signal is q, and the first dark frame after it shows k(q):
//! what data sheets state as image lag. The one after that shows d·k(q), and so on. Charge that is transferred
//! incompletely, with no memory but the charge itself, has d = ℓ.
//!
//! Electrons stay one by one, each with the probability ℓ or d, so that charge is conserved to the electron and
//! Poisson-distributed charge stays so. Only whole electrons stay: a fraction, or a negative charge, is read out.
//! Emission over the barrier whose rate depends on the charge is left out, as is a reset of the photodiode between
//! frames.

use rayon::prelude::*;

use photosite_core::Invalid;

use super::frame::Frame;
use super::shot_noise::part_of;
use crate::model::ImageLag;
use crate::signal::charge_plane::ChargePlane;
use crate::signal::effects::Stage;

/// Charge that the frames before have left in the pixels: goes from one exposure of a sensor to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftCharge {
    charge: ChargePlane,
}

impl LeftCharge {
    /// Electrons of all pixels together.
    pub fn total_e(&self) -> f64 {
        self.charge.electrons.iter().map(|&e| f64::from(e)).sum()
    }

    /// Adds the left charge to that of a frame.
    pub(crate) fn join(&self, charge: &mut ChargePlane) -> Result<(), Invalid> {
        let size = |plane: &ChargePlane| [plane.width, plane.height, plane.samples];
        if size(&self.charge) != size(charge) {
            let [found, expected] = [size(&self.charge), size(charge)].map(|[width, height, _]| [width, height]);
            let message = format!("the frame before left charge in {found:?} pixels, and this one has {expected:?}");
            return Err(Invalid::new("", message).help("expose only frames of one size after another"));
        }
        charge.electrons.par_iter_mut().zip(&self.charge.electrons).for_each(|(charge, left)| *charge += left);
        Ok(())
    }
}

/// Takes out of the pixels what stays there when they are read out, where the sensor has lag. `before` is in their
/// charge.
pub(crate) fn keep_back(
    frame: &Frame<'_>,
    charge: &mut ChargePlane,
    before: Option<&LeftCharge>,
) -> Option<LeftCharge> {
    let ImageLag { fraction, electrons, decay } = frame.sensor.image_lag?;
    if !frame.stages.has(Stage::ImageLag) {
        return None;
    }
    let streams = frame.temporal(Stage::ImageLag);
    let mut left = ChargePlane::empty(charge.width, charge.height, charge.samples);
    let width = charge.width.max(1);
    let rows = charge.electrons.par_chunks_mut(width).zip(left.electrons.par_chunks_mut(width));
    rows.enumerate().for_each(|(y, (charge, left))| {
        for (x, (charge, left)) in charge.iter_mut().zip(left).enumerate() {
            let held = f64::from(*charge).max(0.0);
            let held = if streams.is_some() { held.floor() } else { held };
            // Wells that overflow, or dead pixels, may hold less than came from before.
            let old = before.map_or(0.0, |before| f64::from(before.charge.electrons[y * width + x])).min(held);
            let new = held - old;
            let mut random = streams.map(|streams| streams.pixel(x, y));
            let slow = part_of(new, fraction, random.as_mut());
            let pocket = electrons.0.floor().min(new - slow);
            let stays = slow + pocket + part_of(old, decay, random.as_mut());
            *charge -= stays as f32;
            *left = stays as f32;
        }
    });
    Some(LeftCharge { charge: left })
}
