//! Finished data sets in the folders and files that other tools read: one file a layout.
//!
//! In: a [`PictureSet`], what is known of the pictures of a data set; and [`LayoutFiles`], by which pictures and ground
//! truth are read and files are written. Out: files. Reading the data set is left to
//! `photosite::dataset`.
//!
//! | layout | poses | corners of targets | ground truth that it needs |
//! |---|---|---|---|
//! | [COLMAP](photosite_core::references#colmap) | world → camera | as points | – |
//! | [EuRoC](photosite_core::references#euroc) | body → world, sensor → body; the body is the first camera | – | – |
//! | [Kalibr](photosite_core::references#kalibr) | from camera to camera | target file | – |
//! | [BOP](photosite_core::references#bop) | model → camera, world → camera, mm | – | depth, instance |
//! | [COCO](photosite_core::references#coco) | – | as key points | instance |
//! | [Nerfstudio](photosite_core::references#nerfstudio) | camera → world, z up | – | – |
//!
//! Cameras have OpenCV's axes (x right, y down, z forward) in all of them but Nerfstudio's; the world is that of
//! glTF, metres with y up, in all but that.
//! Pictures are copied, never linked: a tool that changes its pictures in place must not change the data set, and a
//! folder that is moved to another disk or packed stays whole.

mod bop;
mod coco;
mod colmap;
mod euroc;
mod kalibr;
mod models;
mod nerfstudio;
mod objects;
mod picture_set;
mod silhouette;
#[cfg(test)]
mod tests;

use photosite_core::Result;

pub use objects::SceneObject;
pub use picture_set::{EPOCH_NS, LayoutFiles, PictureSet, RollingShutter, SeenPoint, SeenTarget, Shot};

/// A layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Layout of COLMAP: `images/`, `sparse/0/`.
    Colmap,
    /// Layout of the EuRoC data sets, also called ASL: `mav0/`.
    Euroc,
    /// What Kalibr makes a bag of: `cam0/`, `camchain.yaml`, target files.
    Kalibr,
    /// Layout of the BOP data sets: `train/`, `models/`.
    Bop,
    /// Layout of COCO: `images/`, `annotations/instances.json`.
    Coco,
    /// `transforms.json` as Nerfstudio reads it, `images/`, `depths/`.
    Nerfstudio,
}

impl Layout {
    /// Lays out a data set.
    pub fn write(self, set: &PictureSet, files: &mut dyn LayoutFiles) -> Result<()> {
        match self {
            Self::Colmap => colmap::write(set, files),
            Self::Euroc => euroc::write(set, files),
            Self::Kalibr => kalibr::write(set, files),
            Self::Bop => bop::write(set, files),
            Self::Coco => coco::write(set, files),
            Self::Nerfstudio => nerfstudio::write(set, files),
        }
    }
}
