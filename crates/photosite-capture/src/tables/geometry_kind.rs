//! Kinds of geometry files.

use std::path::Path;

use glam::DQuat;

use super::super::tables::UpAxis;

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

    /// The axis of its files that points up where nothing says it. The programs for mechanical design that write STL have z
    /// up.
    pub(crate) fn up(self) -> UpAxis {
        match self {
            Self::Gltf | Self::Obj | Self::Ply => UpAxis::Y,
            Self::Stl => UpAxis::Z,
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

/// File → world of what a file holds, as the axis has it that points up. One that is assumed and is not y is said; `key`
/// states it.
pub(crate) fn upright(path: &Path, stated: Option<UpAxis>, key: &str, warnings: &mut Vec<String>) -> DQuat {
    let assumed = GeometryKind::of(path).map_or(UpAxis::Y, GeometryKind::up);
    if stated.is_none() && assumed == UpAxis::Z {
        let file = path.display();
        let warning = format!(
            "{file}: an STL file does not say which of its axes points up, and z is taken, as programs for design have it; \
             write {key} = \"z\" to confirm it, or \"y\""
        );
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    match stated.unwrap_or(assumed) {
        UpAxis::Y => DQuat::IDENTITY,
        UpAxis::Z => DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
    }
}
