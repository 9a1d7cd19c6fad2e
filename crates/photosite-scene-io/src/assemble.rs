//! Assembly of scenes from files with meshes but no nodes, such as OBJ, PLY and STL: every mesh is at the origin.

use std::path::Path;

use glam::DAffine3;

use super::mesh::checked;
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result};
use photosite_transport::scene::description::{
    AlphaMode, Colour, Diffuse, InstanceDescription, LayeredDescription, MaterialDescription, MaterialModel,
    MeshDescription, SceneDescription, TexturedColour, TexturedFactor,
};

/// Reflectance of surfaces without a description.
pub(crate) const DEFAULT_REFLECTANCE: f32 = 0.5;

/// A diffuse grey material, for surfaces without a description.
pub(crate) fn undescribed(name: &str) -> MaterialDescription {
    diffuse(name, TexturedColour::plain(Colour::Rgb([DEFAULT_REFLECTANCE; 3])))
}

/// A two-sided diffuse material, since these files have no notion of a front.
pub(crate) fn diffuse(name: &str, reflectance: TexturedColour) -> MaterialDescription {
    MaterialDescription {
        double_sided: true,
        ..MaterialDescription::new(name, MaterialModel::Diffuse(Diffuse { reflectance }))
    }
}

/// A diffuse material with colours of the vertices: layers whose facets reflect nothing. `kind` is the format.
pub(crate) fn coloured(kind: &'static str, name: &str, has_holes: bool) -> MaterialDescription {
    let layers = LayeredDescription { kind, specular: TexturedFactor::plain(0.0), ..LayeredDescription::default() };
    MaterialDescription {
        alpha: if has_holes { AlphaMode::Blend } else { AlphaMode::Opaque },
        double_sided: true,
        ..MaterialDescription::new(name, MaterialModel::Layered(Box::new(layers)))
    }
}

/// Adds the meshes of a file, each at the origin, and warns of mended and omitted parts.
pub(crate) fn add_meshes(
    scene: &mut SceneDescription,
    meshes: impl IntoIterator<Item = MeshDescription>,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<()> {
    let mut zero_area = 0;
    for mesh in meshes {
        let (mesh, mended) = checked(mesh).map_err(|invalid| invalid.in_file(path))?;
        zero_area += mended.zero_area;
        if mended.normals > 0 {
            warnings.once("some normals have no length and were computed from the triangles around them");
        }
        if mesh.triangles.is_empty() {
            continue;
        }
        let (name, index) = (mesh.name.clone(), scene.meshes.len());
        scene.meshes.push(mesh.into());
        scene.instances.push(InstanceDescription::of_mesh(name, index, DAffine3::IDENTITY));
    }
    if zero_area > 0 {
        warnings.once(super::zero_area_message(zero_area));
    }
    if scene.meshes.is_empty() {
        let message = match zero_area {
            0 => "has no triangles".to_owned(),
            _ => format!("has no triangles but {zero_area} of zero area"),
        };
        return Err(Invalid::new("", message).help("export the scene with its faces").in_file(path));
    }
    Ok(())
}

/// Name of a file without its folder and extension, for parts of it that have no name of their own.
pub(crate) fn name_of_file(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
