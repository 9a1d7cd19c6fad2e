//! The file that stands for a capture: a capture file, the report of one that was rendered, or a scene.

use std::path::Path;

use super::super::camera::focus;
use super::super::tables::file_kind::FileKind;
use super::super::tables::geometry_kind::GeometryKind;
use super::super::tree::nodes as tree;
use super::super::tree::source::CaptureSource;
use super::super::tree::text_file::{read_text, unknown_kind};
use super::stored_report::StoredReport;
use photosite_core::input::metadata;
use photosite_core::{Error, Result};

/// Reads the source that a path holds: a capture file, a report of one that was rendered, or a scene file that stands
/// for one.
pub(crate) fn read_source(path: &Path) -> Result<CaptureSource> {
    if is_scene_file(path) {
        metadata(path).map_err(|reason| Error::io(path, "read", reason))?;
        return Ok(CaptureSource::of_scene_file(path));
    }
    let is_of_kind = |kind: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(kind));
    if is_of_kind("json") {
        return Ok(StoredReport::read(path)?.source(path));
    }
    if let Some(kind) = FileKind::of_name(path).filter(|kind| *kind != FileKind::Model && path.is_file()) {
        return Err(kind.instead_of("a capture file or a scene", path));
    }
    let source = CaptureSource::parse(path, read_text(path)?);
    // Syntax errors help nobody who gave a file of another kind.
    let source = if is_of_kind("toml") { source? } else { source.map_err(|_| unknown_kind(path))? };
    match FileKind::of_keys(source.sections().map(|(key, _)| key)) {
        Some(kind @ (FileKind::DataSet | FileKind::Sensor | FileKind::Lens)) => {
            Err(kind.instead_of("a capture file or a scene", path))
        }
        Some(_) | None => Ok(source),
    }
}

/// Focuses the lens on the middle of a scene that stands for a capture, unless something says otherwise.
pub(crate) fn focus_on_scene(source: &mut CaptureSource) {
    let keys = ["focus_distance_m", "autofocus_px", "autofocus", "image_distance_mm"];
    let is_stated = keys.iter().any(|key| source.has(&format!("lens.{key}")));
    let is_thin = matches!(source.get("lens.type").and_then(tree::Node::as_str), None | Some("thin"));
    if !is_stated && is_thin {
        source.set_default("lens", "focus_distance_m", &focus::ON_SCENE.into());
    }
}

/// Whether a path names a file of geometry rather than a capture file.
pub(crate) fn is_scene_file(path: &Path) -> bool {
    GeometryKind::of(path).is_some()
}
