//! Environment, `scene.environment`: light from infinitely far in all directions.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use toml::value::{Datetime, Offset};

use super::super::tables::spectra::Finder;
use super::super::tables::{EnvironmentSource, EnvironmentTable, SkyTable};
use super::lights::{emission, positive};
use photosite_core::Invalid;
use photosite_core::spectrum::illuminant;
use photosite_core::warnings::Warnings;
use photosite_scene_io::{EnvironmentFile, read_environment};
use photosite_transport::light::{EnvironmentImage, SkyConditions, SunPosition};
use photosite_transport::scene::description::{Colour, EmissionDescription, EnvironmentDescription, ImageLevel};
use photosite_transport::texture::{Bitmap, Texels};

/// The environment of the same light everywhere.
pub(crate) const EVEN: &str = "even";
/// Illuminance of an even environment, lux: a bright room.
const EVEN_ILLUMINANCE_LUX: f64 = 500.0;

/// Reflectance of the ground that a sky sees, where nothing states it: that of soil and grass.
pub(crate) const DEFAULT_GROUND_ALBEDO: f64 = 0.2;

/// Largest luminance of environment maps, cd/m², a million times that of the sun's disc. In 1 ms behind f/1 it frees
/// 3·10¹⁷ electrons in a pixel of 10 µm, whose square, as in a variance, is far from the largest 32-bit float.
const BRIGHTEST_NIT: f64 = 1e15;

/// Describes `scene.environment`.
pub(crate) fn describe_environment(
    finder: &Finder<'_>,
    source: &EnvironmentSource,
    warnings: &mut Warnings,
) -> Result<Option<EnvironmentDescription>, Invalid> {
    match source {
        EnvironmentSource::Name(name) => match &**name {
            "none" => Ok(None),
            EVEN => Ok(Some(even())),
            _ => Err(Invalid::new("", format!("unknown environment {name:?}"))
                .help("write \"none\", \"even\" or a table such as { illuminant = \"D65\", illuminance_lux = 500 }")),
        },
        EnvironmentSource::Table(table) => match (&table.sky, &table.image) {
            (Some(conditions), _) => {
                if let Some((key, _)) = table.beside_sky().into_iter().find(|(_, is_given)| *is_given) {
                    let message = "cannot be combined with sky, whose light has a colour and a level of its own";
                    return Err(Invalid::new(key, message).help("remove one of them"));
                }
                sky(conditions).map(EnvironmentDescription::Sky).map(Some).map_err(|invalid| invalid.within("sky"))
            }
            (None, Some(image)) => environment_image(finder, table, image, warnings).map(Some),
            (None, None) => constant(finder, table).map(Some),
        },
    }
}

/// D65 from everywhere.
fn even() -> EnvironmentDescription {
    // A plane that looks into the same luminance L everywhere receives E = πL.
    let luminance_nit = Some(EVEN_ILLUMINANCE_LUX / PI);
    EnvironmentDescription::Constant { colour: Colour::Spectrum(illuminant::d65().clone()), luminance_nit }
}

fn constant(finder: &Finder<'_>, table: &EnvironmentTable) -> Result<EnvironmentDescription, Invalid> {
    for (key, is_given) in
        [("rotation_deg", table.rotation_deg.is_some()), ("nit_per_unit", table.nit_per_unit.is_some())]
    {
        if is_given {
            return Err(Invalid::new(key, "only applies with an image").help("remove it, or give image = \"sky.hdr\""));
        }
    }
    // A plane that looks into the same luminance L everywhere receives E = πL.
    let level = match (table.luminance_nit, table.illuminance_lux) {
        (Some(_), Some(_)) => {
            return Err(
                Invalid::new("illuminance_lux", "cannot be combined with luminance_nit").help("keep one of them")
            );
        }
        (Some(nit), None) => Some(("luminance_nit", nit)),
        (None, Some(lux)) => Some(("illuminance_lux", lux / PI)),
        (None, None) => None,
    };
    let EmissionDescription { colour, level, .. } = emission(finder, table.colour(), level, "illuminance_lux")?;
    Ok(EnvironmentDescription::Constant { colour, luminance_nit: level })
}

fn environment_image(
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
            return Err(Invalid::new(key, "cannot be combined with image")
                .help("an image has colours of its own; remove one of them"));
        }
    }
    let level = match (table.nit_per_unit, table.illuminance_lux) {
        (Some(_), Some(_)) => {
            return Err(
                Invalid::new("illuminance_lux", "cannot be combined with nit_per_unit").help("keep one of them")
            );
        }
        (Some(nit), None) => ImageLevel::NitPerUnit(positive("nit_per_unit", nit)?),
        (None, Some(lux)) => ImageLevel::HorizontalLux(positive("illuminance_lux", lux)?),
        (None, None) => {
            let help = "write illuminance_lux = 10000 for an overcast day, or nit_per_unit if the image is calibrated";
            return Err(Invalid::new("", "does not say how bright the image is").help(help));
        }
    };
    let rotation_deg = table.rotation_deg.unwrap_or(0.0);
    if !rotation_deg.is_finite() {
        return Err(Invalid::new("rotation_deg", format!("must be finite, got {rotation_deg}")));
    }
    let file = finder.path(image).and_then(|path| read_environment(&path, warnings));
    let EnvironmentFile { bitmap, white_luminance_nit } = file.map_err(|invalid| invalid.within("image"))?;
    if let ImageLevel::NitPerUnit(nit) = level {
        refuse_overflow(&bitmap, nit).map_err(|invalid| invalid.within("image"))?;
        if let Some(white) = white_luminance_nit.filter(|white| ((white - nit) / nit).abs() > 1e-6) {
            let name = &bitmap.name;
            warnings.once(format!("{name}: its whiteLuminance is {white} cd/m², and nit_per_unit, {nit}, is used"));
        }
    }
    if let (ImageLevel::HorizontalLux(lux), Some(white)) = (level, white_luminance_nit) {
        let name = &bitmap.name;
        warnings.once(format!(
            "{name}: its whiteLuminance, {white} cd/m², has no effect: illuminance_lux, {lux}, is the level; \
             nit_per_unit = {white} would follow it"
        ));
    }
    let image = Arc::new(bitmap);
    if matches!(level, ImageLevel::HorizontalLux(_)) && EnvironmentImage::luminous_integrals(&image).1 <= 0.0 {
        let message = "cannot be reached: all light of the image comes from below the horizon";
        return Err(Invalid::new("illuminance_lux", message).help("give nit_per_unit, what a value of 1 means"));
    }
    Ok(EnvironmentDescription::Image { image, level, rotation_deg })
}

/// Refuses an environment map that has a texel brighter than [`BRIGHTEST_NIT`], where 1 stands for `nit_per_unit`
/// cd/m².
fn refuse_overflow(image: &Bitmap, nit_per_unit: f64) -> Result<(), Invalid> {
    let Texels::Rgb32F(texels) = &image.texels else { return Ok(()) };
    let too_bright = |texel: &[f32; 3]| texel.iter().any(|&value| f64::from(value) * nit_per_unit > BRIGHTEST_NIT);
    let Some(i) = texels.iter().position(too_bright) else { return Ok(()) };
    let (name, x, y) = (&image.name, i % image.width, i / image.width);
    let message = format!(
        "{name}: the texel in column {x}, row {y}, {:?}, is brighter than {BRIGHTEST_NIT:e} cd/m² at {nit_per_unit} \
         cd/m² for 1",
        texels[i]
    );
    Err(Invalid::new("", message).help("correct the image or nit_per_unit; the disc of the sun has 1.6e9 cd/m²"))
}

fn sky(table: &SkyTable) -> Result<SkyConditions, Invalid> {
    let [elevation, azimuth] = match (&table.date_time, table.sun_elevation_deg) {
        (Some(_), None) if table.sun_azimuth_deg.is_none() => sun_by_date(table)?,
        (Some(_), _) => {
            let key = if table.sun_elevation_deg.is_some() { "sun_elevation_deg" } else { "sun_azimuth_deg" };
            return Err(Invalid::new(key, "cannot be combined with date_time, which says where the sun is")
                .help("remove one of them"));
        }
        (None, Some(elevation)) => {
            for (key, is_given) in
                [("latitude_deg", table.latitude_deg.is_some()), ("longitude_deg", table.longitude_deg.is_some())]
            {
                if is_given {
                    return Err(Invalid::new(key, "only applies with date_time").help("remove it, or give date_time"));
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
        ground_albedo: within("ground_albedo", table.ground_albedo.unwrap_or(DEFAULT_GROUND_ALBEDO), [0.0, 1.0])?,
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
        return Err(Invalid::new("date_time", message).help("the sky model only covers daytime; choose another hour"));
    }
    Ok([elevation, sun.azimuth_deg])
}

/// Days from noon of 1 January 2000, UT, to a date and time with an offset.
fn days_after_2000(text: &str) -> Result<f64, Invalid> {
    let bad = |what: &str| {
        let message = format!("{text:?} {what}");
        Err(Invalid::new("", message).help("for example 2026-06-21T12:00:00+02:00, or …Z for Universal Time"))
    };
    let Ok(Datetime { date, time, offset }) = text.parse::<Datetime>() else { return bad("is not a date and time") };
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
