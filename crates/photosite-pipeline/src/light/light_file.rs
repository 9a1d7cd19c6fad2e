//! Light that a render has stored: electrons of one sensor, or irradiance for any.

use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use photosite_capture::StoredCapture;
use photosite_core::image::{Estimate, Planes};
use photosite_core::units::Seconds;
use photosite_core::{Error, Invalid, Result};
use photosite_core::{Help, Remedy, input};
use photosite_files::electrons::electrons;
use photosite_files::exr::read_exr;
use photosite_files::formats::{Format, Holds};
use photosite_files::spectral_exr::irradiance;

/// Light read from a file. Its planes are shared by all that is made of it.
#[derive(Clone)]
pub(crate) enum LightFile {
    /// Mean electrons of the sensor's channels, collected within a time.
    Electrons { electrons: Arc<Estimate>, collected: Seconds },
    /// Irradiance in spectral bands, W·m⁻²·nm⁻¹.
    Irradiance { path: PathBuf, bands: Arc<Planes> },
}

impl LightFile {
    /// Reads an EXR file, which says itself what it holds.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let at = |invalid: Invalid| invalid.in_file(path);
        let file = input::open(path).map_err(|reason| Error::io(path, "read", reason))?;
        let image = read_exr(BufReader::new(file)).map_err(|invalid| {
            let says_nothing = Invalid::new("", "does not say what its pixel values are on the sensor");
            at(if is_image(path) { says_nothing.help(Remedy::LightUnit) } else { invalid })
        })?;
        if image.text("spectralLayoutVersion").is_some() {
            let bands = Arc::new(image.whole().and_then(irradiance).map_err(at)?);
            return Ok(Self::Irradiance { path: path.to_owned(), bands });
        }
        if image.text("unit").is_some() {
            let (electrons, collected) = image.whole().and_then(electrons).map_err(at)?;
            return Ok(Self::Electrons { electrons: Arc::new(electrons), collected });
        }
        let invalid = Invalid::new("", "holds neither electrons nor spectral irradiance on a sensor");
        let own = "give an electrons.exr or irradiance.exr that photosite render wrote".to_owned();
        Err(at(invalid.help(Help::any([Remedy::Say(own), Remedy::LightUnit]))))
    }

    fn planes(&self) -> &Planes {
        match self {
            Self::Electrons { electrons, .. } => &electrons.mean,
            Self::Irradiance { bands, .. } => bands,
        }
    }

    /// Columns and rows.
    pub(crate) fn resolution(&self) -> [usize; 2] {
        [self.planes().width(), self.planes().height()]
    }

    /// Refuses a sensor that this light does not serve.
    pub(crate) fn check(&self, capture: &StoredCapture) -> Result<()> {
        let (sensor, at) = (&capture.sensor, |invalid: Invalid| capture.source.error(invalid.within("sensor")));
        let [width, height] = self.resolution();
        if sensor.resolution != [width, height] {
            let [columns, rows] = sensor.resolution;
            let message = format!("the stored light has {width} × {height} pixels, not {columns} × {rows}");
            return Err(at(Invalid::new("resolution_px", message).help("leave it as it was rendered")));
        }
        let Self::Electrons { electrons, .. } = self else { return Ok(()) };
        match sensor.cfa.channels().iter().find(|name| electrons.mean.plane(name).is_none()) {
            None => Ok(()),
            Some(name) => {
                let held: Vec<&str> = electrons.mean.channels().iter().map(|c| c.name.as_str()).collect();
                let message =
                    format!("has a channel {name}, but the stored electrons are those of {}", held.join(", "));
                let help =
                    "electrons serve the sensor that they were counted for; give irradiance.exr, which serves any";
                Err(at(Invalid::new("cfa", message).help(help)))
            }
        }
    }
}

/// Whether a file is an image of a kind that states no units.
fn is_image(path: &Path) -> bool {
    let is_silent = |format: &Format| format.reads_images() && matches!(format.holds, Holds::Codes | Holds::Arrays);
    Format::of(path).is_some_and(is_silent)
}
