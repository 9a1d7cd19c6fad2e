//! What meshes need because of their materials, once both are settled: UV sets that textures refer to, tangents for
//! normal maps.

use glam::{Vec2, Vec4};

use super::mesh::flatten;
use super::tangents::with_tangents;
use photosite_core::warnings::Warnings;
use photosite_transport::scene::description::{
    LayeredDescription, MaterialDescription, Roughness, SceneDescription, Visit,
};
use photosite_transport::texture::UvTransform;

/// Adds to every mesh what its material needs: a UV set of zeros for each that textures use and the mesh lacks (with a
/// warning), and tangents for normal maps and anisotropy. A flat-shaded mesh that needs tangents gets its geometric
/// normals written out. To be called when no material changes any more.
pub fn complete(scene: &mut SceneDescription) {
    let mut warnings = Warnings::default();
    for mesh in &mut scene.meshes {
        let material = &scene.materials[mesh.material];
        if mesh.quadric.is_some() {
            // It has UVs and tangents of its own; that there are any here tells that they are wanted.
            if tangent_frame(material).is_some() {
                mesh.tangents = vec![Vec4::ZERO; mesh.positions.len()];
            }
            continue;
        }
        for texture in material.textures() {
            if mesh.uvs.len() <= texture.uv_set {
                let (mesh_name, material_name, set) = (&mesh.name, &material.name, texture.uv_set);
                warnings.once(format!(
                    "the mesh {mesh_name:?} lacks TEXCOORD_{set}, which its material {material_name:?} uses: the picture's corner stands for all of it"
                ));
                mesh.uvs.resize(texture.uv_set + 1, vec![Vec2::ZERO; mesh.positions.len()]);
            }
        }
        let Some((uv_set, transform)) = tangent_frame(material) else { continue };
        if mesh.normals.is_empty() {
            *mesh = flatten(mesh);
        }
        if mesh.tangents.is_empty() {
            mesh.uvs.resize((uv_set + 1).max(mesh.uvs.len()), vec![Vec2::ZERO; mesh.positions.len()]);
            *mesh = with_tangents(mesh, uv_set, &transform);
        }
    }
    scene.warnings.extend(warnings.into_messages());
}

/// The UV set and transform that tangents follow, if the material needs any.
fn tangent_frame(material: &MaterialDescription) -> Option<(usize, UvTransform)> {
    if let Some((texture, _)) = &material.normal_map {
        return Some((texture.uv_set, texture.transform));
    }
    let mut frame = TangentFrame(None);
    material.model.visit(&mut frame);
    frame.0
}

/// The first UV set and transform that tangents of a model follow.
struct TangentFrame(Option<(usize, UvTransform)>);

impl Visit for TangentFrame {
    fn roughness(&mut self, roughness: &Roughness) {
        if roughness.anisotropy != 0.0 {
            self.0.get_or_insert((0, UvTransform::default()));
        }
    }

    fn layered(&mut self, layers: &LayeredDescription) {
        let bumps = layers.coat.as_ref().and_then(|coat| coat.normal_map.as_ref()).map(|(texture, _)| texture);
        let grooves = layers.anisotropy.as_ref().map(|anisotropy| anisotropy.texture.as_ref());
        if let Some(texture) = bumps.map(Some).or(grooves) {
            self.0.get_or_insert(texture.map_or((0, UvTransform::default()), |t| (t.uv_set, t.transform)));
        }
    }
}
