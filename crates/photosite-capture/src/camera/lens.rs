//! Lens of a capture: from the table `[lens]` to a [`LensDescription`].

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::super::tables::spectra::Finder;
use super::super::tables::{IntrinsicsTable, LensTable, LensType};
use super::super::tree::numbers::positive_number;
use super::aberrations::{lateral_colour, point_spread, stops};
use super::calibration::Calibrated;
use super::focus::focus;
use super::lens_elements::{ground_lens, supplementary_lens};
use super::prescription::{Prescribed, focus_spectrum};
use super::projection::projection;
use photosite_core::Invalid;
use photosite_core::spectrum::Spectrum;
use photosite_core::spectrum::dispersion::lines::D;
use photosite_core::warnings::Warnings;
use photosite_sensor::SensorModel;
use photosite_transport::optics::{Falloff, Focus, Intrinsics, LensDescription, LensKind, Projection};

/// Default focal length, m.
pub(crate) const DEFAULT_FOCAL_LENGTH_M: f64 = 0.016;
/// Default f-number.
pub(crate) const DEFAULT_F_NUMBER: f64 = 8.0;

/// Describes a lens, of which `prescribed` is what its prescription names, and `calibrated` its calibration. `vertical_fov_rad` is that of a glTF camera,
/// if one is used: without a focal length of the table's own, it decides. `default_focus` holds where the table says
/// nothing of focus, or to focus on the scene.
pub(crate) fn describe_lens(
    finder: &Finder<'_>,
    table: &LensTable,
    (prescribed, calibrated): (Option<Prescribed>, Option<&Calibrated>),
    sensor: &SensorModel,
    vertical_fov_rad: Option<f64>,
    default_focus: Option<Focus>,
    warnings: &mut Warnings,
) -> Result<LensDescription, Invalid> {
    let kind = match table.kind {
        _ if prescribed.is_some() => LensKind::Prescription,
        None | Some(LensType::Thin) => LensKind::Thin,
        Some(LensType::Pinhole) => LensKind::Pinhole,
        Some(LensType::Hole) => LensKind::Hole,
        Some(LensType::None) => LensKind::Bare,
    };
    let size_px = sensor.pixel_array().map(|n| n as f64);
    // The middle of a scene is as far from the entrance pupil, and the focus of a prescription counts from the sensor.
    let default_focus = default_focus.map(|focus| match (focus, &prescribed) {
        (Focus::Distance(u), Some(prescribed)) => Focus::Distance(u + prescribed.pupil_to_sensor_m()),
        (Focus::Distance(_) | Focus::Infinity | Focus::Autofocus { .. } | Focus::ImageDistance(_), _) => focus,
    });
    let focus = focus(table, kind, size_px, default_focus, warnings)?;
    if table.blade_rotation_deg.is_some_and(|turn| turn != 0.0) && table.blades.unwrap_or(0) == 0 {
        warnings.once("lens.blade_rotation_deg has no effect: the aperture is round; write blades, too");
    }
    let projection = calibrated.map_or_else(|| projection(table), |calibrated| Ok(calibrated.projection))?;
    let image_distance_m = image_distance_of_field(table, sensor)?;
    let is_sized = table.focal_length_mm.is_some() || image_distance_m.is_some();
    let stated = match calibrated {
        Some(calibrated) => Some(calibrated.intrinsics),
        None => table.intrinsics.map(intrinsics).transpose()?,
    };
    let intrinsics = match (stated, is_sized, projection) {
        (Some(stated), ..) => Some(stated),
        (None, false, Projection::Equirectangular) => Some(whole_sphere(size_px)),
        (None, ..) => None,
    };
    let ground = table.lensmaker.as_ref().map(|table| ground_lens(finder, table));
    let ground = ground.transpose().map_err(|invalid| invalid.within("lensmaker"))?;
    for (key, is_given) in [("focal_length_mm", table.focal_length_mm.is_some()), ("intrinsics", intrinsics.is_some())]
    {
        if ground.is_some() && is_given {
            let message = "cannot be combined with lensmaker, whose focal length follows from its surfaces";
            return Err(Invalid::new(key, message).help("keep one of them"));
        }
    }
    let hole_distance_mm = table.image_distance_mm.filter(|_| kind == LensKind::Hole);
    let hole_distance_mm = hole_distance_mm.map(|mm| positive_number("image_distance_mm", mm, "16.5")).transpose()?;
    if hole_distance_mm.is_some() && table.focal_length_mm.is_some() {
        let message = "cannot be combined with focal_length_mm, which is the same of a hole";
        return Err(Invalid::new("image_distance_mm", message).help("keep one of them"));
    }
    let first_order = prescribed.as_ref().map(Prescribed::first_order);
    if prescribed.is_some() && image_distance_m.is_some() {
        let message = "cannot be combined with lens.prescription: what it sees follows from its glass and the sensor";
        return Err(
            Invalid::new("horizontal_fov_deg", message).help("write focal_length_mm of a zoom, or another sensor")
        );
    }
    let own_mm = first_order.map(|first_order| first_order.efl_mm);
    let stated_mm = table.focal_length_mm.or(hole_distance_mm).or(own_mm);
    let focal_length_m = match (stated_mm, &ground, intrinsics, vertical_fov_rad) {
        (Some(mm), ..) => mm / 1e3,
        (None, Some(ground), ..) => 1.0 / ground.power(D),
        (None, None, None, _) if image_distance_m.is_some() => {
            image_distance_m.map_or(DEFAULT_FOCAL_LENGTH_M, |v| focal_length(v, focus))
        }
        (None, None, Some(i), _) => focal_length(i.fy * sensor.pixel_pitch_m[1], focus),
        (None, None, None, Some(fov)) => {
            let half_height = size_px[1] * sensor.pixel_pitch_m[1] / 2.0;
            focal_length(half_height / (fov / 2.0).tan(), focus)
        }
        (None, None, None, None) => DEFAULT_FOCAL_LENGTH_M,
    };
    let supplementary = table.supplementary.iter().enumerate().map(|(i, table)| {
        supplementary_lens(finder, table).map_err(|invalid| invalid.within(&format!("supplementary[{i}]")))
    });
    if kind == LensKind::Bare {
        warn_of_idle_keys(table, warnings);
    }
    let transmittance = match &table.transmittance {
        Some(source) => finder.fraction(source).map_err(|e| e.within("transmittance"))?,
        None => Spectrum::constant(1.0),
    };
    let focus_spectrum = if prescribed.is_some() { focus_spectrum(sensor, &transmittance) } else { Vec::new() };
    let lens = LensDescription {
        kind,
        prescription: prescribed.map(|prescribed| prescribed.prescription),
        focal_length_m,
        f_number: f_number(table, kind, focal_length_m, first_order.map(|first_order| first_order.f_number))?,
        focus,
        focus_spectrum,
        min_focus_distance_m: table
            .min_focus_distance_m
            .filter(|_| matches!(kind, LensKind::Thin | LensKind::Prescription)),
        circle_of_confusion_m: table.circle_of_confusion_um.map(|um| um * 1e-6),
        ground,
        supplementary: supplementary.collect::<Result<_, _>>()?,
        blades: table.blades.unwrap_or(0),
        blade_rotation_deg: table.blade_rotation_deg.unwrap_or(0.0),
        falloff: table.falloff.unwrap_or(Falloff::Cos4),
        transmittance,
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

/// The distance between lens and sensor, m, at which the width of the sensor sees the field of view that the table
/// states, if it does; lenses before the main one aside.
pub(crate) fn image_distance_of_field(table: &LensTable, sensor: &SensorModel) -> Result<Option<f64>, Invalid> {
    const KEY: &str = "horizontal_fov_deg";
    let Some(degrees) = table.horizontal_fov_deg else { return Ok(None) };
    for (key, is_given) in [
        ("focal_length_mm", table.focal_length_mm.is_some()),
        ("lensmaker", table.lensmaker.is_some()),
        ("intrinsics", table.intrinsics.is_some()),
        ("image_distance_mm", table.image_distance_mm.is_some()),
    ] {
        if is_given {
            let message = format!("cannot be combined with {key}, which says what the lens sees");
            return Err(Invalid::new(KEY, message).help("keep one of them"));
        }
    }
    let projection = projection(table)?;
    let half = degrees.to_radians() / 2.0;
    let edge = (0.0..=360.0)
        .contains(&degrees)
        .then(|| projection.project(DVec3::new(half.sin(), 0.0, half.cos()), &projection.reach(None)))
        .flatten();
    let half_width_m = sensor.pixel_array()[0] as f64 * sensor.pixel_pitch_m[0] / 2.0;
    match edge.map(|place| half_width_m / place.x) {
        Some(distance) if distance.is_finite() && distance > 0.0 => Ok(Some(distance)),
        Some(_) | None => {
            let message = format!("must be an angle above 0 that the projection can show, got {degrees}");
            Err(Invalid::new(KEY, message).help("a rectilinear lens shows less than 180, for example 40.0"))
        }
    }
}

/// The focal length that puts the sensor at the distance `v` when focused: 1/f = 1/u + 1/v. Where the distance u of
/// what is in focus is not known, it counts as infinite, and f = v.
fn focal_length(v: f64, focus: Focus) -> f64 {
    match focus {
        Focus::Distance(u) => u * v / (u + v),
        Focus::Infinity | Focus::Autofocus { .. } | Focus::ImageDistance(_) => v,
    }
}

/// The f-number, stated or of a diameter. A hole that is not told either has the diameter that makes its spots
/// smallest: that whose first dark ring is as large as itself; a prescription that of the open lens.
fn f_number(
    table: &LensTable,
    kind: LensKind,
    focal_length_m: f64,
    of_prescription: Option<f64>,
) -> Result<f64, Invalid> {
    /// Wavelength at which the eye is most sensitive, m.
    const LAMBDA_M: f64 = 550e-9;
    match (table.f_number, table.diameter_mm, kind) {
        (Some(_), Some(_), _) => {
            Err(Invalid::new("diameter_mm", "cannot be combined with f_number").help("keep one of them"))
        }
        (Some(f_number), None, _) => Ok(f_number),
        (None, Some(mm), _) => Ok(focal_length_m.abs() * 1e3 / positive_number("diameter_mm", mm, "0.3")?),
        (None, None, LensKind::Hole) if focal_length_m > 0.0 => Ok((focal_length_m / (2.44 * LAMBDA_M)).sqrt()),
        (None, None, LensKind::Hole | LensKind::Thin | LensKind::Pinhole | LensKind::Bare | LensKind::Prescription) => {
            Ok(of_prescription.unwrap_or(DEFAULT_F_NUMBER))
        }
    }
}

/// Warns of keys that a bare sensor has no use for.
fn warn_of_idle_keys(table: &LensTable, warnings: &mut Warnings) {
    let keys = [
        ("focal_length_mm", table.focal_length_mm.is_some()),
        ("horizontal_fov_deg", table.horizontal_fov_deg.is_some()),
        ("f_number", table.f_number.is_some()),
        ("diameter_mm", table.diameter_mm.is_some()),
        ("blades", table.blades.is_some()),
        ("circle_of_confusion_um", table.circle_of_confusion_um.is_some()),
    ];
    for (key, _) in keys.into_iter().filter(|(_, is_given)| *is_given) {
        warnings.once(format!("lens.{key} has no effect: there is no lens; remove the key, or write type = \"thin\""));
    }
}

/// Intrinsics of a panorama of all directions, which hold unless a focal length is stated.
fn whole_sphere([width, height]: [f64; 2]) -> Intrinsics {
    Intrinsics { fx: width / TAU, fy: height / PI, cx: width / 2.0, cy: height / 2.0, skew: 0.0 }
}

/// Intrinsics from OpenCV's convention, where the centre of the first pixel is 0, to photosite's, where it is 0.5.
fn intrinsics(table: IntrinsicsTable) -> Result<Intrinsics, Invalid> {
    let IntrinsicsTable { fx, fy, cx, cy, skew } = table;
    positive_number("intrinsics.fx", fx, "1200.0")?;
    positive_number("intrinsics.fy", fy, "1200.0")?;
    for (key, value) in [("cx", cx), ("cy", cy), ("skew", skew)] {
        if !value.is_finite() {
            return Err(Invalid::new(format!("intrinsics.{key}"), format!("must be finite, got {value}")));
        }
    }
    Ok(Intrinsics { fx, fy, cx: cx + 0.5, cy: cy + 0.5, skew })
}
