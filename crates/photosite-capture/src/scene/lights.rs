//! Lights without a surface, `[[lights]]`.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::super::tables::spectra::{Finder, LightSpectrum};
use super::super::tables::{
    DirectionalTable, GaussianBeamTable, LightColour, LightTable, PointTable, ProfileTable, ProjectorTable, SpotTable,
};
use photosite_core::Invalid;
use photosite_core::spectrum::cie;
use photosite_core::suggest::{did_you_mean, list};
use photosite_scene_io::read_bitmap;
use photosite_scene_io::read_ies;
use photosite_transport::light::{DirectionalLight, GaussianBeam, LightKind, PointLight, Projector, SpotLight};
use photosite_transport::scene::description::{
    CameraDescription, Colour, EmissionDescription, LightDescription, SceneDescription, look_at, looking, vector,
};
use photosite_transport::scene::emission_spectrum;

/// Adds all `[[lights]]` to a scene, whose own ones they may replace.
pub(crate) fn describe_lights(
    tables: &[LightTable],
    finder: &Finder<'_>,
    scene: &mut SceneDescription,
) -> Result<(), Invalid> {
    let mut replaced = Vec::new();
    let mut describe = |(i, table): (usize, &LightTable)| {
        let path = format!("lights[{i}]");
        let light = match table {
            LightTable::Point(table) => point(finder, table),
            LightTable::Spot(table) => spot(finder, table),
            LightTable::Directional(table) => directional(finder, table),
            LightTable::Profile(table) => {
                replaced.extend(table.gltf_light.clone());
                profile(finder, table, &scene.lights)
            }
            LightTable::Projector(table) => projector(finder, table, &scene.cameras),
            LightTable::GaussianBeam(table) => gaussian_beam(finder, table),
        };
        let light = light.map_err(|invalid| invalid.within(&path))?;
        Ok(LightDescription { name: table.name().map_or(path, str::to_owned), ..light })
    };
    // Lights that are off are checked all the same.
    let lights: Vec<_> = tables.iter().enumerate().map(&mut describe).collect::<Result<_, Invalid>>()?;
    scene.lights.retain(|light| !replaced.contains(&light.name));
    scene.lights.extend(lights.into_iter().zip(tables).filter(|(_, table)| table.is_on()).map(|(light, _)| light));
    Ok(())
}

fn profile(
    finder: &Finder<'_>,
    table: &ProfileTable,
    lights: &[LightDescription],
) -> Result<LightDescription, Invalid> {
    let path = finder.path(&table.file).map_err(|invalid| invalid.within("file"))?;
    let measured = read_ies(&path).map_err(|error| Invalid::new("file", error.to_string()))?;
    let direction = match (table.direction, table.look_at_m, table.position_m) {
        (Some(_), Some(_), _) => {
            return Err(Invalid::new("look_at_m", "cannot be combined with direction").help("keep one of them"));
        }
        (Some(direction), None, _) => Some(("direction", vector("direction", direction)?)),
        (None, Some(target), Some(position)) => {
            Some(("look_at_m", vector("look_at_m", target)? - vector("position_m", position)?))
        }
        (None, Some(_), None) => return Err(Invalid::new("look_at_m", "needs position_m")),
        (None, None, _) => None,
    };
    let (to_world, later) = match (table.position_m, &table.gltf_light) {
        (Some(position), None) => {
            let (key, direction) = direction.unwrap_or(("direction", DVec3::NEG_Y));
            (shining_along(key, vector("position_m", position)?, direction)?, Vec::new())
        }
        (None, Some(name)) => {
            if let Some((key, _)) = direction {
                return Err(Invalid::new(key, "cannot be combined with gltf_light").help("remove one of them"));
            }
            let light = named("gltf_light", "light", name, lights, |light| &light.name)?;
            (light.to_world, light.later.clone())
        }
        (Some(_), Some(_)) => {
            return Err(Invalid::new("position_m", "cannot be combined with gltf_light").help("remove one of them"));
        }
        (None, None) => return Err(Invalid::new("", "needs position_m or gltf_light")),
    };
    let turn = DAffine3::from_rotation_z(-table.rotation_deg.unwrap_or(0.0).to_radians());
    let scale = match table.flux_lm {
        None => 1.0,
        Some(flux_lm) => {
            let flux_of_file = measured.flux_lm();
            if flux_of_file <= 0.0 {
                return Err(Invalid::new("flux_lm", "cannot be reached: the file's lamp is dark"));
            }
            not_negative("flux_lm", flux_lm)? / flux_of_file
        }
    };
    Ok(LightDescription {
        to_world: to_world * turn,
        later: later.into_iter().map(|place| place * turn).collect(),
        kind: LightKind::Profile(measured),
        emission: emission(finder, table.colour(), Some(("flux_lm", scale)), "flux_lm")?,
        name: String::new(),
    })
}

fn projector(
    finder: &Finder<'_>,
    table: &ProjectorTable,
    cameras: &[CameraDescription],
) -> Result<LightDescription, Invalid> {
    let slide =
        finder.path(&table.image).and_then(|path| read_bitmap(&path)).map_err(|invalid| invalid.within("image"))?;
    let [width, height] = [slide.width, slide.height].map(|n| n as f64);
    let of_file = match &table.gltf_camera {
        None => None,
        Some(name) => Some(named("gltf_camera", "camera", name, cameras, |camera| &camera.name)?),
    };
    let (to_world, later) = match (of_file, table.position_m, table.look_at_m) {
        (Some(camera), None, None) => (camera.to_world, camera.later.clone()),
        (Some(_), _, _) => {
            return Err(
                Invalid::new("gltf_camera", "cannot be combined with position_m or look_at_m").help("remove them")
            );
        }
        (None, Some(position), Some(target)) => (looking(position, target, table.up)?, Vec::new()),
        (None, _, _) => {
            return Err(Invalid::new("", "needs position_m and look_at_m, or gltf_camera"));
        }
    };
    let [fx, fy] = match (table.focal_length_px, table.horizontal_fov_deg, of_file) {
        (Some([fx, fy]), None, _) => [positive("focal_length_px", fx)?, positive("focal_length_px", fy)?],
        (None, Some(angle), _) if angle > 0.0 && angle < 180.0 => [width / 2.0 / (angle.to_radians() / 2.0).tan(); 2],
        (None, Some(angle), _) => {
            return Err(Invalid::new("horizontal_fov_deg", format!("must lie between 0 and 180, got {angle}")));
        }
        (None, None, Some(camera)) => [height / 2.0 / (camera.vertical_fov_rad / 2.0).tan(); 2],
        (Some(_), Some(_), _) => {
            let invalid = Invalid::new("focal_length_px", "cannot be combined with horizontal_fov_deg");
            return Err(invalid.help("keep one of them"));
        }
        (None, None, None) => {
            return Err(
                Invalid::new("", "does not say how wide the image is").help("for example horizontal_fov_deg = 40")
            );
        }
    };
    let [cx, cy] = table.principal_point_px.unwrap_or([width / 2.0, height / 2.0]);
    if !(cx.is_finite() && cy.is_finite()) {
        return Err(Invalid::new("principal_point_px", format!("must be finite, got [{cx}, {cy}]")));
    }
    let radius_m = not_negative("aperture_mm", table.aperture_mm.unwrap_or(0.0))? / 2e3;
    let focus_distance_m = match table.focus_distance_m {
        Some(distance) => positive("focus_distance_m", distance)?,
        None if radius_m == 0.0 => 1.0,
        None => {
            return Err(Invalid::new("aperture_mm", "needs focus_distance_m, where the image is sharp")
                .help("for example focus_distance_m = 2.0"));
        }
    };
    let shift = [(width / 2.0 - cx) / fx, (cy - height / 2.0) / fy];
    let projector = Projector::new(Arc::new(slide), [width / fx, height / fy], shift, radius_m, focus_distance_m);
    Ok(LightDescription {
        to_world,
        later,
        kind: LightKind::Projector(projector),
        emission: flux(finder, table.colour(), table.flux_lm, table.power_w)?,
        name: String::new(),
    })
}

/// Item of that name.
fn named<'a, T>(
    key: &str,
    kind: &str,
    name: &str,
    all: &'a [T],
    name_of: impl Fn(&T) -> &String,
) -> Result<&'a T, Invalid> {
    let names: Vec<&str> = all.iter().map(|one| name_of(one).as_str()).collect();
    match names.iter().position(|known| *known == name) {
        Some(index) => Ok(&all[index]),
        None => {
            let message = format!("the geometry has no {kind} {name:?}{}", did_you_mean(name, names.iter().copied()));
            let help = if names.is_empty() {
                format!("it has no {kind}s")
            } else {
                format!("its {kind}s are {}", list(name, names.iter().copied()))
            };
            Err(Invalid::new(key, message).help(help))
        }
    }
}

fn point(finder: &Finder<'_>, table: &PointTable) -> Result<LightDescription, Invalid> {
    let position = vector("position_m", table.position_m)?;
    Ok(LightDescription {
        to_world: DAffine3::from_translation(position),
        kind: LightKind::Point(PointLight),
        emission: emission(finder, table.colour(), Some(("intensity_cd", table.intensity_cd)), "intensity_cd")?,
        name: String::new(),
        later: Vec::new(),
    })
}

fn spot(finder: &Finder<'_>, table: &SpotTable) -> Result<LightDescription, Invalid> {
    let position = vector("position_m", table.position_m)?;
    let (key, direction) = aim(position, table.direction, table.look_at_m)?;
    let (inner, outer) = (table.inner_angle_deg.unwrap_or(0.0), table.outer_angle_deg);
    if !(0.0 <= inner && inner < outer && outer <= 90.0) {
        let message = format!("inner_angle_deg {inner} and outer_angle_deg {outer} do not rise from 0 to 90");
        let help = "angles are measured from the axis: 0 ≤ inner < outer ≤ 90";
        return Err(Invalid::new("outer_angle_deg", message).help(help));
    }
    Ok(LightDescription {
        to_world: shining_along(key, position, direction)?,
        kind: LightKind::Spot(SpotLight::new(inner.to_radians() as f32, outer.to_radians() as f32)),
        emission: emission(finder, table.colour(), Some(("intensity_cd", table.intensity_cd)), "intensity_cd")?,
        name: String::new(),
        later: Vec::new(),
    })
}

fn directional(finder: &Finder<'_>, table: &DirectionalTable) -> Result<LightDescription, Invalid> {
    let level = Some(("illuminance_lux", table.illuminance_lux));
    Ok(LightDescription {
        to_world: shining_along("direction", DVec3::ZERO, vector("direction", table.direction)?)?,
        kind: LightKind::Directional(DirectionalLight),
        emission: emission(finder, table.colour(), level, "illuminance_lux")?,
        name: String::new(),
        later: Vec::new(),
    })
}

fn gaussian_beam(finder: &Finder<'_>, table: &GaussianBeamTable) -> Result<LightDescription, Invalid> {
    let position = vector("position_m", table.position_m)?;
    let (key, direction) = aim(position, table.direction, table.look_at_m)?;
    let rotation_deg = table.rotation_deg.unwrap_or(0.0);
    if !rotation_deg.is_finite() {
        return Err(Invalid::new("rotation_deg", format!("must be finite, got {rotation_deg}")));
    }
    let waists_mm = table.waist_radius_mm;
    let divergences_deg = table.divergence_deg.unwrap_or([0.0; 2]);
    for (waist_mm, divergence_deg) in waists_mm.into_iter().zip(divergences_deg) {
        not_negative("waist_radius_mm", waist_mm)?;
        if !(0.0..90.0).contains(&divergence_deg) {
            let message = format!("must lie between 0 and 90, got {divergence_deg}");
            return Err(Invalid::new("divergence_deg", message));
        }
        if waist_mm == 0.0 && divergence_deg == 0.0 {
            let message = "is 0 along an axis along which divergence_deg is 0 too, where the beam would have no width";
            return Err(Invalid::new("waist_radius_mm", message).help("for example waist_radius_mm = [0.5, 0.5]"));
        }
    }
    let turn = DAffine3::from_rotation_z(-rotation_deg.to_radians());
    let waists_m = waists_mm.map(|mm| mm * 1e-3);
    Ok(LightDescription {
        to_world: shining_along(key, position, direction)? * turn,
        kind: LightKind::GaussianBeam(GaussianBeam::new(waists_m, divergences_deg.map(f64::to_radians))),
        emission: flux(finder, table.colour(), table.flux_lm, table.power_w)?,
        name: String::new(),
        later: Vec::new(),
    })
}

/// The emission of a light whose flux is photometric or radiant.
fn flux(
    finder: &Finder<'_>,
    colour: LightColour<'_>,
    flux_lm: Option<f64>,
    power_w: Option<f64>,
) -> Result<EmissionDescription, Invalid> {
    match (flux_lm, power_w) {
        (Some(flux_lm), None) => emission(finder, colour, Some(("flux_lm", flux_lm)), "flux_lm"),
        (None, Some(power_w)) => {
            let LightSpectrum { colour, .. } = finder.light(colour)?;
            let shape = emission_spectrum(&colour, matches!(colour, Colour::Rgb(_)).then_some(1.0));
            let per_watt = shape.integral();
            if per_watt <= 0.0 {
                return Err(Invalid::new("power_w", "cannot be reached: the spectrum of the light is black"));
            }
            let colour = Colour::Spectrum(shape.scale(not_negative("power_w", power_w)? / per_watt));
            Ok(EmissionDescription { colour, level: None, texture: None })
        }
        (Some(_), Some(_)) => Err(Invalid::new("power_w", "cannot be combined with flux_lm").help("keep one of them")),
        (None, None) => Err(Invalid::new("", "needs flux_lm or power_w").help("for example power_w = 0.001")),
    }
}

/// The direction of a light by either of two keys, and that key.
fn aim(
    position: DVec3,
    direction: Option<[f64; 3]>,
    look_at_m: Option<[f64; 3]>,
) -> Result<(&'static str, DVec3), Invalid> {
    match (direction, look_at_m) {
        (Some(direction), None) => Ok(("direction", vector("direction", direction)?)),
        (None, Some(target)) => Ok(("look_at_m", vector("look_at_m", target)? - position)),
        (Some(_), Some(_)) => {
            Err(Invalid::new("look_at_m", "cannot be combined with direction").help("keep one of them"))
        }
        (None, None) => {
            Err(Invalid::new("", "needs look_at_m or direction").help("for example direction = [0, -1, 0]"))
        }
    }
}

/// Transform of a node at `position` whose −Z points along `direction`. `key` names what gives the direction.
fn shining_along(key: &str, position: DVec3, direction: DVec3) -> Result<DAffine3, Invalid> {
    let up = if direction.x.abs() + direction.z.abs() > 1e-9 * direction.y.abs() { DVec3::Y } else { DVec3::Z };
    look_at(position, position + direction.normalize_or_zero(), up)
        .ok_or_else(|| Invalid::new(key, "gives no direction").help("for example direction = [0, -1, 0]"))
}

/// The emission of a light or surface. `level` is the key and value of its photometric level, `level_key` the key to
/// name where it is missing.
pub(crate) fn emission(
    finder: &Finder<'_>,
    colour: LightColour<'_>,
    level: Option<(&str, f64)>,
    level_key: &str,
) -> Result<EmissionDescription, Invalid> {
    let LightSpectrum { colour, is_absolute } = finder.light(colour)?;
    let level = match level {
        Some((key, level)) => Some(level_in_scene(&colour, key, level)?),
        None if is_absolute => None,
        None => {
            let message = "says only the colour of the light, not how much there is";
            return Err(Invalid::new("", message).help(format!("for example {level_key} = 100")));
        }
    };
    Ok(EmissionDescription { colour, level, texture: None })
}

/// The level that a scene needs for light of the colour to have `level` itself. Scenes state RGB colours as parts of
/// white, as glTF does; the level of a capture file is that of the light, whatever its colour.
fn level_in_scene(colour: &Colour, key: &str, level: f64) -> Result<f64, Invalid> {
    let level = not_negative(key, level)?;
    let luminous = match colour {
        Colour::Spectrum(spectrum) => cie::luminous(spectrum),
        Colour::Rgb(_) => cie::luminous(&emission_spectrum(colour, Some(1.0))),
    };
    if level > 0.0 && luminous <= 0.0 {
        let message = "cannot be reached: the eye sees nothing of light of this colour";
        return Err(Invalid::new(key, message).help(
            "give another colour; infrared is stated in watts, as the absolute spectrum of a file or by power_w",
        ));
    }
    Ok(match colour {
        Colour::Rgb(_) if level > 0.0 => level / luminous,
        Colour::Rgb(_) | Colour::Spectrum(_) => level,
    })
}

fn not_negative(key: &str, value: f64) -> Result<f64, Invalid> {
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must not be negative, got {value}")))
}

pub(crate) fn positive(key: &str, value: f64) -> Result<f64, Invalid> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must be above 0, got {value}")))
}
