//! Meshes: every primitive becomes one [`MeshDescription`] of one material.

use glam::{DAffine3, Vec2, Vec3, Vec4};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::buffers::out_of_range;
use super::{draco, skin, variants};
use crate::mesh::{Mended, checked};
use photosite_core::Invalid;
use photosite_core::warnings::Warnings;
use photosite_transport::scene::description::{MeshDescription, ShapeDescription};

/// Largest number of UV sets of a mesh.
pub(super) const UV_SETS: usize = 2;

/// Reader of a document's meshes.
pub(super) struct MeshReader<'a> {
    pub(super) accessors: Accessors<'a>,
    /// Index of glTF's default material.
    pub(super) default_material: usize,
    /// Index of the chosen variant (KHR_materials_variants).
    pub(super) variant: Option<usize>,
}

/// Deformation of a mesh at one of its nodes.
#[derive(Clone, Default, PartialEq)]
pub(super) struct Pose<'a> {
    /// Weights of the morph targets, instead of the mesh's own.
    pub(super) weights: Option<Vec<f32>>,
    /// Mesh → world of the joints of its skin.
    pub(super) joints: Option<&'a [DAffine3]>,
}

impl Pose<'_> {
    /// Whether the mesh keeps its undeformed shape.
    pub(super) fn is_own(&self) -> bool {
        self.weights.is_none() && self.joints.is_none()
    }
}

/// Reads the triangles of mesh number `index` in the first of some poses, and the vertex positions in the others.
pub(super) fn read_mesh(
    reader: &MeshReader<'_>,
    index: usize,
    key: &str,
    poses: &[Pose<'_>],
    warnings: &mut Warnings,
) -> Result<(Vec<MeshDescription>, Mended), Invalid> {
    let accessors = reader.accessors;
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
        let unpacked = draco::unpack(accessors, primitive, &key, warnings)?;
        let accessors = Accessors { unpacked: unpacked.as_ref(), ..accessors };
        let reader = &MeshReader { accessors, ..*reader };
        let mut posed = |pose: &Pose<'_>| {
            let weights = pose.weights.as_deref().or(mesh.weights.as_deref()).unwrap_or_default();
            let mut description = read_primitive(reader, primitive, &key, name.clone(), weights, warnings)?;
            if let (Some(joints), Some(description)) = (pose.joints, &mut description) {
                skin::bend(description, primitive, accessors, joints, &key)?;
            }
            Ok::<_, Invalid>(description)
        };
        let Some((first, later)) = poses.split_first() else { continue };
        let Some(mut description) = posed(first)? else { continue };
        for pose in later {
            let MeshDescription { positions, normals, .. } = posed(pose)?.unwrap_or_default();
            description.later_shapes.push(ShapeDescription { positions, normals });
        }
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

/// Primitive of the file; `None` if it has no triangles by design.
fn read_primitive(
    reader: &MeshReader<'_>,
    primitive: &Primitive,
    key: &str,
    name: String,
    weights: &[f32],
    warnings: &mut Warnings,
) -> Result<Option<MeshDescription>, Invalid> {
    let accessors = reader.accessors;
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
    let chosen = match reader.variant {
        Some(variant) => variants::material(primitive, variant, key)?,
        None => None,
    };
    let material = match chosen.or(primitive.material.map(|material| material.value())) {
        Some(material) if material < accessors.root.materials.len() => material,
        Some(material) => {
            let len = accessors.root.materials.len();
            return Err(out_of_range(&format!("{key}.material"), "materials", material, len));
        }
        None => reader.default_material,
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
    let colours = match attribute(Semantic::Colors(0)) {
        Some(index) => {
            let key = attribute_key("COLOR_0");
            let colours: Vec<Vec4> = if accessors.kind(index, &key)?.width == 3 {
                accessors.floats::<3>(index, &key)?.into_iter().map(|c| Vec3::from(c).extend(1.0)).collect()
            } else {
                vectors(accessors.floats::<4>(index, &key)?)
            };
            same_count("COLOR_0", colours.len())?;
            colours
        }
        None => Vec::new(),
    };

    let triangles = match accessors.unpacked {
        Some(unpacked) => unpacked.triangles.clone(),
        None => read_triangles(accessors, primitive, mode, count, key)?,
    };
    if triangles.is_empty() {
        return Err(Invalid::new(key, "has no triangles").help("remove the mesh, or give it geometry"));
    }
    let mut mesh = MeshDescription {
        name,
        material,
        positions,
        normals,
        tangents,
        uvs,
        colours,
        triangles,
        later_shapes: Vec::new(),
        quadric: None,
    };
    morph(&mut mesh, primitive, accessors, weights, key)?;
    Ok(Some(mesh))
}

/// Triangles from the indices of a primitive, or from its vertices in their order.
fn read_triangles(
    accessors: Accessors<'_>,
    primitive: &Primitive,
    mode: Mode,
    vertices: usize,
    key: &str,
) -> Result<Vec<[u32; 3]>, Invalid> {
    let corners = match primitive.indices {
        Some(index) => accessors.indices(index.value(), &format!("{key}.indices"))?,
        None => (0..vertices as u32).collect(),
    };
    let triangles = triangles(mode, &corners);
    if triangles.is_empty() {
        return Err(Invalid::new(key, format!("has {} corners, which make no triangle", corners.len()))
            .help("remove the mesh, or give it geometry"));
    }
    if mode == Mode::Triangles && corners.len() % 3 != 0 {
        let message = format!("has {} corners, which is not a multiple of 3", corners.len());
        return Err(Invalid::new(format!("{key}.indices"), message));
    }
    Ok(triangles)
}

/// Adds the displacements of morph targets, each times its weight (§3.7.2.2). Targets without a weight do nothing.
fn morph(
    mesh: &mut MeshDescription,
    primitive: &Primitive,
    accessors: Accessors<'_>,
    weights: &[f32],
    key: &str,
) -> Result<(), Invalid> {
    let targets = primitive.targets.as_deref().unwrap_or_default();
    for (t, (target, &weight)) in targets.iter().zip(weights).enumerate().filter(|(_, (_, weight))| **weight != 0.0) {
        let read = |accessor: &Option<gltf::json::Index<gltf::json::Accessor>>, name: &str, count: usize| {
            let Some(accessor) = accessor.filter(|_| count > 0) else { return Ok(Vec::new()) };
            let key = format!("{key}.targets[{t}].{name}");
            let values: Vec<Vec3> = vectors(accessors.floats::<3>(accessor.value(), &key)?);
            if values.len() != count {
                return Err(Invalid::new(key, format!("has {} entries for {count} vertices", values.len())));
            }
            Ok(values)
        };
        let [positions, normals, tangents] = [mesh.positions.len(), mesh.normals.len(), mesh.tangents.len()];
        for (place, moved) in mesh.positions.iter_mut().zip(read(&target.positions, "POSITION", positions)?) {
            *place += moved * weight;
        }
        for (place, moved) in mesh.normals.iter_mut().zip(read(&target.normals, "NORMAL", normals)?) {
            *place += moved * weight;
        }
        for (place, moved) in mesh.tangents.iter_mut().zip(read(&target.tangents, "TANGENT", tangents)?) {
            *place += (moved * weight).extend(0.0);
        }
    }
    Ok(())
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
