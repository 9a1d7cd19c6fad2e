//! Layout of COLMAP's sparse model as text with its images ([Colmap](photosite_core::references#colmap), "Output
//! Format"):
//!
//! ```text
//! images/CAMERA/000000.png
//! sparse/0/{cameras.txt, images.txt, points3D.txt}
//! ```
//!
//! A camera for each lens that the cameras of the rig have had. The points are the corners of targets, each seen where
//! it is visible; their error is 0. Pixels are counted from the corner of the first one.

use std::collections::BTreeMap;

use super::super::camera_files::{
    CalibratedCamera, ColmapImage, ColmapPoint, colmap_cameras, colmap_images, colmap_points,
};
use super::image_set::{ImageSet, LayoutFiles, is_same_lens};
use photosite_core::Result;

pub(super) fn write(set: &ImageSet, files: &mut dyn LayoutFiles) -> Result<()> {
    let mut cameras: Vec<(usize, CalibratedCamera)> = Vec::new();
    let mut points = BTreeMap::new();
    let mut images = Vec::new();
    for shot in &set.shots {
        let known =
            |(of, camera): &(usize, CalibratedCamera)| *of == shot.camera && is_same_lens(camera, &shot.calibrated);
        let camera = cameras.iter().position(known).unwrap_or_else(|| {
            cameras.push((shot.camera, shot.calibrated.clone()));
            cameras.len() - 1
        });
        let mut seen = Vec::new();
        for target in &shot.targets {
            for (i, point) in target.points.iter().enumerate() {
                let Some(pixel) = point.pixel.filter(|_| point.is_visible) else { continue };
                // A target that has moved has other points.
                let key = (target.name.clone(), i, point.world.to_array().map(f64::to_bits));
                let next = points.len();
                let ColmapPoint { number, track, .. } = points.entry(key).or_insert_with(|| ColmapPoint {
                    number: next + 1,
                    world: point.world,
                    track: Vec::new(),
                });
                track.push((images.len(), seen.len()));
                seen.push((pixel + 0.5, *number));
            }
        }
        let name = format!("{}/{:06}.png", set.cameras[shot.camera], shot.frame);
        images.push(ColmapImage { name, camera, to_world: shot.calibrated.to_world, points: seen });
    }
    let cameras: Vec<CalibratedCamera> = cameras.into_iter().map(|(_, camera)| camera).collect();
    files.write_text("sparse/0/cameras.txt", &colmap_cameras(&cameras).map_err(|invalid| set.error(invalid))?)?;
    files.write_text("sparse/0/images.txt", &colmap_images(&images))?;
    let mut points: Vec<ColmapPoint> = points.into_values().collect();
    points.sort_by_key(|point| point.number);
    files.write_text("sparse/0/points3D.txt", &colmap_points(&points))?;
    for (shot, image) in set.shots.iter().zip(&images) {
        files.copy_image(&format!("images/{}", image.name), shot)?;
    }
    Ok(())
}
