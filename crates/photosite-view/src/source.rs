//! Inputs of the view: a scene, light, raw images and images of light.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use photosite_capture::report::REPORT;
use photosite_capture::{Capture, FileKind, read_develop_settings};
use photosite_core::{Invalid, Result, Sandbox};
use photosite_dataset::Sheet;
use photosite_develop::{DevelopSettings, EncodedImage};
use photosite_files::developable::{Developable, read_developable};
use photosite_files::formats::{EXR, FORMATS, Format, PNG};
use photosite_pipeline::DevelopedImage;
use photosite_pipeline::{Light, StoredPlanes};
use photosite_transport::integrator::Device;

/// Input of the view.
pub enum Input {
    /// A scene, whose light is traced.
    Scene(Box<Capture>),
    /// Light that a render has stored.
    Light(Light),
    /// A raw file, or an image of light.
    File(OpenFile),
    /// The folder of a data set, whose files must lie where the sandbox allows.
    DataSet(Box<(Sheet, Sandbox)>),
}

/// Open file: a raw file, or an image of light.
pub struct OpenFile {
    path: PathBuf,
    holds: Developable,
    /// Report that says how the file is developed.
    report: Option<PathBuf>,
    beside: StoredPlanes,
}

impl Input {
    /// The capture whose light is traced, if the input is one.
    pub fn traced(&self) -> Option<&Capture> {
        if let Self::Scene(capture) = self { Some(capture) } else { None }
    }

    /// Whether light is exposed, which is traced or was stored.
    pub fn is_exposed(&self) -> bool {
        match self {
            Self::Scene(_) | Self::Light(_) => true,
            Self::File(_) | Self::DataSet(_) => false,
        }
    }

    /// The input, whose light a device traces in place of the processor where it is traced at all.
    #[must_use]
    pub fn on_device(self, device: Option<Arc<dyn Device>>) -> Self {
        match (self, device) {
            (Self::Scene(capture), Some(device)) => Self::Scene(Box::new(capture.on_device(device))),
            (input, _) => input,
        }
    }

    /// Opens a capture file, a scene, a folder that a render or a data set has filled, a file of stored light, a raw
    /// file or an image of light; `overrides` change keys of its capture.
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
            FileKind::PixelValues,
            FileKind::Light,
            FileKind::Image,
        ];
        FileKind::expect(path, &kinds, "a capture file, a scene, a folder of a render or a raw file")?;
        if Sheet::is_in(path) {
            refuse_overrides(path, overrides)?;
            return Ok(Self::DataSet(Box::new((Sheet::read(path)?, sandbox.clone()))));
        }
        if path.is_dir() {
            return Self::open_folder(sandbox, path, overrides);
        }
        match FileKind::of_name(path) {
            Some(FileKind::Light) if Format::of(path) == Some(&EXR) => match Light::read(sandbox, path, overrides) {
                Ok(light) => Ok(Self::Light(light)),
                Err(not_stored) => OpenFile::open(path, None).map_err(|_| not_stored).map(Self::File),
            },
            Some(FileKind::Raw | FileKind::PixelValues | FileKind::Light | FileKind::Image) => {
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

    /// Opens the light of a folder, or without stored light its raw file.
    fn open_folder(sandbox: &Sandbox, path: &Path, overrides: &[String]) -> Result<Self> {
        let has = |name: &str| path.join(name).exists();
        let has_light =
            ["electrons.exr", "irradiance.exr", "electrons-0000.exr", "irradiance-0000.exr"].into_iter().any(has);
        // Those that say most come first.
        let formats = || FORMATS.into_iter().filter(|format| format.writes_raw());
        let formats = formats().filter(|f| f.states_meaning).chain(formats().filter(|f| !f.states_meaning));
        let names = formats.map(|format| format!("raw.{}", format.ending())).chain(["raw-0000.dng".to_owned()]);
        let raw = names.into_iter().find(|name| has(name));
        match raw {
            Some(raw) if !has_light => {
                refuse_overrides(path, overrides)?;
                let report = Some(path.join(REPORT)).filter(|report| report.exists());
                let file = OpenFile::open(&path.join(raw), report)?;
                Ok(Self::File(OpenFile { beside: StoredPlanes::new(path), ..file }))
            }
            Some(_) | None => Ok(Self::Light(Light::read(sandbox, path, overrides)?)),
        }
    }

    /// Kind of the input, for the page.
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
    let message = "has no capture whose keys could be changed";
    match overrides.is_empty() {
        true => Ok(()),
        false => Err(Invalid::new("", message).help("remove --set, and develop it on the page").in_file(path)),
    }
}

impl OpenFile {
    fn open(path: &Path, report: Option<PathBuf>) -> Result<Self> {
        let beside = StoredPlanes::default();
        Ok(Self { path: path.to_owned(), holds: read_developable(path)?, report, beside })
    }

    /// Files beside it in its folder, where that is one of a render.
    pub(super) fn beside(&self) -> &StoredPlanes {
        &self.beside
    }

    /// Contents of the file.
    pub(super) fn holds(&self) -> &Developable {
        &self.holds
    }

    /// Settings of development, with changes to them.
    pub(super) fn settings(&self, changes: &[String]) -> Result<DevelopSettings> {
        read_develop_settings(self.report.as_deref(), changes).map(|(settings, _)| settings)
    }

    /// Develops the file; returns warnings, too.
    pub(super) fn develop(&self, changes: &[String]) -> Result<(EncodedImage, Vec<String>)> {
        let source = read_develop_settings(self.report.as_deref(), changes)?;
        let output = (&PNG, Path::new("the page"));
        let developed = DevelopedImage::develop_file(self.holds.clone(), &self.path, &source, output)?;
        let warnings = developed.assumed.into_iter().chain(developed.warnings).collect();
        Ok((developed.image.encoded(), warnings))
    }
}

/// Light, as far as it is traced; all of it where it is read.
#[derive(Clone)]
pub(super) struct NumberedLight {
    pub(super) light: Light,
    /// Number of the light.
    pub(super) number: u64,
    /// Number of the scene and camera.
    pub(super) trace: u64,
}

/// Source that images are made of now.
#[derive(Clone)]
pub(super) enum ImageSource {
    Light(NumberedLight),
    File(Arc<OpenFile>),
}

impl ImageSource {
    /// Light that stays as it is.
    pub(super) fn of_light(light: Light) -> Self {
        Self::Light(NumberedLight { light, number: 1, trace: 1 })
    }
}
