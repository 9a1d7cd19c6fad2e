//! Light on a sensor, traced or read, to be exposed as often as one likes.

mod light_file;
mod read;
mod shots;
mod stored_facts;
mod stored_light;
mod stored_planes;
#[cfg(test)]
mod tests;
mod trace;

use std::path::Path;
use std::sync::Arc;

pub use shots::Shots;
pub use stored_facts::ImageScale;
pub use stored_planes::{LightPlane, StoredPlanes};
pub use trace::render;

use photosite_calibration::truth::{Needs, TruthLayer};
use photosite_capture::relative_path;
use photosite_capture::report::Report;
use photosite_core::Result;
use photosite_core::image::Planes;
use photosite_develop::{DevelopSettings, EncodedImage};
use photosite_raw::RawImage;
use photosite_sensor::{Exposure, SensorModel};
use photosite_transport::optics::LensKind;

use super::expose::chain::{Chain, CollectedElectrons, SensorSettings};
use super::expose::frame_series::Carried;
use super::expose::sensor_card::SensorCard;
use super::expose::shot::Shot;
use super::monitor::{Monitor, Silent};
use super::prepare::prepared::Prepared;
use super::prepare::strips::FilmMemory;
use super::render::image_report::Taken;
use super::render::render_into::Rendered;
use super::render::request::{Given, LightSource, Request};
use super::trace::traced_light::TracedLight;
use super::write::output_folder::OutputFolder;
use light_file::LightFile;
use stored_light::StoredLight;

/// Light on a sensor that is ready to be exposed: traced in a scene, stored by a render, or computed by another
/// program.
#[derive(Clone)]
pub struct Light {
    origin: Origin,
    /// Card that exposes and develops; `None` for the processor.
    card: Option<Arc<SensorCard>>,
}

/// Sensor and light, by what is known of where the light comes from.
#[derive(Clone)]
enum Origin {
    Traced(Arc<Prepared>, Arc<TracedLight>),
    Stored(Arc<StoredLight>, LightFile),
}

impl Light {
    fn new(origin: Origin) -> Self {
        Self { origin, card: None }
    }

    fn chain(&self) -> Chain<'_> {
        let chain = match &self.origin {
            Origin::Traced(prepared, _) => prepared.chain(),
            Origin::Stored(stored, _) => stored.chain(),
        };
        chain.on(self.card.as_deref())
    }

    /// The light, to which a card exposes its sensor. What the card does not have, the processor does, as the warnings
    /// of an exposure say.
    #[must_use]
    pub fn on_card(self, card: Option<Arc<SensorCard>>) -> Self {
        Self { card, ..self }
    }

    /// Develops a raw image of this light for display, on its card if that has all of the settings.
    ///
    /// # Errors
    ///
    /// Settings that do not fit the image; a card that fails.
    pub fn develop(&self, raw: &RawImage, settings: &DevelopSettings) -> Result<EncodedImage> {
        Ok(self.chain().develop_with(raw, settings)?.0)
    }

    /// Sensor, exposure, output, development, and the seed of the sensor's noise.
    pub fn settings(&self) -> SensorSettings<'_> {
        self.chain().settings
    }

    /// The light with changes, `key=value`, to what it leaves open: keys of sensor, exposure, development and output,
    /// and the seed of the sensor's noise. A sensor that sees light in another way needs the irradiance, which is read
    /// where a folder holds it.
    ///
    /// # Errors
    ///
    /// A key that light transport has used; a value that cannot be used; a sensor or a time that this light does not
    /// serve; output that it does not hold.
    pub fn with(&self, changes: &[String]) -> Result<Self> {
        if changes.is_empty() {
            return Ok(self.clone());
        }
        let origin = match &self.origin {
            Origin::Traced(prepared, light) => {
                Origin::Traced(Arc::new(prepared.for_light(light, changes)?), Arc::clone(light))
            }
            Origin::Stored(stored, light) => match stored.facts.with(light, changes)? {
                Some(facts) => Origin::Stored(Arc::new(StoredLight::new(facts, Some(&**stored))?), light.clone()),
                None => {
                    let overrides = [&stored.facts.overrides[..], changes].concat();
                    let sandbox = stored.facts.capture.source.sandbox();
                    return Ok(Self::read(sandbox, &stored.facts.input, &overrides)?.on_card(self.card.clone()));
                }
            },
        };
        Ok(Self { origin, card: self.card.clone() })
    }

    /// The light through the lens at another f-number; `None` where it [has to be traced anew](Self::f_number_is_open).
    ///
    /// # Errors
    ///
    /// A number that no lens has.
    pub fn at_f_number(&self, f_number: f64) -> Result<Option<Self>> {
        let Origin::Traced(prepared, light) = &self.origin else { return Ok(None) };
        let changed = prepared.at_f_number(f_number, light.plan.as_ref())?;
        Ok(changed.map(|changed| {
            let origin = Origin::Traced(Arc::new(changed), Arc::clone(light));
            Self { origin, card: self.card.clone() }
        }))
    }

    /// Whether the opening of the lens changes the level of this light alone, as that of a pinhole does.
    pub fn f_number_is_open(&self) -> bool {
        matches!(&self.origin, Origin::Traced(prepared, light) if prepared.is_f_number_open(light.plan.as_ref()))
    }

    /// The settings of this light with the light of a later pass of the same trace.
    #[must_use]
    pub fn lit_as(&self, later: &Self) -> Self {
        let mut lit = self.clone();
        if let (Origin::Traced(_, light), Origin::Traced(_, later)) = (&mut lit.origin, &later.origin) {
            light.clone_from(later);
        }
        lit
    }

    /// Whether this light tells what a sensor sees: as the one that it was traced for, or by its irradiance.
    pub fn tells_of(&self, sensor: &SensorModel) -> bool {
        match &self.origin {
            Origin::Traced(_, light) => light.tells_of(sensor),
            Origin::Stored(stored, light) => stored.facts.tells_of(light, sensor),
        }
    }

    /// Warnings about light, sensor and settings, each once; those about an exposure come with [shots](Shot::warnings).
    pub fn warnings(&self) -> &[String] {
        match &self.origin {
            Origin::Traced(prepared, _) => prepared.warnings(),
            Origin::Stored(stored, _) => &stored.warnings,
        }
    }

    /// Changes to keys, `key=value`, that the light was read or traced with.
    pub fn overrides(&self) -> &[String] {
        match &self.origin {
            Origin::Traced(prepared, _) => prepared.capture.overrides(),
            Origin::Stored(stored, _) => &stored.facts.overrides,
        }
    }

    /// Tables of its capture file, as [`Capture::to_table`](photosite_capture::Capture::to_table) has them.
    ///
    /// # Errors
    ///
    /// Errors of [`Capture::to_table`](photosite_capture::Capture::to_table).
    pub fn to_table(&self) -> Result<toml::Table> {
        match &self.origin {
            Origin::Traced(prepared, _) => prepared.capture.to_table(),
            Origin::Stored(stored, _) => stored.facts.capture.to_table(),
        }
    }

    /// The capture with the scene that it was traced in; `None` of light that was read.
    pub fn prepared(&self) -> Option<&Prepared> {
        match &self.origin {
            Origin::Traced(prepared, _) => Some(prepared),
            Origin::Stored(..) => None,
        }
    }

    /// Traced light, through the opening that the lens has now; `None` of light that was read.
    pub fn traced(&self) -> Option<Arc<TracedLight>> {
        match &self.origin {
            Origin::Traced(prepared, light) => Some(prepared.at_level(light)),
            Origin::Stored(..) => None,
        }
    }

    /// The f-number of the lens, where light is traced through one that has it.
    pub fn f_number(&self) -> Option<f64> {
        let prepared = self.prepared()?;
        prepared.camera().makes_image().then_some(prepared.capture.lens().f_number)
    }

    /// Number of the only frame whose light this is, where things move and the other frames have light of their own.
    pub fn only_frame(&self) -> Option<u32> {
        let prepared = self.prepared()?;
        prepared.capture.recording().is_some().then_some(prepared.frame)
    }

    /// Ratio of the noise of light transport to that of the sensor over the image, where it is known: not after a
    /// single sample, and where there is not enough light for an exposure.
    pub fn noise_ratio(&self) -> Option<f64> {
        self.prepared()?.noise_ratio(&*self.traced()?)
    }

    /// Planes that there are of a frame, beside electrons.
    ///
    /// # Errors
    ///
    /// A file that cannot be read.
    pub fn planes(&self, frame: u32) -> Result<Vec<LightPlane>> {
        match &self.origin {
            Origin::Traced(prepared, light) => {
                let ideal = light.has_ideal.then_some(LightPlane::Ideal);
                let bands = light.bands().into_iter().map(LightPlane::Irradiance);
                Ok(ideal.into_iter().chain(bands).chain(layers(prepared).map(LightPlane::Truth)).collect())
            }
            Origin::Stored(stored, _) => StoredPlanes::of_input(&stored.facts.input).planes(frame),
        }
    }

    /// Planes of one kind; `None` where the light does not have them. The ideal image is that of an exposure.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, truth that cannot be found.
    pub fn plane(&self, plane: &LightPlane, frame: u32, exposure: &Exposure) -> Result<Option<Planes>> {
        let (prepared, light) = match &self.origin {
            Origin::Traced(prepared, light) => (prepared, prepared.at_level(light)),
            Origin::Stored(stored, _) => return StoredPlanes::of_input(&stored.facts.input).read(plane, frame),
        };
        match plane {
            LightPlane::Truth(layer) => prepared.truth(&[*layer], &Silent).map(Some),
            LightPlane::Ideal => prepared.ideal(&light, exposure),
            LightPlane::Irradiance(band) => {
                Ok(light.irradiance().and_then(|bands| stored_planes::some(bands, &[band])))
            }
        }
    }

    /// Frames that have light of their own; `None` where all see the same.
    fn own_lights(&self) -> Option<u32> {
        match &self.origin {
            Origin::Traced(..) => None,
            Origin::Stored(stored, _) => stored.own_lights(),
        }
    }

    /// Exposes to the light of the frame of that number.
    fn expose_for(&self, number: u32) -> Result<CollectedElectrons> {
        match &self.origin {
            Origin::Traced(prepared, light) => prepared.expose_light(&prepared.at_level(light)),
            Origin::Stored(stored, light) => {
                stored.check_memory()?;
                let own = stored.own_light(number)?;
                stored.expose(own.unwrap_or_else(|| light.clone()))
            }
        }
    }

    /// Report of a shot in memory: there are no files.
    ///
    /// # Errors
    ///
    /// Values of the capture that cannot be written.
    pub fn report(&self, shot: &Shot) -> Result<Report> {
        let mut report = match &self.origin {
            Origin::Traced(prepared, light) => prepared.report(&prepared.at_level(light), shot)?,
            Origin::Stored(stored, _) => {
                stored.report(&Taken::of(shot), stored.warnings_and(&shot.warnings), Path::new("."))?
            }
        };
        report.exposure.device.clone_from(&shot.device);
        // Of a bracket it is one time.
        report.exposure.bracket_s = None;
        Ok(report)
    }

    /// Reads out and develops into a folder as many frames as its capture asks for, the report last, which is returned.
    ///
    /// # Errors
    ///
    /// An exposure that the sensor cannot make, or for which there is too little light; that it takes more memory than
    /// there is; a folder that cannot be written.
    pub fn write_into(self, folder: &mut OutputFolder, monitor: &dyn Monitor) -> Result<Report> {
        self.write(None, folder, monitor)
    }

    /// Reads out a shot again, and writes it into a folder as [`write_into`](Self::write_into) does; of a bracket all.
    ///
    /// # Errors
    ///
    /// Errors of [`write_into`](Self::write_into).
    pub fn write_shot_into(&self, shot: &Shot, folder: &mut OutputFolder, monitor: &dyn Monitor) -> Result<Report> {
        let one = self.settings().exposure.bracket.is_none().then(|| (shot.frame, shot.before.clone()));
        self.clone().write(Some(one.unwrap_or_default()), folder, monitor)
    }

    fn write(self, one: Option<(u32, Carried)>, folder: &mut OutputFolder, monitor: &dyn Monitor) -> Result<Report> {
        match self.origin {
            Origin::Traced(prepared, light) => {
                let input = prepared.capture.source().path();
                let (light, frame) = (&prepared.at_level(&light), one.unwrap_or_default());
                let given = Given { light, frame, card: self.card.as_deref() };
                let request = Request {
                    input,
                    named: relative_path(input, folder.path()),
                    light: LightSource::Given(given),
                    film_memory: FilmMemory::default(),
                    monitor,
                    is_timed: true,
                };
                match prepared.expose_into(&request, folder)? {
                    Rendered::Image { report, .. } => Ok(*report),
                    Rendered::Part(_) => unreachable!("no part was asked for"),
                }
            }
            Origin::Stored(stored, light) => stored.write_into(light, one, folder, (monitor, self.card.as_deref())),
        }
    }
}

/// Layers of ground truth that there are of a capture.
fn layers(prepared: &Prepared) -> impl Iterator<Item = TruthLayer> {
    let capture = &prepared.capture;
    let [has_camera, has_partner, moves] = [
        capture.lens().kind != LensKind::Bare,
        capture.output().truth.partner.is_some(),
        capture.recording().is_some(),
    ];
    let is_there = move |layer: &TruthLayer| match layer.needs() {
        Needs::Partner => has_partner,
        Needs::NextImage => moves,
        Needs::Surface => true,
    };
    TruthLayer::ALL.into_iter().filter(move |layer| has_camera && is_there(layer))
}
