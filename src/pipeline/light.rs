//! Light in memory: traced once, to be exposed as often as one likes.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::camera::{camera_of, pixels};
use super::chain::{Optics, SensorColours, Settings};
use super::checkpoint::{self, Checkpoints};
use super::completed_rows::CompletedRows;
use super::ideal;
use super::options::Options;
use super::output_folder::OutputFolder;
use super::prepare::Prepared;
use super::provenance::provenance;
use super::same_light::{same_cells, same_times};
use super::trace::{Trace, Traced, trace};
use crate::capture::{Capture, ExposureSettings, SpectralBands};
use crate::film::Film;
use crate::image::{Estimate, Planes};
use crate::integrator::{COARSE_STEP, RenderSettings};
use crate::io::light_rows::LightRows;
use crate::math::hash::hash64;
use crate::optics::LensKind;
use crate::sensor::{Exposure, SensorModel, electron_rates};
use crate::{Error, Invalid, Result};

/// Light that was traced: the rates at which it frees electrons in each pixel.
pub struct Light {
    pub(super) rows: Arc<LightRows>,
    /// Mean rates of the sensor's channels and their variances, e⁻/s and (e⁻/s)².
    pub rates: Arc<Estimate>,
    /// Samples of each pixel, row by row.
    pub samples: Vec<u32>,
    /// Camera paths that were traced.
    pub paths: u64,
    /// Wall-clock seconds that it took.
    pub trace_s: f64,
    /// Of the paths, those that found how many others are needed.
    pilot_paths: u64,
    /// The sensor that the rates are those of, and the exposure in whose time things may move.
    sensor: SensorModel,
    exposure: ExposureSettings,
    /// The bands of the irradiance that is kept.
    bands: Option<SpectralBands>,
    /// Whether the picture of an ideal observer is kept.
    has_ideal: bool,
    /// The [solid angle](crate::optics::Camera::on_axis_sr) of the opening that it came through.
    on_axis_sr: f64,
}

impl Light {
    /// Irradiance on the sensor in the bands that `output.irradiance` asked for, W·m⁻²·nm⁻¹, a plane for each, named
    /// after its centre in nm; `None` where the capture asked for none.
    pub fn irradiance(&self) -> Option<Planes> {
        self.bands.as_ref()?;
        let names = self.bands();
        self.rows.means(names.iter().map(String::as_str)).to_planes().ok()
    }

    /// The names of these planes.
    pub fn bands(&self) -> Vec<String> {
        self.bands
            .as_ref()
            .map_or_else(Vec::new, |bands| (0..bands.count).map(|band| bands.centre_nm(band).to_string()).collect())
    }

    /// Whether the picture of an ideal observer is kept.
    pub fn has_ideal(&self) -> bool {
        self.has_ideal
    }

    pub(super) fn pilot_paths(&self) -> u64 {
        self.pilot_paths
    }

    /// As tracing leaves it.
    pub(super) fn traced(&self) -> Traced {
        Traced {
            rows: CompletedRows::Light(Arc::clone(&self.rows), None),
            paths: self.paths - self.pilot_paths,
            pilot_paths: self.pilot_paths,
            earlier: Duration::ZERO,
        }
    }
}

/// Render settings of the picture of that number, where pictures have light of their own: noise of light that stays in
/// its place from one to the next would pass for a pattern.
pub(super) fn settings_of_frame(settings: &RenderSettings, frame: u32) -> RenderSettings {
    let seed = if frame == 0 { settings.seed } else { hash64(settings.seed, u64::from(frame)) };
    RenderSettings { seed, ..settings.clone() }
}

/// Memory takes what it is given, and gives it back.
fn in_memory(reason: std::io::Error) -> Error {
    Error::io("memory".as_ref(), "read", reason)
}

impl Prepared {
    /// Traces the light of its picture, in memory.
    ///
    /// # Errors
    ///
    /// A film that needs more memory than it is given where it cannot be cut into strips; that the monitor stopped it.
    pub fn trace(&self, options: Options<'_>) -> Result<Light> {
        let start = Instant::now();
        let camera = self.camera();
        let chain = self.chain();
        let settings = settings_of_frame(&self.capture.render, self.frame);
        let strips = options.film_memory.strips(&self.capture, self.responses.len(), [true, false])?;
        let traced = Trace {
            capture: &self.capture,
            settings: &settings,
            scene: &self.scene,
            camera: &camera,
            responses: &self.responses,
            filters: self.filters.as_ref(),
            importance: Some(&self.importance_for_all),
            strips: &strips,
            is_part: false,
            is_coarse_first: options.is_coarse_first,
            chain: &chain,
            folder: None,
            monitor: options.monitor,
        };
        let traced = match options.checkpoint {
            None => trace(&traced, None)?,
            Some(path) => self.trace_with_checkpoint(&traced, path)?,
        };
        let Traced { rows, paths, pilot_paths, .. } = traced;
        let CompletedRows::Light(rows, _) = rows else { unreachable!("sums are kept of parts alone") };
        self.light(rows, [paths, pilot_paths], start.elapsed().as_secs_f64())
    }

    /// The light of a film under way, of which [`Event::PassEnds`](super::Event::PassEnds) tells; `None` where it holds
    /// a strip of the picture alone. `trace_s` is the time that it has taken.
    ///
    /// # Errors
    ///
    /// None that the film causes.
    pub fn light_so_far(&self, film: &Film, trace_s: f64) -> Result<Option<Light>> {
        let [_, height] = pixels(&self.capture).map(|n| n as usize);
        if film.picture_rows() != (0..height) {
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

    /// The picture of an ideal observer at that exposure, linear in the colour space that the capture develops to;
    /// `None` where the light was traced without it.
    ///
    /// # Errors
    ///
    /// A sensor whose white is none.
    pub fn ideal(&self, light: &Light, exposure: &Exposure) -> Result<Option<Planes>> {
        if !light.has_ideal {
            return Ok(None);
        }
        let seen = light.rows.means(ideal::NAMES).to_planes().map_err(in_memory)?;
        let picture = ideal::picture(seen, &self.capture, &self.light, exposure)?;
        Ok(Some(match self.chain().ideal_resampling() {
            Some(resampling) => resampling.apply(picture),
            None => picture,
        }))
    }

    /// Ratio of the noise of that light to that of the sensor, over the picture. `None` where there is not enough light
    /// for an exposure, and after a single sample.
    pub fn noise_ratio(&self, light: &Light) -> Option<f64> {
        self.chain().noise_ratio(&light.rates, light.samples.iter().copied().min().unwrap_or(0))
    }

    fn light(&self, rows: Arc<LightRows>, [paths, pilot_paths]: [u64; 2], trace_s: f64) -> Result<Light> {
        let rates = Arc::new(rows.estimate(self.chain().channels()).map_err(in_memory)?);
        let samples = rows.counts().map_err(in_memory)?;
        let Capture { sensor, exposure, output, .. } = &self.capture;
        Ok(Light {
            rows,
            rates,
            samples,
            paths: paths + pilot_paths,
            trace_s,
            pilot_paths,
            sensor: sensor.clone(),
            exposure: exposure.clone(),
            bands: output.irradiance,
            has_ideal: output.ideal,
            on_axis_sr: self.camera.on_axis_sr(),
        })
    }

    /// Traces with a checkpoint in a folder, which is that of a render of this capture into it.
    fn trace_with_checkpoint(&self, job: &Trace<'_>, path: &Path) -> Result<Traced> {
        let folder = OutputFolder::claim(path, false)?;
        let provenance = provenance(&self.capture)?;
        let interval = self.capture.output.checkpoint_interval;
        let checkpoints =
            Checkpoints::new(path, folder.is_forced(), None, false, job.settings.samples(), &provenance, interval);
        let traced = trace(job, Some(checkpoints))?;
        checkpoint::remove(path)?;
        Ok(traced)
    }

    /// This capture with changes, `key=value`, to what light leaves open once it is traced: keys of sensor, exposure,
    /// development and output, and the seed of the sensor's noise. A sensor that sees light differently needs light
    /// whose irradiance is kept.
    ///
    /// # Errors
    ///
    /// A key that light transport has used; a value that cannot be used; a sensor or a time that this light does not
    /// serve; output that it does not hold.
    pub fn for_light(&self, light: &Light, changes: &[String]) -> Result<Self> {
        if changes.is_empty() {
            return Ok(self.clone());
        }
        let capture = self.capture.for_traced_light(changes)?;
        light.check(&capture, self.capture.recording.is_some()).map_err(|invalid| capture.source.error(invalid))?;
        let colours = SensorColours::find(Settings::from(&capture), &self.optics, &self.light, None)?;
        // What was said of the sensor and the exposure before holds no more.
        let changed = Self { capture, colours: Arc::new(colours), ..self.clone() };
        Ok(Self { warnings: changed.all_warnings(), ..changed })
    }

    /// Whether light need not be traced anew for another f-number: the opening of a pinhole without a point spread changes
    /// the level of light alone.
    pub fn is_f_number_open(&self) -> bool {
        let Capture { lens, render, .. } = &self.capture;
        lens.kind == LensKind::Pinhole && lens.point_spread.is_none() && render.light_paths == 0.0
    }

    /// This capture at another f-number; `None` where light has to be [traced anew](Self::is_f_number_open) for it.
    ///
    /// # Errors
    ///
    /// A number that no lens has.
    pub fn at_f_number(&self, f_number: f64) -> Result<Option<Self>> {
        if !self.is_f_number_open() {
            return Ok(None);
        }
        let capture = self.capture.at_f_number(f_number)?;
        let camera = camera_of(&capture.lens, &capture.sensor, self.camera.to_world(), f64::NAN);
        let camera = camera.map_err(|invalid| capture.source.error(invalid.within("lens")))?;
        let optics = Optics { f_number: Some(f_number), ..self.optics.clone() };
        Ok(Some(Self { capture, camera, optics, ..self.clone() }))
    }

    /// That light through the opening of this capture's pinhole, where it was traced through another one.
    #[must_use]
    pub fn at_level(&self, light: &Arc<Light>) -> Arc<Light> {
        let factor = self.camera.on_axis_sr() / light.on_axis_sr;
        if factor == 1.0 { Arc::clone(light) } else { Arc::new(light.at_level(factor)) }
    }

    /// The rates at which light frees electrons in this capture's sensor, e⁻/s. Those of another sensor than the light
    /// was traced for come from its irradiance, without a variance, and with warnings about it.
    pub(super) fn rates(&self, light: &Light) -> Result<(Arc<Estimate>, Vec<String>)> {
        let sensor = &self.capture.sensor;
        if light.serves(sensor) {
            return Ok((Arc::clone(&light.rates), Vec::new()));
        }
        let invalid = || Invalid::new("sensor", "sees light in another way than the one that it was traced for");
        let help = "keep the irradiance, which serves any sensor, with output.irradiance = true when light is traced";
        let bands = light.irradiance().ok_or_else(|| self.capture.source.error(invalid().help(help)))?;
        let rates =
            electron_rates(&bands, sensor, &self.light).map_err(|invalid| self.capture.source.error(invalid))?;
        let variance = Planes::zeros::<&str>(bands.width(), bands.height(), []);
        Ok((Arc::new(Estimate { mean: rates.rates, variance }), rates.warnings))
    }
}

/// Gives pixels without a sample what the pixel of a coarse picture shows that is next to them, to the left and above.
fn fill_gaps(planes: &mut Planes, samples: &[u32]) {
    let width = planes.width();
    for channel in planes.channels_mut() {
        for pixel in (0..samples.len()).filter(|&pixel| samples[pixel] == 0) {
            let [column, row] = [pixel % width, pixel / width].map(|at| at / COARSE_STEP * COARSE_STEP);
            channel.data[pixel] = channel.data[row * width + column];
        }
    }
}

impl Light {
    /// So many times as much light.
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

    /// Whether it tells what a sensor sees: as the one that it was traced for, or by its irradiance.
    pub fn tells_of(&self, sensor: &SensorModel) -> bool {
        self.bands.is_some() || self.serves(sensor)
    }

    /// Whether a sensor sees light as the one does that it was traced for.
    fn serves(&self, sensor: &SensorModel) -> bool {
        self.sensor.cfa.channels() == sensor.cfa.channels() && self.sensor.responses() == sensor.responses()
    }

    /// Refuses a capture that this light does not serve.
    fn check(&self, capture: &Capture, moves: bool) -> Result<(), Invalid> {
        let Capture { sensor, exposure, output, .. } = capture;
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
