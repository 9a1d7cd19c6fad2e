//! A lens from a prescription before a sensor: focused, stopped down, and asked for its rays.
//!
//! Light takes the way of its wavelength through the glass, so that distortion, lateral and axial colour, vignetting,
//! the falloff of light and breathing are those of the lens. The camera's origin is the paraxial entrance pupil at the d
//! line of the lens as it is focused; its axes are those of the prescription.

use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3, Vec3};

use super::{Focus, LensDescription, PointSpread, Seen, spread_store};
use photosite_core::Invalid;
use photosite_core::math::monotone_cubic::MonotoneCubic;
use photosite_core::spectrum::dispersion::lines;
use photosite_lens::chief_map::ChiefMap;
use photosite_lens::entrance_table::EntranceTable;
use photosite_lens::focus::{Distance, FocusBy};
use photosite_lens::lanes::{LaneLens, LaneRay};
use photosite_lens::positions::GapCurves;
use photosite_lens::prescription::{Blades, Prescription};
use photosite_lens::pupil_table::PupilTable;
use photosite_lens::wave::{FocusSurface, WaveSpread};
use photosite_lens::{Lens, paraxial::FirstOrder};

/// Wavelengths, nm, that the table of the pupil holds for: beyond and between them apertures look the same to 2 %, which
/// the table adds.
const PUPIL_NM: [f64; 5] = [350.0, 450.0, 550.0, 750.0, 1000.0];
/// Wavelengths, nm, that the table of the entrance pupil holds for.
const ENTRANCE_NM: [f64; 3] = [350.0, 550.0, 1000.0];
/// Wavelengths, nm, and weights of the spot that is least in focus, where the description has none.
const FOCUS_NM: [(f64, f64); 5] = [(440.0, 1.0), (490.0, 1.0), (540.0, 1.0), (590.0, 1.0), (640.0, 1.0)];
/// Wavelength, nm, of chief rays, illumination and rays without a wavelength: the one that the eye sees best.
pub(super) const REFERENCE_NM: f64 = 555.0;
/// An f-number may be this much smaller than the open lens has: engravings are rounded.
const OPEN: f64 = 0.97;
/// Heights at which the illumination is worked out, and directions of the boundary then.
const HEIGHTS: usize = 33;
const DIRECTIONS: usize = 128;

/// A lens from a prescription, focused and stopped down.
#[derive(Debug)]
pub(super) struct PrescribedLens {
    lens: Lens,
    /// Figures to first order at the d line.
    first_order: FirstOrder,
    chief: ChiefMap,
    /// Distance of the image's corners from the axis, mm.
    corner_mm: f64,
    /// Distance of what is sharp from the entrance pupil, m.
    focus_distance_m: f64,
    /// Irradiance over radiance, sr, by image height in mm, at the reference wavelength. Worked out when it is asked for,
    /// as is what rays are drawn and traced by: many cameras are made that take no image.
    illumination: OnceLock<MonotoneCubic>,
    tables: OnceLock<Tables>,
    entrance: OnceLock<EntranceTable>,
    /// Point spread of waves, where points are not spread as the rays of the glass land.
    wave: Option<Arc<WaveSpread>>,
    /// Image height up to which chief rays pass all apertures, mm.
    clear_mm: OnceLock<f64>,
}

/// A ray as it starts at the sensor.
pub(super) struct Start {
    pub(super) ray: LaneRay,
    /// Solid angle of the region that the direction was drawn from, sr.
    pub(super) area: f32,
    /// The sensor point whose chief ray leads to what it meets in the plane of focus, mm from the axis, where points are
    /// spread as waves are; else where it starts.
    pub(super) image: DVec2,
}

/// A way into the lens from a point of the scene.
pub(super) struct WayIn {
    /// Point at which the way meets the first surface, m, in the camera's space.
    pub(super) front: DVec3,
    /// Ray from that point on, at any wavelength.
    pub(super) ray: LaneRay,
    /// Solid angle cos θ·A/r², sr: of the area A that it was drawn from, at the distance r, under the angle θ.
    pub(super) solid_angle: f32,
}

/// Tables by which rays are drawn and traced.
#[derive(Debug)]
struct Tables {
    pupil: PupilTable,
    lanes: LaneLens,
}

impl PrescribedLens {
    /// Zooms, stops down and focuses the lens of a prescription for an image whose corners are at `corner_mm` from the
    /// axis. `autofocus_distance_m` counts from the entrance pupil.
    pub(super) fn new(
        prescription: &Prescription,
        description: &LensDescription,
        corner_mm: f64,
        autofocus_distance_m: f64,
    ) -> Result<Self, Invalid> {
        let lens = Lens::new(&with_blades(prescription, description)).map_err(|error| error.within("prescription"))?;
        let lens = zoomed(&lens, prescription, description.focal_length_m * 1e3)?;
        let lens = stopped(lens, description.f_number)?;
        let curves = GapCurves::of_focus(&lens, &prescription.positions);
        let by = curves.as_ref().map_or(FocusBy::WholeLens, FocusBy::Positions);
        let spectrum = if description.focus_spectrum.is_empty() { &FOCUS_NM[..] } else { &description.focus_spectrum };
        let focused = |distance: Distance, key: &str| {
            let focused = lens.focused_by_spot(by, distance, spectrum);
            focused.map_err(|error| Invalid { key: key.to_owned(), ..error })
        };
        let to_autofocus = if autofocus_distance_m.is_finite() {
            Distance::FromEntrancePupil(autofocus_distance_m * 1e3)
        } else {
            Distance::Infinity
        };
        let lens = match description.focus {
            Focus::Infinity => focused(Distance::Infinity, "focus_distance_m")?,
            Focus::Distance(u) => focused(Distance::FromSensor(u * 1e3), "focus_distance_m")?,
            Focus::Autofocus { .. } => focused(to_autofocus, "autofocus_px")?,
            Focus::ImageDistance(v) => lens.with_gaps(&[(lens.surfaces().len() - 1, v * 1e3)]),
        };
        let at = lens.at(REFERENCE_NM);
        let first_order = lens.at(lines::D).first_order();
        let no_chief = || Invalid::new("prescription", "no chief ray of this lens reaches the image beside its axis");
        let chief = ChiefMap::new(&at, corner_mm).ok_or_else(no_chief)?;
        // What is sharp on the axis to first order, seen from the sensor.
        let gap = lens.gap_mm(lens.surfaces().len() - 1);
        let focus_distance_m = match description.focus {
            Focus::Infinity => f64::INFINITY,
            Focus::Distance(u) => u - (lens.sensor_z_mm() - first_order.entrance_pupil_mm) * 1e-3,
            Focus::Autofocus { .. } => autofocus_distance_m,
            Focus::ImageDistance(_) => {
                (lens.at(lines::D).object_distance_mm(gap) + first_order.entrance_pupil_mm) * 1e-3
            }
        };
        let focus = |is_flat| FocusSurface {
            distance_mm: focus_distance_m * 1e3,
            reference_mm: first_order.entrance_pupil_mm,
            is_flat,
        };
        let is_wave = description.point_spread == Some(PointSpread::Wave);
        // In the middle of what the sensor sees.
        let (middle_nm, _) = spectrum[spectrum.len() / 2];
        let wave =
            is_wave.then(|| spread_store::known(WaveSpread::new(&lens, focus(is_flat(&chief)), corner_mm, middle_nm)));
        Ok(Self {
            wave,
            lens,
            first_order,
            chief,
            corner_mm,
            focus_distance_m,
            illumination: OnceLock::new(),
            tables: OnceLock::new(),
            entrance: OnceLock::new(),
            clear_mm: OnceLock::new(),
        })
    }

    fn tables(&self) -> &Tables {
        self.tables.get_or_init(|| {
            let pupil = PupilTable::new(&self.lens, self.corner_mm, &PUPIL_NM);
            let lanes = LaneLens::new(&self.lens, &pupil, self.corner_mm);
            Tables { pupil, lanes }
        })
    }

    /// Sensor point whose light lands at another, mm from the axis, by a sample of the point spread: light that is
    /// spread by an offset to there comes from that much before.
    #[inline]
    pub(super) fn image(&self, sensor_mm: DVec2, spread: [f32; 2], wavelength_nm: f32) -> DVec2 {
        sensor_mm - self.offset(sensor_mm, wavelength_nm, spread)
    }

    /// The start of a ray for a sensor point, mm from the axis, by a sample of the pupil; `None` where no light reaches.
    #[inline]
    pub(super) fn start(&self, image: DVec2, sample: [f32; 2], wavelength_nm: f32) -> Option<Start> {
        let direction = self.tables().pupil.sample(image, sample.map(f64::from))?;
        let ray = LaneRay::from_sensor(image, direction.cosines, wavelength_nm);
        Some(Start { ray, area: direction.area as f32, image })
    }

    /// Distance from the middle of a point's image at which rays land, and the distance that the tabulated point spread
    /// reaches, mm, at the reference wavelength, where points are spread as waves are; `None` where it reaches as far.
    pub(super) fn beyond_reach_mm(&self) -> Option<[f64; 2]> {
        self.wave.as_ref()?.beyond_reach_mm(REFERENCE_NM)
    }

    /// Whether both lenses share their point spreads in memory.
    #[cfg(test)]
    pub(super) fn shares_images_of_points(&self, other: &Self) -> bool {
        self.wave.as_ref().zip(other.wave.as_ref()).is_some_and(|(one, other)| Arc::ptr_eq(one, other))
    }

    /// Whether points are spread as waves are.
    pub(super) fn spreads_waves(&self) -> bool {
        self.wave.is_some()
    }

    /// Offset from the place where a chief ray lands to the one where light does, mm, where points are spread as waves
    /// are.
    #[inline]
    fn offset(&self, sensor_mm: DVec2, wavelength_nm: f32, spread: [f32; 2]) -> DVec2 {
        let offset = |wave: &WaveSpread| wave.offset(sensor_mm, wavelength_nm.into(), spread.map(f64::from));
        self.wave.as_deref().map_or(DVec2::ZERO, offset)
    }

    /// Aims a ray by the point spread: where points are spread as waves are, turns a ray that has come out into the
    /// scene to the point in focus that the chief ray of its [`Start::image`] meets.
    ///
    /// Rays from one sensor point that a lens without aberrations leads through one point there are those of the glass but
    /// for these, as far as they are within the lens: what passes and what it weighs stays as it is.
    #[inline]
    pub(super) fn aim(&self, out: &mut LaneRay, image: DVec2) {
        let Some(wave) = &self.wave else { return };
        if out.passed <= 0.0 {
            return;
        }
        match wave.aim(out.point.as_dvec3(), image, out.wavelength_nm.into()) {
            Some(direction) => out.direction = direction.as_vec3(),
            None => out.passed = 0.0,
        }
    }

    /// Place where light that has come in lands, mm from the axis, if it does: as its ray, or where points are spread
    /// as waves are about where the chief ray lands of what the ray `(point, direction)` out in the scene meets in the
    /// plane of focus.
    #[inline]
    pub(super) fn landing(&self, inside: &LaneRay, outside: (Vec3, Vec3), spread: [f32; 2]) -> Option<DVec2> {
        let Some(wave) = &self.wave else { return Some(inside.point.truncate().as_dvec2()) };
        let (point, direction) = outside;
        let nm = inside.wavelength_nm;
        let image = wave.place(point.as_dvec3(), direction.as_dvec3(), nm.into())?;
        Some(image + self.offset(image, nm, spread))
    }

    /// Area in sr of the region that directions are drawn from at a sensor point, mm from the axis.
    #[inline]
    pub(super) fn area(&self, sensor_mm: DVec2) -> f32 {
        self.tables().pupil.area(sensor_mm) as f32
    }

    /// Leads rays out into the scene.
    pub(super) fn trace_out(&self, rays: &mut [LaneRay]) {
        self.tables().lanes.trace_out(rays);
    }

    /// Leads rays from the scene in to the sensor.
    pub(super) fn trace_in(&self, rays: &mut [LaneRay]) {
        self.tables().lanes.trace_in(rays);
    }

    fn entrance(&self) -> &EntranceTable {
        self.entrance.get_or_init(|| EntranceTable::new(&self.lens, &self.tables().pupil, self.corner_mm, &ENTRANCE_NM))
    }

    /// The distance in m from the first surface below which nothing is led in from a point of the scene.
    pub(super) fn least_distance_m(&self) -> f64 {
        self.entrance().least_distance_mm() * 1e-3
    }

    /// A way in from a point of the camera's space, m, by a sample of the entrance pupil; `None` where no light of it comes
    /// to the image, and nearer than [`Self::least_distance_m`].
    pub(super) fn way_in(&self, point: DVec3, sample: [f32; 2]) -> Option<WayIn> {
        let point_mm = point * 1e3 + DVec3::new(0.0, 0.0, self.first_order.entrance_pupil_mm);
        let table = self.entrance();
        let entrance = table.sample(point_mm, sample.map(f64::from))?;
        let to_pupil = entrance.point - point_mm;
        let direction = to_pupil.normalize();
        let front_mm = self.lens.front_point(point_mm, direction)?;
        if front_mm.distance(point_mm) < table.least_distance_mm() {
            return None;
        }
        let solid_angle = entrance.area_mm2 * direction.dot(entrance.normal).abs() / to_pupil.length_squared();
        let ray = LaneRay {
            point: front_mm.as_vec3(),
            direction: direction.as_vec3(),
            wavelength_nm: REFERENCE_NM as f32,
            passed: 1.0,
        };
        Some(WayIn { front: self.to_camera(front_mm), ray, solid_angle: solid_angle as f32 })
    }

    /// A point of a ray before the lens, m, in the camera's space, and its direction.
    #[inline]
    pub(super) fn before_lens(&self, ray: &LaneRay) -> (DVec3, DVec3) {
        (self.to_camera(ray.point.as_dvec3()), ray.direction.as_dvec3())
    }

    /// The largest image height that light reaches, mm; that of the corners where it reaches these.
    pub(super) fn lit_mm(&self) -> f64 {
        self.tables().pupil.lit_mm()
    }

    /// View of a sensor point, mm from the axis, along its chief ray: from the point at which that crosses the plane of
    /// the camera's origin, of a lens that sees less than a half-space, else from its own entrance pupil. The solid
    /// angle is that over the area of the sensor in units of [`Self::scale_mm`].
    pub(super) fn seen(&self, sensor_mm: DVec2) -> Option<(DVec3, Seen)> {
        let sighting = self.chief.sighting(sensor_mm)?;
        let direction = sighting.direction;
        let pupil = self.to_camera(DVec3::new(0.0, 0.0, sighting.pupil_mm));
        let (origin, chief) = if self.is_flat() {
            let chief = direction / -direction.z;
            (pupil + chief * pupil.z, chief)
        } else {
            (pupil, direction)
        };
        let height = sensor_mm.length();
        let step = 1e-4 * self.corner_mm;
        let field = |height: f64| self.chief.field_rad(height);
        let slope = (field(height + step).or(field(height))? - field((height - step).max(0.0))?)
            / (step.min(self.chief.highest_mm() - height).max(0.0) + step.min(height));
        let scale = self.scale_mm();
        // dΩ = sin θ dθ dφ over r dr dφ, r = h/scale.
        let bend = if height > 0.0 { field(height)?.sin() * scale / height } else { 1.0 };
        Some((origin, Seen { direction, chief, solid_angle: bend * slope * scale }))
    }

    /// The sensor point, mm from the axis, on which a point of the camera's space, m, is seen by its chief ray.
    pub(super) fn place(&self, point: DVec3) -> Option<DVec2> {
        self.chief.place(point * 1e3 + DVec3::new(0.0, 0.0, self.first_order.entrance_pupil_mm))
    }

    /// Irradiance over radiance of uniform light, sr, at an image height in mm, without the losses of surfaces.
    pub(super) fn illumination_sr(&self, height_mm: f64) -> f64 {
        let curve = self.illumination.get_or_init(|| {
            let at = self.lens.at(REFERENCE_NM);
            let heights: Vec<f64> = (0..HEIGHTS).map(|i| self.corner_mm * i as f64 / (HEIGHTS - 1) as f64).collect();
            let areas = heights.iter().map(|height| at.pupil_region(*height, DIRECTIONS).map_or(0.0, |r| r.area()));
            MonotoneCubic::new(heights.clone(), areas.collect()).expect("heights rise")
        });
        curve.eval(height_mm.min(self.corner_mm)).max(0.0)
    }

    /// The f-number whose cone of light, 1/(2·sin u′), is as much as comes to the middle of the image at the reference
    /// wavelength: |S| = π·sin² u′.
    pub(super) fn working_f_number(&self) -> f64 {
        let axis_sr = self.lens.at(REFERENCE_NM).pupil_region(0.0, DIRECTIONS).map_or(0.0, |region| region.area());
        0.5 / (axis_sr / std::f64::consts::PI).sqrt()
    }

    /// Image height up to which chief rays pass all apertures, mm; infinite where all of the image's do.
    pub(super) fn clear_height_mm(&self) -> f64 {
        *self.clear_mm.get_or_init(|| self.lens.at(REFERENCE_NM).clear_height_mm(self.chief.widest_stop_rad()))
    }

    /// Distance from the first vertex to the sensor, m.
    pub(super) fn length_m(&self) -> f64 {
        self.lens.sensor_z_mm() * 1e-3
    }

    /// The distance mm at which a pinhole has the scale of the image on the axis: dh/dθ.
    pub(super) fn scale_mm(&self) -> f64 {
        let height = 1e-3 * self.corner_mm;
        self.chief.field_rad(height).map_or(self.first_order.efl_mm, |field| height / field.tan())
    }

    /// Whether the lens is focused on a plane, and sees less than a half-space.
    pub(super) fn is_flat(&self) -> bool {
        is_flat(&self.chief)
    }

    /// Figures to first order at the d line.
    pub(super) fn first_order(&self) -> &FirstOrder {
        &self.first_order
    }

    /// Distance of what is sharp from the entrance pupil, m.
    pub(super) fn focus_distance_m(&self) -> f64 {
        self.focus_distance_m
    }

    /// Distance from the last vertex to the sensor, m.
    pub(super) fn last_gap_m(&self) -> f64 {
        self.lens.gap_mm(self.lens.surfaces().len() - 1) * 1e-3
    }

    /// The greatest field angle that it knows, rad.
    pub(super) fn widest_rad(&self) -> f64 {
        self.chief.widest_rad()
    }

    /// The image height at that angle, mm.
    pub(super) fn highest_mm(&self) -> f64 {
        self.chief.highest_mm()
    }

    /// Converts a point from mm of the prescription to m about the entrance pupil.
    fn to_camera(&self, point: DVec3) -> DVec3 {
        (point - DVec3::new(0.0, 0.0, self.first_order.entrance_pupil_mm)) * 1e-3
    }
}

/// Part of 90° up to which a lens counts as one with a flat image.
const FLAT: f64 = 0.9;

fn is_flat(chief: &ChiefMap) -> bool {
    chief.widest_rad() < FLAT * FRAC_PI_2
}

fn with_blades(prescription: &Prescription, description: &LensDescription) -> Prescription {
    let blades = Blades { count: description.blades, rotation_deg: description.blade_rotation_deg };
    let blades = if description.blades > 0 { Some(blades) } else { prescription.blades };
    Prescription { blades, ..prescription.clone() }
}

fn zoomed(lens: &Lens, prescription: &Prescription, focal_length_mm: f64) -> Result<Lens, Invalid> {
    let own = lens.at(lines::D).first_order().efl_mm;
    if (focal_length_mm / own - 1.0).abs() < 1e-6 {
        return Ok(lens.clone());
    }
    lens.zoomed(&prescription.positions, focal_length_mm)
}

fn stopped(lens: Lens, f_number: f64) -> Result<Lens, Invalid> {
    let at = lens.at(lines::D);
    let open = at.first_order().f_number;
    if f_number < OPEN * open {
        let message = format!("the lens opens to f/{open:.3}, not to f/{f_number}");
        return Err(Invalid::new("f_number", message).help(format!("f_number = {open:.2} or more")));
    }
    let radius = at.stop_radius_of_f_number(f_number).min(lens.stop_radius_mm());
    Ok(lens.with_stop_radius(radius))
}
