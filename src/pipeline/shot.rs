//! The pipeline in memory: light is traced once and exposed as often as one likes, without any folder.

use std::time::Instant;

use super::camera::pixels;
use super::chain::Exposed;
use super::completed_rows::CompletedRows;
use super::monitor::{Event, Monitor, Silent, go_on};
use super::prepare::Prepared;
use super::strips::FilmMemory;
use super::trace::{Trace, Traced, trace};
use crate::capture::{Capture, ExposureSettings};
use crate::develop::DevelopSettings;
use crate::image::{Estimate, Planes};
use crate::io::light_rows::LightRows;
use crate::raw::RawImage;
use crate::sensor::{Exposure, LeftCharge, NoiseMaps};
use crate::units::Seconds;
use crate::{Picture, Result};

/// How a capture is rendered, besides what it says itself.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Hears of the work, and may stop it.
    pub monitor: &'a dyn Monitor,
    /// Memory for the film. The picture does not depend on it.
    pub film_memory: FilmMemory,
}

impl Default for Options<'_> {
    /// Silent, with 4 GiB for the film.
    fn default() -> Self {
        Self { monitor: &Silent, film_memory: FilmMemory::default() }
    }
}

/// Renders the first picture of a capture: prepares, traces, exposes it. No file is touched but those that the capture
/// names. Warnings go to the monitor.
///
/// ```no_run
/// # fn main() -> photosite::Result<()> {
/// let capture = photosite::Capture::load("scenes/cornell-box/capture.toml")?;
/// let shot = photosite::render(&capture, photosite::Options::default())?;
/// shot.raw.save("raw.dng")?;
/// shot.develop(&capture.develop)?.save("image.png")?;
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

/// Light that was traced: the rates at which it frees electrons in each pixel.
pub struct Light {
    rows: LightRows,
    /// Mean rates of the sensor's channels and their variances, e⁻/s and (e⁻/s)².
    pub rates: Estimate,
    /// Samples of each pixel, row by row.
    pub samples: Vec<u32>,
    /// Camera paths that were traced.
    pub paths: u64,
    /// Wall-clock seconds that it took.
    pub trace_s: f64,
}

impl Light {
    /// Irradiance on the sensor in the bands that `output.irradiance` asks for, W·m⁻²·nm⁻¹, a plane for each, named
    /// after its centre in nm; `None` where the capture asks for none.
    pub fn irradiance(&self, capture: &Capture) -> Option<Planes> {
        let bands = capture.output.irradiance.as_ref()?;
        let names: Vec<_> = (0..bands.count).map(|band| bands.centre_nm(band).to_string()).collect();
        self.rows.means(names.iter().map(String::as_str)).to_planes().ok()
    }
}

/// One exposure: what the sensor made of the light.
#[derive(Clone, Debug)]
pub struct Shot {
    /// Digital numbers with all that raw files say of them.
    pub raw: RawImage,
    /// The exposure, of an automatic one as it was found.
    pub exposure: Exposure,
    /// Mean electrons of each channel and their variance from light transport, e⁻ and (e⁻)².
    pub electrons: Estimate,
    /// What each effect that `output.noise_maps` names has added to every number.
    pub noise_maps: NoiseMaps,
    /// Charge that stays in the sensor for the frame after this one; `None` of a sensor without image lag.
    pub left: Option<LeftCharge>,
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
    /// Traces the light of the first picture, in memory.
    ///
    /// # Errors
    ///
    /// A film that needs more memory than it is given where it cannot be cut into strips; that the monitor stopped it.
    pub fn trace(&self, options: Options<'_>) -> Result<Light> {
        let start = Instant::now();
        let camera = self.camera();
        let chain = self.chain();
        let strips = options.film_memory.strips(&self.capture, self.responses.len(), [true, false])?;
        let traced = Trace {
            capture: &self.capture,
            settings: &self.capture.render,
            scene: &self.scene,
            camera: &camera,
            responses: &self.responses,
            filters: self.filters.as_ref(),
            strips: &strips,
            is_part: false,
            chain: &chain,
            folder: None,
            monitor: options.monitor,
        };
        let Traced { rows, paths, pilot_paths, .. } = trace(&traced, None)?;
        let CompletedRows::Light(rows, _) = rows else { unreachable!("sums are kept of parts alone") };
        let in_memory = |reason| crate::Error::io("memory".as_ref(), "read", reason);
        let rates = rows.estimate(chain.channels()).map_err(in_memory)?;
        let samples = rows.counts().map_err(in_memory)?;
        Ok(Light { rows, rates, samples, paths: paths + pilot_paths, trace_s: start.elapsed().as_secs_f64() })
    }

    /// Exposes to that light at the gain of the exposure; each frame has temporal noise of its own, and all share the fixed pattern of the sensor,
    /// which has been in the dark before.
    ///
    /// # Errors
    ///
    /// An exposure that the sensor cannot make, or for which there is too little light.
    pub fn expose(&self, light: &Light, frame: u32) -> Result<Shot> {
        self.expose_after(light, frame, None)
    }

    /// Exposes to that light after a frame that has [left](Shot::left) charge in the sensor.
    ///
    /// # Errors
    ///
    /// As [`expose`](Self::expose).
    pub fn expose_after(&self, light: &Light, frame: u32, before: Option<LeftCharge>) -> Result<Shot> {
        let chain = self.chain();
        let exposed = chain.expose(light.rates.clone(), Seconds(1.0), None)?;
        let mut left = before;
        let maps = &self.capture.output.noise.maps;
        let (raw, noise_maps) = chain.read_out_with_maps(&exposed, exposed.exposure.gain, frame, maps, &mut left)?;
        let Exposed { exposure, electrons, warning } = exposed;
        Ok(Shot { raw, exposure, electrons, noise_maps, left, warnings: warning.into_iter().collect() })
    }

    /// This capture with another exposure, for light that was traced already.
    #[must_use]
    pub fn with_exposure(mut self, exposure: ExposureSettings) -> Self {
        self.capture.exposure = exposure;
        self
    }

    /// Columns and rows of the picture.
    pub fn resolution(&self) -> [u32; 2] {
        pixels(&self.capture)
    }
}
