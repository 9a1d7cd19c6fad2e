//! `calibration/`: expected results of calibrating the cameras, for OpenCV, ROS and Kalibr.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use photosite_calibration::camera_files::{CalibratedCamera, StereoPair, kalibr, opencv, opencv_pair, ros, ros_pair};
use photosite_calibration::dataset::CALIBRATION_FOLDER;
use photosite_calibration::layouts::ImageSet;
use photosite_core::output::{create_folder, write_whole};
use photosite_core::{Error, Invalid, Result};

/// Writes the calibration files as far as the formats can express the lenses; returns why others are left out. Where
/// autofocus `focuses`, lenses differ from frame to frame, and only the images' own reports state them.
pub(super) fn write_calibration(set: &ImageSet, focuses: bool) -> Result<Vec<String>> {
    let folder = set.folder.join(CALIBRATION_FOLDER);
    let mut left_out = Vec::new();
    let mut written = BTreeSet::new();
    match set.rig() {
        Ok(rig) => {
            for (name, text) in calibration_files(&rig) {
                match text {
                    Ok(text) => {
                        let path = folder.join(&name);
                        create_folder(path.parent().unwrap_or(&folder))?;
                        write_whole(&path, |to| to.write_all(text.as_bytes()))?;
                        written.insert(name);
                    }
                    Err(invalid) => left_out.push(format!("`{name}`: {}", invalid.message)),
                }
            }
        }
        Err(invalid) => {
            let help = invalid.help.map(|help| help.to_string()).unwrap_or_default();
            let cure = if focuses {
                "autofocus moves lenses from frame to frame, write lens.focus_distance_m in its place"
            } else {
                &help
            };
            let message = invalid.message;
            left_out.push(format!(
                "all of its files: {message}; {cure}; `photosite camera` makes those of one image from its capture.json"
            ));
        }
    }
    // What was true of fewer frames is not left behind.
    let earlier = calibration_names(&set.cameras).into_iter().filter(|name| !written.contains(name));
    earlier.map(|name| folder.join(name)).try_for_each(|path| remove(&path))?;
    Ok(left_out)
}

/// Removes a file, which another process may have removed already.
fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        // A folder that is not there, or a file of that name in its place
        Err(reason) if matches!(reason.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(()),
        removed => removed.map_err(|reason| Error::io(path, "remove the earlier file", reason)),
    }
}

/// Files of a rig by their names. OpenCV's and ROS's pairs are those of the first camera with each other one; ROS files
/// of rigs of more than two cameras lie in a folder for each pair, in which the first camera is turned for that pair.
fn calibration_files(rig: &[CalibratedCamera]) -> Vec<(String, Result<String, Invalid>)> {
    let mut files = vec![("camchain.yaml".to_owned(), kalibr(rig))];
    files.extend(beside_the_first(rig).map(|camera| (format!("opencv/{}.yaml", camera.name), opencv(&camera))));
    let Some((first, others)) = rig.split_first() else { return files };
    if others.is_empty() {
        files.push((format!("ros/{}.yaml", first.name), ros(first)));
    }
    for other in others {
        let pair_name = format!("{}-{}", first.name, other.name);
        let folder = if others.len() > 1 { format!("ros/{pair_name}") } else { "ros".to_owned() };
        let pair = StereoPair::new(first, other);
        let pair = pair.as_ref().map_err(Invalid::clone);
        files.push((format!("opencv/stereo/{pair_name}.yaml"), pair.clone().and_then(opencv_pair)));
        let names = [first, other].map(|camera| format!("{folder}/{}.yaml", camera.name));
        match pair.and_then(ros_pair) {
            Ok(texts) => files.extend(names.into_iter().zip(texts.map(Ok))),
            Err(invalid) => files.extend(names.map(|name| (name, Err(invalid.clone())))),
        }
    }
    files
}

/// Names of all files that [`calibration_files`] may give for cameras of these names.
fn calibration_names(cameras: &[String]) -> Vec<String> {
    let mut names = vec!["camchain.yaml".to_owned()];
    let Some(first) = cameras.first() else { return names };
    for camera in cameras {
        names.extend(["opencv", "ros"].map(|folder| format!("{folder}/{camera}.yaml")));
        names.push(format!("opencv/stereo/{first}-{camera}.yaml"));
        names.extend([first, camera].map(|of_pair| format!("ros/{first}-{camera}/{of_pair}.yaml")));
    }
    names
}

/// Cameras in a world whose axes are OpenCV's of the first camera, whose own pose is then the identity.
fn beside_the_first(rig: &[CalibratedCamera]) -> impl Iterator<Item = CalibratedCamera> {
    let to_first = rig.first().map(CalibratedCamera::from_world).unwrap_or_default();
    rig.iter().map(move |camera| CalibratedCamera { to_world: to_first * camera.to_world, ..camera.clone() })
}
