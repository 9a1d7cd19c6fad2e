//! `[[lights]]` and `scene.environment`: light that comes from no surface.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::colour::{Finder, LightSpectrum};
use super::tables::{
    DirectionalTable, EnvironmentSource, EnvironmentTable, LightColour, LightTable, PointTable, SpotTable,
};
use crate::Invalid;
use crate::io::environment::read_environment;
use crate::io::warnings::Warnings;
use crate::light::EnvironmentPicture;
use crate::scene::description::{
    EmissionDescription, EnvironmentDescription, LightDescription, LightKind, PictureLevel, look_at,
};

/// Describes all `[[lights]]`.
pub(super) fn describe_lights(tables: &[LightTable], finder: &Finder<'_>) -> Result<Vec<LightDescription>, Invalid> {
    let describe = |(i, table): (usize, &LightTable)| {
        let path = format!("lights[{i}]");
        let (name, light) = match table {
            LightTable::Point(table) => (&table.name, point(finder, table)),
            LightTable::Spot(table) => (&table.name, spot(finder, table)),
            LightTable::Directional(table) => (&table.name, directional(finder, table)),
        };
        let light = light.map_err(|invalid| invalid.within(&path))?;
        Ok(LightDescription { name: name.clone().unwrap_or(path), ..light })
    };
    tables.iter().enumerate().map(describe).collect()
}

fn point(finder: &Finder<'_>, table: &PointTable) -> Result<LightDescription, Invalid> {
    let position = vector("position_m", table.position_m)?;
    Ok(LightDescription {
        to_world: DAffine3::from_translation(position),
        kind: LightKind::Point,
        emission: emission(finder, table.colour(), Some(("intensity_cd", table.intensity_cd)), "intensity_cd")?,
        name: String::new(),
        later: Vec::new(),
    })
}

fn spot(finder: &Finder<'_>, table: &SpotTable) -> Result<LightDescription, Invalid> {
    let position = vector("position_m", table.position_m)?;
    let (key, direction) = match (table.direction, table.look_at_m) {
        (Some(direction), None) => ("direction", vector("direction", direction)?),
        (None, Some(target)) => ("look_at_m", vector("look_at_m", target)? - position),
        (Some(_), Some(_)) => {
            return Err(Invalid::new("look_at_m", "cannot go with direction").help("keep one of them"));
        }
        (None, None) => {
            return Err(Invalid::new("", "needs look_at_m or direction").help("for example direction = [0, -1, 0]"));
        }
    };
    let (inner, outer) = (table.inner_angle_deg.unwrap_or(0.0), table.outer_angle_deg);
    if !(0.0 <= inner && inner < outer && outer <= 90.0) {
        let message = format!("inner_angle_deg {inner} and outer_angle_deg {outer} do not rise from 0 to 90");
        let help = "angles are measured from the axis: 0 ≤ inner < outer ≤ 90";
        return Err(Invalid::new("outer_angle_deg", message).help(help));
    }
    Ok(LightDescription {
        to_world: shining_along(key, position, direction)?,
        kind: LightKind::Spot { inner_rad: inner.to_radians() as f32, outer_rad: outer.to_radians() as f32 },
        emission: emission(finder, table.colour(), Some(("intensity_cd", table.intensity_cd)), "intensity_cd")?,
        name: String::new(),
        later: Vec::new(),
    })
}

fn directional(finder: &Finder<'_>, table: &DirectionalTable) -> Result<LightDescription, Invalid> {
    let level = Some(("illuminance_lux", table.illuminance_lux));
    Ok(LightDescription {
        to_world: shining_along("direction", DVec3::ZERO, vector("direction", table.direction)?)?,
        kind: LightKind::Directional,
        emission: emission(finder, table.colour(), level, "illuminance_lux")?,
        name: String::new(),
        later: Vec::new(),
    })
}

/// A node at `position` whose −Z points along `direction`. `key` names what gives the direction.
fn shining_along(key: &str, position: DVec3, direction: DVec3) -> Result<DAffine3, Invalid> {
    let up = if direction.x.abs() + direction.z.abs() > 1e-9 * direction.y.abs() { DVec3::Y } else { DVec3::Z };
    look_at(position, position + direction.normalize_or_zero(), up)
        .ok_or_else(|| Invalid::new(key, "gives no direction").help("for example direction = [0, -1, 0]"))
}

/// The emission of a light or surface. `level` is the key and value of its photometric level, `level_key` the key to
/// name where it is missing.
pub(super) fn emission(
    finder: &Finder<'_>,
    colour: LightColour<'_>,
    level: Option<(&str, f64)>,
    level_key: &str,
) -> Result<EmissionDescription, Invalid> {
    let LightSpectrum { colour, is_absolute } = finder.light(colour)?;
    let level = match level {
        Some((key, level)) => Some(not_negative(key, level)?),
        None if is_absolute => None,
        None => {
            let message = "says only the colour of the light, not how much there is";
            return Err(Invalid::new("", message).help(format!("for example {level_key} = 100")));
        }
    };
    Ok(EmissionDescription { colour, level, texture: None })
}

/// Describes `scene.environment`.
pub(super) fn describe_environment(
    finder: &Finder<'_>,
    source: &EnvironmentSource,
    warnings: &mut Warnings,
) -> Result<Option<EnvironmentDescription>, Invalid> {
    match source {
        EnvironmentSource::Name(name) if name == "none" => Ok(None),
        EnvironmentSource::Name(name) => Err(Invalid::new("", format!("unknown environment {name:?}"))
            .help("write \"none\" or a table such as { illuminant = \"D65\", illuminance_lux = 500 }")),
        EnvironmentSource::Table(table) => match &table.image {
            Some(image) => picture(finder, table, image, warnings).map(Some),
            None => constant(finder, table).map(Some),
        },
    }
}

fn constant(finder: &Finder<'_>, table: &EnvironmentTable) -> Result<EnvironmentDescription, Invalid> {
    for (key, is_given) in
        [("rotation_deg", table.rotation_deg.is_some()), ("nit_per_unit", table.nit_per_unit.is_some())]
    {
        if is_given {
            return Err(Invalid::new(key, "goes only with an image").help("remove it, or give image = \"sky.hdr\""));
        }
    }
    // A plane that looks into the same luminance L everywhere receives E = πL.
    let level = match (table.luminance_nit, table.illuminance_lux) {
        (Some(_), Some(_)) => {
            return Err(Invalid::new("illuminance_lux", "cannot go with luminance_nit").help("keep one of them"));
        }
        (Some(nit), None) => Some(("luminance_nit", nit)),
        (None, Some(lux)) => Some(("illuminance_lux", lux / PI)),
        (None, None) => None,
    };
    let EmissionDescription { colour, level, .. } = emission(finder, table.colour(), level, "illuminance_lux")?;
    Ok(EnvironmentDescription::Constant { colour, luminance_nit: level })
}

fn picture(
    finder: &Finder<'_>,
    table: &EnvironmentTable,
    image: &str,
    warnings: &mut Warnings,
) -> Result<EnvironmentDescription, Invalid> {
    for (key, is_given) in [
        ("illuminant", table.illuminant.is_some()),
        ("spectrum", table.spectrum.is_some()),
        ("rgb", table.rgb.is_some()),
        ("linear_rgb", table.linear_rgb.is_some()),
        ("luminance_nit", table.luminance_nit.is_some()),
    ] {
        if is_given {
            return Err(
                Invalid::new(key, "cannot go with image").help("a picture has colours of its own; remove one of them")
            );
        }
    }
    let level = match (table.nit_per_unit, table.illuminance_lux) {
        (Some(_), Some(_)) => {
            return Err(Invalid::new("illuminance_lux", "cannot go with nit_per_unit").help("keep one of them"));
        }
        (Some(nit), None) => PictureLevel::NitPerUnit(positive("nit_per_unit", nit)?),
        (None, Some(lux)) => PictureLevel::HorizontalLux(positive("illuminance_lux", lux)?),
        (None, None) => {
            let help =
                "write illuminance_lux = 10000 for an overcast day, or nit_per_unit if the picture is calibrated";
            return Err(Invalid::new("", "does not say how bright the picture is").help(help));
        }
    };
    let rotation_deg = table.rotation_deg.unwrap_or(0.0);
    if !rotation_deg.is_finite() {
        return Err(Invalid::new("rotation_deg", format!("must be finite, got {rotation_deg}")));
    }
    let image = Arc::new(read_environment(&finder.path(image), warnings).map_err(|e| e.within("image"))?);
    if matches!(level, PictureLevel::HorizontalLux(_)) && EnvironmentPicture::luminous_integrals(&image).1 <= 0.0 {
        let message = "cannot be reached: all light of the picture comes from below the horizon";
        return Err(Invalid::new("illuminance_lux", message).help("give nit_per_unit, what a value of 1 means"));
    }
    Ok(EnvironmentDescription::Picture { image, level, rotation_deg })
}

/// Three finite coordinates.
pub(super) fn vector(key: &str, v: [f64; 3]) -> Result<DVec3, Invalid> {
    let vector = DVec3::from_array(v);
    if vector.is_finite() { Ok(vector) } else { Err(Invalid::new(key, format!("must be finite, got {v:?}"))) }
}

fn not_negative(key: &str, value: f64) -> Result<f64, Invalid> {
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must not be negative, got {value}")))
}

fn positive(key: &str, value: f64) -> Result<f64, Invalid> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must be above 0, got {value}")))
}
