//! STL meshes, which programs for mechanical design and 3-D printing write, as a [`SceneDescription`].
//!
//! A `.stl` file, ASCII or binary, becomes a mesh for each solid, in the file's own unit, at the origin, of a diffuse
//! grey material with the name of the file. Corners at the same place are one vertex. Normals of facets are left out,
//! since the order of the corners defines the front, and so are colours in the attributes of binary files, for which
//! programs have different codes; warnings report visible effects.
//!
//! The parser is our own: that of the `stl_io` crate takes every file for ASCII that begins with "solid", as many binary
//! ones do, knows neither solids nor lines, and takes the rest of a file that is cut off within a solid for its end.

mod ascii;
mod binary;
mod solid;

#[cfg(test)]
mod tests;

use std::path::Path;

use super::assemble::{add_meshes, name_of_file, undescribed};
use super::mesh::{MissingNormals, seamless_normals};
use photosite_core::warnings::Warnings;
use photosite_core::{Error, Result, input, text};
use photosite_transport::scene::description::{MeshDescription, SceneDescription};
use solid::Solid;

/// Reads a `.stl` file.
pub fn read(path: &Path, missing_normals: MissingNormals) -> Result<SceneDescription> {
    let bytes = input::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    parse(&bytes, path, missing_normals)
}

/// Reads a `.stl` file from memory; `path` is for messages.
pub fn parse(bytes: &[u8], path: &Path, missing_normals: MissingNormals) -> Result<SceneDescription> {
    let mut warnings = Warnings::default();
    let text = if binary::is_whole(bytes) { Ok(bytes.into()) } else { text::plain(bytes) };
    let bytes = text.map_err(|reason| Error::io(path, "read", reason))?;
    let solids = if binary::is_binary(&bytes) {
        vec![binary::read(&bytes, path, &mut warnings)?]
    } else {
        ascii::read(bytes.into_owned(), path)?
    };
    let contrary: usize = solids.iter().map(|solid| solid.contrary).sum();
    if contrary > 0 {
        let of_all: usize = solids.iter().map(|solid| solid.triangles.len()).sum();
        warnings.once(format!(
            "the normals of {contrary} of {of_all} facets contradict the order of their corners, which is used instead"
        ));
    }
    let name = name_of_file(path);
    let mut scene = SceneDescription { materials: vec![undescribed(&name)], ..SceneDescription::default() };
    let meshes = solids.into_iter().filter(|solid| !solid.triangles.is_empty()).map(|solid| {
        let Solid { name: own_name, positions, triangles, .. } = solid;
        let normals = match missing_normals {
            MissingNormals::Flat => Vec::new(),
            MissingNormals::Smooth => seamless_normals(&positions, &triangles),
        };
        let name = if own_name.is_empty() { name.clone() } else { own_name };
        MeshDescription { name, positions, normals, triangles, ..MeshDescription::default() }
    });
    add_meshes(&mut scene, meshes, path, &mut warnings)?;
    scene.warnings = warnings.of_file(path);
    Ok(scene)
}
