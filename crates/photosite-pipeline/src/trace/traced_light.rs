//! Traced light, in memory: the rates at which it frees electrons, and the keys that it leaves open.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::completed_rows::CompletedRows;
use super::trace_job::{Trace, Traced, trace};
use crate::camera::capture_camera::{camera_of, pixels};
use crate::camera::film_responses::IDEAL;
use crate::expose::chain::{CollectedElectrons, Optics, SensorColours, SensorSettings};
use crate::expose::light_reuse::{same_cells, same_times};
use crate::options::Options;
use crate::prepare::prepared::Prepared;
use crate::write::checkpoint::{self, Checkpoints};
use crate::write::output_folder::OutputFolder;
use crate::write::provenance::provenance;
use photosite_capture::report::PlanReport;
use photosite_capture::{Capture, ExposureSettings, SpectralBands};
use photosite_core::image::{Estimate, Planes};
use photosite_core::math::hash::hash64;
use photosite_core::units::Seconds;
use photosite_core::{Error, Invalid, Result};
use photosite_files::light_rows::LightRows;
use photosite_sensor::{Exposure, SensorModel, electron_rates};
use photosite_transport::film::Film;
use photosite_transport::integrator::{COARSE_STEP, RenderSettings, may_plan_light_paths};
use photosite_transport::optics::LensKind;

/// Light that was traced: the rates at which it frees electrons in each pixel.
pub struct TracedLight {
    pub(crate) rows: Arc<LightRows>,
    /// Mean rates of the sensor's channels and their variances, e⁻/s and (e⁻/s)².
    pub rates: Arc<Estimate>,
    /// Samples of each pixel, row by row.
    pub samples: Vec<u32>,
    /// Number of camera paths that were traced.
    pub paths: u64,
    /// Wall-clock seconds that tracing took.
    pub trace_s: f64,
    /// Number of the paths that found how many others are needed.
    pub(crate) pilot_paths: u64,
    /// Plan that tracing followed.
    pub(crate) plan: Option<PlanReport>,
    /// The sensor that the rates are those of, and the exposure in whose time things may move.
    sensor: SensorModel,
    exposure: ExposureSettings,
    /// The bands of the irradiance that is kept.
    bands: Option<SpectralBands>,
    /// Whether the image of an ideal observer is kept.
    pub(crate) has_ideal: bool,
    /// Opening that the light came through, by its [solid angle](photosite_transport::optics::Camera::on_axis_sr).
    on_axis_sr: f64,
}

impl TracedLight {
    /// Irradiance on the sensor in the bands that `output.irradiance` asked for, W·m⁻²·nm⁻¹, a plane for each, named
    /// after its centre in nm; `None` where the capture asked for none.
    pub fn irradiance(&self) -> Option<Planes> {
        self.bands.as_ref()?;
        let names = self.bands();
        self.rows.means(names.iter().map(String::as_str)).to_planes().ok()
    }

    /// Names of the planes of irradiance.
    pub(crate) fn bands(&self) -> Vec<String> {
        let names = |bands: &SpectralBands| (0..bands.count).map(|band| bands.centre_nm(band).to_string()).collect();
        self.bands.as_ref().map_or_else(Vec::new, names)
    }

    /// Facts of tracing, as it leaves them.
    pub(crate) fn traced(&self) -> Traced {
        Traced {
            rows: CompletedRows::Light(Arc::clone(&self.rows), None),
            paths: self.paths - self.pilot_paths,
            pilot_paths: self.pilot_paths,
            plan: self.plan,
            earlier: Duration::ZERO,
        }
    }
}

/// Render settings of the image of that number, where images have light of their own: noise of light that stays in its
/// place from one to the next would pass for a pattern.
pub(crate) fn settings_of_frame(settings: &RenderSettings, frame: u32) -> RenderSettings {
    let seed = if frame == 0 { settings.seed } else { hash64(settings.seed, u64::from(frame)) };
    RenderSettings { seed, ..settings.clone() }
}

/// Error of memory, which does not occur: it takes all that is written, and gives it back.
fn in_memory(reason: std::io::Error) -> Error {
    Error::io("memory".as_ref(), "read", reason)
}

impl Prepared {
    /// Traces the light of the capture's image, in memory.
    pub(crate) fn trace_light(&self, options: Options<'_>) -> Result<TracedLight> {
        let start = Instant::now();
        let camera = self.camera();
        let settings = settings_of_frame(self.capture.render(), self.frame);
        let strips = options.film_memory.strips(&self.capture, self.responses.len(), [true, false])?;
        let traced = Trace {
            prepared: self,
            job: self.job(&self.scene, &camera, &settings),
            strips: &strips,
            is_coarse_first: options.is_coarse_first,
            folder: None,
            monitor: options.monitor,
        };
        let traced = match options.checkpoint {
            None => trace(&traced, None)?,
            Some(path) => self.trace_with_checkpoint(&traced, path)?,
        };
        let Traced { rows, paths, pilot_paths, plan, .. } = traced;
        let CompletedRows::Light(rows, _) = rows else { unreachable!("sums are kept of parts alone") };
        let light = self.light(rows, [paths, pilot_paths], start.elapsed().as_secs_f64())?;
        Ok(TracedLight { plan, ..light })
    }

    /// Light of a film under way; `None` where it holds a strip of the image alone.
    pub(crate) fn light_of_film(&self, film: &Film, trace_s: f64) -> Result<Option<TracedLight>> {
        let [_, height] = pixels(&self.capture).map(|n| n as usize);
        if film.image_rows() != (0..height) {
            return Ok(None);
        }
        let rows = CompletedRows::light(&self.capture, &self.responses, None);
        rows.write(film).map_err(in_memory)?;
        let mut light = self.light(rows, [film.total(), 0], trace_s)?;
        if light.samples.contains(&0) {
            let Estimate { mean, variance } = Arc::make_mut(&mut light.rates);
            [mean, variance].into_iter().for_each(|planes| fill_gaps(planes, &light.samples));
        }
        Ok(Some(light))
    }

    /// Exposes to the light.
    pub(crate) fn expose_light(&self, light: &TracedLight) -> Result<CollectedElectrons> {
        let (rates, warnings) = self.rates(light)?;
        let exposed = self.chain().expose(rates, Seconds(1.0), None)?;
        Ok(CollectedElectrons { warnings: [warnings, exposed.warnings].concat(), ..exposed })
    }

    /// Image of an ideal observer at that exposure, linear in the colour space that the capture develops to; `None`
    /// where the light was traced without it.
    pub(crate) fn ideal(&self, light: &TracedLight, exposure: &Exposure) -> Result<Option<Planes>> {
        if !light.has_ideal {
            return Ok(None);
        }
        let seen = light.rows.means(IDEAL).to_planes().map_err(in_memory)?;
        self.chain().ideal(seen, &self.light, exposure).map(Some)
    }

    /// Ratio of the noise of that light to that of the sensor, over the image. `None` where there is not enough light
    /// for an exposure, and after a single sample.
    pub(crate) fn noise_ratio(&self, light: &TracedLight) -> Option<f64> {
        self.chain().light_noise(&light.rates, light.samples.iter().copied().min().unwrap_or(0))?.ratio
    }

    fn light(&self, rows: Arc<LightRows>, [paths, pilot_paths]: [u64; 2], trace_s: f64) -> Result<TracedLight> {
        let rates = Arc::new(rows.estimate(self.chain().channels()).map_err(in_memory)?);
        let samples = rows.counts().map_err(in_memory)?;
        let (sensor, exposure, output) = (self.capture.sensor(), self.capture.exposure(), self.capture.output());
        Ok(TracedLight {
            rows,
            rates,
            samples,
            paths: paths + pilot_paths,
            trace_s,
            pilot_paths,
            plan: None,
            sensor: sensor.clone(),
            exposure: exposure.clone(),
            bands: output.irradiance,
            has_ideal: output.ideal,
            on_axis_sr: self.camera.on_axis_sr(),
        })
    }

    /// Traces with a checkpoint in a folder, which is that of a render of this capture into it.
    fn trace_with_checkpoint(&self, t: &Trace<'_>, path: &Path) -> Result<Traced> {
        let folder = OutputFolder::claim(path, false)?;
        let provenance = provenance(&self.capture)?;
        let interval = self.capture.output().checkpoint_interval;
        let checkpoints =
            Checkpoints::new(path, folder.is_forced(), None, false, t.job.settings.samples(), &provenance, interval);
        let traced = trace(t, Some(checkpoints))?;
        checkpoint::remove(path)?;
        Ok(traced)
    }

    /// The capture with changes, `key=value`, to what its light leaves open.
    pub(crate) fn for_light(&self, light: &TracedLight, changes: &[String]) -> Result<Self> {
        if changes.is_empty() {
            return Ok(self.clone());
        }
        let capture = self.capture.for_traced_light(changes)?;
        light.check(&capture, self.capture.recording().is_some()).map_err(|invalid| capture.source().error(invalid))?;
        let colours = if capture.sensor() == self.capture.sensor() {
            Arc::clone(&self.colours)
        } else {
            Arc::new(SensorColours::find(SensorSettings::from(&capture), &self.optics, &self.light, None)?)
        };
        // What was said of the sensor and the exposure before holds no more.
        let changed = Self { capture, colours, ..self.clone() };
        Ok(Self { warnings: changed.all_warnings(), ..changed })
    }

    /// Whether light need not be traced anew for another f-number: the opening of a pinhole without a point spread
    /// changes the level of light alone. `plan` is the one that the light was traced by, as far as it is known.
    pub(crate) fn is_f_number_open(&self, plan: Option<&PlanReport>) -> bool {
        let (lens, render) = (self.capture.lens(), self.capture.render());
        let pixels = pixels(&self.capture).map(u64::from).iter().product();
        let has_light_paths = match plan {
            Some(plan) => plan.light_paths > 0.0,
            None => render.light_paths() > 0.0 || may_plan_light_paths(render, &self.scene, &self.camera, pixels),
        };
        lens.kind == LensKind::Pinhole && lens.point_spread.is_none() && !has_light_paths
    }

    /// The capture at another f-number; `None` where light has to be [traced anew](Self::is_f_number_open) for it.
    pub(crate) fn at_f_number(&self, f_number: f64, plan: Option<&PlanReport>) -> Result<Option<Self>> {
        if !self.is_f_number_open(plan) {
            return Ok(None);
        }
        let capture = self.capture.at_f_number(f_number)?;
        let camera = camera_of(capture.lens(), capture.sensor(), self.camera.to_world(), f64::NAN);
        let camera = camera.map_err(|invalid| capture.source().error(invalid.within("lens")))?;
        let optics = Optics { f_number: Some(f_number), ..self.optics.clone() };
        Ok(Some(Self { capture, camera, optics, ..self.clone() }))
    }

    /// The light through the opening of this capture's pinhole, where it was traced through another one.
    pub(crate) fn at_level(&self, light: &Arc<TracedLight>) -> Arc<TracedLight> {
        let factor = self.camera.on_axis_sr() / light.on_axis_sr;
        if factor == 1.0 { Arc::clone(light) } else { Arc::new(light.at_level(factor)) }
    }

    /// The rates at which light frees electrons in this capture's sensor, e⁻/s. Those of another sensor than the light
    /// was traced for come from its irradiance, without a variance, and with warnings about it.
    pub(crate) fn rates(&self, light: &TracedLight) -> Result<(Arc<Estimate>, Vec<String>)> {
        let sensor = self.capture.sensor();
        if light.serves(sensor) {
            return Ok((Arc::clone(&light.rates), Vec::new()));
        }
        let invalid = || Invalid::new("sensor", "sees light in another way than the one that it was traced for");
        let help = "keep the irradiance, which serves any sensor, with output.irradiance = true when light is traced";
        let bands = light.irradiance().ok_or_else(|| self.capture.source().error(invalid().help(help)))?;
        let rates =
            electron_rates(&bands, sensor, &self.light).map_err(|invalid| self.capture.source().error(invalid))?;
        let variance = Planes::zeros::<&str>(bands.width(), bands.height(), []);
        Ok((Arc::new(Estimate { mean: rates.rates, variance }), rates.warnings))
    }
}

/// Gives pixels without a sample the value of the next pixel of a coarse image, to the left and above.
fn fill_gaps(planes: &mut Planes, samples: &[u32]) {
    let width = planes.width();
    for channel in planes.channels_mut() {
        for pixel in (0..samples.len()).filter(|&pixel| samples[pixel] == 0) {
            let [column, row] = [pixel % width, pixel / width].map(|at| at / COARSE_STEP * COARSE_STEP);
            channel.data[pixel] = channel.data[row * width + column];
        }
    }
}

impl TracedLight {
    /// The light times `factor`.
    fn at_level(&self, factor: f64) -> Self {
        let Self { samples, sensor, exposure, .. } = self;
        Self {
            rows: Arc::new(self.rows.at_level(factor as f32)),
            rates: Arc::new(Estimate::clone(&self.rates).scaled(factor)),
            samples: samples.clone(),
            sensor: sensor.clone(),
            exposure: exposure.clone(),
            on_axis_sr: self.on_axis_sr * factor,
            ..*self
        }
    }

    /// Whether this light tells what a sensor sees: as the one that it was traced for, or by its irradiance.
    pub(crate) fn tells_of(&self, sensor: &SensorModel) -> bool {
        self.bands.is_some() || self.serves(sensor)
    }

    /// Whether a sensor sees light as the one does that it was traced for.
    fn serves(&self, sensor: &SensorModel) -> bool {
        self.sensor.cfa.channels() == sensor.cfa.channels() && self.sensor.responses() == sensor.responses()
    }

    /// Refuses a capture that this light does not serve.
    fn check(&self, capture: &Capture, moves: bool) -> Result<(), Invalid> {
        let (sensor, exposure, output) = (capture.sensor(), capture.exposure(), capture.output());
        if sensor.resolution != self.sensor.resolution {
            let [width, height] = self.sensor.resolution;
            let message = format!("the light was traced for {width} × {height} pixels");
            return Err(Invalid::new("sensor.resolution_px", message).help("leave it as it was traced, or trace again"));
        }
        same_times([(&self.sensor, &self.exposure), (sensor, exposure)], moves)?;
        same_cells(&self.sensor, sensor)?;
        if output.irradiance.is_some() && output.irradiance != self.bands {
            let message = "light was traced without these bands";
            return Err(Invalid::new("output.irradiance", message).help("ask for them when light is traced"));
        }
        if output.ideal && !self.has_ideal {
            let message = "light was traced without what an ideal observer sees of it";
            return Err(Invalid::new("output.ideal", message).help("ask for it when light is traced"));
        }
        Ok(())
    }
}
