//! Skins: meshes that follow joints (§3.7.3).

use glam::{DAffine3, DMat4, DVec3, Vec3};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::buffers::out_of_range;
use photosite_core::Invalid;
use photosite_transport::scene::description::MeshDescription;

/// Transforms mesh → world of every joint of skin number `index`: the joint's transform times its inverse bind matrix.
/// `to_world` holds the transform of each node in the scene.
pub(super) fn joints(
    accessors: Accessors<'_>,
    index: usize,
    key: &str,
    to_world: &[Option<DAffine3>],
) -> Result<Vec<DAffine3>, Invalid> {
    let skins = &accessors.root.skins;
    let skin = skins.get(index).ok_or_else(|| out_of_range(key, "skins", index, skins.len()))?;
    let key = format!("skins[{index}]");
    let inverse_binds = match skin.inverse_bind_matrices {
        Some(accessor) => accessors.floats::<16>(accessor.value(), &format!("{key}.inverseBindMatrices"))?,
        None => Vec::new(),
    };
    if skin.inverse_bind_matrices.is_some() && inverse_binds.len() < skin.joints.len() {
        let message = format!("has {} matrices for {} joints", inverse_binds.len(), skin.joints.len());
        return Err(Invalid::new(format!("{key}.inverseBindMatrices"), message));
    }
    let joint = |(i, node): (usize, &gltf::json::Index<gltf::json::Node>)| {
        let key = format!("{key}.joints[{i}]");
        let place =
            to_world.get(node.value()).ok_or_else(|| out_of_range(&key, "nodes", node.value(), to_world.len()))?;
        let place = place.ok_or_else(|| {
            Invalid::new(&*key, format!("nodes[{}] is not in the scene", node.value()))
                .help("joints must be part of the same scene as the mesh that they move")
        })?;
        let bind = inverse_binds.get(i).map_or(DMat4::IDENTITY, |m| DMat4::from_cols_array(&m.map(f64::from)));
        Ok(place * DAffine3::from_mat4(bind))
    };
    skin.joints.iter().enumerate().map(joint).collect()
}

/// Moves the vertices of a primitive into the world by their joints.
pub(super) fn bend(
    mesh: &mut MeshDescription,
    primitive: &Primitive,
    accessors: Accessors<'_>,
    joints: &[DAffine3],
    key: &str,
) -> Result<(), Invalid> {
    let mut moves = vec![[DVec3::ZERO; 4]; mesh.positions.len()];
    let mut sums = vec![0.0; mesh.positions.len()];
    for set in 0.. {
        let find = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(|accessor| accessor.value());
        let (Some(indices), Some(weights)) = (find(Semantic::Joints(set)), find(Semantic::Weights(set))) else { break };
        let (joints_key, weights_key) =
            (format!("{key}.attributes.JOINTS_{set}"), format!("{key}.attributes.WEIGHTS_{set}"));
        let indices = accessors.floats::<4>(indices, &joints_key)?;
        let weights = accessors.floats::<4>(weights, &weights_key)?;
        for (key, len) in [(&joints_key, indices.len()), (&weights_key, weights.len())] {
            if len != moves.len() {
                return Err(Invalid::new(&**key, format!("has {len} entries for {} positions", moves.len())));
            }
        }
        for (vertex, (indices, weights)) in indices.iter().zip(&weights).enumerate() {
            for (&joint, &weight) in indices.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
                let place = joints.get(joint as usize).ok_or_else(|| {
                    let message = format!("vertex {vertex} follows joint {joint} of {} (counted from 0)", joints.len());
                    Invalid::new(&*joints_key, message)
                })?;
                let columns = [place.matrix3.x_axis, place.matrix3.y_axis, place.matrix3.z_axis, place.translation];
                for (sum, column) in moves[vertex].iter_mut().zip(columns) {
                    *sum += column * f64::from(weight);
                }
                sums[vertex] += f64::from(weight);
            }
        }
    }
    for (vertex, ([x, y, z, translation], sum)) in moves.into_iter().zip(sums).enumerate() {
        // Weights are rounded; those of a vertex that follows nothing leave it where it is.
        if sum <= 0.0 {
            continue;
        }
        let place = DAffine3::from_cols(x / sum, y / sum, z / sum, translation / sum);
        mesh.positions[vertex] = place.transform_point3(mesh.positions[vertex].as_dvec3()).as_vec3();
        let turn = |v: Vec3, by: glam::DMat3| (by * v.as_dvec3()).normalize_or_zero().as_vec3();
        if let Some(normal) = mesh.normals.get_mut(vertex) {
            *normal = turn(*normal, place.matrix3.inverse().transpose());
        }
        if let Some(tangent) = mesh.tangents.get_mut(vertex) {
            *tangent = turn(tangent.truncate(), place.matrix3).extend(tangent.w);
        }
    }
    Ok(())
}
