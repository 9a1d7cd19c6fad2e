//! Sampling of the entrance pupil from points of the scene so that most rays pass, for light paths into the lens.
//!
//! Light that a point y of the scene sends to the area dA of a plane at the distance r arrives with the étendue cos
//! θ_y·cos θ·dA/r², which the lens keeps. The plane contains a point of the axis, the paraxial entrance pupil, across
//! the line from there to y: so the polygon around the passing light changes little with the angle θ between that line
//! and the axis, and with the distance. The table holds polygons by the angle and by the reciprocal of the distance,
//! between which they are interpolated.

use glam::{DVec2, DVec3};

use crate::lens::Lens;
use crate::profile::Travel;
use crate::pupil_table::PupilTable;
use crate::support_polygon::SupportPolygon;
use crate::trace::{Apertures, LensAt, Ray};

/// Number of polygons by angle, closer to each other the farther off the axis, where they change most; and by
/// reciprocal distance, closer to each other the farther away, where most scenes are.
const ANGLES: usize = 33;
const CLOSENESSES: usize = 6;
/// Reciprocal distance that counts as 0: so far away that the rest of the way to infinity makes no difference.
const FAR: f64 = 1e-9;
/// Number of places on the line away from the axis at which passing light is searched for.
const PLACES: u32 = 64;
/// Number of image heights, and of directions for each, of rays from the image that find the greatest angle to the
/// axis.
const HEIGHTS: u32 = 33;
const DIRECTIONS: u32 = 32;
/// Margin of the table's angles over the found ones.
const BEYOND: f64 = 1.02;
/// Radius of the search for a polygon relative to the one before, and margin of polygons over the found ones.
const WIDER: f64 = 3.0;
const MARGIN: f64 = 0.02;

/// Pupil as seen from points of the scene.
#[derive(Clone, Debug)]
pub struct EntranceTable {
    /// Point of reference on the axis, mm from the first vertex.
    reference_mm: f64,
    /// Least distance of the table from the point of reference, mm.
    nearest_mm: f64,
    /// Greatest angle to the axis from which light reaches the image, by closeness.
    widest_rad: [f64; CLOSENESSES],
    /// Polygons by closeness and angle; `None` where no light passes.
    polygons: Vec<Option<SupportPolygon>>,
}

/// A sampled point of the entrance pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entrance {
    /// Point, mm, z = 0 at the first vertex. The ray to it goes on into the lens.
    pub point: DVec3,
    /// Unit normal of the plane that the point was drawn on.
    pub normal: DVec3,
    /// Area of the polygon that the point was drawn from, mm².
    pub area_mm2: f64,
}

/// Position of a scene point, and the plane across its line to the point of reference.
struct ScenePoint {
    angle_rad: f64,
    distance_mm: f64,
    /// Unit vectors towards the point, and in the plane: across the axis, and away from it.
    towards: DVec3,
    across: DVec3,
    away: DVec3,
}

impl ScenePoint {
    fn new(reference_mm: f64, point: DVec3) -> Self {
        let from_reference = point - DVec3::new(0.0, 0.0, reference_mm);
        let (distance_mm, off) = (from_reference.length(), from_reference.truncate().length());
        let radial = if off > 0.0 { from_reference.truncate() / off } else { DVec2::Y };
        let (sin, cos) = (off / distance_mm, -from_reference.z / distance_mm);
        Self {
            angle_rad: off.atan2(-from_reference.z),
            distance_mm,
            towards: from_reference / distance_mm,
            across: DVec3::new(-radial.y, radial.x, 0.0),
            away: (radial * cos).extend(sin),
        }
    }

    /// Point in space of a place in the plane.
    fn in_space(&self, reference_mm: f64, place: DVec2) -> DVec3 {
        self.across * place.x + self.away * place.y + DVec3::new(0.0, 0.0, reference_mm)
    }
}

impl EntranceTable {
    /// Table of a lens for all light that reaches image heights up to one in mm, at wavelengths in nm, of which the
    /// middle one determines the centres; `pupil` is the pupil table of the same lens. A stop with blades counts as
    /// round.
    pub fn new(lens: &Lens, pupil: &PupilTable, highest_mm: f64, wavelengths_nm: &[f64]) -> Self {
        let lens = lens.with_round_stop();
        let at: Vec<LensAt<'_>> = wavelengths_nm.iter().map(|nm| lens.at(*nm)).collect();
        let middle = &at[at.len() / 2];
        let pupil_mm = middle.first_order().entrance_pupil_mm;
        // Of lenses that are telecentric it is far away.
        let reference_mm = if pupil_mm.is_finite() { pupil_mm.clamp(0.0, lens.sensor_z_mm()) } else { 0.0 };
        let nearest_mm = lens.front_reach_mm(reference_mm);
        let widest_rad = widest(&at, pupil, highest_mm, (reference_mm, nearest_mm)).map(|widest| BEYOND * widest);
        let pupil_radius_mm = 0.5 * middle.first_order().entrance_pupil_diameter_mm.abs().min(2.0 * nearest_mm);
        let build = Build { at: &at, reference_mm, nearest_mm, widest_rad, pupil_radius_mm };
        let mut polygons: Vec<Option<SupportPolygon>> = Vec::with_capacity(ANGLES * CLOSENESSES);
        let mut lit = [0; CLOSENESSES];
        for (closeness, lit) in lit.iter_mut().enumerate() {
            // From the axis out, each near the one before. Beyond the last angle at which light passes, polygons go on as
            // they were and a little larger: in between what passes shrinks to nothing.
            let (mut last, mut step): (Option<SupportPolygon>, f64) = (None, 0.0);
            for angle in 0..ANGLES {
                let next = last.map(|last| last.moved(step, 0.0));
                let found = if *lit == angle { build.polygon(angle as f64, closeness as f64, next) } else { None };
                *lit += usize::from(found.is_some());
                let polygon = found.or(next.map(|next| next.moved(0.0, step.abs())));
                step = polygon.zip(last).map_or(0.0, |(polygon, last)| polygon.centre() - last.centre());
                polygons.push(polygon);
                last = polygon;
            }
        }
        // Where polygons bend, light reaches farther out between them than they say.
        let mut lacking = vec![0.0_f64; polygons.len()];
        for i in 0..(ANGLES - 1) * (CLOSENESSES - 1) {
            let (angle, closeness) = (i % (ANGLES - 1), i / (ANGLES - 1));
            let around = [0, 1, ANGLES, ANGLES + 1].map(|number| closeness * ANGLES + angle + number);
            let [Some(a), Some(b), Some(c), Some(d)] = around.map(|number| polygons[number]) else { continue };
            let between = SupportPolygon::mixed(&[(&a, 0.25), (&b, 0.25), (&c, 0.25), (&d, 0.25)]);
            let is_lit = angle + 1 < lit[closeness].min(lit[closeness + 1]);
            let middle =
                is_lit.then(|| build.polygon(angle as f64 + 0.5, closeness as f64 + 0.5, Some(between))).flatten();
            let lacks = middle.map_or(0.0, |middle| between.lacks(&middle));
            around.iter().for_each(|number| lacking[*number] = lacking[*number].max(lacks));
        }
        for (polygon, lacking) in polygons.iter_mut().zip(lacking) {
            *polygon = polygon.map(|polygon| polygon.moved(0.0, lacking + MARGIN * polygon.radius()));
        }
        Self { reference_mm, nearest_mm, widest_rad, polygons }
    }

    /// Distance, mm, between a scene point and the point where its light meets the first surface, below which the scene
    /// point may be nearer to the lens than the table's least distance.
    pub fn least_distance_mm(&self) -> f64 {
        2.0 * self.nearest_mm
    }

    /// Draws a point of the pupil for a point of the scene, mm, z = 0 at the first vertex; `None` where none of its
    /// light reaches the image.
    pub fn sample(&self, point: DVec3, u: [f64; 2]) -> Option<Entrance> {
        let sight = ScenePoint::new(self.reference_mm, point);
        let (place, area_mm2) = self.polygon(&sight)?.sample(u)?;
        Some(Entrance { point: sight.in_space(self.reference_mm, place), normal: sight.towards, area_mm2 })
    }

    /// Whether the table may draw the point at which a ray from a scene point, unit direction, meets the plane.
    pub fn contains(&self, point: DVec3, direction: DVec3) -> bool {
        let sight = ScenePoint::new(self.reference_mm, point);
        let Some(polygon) = self.polygon(&sight) else { return false };
        let to_plane = sight.distance_mm / -direction.dot(sight.towards);
        let place = point + direction * to_plane - DVec3::new(0.0, 0.0, self.reference_mm);
        to_plane > 0.0 && polygon.contains(DVec2::new(place.dot(sight.across), place.dot(sight.away)))
    }

    /// Polygon for a scene point.
    fn polygon(&self, sight: &ScenePoint) -> Option<SupportPolygon> {
        if sight.distance_mm < self.nearest_mm {
            return None;
        }
        let y = (self.nearest_mm / sight.distance_mm).sqrt() * (CLOSENESSES - 1) as f64;
        let j = (y as usize).min(CLOSENESSES - 2);
        let y = y - j as f64;
        let part = sight.angle_rad / (self.widest_rad[j] * (1.0 - y) + self.widest_rad[j + 1] * y);
        if part > 1.0 {
            return None;
        }
        let x = (1.5 - (2.25 - 2.0 * part).sqrt()) * (ANGLES - 1) as f64;
        let i = (x as usize).min(ANGLES - 2);
        let x = x - i as f64;
        let of = |number: usize| self.polygons[number].as_ref();
        let first = j * ANGLES + i;
        Some(SupportPolygon::mixed(&[
            (of(first)?, (1.0 - x) * (1.0 - y)),
            (of(first + 1)?, x * (1.0 - y)),
            (of(first + ANGLES)?, (1.0 - x) * y),
            (of(first + ANGLES + 1)?, x * y),
        ]))
    }
}

/// Inputs for computing the polygons.
struct Build<'a> {
    at: &'a [LensAt<'a>],
    reference_mm: f64,
    nearest_mm: f64,
    widest_rad: [f64; CLOSENESSES],
    pupil_radius_mm: f64,
}

impl Build<'_> {
    /// Polygon at an angle and a closeness in steps of the table, near another polygon; `None` where no light passes.
    fn polygon(&self, angle: f64, closeness: f64, near: Option<SupportPolygon>) -> Option<SupportPolygon> {
        let (low, high) = (closeness.floor() as usize, closeness.ceil() as usize);
        let widest_rad = 0.5 * (self.widest_rad[low] + self.widest_rad[high]);
        let angle = widest_rad * part_of(angle / (ANGLES - 1) as f64);
        let closeness = closeness_at(closeness);
        let reference = DVec3::new(0.0, 0.0, self.reference_mm);
        let (sin, cos) = angle.sin_cos();
        let point = reference + DVec3::new(0.0, sin, -cos) * (self.nearest_mm / closeness);
        let sight = ScenePoint::new(self.reference_mm, point);
        let passes = |wavelength: usize, place: DVec2| {
            let target = sight.in_space(self.reference_mm, place);
            let ray = Ray { origin: target, direction: (target - point).normalize() };
            self.at[wavelength].trace_in(ray, Apertures::Clip).is_ok()
        };
        // What passes is its own mirror image, and convex but for little: where there is any, there is some on the line
        // away from the axis.
        let (about, reach) =
            near.map_or((0.0, WIDER * self.pupil_radius_mm), |near| (near.centre(), WIDER * near.radius()));
        let place = |i: u32| about + reach * (2.0 * (f64::from(i) + 0.5) / f64::from(PLACES) - 1.0);
        let is_inside = |place: &f64| passes(self.at.len() / 2, DVec2::new(0.0, *place));
        let inside: Vec<f64> = (0..PLACES).map(place).filter(is_inside).collect();
        let centre = 0.5 * (inside.first()? + inside.last()?);
        let circle = (DVec2::new(0.0, centre), reach);
        Some(SupportPolygon::around(passes, self.at.len(), centre, circle))
    }
}

/// Fraction of the greatest angle at a fraction `x` of the polygons.
fn part_of(x: f64) -> f64 {
    x * (1.5 - 0.5 * x)
}

/// Least distance over the distance at a step of the table.
fn closeness_at(step: f64) -> f64 {
    (step / (CLOSENESSES - 1) as f64).powi(2).max(FAR)
}

/// Greatest angle to the axis, by closeness, at which the point of reference sees scene points whose light reaches the
/// image.
fn widest(
    at: &[LensAt<'_>],
    pupil: &PupilTable,
    highest_mm: f64,
    (reference_mm, nearest_mm): (f64, f64),
) -> [f64; CLOSENESSES] {
    let reference = DVec3::new(0.0, 0.0, reference_mm);
    let mut widest = [0.0_f64; CLOSENESSES];
    for i in 0..HEIGHTS * DIRECTIONS {
        let point = DVec2::new(0.0, highest_mm * f64::from(i / DIRECTIONS) / f64::from(HEIGHTS - 1));
        let around = (f64::from(i % DIRECTIONS) + 0.5) / f64::from(DIRECTIONS);
        let Some(direction) = pupil.sample(point, [around, 1.0]) else { continue };
        for at in at {
            // Unclipped: what the table draws beyond the rims widens the angles a little.
            let ray = at.ray_from_sensor(point, direction.cosines);
            let Ok(out) = at.trace_out(ray, Apertures::Ignore) else { continue };
            let from_reference = out.origin - reference;
            let along = from_reference.dot(out.direction);
            for (closeness, widest) in widest.iter_mut().enumerate() {
                // Where the ray is at that distance, else where it leaves the lens.
                let distance = nearest_mm / closeness_at(closeness as f64);
                let ahead = along * along + distance * distance - from_reference.length_squared();
                let there = from_reference + out.direction * (ahead.max(0.0).sqrt() - along).max(0.0);
                *widest = widest.max(there.truncate().length().atan2(-there.z));
            }
        }
    }
    widest
}

impl Lens {
    /// Greatest distance of the first surface from a point of the axis, mm.
    fn front_reach_mm(&self, reference_mm: f64) -> f64 {
        let front = &self.surfaces()[0];
        let semi = front.semi_aperture_mm;
        let rim = front.profile.sag(semi * semi).unwrap_or(0.0);
        [DVec2::new(0.0, reference_mm), DVec2::new(semi, reference_mm - rim)]
            .into_iter()
            .map(DVec2::length)
            .fold(0.0, f64::max)
    }

    /// Point at which light from a scene point, mm, in a unit direction meets the first surface; `None` where it
    /// misses.
    pub fn front_point(&self, point: DVec3, direction: DVec3) -> Option<DVec3> {
        let met = self.surfaces()[0].profile.meet(point, direction, Travel::ToSensor)?;
        (met.distance > 0.0).then_some(met.point)
    }
}
