//! What the folder of a render holds beside its light: ground truth, irradiance, the picture of an ideal observer.

use std::path::{Path, PathBuf};

use super::plane::Plane;
use crate::calibration::truth::TruthLayer;
use crate::image::{Channel, Planes};
use crate::io::exr::{channel_names, read_exr_file};
use crate::io::spectral_exr::{band_of_channel, irradiance};
use crate::{Invalid, Result};

/// The folder of a render; without one there is nothing.
#[derive(Clone, Debug, Default)]
pub struct Beside(Option<PathBuf>);

/// Files that hold planes.
const TRUTH: &str = "truth";
const IRRADIANCE: &str = "irradiance";
const IDEAL: &str = "ideal";
/// Channels of a picture in the order in which people name them.
const ORDER: [&str; 6] = ["R", "G", "B", "X", "Y", "Z"];

impl Beside {
    pub(super) fn new(folder: &Path) -> Self {
        Self(Some(folder.to_owned()))
    }

    /// A file of a frame: that of its number where frames have files of their own.
    fn path(&self, stem: &str, frame: u32) -> Option<PathBuf> {
        let folder = self.0.as_ref()?;
        [format!("{stem}-{frame:04}.exr"), format!("{stem}.exr")]
            .iter()
            .map(|name| folder.join(name))
            .find(|path| path.is_file())
    }

    /// The planes that there are of a frame.
    ///
    /// # Errors
    ///
    /// A file that cannot be read.
    pub(super) fn planes(&self, frame: u32) -> Result<Vec<Plane>> {
        let names = |stem| self.path(stem, frame).map_or(Ok(Vec::new()), |path| channel_names(&path));
        let ideal = self.path(IDEAL, frame).map(|_| Plane::Ideal);
        let mut bands: Vec<f64> = names(IRRADIANCE)?.iter().filter_map(|name| band_of_channel(name)).collect();
        bands.sort_by(f64::total_cmp);
        let bands = bands.into_iter().map(|band| Plane::Irradiance(band.to_string()));
        let known = names(TRUTH)?;
        let has = |layer: &TruthLayer| layer.channels().iter().all(|name| known.iter().any(|known| known == name));
        let layers = TruthLayer::ALL.into_iter().filter(has).map(Plane::Truth);
        Ok(ideal.into_iter().chain(bands).chain(layers).collect())
    }

    /// A plane of a frame, if there is such a one.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or holds something else.
    pub(super) fn read(&self, plane: &Plane, frame: u32) -> Result<Option<Planes>> {
        let read = |stem| self.path(stem, frame).map(|path| Ok((read_exr_file(&path)?, path))).transpose();
        match plane {
            Plane::Truth(layer) => Ok(read(TRUTH)?.and_then(|(picture, _)| some(picture.planes, layer.channels()))),
            Plane::Ideal => Ok(read(IDEAL)?.and_then(|(picture, _)| {
                let has = |name: &&&str| picture.planes.plane(name).is_some();
                let names: Vec<&str> = ORDER.iter().filter(has).copied().collect();
                some(picture.planes, &names)
            })),
            Plane::Irradiance(band) => {
                let Some((picture, path)) = read(IRRADIANCE)? else { return Ok(None) };
                let bands = irradiance(picture).map_err(|invalid: Invalid| invalid.in_file(&path))?;
                Ok(some(bands, &[band]))
            }
            Plane::Developed | Plane::Raw | Plane::Electrons(_) | Plane::Sigma(_) | Plane::Noise(_) => Ok(None),
        }
    }
}

/// Some planes in that order; `None` where one of them is missing.
fn some(planes: Planes, names: &[&str]) -> Option<Planes> {
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
    use crate::io::exr::write_exr;

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
        let beside = Beside::new(folder.path());
        let [depth, normal] = [TruthLayer::Depth, TruthLayer::Normal].map(Plane::Truth);
        // Half of flow is none.
        assert_eq!(beside.planes(1).expect("read"), [Plane::Ideal, depth.clone(), normal.clone()]);
        assert_eq!(beside.planes(0).expect("read"), [Plane::Ideal, depth.clone()]);
        let first = |plane: &Plane, frame| {
            let planes = beside.read(plane, frame).expect("read").expect("there");
            planes.channels().iter().map(|channel| channel.data[0]).collect::<Vec<_>>()
        };
        assert_eq!([first(&depth, 1), first(&depth, 0)], [[3.0], [4.0]]);
        assert_eq!([first(&normal, 1), first(&Plane::Ideal, 0)], [[1.0, 2.0, 3.0]; 2]);
        assert_eq!(beside.read(&normal, 0).expect("read"), None);
        assert!(Beside::default().planes(0).expect("nothing").is_empty());
    }
}
