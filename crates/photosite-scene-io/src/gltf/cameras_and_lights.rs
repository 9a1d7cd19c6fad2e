//! Cameras and KHR_lights_punctual lights at their nodes.

use std::f32::consts::FRAC_PI_2;

use gltf::json::Root;
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;

use super::buffers::out_of_range;
use super::nodes::{PlacedNode, rigid};
use photosite_core::Invalid;
use photosite_core::warnings::Warnings;
use photosite_transport::light::{DirectionalLight, PointLight, SpotLight};
use photosite_transport::scene::description::{
    CameraDescription, Colour, EmissionDescription, LightDescription, LightKind,
};

/// The camera of a node, if it has one of a supported kind.
pub(super) fn read_camera(
    root: &Root,
    placed: &PlacedNode<'_>,
    warnings: &mut Warnings,
) -> Result<Option<CameraDescription>, Invalid> {
    let Some(index) = placed.node.camera else { return Ok(None) };
    let index = index.value();
    let camera = root.cameras.get(index).ok_or_else(|| {
        out_of_range(&format!("nodes[{}].camera", placed.index), "cameras", index, root.cameras.len())
    })?;
    let name = camera.name.clone().unwrap_or_else(|| placed.name.clone());
    let perspective = match (camera.type_, &camera.perspective) {
        (Checked::Valid(CameraType::Perspective), Some(perspective)) => perspective,
        (Checked::Valid(CameraType::Perspective), None) => {
            let invalid = Invalid::new(format!("cameras[{index}]"), "has no perspective, as its type promises");
            return Err(invalid.help("the file is damaged; export it again"));
        }
        (Checked::Valid(CameraType::Orthographic), _) => {
            warnings.once(format!("the camera {name:?} is orthographic, which no lens is, and is left out"));
            return Ok(None);
        }
        (Checked::Invalid, _) => {
            return Err(
                Invalid::new(format!("cameras[{index}].type"), "is unknown").help("write perspective or orthographic")
            );
        }
    };
    let fov = perspective.yfov;
    if !(fov > 0.0 && f64::from(fov) < std::f64::consts::PI) {
        let key = format!("cameras[{index}].perspective.yfov");
        return Err(Invalid::new(key, format!("must lie between 0 and π, got {fov}")));
    }
    Ok(Some(CameraDescription {
        name,
        to_world: rigid(&placed.to_world),
        later: Vec::new(),
        vertical_fov_rad: f64::from(fov),
    }))
}

/// Light of a node, if its intensity is above 0. Intensities are in candela (point and spot) or lux (directional).
pub(super) fn read_light(
    root: &Root,
    placed: &PlacedNode<'_>,
    warnings: &mut Warnings,
) -> Result<Option<LightDescription>, Invalid> {
    let used = placed.node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let Some(index) = used.map(|used| used.light.value()) else { return Ok(None) };
    let lights: &[Light] = root.as_ref();
    let light = lights.get(index).ok_or_else(|| {
        let key = format!("nodes[{}].extensions.KHR_lights_punctual.light", placed.index);
        out_of_range(&key, "lights", index, lights.len())
    })?;
    let key = format!("extensions.KHR_lights_punctual.lights[{index}]");
    let name = light.name.clone().unwrap_or_else(|| placed.name.clone());
    let shining = |v: f32| v.is_finite() && v >= 0.0;
    if !(shining(light.intensity) && light.color.into_iter().all(shining)) {
        let message = format!("intensity {} and colour {:?} must be 0 or above", light.intensity, light.color);
        return Err(Invalid::new(key, message));
    }
    if light.range.is_some() {
        warnings.once("the range of lights is ignored: their light falls off with the square of the distance forever");
    }
    if light.intensity == 0.0 || light.color == [0.0; 3] {
        return Ok(None);
    }
    let emission = EmissionDescription {
        colour: Colour::Rgb(light.color),
        level: Some(f64::from(light.intensity)),
        texture: None,
    };
    Ok(Some(LightDescription {
        name,
        to_world: rigid(&placed.to_world),
        later: Vec::new(),
        kind: light_kind(light, &key)?,
        emission,
    }))
}

fn light_kind(light: &Light, key: &str) -> Result<LightKind, Invalid> {
    match light.type_ {
        Checked::Valid(Type::Point) => Ok(LightKind::Point(PointLight)),
        Checked::Valid(Type::Directional) => Ok(LightKind::Directional(DirectionalLight)),
        Checked::Valid(Type::Spot) => {
            let spot = light.spot.clone().unwrap_or_default();
            // A spot without angles deserialises to zeros; the extension's default is π/4.
            let outer_rad = if light.spot.is_some() { spot.outer_cone_angle } else { std::f32::consts::FRAC_PI_4 };
            let inner_rad = spot.inner_cone_angle;
            // One part in 10⁶ of room for π/2 written with few digits.
            if !(0.0 <= inner_rad && inner_rad < outer_rad && outer_rad <= FRAC_PI_2 * 1.000_001) {
                let message =
                    format!("innerConeAngle {inner_rad} and outerConeAngle {outer_rad} do not rise from 0 to π/2");
                return Err(Invalid::new(format!("{key}.spot"), message)
                    .help("angles are in radians, measured from the axis: 0 ≤ inner < outer ≤ π/2"));
            }
            Ok(LightKind::Spot(SpotLight::new(inner_rad, outer_rad.min(FRAC_PI_2))))
        }
        Checked::Invalid => {
            Err(Invalid::new(format!("{key}.type"), "is unknown").help("write point, spot or directional"))
        }
    }
}
