//! Tracing of many rays side by side in single precision, as images take them by the million.
//!
//! The formulas are those of [`trace`](crate::trace) and [`profile`](crate::profile), for as many rays at a time as a
//! register has room for, each at a wavelength of its own. Points count from the vertex of the surface that a ray comes to,
//! so that little is lost: less than 1e-4 mm in the image.

use glam::{DVec2, Vec3};
use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM};
use photosite_simd::{MAX_LANES, Simd, Vector, WideLanes, WithSimd, dispatch_wide};

use crate::films::{Films, TERMS};
use crate::lane_surface::{LaneSurface, Rays};
use crate::lens::Lens;
use crate::profile::Travel;
use crate::pupil_table::PupilTable;
use crate::trace::{Apertures, Step};

/// Numbers of image heights and of points about the pupil, and wavelengths, nm, of the rays that find how steeply
/// surfaces are met.
const HEIGHTS: u32 = 17;
const DIRECTIONS: u32 = 32;
const WAVELENGTHS_NM: [f64; 3] = [400.0, 550.0, 900.0];
/// Margin of rays steeper than those, as a cosine.
const STEEPER: f64 = 0.03;

/// A lens whose surfaces, indices and films are tabulated for rays in lanes.
#[derive(Clone, Debug)]
pub struct LaneLens {
    /// Surfaces as met by light from the scene, and by light from the sensor.
    to_sensor: Vec<LaneSurface>,
    to_scene: Vec<LaneSurface>,
    films: Films,
    /// Distance from the last vertex to the sensor, mm.
    last_gap_mm: f32,
}

/// A ray before a lens, or behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneRay {
    /// Point, mm: before the lens from the first vertex, behind it from the middle of the sensor.
    pub point: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Wavelength, 300 to 1100 nm, rounded to whole nanometres.
    pub wavelength_nm: f32,
    /// Fraction of the light that the surfaces transmit; 0 for a blocked ray.
    pub passed: f32,
}

impl LaneRay {
    /// Ray from a sensor point, mm from the axis, with the direction cosines p and q.
    pub fn from_sensor(point: DVec2, cosines: DVec2, wavelength_nm: f32) -> Self {
        let z = -(1.0 - cosines.length_squared()).max(0.0).sqrt();
        let direction = cosines.extend(z).as_vec3();
        Self { point: point.as_vec2().extend(0.0), direction, wavelength_nm, passed: 1.0 }
    }

    /// Ray of the same line at another wavelength.
    #[must_use]
    pub fn at_wavelength(&self, wavelength_nm: f32) -> Self {
        Self { wavelength_nm, ..*self }
    }

    /// Reversed ray at another wavelength, with all its light.
    #[must_use]
    pub fn back(&self, wavelength_nm: f32) -> Self {
        Self { direction: -self.direction, wavelength_nm, passed: 1.0, ..*self }
    }
}

impl LaneLens {
    /// Lens tabulated for the rays of a pupil, of image heights up to one in mm.
    pub fn new(lens: &Lens, pupil: &PupilTable, highest_mm: f64) -> Self {
        let count = lens.surfaces().len();
        Self {
            to_sensor: (0..count).map(|number| LaneSurface::new(lens, number, Travel::ToSensor)).collect(),
            to_scene: (0..count).rev().map(|number| LaneSurface::new(lens, number, Travel::ToScene)).collect(),
            films: Films::new(lens, &steepest(lens, pupil, highest_mm)),
            last_gap_mm: lens.gap_mm(count - 1) as f32,
        }
    }

    /// Traces rays from the sensor out into the scene, to points on the first surface.
    pub fn trace_out(&self, rays: &mut [LaneRay]) {
        dispatch_wide(Trace { lens: self, travel: Travel::ToScene, rays });
    }

    /// Traces rays from the scene in, to the plane of the sensor.
    pub fn trace_in(&self, rays: &mut [LaneRay]) {
        dispatch_wide(Trace { lens: self, travel: Travel::ToSensor, rays });
    }
}

/// Smallest cosine, in the thinner medium, at which rays of a pupil meet each surface.
fn steepest(lens: &Lens, pupil: &PupilTable, highest_mm: f64) -> Vec<f64> {
    let count = lens.surfaces().len();
    let mut steepest = vec![1.0_f64; count];
    for nm in WAVELENGTHS_NM {
        let at = lens.at(nm);
        for i in 0..HEIGHTS * DIRECTIONS {
            let point = DVec2::new(0.0, highest_mm * f64::from(i / DIRECTIONS) / f64::from(HEIGHTS - 1));
            let around = (f64::from(i % DIRECTIONS) + 0.5) / f64::from(DIRECTIONS);
            let Some(direction) = pupil.sample(point, [around, 1.0]) else { continue };
            let ray = at.ray_from_sensor(point, direction.cosines);
            // Rays that end on the way have met what comes before.
            let _ = at.trace(ray, Travel::ToScene, (0..count).rev().map(Step::refract), Apertures::Ignore, |hit| {
                let cosine = hit.cos_incidence.min(hit.turned.dot(hit.normal));
                steepest[hit.surface] = steepest[hit.surface].min(cosine - STEEPER);
            });
        }
    }
    steepest
}

/// Operation that traces rays through a lens, one way.
struct Trace<'a> {
    lens: &'a LaneLens,
    travel: Travel,
    rays: &'a mut [LaneRay],
}

impl WithSimd for Trace<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lens, travel, rays } = self;
        let surfaces = match travel {
            Travel::ToSensor => &lens.to_sensor,
            Travel::ToScene => &lens.to_scene,
        };
        let mut films = vec![[[0.0; MAX_LANES]; TERMS]; surfaces.len()];
        for group in rays.chunks_mut(S::Wide::COUNT) {
            // The films of all wavelengths, long before they are needed: what was stored number by number is slow to load
            // as a whole at once
            for (lane, ray) in group.iter().enumerate() {
                let nm = ray.wavelength_nm.clamp(LAMBDA_MIN_NM, LAMBDA_MAX_NM) - LAMBDA_MIN_NM;
                let of_wavelength = lens.films.at((nm + 0.5) as usize);
                for (surface, films) in surfaces.iter().zip(&mut films) {
                    let terms = of_wavelength[surface.number].terms(travel);
                    for i in 0..TERMS {
                        films[i][lane] = terms[i];
                    }
                }
            }
            let mut lanes = load(simd, group, travel);
            if travel == Travel::ToScene {
                // In the plane of the last vertex
                lanes.go_to(-lens.last_gap_mm, 0.0);
            }
            for (surface, films) in surfaces.iter().zip(&films) {
                let met = lanes.meet(surface);
                lanes.clip(surface, &met);
                if !lanes.any() {
                    break;
                }
                if surface.is_of_glass {
                    let mut terms = [simd.broadcast_wide(0.0); TERMS];
                    for i in 0..TERMS {
                        terms[i] = simd.load_wide(&films[i]);
                    }
                    lanes.refract(&met, &terms, lens.films.range(surface.number));
                }
                lanes.point.z = lanes.point.z - simd.broadcast_wide(surface.gap_mm);
            }
            if travel == Travel::ToSensor {
                lanes.go_to(0.0, 0.0);
            }
            store(group, &lanes, travel);
        }
    }
}

/// Loads a group of rays into lanes, with z along their way.
#[inline(always)]
fn load<S: Simd>(simd: S, group: &[LaneRay], travel: Travel) -> Rays<S::Wide> {
    let sign = travel.sign() as f32;
    let mut columns = [[0.0; MAX_LANES]; 7];
    for (lane, ray) in group.iter().enumerate() {
        let (Vec3 { x, y, z }, direction) = (ray.point, ray.direction);
        [columns[0][lane], columns[1][lane], columns[2][lane]] = [x, y, sign * z];
        [columns[3][lane], columns[4][lane], columns[5][lane]] = [direction.x, direction.y, sign * direction.z];
        columns[6][lane] = ray.passed;
    }
    let [x, y, z, p, q, r, passed] = &columns;
    Rays {
        point: Vector::new(simd.load_wide(x), simd.load_wide(y), simd.load_wide(z)),
        direction: Vector::new(simd.load_wide(p), simd.load_wide(q), simd.load_wide(r)),
        passed: simd.load_wide(passed),
    }
}

/// Stores lanes into a group of rays.
#[inline(always)]
fn store<W: WideLanes>(group: &mut [LaneRay], lanes: &Rays<W>, travel: Travel) {
    let sign = travel.sign() as f32;
    let Rays { point, direction, passed } = lanes;
    let [x, y, z] = [point.x.store_wide(), point.y.store_wide(), point.z.store_wide()];
    let [p, q, r] = [direction.x.store_wide(), direction.y.store_wide(), direction.z.store_wide()];
    let passed = passed.store_wide();
    for (lane, ray) in group.iter_mut().enumerate() {
        ray.point = Vec3::new(x[lane], y[lane], sign * z[lane]);
        ray.direction = Vec3::new(p[lane], q[lane], sign * r[lane]);
        ray.passed = passed[lane];
    }
}
