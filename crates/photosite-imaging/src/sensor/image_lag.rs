//! Image lag: charge that does not leave the pixel when it is read out, and comes with later frames. Barriers and pockets
//! between a pinned photodiode and its transfer gate cause it, and in interline CCDs the same at the gate to the register
//! ([Fossum14](photosite_core::references#fossum14), section V).
//!
//! A pixel reads out what light and heat have freed in the frame, q, less what it keeps of it, plus what comes out of what it
//! has kept before, s:
//!
//! signal = q − k(q) + (1 − d)·s,  s' = k(q) + d·s,  k(q) = ℓ·q + min(L, (1 − ℓ)·q)
//!
//! with the lag ℓ, a number of electrons L that stay whatever the signal, and the part d of the kept charge that stays once
//! more. Under steady light s is k/(1 − d), so that the signal is q, and the first dark frame after it shows k(q): what data
//! sheets state as image lag. The one after that shows d·k(q), and so on. Charge that is transferred incompletely, with no
//! memory but the charge itself, has d = ℓ.
//!
//! Electrons stay one by one, each with the probability ℓ or d, so that charge is conserved to the electron and
//! Poisson-distributed charge stays so. Only whole electrons stay: a fraction, or a negative charge, is read out. Emission
//! over the barrier whose rate depends on the charge is left out, as is a reset of the photodiode between frames.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::units::Electrons;

use super::charge_plane::ChargePlane;
use super::description::SensorKind;
use super::expose::Frame;
use super::model::checks::not_negative;
use super::shot_noise::binomial;
use super::stage::Stage;
use super::{SensorDescription, Shutter};

/// `[charge.image_lag]`: charge that stays in the pixel when it is read out and comes with later frames.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImageLagDescription {
    /// Residual signal of the first dark frame after steady light, % of the signal, as data sheets state it.
    pub percent: f64,
    /// Residual signal of that frame besides, whatever the signal, e⁻.
    pub electrons: f64,
    /// Residual signal of each dark frame over that of the one before it. Left out: percent/100, as where a part of the charge
    /// is not transferred.
    pub decay: Option<f64>,
}

/// Charge that stays in the pixel when it is read out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageLag {
    /// ℓ: residual signal of the first dark frame after steady light over that light's signal, 0 to below 1.
    pub fraction: f64,
    /// L: residual signal of that frame besides.
    pub electrons: Electrons,
    /// d: residual signal of each dark frame over that of the one before it, 0 to below 1.
    pub decay: f64,
}

impl ImageLag {
    /// `None` where nothing stays. Keys of errors are those of the sensor file.
    pub(super) fn new(d: &SensorDescription, shutter: &Shutter) -> Result<Option<Self>, Invalid> {
        const KEY: &str = "charge.image_lag";
        let Some(lag) = &d.charge.image_lag else { return Ok(None) };
        let below_one = |key: &str, value: f64, most: f64| {
            if (0.0..most).contains(&value) {
                return Ok(value / most);
            }
            Err(Invalid::new(format!("{KEY}.{key}"), format!("must be at least 0 and below {most}, got {value}"))
                .help("write 0 to leave this out"))
        };
        let fraction = below_one("percent", lag.percent, 100.0)?;
        let electrons = Electrons(not_negative(&format!("{KEY}.electrons"), lag.electrons)?);
        let decay = lag.decay.map_or(Ok(fraction), |decay| below_one("decay", decay, 1.0))?;
        if fraction == 0.0 && electrons.0 == 0.0 {
            return Ok(None);
        }
        let clash = match d.kind {
            SensorKind::Cmos | SensorKind::Ccd => None,
            SensorKind::Spad => Some("kind = \"spad\", whose pixels keep no charge"),
        };
        let clash = clash
            .or(d.charge.logarithmic_reference_e_per_s.map(|_| "logarithmic pixels, which are never emptied"))
            .or(shutter.scans().then_some("a scanning sensor, whose lines would leave charge to each other"));
        match clash {
            Some(clash) => Err(Invalid::new(KEY, format!("cannot go with {clash}")).help("remove charge.image_lag")),
            None => Ok(Some(Self { fraction, electrons, decay })),
        }
    }

    /// Frames under steady light until what a pixel keeps is within a thousandth of what it will be.
    pub fn settling_frames(&self) -> u32 {
        if self.decay < 1e-3 { 1 } else { (1e-3_f64.ln() / self.decay.ln()).ceil() as u32 }
    }
}

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

    /// Adds it to the charge of a frame.
    pub(super) fn join(&self, charge: &mut ChargePlane) -> Result<(), Invalid> {
        let size = |plane: &ChargePlane| [plane.width, plane.height, plane.samples];
        if size(&self.charge) != size(charge) {
            let [found, expected] = [size(&self.charge), size(charge)].map(|[width, height, _]| [width, height]);
            let message = format!("the frame before left charge in {found:?} pixels, and this one has {expected:?}");
            return Err(Invalid::new("", message).help("expose frames of one size after each other"));
        }
        charge.electrons.par_iter_mut().zip(&self.charge.electrons).for_each(|(charge, left)| *charge += left);
        Ok(())
    }
}

/// Takes out of the pixels what stays there when they are read out, where the sensor has lag. `before` is in their charge.
pub(super) fn keep_back(
    frame: &Frame<'_>,
    charge: &mut ChargePlane,
    before: Option<&LeftCharge>,
) -> Option<LeftCharge> {
    let ImageLag { fraction, electrons, decay } = frame.sensor.image_lag?;
    let streams = frame.temporal(Stage::ImageLag)?;
    let mut left = ChargePlane::empty(charge.width, charge.height, charge.samples);
    let width = charge.width.max(1);
    let rows = charge.electrons.par_chunks_mut(width).zip(left.electrons.par_chunks_mut(width));
    rows.enumerate().for_each(|(y, (charge, left))| {
        for (x, (charge, left)) in charge.iter_mut().zip(left).enumerate() {
            let held = f64::from(*charge).floor().max(0.0);
            // Wells that overflow, or dead pixels, may hold less than came from before.
            let old = before.map_or(0.0, |before| f64::from(before.charge.electrons[y * width + x])).min(held);
            let new = held - old;
            let mut random = streams.pixel(x, y);
            let slow = binomial(new, fraction, &mut random);
            let pocket = electrons.0.floor().min(new - slow);
            let stays = slow + pocket + binomial(old, decay, &mut random);
            *charge -= stays as f32;
            *left = stays as f32;
        }
    });
    Some(LeftCharge { charge: left })
}
