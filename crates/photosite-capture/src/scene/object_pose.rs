//! Pose of an object: its place and rotation.

use glam::{DAffine3, DQuat, DVec3};

use super::super::tables::{ObjectTable, ScaleSource};
use photosite_core::Invalid;
use photosite_transport::scene::description::{look_at, vector};

/// Pose of an object, with its scale apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ObjectPose {
    pub(crate) position: DVec3,
    pub(crate) rotation: DQuat,
    /// Scale along its own axes.
    pub(crate) scale: DVec3,
}

impl ObjectPose {
    pub(crate) fn of(table: &ObjectTable) -> Result<Self, Invalid> {
        let position = vector("position_m", table.position_m.unwrap_or_default())?;
        let rotation = rotation(position, [table.rotation_deg, table.look_at_m], table.quaternion_wxyz)?;
        let scale = match table.scale {
            None => DVec3::ONE,
            Some(ScaleSource::All(scale)) => DVec3::splat(scale),
            Some(ScaleSource::Each(scale)) => DVec3::from_array(scale),
        };
        if !(scale.is_finite() && scale.min_element() > 0.0) {
            let message = format!("must be above 0, got {:?}", scale.to_array());
            return Err(Invalid::new("scale", message).help("1 leaves the size as it is"));
        }
        Ok(Self { position, rotation, scale })
    }

    /// Own axes → world, without the scale.
    pub(crate) fn rigid(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation, self.position)
    }
}

/// Rotation of something at that place, by one key at most of `rotation_deg`, `look_at_m` and `quaternion_wxyz`.
pub(crate) fn rotation(
    position: DVec3,
    [rotation_deg, look_at_m]: [Option<[f64; 3]>; 2],
    quaternion_wxyz: Option<[f64; 4]>,
) -> Result<DQuat, Invalid> {
    let turns = [
        ("rotation_deg", rotation_deg.is_some()),
        ("quaternion_wxyz", quaternion_wxyz.is_some()),
        ("look_at_m", look_at_m.is_some()),
    ];
    let mut given = turns.iter().filter(|(_, is_given)| *is_given);
    if let (Some((first, _)), Some((second, _))) = (given.next(), given.next()) {
        return Err(Invalid::new(*second, format!("cannot be combined with {first}")).help("keep one of them"));
    }
    if let Some(angles) = rotation_deg {
        let [x, y, z] = vector("rotation_deg", angles)?.to_array().map(f64::to_radians);
        return Ok(DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x));
    }
    if let Some([w, x, y, z]) = quaternion_wxyz {
        let quaternion = DQuat::from_xyzw(x, y, z, w);
        let length = quaternion.length();
        if !(length.is_finite() && length > 0.0) {
            let message = format!("must not be 0 and must be finite, got {:?}", [w, x, y, z]);
            return Err(Invalid::new("quaternion_wxyz", message).help("write [1, 0, 0, 0] for no rotation"));
        }
        return Ok(quaternion / length);
    }
    let Some(target) = look_at_m else { return Ok(DQuat::IDENTITY) };
    let target = vector("look_at_m", target)?;
    // Turned about: a camera looks along −z, and the front of an object is +z.
    let away = position * 2.0 - target;
    let looking = look_at(position, away, DVec3::Y).ok_or_else(|| {
        let message = "is straight above, below or where the object stands, so which way is up is undefined";
        Invalid::new("look_at_m", message).help("write rotation_deg or quaternion_wxyz instead")
    })?;
    Ok(DQuat::from_mat3(&looking.matrix3))
}
