//! PLY meshes, which scanners and programs for point clouds write, as a [`SceneDescription`].
//!
//! A `.ply` file, ASCII or binary in either byte order, with the image that it names, becomes a mesh in the file's own
//! unit, at the origin; it and its material have the name of the file.
//!
//! | what the file has | is taken as |
//! |---|---|
//! | `x y z`, `nx ny nz` of vertices | positions and normals |
//! | `red green blue` and `alpha` of vertices, also `r g b a` and `diffuse_red` … | reflectance and opacity: bytes and 16-bit integers are encoded as sRGB, as scanners write them, floats are linear from 0 to 1 |
//! | `u v`, `s t`, `texture_u texture_v` or `s0 t0` of vertices | UV, v upwards |
//! | `vertex_indices` or `vertex_index` of faces | polygons |
//! | `texcoord` of faces | UV of their corners (MeshLab) |
//! | a comment `TextureFile` | the image of the reflectance (MeshLab); colours of vertices beside it are left out |
//!
//! Without colours and image the surface is diffuse grey. Other content, such as triangle strips and colours of
//! faces, is left out with a warning where it would show.
//!
//! The parser is our own: that of the `ply-rs-bw` crate keeps a table of names for each vertex, takes memory for elements
//! without properties that no byte backs, and knows no place of an error in binary files.

mod header;
mod mesh;
mod values;

#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::Arc;

use super::assemble::{add_meshes, coloured, diffuse, name_of_file, undescribed};
use super::bitmap_file::read_bitmap;
use super::mesh::MissingNormals;
use header::Header;
use mesh::Geometry;
use photosite_core::warnings::Warnings;
use photosite_core::{Error, Result, Sandbox, input, text};
use photosite_transport::scene::description::{Colour, SceneDescription, TextureDescription, TexturedColour};
use photosite_transport::texture::{SamplerSettings, UvTransform};

/// Reads a `.ply` file with the image that it names, which must lie in a sandbox.
pub fn read(path: &Path, missing_normals: MissingNormals, sandbox: &Sandbox) -> Result<SceneDescription> {
    let bytes = input::read(path).map_err(|reason| Error::io(path, "read", reason))?;
    parse(&bytes, path, missing_normals, sandbox)
}

/// Reads a `.ply` file from memory; `path` is for messages and for the image that it names, which must lie in a
/// sandbox.
pub fn parse(
    bytes: &[u8],
    path: &Path,
    missing_normals: MissingNormals,
    sandbox: &Sandbox,
) -> Result<SceneDescription> {
    let mut warnings = Warnings::default();
    let bytes = &*text::plain(bytes).map_err(|reason| Error::io(path, "read", reason))?;
    let header = Header::parse(bytes, path)?;
    let geometry = Geometry::read(bytes, &header, path, &mut warnings)?;
    let name = name_of_file(path);
    let mut mesh = geometry.into_mesh(name.clone(), missing_normals);
    let mut scene = SceneDescription::default();
    let texture = read_texture(&header, &mut scene, path, sandbox, !mesh.uvs.is_empty(), &mut warnings)?;
    if texture.is_some() && !mesh.colours.is_empty() {
        warnings.once("the colours of the vertices are left out, as the image has those of the surface");
        mesh.colours = Vec::new();
    }
    scene.materials.push(match texture {
        Some(texture) => {
            let colour = Colour::Rgb([1.0; 3]);
            diffuse(&name, TexturedColour { colour, texture: Some(texture) })
        }
        None if mesh.colours.is_empty() => undescribed(&name),
        None => coloured("PLY", &name, mesh.colours.iter().any(|colour| colour.w < 1.0)),
    });
    add_meshes(&mut scene, [mesh], path, &mut warnings)?;
    scene.warnings = warnings.of_file(path);
    Ok(scene)
}

/// Image of the surface, if the file names a single one and gives UV coordinates.
fn read_texture(
    header: &Header,
    scene: &mut SceneDescription,
    path: &Path,
    sandbox: &Sandbox,
    has_uvs: bool,
    warnings: &mut Warnings,
) -> Result<Option<TextureDescription>> {
    let (line, name) = match &header.images[..] {
        [] => return Ok(None),
        [image] => image,
        [(line, _), .., (last, _)] => {
            warnings
                .once(format!("the images of the lines {line}–{last} are left out: more than one is not supported"));
            return Ok(None);
        }
    };
    if !has_uvs {
        warnings.once(format!("line {line}: the image {name:?} is left out, as there are no UV"));
        return Ok(None);
    }
    let image = path.with_file_name(name);
    let bitmap = sandbox.check(&image).and_then(|()| read_bitmap(&image));
    scene.images.push(Arc::new(bitmap.map_err(|e| e.within("TextureFile").at_line(path, *line))?));
    scene.files.push(image);
    let (sampler, transform) = (SamplerSettings::default(), UvTransform::default());
    Ok(Some(TextureDescription { image: 0, uv_set: 0, sampler, transform }))
}
