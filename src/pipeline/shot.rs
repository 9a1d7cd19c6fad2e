//! The pipeline in memory: light is traced once and exposed as often as one likes, without any folder.

use std::sync::Arc;

use super::camera::pixels;
use super::carried::Carried;
use super::chain::Exposed;
use super::light::Light;
use super::monitor::{Event, go_on};
use super::options::Options;
use super::prepare::Prepared;
use crate::capture::Capture;
use crate::develop::DevelopSettings;
use crate::image::Estimate;
use crate::raw::RawImage;
use crate::sensor::{Exposure, NoiseMap, NoiseMaps};
use crate::units::Seconds;
use crate::{Picture, Result};

/// Renders the first picture of a capture: prepares, traces, exposes it. No file is touched but those that the capture
/// names. Warnings go to the monitor.
///
/// ```no_run
/// # fn main() -> photosite::Result<()> {
/// let capture = photosite::Capture::load("scenes/cornell-box/capture.toml")?;
/// let shot = photosite::render(&capture, photosite::Options::default())?;
/// shot.raw.save("raw.dng")?;
/// shot.develop(capture.develop())?.save("image.png")?;
/// # Ok(())
/// # }
/// ```
///
/// # Errors
///
/// What is wrong with the capture as a whole, see [`Prepared::new`]; that the monitor stopped it.
pub fn render(capture: &Capture, options: Options<'_>) -> Result<Shot> {
    go_on(options.monitor)?;
    let prepared = Prepared::new(capture.clone())?;
    prepared.warnings().iter().for_each(|warning| options.monitor.report(Event::Warning(warning)));
    let light = prepared.trace(options)?;
    go_on(options.monitor)?;
    let shot = prepared.expose(&light, 0)?;
    shot.warnings.iter().for_each(|warning| options.monitor.report(Event::Warning(warning)));
    Ok(shot)
}

/// One exposure: what the sensor made of the light.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Digital numbers with all that raw files say of them.
    pub raw: RawImage,
    /// The exposure, of an automatic one as it was found.
    pub exposure: Exposure,
    /// Mean electrons of each channel and their variance from light transport, e⁻ and (e⁻)².
    pub electrons: Arc<Estimate>,
    /// What each effect that `output.noise_maps` names has added to every number.
    pub noise_maps: NoiseMaps,
    /// State that this frame hands on to the next.
    pub carried: Carried,
    /// Warnings about the exposure.
    pub warnings: Vec<String>,
}

impl Shot {
    /// Develops the raw image.
    ///
    /// # Errors
    ///
    /// As [`Picture::develop`].
    pub fn develop(&self, settings: &DevelopSettings) -> Result<Picture> {
        Picture::develop(&self.raw, settings)
    }
}

impl Prepared {
    /// Exposes to that light at the gain of the exposure; each frame has temporal noise of its own, and all share the fixed pattern of the sensor,
    /// which has been in the dark before.
    ///
    /// # Errors
    ///
    /// An exposure that the sensor cannot make, or for which there is too little light.
    pub fn expose(&self, light: &Light, frame: u32) -> Result<Shot> {
        self.expose_after(light, frame, &Carried::default())
    }

    /// Exposes to that light after a frame of that [state](Shot::carried).
    ///
    /// # Errors
    ///
    /// As [`expose`](Self::expose).
    pub fn expose_after(&self, light: &Light, frame: u32, before: &Carried) -> Result<Shot> {
        self.expose_with_maps(light, frame, before, &self.capture.output.noise.maps)
    }

    /// Exposes to that light after a frame of that [state](Shot::carried), with these noise maps.
    ///
    /// # Errors
    ///
    /// As [`expose`](Self::expose).
    pub fn expose_with_maps(&self, light: &Light, frame: u32, before: &Carried, maps: &[NoiseMap]) -> Result<Shot> {
        let chain = self.chain();
        let (rates, mut warnings) = self.rates(light)?;
        let exposed = chain.expose(rates, Seconds(1.0), None)?;
        let mut carried = before.clone();
        let (raw, noise_maps, exposure) = chain.read_out_next(&exposed, frame, maps, &mut carried)?;
        let Exposed { electrons, warnings: of_exposure, .. } = exposed;
        warnings.extend(of_exposure);
        Ok(Shot { raw, exposure, electrons, noise_maps, carried, warnings })
    }

    /// Columns and rows of the picture.
    pub fn resolution(&self) -> [u32; 2] {
        pixels(&self.capture)
    }
}
