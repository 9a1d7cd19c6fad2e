//! The figures from rays.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};
use photosite_lens::files::Reading;
use photosite_lens::prescription::Position;
use photosite_lens::spots::Spot;
use photosite_lens::trace::Apertures;
use photosite_lens::{Lens, LensAt, Ray};
use rayon::prelude::*;

use super::figures::{
    ChiefFigures, Claims, FieldFigures, FirstOrderRow, LensFigures, PositionFigures, StopFigures, SurfaceRow,
};
use super::mtf;
use crate::spectrum::dispersion::lines;
use crate::{Invalid, Result};

/// The lines that figures are of, from short to long.
pub(super) const LINES: [(&str, f64); 3] = [("F", lines::F), ("d", lines::D), ("C", lines::C)];
/// Fields from the axis to the edge.
const FIELDS: u32 = 7;
/// Points of curves over the field.
const CURVE: u32 = 33;
/// Directions in which the edge of the light is looked for.
const DIRECTIONS: usize = 90;
/// Rays along a side of a spot diagram.
const ACROSS: u32 = 24;
/// f-numbers that barrels have marks for.
const MARKS: [f64; 13] = [1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0, 45.0, 64.0];
/// The widest half field that is looked for where the file claims none, degrees.
const WIDEST_DEG: u32 = 89;

/// What to show of a lens.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// The f-number that the stop is closed to; open without.
    pub f_number: Option<f64>,
    /// Half of the angle of view, degrees; that of the file without.
    pub half_field_deg: Option<f64>,
}

impl LensFigures {
    /// The figures of a lens that was read.
    ///
    /// # Errors
    ///
    /// An f-number that the lens does not open to.
    pub fn new(reading: &Reading, options: &Options) -> Result<Self> {
        figures(reading, options)
    }
}

fn figures(reading: &Reading, options: &Options) -> Result<LensFigures> {
    let lens = &reading.prescription;
    // Of a prime there is one position: its fields and lines, too, share the processor's cores.
    let positions = lenses(reading, options)?
        .par_iter()
        .map(|(position, lens)| of_position(reading, *position, lens, options))
        .collect();
    let report = &reading.report;
    let surface = |surface: &photosite_lens::prescription::Surface| SurfaceRow {
        radius_mm: surface.radius_mm,
        thickness_mm: surface.thickness_mm,
        glass: surface.glass.as_ref().map(|glass| glass.name.clone()),
        semi_aperture_mm: surface.semi_aperture_mm,
        conic: surface.conic,
        asphere: surface.asphere.clone(),
        stop: surface.is_stop,
    };
    Ok(LensFigures {
        name: lens.name.clone(),
        format: report.format.name(),
        source: lens.source.clone(),
        licence: lens.licence.clone(),
        patent: lens.patent.clone(),
        f_number: options.f_number,
        claims: Claims {
            efl_mm: lens.claims.focal_length_mm,
            f_number: lens.claims.f_number,
            half_field_deg: lens.claims.half_field_deg,
            image_half_diagonal_mm: lens.claims.image_half_diagonal_mm,
        },
        assumed: report.assumed.clone(),
        ignored: report.ignored.clone(),
        warnings: report.warnings.clone(),
        glasses: report.glasses.iter().map(Into::into).collect(),
        surfaces: lens.surfaces.iter().map(surface).collect(),
        positions,
    })
}

/// The lens in each of its positions, with its stop as far open as is asked for.
pub(super) fn lenses<'a>(reading: &'a Reading, options: &Options) -> Result<Vec<(Option<&'a Position>, Lens)>> {
    let positions = &reading.prescription.positions;
    let lenses: Vec<(Option<&Position>, Lens)> = if positions.is_empty() {
        vec![(None, reading.lens.clone())]
    } else {
        positions.iter().map(|position| (Some(position), reading.lens.in_position(position))).collect()
    };
    let Some(f_number) = options.f_number else { return Ok(lenses) };
    let stopped = lenses.into_iter().map(|(position, lens)| {
        let at = lens.at(lines::D);
        let open = at.first_order().f_number;
        // The figures of a barrel are rounded.
        if !(f_number.is_finite() && f_number >= 0.99 * open) {
            let message = format!("the lens does not open to f/{f_number}: it is f/{open:.3} where it is open");
            let invalid = Invalid::new("f_number", message).help("ask for a larger f-number");
            return Err(crate::Error::Usage { message: invalid.to_string(), help: invalid.help });
        }
        Ok((position, lens.with_stop_radius(at.stop_radius_of_f_number(f_number))))
    });
    stopped.collect()
}

fn of_position(reading: &Reading, position: Option<&Position>, lens: &Lens, options: &Options) -> PositionFigures {
    let at = lens.at(lines::D);
    let first_order: Vec<FirstOrderRow> = LINES.iter().map(|&(line, nm)| first_order(line, &lens.at(nm))).collect();
    let (half_field_deg, field_from) = half_field(reading, position, &at, options);
    let angles =
        |count: u32| -> Vec<f64> { (0..count).map(|i| half_field_deg * f64::from(i) / f64::from(count - 1)).collect() };
    let efl_mm = first_order[1].efl_mm;
    let on_axis = at.pupil_region(0.0, DIRECTIONS);
    let axis_sr = on_axis.as_ref().map_or(f64::NAN, |region| region.area());
    let fields: Vec<FieldFigures> =
        angles(FIELDS).par_iter().filter_map(|&angle| of_field(lens, angle, efl_mm, axis_sr)).collect();
    let curves = angles(CURVE).par_iter().filter_map(|&angle| of_chief_ray(lens, angle, efl_mm)).collect();
    let gap = lens.gap_mm(lens.surfaces().len() - 1);
    PositionFigures {
        label: position.map_or_else(String::new, |position| position.label.clone()),
        // |S| is π·sin²u′ on the axis.
        working_f_number: 0.5 / (axis_sr / std::f64::consts::PI).sqrt(),
        length_mm: lens.sensor_z_mm(),
        axial_colour_mm: first_order[2].bfl_mm - first_order[0].bfl_mm,
        defocus_mm: gap - first_order[1].bfl_mm,
        half_field_deg,
        field_from,
        stops: stops(lens, first_order[1].f_number, &fields),
        first_order,
        fields,
        curves,
    }
}

fn first_order(line: &'static str, at: &LensAt) -> FirstOrderRow {
    let found = at.first_order();
    FirstOrderRow {
        line,
        wavelength_nm: at.wavelength_nm,
        efl_mm: found.efl_mm,
        bfl_mm: found.bfl_mm,
        entrance_pupil_mm: found.entrance_pupil_mm,
        entrance_pupil_diameter_mm: found.entrance_pupil_diameter_mm,
        exit_pupil_mm: found.exit_pupil_mm,
        exit_pupil_diameter_mm: found.exit_pupil_diameter_mm,
        f_number: found.f_number,
    }
}

/// Half of the angle of view, and where it comes from.
fn half_field(reading: &Reading, position: Option<&Position>, at: &LensAt, options: &Options) -> (f64, &'static str) {
    let claims = &reading.prescription.claims;
    let by_height = || {
        let chief = at.chief_ray_at_height(claims.image_half_diagonal_mm?)?;
        Some(chief.field_rad.to_degrees())
    };
    if let Some(angle) = options.half_field_deg {
        (angle, "as asked for")
    } else if let Some(angle) = position.and_then(|position| position.half_field_deg) {
        (angle, "of the file, for this position")
    } else if let Some(angle) = claims.half_field_deg {
        (angle, "of the file")
    } else if let Some(angle) = by_height() {
        (angle, "from the height of the picture in the file")
    } else {
        let passes = |angle: &u32| at.beam(f64::from(*angle).to_radians()).is_some();
        let widest = (1..=WIDEST_DEG).take_while(passes).last().unwrap_or(1);
        (f64::from(widest), "the widest, in whole degrees, in which light passes: the file gives none")
    }
}

/// The figures of the chief ray of a field; `None` where the lens has none.
fn of_chief_ray(lens: &Lens, angle_deg: f64, efl_mm: f64) -> Option<ChiefFigures> {
    let field = angle_deg.to_radians();
    let height = |nm: f64| Some(if field == 0.0 { 0.0 } else { lens.at(nm).chief_ray(field)?.image_height_mm });
    let image_height_mm = height(lines::D)?;
    let lateral = |nm: f64| height(nm).map(|height| (height - image_height_mm) * 1e3);
    let foci = foci(&lens.at(lines::D), field);
    // On the axis the ratio is that of rays close by, which a sensor off the paraxial focus changes. Beyond 90° there is no
    // picture on a plane to compare with.
    const CLOSE_RAD: f64 = 1e-4;
    let distortion_percent = if field >= FRAC_PI_2 {
        0.0
    } else {
        lens.at(lines::D).chief_ray(field.max(CLOSE_RAD))?.distortion_percent(efl_mm)
    };
    Some(ChiefFigures {
        field_deg: angle_deg,
        image_height_mm,
        distortion_percent,
        tangential_focus_mm: foci.map(|[tangential, _]| tangential),
        sagittal_focus_mm: foci.map(|[_, sagittal]| sagittal),
        lateral_colour_f_um: lateral(lines::F),
        lateral_colour_c_um: lateral(lines::C),
    })
}

/// The figures of a field; `None` where the lens has no chief ray.
fn of_field(lens: &Lens, angle_deg: f64, efl_mm: f64, axis_sr: f64) -> Option<FieldFigures> {
    let chief = of_chief_ray(lens, angle_deg, efl_mm)?;
    let field = angle_deg.to_radians();
    let region = lens.at(lines::D).pupil_region(chief.image_height_mm, DIRECTIONS);
    let illumination_sr = region.map_or(0.0, |region| region.area());
    let spots: Vec<Vec<DVec2>> = LINES.iter().map(|&(_, nm)| lens.at(nm).spot_diagram(field, ACROSS)).collect();
    let rms = |points: &[DVec2]| Spot::of(points).map(|spot| spot.rms_mm * 1e3);
    let mtf_of_lines: Vec<_> = LINES.par_iter().map(|&(_, nm)| mtf::mtf(&lens.at(nm), field)).collect();
    Some(FieldFigures {
        chief,
        illumination_sr,
        relative_illumination: illumination_sr / axis_sr,
        spot_rms_um: [0, 1, 2].map(|i| rms(&spots[i])),
        spot_rms_all_um: rms(&spots.concat()),
        mtf: mtf_of_lines.try_into().unwrap_or_default(),
    })
}

/// Where rays close to the chief ray cross it, behind the sensor, mm: in its plane, and across. The chief ray is traced
/// with one beside it.
fn foci(at: &LensAt, field: f64) -> Option<[f64; 2]> {
    // Far above the digits of a double, far below any aberration of the third order.
    const BESIDE_MM: f64 = 1e-4;
    let chief = if field == 0.0 { at.chief_ray_of_stop_angle(0.0).ok()? } else { at.chief_ray(field)? };
    let Ray { origin, direction } = chief.before;
    let up = DVec3::new(0.0, direction.z, -direction.y);
    let traced = |beside: DVec3| {
        let ray = at.trace_in(Ray { origin: origin + beside * BESIDE_MM, direction }, Apertures::Ignore).ok()?;
        Some((ray.at_z(at.lens.sensor_z_mm()), ray.direction / ray.direction.z))
    };
    let (point, slope) = traced(DVec3::ZERO)?;
    let crossing = |beside: DVec3, axis: DVec3| {
        let (other, other_slope) = traced(beside)?;
        Some(-(other - point).dot(axis) / (other_slope - slope).dot(axis))
    };
    Some([crossing(up, DVec3::Y)?, crossing(DVec3::X, DVec3::X)?])
}

/// The lens as it is, and closed to the marks of a barrel.
fn stops(lens: &Lens, open: f64, fields: &[FieldFigures]) -> Vec<StopFigures> {
    let marks = MARKS.iter().copied().filter(|mark| *mark > 1.05 * open && *mark <= 22.0_f64.max(2.0 * open));
    let f_numbers: Vec<f64> = std::iter::once(open).chain(marks).collect();
    f_numbers
        .par_iter()
        .map(|&f_number| {
            let at_d = lens.at(lines::D);
            let stopped = lens.with_stop_radius(at_d.stop_radius_of_f_number(f_number));
            let at = stopped.at(lines::D);
            let area = |height: f64| at.pupil_region(height, DIRECTIONS).map_or(0.0, |region| region.area());
            let axis = area(0.0);
            let spot = |angle_deg: f64| {
                let of_line = |&(_, nm): &(&str, f64)| stopped.at(nm).spot_diagram(angle_deg.to_radians(), ACROSS);
                Spot::of(&LINES.iter().flat_map(of_line).collect::<Vec<_>>()).map(|spot| spot.rms_mm * 1e3)
            };
            StopFigures {
                f_number,
                relative_illumination: fields.iter().map(|field| area(field.chief.image_height_mm) / axis).collect(),
                spot_rms_um: fields.iter().map(|field| spot(field.chief.field_deg)).collect(),
            }
        })
        .collect()
}
