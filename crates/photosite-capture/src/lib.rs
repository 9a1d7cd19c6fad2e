//! The capture file: a scene, the camera that looks at it and what to make of it, as TOML.
//!
//! In: the path of a capture file, or of a scene file (`.gltf`, `.glb`, `.obj`, `.ply`, `.stl`) that stands for a
//! capture of defaults, and overrides, `key=value`. Out: a [`Capture`], everything checked and in SI units. Every error
//! names the file, the key and its line, or the argument.
//!
//! | folder | holds |
//! |---|---|
//! | `tree/` | values that know their lines, laid over each other, and read into Rust types |
//! | `tables/` | the tables of keys, their JSON Schema, and the kinds of files that hold them |
//! | `scene/` | the meaning of `[scene]`, `[[lights]]`, `[[targets]]`, `[materials.NAME]` |
//! | `camera/` | the meaning of `[camera]`, `[lens]`: pose, optics |
//! | `settings/` | the meaning of `[sensor]`, `[exposure]`, `[render]`, `[develop]`, `[output]` |
//! | `files/` | files that stand for a capture, and captures made ready to be saved |
//!
//! The keys are documented where they are declared, in `tables/`; [`capture_schema`] makes a JSON Schema of that.
//! Rendering is left to others.

#![forbid(unsafe_code)]

mod access;
mod camera;
mod device;
mod files;
pub mod keys;
pub mod report;
mod scene;
mod schema_links;
mod settings;
mod tables;
mod tree;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Weak};

use glam::DAffine3;

use photosite_calibration::targets::PlacedTarget;
use photosite_core::Sandbox;
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result};
use photosite_develop::DevelopSettings;
use photosite_sensor::SensorModel;
use photosite_transport::integrator::{Device, RenderSettings};
use photosite_transport::optics::{LensDescription, LensKind, Recording};
use photosite_transport::scene::description::SceneDescription;

use camera::calibration::Calibrated;
use camera::pose::place_camera;
pub use files::init::{InitialCapture, initial_capture};
use files::input::{focus_on_scene, is_scene_file, read_source};
use files::relocate::keys_of;
pub use files::relocate::{real_path, relative_path, typed_change};
use keys::CaptureKeys;
pub use scene::extent::{Extent, FileUnit, subject};
use scene::geometry::ReadScene;
use scene::models::KnownModels;
use scene::moments::Moments;
use scene::targets::place_targets;
use scene::{extent, moments, motion, surroundings};
use settings::sensor::sensor_model;
use settings::{develop, exposure, output};
use tables::CaptureFile;
use tables::spectra::Finder;
use tree::overrides;

pub use files::dataset::DatasetFile;
pub use files::stored::StoredCapture;
pub use files::stored_report::StoredReport;
pub use files::synthetic_noise::read_synthetic_noise;
pub use scene::surroundings::GROUND;
pub use scene::targets::read_target;
pub use settings::develop::read_develop_settings;
pub use settings::exposure::{Bracket, ExposureSettings, ExposureTime};
pub use settings::output::{FlowTarget, NoiseOutput, OutputSettings, SpectralBands, TruthOutput};
pub use settings::sensor::{NamedSensor, read_named_sensor, read_sensor_file};
pub use tables::RawFormat;
pub use tables::file_kind::FileKind;
pub use tables::schema::{capture_schema, dataset_schema, noise_schema, sensor_schema};
pub use tree::source::CaptureSource;

/// Everything that a capture file, the files it names and the command line say.
///
/// Values of a capture are read by the methods of their names, and changed by [`with`](Self::with), which reads the
/// capture anew: what reports say of a render and what was rendered are the same.
///
/// ```no_run
/// use photosite_capture::{Capture, keys::LensKeys};
///
/// # fn main() -> photosite_core::Result<()> {
/// let capture = Capture::load("scenes/cornell-box/capture.toml")?;
/// let faster = capture.with(&Capture::builder().lens(LensKeys::new().f_number(2.0)))?;
/// assert_eq!(faster.lens().f_number, 2.0);
/// # Ok(())
/// # }
/// ```
///
/// ```compile_fail,E0616
/// let mut capture = photosite_capture::Capture::load("scenes/cornell-box/capture.toml").unwrap();
/// capture.lens.f_number = 2.0; // `capture.json` would state another f-number
/// ```
#[derive(Clone, Debug)]
pub struct Capture {
    /// The scene in front of the camera. Captures that differ in other tables alone share it.
    pub(crate) scene: Arc<SceneDescription>,
    /// Calibration targets in the scene.
    pub(crate) targets: Vec<PlacedTarget>,
    /// Camera → world; the camera looks along −Z.
    pub(crate) camera_to_world: DAffine3,
    /// Calibration that the camera has.
    pub(crate) calibrated: Option<Calibrated>,
    /// Recording of an image in whose time camera or scene move; `None` where all stands still.
    pub(crate) recording: Option<Recording>,
    /// Whether the scene is that of one image only, so that others need [`Capture::at_frame`].
    pub(crate) scene_moves: bool,
    /// The lens.
    pub(crate) lens: LensDescription,
    /// The sensor.
    pub(crate) sensor: SensorModel,
    /// Settings of the exposure.
    pub(crate) exposure: ExposureSettings,
    /// Settings of light transport.
    pub(crate) render: RenderSettings,
    /// Settings of the development of the raw image.
    pub(crate) develop: DevelopSettings,
    /// Settings of the files to write.
    pub(crate) output: OutputSettings,
    /// Things worth telling the user of camera and lens that are no errors, each once.
    pub(crate) warnings: Vec<String>,
    /// Warnings about keys that the sensor was made of, and which its values no longer show.
    pub(crate) sensor_warnings: Vec<String>,
    /// Warnings about the values of sensor and exposure.
    pub(crate) exposure_warnings: Vec<String>,
    /// Source of all values, for errors that show up later.
    pub(crate) source: CaptureSource,
    /// Tables that the scene was read from, and the scene itself as long as somebody holds it; `None` where no tables
    /// state it.
    known_scene: Option<(TablesOfScene, Weak<SceneDescription>)>,
    /// Contents of the files of geometry that its scene or those of related captures were made of.
    models: KnownModels,
    /// Origin to be read again with changes; `None` where no file and no values hold its scene.
    origin: Option<Origin>,
    /// Device that traces its light; `None` for the processor.
    device: Option<Arc<dyn Device>>,
}

/// Origin of a capture: the source and overrides that it is read from.
#[derive(Clone, Debug)]
struct Origin {
    /// Source as it was before overrides.
    source: CaptureSource,
    /// The file, whose kind says what it holds and whose folder is what paths are relative to.
    path: PathBuf,
    overrides: Vec<String>,
    /// Whether it is of a data set, which keeps no electrons unless they are asked for: they are most of a frame's
    /// bytes.
    is_of_set: bool,
}

/// Tables that decide what a scene is, as long as the files stay that they name.
#[derive(Clone, Debug, PartialEq)]
struct TablesOfScene {
    tables: [Option<serde_json::Value>; 4],
    moments: Moments,
}

impl TablesOfScene {
    fn of(source: &CaptureSource, moments: Moments) -> Result<Self> {
        let [scene, targets, lights, materials] = ["scene", "targets", "lights", "materials"];
        let tables = [source.read(scene)?, source.read(targets)?, source.read(lights)?, source.read(materials)?];
        Ok(Self { tables, moments })
    }
}

impl Capture {
    /// Loads a capture file (`.toml`), a report of one that was rendered (`capture.json`) or a scene file (`.gltf`,
    /// `.glb`, `.obj`, `.ply`, `.stl`), which stands for a capture of defaults.
    ///
    /// # Errors
    ///
    /// Whatever is wrong with the file or one that it names, with key and line, and what to write instead.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        Self::load_with(path.as_ref(), &[])
    }

    /// Loads a capture with changes to its keys laid over it, `key=value` as in `exposure.time_s=0.02`.
    pub fn load_with(path: &Path, overrides: &[String]) -> Result<Self> {
        Self::load_within(&Sandbox::default(), path, overrides)
    }

    /// Loads a capture with changes, of which all files that it names, and that these name, must lie in a sandbox. The
    /// capture itself may lie anywhere.
    pub fn load_within(sandbox: &Sandbox, path: &Path, overrides: &[String]) -> Result<Self> {
        Self::of_origin(Origin::new(read_source(path)?.within(sandbox), path, overrides), 0, None)
    }

    /// Loads a capture for a data set, which keeps no mean electrons unless they are asked for.
    pub fn load_for_set(sandbox: &Sandbox, path: &Path, overrides: &[String]) -> Result<Self> {
        let origin = Origin::new(read_source(path)?.within(sandbox), path, overrides);
        Self::of_origin(Origin { is_of_set: true, ..origin }, 0, None)
    }

    /// A capture from the text of a capture file, which names files relative to `folder`.
    pub fn parse(text: &str, folder: &Path, overrides: &[String]) -> Result<Self> {
        let path = folder.join("capture.toml");
        Self::of_origin(Origin::new(CaptureSource::parse(&path, text.to_owned())?, &path, overrides), 0, None)
    }

    /// A capture from the values of a capture file, by the names of its tables. `path` stands for the file in messages,
    /// and its folder is what paths are relative to.
    ///
    /// # Errors
    ///
    /// Errors of [`load`](Self::load), without lines.
    pub fn of_values(values: &serde_json::Value, path: &Path, overrides: &[String]) -> Result<Self> {
        Self::of_origin(Origin::new(CaptureSource::of_values(path, values)?, path, overrides), 0, None)
    }

    /// The capture with more changes to its keys, read anew from its origin. Where they leave the scene as it is, it is
    /// shared; otherwise files that it names are read as they now are.
    pub fn with(&self, overrides: &[String]) -> Result<Self> {
        self.with_all(&[self.overrides(), overrides].concat())
    }

    /// The capture with these changes to its keys in place of its own, as [`with`](Self::with) has it.
    pub fn with_all(&self, overrides: &[String]) -> Result<Self> {
        let origin = Origin { overrides: overrides.to_vec(), ..self.origin()?.clone() };
        Self::of_origin(origin, 0, Some(self))
    }

    /// The capture for the image of that number of its series, in whose time an animated scene has gone on.
    pub fn at_frame(&self, frame: u32) -> Result<Self> {
        Self::of_origin(self.origin()?.clone(), frame, Some(self))
    }

    /// Things worth telling the user that are no errors, each once.
    pub fn warnings(&self) -> Vec<String> {
        [&*self.light_warnings(), &*self.sensor_warnings, &*self.exposure_warnings].concat()
    }

    /// Warnings that hold for its light, whatever that falls on.
    pub fn light_warnings(&self) -> Vec<String> {
        [&*self.scene.warnings, &*self.warnings].concat()
    }

    /// The units of the files of its geometry.
    pub fn units(&self) -> Result<Vec<FileUnit>> {
        extent::units(&self.source)
    }

    /// Tells where the scene is so large that its unit is hardly the metre.
    pub fn unit_warning(&self) -> Option<String> {
        extent::unit_warning(&self.scene, &self.source)
    }

    /// Takes the scene out; its files still tell what results are made of.
    pub fn take_scene(&mut self) -> Arc<SceneDescription> {
        self.models = KnownModels::default();
        let left = SceneDescription { files: self.scene.files.clone(), ..SceneDescription::default() };
        std::mem::replace(&mut self.scene, Arc::new(left))
    }

    fn origin(&self) -> Result<&Origin> {
        let none = || Invalid::new("", "its scene is not in a file from which it could be read again");
        self.origin.as_ref().ok_or_else(|| self.source.error(none()))
    }

    /// The value of a key such as `scene.ground.height_m`, as it was given.
    pub fn value(&self, key: &str) -> Result<Option<serde_json::Value>> {
        self.source.read(key)
    }

    /// The changes to keys that it was read with, `key=value`.
    pub fn overrides(&self) -> &[String] {
        self.origin.as_ref().map_or(&[], |origin| &origin.overrides)
    }

    /// Keys of a capture, none yet: for one that no file holds, or for changes to one that is loaded.
    pub fn builder() -> CaptureKeys {
        CaptureKeys::new()
    }

    /// A capture of a scene that no file holds; `keys` are all but its geometry. Names of materials and of cameras in
    /// them are those of the scene.
    pub fn of_scene(scene: SceneDescription, keys: &CaptureKeys) -> Result<Self> {
        let folder = Path::new("");
        let mut source = CaptureSource::empty(Path::new("capture.toml"));
        keys.iter().try_for_each(|change| overrides::set(&mut source, change))?;
        let file = CaptureFile::read(&mut source, folder)?;
        if !file.scene.geometry.is_empty() {
            let invalid = Invalid::new("scene.geometry", "cannot be combined with a scene that is given");
            return Err(source.error(invalid.help("remove it, or load the capture file")));
        }
        let (scene, targets) = Self::describe(&file, ReadScene::of_description(scene), &source, folder)?;
        Self::assemble(&file, scene, targets, &source, folder, 0).map_err(|invalid| source.error(invalid))
    }

    /// Reads a capture, with the scene of `earlier` if it is the same.
    fn of_origin(origin: Origin, frame: u32, earlier: Option<&Self>) -> Result<Self> {
        let (path, mut source) = (&*origin.path, origin.source.clone());
        for argument in &origin.overrides {
            overrides::set(&mut source, argument)?;
        }
        if is_scene_file(path) {
            focus_on_scene(&mut source);
        }
        if origin.is_of_set {
            source.set_default("output", "electrons", &false.into());
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut file = CaptureFile::read(&mut source, folder)?;
        let moments = Moments::of(&file, frame, source.sandbox()).map_err(|invalid| source.error(invalid))?;
        let tables = TablesOfScene::of(&source, moments)?;
        let models = match earlier {
            Some(earlier) => earlier.models.clone(),
            None if origin.is_of_set => KnownModels::kept(),
            None => KnownModels::default(),
        };
        let device = earlier.and_then(|earlier| earlier.device.clone());
        // A scene file gets its surroundings from what it holds.
        let earlier = earlier.filter(|_| !is_scene_file(path));
        let (scene, targets) = match earlier.and_then(|earlier| Some((earlier.scene_of(&tables)?, &earlier.targets))) {
            Some((scene, targets)) => (scene, targets.clone()),
            None => {
                let mut geometry = ReadScene::of_capture(&source, &file, &tables.moments, folder, &models)?;
                if is_scene_file(path) {
                    geometry.scene.warnings.extend(extent::unit_warning(&geometry.scene, &source));
                    geometry.surround(&mut source)?;
                    file.scene = source.read("scene")?.unwrap_or_default();
                    file.exposure = source.read("exposure")?.unwrap_or_default();
                }
                Self::describe(&file, geometry, &source, folder)?
            }
        };
        let read = Self::assemble(&file, scene, targets, &source, folder, frame);
        let read = read.map_err(|invalid| source.error(invalid))?;
        let known_scene = Some((tables, Arc::downgrade(&read.scene)));
        Ok(Self { origin: Some(origin), known_scene, models, device, ..read })
    }

    /// The scene, if these tables are what it was read from.
    fn scene_of(&self, tables: &TablesOfScene) -> Option<Arc<SceneDescription>> {
        let (_, scene) = self.known_scene.as_ref().filter(|(known, _)| known == tables)?;
        scene.upgrade()
    }

    /// Lays the tables of the capture over the geometry that its files hold.
    fn describe(
        file: &CaptureFile,
        mut geometry: ReadScene,
        source: &CaptureSource,
        folder: &Path,
    ) -> Result<(Arc<SceneDescription>, Vec<PlacedTarget>)> {
        let described = || -> Result<_, Invalid> {
            let targets = place_targets(&file.targets)?;
            geometry.add_quadrics(&file.scene, &file.materials)?;
            geometry.add_targets(&targets)?;
            surroundings::add(&mut geometry, file, folder, source.sandbox())?;
            let scene = geometry.with_tables(file, folder, source.sandbox())?;
            Ok((Arc::new(scene), targets))
        };
        described().map_err(|invalid| source.error(invalid))
    }

    /// Values of all keys that were given: the capture file, the sensor's preset under it and overrides over it. They
    /// stand for themselves: the sensor is whole and names no preset. Paths become relative to `folder`, where this is
    /// going to be kept.
    pub fn to_json(&self, folder: &Path) -> Result<serde_json::Value> {
        keys_of(&self.source, &self.sensor.name, Some(folder))
    }

    /// Assembles a capture from its tables.
    fn assemble(
        file: &CaptureFile,
        scene: Arc<SceneDescription>,
        targets: Vec<PlacedTarget>,
        source: &CaptureSource,
        folder: &Path,
        frame: u32,
    ) -> Result<Self, Invalid> {
        let finder = Finder::new(folder, source.sandbox(), Vec::new());
        let sensor = sensor_model(&file.sensor, source.sandbox()).map_err(|invalid| invalid.within("sensor"))?;
        let motion = motion::of_camera(&file.camera).map_err(|e| e.within("motion").within("camera"))?;
        let mut warnings = Warnings::default();
        let exposure = exposure::exposure(&file.exposure, &sensor).map_err(|invalid| invalid.within("exposure"))?;
        let read_out = sensor.read_out_grid(&exposure.region, exposure.stages);
        let calibrated = Calibrated::of(&finder, (&file.camera, &file.lens), &sensor, &read_out, &mut warnings)?;
        let seen = (&sensor, calibrated.as_ref());
        let (camera_to_world, lens) = place_camera(file, motion.as_ref(), &finder, &scene, seen, &mut warnings)?;
        let scene_mover = file.scene.mover();
        let scene_moves = scene_mover.is_some();
        let moves = motion.is_some() || scene_moves;
        let mover = match (&motion, &scene_mover) {
            (None, Some(mover)) => mover,
            (Some(_), _) | (None, None) => "camera.motion",
        };
        if moves && exposure.bracket.is_some() {
            let key = if file.exposure.bracket_ev.is_some() { "bracket_ev" } else { "bracket_times_s" };
            let invalid =
                Invalid::new(key, "cannot be combined with a camera or a scene that moves, as the images differ");
            return Err(invalid.help(format!("remove it, or {mover}")).within("exposure"));
        }
        let recording = moves.then(|| moments::recording(mover, motion, &exposure, &sensor)).transpose()?;
        let recording = recording.map(|recording| recording.later(frame)).map(|recording| {
            let of_file = motion::motion_of_file(&file.camera, &scene.cameras, &recording);
            Recording { motion: recording.motion.clone().or(of_file), ..recording }
        });
        let output = output::output(&file.output, &sensor).map_err(|invalid| invalid.within("output"))?;
        if output.truth.next != FlowTarget::OfSeries && exposure.frames != 1 {
            let invalid =
                Invalid::new("truth_next", "cannot be combined with exposure.frames: images of a series are the next");
            return Err(invalid.help("remove it, or exposure.frames").within("output"));
        }
        let render = file.render.clone();
        render.validate().map_err(|invalid| invalid.within("render"))?;
        if moves && render.light_paths() > 0.0 {
            let invalid = Invalid::new("light_paths", "cannot be combined with a camera or a scene that moves");
            return Err(invalid.help(format!("remove it, or {mover}")).within("render"));
        }
        if lens.kind == LensKind::Bare {
            let needs_lens = [
                ("output", "truth", !output.truth.layers.is_empty()),
                ("output", "objects", output.objects),
                ("render", "light_paths", render.light_paths() > 0.0),
            ];
            if let Some((table, key, _)) = needs_lens.into_iter().find(|(_, _, is_set)| *is_set) {
                let message =
                    "cannot be combined with lens.type = \"none\": each pixel of a bare sensor sees everything";
                return Err(Invalid::new(key, message).help("remove it, or use a lens").within(table));
            }
        }
        if sensor.shutter.scans() && render.light_paths() > 0.0 {
            let invalid = Invalid::new("light_paths", "cannot be combined with a sensor that scans line by line");
            return Err(invalid.help("remove it, or sensor.shutter").within("render"));
        }
        let of_values = sensor.warnings().into_iter().chain(exposure.warning());
        let exposure_warnings = source.displaced().iter().cloned().chain(of_values).collect();
        Ok(Self {
            recording,
            scene_moves,
            exposure,
            render,
            develop: develop::checked(&file.develop)?,
            output,
            scene,
            targets,
            camera_to_world,
            calibrated,
            lens,
            sensor,
            warnings: warnings.into_messages(),
            sensor_warnings: file.sensor.warnings.clone(),
            exposure_warnings,
            source: source.clone(),
            known_scene: None,
            models: KnownModels::default(),
            origin: None,
            device: None,
        })
    }
}

impl CaptureKeys {
    /// The capture that has these keys, which name files relative to `folder`.
    ///
    /// # Errors
    ///
    /// Errors of [`Capture::load`], with the key in place of a line.
    pub fn build(&self, folder: &Path) -> Result<Capture> {
        Capture::parse("", folder, self)
    }
}

impl Origin {
    fn new(source: CaptureSource, path: &Path, overrides: &[String]) -> Self {
        Self { source, path: path.to_owned(), overrides: overrides.to_vec(), is_of_set: false }
    }
}
