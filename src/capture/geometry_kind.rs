//! Kinds of geometry files.

use std::path::Path;

/// A kind of geometry files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GeometryKind {
    Gltf,
    Obj,
    Ply,
    Stl,
}

impl GeometryKind {
    /// The kind that a name's ending says.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_ascii_lowercase();
        match &*extension {
            "gltf" | "glb" => Some(Self::Gltf),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }

    /// Whether its files are in metres. Others have no unit: `meters_per_unit` says it.
    pub(crate) fn is_in_metres(self) -> bool {
        match self {
            Self::Gltf => true,
            Self::Obj | Self::Ply | Self::Stl => false,
        }
    }
}
