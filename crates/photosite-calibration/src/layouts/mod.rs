//! Finished data sets in the folders and files that other tools read: one file a layout.
//!
//! In: a [`ImageSet`], the images of a data set with everything known about them; and [`LayoutFiles`], by which
//! images and ground truth are read and files are written. Out: files. Reading the data set is left to
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
//! Cameras have OpenCV's axes (x right, y down, z forward) and the world is that of glTF, metres with y up, except in
//! Nerfstudio's layout. Images are copied, never linked: a tool that changes its images in place must not change the
//! data set, and a folder that is moved to another disk or packed stays whole.

mod bop;
mod coco;
mod colmap;
mod euroc;
mod image_set;
mod kalibr;
mod models;
mod nerfstudio;
mod objects;
mod silhouette;
#[cfg(test)]
mod tests;

use photosite_core::Result;

pub use image_set::{EPOCH_NS, ImageSet, LayoutFiles, RollingShutter, SeenPoint, SeenTarget, Shot};
pub use objects::SceneObject;

/// Layout of a data set for another tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Layout of COLMAP: `images/`, `sparse/0/`.
    Colmap,
    /// Layout of the EuRoC data sets, also called ASL: `mav0/`.
    Euroc,
    /// Kalibr's input for a bag: `cam0/`, `camchain.yaml`, target files.
    Kalibr,
    /// Layout of the BOP data sets: `train/`, `models/`.
    Bop,
    /// Layout of COCO: `images/`, `annotations/instances.json`.
    Coco,
    /// Layout of Nerfstudio: `transforms.json`, `images/`, `depths/`.
    Nerfstudio,
}

impl Layout {
    /// Lays out a data set.
    pub fn write(self, set: &ImageSet, files: &mut dyn LayoutFiles) -> Result<()> {
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
