//! `[lens]`: from the table to a [`LensDescription`].

use std::f64::consts::{PI, TAU};

use super::aberrations::{lateral_colour, point_spread, stops};
use super::colour::Finder;
use super::projection::projection;
use super::tables::{AutofocusTable, FalloffName, FocusDistance, IntrinsicsTable, LensTable, LensType};
use crate::Invalid;
use crate::optics::{Falloff, Focus, Intrinsics, LensDescription, LensKind, Projection};
use crate::sensor::SensorModel;
use photosite_core::warnings::Warnings;

/// Focal length where nothing asks for another, m.
pub(super) const DEFAULT_FOCAL_LENGTH_M: f64 = 0.016;
/// The focus distance that is that of the middle of the geometry.
pub(super) const ON_SCENE: &str = "scene";
/// f-number where nothing asks for another.
pub(super) const DEFAULT_F_NUMBER: f64 = 8.0;

/// Describes a lens. `vertical_fov_rad` is that of a glTF camera, if one is used: without a focal length of the table's
/// own, it decides. `default_focus` holds where the table says nothing of focus, or to focus on the scene.
pub(super) fn describe_lens(
    finder: &Finder<'_>,
    table: &LensTable,
    sensor: &SensorModel,
    vertical_fov_rad: Option<f64>,
    default_focus: Option<Focus>,
    warnings: &mut Warnings,
) -> Result<LensDescription, Invalid> {
    let kind = match table.kind {
        None | Some(LensType::Thin) => LensKind::Thin,
        Some(LensType::Pinhole) => LensKind::Pinhole,
    };
    let size_px = sensor.pixel_array().map(|n| n as f64);
    let unstated = || default_focus.unwrap_or(Focus::Autofocus { pixel: size_px.map(|n| n / 2.0) });
    let focus = match (&table.focus_distance_m, &table.autofocus_px) {
        (Some(_), Some(_)) => {
            return Err(Invalid::new("autofocus_px", "cannot go with focus_distance_m").help("keep one of them"));
        }
        (Some(FocusDistance::Name(name)), None) if name == ON_SCENE => unstated(),
        (Some(distance), None) => focus_distance(distance)?,
        (None, Some(pixel)) => autofocus(pixel, size_px)?,
        (None, None) => unstated(),
    };
    let focus = match kind {
        LensKind::Thin => focus,
        LensKind::Pinhole => {
            let key = if table.focus_distance_m.is_some() { "focus_distance_m" } else { "autofocus_px" };
            let is_given = table.focus_distance_m.is_some() || table.autofocus_px.is_some();
            if is_given && focus != Focus::Infinity {
                warnings.once(format!(
                    "lens.{key} has no effect: a pinhole has no focus, and its picture lies one focal length behind it; remove \
                     the key, or write type = \"thin\""
                ));
            }
            Focus::Infinity
        }
    };
    if table.blade_rotation_deg.is_some_and(|turn| turn != 0.0) && table.blades.unwrap_or(0) == 0 {
        warnings.once("lens.blade_rotation_deg has no effect: the aperture is round; write blades, too");
    }
    let projection = projection(table)?;
    let intrinsics = match (table.intrinsics, table.focal_length_mm, projection) {
        (Some(table), ..) => Some(intrinsics(table)?),
        (None, None, Projection::Equirectangular) => Some(whole_sphere(size_px)),
        (None, ..) => None,
    };
    let focal_length_m = match (table.focal_length_mm, intrinsics, vertical_fov_rad) {
        (Some(mm), ..) => mm / 1e3,
        (None, Some(i), _) => focal_length(i.fy * sensor.pixel_pitch_m[1], focus),
        (None, None, Some(fov)) => {
            let half_height = size_px[1] * sensor.pixel_pitch_m[1] / 2.0;
            focal_length(half_height / (fov / 2.0).tan(), focus)
        }
        (None, None, None) => DEFAULT_FOCAL_LENGTH_M,
    };
    let lens = LensDescription {
        kind,
        focal_length_m,
        f_number: table.f_number.unwrap_or(DEFAULT_F_NUMBER),
        focus,
        blades: table.blades.unwrap_or(0),
        blade_rotation_deg: table.blade_rotation_deg.unwrap_or(0.0),
        falloff: match table.falloff {
            None | Some(FalloffName::Cos4) => Falloff::Cos4,
            Some(FalloffName::None) => Falloff::None,
        },
        transmittance: match &table.transmittance {
            Some(source) => finder.fraction(source).map_err(|e| e.within("transmittance"))?,
            None => crate::spectrum::Spectrum::constant(1.0),
        },
        projection,
        point_spread: table
            .psf
            .as_ref()
            .map(|psf| point_spread(finder, psf, sensor.pixel_pitch_m, warnings))
            .transpose()
            .map_err(|e| e.within("psf"))?,
        lateral_colour: table
            .lateral_colour
            .as_ref()
            .map(lateral_colour)
            .transpose()
            .map_err(|e| e.within("lateral_colour"))?,
        stops: stops(&table.stops)?,
        max_angle_rad: table.max_angle_deg.map(f64::to_radians),
        intrinsics,
    };
    if !lens.blade_rotation_deg.is_finite() {
        return Err(Invalid::new("blade_rotation_deg", format!("must be finite, got {}", lens.blade_rotation_deg)));
    }
    lens.validate()?;
    Ok(lens)
}

/// The focal length that puts the sensor at the distance `v` when focused: 1/f = 1/u + 1/v. Where the distance u of
/// what is in focus is not known, it counts as infinite, and f = v.
fn focal_length(v: f64, focus: Focus) -> f64 {
    match focus {
        Focus::Distance(u) => u * v / (u + v),
        Focus::Infinity | Focus::Autofocus { .. } => v,
    }
}

fn focus_distance(distance: &FocusDistance) -> Result<Focus, Invalid> {
    match distance {
        FocusDistance::Metres(u) => Ok(Focus::Distance(*u)),
        FocusDistance::Name(name) if name == "infinity" => Ok(Focus::Infinity),
        FocusDistance::Name(name) => Err(Invalid::new("focus_distance_m", format!("unknown distance {name:?}"))
            .help("write a number of metres, \"infinity\" or \"scene\"")),
    }
}

fn autofocus(pixel: &AutofocusTable, size_px: [f64; 2]) -> Result<Focus, Invalid> {
    match pixel {
        AutofocusTable::Pixel(pixel) if (0..2).all(|i| (0.0..=size_px[i]).contains(&pixel[i])) => {
            Ok(Focus::Autofocus { pixel: *pixel })
        }
        AutofocusTable::Pixel(pixel) => {
            let message = format!("{pixel:?} is not on the sensor of {} × {} pixels", size_px[0], size_px[1]);
            Err(Invalid::new("autofocus_px", message).help("pixels count from the top-left corner"))
        }
        AutofocusTable::Name(name) if name == "centre" => Ok(Focus::Autofocus { pixel: size_px.map(|n| n / 2.0) }),
        AutofocusTable::Name(name) => Err(Invalid::new("autofocus_px", format!("unknown place {name:?}"))
            .help("write a pixel such as [400, 300], or \"centre\"")),
    }
}

/// Panoramas show all directions unless a focal length says otherwise.
fn whole_sphere([width, height]: [f64; 2]) -> Intrinsics {
    Intrinsics { fx: width / TAU, fy: height / PI, cx: width / 2.0, cy: height / 2.0, skew: 0.0 }
}

/// From OpenCV's convention, where the centre of the first pixel is 0, to ours, where it is 0.5.
fn intrinsics(table: IntrinsicsTable) -> Result<Intrinsics, Invalid> {
    let IntrinsicsTable { fx, fy, cx, cy, skew } = table;
    for (key, value) in [("cx", cx), ("cy", cy), ("skew", skew)] {
        if !value.is_finite() {
            return Err(Invalid::new(format!("intrinsics.{key}"), format!("must be finite, got {value}")));
        }
    }
    Ok(Intrinsics { fx, fy, cx: cx + 0.5, cy: cy + 0.5, skew })
}
