//! Frames of a series: what each hands on to the next, and the times of a bracket.

use std::sync::Arc;

use photosite_core::Result;
use photosite_core::image::{Estimate, Planes};
use photosite_core::units::{Decibels, Seconds};
use photosite_raw::RawImage;
use photosite_sensor::{Exposure, LeftCharge, NoiseMap, NoiseMaps, Stage};

use super::chain::{Chain, CollectedElectrons, ReadOut};

/// State that a frame hands on to the one after it: charge left in the sensor (image lag), and the gain that
/// `exposure.gain_control` chooses for it. The default is the state of a sensor that has been in the dark.
#[derive(Clone, Debug, Default)]
pub(crate) struct Carried {
    left: Option<LeftCharge>,
    gain: Option<Decibels>,
}

/// Frames that a sensor takes one after the other. All frames come from here, whoever asks for them: those of folders,
/// of Python and of the live view. There is a next one while there is light, and of a bracket a next time.
pub(crate) struct FrameSeries<'a> {
    pub(crate) chain: Chain<'a>,
    pub(crate) maps: &'a [NoiseMap],
    /// Number of the next frame.
    pub(crate) number: u32,
    /// State after the frames before it.
    pub(crate) carried: Carried,
    pub(crate) light: Option<CollectedElectrons>,
    /// Times of the bracket, if the light is exposed for one.
    pub(crate) times: Option<Vec<Seconds>>,
    /// Gains of the frames so far, where there is gain control.
    pub(crate) gains: Vec<Decibels>,
}

/// Frame of a series, and the exposure that it was taken with.
pub(crate) struct Frame {
    pub(crate) number: u32,
    pub(crate) raw: RawImage,
    /// Noise maps of the frame.
    pub(crate) maps: NoiseMaps,
    pub(crate) exposure: Exposure,
    /// Name of the card that has exposed, or the warning that the processor has; `None` without a card.
    pub(crate) device: Option<Result<String, String>>,
}

impl<'a> FrameSeries<'a> {
    /// A series from the frame of that number on, which comes after frames of that state.
    pub(crate) fn new(chain: Chain<'a>, maps: &'a [NoiseMap], (number, carried): (u32, Carried)) -> Self {
        Self { chain, maps, number, carried, light: None, times: None, gains: Vec::new() }
    }

    /// Sets the light that frames see from now on.
    ///
    /// # Errors
    ///
    /// A bracket with a time that the sensor cannot make.
    pub(crate) fn see(&mut self, light: CollectedElectrons) -> Result<()> {
        self.times = self.chain.bracket(&light)?;
        self.light = Some(light);
        Ok(())
    }

    /// Whether a frame depends on the frames before it.
    pub(crate) fn hands_on(&self) -> bool {
        let (sensor, exposure) = (self.chain.settings.sensor, self.chain.settings.exposure);
        exposure.gain_control.is_some() || sensor.image_lag.is_some() && exposure.stages.has(Stage::ImageLag)
    }
}

impl Iterator for FrameSeries<'_> {
    type Item = Result<Frame>;

    fn next(&mut self) -> Option<Self::Item> {
        let light = self.light.as_ref()?;
        let number = self.number;
        let of_bracket = match &self.times {
            Some(times) => Some(at_time(light, *times.get(number as usize)?)),
            None => None,
        };
        let exposed = of_bracket.as_ref().unwrap_or(light);
        let gain = self.carried.gain.unwrap_or(exposed.exposure.gain);
        let read = self.chain.read_out_with_maps(exposed, gain, number, self.maps, &mut self.carried.left);
        Some(read.map(|ReadOut { raw, maps, device }| {
            if let Some(control) = &self.chain.settings.exposure.gain_control {
                self.gains.push(gain);
                self.carried.gain = Some(control.next(gain, &raw));
            }
            self.number += 1;
            Frame { number, raw, maps, exposure: Exposure { gain, ..exposed.exposure }, device }
        }))
    }
}

/// The light of an exposure, collected for another time.
fn at_time(exposed: &CollectedElectrons, time: Seconds) -> CollectedElectrons {
    let mean = exposed.electrons.mean.clone().scaled(time.0 / exposed.exposure.time.0);
    // No raw image needs the variance.
    let variance = Planes::zeros::<&str>(mean.width(), mean.height(), []);
    let electrons = Arc::new(Estimate { mean, variance });
    CollectedElectrons { exposure: Exposure { time, ..exposed.exposure }, electrons, warnings: Vec::new() }
}
