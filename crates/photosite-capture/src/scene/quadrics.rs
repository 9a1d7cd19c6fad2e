//! Spheres, disks and cylinders of `[scene]`.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};

use super::super::tables::{MaterialTable, SceneTable};
use super::geometry::{FARTHEST_M, ReadScene};
use photosite_core::Invalid;
use photosite_transport::geometry::QuadricKind;
use photosite_transport::scene::description::{InstanceDescription, MeshDescription};

/// Smaller radii and lengths, m, have squares without digits of single precision.
pub(crate) const SMALLEST_SIZE_M: f64 = 1e-15;

impl ReadScene {
    /// Adds spheres, disks and cylinders. Materials that no file of the geometry has are those of `described` names.
    pub(crate) fn add_quadrics(
        &mut self,
        table: &SceneTable,
        described: &BTreeMap<String, MaterialTable>,
    ) -> Result<(), Invalid> {
        for quadric in quadrics(table) {
            let Quadric { kind, index, position_m, axis, radius_m, length_m, .. } = quadric;
            let invalid = |key: &str, message: String| Invalid::new(format!("{}.{key}", place(kind, index)), message);
            let (centre, reach) = (DVec3::from_array(position_m), radius_m.abs() + length_m.map_or(0.0, f64::abs));
            if !(centre.is_finite() && (centre.abs() + reach).max_element() <= FARTHEST_M) {
                return Err(invalid(
                    "position_m",
                    format!("lies farther out than {FARTHEST_M:e} m, too far to compute with"),
                ));
            }
            // The square of a smaller one has no digits in single precision.
            for (key, size) in [("radius_m", Some(radius_m)), ("length_m", length_m)] {
                if size.is_some_and(|size| size.is_nan() || size < SMALLEST_SIZE_M) {
                    let size = size.unwrap_or_default();
                    return Err(invalid(key, format!("must be at least {SMALLEST_SIZE_M:e}, got {size}")));
                }
            }
            let turn = match axis {
                None => DQuat::IDENTITY,
                Some((key, axis)) => match DVec3::from_array(axis).try_normalize() {
                    Some(axis) => DQuat::from_rotation_arc(DVec3::Z, axis),
                    None => {
                        let message = format!("must be a direction (not zero), got {axis:?}");
                        return Err(invalid(key, message).help(format!("for example {key} = [0, 1, 0] for upwards")));
                    }
                },
            };
            let material = self.material_of(quadric.material, described, &invalid)?;
            let name = quadric.name.map_or_else(|| format!("{}-{index}", kind.name()), str::to_owned);
            // The unit cylinder begins at the origin, and this one at half of its length from its middle.
            let length = length_m.unwrap_or(radius_m);
            let origin = centre - turn * DVec3::Z * (length_m.unwrap_or(0.0) / 2.0);
            let scale = DVec3::new(radius_m, radius_m, length);
            let to_world = DAffine3::from_scale_rotation_translation(scale, turn, origin);
            let mesh = self.scene.meshes.len();
            self.scene.meshes.push(MeshDescription::of_quadric(kind, name.clone(), material).into());
            self.scene.instances.push(InstanceDescription::of_mesh(name, mesh, to_world));
        }
        Ok(())
    }
}

/// A table of a quadric, of whatever kind.
struct Quadric<'a> {
    kind: QuadricKind,
    /// Index among the quadrics of its kind.
    index: usize,
    name: Option<&'a str>,
    material: &'a str,
    position_m: [f64; 3],
    /// Direction of the unit shape's +Z, with its key.
    axis: Option<(&'static str, [f64; 3])>,
    radius_m: f64,
    length_m: Option<f64>,
}

/// All quadrics of a scene: a row for each kind.
fn quadrics(table: &SceneTable) -> impl Iterator<Item = Quadric<'_>> {
    let spheres = table.spheres.iter().enumerate().map(|(index, sphere)| Quadric {
        kind: QuadricKind::Sphere,
        index,
        name: sphere.name.as_deref(),
        material: &sphere.material,
        position_m: sphere.position_m,
        axis: None,
        radius_m: sphere.radius_m,
        length_m: None,
    });
    let disks = table.disks.iter().enumerate().map(|(index, disk)| Quadric {
        kind: QuadricKind::Disk,
        index,
        name: disk.name.as_deref(),
        material: &disk.material,
        position_m: disk.position_m,
        axis: Some(("normal", disk.normal)),
        radius_m: disk.radius_m,
        length_m: None,
    });
    let cylinders = table.cylinders.iter().enumerate().map(|(index, cylinder)| Quadric {
        kind: QuadricKind::Cylinder,
        index,
        name: cylinder.name.as_deref(),
        material: &cylinder.material,
        position_m: cylinder.position_m,
        axis: Some(("axis", cylinder.axis)),
        radius_m: cylinder.radius_m,
        length_m: Some(cylinder.length_m),
    });
    spheres.chain(disks).chain(cylinders)
}

/// The path of a table in the capture file.
fn place(kind: QuadricKind, index: usize) -> String {
    format!("scene.{}s[{index}]", kind.name())
}
