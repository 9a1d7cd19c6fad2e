//! Completion of meshes for their materials: UV sets that textures refer to, tangents for normal maps.

use glam::{Vec2, Vec4};

use super::changed_meshes::{ChangedMeshes, MeshChange};
use super::mesh::flatten;
use super::tangents::with_tangents;
use photosite_core::warnings::Warnings;
use photosite_transport::scene::description::{
    LayeredDescription, MaterialDescription, MeshDescription, Roughness, SceneDescription, Visit,
};
use photosite_transport::texture::UvTransform;

/// Completes every mesh for its material: a UV set of zeros for each that textures use and the mesh lacks (with a
/// warning), and tangents for normal maps and anisotropy. A flat-shaded mesh that needs tangents gets its geometric
/// normals written out. Call it when no material changes any more.
pub fn complete(scene: &mut SceneDescription, known: &mut ChangedMeshes) {
    let mut warnings = Warnings::default();
    for mesh in &mut scene.meshes {
        let material = &scene.materials[mesh.material];
        let tangents = tangent_frame(material).filter(|_| mesh.tangents.is_empty() || mesh.normals.is_empty());
        let textures = material.textures();
        let missing = || textures.iter().filter(|texture| mesh.uvs.len() <= texture.uv_set);
        if mesh.quadric.is_none() {
            for texture in missing() {
                let (mesh_name, material_name, set) = (&mesh.name, &material.name, texture.uv_set);
                warnings.once(format!(
                    "the mesh {mesh_name:?} lacks TEXCOORD_{set}, which its material {material_name:?} uses: the image's corner stands for all of it"
                ));
            }
        }
        let uv_sets = missing().map(|texture| texture.uv_set + 1).max().unwrap_or(0);
        if tangents.is_some() || uv_sets > 0 && mesh.quadric.is_none() {
            let change = MeshChange::Completed { uv_sets, tangents };
            known.change(mesh, change, |mesh| complete_mesh(mesh, uv_sets, tangents));
        }
    }
    scene.warnings.extend(warnings.into_messages());
}

/// Gives a mesh at least this number of UV sets, and tangents.
fn complete_mesh(mesh: &mut MeshDescription, uv_sets: usize, tangents: Option<(usize, UvTransform)>) {
    if mesh.quadric.is_some() {
        // It has UVs and tangents of its own; that there are any here tells that they are wanted.
        mesh.tangents = vec![Vec4::ZERO; mesh.positions.len()];
        return;
    }
    let with_sets = |mesh: &mut MeshDescription, count: usize| {
        mesh.uvs.resize(count.max(mesh.uvs.len()), vec![Vec2::ZERO; mesh.positions.len()]);
    };
    with_sets(mesh, uv_sets);
    let Some((uv_set, transform)) = tangents else { return };
    if mesh.normals.is_empty() {
        *mesh = flatten(mesh);
    }
    if mesh.tangents.is_empty() {
        with_sets(mesh, uv_set + 1);
        *mesh = with_tangents(mesh, uv_set, &transform);
    }
}

/// UV set and transform that tangents follow, if the material needs any.
fn tangent_frame(material: &MaterialDescription) -> Option<(usize, UvTransform)> {
    if let Some((texture, _)) = &material.normal_map {
        return Some((texture.uv_set, texture.transform));
    }
    let mut frame = TangentFrame(None);
    material.model.visit(&mut frame);
    frame.0
}

/// First UV set and transform that tangents of a model follow.
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
