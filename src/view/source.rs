//! What is viewed: light of a scene, light of files, raw images and pictures.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::beside::Beside;
use super::plane::Plane;
use crate::calibration::truth::TruthLayer;
use crate::capture::{Capture, ExposureSettings, FileKind, read_develop_settings};
use crate::dataset::Sheet;
use crate::develop::{DevelopSettings, EncodedPicture, develop};
use crate::image::Planes;
use crate::io::developable::{Developable, read_developable};
use crate::io::developed::PictureFormat;
use crate::optics::LensKind;
use crate::pipeline::{Carried, ExposedRender, Light, Prepared, Shot, Silent, StoredRender};
use crate::report::REPORT;
use crate::sensor::{Exposure, NoiseMap, SensorModel};
use crate::{Error, Invalid, Picture, Result, Sandbox};

/// What is viewed.
pub enum Input {
    /// A scene, whose light is traced.
    Scene(Box<Capture>),
    /// Light that a render has stored, and what its folder holds beside it.
    Light(Box<StoredRender>, Beside),
    /// A raw file, or a picture of light.
    File(OpenFile),
    /// The folder of a data set, whose files must lie where the sandbox allows.
    DataSet(Box<(Sheet, Sandbox)>),
}

/// A raw file, or a picture of light.
pub struct OpenFile {
    path: PathBuf,
    holds: Developable,
    /// The report that says how it is developed.
    report: Option<PathBuf>,
    beside: Beside,
}

impl Input {
    /// Opens a capture file, a scene, a folder that a render or a data set has filled, a file of stored light, a raw file or a
    /// picture of light; `overrides` change keys of its capture.
    ///
    /// # Errors
    ///
    /// A file of another kind, and what is wrong with the file.
    pub fn open(sandbox: &Sandbox, path: &Path, overrides: &[String]) -> Result<Self> {
        let kinds = [
            FileKind::Capture,
            FileKind::Model,
            FileKind::Report,
            FileKind::Raw,
            FileKind::Numbers,
            FileKind::Light,
            FileKind::Picture,
        ];
        FileKind::expect(path, &kinds, "a capture file, a scene, a folder of a render or a raw file")?;
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if Sheet::is_in(path) {
            refuse_overrides(path, overrides)?;
            return Ok(Self::DataSet(Box::new((Sheet::read(path)?, sandbox.clone()))));
        }
        if path.is_dir() {
            return Self::open_folder(sandbox, path, overrides);
        }
        match FileKind::of_name(path) {
            Some(FileKind::Light) if extension == "exr" => match StoredRender::read(sandbox, path, overrides) {
                Ok(light) => Ok(Self::Light(Box::new(light), Beside::default())),
                Err(not_stored) => OpenFile::open(path, None).map_err(|_| not_stored).map(Self::File),
            },
            Some(FileKind::Raw | FileKind::Numbers | FileKind::Light | FileKind::Picture) => {
                refuse_overrides(path, overrides)?;
                OpenFile::open(path, None).map(Self::File)
            }
            Some(
                FileKind::Capture
                | FileKind::DataSet
                | FileKind::Sensor
                | FileKind::Report
                | FileKind::Model
                | FileKind::Lens,
            )
            | None => Ok(Self::Scene(Box::new(Capture::load_within(sandbox, path, overrides)?))),
        }
    }

    /// Without stored light a folder shows its raw file.
    fn open_folder(sandbox: &Sandbox, path: &Path, overrides: &[String]) -> Result<Self> {
        let has = |name: &&str| path.join(name).exists();
        let has_light =
            ["electrons.exr", "irradiance.exr", "electrons-0000.exr", "irradiance-0000.exr"].iter().any(has);
        let raw =
            ["raw.dng", "raw.exr", "raw.tiff", "raw.npy", "raw.pgm", "raw-0000.dng"].iter().find(|name| has(name));
        match raw {
            Some(raw) if !has_light => {
                refuse_overrides(path, overrides)?;
                let report = Some(path.join(REPORT)).filter(|report| report.exists());
                let file = OpenFile::open(&path.join(raw), report)?;
                Ok(Self::File(OpenFile { beside: Beside::new(path), ..file }))
            }
            Some(_) | None => {
                Ok(Self::Light(Box::new(StoredRender::read(sandbox, path, overrides)?), Beside::new(path)))
            }
        }
    }

    /// What it is, for the page.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Scene(_) => "scene",
            Self::Light(..) => "light",
            Self::File(_) => "file",
            Self::DataSet(_) => "data set",
        }
    }
}

fn refuse_overrides(path: &Path, overrides: &[String]) -> Result<()> {
    let message = "has no capture whose keys could be changed";
    match overrides.is_empty() {
        true => Ok(()),
        false => Err(Invalid::new("", message).help("remove --set, and develop it on the page").in_file(path)),
    }
}

impl OpenFile {
    fn open(path: &Path, report: Option<PathBuf>) -> Result<Self> {
        let beside = Beside::default();
        Ok(Self { path: path.to_owned(), holds: read_developable(path)?, report, beside })
    }

    /// What its folder holds beside it, where that is one of a render.
    pub(super) fn beside(&self) -> &Beside {
        &self.beside
    }

    /// What it holds.
    pub(super) fn holds(&self) -> &Developable {
        &self.holds
    }

    /// Its settings with changes to them.
    pub(super) fn settings(&self, changes: &[String]) -> Result<DevelopSettings> {
        read_develop_settings(self.report.as_deref(), changes).map(|(settings, _)| settings)
    }

    /// Develops it, with what is to be said of that.
    pub(super) fn develop(&self, changes: &[String]) -> Result<(EncodedPicture, Vec<String>)> {
        let source = read_develop_settings(self.report.as_deref(), changes)?;
        let output = (PictureFormat::Png, Path::new("the page"));
        let developed = Picture::develop_file(self.holds.clone(), &self.path, &source, output)?;
        let warnings = developed.assumed.into_iter().chain(developed.warnings).collect();
        Ok((developed.picture.encoded(), warnings))
    }
}

/// Light of a scene, as far as it is traced.
#[derive(Clone)]
pub(super) struct Lit {
    pub(super) prepared: Arc<Prepared>,
    pub(super) light: Arc<Light>,
    /// Counts the lights.
    pub(super) number: u64,
    /// Counts the scenes and cameras.
    pub(super) trace: u64,
}

/// What pictures are made of now.
#[derive(Clone)]
pub(super) enum Source {
    Traced(Lit),
    Stored(Arc<StoredRender>, Beside),
    File(Arc<OpenFile>),
}

/// A sensor that light falls on, ready to be read out.
#[derive(Clone)]
pub(super) enum Ready {
    Traced(Arc<Prepared>, Arc<Light>),
    Stored(Arc<ExposedRender>, Arc<StoredRender>, Beside),
}

impl Ready {
    fn expose_after(&self, frame: u32, before: &Carried, maps: &[NoiseMap]) -> Result<Shot> {
        match self {
            Self::Traced(prepared, light) => prepared.expose_with_maps(light, frame, before, maps),
            Self::Stored(render, ..) => render.read_out(frame, before, maps),
        }
    }

    /// Reads out a frame. Where a frame depends on the ones before it (image lag, gain control), these are read out, too,
    /// if they have seen the same light.
    pub(super) fn expose(&self, frame: u32, maps: &[NoiseMap]) -> Result<Shot> {
        let mut alone = self.expose_after(frame, &Carried::default(), maps)?;
        if self.settings().1.bracket.is_some() {
            let message = "the bracket has no effect here: every frame has the time that exposure states";
            alone.warnings.push(message.to_owned());
        }
        if frame == 0 || alone.carried.is_empty() {
            return Ok(alone);
        }
        if self.has_light_of_one_frame() {
            let message = "earlier frames, whose light is not traced here, leave charge in this sensor or set its gain: \
                           image lag and exposure.gain_control are left out";
            alone.warnings.push(message.to_owned());
            return Ok(alone);
        }
        let mut before = Carried::default();
        for earlier in 0..frame {
            before = self.expose_after(earlier, &before, &[])?.carried;
        }
        let after = self.expose_after(frame, &before, maps)?;
        Ok(Shot { warnings: alone.warnings, ..after })
    }

    /// How shots are developed, with changes to that.
    pub(super) fn develop_settings(&self, changes: &[String]) -> Result<DevelopSettings> {
        match self {
            Self::Traced(prepared, _) if changes.is_empty() => Ok(prepared.capture().develop.clone()),
            Self::Traced(prepared, _) => Ok(prepared.capture().for_traced_light(changes)?.develop),
            Self::Stored(_, stored, _) if changes.is_empty() => Ok(stored.develop_settings().clone()),
            Self::Stored(_, stored, _) => Ok(stored.with(changes)?.develop_settings().clone()),
        }
    }

    /// Develops a shot, as the files of a render are.
    pub(super) fn develop(&self, shot: &Shot, settings: &DevelopSettings) -> Result<EncodedPicture> {
        let in_file = |invalid: Invalid| -> Error {
            match self {
                Self::Traced(prepared, _) => prepared.capture().source.error(invalid.within("develop")),
                Self::Stored(_, stored, _) => stored.error(invalid.within("develop")),
            }
        };
        develop(&shot.raw, settings).map_err(in_file)
    }

    /// Sensor, exposure, and the seed of the noise.
    pub(super) fn settings(&self) -> (&SensorModel, &ExposureSettings, u64) {
        match self {
            Self::Traced(prepared, _) => {
                let Capture { sensor, exposure, render, .. } = prepared.capture();
                (sensor, exposure, render.seed)
            }
            Self::Stored(_, stored, _) => (stored.sensor(), stored.exposure(), stored.seed()),
        }
    }

    /// Whether the light tells what a sensor sees.
    pub(super) fn tells_of(&self, sensor: &SensorModel) -> bool {
        match self {
            Self::Traced(_, light) => light.tells_of(sensor),
            Self::Stored(_, stored, _) => stored.tells_of(sensor),
        }
    }

    /// Whether frames have light of their own, of which that of one is there.
    fn has_light_of_one_frame(&self) -> bool {
        match self {
            Self::Traced(prepared, _) => prepared.capture().recording.is_some(),
            Self::Stored(..) => false,
        }
    }

    /// The f-number of the lens, where it can be changed.
    pub(super) fn f_number(&self) -> Option<f64> {
        match self {
            Self::Traced(prepared, _) => prepared.camera().makes_picture().then_some(prepared.capture().lens.f_number),
            Self::Stored(..) => None,
        }
    }

    /// Noise of light over that of the sensor, where that is known.
    pub(super) fn noise_ratio(&self) -> Option<f64> {
        match self {
            Self::Traced(prepared, light) => prepared.noise_ratio(light),
            Self::Stored(..) => None,
        }
    }

    /// Warnings about sensor, light and settings.
    pub(super) fn warnings(&self) -> &[String] {
        match self {
            Self::Traced(prepared, _) => prepared.warnings(),
            Self::Stored(render, ..) => render.warnings(),
        }
    }

    /// The planes of light and of ground truth that there are of a frame, beside electrons.
    pub(super) fn planes(&self, frame: u32) -> Result<Vec<Plane>> {
        let (prepared, light) = match self {
            Self::Traced(prepared, light) => (prepared, light),
            Self::Stored(_, _, beside) => return beside.planes(frame),
        };
        let ideal = light.has_ideal().then_some(Plane::Ideal);
        let bands = light.bands().into_iter().map(Plane::Irradiance);
        Ok(ideal.into_iter().chain(bands).chain(layers(prepared).into_iter().map(Plane::Truth)).collect())
    }

    /// One of these planes; `None` where it is not there.
    pub(super) fn plane(&self, plane: &Plane, frame: u32, exposure: &Exposure) -> Result<Option<Planes>> {
        match self {
            Self::Stored(_, _, beside) => beside.read(plane, frame),
            Self::Traced(prepared, light) => match plane {
                Plane::Truth(layer) => prepared.truth(&[*layer], &Silent).map(Some),
                Plane::Ideal => prepared.ideal(light, exposure),
                Plane::Irradiance(band) => Ok(light.irradiance().and_then(|bands| alone(bands, band))),
                Plane::Developed | Plane::Raw | Plane::Electrons(_) | Plane::Sigma(_) | Plane::Noise(_) => Ok(None),
            },
        }
    }
}

/// One of several planes.
fn alone(planes: Planes, name: &str) -> Option<Planes> {
    let [width, height] = [planes.width(), planes.height()];
    let channel = planes.into_channels().into_iter().find(|channel| channel.name == name)?;
    Planes::new(width, height, vec![channel]).ok()
}

/// The layers of ground truth that there are of a capture.
fn layers(prepared: &Prepared) -> Vec<TruthLayer> {
    let capture = prepared.capture();
    let has_partner = capture.output.truth.partner.is_some();
    let is_there = |layer: &TruthLayer| match layer {
        TruthLayer::Disparity => has_partner,
        TruthLayer::Flow => capture.recording.is_some(),
        TruthLayer::Depth
        | TruthLayer::Distance
        | TruthLayer::Position
        | TruthLayer::Normal
        | TruthLayer::ShadingNormal
        | TruthLayer::Uv
        | TruthLayer::Albedo
        | TruthLayer::ObjectPosition
        | TruthLayer::Nocs
        | TruthLayer::Instance
        | TruthLayer::Material => true,
    };
    if capture.lens.kind == LensKind::Bare {
        return Vec::new();
    }
    TruthLayer::ALL.into_iter().filter(is_there).collect()
}
