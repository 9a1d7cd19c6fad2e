//! Meshes as PLY files, spheres, disks and cylinders, and where they stand.

use glam::Vec4;

use super::element::Element;
use super::material::ExportedMaterial;
use super::output::{Output, quoted};
use super::sensor::rows;
use crate::scene::description::{
    AlphaMode, MaterialDescription, MaterialModel, MeshDescription, Roughness, SceneDescription, Visit,
};
use crate::scene::emission_spectrum;
use crate::texture::UvTransform;

/// All placements of all meshes.
pub(super) fn shapes(scene: &SceneDescription, materials: &[ExportedMaterial], out: &mut Output) -> Vec<Element> {
    let mut uses = vec![0usize; scene.meshes.len()];
    scene.instances.iter().flat_map(|instance| instance.meshes.clone()).for_each(|mesh| uses[mesh] += 1);
    let mut elements = Vec::new();
    // A group may not shine: lamps are placed one by one.
    let is_group = |mesh: usize| uses[mesh] > 1 && scene.materials[scene.meshes[mesh].material].emission.is_none();
    for index in (0..scene.meshes.len()).filter(|&index| is_group(index)) {
        let group = Element::object("shape", "shapegroup").attribute("id", group_id(index));
        elements.push(group.child(shape(index, false, scene, materials, out)));
    }
    for instance in &scene.instances {
        // A mirroring placement turns corners clockwise; the front shall stay the front.
        let mirrored = instance.to_world.matrix3.determinant() < 0.0;
        for mesh in instance.meshes.clone() {
            let placed = if is_group(mesh) && !mirrored {
                Element::object("shape", "instance").child(Element::reference(&group_id(mesh)))
            } else {
                shape(mesh, mirrored, scene, materials, out)
            };
            elements.push(placed.transform("to_world", rows(instance.to_world)));
        }
    }
    elements
}

fn group_id(mesh: usize) -> String {
    format!("group-{mesh}")
}

fn shape(
    index: usize,
    mirrored: bool,
    scene: &SceneDescription,
    materials: &[ExportedMaterial],
    out: &mut Output,
) -> Element {
    let mesh = &scene.meshes[index];
    let material = &materials[mesh.material];
    let described = &scene.materials[mesh.material];
    // Mitsuba's unit shapes are the same, each a plugin of its own.
    if let Some(kind) = mesh.quadric {
        if is_anisotropic(described) || !described.textures().is_empty() {
            let name = quoted(kind.name(), &mesh.name);
            out.approximate(format!("the texture of {name} or its grooves: its UVs are others"));
        }
        return Element::object("shape", kind.name()).child(Element::reference(&material.id));
    }
    let name = if mirrored { format!("meshes/{index}-mirrored.ply") } else { format!("meshes/{index}.ply") };
    let file = out.file(name, || ply(mesh, mirrored, material.uv_set, material.uv_transform));
    let shape = Element::object("shape", "ply")
        .string("filename", file)
        .boolean("face_normals", is_flat(mesh))
        .child(Element::reference(&material.id));
    let is_coloured = matches!(described.model, MaterialModel::Layered(_));
    if is_coloured && mesh.colours.iter().any(|colour| *colour != Vec4::ONE) {
        out.approximate(format!("the colours of the corners of {}: they are left out", quoted("mesh", &mesh.name)));
    }
    let name = quoted("material", &described.name);
    if !has_uvs(mesh) && is_anisotropic(described) {
        out.approximate(format!("the anisotropy of {name} on a mesh without UVs: its direction is another one"));
    }
    let Some(emission) = &described.emission else { return shape };
    if emission.texture.is_some() {
        out.approximate(format!("the emission texture of {name}: it shines as if the texture were white"));
    }
    if described.alpha != AlphaMode::Opaque {
        out.approximate(format!("the holes of the lamp of {name}: they shine too"));
    }
    if described.double_sided {
        out.approximate(format!("the light of {name} on both sides: it shines on the front only"));
    }
    if !is_flat(mesh) {
        out.approximate(format!(
            "the light of {name} on a smooth mesh: in Mitsuba its shading normals tell front from back"
        ));
    }
    let radiance = emission_spectrum(&emission.colour, emission.level);
    shape.child(Element::object("emitter", "area").spectrum("radiance", &radiance))
}

/// Whether the microfacets of a material have a direction. The anisotropy of layers is left out, which their export
/// tells.
fn is_anisotropic(material: &MaterialDescription) -> bool {
    let mut found = IsAnisotropic(false);
    material.model.visit(&mut found);
    found.0
}

struct IsAnisotropic(bool);

impl Visit for IsAnisotropic {
    fn roughness(&mut self, roughness: &Roughness) {
        let [along, across] = roughness.distribution().alpha();
        self.0 |= along != across;
    }
}

/// Whether there are UVs that lead anywhere: meshes that had none are given zeros.
fn has_uvs(mesh: &MeshDescription) -> bool {
    mesh.uvs.first().is_some_and(|uvs| uvs.iter().any(|uv| *uv != uvs[0]))
}

/// Whether the shading normals, if there are any, are those of the triangles.
fn is_flat(mesh: &MeshDescription) -> bool {
    mesh.normals.is_empty()
        || mesh.triangles.iter().all(|corners| {
            let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize].as_dvec3());
            let normal = (b - a).cross(c - a).normalize_or_zero();
            // Half a thousandth of a radian, the square root of twice the bound.
            corners.iter().all(|&corner| mesh.normals[corner as usize].as_dvec3().dot(normal) > 1.0 - 1e-7)
        })
}

/// A binary PLY file of a mesh in its own space, its triangles turned over if it is to be `mirrored`.
fn ply(mesh: &MeshDescription, mirrored: bool, uv_set: usize, uv_transform: UvTransform) -> Vec<u8> {
    let uvs = mesh.uvs.get(uv_set);
    let transform = uv_transform.to_affine();
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.positions.len());
    let mut properties = vec!["x", "y", "z"];
    if !mesh.normals.is_empty() {
        properties.extend(["nx", "ny", "nz"]);
    }
    if uvs.is_some() {
        properties.extend(["u", "v"]);
    }
    properties.iter().for_each(|name| header += &format!("property float {name}\n"));
    header += &format!("element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.triangles.len());
    let mut bytes = header.into_bytes();
    for (i, position) in mesh.positions.iter().enumerate() {
        let uv = uvs.map(|uvs| transform.transform_point2(uvs[i]).to_array());
        let normal = mesh.normals.get(i).map(|n| n.to_array());
        let numbers =
            position.to_array().into_iter().chain(normal.into_iter().flatten()).chain(uv.into_iter().flatten());
        numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    for &[a, b, c] in &mesh.triangles {
        bytes.push(3);
        let corners = if mirrored { [a, c, b] } else { [a, b, c] };
        corners.iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
    }
    bytes
}
