//! Folders that each hold some samples of a data set's images.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::identity::{IDENTITY, OF_PART, of_part, read_identity};
use super::image_folder::image;
use photosite_core::{Error, Invalid, Result};
use photosite_pipeline::{DEVICE, FormerDevice, difference};
use photosite_transport::integrator::Device;

/// Folder of parts of images.
pub struct PartFolder {
    path: PathBuf,
    identity: Value,
}

impl PartFolder {
    /// Whether a folder is that of a data set.
    pub fn is_one(path: &Path) -> bool {
        path.join(IDENTITY).exists()
    }

    /// Reads the identity of a folder of parts.
    pub fn read(path: &Path) -> Result<Self> {
        let refuse = |message: &str| {
            let help = "give folders that contain a part of a data set";
            Err(Invalid::new("", message).help(help).in_file(path))
        };
        if !Self::is_one(path) {
            return refuse("does not contain a part of a data set");
        }
        let identity = read_identity(&path.join(IDENTITY))?;
        if identity.get(OF_PART).is_none_or(Value::is_null) {
            return refuse("contains a whole data set, not a part of one");
        }
        Ok(Self { path: path.to_owned(), identity })
    }

    /// Path of the data set file from which the parts were made.
    pub fn input(&self) -> PathBuf {
        PathBuf::from(of_part(&self.identity, "path").and_then(Value::as_str).unwrap_or_default())
    }

    /// Overrides that the parts were made with.
    pub fn arguments(&self) -> Vec<String> {
        let arguments = self.identity.get("overrides").and_then(Value::as_array).into_iter().flatten();
        arguments.filter_map(Value::as_str).map(str::to_owned).collect()
    }

    /// Device that traced the parts; `None` for the processor.
    pub fn device(&self) -> Option<Arc<dyn Device>> {
        FormerDevice::of(self.identity.get(DEVICE))
    }

    /// Refuses parts of another data set.
    pub(super) fn check(&self, whole: &Value) -> Result<()> {
        if self.identity.get("fingerprint") == whole.get("fingerprint") {
            return Ok(());
        }
        let difference = difference(&self.identity, whole);
        let message = format!("{} is a part of another data set: {difference}", self.path.display());
        Err(Error::Usage { message, help: Some("give parts of one data set, and its file as it was".into()) })
    }

    /// Part of an image, if it is there.
    pub(super) fn image(&self, camera: &str, number: u32) -> Option<PathBuf> {
        Some(image(&self.path, camera, number)).filter(|path| path.exists())
    }
}
