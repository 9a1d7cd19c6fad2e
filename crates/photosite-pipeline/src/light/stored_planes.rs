//! Planes beside electrons: ground truth, irradiance, the image of an ideal observer; as the folder of a render holds
//! them.

use std::path::{Path, PathBuf};

use photosite_calibration::truth::TruthLayer;
use photosite_core::image::{Channel, Planes};
use photosite_core::{Invalid, Result};
use photosite_files::exr::{channel_names, read_exr_file};
use photosite_files::spectral_exr::{band_of_channel, irradiance};

/// Plane of light or of ground truth, beside the electrons of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum LightPlane {
    /// Irradiance in the band around this many nm.
    Irradiance(String),
    /// Image of an observer with the eyes of the CIE.
    Ideal,
    /// Layer of ground truth.
    Truth(TruthLayer),
}

/// Folder of a render, which holds planes; without one there are none.
#[derive(Clone, Debug, Default)]
pub struct StoredPlanes(Option<PathBuf>);

/// Files that hold planes.
const TRUTH: &str = "truth";
const IRRADIANCE: &str = "irradiance";
const IDEAL: &str = "ideal";
/// Channels of an image in the order in which people name them.
const ORDER: [&str; 6] = ["R", "G", "B", "X", "Y", "Z"];

impl StoredPlanes {
    /// Planes in that folder, or none where the input is a file.
    pub(crate) fn of_input(input: &Path) -> Self {
        Self(input.is_dir().then(|| input.to_owned()))
    }

    /// Planes in a folder.
    pub fn new(folder: &Path) -> Self {
        Self(Some(folder.to_owned()))
    }

    /// Path of a file of a frame: that of its number where frames have files of their own.
    fn path(&self, stem: &str, frame: u32) -> Option<PathBuf> {
        let folder = self.0.as_ref()?;
        [format!("{stem}-{frame:04}.exr"), format!("{stem}.exr")]
            .iter()
            .map(|name| folder.join(name))
            .find(|path| path.is_file())
    }

    /// Planes that the folder holds of a frame.
    ///
    /// # Errors
    ///
    /// A file that cannot be read.
    pub fn planes(&self, frame: u32) -> Result<Vec<LightPlane>> {
        let names = |stem| self.path(stem, frame).map_or(Ok(Vec::new()), |path| channel_names(&path));
        let ideal = self.path(IDEAL, frame).map(|_| LightPlane::Ideal);
        let mut bands: Vec<f64> = names(IRRADIANCE)?.iter().filter_map(|name| band_of_channel(name)).collect();
        bands.sort_by(f64::total_cmp);
        let bands = bands.into_iter().map(|band| LightPlane::Irradiance(band.to_string()));
        let known = names(TRUTH)?;
        let has = |layer: &TruthLayer| layer.channels().iter().all(|name| known.iter().any(|known| known == name));
        let layers = TruthLayer::ALL.into_iter().filter(has).map(LightPlane::Truth);
        Ok(ideal.into_iter().chain(bands).chain(layers).collect())
    }

    /// Plane of a frame, if the folder holds it.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or holds something else.
    pub fn read(&self, plane: &LightPlane, frame: u32) -> Result<Option<Planes>> {
        let read = |stem| self.path(stem, frame).map(|path| Ok((read_exr_file(&path)?, path))).transpose();
        match plane {
            LightPlane::Truth(layer) => Ok(read(TRUTH)?.and_then(|(image, _)| some(image.planes, layer.channels()))),
            LightPlane::Ideal => Ok(read(IDEAL)?.and_then(|(image, _)| {
                let has = |name: &&&str| image.planes.plane(name).is_some();
                let names: Vec<&str> = ORDER.iter().filter(has).copied().collect();
                some(image.planes, &names)
            })),
            LightPlane::Irradiance(band) => {
                let Some((image, path)) = read(IRRADIANCE)? else { return Ok(None) };
                let bands = irradiance(image).map_err(|invalid: Invalid| invalid.in_file(&path))?;
                Ok(some(bands, &[band]))
            }
        }
    }
}

/// Planes of these names in that order; `None` where one of them is missing.
pub(crate) fn some(planes: Planes, names: &[&str]) -> Option<Planes> {
    let [width, height] = [planes.width(), planes.height()];
    let mut all: Vec<Channel> = planes.into_channels();
    let take = |name: &&str| {
        let place = all.iter().position(|channel| channel.name == **name)?;
        Some(all.swap_remove(place))
    };
    let channels: Vec<Channel> = names.iter().map(take).collect::<Option<_>>()?;
    Planes::new(width, height, channels).ok()
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;
    use photosite_files::exr::write_exr;

    #[test]
    fn planes_of_files_are_found_and_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let channel = |name: &str, value: f32| Channel { name: name.to_owned(), data: vec![value; 2] };
        let write = |name: &str, channels: Vec<Channel>| {
            let planes = Planes::new(2, 1, channels).expect("planes");
            write_exr(&planes, &[], File::create(folder.path().join(name)).expect("a file")).expect("written");
        };
        let normal = TruthLayer::Normal.channels();
        let mut truth = vec![channel("depth", 3.0), channel(TruthLayer::Flow.channels()[0], 1.0)];
        truth.extend(normal.iter().zip(1_u8..).map(|(name, value)| channel(name, f32::from(value))));
        write("truth-0001.exr", truth);
        write("truth.exr", vec![channel("depth", 4.0)]);
        write("ideal.exr", vec![channel("R", 1.0), channel("G", 2.0), channel("B", 3.0)]);
        let beside = StoredPlanes::new(folder.path());
        let [depth, normal] = [TruthLayer::Depth, TruthLayer::Normal].map(LightPlane::Truth);
        // Half of flow is none.
        assert_eq!(beside.planes(1).expect("read"), [LightPlane::Ideal, depth.clone(), normal.clone()]);
        assert_eq!(beside.planes(0).expect("read"), [LightPlane::Ideal, depth.clone()]);
        let first = |plane: &LightPlane, frame| {
            let planes = beside.read(plane, frame).expect("read").expect("there");
            planes.channels().iter().map(|channel| channel.data[0]).collect::<Vec<_>>()
        };
        assert_eq!([first(&depth, 1), first(&depth, 0)], [[3.0], [4.0]]);
        assert_eq!([first(&normal, 1), first(&LightPlane::Ideal, 0)], [[1.0, 2.0, 3.0]; 2]);
        assert_eq!(beside.read(&normal, 0).expect("read"), None);
        assert!(StoredPlanes::default().planes(0).expect("nothing").is_empty());
    }
}
