//! Calibration targets, `[[targets]]`, drawn and placed in the scene.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::super::files::sections as file;
use super::super::tables::TargetTable;
use super::super::tree::overrides;
use super::super::tree::source::CaptureSource;
use photosite_calibration::targets::{PlacedTarget, Target, TargetDescription, TargetKind};
use photosite_core::{Invalid, Result};
use photosite_transport::scene::description::{
    InstanceDescription, MeshDescription, SceneDescription, look_at, vector,
};

/// Reads the description of a target that the command line asks for: a kind, and `key=value` for any of its keys.
pub fn read_target(kind: TargetKind, arguments: &[String]) -> Result<(TargetDescription, Target)> {
    let mut source = CaptureSource::parse(Path::new(kind.name()), format!("[target]\ntype = {:?}\n", kind.name()))?;
    for argument in arguments {
        overrides::set_target(&mut source, argument)?;
    }
    let node = source.get("target").cloned();
    let node = node.ok_or_else(|| source.error(Invalid::new("target", "is missing")))?;
    let TargetTable { description, .. } = file::target(&source, "target", &node)?;
    let target = description.draw().map_err(|invalid| source.error(invalid.within("target")))?;
    Ok((description, target))
}

/// Draws and places the targets of a capture file.
pub(crate) fn place_targets(tables: &[TargetTable]) -> Result<Vec<PlacedTarget>, Invalid> {
    let mut placed: Vec<PlacedTarget> = Vec::new();
    for (i, table) in tables.iter().enumerate() {
        let target = place(table).map_err(|invalid| invalid.within(&format!("targets[{i}]")))?;
        if placed.iter().any(|other| other.name == target.name) {
            let message = format!("there is already a target {:?}", target.name);
            let key =
                if table.placement.name.is_some() { format!("targets[{i}].name") } else { format!("targets[{i}]") };
            return Err(Invalid::new(key, message).help("give each a name of its own"));
        }
        placed.push(target);
    }
    Ok(placed)
}

fn place(table: &TargetTable) -> Result<PlacedTarget, Invalid> {
    let TargetTable { placement, description } = table;
    let target = description.draw()?;
    let name = placement.name.clone().unwrap_or_else(|| description.kind().name().to_owned());
    let position = vector("position_m", placement.position_m.unwrap_or_default())?;
    let faced = placement.look_at_m.map(|point| vector("look_at_m", point)).transpose()?;
    let up = vector("up", placement.up.unwrap_or([0.0, 1.0, 0.0]))?;
    let outward = look_at(position, faced.unwrap_or(position + DVec3::Z), up).ok_or_else(|| match faced {
        Some(point) if point == position => {
            let message = "is where the target stands, so it faces nowhere";
            Invalid::new("look_at_m", message).help("write a point in front of it, for example that of the camera")
        }
        Some(_) | None => {
            let message = format!("the target faces along {up}, so that cannot be up on it");
            Invalid::new("up", message).help("write a direction along the sheet, for example up = [0, 0, -1]")
        }
    })?;
    // Looking out of the sheet, left and right are swapped.
    let DMat3 { x_axis, y_axis, z_axis } = outward.matrix3;
    let rotation = DMat3::from_cols(-x_axis, -y_axis, z_axis);
    let middle = (target.sheet[0] + target.sheet[1]) / 2.0;
    let to_world = DAffine3::from_mat3_translation(rotation, position - rotation * middle.extend(0.0));
    Ok(PlacedTarget { name, description: description.clone(), target, to_world })
}

/// A target as meshes with their materials.
pub(crate) fn scene_of(placed: &PlacedTarget) -> SceneDescription {
    let mut scene = SceneDescription::default();
    for (index, (material, mesh)) in placed.target.meshes(&placed.name).into_iter().enumerate() {
        scene.materials.push(material);
        scene.meshes.push(MeshDescription { material: index, ..mesh }.into());
        scene.instances.push(InstanceDescription::of_mesh(&placed.name, index, placed.to_world));
    }
    scene
}
