//! `[[lights]]` and `scene.environment`: light that comes from no surface.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use toml::value::{Datetime, Offset};

use super::colour::{Finder, LightSpectrum};
use super::tables::{
    DirectionalTable, EnvironmentSource, EnvironmentTable, LightColour, LightTable, PointTable, ProfileTable,
    ProjectorTable, SkyTable, SpotTable,
};
use crate::Invalid;
use crate::light::{EnvironmentPicture, SkyConditions, SunPosition};
use crate::scene::description::{
    CameraDescription, EmissionDescription, EnvironmentDescription, LightDescription, LightKind, PictureLevel,
    ProjectorDescription, SceneDescription, look_at, looking, vector,
};
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::warnings::Warnings;
use photosite_scene_io::read_environment;
use photosite_scene_io::read_ies;
use photosite_scene_io::read_picture;

/// Adds all `[[lights]]` to a scene, whose own ones they may replace.
pub(super) fn describe_lights(
    tables: &[LightTable],
    finder: &Finder<'_>,
    scene: &mut SceneDescription,
) -> Result<(), Invalid> {
    let mut replaced = Vec::new();
    let mut describe = |(i, table): (usize, &LightTable)| {
        let path = format!("lights[{i}]");
        let (name, light) = match table {
            LightTable::Point(table) => (&table.name, point(finder, table)),
            LightTable::Spot(table) => (&table.name, spot(finder, table)),
            LightTable::Directional(table) => (&table.name, directional(finder, table)),
            LightTable::Profile(table) => {
                replaced.extend(table.gltf_light.clone());
                (&table.name, profile(finder, table, &scene.lights))
            }
            LightTable::Projector(table) => (&table.name, projector(finder, table, &scene.cameras)),
        };
        let light = light.map_err(|invalid| invalid.within(&path))?;
        Ok(LightDescription { name: name.clone().unwrap_or(path), ..light })
    };
    let lights: Vec<_> = tables.iter().enumerate().map(&mut describe).collect::<Result<_, Invalid>>()?;
    scene.lights.retain(|light| !replaced.contains(&light.name));
    scene.lights.extend(lights);
    Ok(())
}

fn profile(
    finder: &Finder<'_>,
    table: &ProfileTable,
    lights: &[LightDescription],
) -> Result<LightDescription, Invalid> {
    let measured = read_ies(&finder.path(&table.file)).map_err(|error| Invalid::new("file", error.to_string()))?;
    let direction = match (table.direction, table.look_at_m, table.position_m) {
        (Some(_), Some(_), _) => {
            return Err(Invalid::new("look_at_m", "cannot go with direction").help("keep one of them"));
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
                return Err(Invalid::new(key, "cannot go with gltf_light").help("remove one of them"));
            }
            let light = named("gltf_light", "light", name, lights, |light| &light.name)?;
            (light.to_world, light.later.clone())
        }
        (Some(_), Some(_)) => {
            return Err(Invalid::new("position_m", "cannot go with gltf_light").help("remove one of them"));
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
        kind: LightKind::Profile(Arc::new(measured)),
        emission: emission(finder, table.colour(), Some(("flux_lm", scale)), "flux_lm")?,
        name: String::new(),
    })
}

fn projector(
    finder: &Finder<'_>,
    table: &ProjectorTable,
    cameras: &[CameraDescription],
) -> Result<LightDescription, Invalid> {
    let slide = read_picture(&finder.path(&table.image)).map_err(|invalid| invalid.within("image"))?;
    let [width, height] = [slide.width, slide.height].map(|n| n as f64);
    let of_file = match &table.gltf_camera {
        None => None,
        Some(name) => Some(named("gltf_camera", "camera", name, cameras, |camera| &camera.name)?),
    };
    let (to_world, later) = match (of_file, table.position_m, table.look_at_m) {
        (Some(camera), None, None) => (camera.to_world, camera.later.clone()),
        (Some(_), _, _) => {
            return Err(Invalid::new("gltf_camera", "cannot go with position_m or look_at_m").help("remove them"));
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
            let invalid = Invalid::new("focal_length_px", "cannot go with horizontal_fov_deg");
            return Err(invalid.help("keep one of them"));
        }
        (None, None, None) => {
            return Err(
                Invalid::new("", "does not say how wide the picture is").help("for example horizontal_fov_deg = 40")
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
            return Err(Invalid::new("aperture_mm", "needs focus_distance_m, where the picture is sharp")
                .help("for example focus_distance_m = 2.0"));
        }
    };
    let projector = ProjectorDescription {
        slide: Arc::new(slide),
        extent: [width / fx, height / fy],
        shift: [(width / 2.0 - cx) / fx, (cy - height / 2.0) / fy],
        radius_m,
        focus_distance_m,
    };
    Ok(LightDescription {
        to_world,
        later,
        kind: LightKind::Projector(projector),
        emission: emission(finder, table.colour(), Some(("flux_lm", table.flux_lm)), "flux_lm")?,
        name: String::new(),
    })
}

/// The one of that name.
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

fn sky(table: &SkyTable) -> Result<SkyConditions, Invalid> {
    let [elevation, azimuth] = match (&table.date_time, table.sun_elevation_deg) {
        (Some(_), None) if table.sun_azimuth_deg.is_none() => sun_by_date(table)?,
        (Some(_), _) => {
            let key = if table.sun_elevation_deg.is_some() { "sun_elevation_deg" } else { "sun_azimuth_deg" };
            return Err(
                Invalid::new(key, "cannot go with date_time, which says where the sun is").help("remove one of them")
            );
        }
        (None, Some(elevation)) => {
            for (key, is_given) in
                [("latitude_deg", table.latitude_deg.is_some()), ("longitude_deg", table.longitude_deg.is_some())]
            {
                if is_given {
                    return Err(Invalid::new(key, "goes only with date_time").help("remove it, or give date_time"));
                }
            }
            [elevation, table.sun_azimuth_deg.unwrap_or(0.0)]
        }
        (None, None) => {
            return Err(Invalid::new("", "does not say where the sun is")
                .help("write sun_elevation_deg = 40, or date_time, latitude_deg and longitude_deg"));
        }
    };
    let elevation = within("sun_elevation_deg", elevation, [0.0, 90.0])?.to_radians();
    let azimuth = within("sun_azimuth_deg", azimuth, [-360.0, 360.0])?.to_radians();
    let towards_sun = DVec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), -elevation.cos() * azimuth.cos());
    Ok(SkyConditions {
        towards_sun,
        turbidity: within("turbidity", table.turbidity.unwrap_or(3.0), [1.0, 10.0])?,
        ground_albedo: within("ground_albedo", table.ground_albedo.unwrap_or(0.2), [0.0, 1.0])?,
        has_sun: table.sun.unwrap_or(true),
    })
}

fn within(key: &str, value: f64, [low, high]: [f64; 2]) -> Result<f64, Invalid> {
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(Invalid::new(key, format!("must lie between {low} and {high}, got {value}")))
}

/// Elevation and azimuth of the sun, degrees, as seen at the date and place of the table.
fn sun_by_date(table: &SkyTable) -> Result<[f64; 2], Invalid> {
    let text = table.date_time.as_deref().unwrap_or_default();
    let days = days_after_2000(text).map_err(|invalid| invalid.within("date_time"))?;
    let place = |key: &str, value: Option<f64>, limit: f64| match value {
        Some(value) => within(key, value, [-limit, limit]),
        None => Err(Invalid::new("", format!("needs {key} with date_time"))
            .help("for example latitude_deg = 48.1, longitude_deg = 11.6")),
    };
    let latitude = place("latitude_deg", table.latitude_deg, 90.0)?;
    let sun = SunPosition::new(days, latitude, place("longitude_deg", table.longitude_deg, 180.0)?);
    let elevation = sun.apparent_elevation_deg();
    if elevation < 0.0 {
        let message = format!("is at night: the sun is {:.1} degrees below the horizon", -elevation);
        return Err(Invalid::new("date_time", message).help("the model of the sky is one by day; choose another hour"));
    }
    Ok([elevation, sun.azimuth_deg])
}

/// Days from noon of 1 January 2000, UT, to a date and time with an offset.
fn days_after_2000(text: &str) -> Result<f64, Invalid> {
    let bad = |what: &str| {
        let message = format!("{text:?} {what}");
        Err(Invalid::new("", message).help("for example 2026-06-21T12:00:00+02:00, or …Z for Universal Time"))
    };
    let Ok(Datetime { date, time, offset }) = text.parse::<Datetime>() else { return bad("is no date and time") };
    let (Some(date), Some(time)) = (date, time) else { return bad("needs a date and a time") };
    let minutes_east = match offset {
        Some(Offset::Z) => 0,
        Some(Offset::Custom { minutes }) => minutes,
        None => return bad("does not say how far it is from Universal Time"),
    };
    if !(1950..=2050).contains(&date.year) {
        return bad("is not from 1950 to 2050, where the sun's place is known");
    }
    let year = i32::from(date.year);
    let days_of_months = [31, if year % 4 == 0 { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let month = usize::from(date.month) - 1;
    let day_of_year = days_of_months[..month].iter().sum::<i32>() + i32::from(date.day);
    // Leap years since 1948, of which 13 had passed in 2000.
    let midnight = 365 * (year - 2000) + (year - 1949).div_euclid(4) - 12 + day_of_year - 1;
    let minutes = 60.0 * f64::from(time.hour) + f64::from(time.minute) - f64::from(minutes_east);
    let seconds = f64::from(time.second.unwrap_or(0)) + f64::from(time.nanosecond.unwrap_or(0)) * 1e-9;
    Ok(f64::from(midnight) - 0.5 + (minutes + seconds / 60.0) / 1440.0)
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
        EnvironmentSource::Table(table) => match (&table.sky, &table.image) {
            (Some(conditions), _) => {
                if let Some((key, _)) = table.beside_sky().into_iter().find(|(_, is_given)| *is_given) {
                    let message = "cannot go with sky, whose light has a colour and a level of its own";
                    return Err(Invalid::new(key, message).help("remove one of them"));
                }
                sky(conditions).map(EnvironmentDescription::Sky).map(Some).map_err(|invalid| invalid.within("sky"))
            }
            (None, Some(image)) => picture(finder, table, image, warnings).map(Some),
            (None, None) => constant(finder, table).map(Some),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_counted_across_leap_years_and_time_zones() {
        let days = |text: &str| days_after_2000(text).expect(text);
        assert_eq!(days("2000-01-01T12:00:00Z"), 0.0);
        assert_eq!(days("2000-01-01 14:00:00+02:00"), 0.0);
        // Julian dates of Meeus, "Astronomical Algorithms" (1998), chapter 7, less 2 451 545.
        for (text, julian) in [
            ("1999-01-01T00:00:00Z", 2_451_179.5),
            ("1987-01-27T00:00:00Z", 2_446_822.5),
            ("1987-06-19T12:00:00Z", 2_446_966.0),
            ("1988-01-27T00:00:00Z", 2_447_187.5),
            ("1988-06-19T12:00:00Z", 2_447_332.0),
        ] {
            assert_eq!(days(text), julian - 2_451_545.0, "{text}");
        }
        for year in 1950..2050 {
            let length = days(&format!("{}-01-01T00:00:00Z", year + 1)) - days(&format!("{year}-01-01T00:00:00Z"));
            assert_eq!(length, if year % 4 == 0 { 366.0 } else { 365.0 }, "{year}");
        }
        for bad in
            ["noon", "2026-06-21", "12:00:00", "2026-06-21T12:00:00", "2150-06-21T12:00:00Z", "2026-13-01T00:00:00Z"]
        {
            assert!(days_after_2000(bad).is_err(), "{bad}");
        }
    }
}
