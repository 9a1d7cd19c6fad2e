//! Computation of a lens's figures by tracing rays.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};
use photosite_lens::chief::ChiefRay;
use photosite_lens::files::Reading;
use photosite_lens::prescription::Position;
use photosite_lens::spots::{ObjectPoint, Spot};
use photosite_lens::trace::Apertures;
use photosite_lens::{Lens, LensAt};
use rayon::prelude::*;

use super::figures::{
    ChiefFigures, Claims, FieldFigures, FirstOrderRow, LensFigures, PositionFigures, StopFigures, SurfaceRow,
};
use super::mtf;
use photosite_core::spectrum::dispersion::lines;
use photosite_core::{Invalid, Result};

/// Spectral lines of the figures, from short to long wavelengths.
pub(super) const LINES: [(&str, f64); 3] = [("F", lines::F), ("d", lines::D), ("C", lines::C)];
/// Number of fields from the axis to the edge.
const FIELDS: u32 = 7;
/// Number of points of curves over the field.
const CURVE: u32 = 33;
/// Number of directions in which the edge of the light is searched.
const DIRECTIONS: usize = 90;
/// Number of directions in which the edge of the light of a spot is searched.
const SPOT_DIRECTIONS: usize = 48;
/// Marked f-numbers of lens barrels.
const MARKS: [f64; 13] = [1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0, 45.0, 64.0];
/// Widest half field that is searched where the file claims none, degrees.
const WIDEST_DEG: u32 = 89;

/// Options of the figures of a lens.
#[derive(Clone, Debug, Default)]
pub(crate) struct Options {
    /// F-number that the stop is closed to; `None` leaves it open.
    pub f_number: Option<f64>,
    /// Half of the angle of view, degrees; `None` takes that of the file.
    pub half_field_deg: Option<f64>,
    /// Position of zoom and focus, by its label or its number from 1 on; `None` takes all.
    pub position: Option<String>,
    /// Whether only the figures of the text are computed: no curves, and modulation at d alone.
    pub is_text: bool,
}

impl LensFigures {
    /// Figures of a lens that was read.
    ///
    /// # Errors
    ///
    /// An f-number that the lens does not open to, a position that it does not have.
    pub(crate) fn new(reading: &Reading, options: &Options) -> Result<Self> {
        figures(reading, options)
    }
}

fn figures(reading: &Reading, options: &Options) -> Result<LensFigures> {
    let lens = &reading.prescription;
    // Of a prime there is one position: its fields and lines, too, share the processor's cores.
    let positions = lenses(reading, options)?
        .par_iter()
        .map(|(position, lens)| InPosition::new(*position, lens).figures(reading, options))
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
        position: options.position.clone(),
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

/// Lens in each requested position, with its stop closed to the requested f-number.
pub(super) fn lenses<'a>(reading: &'a Reading, options: &Options) -> Result<Vec<(Option<&'a Position>, Lens)>> {
    let positions = &reading.prescription.positions;
    let lenses: Vec<(Option<&Position>, Lens)> = match &options.position {
        None if positions.is_empty() => vec![(None, reading.lens.clone())],
        None => positions.iter().map(|position| (Some(position), reading.lens.in_position(position))).collect(),
        Some(wanted) => {
            let by_number = wanted.parse::<usize>().ok().and_then(|number| positions.get(number.checked_sub(1)?));
            let found = positions.iter().find(|position| position.label == *wanted).or(by_number);
            let position = found.ok_or_else(|| no_position(wanted, positions))?;
            vec![(Some(position), reading.lens.in_position(position))]
        }
    };
    let Some(f_number) = options.f_number else { return Ok(lenses) };
    let stopped = lenses.into_iter().map(|(position, lens)| {
        let at = lens.at(lines::D);
        let open = at.first_order().f_number;
        // The figures of a barrel are rounded.
        if !(f_number.is_finite() && f_number >= 0.99 * open) {
            let message = format!("the lens does not open to f/{f_number}: it is f/{open:.3} where it is open");
            let invalid = Invalid::new("f_number", message).help("ask for a larger f-number");
            return Err(photosite_core::Error::Usage { message: invalid.to_string(), help: invalid.help });
        }
        Ok((position, lens.with_stop_radius(at.stop_radius_of_f_number(f_number))))
    });
    stopped.collect()
}

fn no_position(wanted: &str, positions: &[Position]) -> photosite_core::Error {
    let named = positions.iter().enumerate().map(|(i, position)| format!("{} ({})", i + 1, position.label));
    let help = match positions.len() {
        0 => "leave --position out".to_owned(),
        _ => format!("--position takes a number or a label: {}", named.collect::<Vec<_>>().join(", ")),
    };
    photosite_core::Error::Usage { message: format!("the lens has no position {wanted:?}"), help: Some(help.into()) }
}

/// Lens in a position, with the distance of its object.
pub(super) struct InPosition<'a> {
    position: Option<&'a Position>,
    lens: &'a Lens,
    /// Distance of the object from the first vertex, mm.
    distance_mm: f64,
}

impl<'a> InPosition<'a> {
    pub(super) fn new(position: Option<&'a Position>, lens: &'a Lens) -> Self {
        let distance_mm = position.and_then(|position| position.object_distance_mm).unwrap_or(f64::INFINITY);
        Self { position, lens, distance_mm }
    }

    fn figures(&self, reading: &Reading, options: &Options) -> PositionFigures {
        let (lens, at) = (self.lens, self.lens.at(lines::D));
        let first_order: Vec<FirstOrderRow> = LINES.iter().map(|&(line, nm)| first_order(line, &lens.at(nm))).collect();
        let (half_field_deg, field_from) = half_field(reading, self.position, &at, options);
        let angles = |count: u32| -> Vec<f64> {
            (0..count).map(|i| half_field_deg * f64::from(i) / f64::from(count - 1)).collect()
        };
        let axis_sr = at.pupil_region(0.0, DIRECTIONS).map_or(f64::NAN, |region| region.area());
        let fields: Vec<FieldFigures> =
            angles(FIELDS).par_iter().filter_map(|&angle| self.of_field(angle, axis_sr, options)).collect();
        let curves = if options.is_text { Vec::new() } else { angles(CURVE) };
        let gap = lens.gap_mm(lens.surfaces().len() - 1);
        let focus = |nm: f64| lens.at(nm).image(self.distance_mm).distance_mm;
        PositionFigures {
            label: self.position.map_or_else(String::new, |position| position.label.clone()),
            object_distance_mm: self.distance_mm.is_finite().then_some(self.distance_mm),
            // |S| is π·sin²u′ on the axis.
            working_f_number: 0.5 / (axis_sr / std::f64::consts::PI).sqrt(),
            length_mm: lens.sensor_z_mm(),
            axial_colour_mm: focus(lines::C) - focus(lines::F),
            defocus_mm: gap - focus(lines::D),
            half_field_deg,
            field_from,
            stops: self.stops(first_order[1].f_number, &fields),
            first_order,
            fields,
            curves: curves.par_iter().filter_map(|&angle| self.of_chief_ray(angle)).collect(),
        }
    }

    /// Chief ray of d at an angle, rad; `None` where the lens has none.
    fn chief_ray(&self, angle_rad: f64) -> Option<ChiefRay> {
        self.lens.at(lines::D).chief_ray(angle_rad)
    }

    /// Chief ray at wavelength `nm` from the same object point as a chief ray of d.
    fn chief_ray_at(&self, nm: f64, of_d: &ChiefRay) -> Option<ChiefRay> {
        if self.distance_mm.is_infinite() {
            self.lens.at(nm).chief_ray(of_d.field_rad)
        } else {
            self.lens.at(nm).chief_ray_of_object(of_d.object_height_mm(self.distance_mm), self.distance_mm)
        }
    }

    /// Distance along a chief ray from its point on the first surface to the object, mm.
    fn along_mm(&self, chief: &ChiefRay) -> f64 {
        (chief.before.origin.z + self.distance_mm) / chief.before.direction.z.abs()
    }

    /// Object point of the chief ray of d at an angle, rad; where the lens has none, a point at infinity.
    pub(super) fn object(&self, angle_rad: f64) -> ObjectPoint {
        let direction = DVec3::new(0.0, angle_rad.sin(), angle_rad.cos());
        self.chief_ray(angle_rad)
            .map_or(ObjectPoint { origin: DVec3::ZERO, direction, distance_mm: f64::INFINITY }, |chief| {
                ObjectPoint::on(&chief, self.along_mm(&chief))
            })
    }

    /// Percent by which a chief ray lands farther out than to first order.
    fn distortion_percent(&self, chief: &ChiefRay) -> f64 {
        let at = self.lens.at(lines::D);
        if self.distance_mm.is_infinite() {
            return chief.distortion_percent(at.first_order().efl_mm);
        }
        let to_first_order = at.image(self.distance_mm).magnification * chief.object_height_mm(self.distance_mm);
        100.0 * (chief.image_height_mm / to_first_order - 1.0)
    }

    /// Figures of the chief ray of a field; `None` where the lens has none.
    fn of_chief_ray(&self, angle_deg: f64) -> Option<ChiefFigures> {
        let field = angle_deg.to_radians();
        let chief = self.chief_ray(field)?;
        let lateral = |nm: f64| Some((self.chief_ray_at(nm, &chief)?.image_height_mm - chief.image_height_mm) * 1e3);
        let foci = foci(&self.lens.at(lines::D), ObjectPoint::on(&chief, self.along_mm(&chief)));
        // On the axis the ratio is that of rays close by, which a sensor off the paraxial focus changes. Beyond 90° there is no
        // image on a plane to compare with.
        const CLOSE_RAD: f64 = 1e-4;
        let distortion_percent =
            if field >= FRAC_PI_2 { 0.0 } else { self.distortion_percent(&self.chief_ray(field.max(CLOSE_RAD))?) };
        Some(ChiefFigures {
            field_deg: angle_deg,
            image_height_mm: chief.image_height_mm,
            distortion_percent,
            tangential_focus_mm: foci.map(|[tangential, _]| tangential),
            sagittal_focus_mm: foci.map(|[_, sagittal]| sagittal),
            lateral_colour_f_um: lateral(lines::F),
            lateral_colour_c_um: lateral(lines::C),
        })
    }

    /// Figures of a field; `None` where the lens has no chief ray.
    fn of_field(&self, angle_deg: f64, axis_sr: f64, options: &Options) -> Option<FieldFigures> {
        let chief = self.of_chief_ray(angle_deg)?;
        let field = angle_deg.to_radians();
        let region = self.lens.at(lines::D).pupil_region(chief.image_height_mm, DIRECTIONS);
        let illumination_sr = region.map_or(0.0, |region| region.area());
        let object = self.object(field);
        let spots = LINES.map(|(_, nm)| self.lens.at(nm).spot(object, SPOT_DIRECTIONS));
        let rms = |points: &[(DVec2, f64)]| Spot::of(points).map(|spot| spot.rms_mm * 1e3);
        let of_d = self.chief_ray(field)?;
        let mtf = |(_, nm): (&str, f64)| {
            if spots[1].is_empty() || (options.is_text && nm != lines::D) {
                return None;
            }
            let chief = self.chief_ray_at(nm, &of_d)?;
            let frequencies_per_mm = if options.is_text { &mtf::TOLD_PER_MM[..] } else { &mtf::FREQUENCIES_PER_MM[..] };
            mtf::mtf(&self.lens.at(nm), chief, self.along_mm(&chief), frequencies_per_mm)
        };
        Some(FieldFigures {
            chief,
            illumination_sr,
            relative_illumination: illumination_sr / axis_sr,
            spot_rms_um: [0, 1, 2].map(|i| rms(&spots[i])),
            spot_rms_all_um: rms(&spots.concat()),
            mtf: LINES.map(mtf),
        })
    }

    /// Figures of the lens as it is, and closed to the marks of a barrel.
    fn stops(&self, open: f64, fields: &[FieldFigures]) -> Vec<StopFigures> {
        let marks = MARKS.iter().copied().filter(|mark| *mark > 1.05 * open && *mark <= 22.0_f64.max(2.0 * open));
        let f_numbers: Vec<f64> = std::iter::once(open).chain(marks).collect();
        let radius_mm = |f_number: f64| self.lens.at(lines::D).stop_radius_of_f_number(f_number);
        let of_stop = |&f_number: &f64| {
            let stopped = self.lens.with_stop_radius(radius_mm(f_number));
            let at = stopped.at(lines::D);
            let area = |height: f64| at.pupil_region(height, DIRECTIONS).map_or(0.0, |region| region.area());
            let axis = area(0.0);
            // Where the open stop lets no light through, a closed one does not, and a search for it is long.
            let illumination = |field: &FieldFigures| {
                if field.illumination_sr == 0.0 { 0.0 } else { area(field.chief.image_height_mm) / axis }
            };
            let spot = |field: &FieldFigures| {
                field.spot_rms_all_um?;
                let object = self.object(field.chief.field_deg.to_radians());
                let of_line = |(_, nm): (&str, f64)| stopped.at(nm).spot(object, SPOT_DIRECTIONS);
                Spot::of(&LINES.map(of_line).concat()).map(|spot| spot.rms_mm * 1e3)
            };
            StopFigures {
                f_number,
                relative_illumination: fields.iter().map(illumination).collect(),
                spot_rms_um: fields.iter().map(spot).collect(),
            }
        };
        f_numbers.par_iter().map(of_stop).collect()
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

/// Half of the angle of view, and its source.
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
        (angle, "from the height of the image in the file")
    } else {
        let passes = |angle: &u32| at.beam(f64::from(*angle).to_radians()).is_some();
        let widest = (1..=WIDEST_DEG).take_while(passes).last().unwrap_or(1);
        (f64::from(widest), "the widest, in whole degrees, in which light passes: the file gives none")
    }
}

/// Tangential and sagittal focus of rays close to the chief ray, behind the sensor, mm. The chief ray is traced with
/// one beside it.
fn foci(at: &LensAt, object: ObjectPoint) -> Option<[f64; 2]> {
    // Far above the digits of a double, far below any aberration of the third order.
    const BESIDE_MM: f64 = 1e-4;
    let traced = |beside: DVec2| {
        let ray = at.trace_in(object.ray(beside * BESIDE_MM), Apertures::Ignore).ok()?;
        Some((ray.at_z(at.lens.sensor_z_mm()), ray.direction / ray.direction.z))
    };
    let (point, slope) = traced(DVec2::ZERO)?;
    let crossing = |beside: DVec2, axis: DVec3| {
        let (other, other_slope) = traced(beside)?;
        Some(-(other - point).dot(axis) / (other_slope - slope).dot(axis))
    };
    Some([crossing(DVec2::Y, DVec3::Y)?, crossing(DVec2::X, DVec3::X)?])
}
