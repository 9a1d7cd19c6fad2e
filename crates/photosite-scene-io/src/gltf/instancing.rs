//! EXT_mesh_gpu_instancing: one mesh at many places of its node.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};
use serde::Deserialize;

use super::accessor::Accessors;
use super::nodes::{PlacedNode, is_invertible};
use photosite_core::Invalid;

const NAME: &str = "EXT_mesh_gpu_instancing";

#[derive(Deserialize)]
struct Instancing {
    attributes: BTreeMap<String, usize>,
}

/// Mesh → world of every placement at a node: one, or those that the extension lists.
pub(super) fn placements(accessors: Accessors<'_>, placed: &PlacedNode<'_>) -> Result<Vec<DAffine3>, Invalid> {
    let Some(value) = placed.node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else {
        return Ok(vec![placed.to_world]);
    };
    let key = format!("nodes[{}].extensions.{NAME}", placed.index);
    let table: Instancing =
        serde_json::from_value(value.clone()).map_err(|source| Invalid::new(&*key, source.to_string()))?;
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let attribute = |name: &str| table.attributes.get(name).map(|&index| (index, format!("{key}.attributes.{name}")));
    let vectors = |name: &str| -> Result<Option<Vec<[f32; 3]>>, Invalid> {
        attribute(name).map(|(index, key)| accessors.floats::<3>(index, &key)).transpose()
    };
    let (translations, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
    let rotations = attribute("ROTATION").map(|(index, key)| accessors.floats::<4>(index, &key)).transpose()?;
    let counts = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let Some(count) = counts.into_iter().flatten().next() else { return Ok(vec![placed.to_world]) };
    if counts.into_iter().flatten().any(|other| other != count) {
        return Err(Invalid::new(key, "has attributes of different counts"));
    }
    let place = |i: usize| {
        let translation = translations.as_ref().map_or(DVec3::ZERO, |t| wide(t[i]));
        let scale = scales.as_ref().map_or(DVec3::ONE, |s| wide(s[i]));
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |r| DQuat::from_array(r[i].map(f64::from)));
        let length = rotation.length();
        let local = DAffine3::from_scale_rotation_translation(scale, rotation / length, translation);
        let to_world = placed.to_world * local;
        if is_invertible(&to_world) {
            Ok(to_world)
        } else {
            Err(Invalid::new(&*key, format!("the transform of instance {i} is singular, or is not finite"))
                .help("give every axis a scale other than 0 and every rotation a unit quaternion"))
        }
    };
    (0..count).map(place).collect()
}
