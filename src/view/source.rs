//! What can be exposed and developed: light of a scene, light of files, raw images.

use std::path::PathBuf;
use std::sync::Arc;

use crate::io::developable::Developable;
use crate::pipeline::{Light, Prepared, StoredRender};

/// Light of a scene, as far as it is traced.
#[derive(Clone)]
pub(super) struct Lit {
    pub(super) prepared: Arc<Prepared>,
    pub(super) light: Arc<Light>,
    /// Counts the lights.
    pub(super) number: u64,
    /// Counts the scenes and cameras.
    pub(super) trace: u64,
}

/// What pictures are made of.
#[derive(Clone)]
pub(super) enum Source {
    Traced(Lit),
    Stored(Arc<StoredRender>),
    File(Arc<OpenFile>),
}

/// A raw file, or a picture of light.
pub(super) struct OpenFile {
    pub(super) path: PathBuf,
    pub(super) holds: Developable,
}
