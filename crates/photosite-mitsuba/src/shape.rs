//! Shapes: meshes as PLY files, spheres, disks and cylinders, and their placements.

use glam::{DVec3, Vec4};

use super::difference::Difference;
use super::element::Element;
use super::material::ExportedMaterial;
use super::output::{Output, quoted};
use super::sensor::rows;
use photosite_transport::scene::description::{
    AlphaMode, MaterialDescription, MaterialModel, MeshDescription, Roughness, SceneDescription, Visit,
};
use photosite_transport::scene::emission_spectrum;
use photosite_transport::texture::UvTransform;

/// Elements of all placements of all meshes.
pub(super) fn shapes(scene: &SceneDescription, materials: &[ExportedMaterial], out: &mut Output) -> Vec<Element> {
    let mut uses = vec![0usize; scene.meshes.len()];
    scene.instances.iter().flat_map(|instance| instance.meshes.clone()).for_each(|mesh| uses[mesh] += 1);
    let mut elements = Vec::new();
    // A group may not shine: lamps are placed one by one.
    let is_group = |mesh: usize| uses[mesh] > 1 && scene.materials[scene.meshes[mesh].material].emission.is_none();
    for index in (0..scene.meshes.len()).filter(|&index| is_group(index)) {
        let group = Element::object("shape", "shapegroup").attribute("id", group_id(index));
        elements.push(group.with(shape(index, false, scene, materials, out)));
    }
    for instance in &scene.instances {
        // A mirroring placement turns corners clockwise; the front shall stay the front.
        let mirrored = instance.to_world.matrix3.determinant() < 0.0;
        for mesh in instance.meshes.clone() {
            let placed = if is_group(mesh) && !mirrored {
                vec![Element::object("shape", "instance").child(Element::reference(&group_id(mesh)))]
            } else {
                shape(mesh, mirrored, scene, materials, out)
            };
            let to_world = rows(instance.to_world);
            elements.extend(placed.into_iter().map(|shape| shape.transform("to_world", to_world)));
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
) -> Vec<Element> {
    let mesh = &scene.meshes[index];
    let material = &materials[mesh.material];
    let described = &scene.materials[mesh.material];
    match mesh.quadric {
        Some(kind) if is_anisotropic(described) || !described.textures().is_empty() => {
            out.approximate(Difference::QuadricUvs { shape: quoted(kind.name(), &mesh.name) });
        }
        Some(_) => {}
        None => differences(mesh, described, material, out),
    }
    let radiance = described.emission.as_ref().map(|emission| {
        lamp_differences(mesh, described, out);
        emission_spectrum(&emission.colour, emission.level)
    });
    let shining = |shape: Element| match &radiance {
        Some(radiance) => shape.child(Element::object("emitter", "area").spectrum("radiance", radiance)),
        None => shape,
    };
    // Mitsuba's unit shapes are the same, each a plugin of its own.
    if let Some(kind) = mesh.quadric {
        return vec![shining(Element::object("shape", kind.name()).child(Element::reference(&material.id)))];
    }
    let part = |(suffix, id, triangles): (&str, &str, Vec<[u32; 3]>)| {
        let suffix = if mirrored { format!("{suffix}-mirrored") } else { suffix.to_owned() };
        let file = out.file(format!("meshes/{index}{suffix}.ply"), || {
            ply(mesh, &triangles, mirrored, material.uv_set, material.uv_transform)
        });
        let ply = Element::object("shape", "ply").string("filename", file).boolean("face_normals", is_flat(mesh));
        shining(ply.child(Element::reference(id)))
    };
    parts(mesh, material, mirrored).into_iter().map(part).collect()
}

/// The triangles of a mesh by the handedness of their tangents where that matters: the suffix of the file, the id of
/// the material and the triangles.
fn parts<'a>(
    mesh: &MeshDescription,
    material: &'a ExportedMaterial,
    mirrored: bool,
) -> Vec<(&'static str, &'a str, Vec<[u32; 3]>)> {
    let Some((left_id, _)) = &material.left_handed else { return vec![("", &material.id, mesh.triangles.clone())] };
    let is_left = |corners: &[u32; 3]| {
        let sum: f32 = corners.iter().filter_map(|&corner| mesh.tangents.get(corner as usize)).map(|t| t.w).sum();
        (sum < 0.0) != mirrored
    };
    let (left, right): (Vec<_>, Vec<_>) = mesh.triangles.iter().copied().partition(is_left);
    let parts = [("", material.id.as_str(), right), ("-left", left_id.as_str(), left)];
    parts.into_iter().filter(|(_, _, triangles)| !triangles.is_empty()).collect()
}

/// Notes differences between Mitsuba and photosite in a mesh and its material together.
fn differences(mesh: &MeshDescription, described: &MaterialDescription, material: &ExportedMaterial, out: &mut Output) {
    let is_coloured = matches!(described.model, MaterialModel::Layered(_));
    if is_coloured && mesh.colours.iter().any(|colour| *colour != Vec4::ONE) {
        out.approximate(Difference::CornerColours { mesh: quoted("mesh", &mesh.name) });
    }
    if !has_uvs(mesh) && is_anisotropic(described) {
        out.approximate(Difference::GroovesWithoutUvs { material: quoted("material", &described.name) });
    }
    let has_frame = is_anisotropic(described) || described.normal_map.is_some();
    if has_frame && has_uvs(mesh) && !runs_along_u(mesh, material) {
        out.approximate(Difference::Tangents { mesh: quoted("mesh", &mesh.name) });
    }
    let lean = largest_lean_rad(mesh);
    if lean > COARSE_RAD {
        out.approximate(Difference::CoarseNormals { mesh: quoted("mesh", &mesh.name), lean_deg: lean.to_degrees() });
    }
}

/// Notes differences between Mitsuba and photosite in the light of a mesh.
fn lamp_differences(mesh: &MeshDescription, described: &MaterialDescription, out: &mut Output) {
    let material = || quoted("material", &described.name);
    if described.emission.as_ref().is_some_and(|emission| emission.texture.is_some()) {
        out.approximate(Difference::EmissionTexture { material: material() });
    }
    if described.alpha != AlphaMode::Opaque {
        out.approximate(Difference::HolesOfEmitter { material: material() });
    }
    if described.double_sided {
        out.approximate(Difference::EmitterOfTwoSides { material: material() });
    }
    if !is_flat(mesh) {
        out.approximate(Difference::SmoothEmitter { material: material() });
    }
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

/// Whether a mesh has UVs that lead anywhere: meshes that had none are given zeros.
fn has_uvs(mesh: &MeshDescription) -> bool {
    mesh.uvs.first().is_some_and(|uvs| uvs.iter().any(|uv| *uv != uvs[0]))
}

/// Whether the tangents are along u of each triangle, as Mitsuba has them, to within a thousandth of a radian.
fn runs_along_u(mesh: &MeshDescription, material: &ExportedMaterial) -> bool {
    let (Some(uvs), transform) = (mesh.uvs.get(material.uv_set), material.uv_transform.to_affine()) else {
        return false;
    };
    mesh.tangents.is_empty()
        || mesh.triangles.iter().all(|corners| {
            let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize].as_dvec3());
            let [u, v, w] = corners.map(|corner| transform.transform_point2(uvs[corner as usize]).as_dvec2());
            let (to_v, to_w) = (v - u, w - u);
            let along = ((b - a) * to_w.y - (c - a) * to_v.y) * to_v.perp_dot(to_w).signum();
            corners.iter().all(|&corner| {
                let normal = mesh.normals[corner as usize].as_dvec3();
                let in_plane = |t: DVec3| t.reject_from_normalized(normal).normalize_or_zero();
                in_plane(along).dot(in_plane(mesh.tangents[corner as usize].truncate().as_dvec3())) > 1.0 - 5e-7
            })
        })
}

/// Largest angle, rad, by which normals of smooth meshes may lean from their triangles; more shows at their outlines:
/// of a ball, the square of it is the part of the image where normals are seen from behind.
const COARSE_RAD: f64 = 0.1;

/// Whether the shading normals, if there are any, are those of the triangles.
fn is_flat(mesh: &MeshDescription) -> bool {
    largest_lean_rad(mesh) < 5e-4
}

/// The largest angle between a shading normal and its triangle, rad.
fn largest_lean_rad(mesh: &MeshDescription) -> f64 {
    let lean = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize].as_dvec3());
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let of_corner =
            |&corner: &u32| mesh.normals.get(corner as usize).map_or(0.0, |n| n.as_dvec3().angle_between(normal));
        corners.iter().map(of_corner).fold(0.0, f64::max)
    };
    // A triangle without an area has no normal.
    mesh.triangles.iter().map(lean).fold(0.0, f64::max)
}

/// A binary PLY file of triangles of a mesh in its own space, turned over if it is to be `mirrored`.
fn ply(
    mesh: &MeshDescription,
    triangles: &[[u32; 3]],
    mirrored: bool,
    uv_set: usize,
    uv_transform: UvTransform,
) -> Vec<u8> {
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
    header += &format!("element face {}\nproperty list uchar int vertex_indices\nend_header\n", triangles.len());
    let mut bytes = header.into_bytes();
    for (i, position) in mesh.positions.iter().enumerate() {
        let uv = uvs.map(|uvs| transform.transform_point2(uvs[i]).to_array());
        let normal = mesh.normals.get(i).map(|n| n.to_array());
        let numbers =
            position.to_array().into_iter().chain(normal.into_iter().flatten()).chain(uv.into_iter().flatten());
        numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    for &[a, b, c] in triangles {
        bytes.push(3);
        let corners = if mirrored { [a, c, b] } else { [a, b, c] };
        corners.iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
    }
    bytes
}
