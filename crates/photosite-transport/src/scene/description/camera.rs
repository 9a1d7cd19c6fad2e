//! Cameras as files describe them.

use glam::{DAffine3, DVec3};

use photosite_core::Invalid;

/// A camera of a scene file. The lens and sensor may override its field of view.
#[derive(Clone, Debug)]
pub struct CameraDescription {
    /// Name that `gltf_camera` refers to.
    pub name: String,
    /// Camera → world; looks along −Z, +Y up.
    pub to_world: DAffine3,
    /// Transforms camera → world at the evenly spaced times that follow in the time of the image, where the camera
    /// moves.
    pub later: Vec<DAffine3>,
    /// Full vertical field of view, rad.
    pub vertical_fov_rad: f64,
}

/// Pose of a camera that stands at `position` and looks at `target`, as rotation and translation.
pub fn look_at(position: DVec3, target: DVec3, up: DVec3) -> Option<DAffine3> {
    let z = (position - target).try_normalize()?;
    let x = up.cross(z).try_normalize()?;
    Some(DAffine3::from_cols(x, z.cross(x), z, position))
}

/// Pose of a camera, checked as a user wrote it. Keys of errors are `position_m`, `look_at_m` and `up`.
pub fn looking(position: [f64; 3], target: [f64; 3], up: Option<[f64; 3]>) -> Result<DAffine3, Invalid> {
    let position = vector("position_m", position)?;
    let target = vector("look_at_m", target)?;
    let up = vector("up", up.unwrap_or([0.0, 1.0, 0.0]))?;
    if position == target {
        let message = "is where the camera stands, so it looks nowhere";
        return Err(Invalid::new("look_at_m", message).help("write a point in front of the camera"));
    }
    look_at(position, target, up).ok_or_else(|| {
        let message = format!("the camera looks along {up}, so that cannot be up in the image");
        Invalid::new("up", message).help("write a direction across the view, for example up = [0, 0, -1]")
    })
}

/// Checks that three coordinates are finite.
pub fn vector(key: &str, v: [f64; 3]) -> Result<DVec3, Invalid> {
    let vector = DVec3::from_array(v);
    if vector.is_finite() { Ok(vector) } else { Err(Invalid::new(key, format!("must be finite, got {v:?}"))) }
}
