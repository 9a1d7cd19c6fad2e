//! Folder of a layout, made under a temporary name and renamed when it is complete.

use photosite_core::{Remedy, input};
use std::fs;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use photosite_calibration::layouts::{LayoutFiles, SeenPoint, Shot};
use photosite_calibration::truth::TruthLayer;
use photosite_capture::Capture;
use photosite_capture::report::{ObjectsReport, REPORT, Report};
use photosite_core::image::Planes;
use photosite_core::output::{create_folder, create_folders, write_unsynced};
use photosite_core::{Error, Invalid, Result, Sandbox};
use photosite_files::exr::{ExrImage, read_exr};
use photosite_files::lock::Lock;
use photosite_files::npy::write_planes;
use photosite_files::plain_png::{image_size, is_grey, read_grey, write_grey8, write_grey16};
use photosite_files::unfinished::{UnfinishedFolder, is_filled, unfinished_folders};
use photosite_transport::scene::description::SceneDescription;
use serde_json::Value;

/// Name of the developed image in the folder of an image.
pub(super) const IMAGE: &str = "image.png";
/// Name of the ground truth file.
pub(super) const TRUTH: &str = "truth.exr";
/// Name of the file of objects.
pub(super) const OBJECTS: &str = "objects.json";

/// Folder that is being filled. It is removed when it is given up.
pub struct LayoutFolder {
    folder: UnfinishedFolder,
    _lock: Lock,
    dataset: PathBuf,
    /// Scene that was read last, with the keys that it was read from.
    scene: Option<(Vec<Value>, Arc<SceneDescription>)>,
    /// Sandbox in which the layout's files must lie.
    sandbox: Sandbox,
    warnings: Vec<String>,
}

impl LayoutFolder {
    /// Refuses a path that cannot become a folder, or is a folder that is not empty.
    pub fn check(path: &Path) -> Result<()> {
        let message = if path.is_file() {
            format!("{} is a file, but a folder is needed", path.display())
        } else if is_filled(path) {
            format!("{} is not empty", path.display())
        } else if path.file_name().is_none() {
            format!("{} is not a name for a new folder", path.display())
        } else {
            return Ok(());
        };
        Err(Error::Usage { message, help: Some(Remedy::Elsewhere("a new folder".to_owned()).into()) })
    }

    /// Begins a folder that does not exist yet, or is empty.
    pub fn begin(sandbox: &Sandbox, path: &Path, dataset: &Path) -> Result<Self> {
        create_folder(path.parent().unwrap_or(Path::new("")))?;
        let lock = Lock::beside(path)?;
        // Another process may have finished in the meantime.
        Self::check(path)?;
        if lock.is_proven() {
            // Of dead processes; nothing depends on it.
            unfinished_folders(path).iter().for_each(|folder| drop(fs::remove_dir_all(folder)));
        }
        let folder = UnfinishedFolder::beside(path, |_| false)?;
        Ok(Self {
            folder,
            _lock: lock,
            dataset: dataset.to_owned(),
            scene: None,
            sandbox: sandbox.clone(),
            warnings: Vec::new(),
        })
    }

    /// Warnings of what the layout leaves out.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Gives the complete folder its name.
    pub fn finish(self, path: &Path) -> Result<()> {
        if self.folder.finish()? {
            return Ok(());
        }
        let help = Remedy::Elsewhere("a new folder".to_owned());
        let message = format!("{} was filled by another process", path.display());
        Err(Error::Usage { message, help: Some(help.into()) })
    }

    /// Path of a file of the layout, whose folder is created.
    pub(super) fn place(&self, name: &str) -> Result<PathBuf> {
        let path = self.folder.path().join(name);
        if let Some(folder) = path.parent() {
            create_folders(folder).map_err(|reason| Error::io(folder, "create the folder", reason))?;
        }
        Ok(path)
    }

    /// Path of a file of an image, which need not exist.
    pub(super) fn of_shot(&self, shot: &Shot, name: &str) -> PathBuf {
        self.dataset.join(&shot.folder).join(name)
    }

    /// Path of a file of an image that must exist; `help` says what to write into the capture for it to be there.
    fn source(&self, shot: &Shot, name: &str, help: &str) -> Result<PathBuf> {
        let path = self.of_shot(shot, name);
        if path.is_file() {
            return Ok(path);
        }
        Err(Invalid::new("", "is missing").help(help).in_file(&path))
    }

    /// Warns once that key points of objects are left out, where the capture has any.
    fn warn_of_key_points(&mut self, shot: &Shot) -> Result<()> {
        let capture = Report::read(&self.of_shot(shot, REPORT))?.capture;
        let objects = capture.pointer("/scene/objects").and_then(Value::as_array);
        let has_points = |object: &Value| object.get("keypoints").is_some();
        let message = "objects have key points, and the data set holds no objects.json that says where they appear: make it \
                       with output.objects = true";
        if objects.is_some_and(|objects| objects.iter().any(has_points)) && !self.warnings.iter().any(|w| w == message)
        {
            self.warnings.push(message.to_owned());
        }
        Ok(())
    }

    /// Developed image, checked to have the pixels of the camera.
    pub(super) fn image(&self, shot: &Shot) -> Result<PathBuf> {
        let help = "make the data set with output.image = true, and a develop.colour_space whose images are PNG files, not xyz";
        let path = self.source(shot, IMAGE, help)?;
        check_size(image_size(&path)?, shot, &path)?;
        Ok(path)
    }
}

/// Refuses a file that does not have the pixels of its camera.
pub(super) fn check_size([width, height]: [u32; 2], shot: &Shot, path: &Path) -> Result<()> {
    let [columns, rows] = shot.calibrated.resolution;
    if [width, height] == [columns, rows] {
        return Ok(());
    }
    let message = format!("has {width} × {height} pixels, and the camera {columns} × {rows}");
    let help = "make the data set again: earlier versions knew the camera of all pixels of the sensor alone";
    Err(Invalid::new("", message).help(help).in_file(path))
}

/// Reads all layers of an image's ground truth.
pub(super) fn read_truth(path: &Path) -> Result<Planes> {
    let file = input::open(path).map_err(|reason| Error::io(path, "read", reason))?;
    let whole = read_exr(BufReader::new(file)).and_then(ExrImage::whole);
    whole.map(|truth| truth.planes).map_err(|invalid| invalid.in_file(path))
}

impl LayoutFiles for LayoutFolder {
    fn write_text(&mut self, path: &str, text: &str) -> Result<()> {
        write_unsynced(&self.place(path)?, |to| to.write_all(text.as_bytes()))
    }

    fn copy_image(&mut self, path: &str, shot: &Shot) -> Result<()> {
        let (from, to) = (self.image(shot)?, self.place(path)?);
        let mut file = input::open(&from).map_err(|reason| Error::io(&from, "read", reason))?;
        write_unsynced(&to, |to| io::copy(&mut file, to).map(|_| ()))
    }

    fn write_grey_image(&mut self, path: &str, shot: &Shot) -> Result<()> {
        let grey = read_grey(&self.image(shot)?)?;
        write_unsynced(&self.place(path)?, |to| write_grey8(grey.size, &grey.values, to))
    }

    fn is_grey(&mut self, shot: &Shot) -> Result<bool> {
        is_grey(&self.image(shot)?)
    }

    fn write_mask(&mut self, path: &str, size: [u32; 2], inside: &[bool]) -> Result<()> {
        let values: Vec<u8> = inside.iter().map(|&inside| if inside { 255 } else { 0 }).collect();
        write_unsynced(&self.place(path)?, |to| write_grey8(size, &values, to))
    }

    fn write_grey16(&mut self, path: &str, size: [u32; 2], values: &[u16]) -> Result<()> {
        write_unsynced(&self.place(path)?, |to| write_grey16(size, values, to))
    }

    fn write_npy(&mut self, path: &str, size: [u32; 2], values: &[f32]) -> Result<()> {
        let size = size.map(|n| n as usize);
        write_unsynced(&self.place(path)?, |to| write_planes(size, &[values], |value| value, to))
    }

    fn warn(&mut self, message: &str) {
        self.warnings.push(message.to_owned());
    }

    fn has_truth(&mut self, shot: &Shot, layers: &[TruthLayer]) -> Result<bool> {
        let path = self.of_shot(shot, TRUTH);
        if !path.is_file() {
            return Ok(false);
        }
        let planes = read_truth(&path)?;
        Ok(layers.iter().flat_map(|layer| layer.channels()).all(|name| planes.plane(name).is_some()))
    }

    fn truth(&mut self, shot: &Shot, layers: &[TruthLayer]) -> Result<Planes> {
        let names: Vec<String> = layers.iter().map(|layer| format!("\"{}\"", layer.name())).collect();
        let help = format!(
            "this layout needs output.truth = [{}] in the capture, with truth_formats = [\"exr\"]",
            names.join(", ")
        );
        let path = self.source(shot, TRUTH, &help)?;
        let planes = read_truth(&path)?;
        let mut channels = layers.iter().flat_map(|layer| layer.channels());
        if let Some(missing) = channels.find(|name| planes.plane(name).is_none()) {
            return Err(Invalid::new("", format!("has no layer {missing}")).help(help).in_file(&path));
        }
        if [planes.width(), planes.height()] != shot.calibrated.resolution.map(|n| n as usize) {
            return Err(Invalid::new("", "is not of the size of the image").in_file(&path));
        }
        Ok(planes)
    }

    fn object_points(&mut self, shot: &Shot) -> Result<Vec<(u32, Vec<SeenPoint>)>> {
        let path = self.of_shot(shot, OBJECTS);
        if !path.is_file() {
            return self.warn_of_key_points(shot).map(|()| Vec::new());
        }
        let text = input::read_text(&path, input::TABLE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
        let report: ObjectsReport = serde_json::from_str(&text)
            .map_err(|error| Invalid::new("", format!("is damaged: {error}")).in_file(&path))?;
        let objects = report.objects.into_iter().filter(|object| !object.keypoints.is_empty());
        Ok(objects.map(|object| (object.number, object.seen_points())).collect())
    }

    fn scene(&mut self, shot: &Shot) -> Result<Arc<SceneDescription>> {
        let path = self.dataset.join(&shot.folder).join(REPORT);
        let capture = Report::read(&path)?.capture;
        let keys: Vec<Value> = ["scene", "targets", "materials"].map(|table| capture[table].clone()).to_vec();
        if let Some((known, scene)) = &self.scene
            && *known == keys
        {
            return Ok(scene.clone());
        }
        let scene = Capture::load_within(&self.sandbox, &path, &[])?.scene().clone();
        self.scene = Some((keys, scene.clone()));
        Ok(scene)
    }
}
