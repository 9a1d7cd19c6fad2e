//! What is viewed: light of a scene, light of files, raw images and pictures.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::calibration::truth::TruthLayer;
use crate::capture::{Capture, ExposureSettings, FileKind, read_develop_settings};
use crate::dataset::Sheet;
use crate::develop::{DevelopSettings, EncodedPicture, develop};
use crate::image::Planes;
use crate::io::developable::{Developable, read_developable};
use crate::io::developed::PictureFormat;
use crate::optics::LensKind;
use crate::pipeline::{ExposedRender, Light, Prepared, Shot, StoredRender};
use crate::report::REPORT;
use crate::sensor::{Exposure, LeftCharge, NoiseMap, SensorModel};
use crate::{Error, Invalid, Picture, Result, Sandbox};

/// What is viewed.
pub enum Input {
    /// A scene, whose light is traced.
    Scene(Box<Capture>),
    /// Light that a render has stored.
    Light(Box<StoredRender>),
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
                Ok(light) => Ok(Self::Light(Box::new(light))),
                Err(not_stored) => OpenFile::open(path, None).map_err(|_| not_stored).map(Self::File),
            },
            Some(FileKind::Raw | FileKind::Numbers | FileKind::Light | FileKind::Picture) => {
                refuse_overrides(path, overrides)?;
                OpenFile::open(path, None).map(Self::File)
            }
            Some(FileKind::Capture | FileKind::DataSet | FileKind::Sensor | FileKind::Report | FileKind::Model)
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
                OpenFile::open(&path.join(raw), report).map(Self::File)
            }
            Some(_) | None => Ok(Self::Light(Box::new(StoredRender::read(sandbox, path, overrides)?))),
        }
    }

    /// What it is, for the page.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Scene(_) => "scene",
            Self::Light(_) => "light",
            Self::File(_) => "file",
            Self::DataSet(_) => "data set",
        }
    }
}

fn refuse_overrides(path: &Path, overrides: &[String]) -> Result<()> {
    let message = "has no capture, of which keys could be changed";
    match overrides.is_empty() {
        true => Ok(()),
        false => Err(Invalid::new("", message).help("remove --set, and develop it on the page").in_file(path)),
    }
}

impl OpenFile {
    fn open(path: &Path, report: Option<PathBuf>) -> Result<Self> {
        Ok(Self { path: path.to_owned(), holds: read_developable(path)?, report })
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
    Stored(Arc<StoredRender>),
    File(Arc<OpenFile>),
}

/// A sensor that light falls on, ready to be read out.
#[derive(Clone)]
pub(super) enum Ready {
    Traced(Arc<Prepared>, Arc<Light>),
    Stored(Arc<ExposedRender>, Arc<StoredRender>),
}

impl Ready {
    fn expose_after(&self, frame: u32, before: Option<LeftCharge>, maps: &[NoiseMap]) -> Result<Shot> {
        match self {
            Self::Traced(prepared, light) => prepared.expose_with_maps(light, frame, before, maps),
            Self::Stored(render, _) => render.read_out(frame, before, maps),
        }
    }

    /// Reads out a frame. Of a sensor that keeps charge from one frame to the next, all frames before it are read out,
    /// too.
    pub(super) fn expose(&self, frame: u32, maps: &[NoiseMap]) -> Result<Shot> {
        let alone = self.expose_after(frame, None, maps)?;
        if frame == 0 || alone.left.is_none() {
            return Ok(alone);
        }
        let mut before = None;
        for earlier in 0..frame {
            before = self.expose_after(earlier, before, &[])?.left;
        }
        self.expose_after(frame, before, maps)
    }

    /// How shots are developed, with changes to that.
    pub(super) fn develop_settings(&self, changes: &[String]) -> Result<DevelopSettings> {
        match self {
            Self::Traced(prepared, _) if changes.is_empty() => Ok(prepared.capture().develop.clone()),
            Self::Traced(prepared, _) => Ok(prepared.capture().for_traced_light(changes)?.develop),
            Self::Stored(_, stored) if changes.is_empty() => Ok(stored.develop_settings().clone()),
            Self::Stored(_, stored) => Ok(stored.with(changes)?.develop_settings().clone()),
        }
    }

    /// Develops a shot, as the files of a render are.
    pub(super) fn develop(&self, shot: &Shot, settings: &DevelopSettings) -> Result<EncodedPicture> {
        let in_file = |invalid: Invalid| -> Error {
            match self {
                Self::Traced(prepared, _) => prepared.capture().source.error(invalid.within("develop")),
                Self::Stored(_, stored) => stored.error(invalid.within("develop")),
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
            Self::Stored(_, stored) => (stored.sensor(), stored.exposure(), stored.seed()),
        }
    }

    /// Whether the light tells what a sensor sees.
    pub(super) fn tells_of(&self, sensor: &SensorModel) -> bool {
        match self {
            Self::Traced(_, light) => light.tells_of(sensor),
            Self::Stored(_, stored) => stored.tells_of(sensor),
        }
    }

    /// Whether frames have light of their own, of which that of the first is traced alone.
    pub(super) fn has_first_frame_alone(&self) -> bool {
        match self {
            Self::Traced(prepared, _) => prepared.capture().recording.is_some(),
            Self::Stored(..) => false,
        }
    }

    /// Warnings about sensor, light and settings.
    pub(super) fn warnings(&self) -> &[String] {
        match self {
            Self::Traced(prepared, _) => prepared.warnings(),
            Self::Stored(render, _) => render.warnings(),
        }
    }

    /// Irradiance in bands, where it is kept.
    pub(super) fn irradiance(&self) -> Option<Planes> {
        match self {
            Self::Traced(_, light) => light.irradiance(),
            Self::Stored(..) => None,
        }
    }

    /// The names of these bands.
    pub(super) fn bands(&self) -> Vec<String> {
        match self {
            Self::Traced(_, light) => light.bands(),
            Self::Stored(..) => Vec::new(),
        }
    }

    /// Whether the picture of an ideal observer is kept.
    pub(super) fn has_ideal(&self) -> bool {
        match self {
            Self::Traced(_, light) => light.has_ideal(),
            Self::Stored(..) => false,
        }
    }

    /// The picture of an ideal observer, where it is kept.
    pub(super) fn ideal(&self, exposure: &Exposure) -> Result<Option<Planes>> {
        match self {
            Self::Traced(prepared, light) => prepared.ideal(light, exposure),
            Self::Stored(..) => Ok(None),
        }
    }

    /// The layers of ground truth that there are.
    pub(super) fn layers(&self) -> Vec<TruthLayer> {
        let Self::Traced(prepared, _) = self else { return Vec::new() };
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

    /// A layer of ground truth.
    pub(super) fn truth(&self, layer: TruthLayer) -> Result<Option<Planes>> {
        match self {
            Self::Traced(prepared, _) => prepared.truth(&[layer]).map(Some),
            Self::Stored(..) => Ok(None),
        }
    }
}
