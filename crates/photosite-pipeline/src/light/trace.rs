//! Light that is traced in memory.

use std::sync::Arc;

use super::{Light, Origin};
use crate::expose::shot::Shot;
use crate::monitor::{Event, go_on};
use crate::options::Options;
use crate::prepare::prepared::Prepared;
use crate::trace::traced_light::TracedLight;
use photosite_capture::Capture;
use photosite_core::Result;
use photosite_transport::film::Film;

/// Renders the first image of a capture: prepares, traces, exposes it. No file is touched but those that the capture
/// names. Warnings go to the monitor.
///
/// ```no_run
/// use photosite_capture::Capture;
/// use photosite_pipeline::{Options, render};
///
/// # fn main() -> photosite_core::Result<()> {
/// let capture = Capture::load("scenes/cornell-box/capture.toml")?;
/// let shot = render(&capture, Options::default())?;
/// photosite_files::raw_file::save_raw(&shot.raw, "raw.dng")?;
/// shot.develop(capture.develop())?.save("image.png")?;
/// # Ok(())
/// # }
/// ```
///
/// # Errors
///
/// Errors of the capture as a whole, see [`Prepared::new`]; that the monitor stopped it.
pub fn render(capture: &Capture, options: Options<'_>) -> Result<Shot> {
    go_on(options.monitor)?;
    let prepared = Prepared::new(capture.clone())?;
    prepared.warnings().iter().for_each(|warning| options.monitor.report(Event::Warning(warning)));
    let light = prepared.trace(options)?;
    go_on(options.monitor)?;
    let shot = light.frame(0, &light.settings().output.noise.maps)?;
    shot.warnings.iter().for_each(|warning| options.monitor.report(Event::Warning(warning)));
    Ok(shot)
}

impl Prepared {
    /// Traces the light of the capture's image, in memory.
    ///
    /// # Errors
    ///
    /// A film that needs more memory than it is given where it cannot be cut into strips; that the monitor stopped it.
    pub fn trace(&self, options: Options<'_>) -> Result<Light> {
        self.trace_light(options).map(|light| self.lit(light))
    }

    /// Light of a film under way, of which [`Event::PassEnds`] tells; `None` where it holds a strip of the image alone.
    /// `trace_s` is the time that tracing has taken.
    ///
    /// # Errors
    ///
    /// Errors of the capture; the film causes none.
    pub fn light_so_far(&self, film: &Film, trace_s: f64) -> Result<Option<Light>> {
        Ok(self.light_of_film(film, trace_s)?.map(|light| self.lit(light)))
    }

    fn lit(&self, light: TracedLight) -> Light {
        Light::new(Origin::Traced(Arc::new(self.clone()), Arc::new(light)))
    }

    /// Columns and rows of the image.
    pub fn resolution(&self) -> [u32; 2] {
        crate::pixels(&self.capture)
    }
}
