//! State that one frame of a series hands on to the next.

use crate::Result;
use crate::raw::RawImage;
use crate::sensor::{Exposure, LeftCharge, NoiseMap, NoiseMaps};
use crate::units::Decibels;

use super::chain::{Chain, Exposed};

/// State that a frame hands on to the one after it: charge left in the sensor (image lag), and the gain that
/// `exposure.gain_control` chooses for it. The default is the state of a sensor that has been in the dark.
#[derive(Clone, Debug, Default)]
pub struct Carried {
    left: Option<LeftCharge>,
    gain: Option<Decibels>,
}

impl Carried {
    /// Whether frames of this sensor and exposure are independent of the frames before them.
    pub fn is_empty(&self) -> bool {
        self.left.is_none() && self.gain.is_none()
    }
}

impl Chain<'_> {
    /// Reads out the next frame of a series, with maps of what some effects did, and the exposure at the gain that it
    /// was taken with. `carried` is the state after the frame before, and then after this one.
    pub(super) fn read_out_next(
        &self,
        exposed: &Exposed,
        frame: u32,
        maps: &[NoiseMap],
        carried: &mut Carried,
    ) -> Result<(RawImage, NoiseMaps, Exposure)> {
        let gain = carried.gain.unwrap_or(exposed.exposure.gain);
        let (raw, maps) = self.read_out_with_maps(exposed, gain, frame, maps, &mut carried.left)?;
        carried.gain = self.settings.exposure.gain_control.as_ref().map(|control| control.next(gain, &raw));
        Ok((raw, maps, Exposure { gain, ..exposed.exposure }))
    }
}
