//! Meshes: every primitive becomes one [`MeshDescription`] of one material.

use glam::{Vec2, Vec3, Vec4};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::buffers::out_of_range;
use crate::Invalid;
use crate::io::mesh::{Mended, checked};
use crate::io::warnings::Warnings;
use crate::scene::description::MeshDescription;

/// UV sets that a mesh can carry.
pub(super) const UV_SETS: usize = 2;

/// Reads the triangles of mesh number `index`. `default_material` is the index of glTF's default material.
pub(super) fn read_mesh(
    accessors: Accessors<'_>,
    index: usize,
    key: &str,
    default_material: usize,
    warnings: &mut Warnings,
) -> Result<(Vec<MeshDescription>, Mended), Invalid> {
    let all = &accessors.root.meshes;
    let mesh = all.get(index).ok_or_else(|| out_of_range(key, "meshes", index, all.len()))?;
    if mesh.primitives.is_empty() {
        return Err(Invalid::new(format!("meshes[{index}].primitives"), "is empty")
            .help("remove the mesh, or give it geometry"));
    }
    let mut meshes = Vec::with_capacity(mesh.primitives.len());
    let mut mended = Mended::default();
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        let key = format!("meshes[{index}].primitives[{p}]");
        let mut name = mesh.name.clone().unwrap_or_else(|| format!("mesh-{index}"));
        if mesh.primitives.len() > 1 {
            name += &format!("#{p}");
        }
        let Some(description) = read_primitive(accessors, primitive, &key, name, default_material, warnings)? else {
            continue;
        };
        let (description, mended_here) = checked(description).map_err(|e| {
            // What is no index is an attribute.
            let e = if e.key == "indices" { e } else { e.within("attributes") };
            e.within(&key)
        })?;
        mended.zero_area += mended_here.zero_area;
        mended.normals += mended_here.normals;
        if !description.triangles.is_empty() {
            meshes.push(description);
        }
    }
    Ok((meshes, mended))
}

/// A primitive as the file has it; `None` if it has no triangles by design.
fn read_primitive(
    accessors: Accessors<'_>,
    primitive: &Primitive,
    key: &str,
    name: String,
    default_material: usize,
    warnings: &mut Warnings,
) -> Result<Option<MeshDescription>, Invalid> {
    let mode = match primitive.mode {
        Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) => {
            warnings.once("points and lines have no surface and are left out");
            return Ok(None);
        }
        Checked::Valid(mode) => mode,
        Checked::Invalid => {
            return Err(Invalid::new(format!("{key}.mode"), "is unknown").help("write a number from 0 to 6"));
        }
    };
    if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
        warnings.once("morph targets are not supported; meshes keep their basic shape");
    }
    let material = match primitive.material {
        Some(material) if material.value() < accessors.root.materials.len() => material.value(),
        Some(material) => {
            let len = accessors.root.materials.len();
            return Err(out_of_range(&format!("{key}.material"), "materials", material.value(), len));
        }
        None => default_material,
    };

    let attribute_key = |name: &str| format!("{key}.attributes.{name}");
    let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|accessor| accessor.value());
    let Some(positions) = attribute(Semantic::Positions) else {
        return Err(Invalid::new(format!("{key}.attributes"), "has no POSITION, so the mesh has no shape"));
    };
    let positions: Vec<Vec3> = vectors(accessors.floats::<3>(positions, &attribute_key("POSITION"))?);
    let count = positions.len();
    if count == 0 {
        return Err(
            Invalid::new(attribute_key("POSITION"), "has no vertices").help("remove the mesh, or give it geometry")
        );
    }
    if count > u32::MAX as usize {
        return Err(Invalid::new(attribute_key("POSITION"), format!("has {count} vertices, more than {}", u32::MAX)));
    }
    let same_count = |name: &str, len: usize| {
        if len == count {
            return Ok(());
        }
        Err(Invalid::new(attribute_key(name), format!("has {len} entries for {count} positions")))
    };

    let normals: Vec<Vec3> = match attribute(Semantic::Normals) {
        Some(index) => vectors(accessors.floats::<3>(index, &attribute_key("NORMAL"))?),
        None => Vec::new(),
    };
    if !normals.is_empty() {
        same_count("NORMAL", normals.len())?;
    }
    let tangents: Vec<Vec4> = match attribute(Semantic::Tangents) {
        Some(index) => vectors(accessors.floats::<4>(index, &attribute_key("TANGENT"))?),
        None => Vec::new(),
    };
    if !tangents.is_empty() {
        same_count("TANGENT", tangents.len())?;
    }
    let mut uvs: Vec<Vec<Vec2>> = Vec::new();
    for set in 0..UV_SETS {
        let name = format!("TEXCOORD_{set}");
        let Some(index) = attribute(Semantic::TexCoords(set as u32)) else { continue };
        let values = vectors(accessors.floats::<2>(index, &attribute_key(&name))?);
        same_count(&name, values.len())?;
        // A file may have the second set only.
        uvs.resize(set, vec![Vec2::ZERO; count]);
        uvs.push(values);
    }
    if attribute(Semantic::Colors(0)).is_some() {
        warnings.once("vertex colours are not supported and are left out");
    }

    let corners = match primitive.indices {
        Some(index) => accessors.indices(index.value(), &format!("{key}.indices"))?,
        None => (0..count as u32).collect(),
    };
    let triangles = triangles(mode, &corners);
    if triangles.is_empty() {
        return Err(Invalid::new(key, format!("has {} corners, which make no triangle", corners.len()))
            .help("remove the mesh, or give it geometry"));
    }
    if mode == Mode::Triangles && corners.len() % 3 != 0 {
        let message = format!("has {} corners, which is no multiple of 3", corners.len());
        return Err(Invalid::new(format!("{key}.indices"), message));
    }
    Ok(Some(MeshDescription { name, material, positions, normals, tangents, uvs, triangles }))
}

fn vectors<const N: usize, V: From<[f32; N]>>(arrays: Vec<[f32; N]>) -> Vec<V> {
    arrays.into_iter().map(V::from).collect()
}

/// Cuts a list of corners into triangles (glTF specification §3.7.2.1: the order keeps fronts counter-clockwise).
fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::Triangles => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        Mode::TriangleStrip => {
            let turn = |(i, c): (usize, &[u32])| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] };
            corners.windows(3).enumerate().map(turn).collect()
        }
        Mode::TriangleFan => match corners {
            [hub, rim @ ..] => rim.windows(2).map(|c| [c[0], c[1], *hub]).collect(),
            [] => Vec::new(),
        },
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_turn_the_same_way_as_triangles() {
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 3, 4]), [[0, 1, 2]]);
        assert_eq!(triangles(Mode::TriangleStrip, &[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(triangles(Mode::TriangleFan, &[0, 1, 2, 3]), [[1, 2, 0], [2, 3, 0]]);
        for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
            assert!(triangles(mode, &[0, 1]).is_empty() && triangles(mode, &[]).is_empty());
        }
    }
}
