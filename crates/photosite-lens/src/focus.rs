//! Focus: the gaps at which an object distance is sharpest.

use glam::{DVec2, DVec3};

use photosite_core::Invalid;
use photosite_core::spectrum::dispersion::lines;

use crate::lens::Lens;
use crate::positions::GapCurves;
use crate::profile::Travel;
use crate::trace::{Apertures, Ray, Step};

/// Number of rays from the axis to the rim that measure sharpness, of equal shares of the pupil's area.
const RAYS: u32 = 256;
/// Largest number of steps of the search for the focus; the final distance of two steps and the length of the first,
/// relative to the focal length or to the parameter range of the curves.
const MOST_STEPS: usize = 60;
const PRECISION: f64 = 1e-11;
const FIRST_STEP: f64 = 1e-3;
/// Margin of the positions of focus beyond both ends, relative to the range between them.
const BEYOND_INFINITY: f64 = 0.02;

/// Moving part of a lens when it is focused.
#[derive(Clone, Copy, Debug)]
pub enum FocusBy<'a> {
    /// The whole lens, before the sensor: the last gap grows.
    WholeLens,
    /// All surfaces up to this one, towards the object: the gap behind it grows. The image stays where it is.
    FrontGroup(usize),
    /// All gaps that differ between its positions of focus.
    Positions(&'a GapCurves),
}

/// Distance of the object on the axis that is in focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distance {
    /// Parallel light.
    Infinity,
    /// Distance from the first vertex, mm, which moves with the lens.
    FromFirstVertex(f64),
    /// Distance from the entrance pupil, mm, which moves with the lens.
    FromEntrancePupil(f64),
    /// Distance from the sensor, mm, as engraved on lens barrels.
    FromSensor(f64),
}

impl Distance {
    /// Distance from the first vertex, mm.
    fn before(self, lens: &Lens) -> f64 {
        match self {
            Self::Infinity => f64::INFINITY,
            Self::FromFirstVertex(distance) => distance,
            Self::FromEntrancePupil(distance) => distance - lens.at(lines::D).first_order().entrance_pupil_mm,
            Self::FromSensor(distance) => distance - lens.sensor_z_mm(),
        }
    }
}

impl Lens {
    /// Lens with its focus at a parameter: the gap in mm that changes, or the parameter of the curves.
    fn with_focus(&self, by: FocusBy<'_>, parameter: f64) -> Self {
        match by {
            FocusBy::WholeLens => self.with_gaps(&[(self.surfaces().len() - 1, parameter)]),
            FocusBy::FrontGroup(surface) => self.with_gaps(&[(surface, parameter)]),
            FocusBy::Positions(curves) => curves.set(self, parameter),
        }
    }

    /// Lens focused to first order at a wavelength: the paraxial image of the object lies on the sensor.
    pub fn focused_paraxially(&self, by: FocusBy<'_>, distance: Distance, wavelength_nm: f64) -> Result<Self, Invalid> {
        self.focused(by, distance, |lens, before| {
            let image = lens.at(wavelength_nm).image(before);
            Some(image.distance_mm - lens.gap_mm(lens.surfaces().len() - 1))
        })
    }

    /// Lens focused as a photographer does: with the least root mean square of the spot of a point on the axis at a
    /// distance, over wavelengths in nm with their weights, at the current stop. The paraxial focus of a fast lens lies
    /// elsewhere, because of spherical aberration and chromatic aberration.
    pub fn focused_by_spot(
        &self,
        by: FocusBy<'_>,
        distance: Distance,
        spectrum: &[(f64, f64)],
    ) -> Result<Self, Invalid> {
        self.focused(by, distance, |lens, before| lens.sharpest_behind_sensor_mm(before, spectrum))
    }

    /// Distance behind the sensor at which the spot of a point on the axis is smallest, mm, over wavelengths in nm with
    /// their weights. `None` where no light of it passes.
    ///
    /// A ray that lands at the height y with the slope s is at y + s·δ behind the sensor by δ: the sum of squares is
    /// least at δ = −Σ w·y·s/Σ w·s². Rays of one direction from the axis stand for all, as much as the blades of the stop leave
    /// of them.
    pub fn sharpest_behind_sensor_mm(&self, object_distance_mm: f64, spectrum: &[(f64, f64)]) -> Option<f64> {
        let (mut products, mut squares) = (0.0, 0.0);
        let round = self.with_round_stop();
        let steps = || (0..self.surfaces().len()).map(Step::refract);
        for &(wavelength_nm, weight) in spectrum {
            let at = round.at(wavelength_nm);
            let first_order = at.first_order();
            // To a little beyond the pupil's rim, where aberrations may let rays pass still.
            let rim = 0.55 * first_order.entrance_pupil_diameter_mm;
            for i in 0..RAYS {
                let height = rim * ((f64::from(i) + 0.5) / f64::from(RAYS)).sqrt();
                let pupil = DVec3::new(0.0, height, first_order.entrance_pupil_mm);
                let ray = if object_distance_mm.is_infinite() {
                    Ray { origin: DVec3::new(0.0, height, 0.0), direction: DVec3::Z }
                } else {
                    let origin = DVec3::new(0.0, 0.0, -object_distance_mm);
                    Ray { origin, direction: (pupil - origin).normalize() }
                };
                let mut within = 1.0;
                let behind = at.trace(ray, Travel::ToSensor, steps(), Apertures::Clip, |hit| {
                    if hit.surface == self.stop() {
                        within = self.part_within_blades(hit.point.truncate().length());
                    }
                });
                let Ok(behind) = behind else { continue };
                let weight = weight * within;
                let landing: DVec2 = behind.at_z(self.sensor_z_mm()).truncate();
                let slope = behind.direction.y / behind.direction.z;
                products += weight * landing.y * slope;
                squares += weight * slope * slope;
            }
        }
        (squares > 0.0).then(|| -products / squares)
    }

    /// Lens with the focus at which `behind`, the distance of the image behind the sensor, is 0, by the secant method.
    fn focused(
        &self,
        by: FocusBy<'_>,
        distance: Distance,
        behind: impl Fn(&Self, f64) -> Option<f64>,
    ) -> Result<Self, Invalid> {
        let out_of_reach = || {
            let message = match distance {
                Distance::Infinity => "the lens cannot be focused on infinity".to_owned(),
                Distance::FromFirstVertex(mm) => format!("the lens cannot be focused at {mm} mm from its first vertex"),
                Distance::FromEntrancePupil(mm) => {
                    format!("the lens cannot be focused at {mm} mm from its entrance pupil")
                }
                Distance::FromSensor(mm) => format!("the lens cannot be focused at {mm} mm from the sensor"),
            };
            Invalid::new("focus_distance_m", message)
                .help("a larger distance, or the gaps as the prescription has them")
        };
        let of = |parameter: f64| {
            let lens = self.with_focus(by, parameter);
            let before = distance.before(&lens);
            let off = (before > 0.0).then(|| behind(&lens, before)).flatten().ok_or_else(out_of_reach)?;
            Ok::<_, Invalid>((lens, off))
        };
        let least = match by {
            FocusBy::WholeLens | FocusBy::FrontGroup(_) => 0.0,
            // 1/distance of infinity, and a little beyond, since the sensor of a design need not stand in its focus.
            FocusBy::Positions(curves) => -BEYOND_INFINITY * curves.end(),
        };
        let mut last = match by {
            FocusBy::WholeLens => self.gap_mm(self.surfaces().len() - 1),
            FocusBy::FrontGroup(surface) => self.gap_mm(surface),
            FocusBy::Positions(_) => 0.0,
        };
        let mut off_last = of(last)?.1;
        let mut next = last
            + match by {
                FocusBy::WholeLens => off_last,
                FocusBy::FrontGroup(_) => FIRST_STEP * self.at(lines::D).first_order().efl_mm,
                FocusBy::Positions(curves) => FIRST_STEP * curves.end(),
            };
        let scale = (next - last).abs();
        for _ in 0..MOST_STEPS {
            let (lens, off) = of(next)?;
            let step = if off == off_last { 0.0 } else { off * (next - last) / (off - off_last) };
            if step.abs() <= PRECISION * next.abs().max(scale) {
                let is_within = match by {
                    FocusBy::WholeLens | FocusBy::FrontGroup(_) => next > least,
                    FocusBy::Positions(curves) => (least..=curves.end() * (1.0 + BEYOND_INFINITY)).contains(&next),
                };
                return if is_within { Ok(lens) } else { Err(out_of_reach()) };
            }
            (last, off_last) = (next, off);
            next -= step;
            if !next.is_finite() {
                break;
            }
        }
        Err(out_of_reach())
    }
}
