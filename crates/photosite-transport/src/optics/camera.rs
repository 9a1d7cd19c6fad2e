//! Rays from the sensor through the lens into the scene, and the weight that makes irradiance of their radiance.
//!
//! Camera space is that of glTF: x right, y up, the camera looks along −z, the origin is the centre of the lens. The
//! sensor stands at z = +v, where the picture lies upside down.

mod sample;

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};

use super::aperture::Aperture;
use super::{
    Falloff, FieldOfView, Focus, Intrinsics, LateralColour, LensDescription, LensKind, PointSpread, Projection, Reach,
    ReachEnd, Recording, Seen, Stop,
};
use crate::geometry::Ray;
use photosite_core::Invalid;
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

pub use sample::CameraSample;

/// The grid of pixels behind the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    /// Columns and rows.
    pub resolution: [u32; 2],
    /// Width and height of a pixel, m.
    pub pitch_m: [f64; 2],
}

/// A lens in front of a pixel grid, placed in the world.
#[derive(Clone, Debug)]
pub struct Camera {
    to_world: DAffine3,
    kind: LensKind,
    aperture: Aperture,
    /// Distance lens → plane of focus along the axis, m; infinite where focused at infinity.
    focus_distance_m: f64,
    /// Distance lens → sensor, m.
    image_distance_m: f64,
    resolution: [u32; 2],
    /// Width and height of a pixel, m.
    pitch_m: [f64; 2],
    intrinsics: Intrinsics,
    projection: Projection,
    reach: Reach,
    falloff: Falloff,
    /// Irradiance on the axis over the mean radiance over the aperture, sr.
    on_axis_sr: f64,
    /// What a sample of the aperture counts before the falloff, sr.
    sample_sr: f64,
    /// Distance lens → sensor over the diameter of the aperture.
    working_f_number: f64,
    point_spread: Option<PointSpread>,
    lateral_colour: Option<LateralColour>,
    stops: Vec<Stop>,
    /// `None` where nothing moves.
    recording: Option<Recording>,
    /// Which part of the picture's time has gone by, 0 to 1, where it is always the same.
    time: f32,
    /// Whether all lines of the picture are seen by one row of pixels.
    scans: bool,
}

/// A ray into the scene and what its radiance counts.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// In world space, direction of unit length.
    pub ray: Ray,
    /// E = weight · L for one sample of the aperture, sr, without the lens's transmittance.
    pub weight: f32,
}

/// A ray of a place through a point of the aperture, in camera space.
struct Aim {
    seen: Seen,
    /// On the entrance pupil.
    origin: DVec3,
    /// From there to what is in focus, of any length.
    towards: DVec3,
}

impl Aim {
    /// Origin and unit direction in world space.
    #[inline(always)]
    fn in_world(&self, to_world: &DAffine3) -> (DVec3, DVec3) {
        let direction = to_world.transform_vector3(self.towards).normalize();
        (to_world.transform_point3(self.origin), direction)
    }
}

/// Where a point in the world is seen through a point of the aperture.
#[derive(Clone, Copy, Debug)]
pub struct Connection {
    /// Continuous pixel coordinates, on the sensor or beside it.
    pub pixel: DVec2,
    /// From the lens by the point; see [`Camera::generate`].
    pub ray: CameraRay,
    /// What each wavelength counts.
    pub weights: SampledSpectrum,
    /// Area of the picture over that of what it shows on a plane across the ray at the point, px²·m⁻².
    pub px2_per_m2: f32,
}

/// From OpenCV's camera space to that of glTF.
#[inline(always)]
fn turned(seen: Seen) -> Seen {
    let turned = |d: DVec3| DVec3::new(d.x, -d.y, -d.z);
    Seen { direction: turned(seen.direction), chief: turned(seen.chief), ..seen }
}

impl Camera {
    /// Places a lens. `autofocus_distance_m` is what [`Focus::Autofocus`] found along the axis (infinite for nothing)
    /// and not looked at for other kinds of focus. A pinhole has no focus: whatever the lens is said to be focused on, its
    /// picture lies one focal length behind it.
    pub fn new(
        lens: &LensDescription,
        grid: &PixelGrid,
        to_world: DAffine3,
        autofocus_distance_m: f64,
    ) -> Result<Self, Invalid> {
        lens.validate()?;
        let f = lens.focal_length_m;
        let u = match (lens.kind, lens.focus) {
            (LensKind::Pinhole, _) | (LensKind::Thin, Focus::Infinity) => f64::INFINITY,
            (LensKind::Thin, Focus::Distance(u)) => u,
            (LensKind::Thin, Focus::Autofocus { .. }) if autofocus_distance_m > f => autofocus_distance_m,
            (LensKind::Thin, Focus::Autofocus { .. }) => {
                // As precise as intersections are.
                let distance = autofocus_distance_m as f32;
                let message = format!("what is there is {distance} m away, within the focal length of {f} m");
                return Err(
                    Invalid::new("autofocus_px", message).help("move the camera back or shorten the focal length")
                );
            }
        };
        let v = if u.is_finite() { u * f / (u - f) } else { f };
        let [width, height] = grid.resolution.map(f64::from);
        let intrinsics = lens.intrinsics.unwrap_or(Intrinsics {
            fx: v / grid.pitch_m[0],
            fy: v / grid.pitch_m[1],
            cx: width / 2.0,
            cy: height / 2.0,
            skew: 0.0,
        });
        let aperture = Aperture::new(f / lens.f_number / 2.0, lens.blades, lens.blade_rotation_deg);
        let reach = lens.projection.reach(lens.max_angle_rad);
        let middle = lens.projection.unproject(DVec2::ZERO, &reach).map_or(1.0, |seen| seen.solid_angle);
        Ok(Self {
            to_world,
            kind: lens.kind,
            aperture,
            focus_distance_m: u,
            image_distance_m: v,
            resolution: grid.resolution,
            pitch_m: grid.pitch_m,
            intrinsics,
            projection: lens.projection,
            reach,
            falloff: lens.falloff,
            on_axis_sr: aperture.projected_solid_angle(v) * middle,
            sample_sr: match (lens.kind, lens.falloff) {
                (LensKind::Thin, Falloff::Cos4) => aperture.area() / (v * v),
                // One ray stands for all of the aperture, as seen from the axis.
                (LensKind::Pinhole, Falloff::Cos4) => aperture.projected_solid_angle(v),
                (LensKind::Thin | LensKind::Pinhole, Falloff::None) => aperture.projected_solid_angle(v) * middle,
            },
            working_f_number: v * lens.f_number / f,
            point_spread: lens.point_spread.clone(),
            lateral_colour: lens.lateral_colour.clone(),
            stops: lens.stops.clone(),
            recording: None,
            time: 0.0,
            scans: false,
        })
    }

    /// The same camera taking a picture in whose time something moves.
    #[must_use]
    pub fn recording(self, recording: Recording) -> Self {
        Self { recording: Some(recording), ..self }
    }

    /// The same camera moving as another does.
    #[must_use]
    pub fn moving_as(self, other: &Self) -> Self {
        Self { recording: other.recording.clone(), ..self }
    }

    /// The same camera with a single row of pixels, which sees every line of the picture. Its grid has one row.
    #[must_use]
    pub fn scanning(self) -> Self {
        Self { scans: true, ..self }
    }

    /// Whether paths start at times of their own.
    pub fn moves(&self) -> bool {
        self.recording.is_some()
    }

    /// Whether all lines of the picture are seen by one row of pixels.
    pub fn scans(&self) -> bool {
        self.scans
    }

    /// The camera as it stands, still, in the middle of the exposure of a row.
    pub fn at_row(&self, row: f64) -> Self {
        let (to_world, time) = self.pose(row, 0.5);
        Self { to_world, time, recording: None, ..self.clone() }
    }

    /// Camera → world in the middle of the exposure of a row, and which part of the picture's time has gone by then.
    pub fn pose_at_row(&self, row: f64) -> (DAffine3, f32) {
        self.pose(row, 0.5)
    }

    /// The camera as it stands, still, at [`Recording::middle_s`]: where it is where one pose is to stand for the picture.
    pub fn halfway(&self) -> Self {
        let Some(recording) = &self.recording else { return self.clone() };
        let (to_world, time) = self.pose_at(recording, recording.middle_s());
        Self { to_world, time, recording: None, ..self.clone() }
    }

    /// Where the camera is at the sample u in [0, 1) of the exposure of a row, and which part of the picture's time has gone
    /// by.
    #[inline]
    fn pose(&self, row: f64, u: f32) -> (DAffine3, f32) {
        let Some(recording) = &self.recording else { return (self.to_world, self.time) };
        self.pose_at(recording, recording.time_s(row, u))
    }

    #[inline]
    fn pose_at(&self, recording: &Recording, time_s: f64) -> (DAffine3, f32) {
        let pose = recording.motion.as_ref().map_or(self.to_world, |motion| motion.pose(&self.to_world, time_s));
        (pose, recording.part(time_s))
    }

    /// Camera → world, of a moving camera at time 0.
    pub fn to_world(&self) -> DAffine3 {
        self.to_world
    }

    /// Pinhole matrix of the picture, pixels.
    pub fn intrinsics(&self) -> Intrinsics {
        self.intrinsics
    }

    /// The projected solid angle Ω that the light on the axis fills, sr: of even radiance L its irradiance is Ω·L, τ aside.
    ///
    /// Ω = π·sin²θ' for a round aperture, tan θ' = D/2v, whatever the kind of lens; for one with blades, the same integral
    /// over the polygon. A projection that does not show the axis at the scale of v has its own dΩ/dA_s there as a factor.
    pub fn on_axis_sr(&self) -> f64 {
        self.on_axis_sr
    }

    /// Distance lens → plane of focus, m; infinite for a pinhole.
    pub fn focus_distance_m(&self) -> f64 {
        self.focus_distance_m
    }

    /// Distance lens → sensor, m.
    pub fn image_distance_m(&self) -> f64 {
        self.image_distance_m
    }

    /// How directions become places in the picture.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// How far from the axis the lens sees.
    pub fn reach(&self) -> &Reach {
        &self.reach
    }

    /// What of the picture is seen, and how far from the axis.
    pub fn field_of_view(&self) -> FieldOfView {
        FieldOfView::new(self)
    }

    /// Columns and rows.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// Refuses a lens whose model ends within the picture, because it folds back over itself or because its picture is
    /// flat and 90° are not enough; not one whose image circle is smaller than the sensor. The key is that of `[lens]`.
    pub fn check_coverage(&self) -> Result<(), Invalid> {
        let what = match self.reach.end {
            ReachEnd::Sees => return Ok(()),
            ReachEnd::Folds => "folds back over its own picture",
            ReachEnd::Flat => "has reached 90° from the axis",
        };
        let field = self.field_of_view();
        let Some([x, y]) = field.blind_px else { return Ok(()) };
        let from_centre = DVec2::new(x - self.intrinsics.cx, y - self.intrinsics.cy).length();
        let degrees = self.reach.angle.to_degrees();
        let message = format!(
            "the model {what} {:.1} px from the principal point, {degrees:.2}° from the axis, and the sensor goes on to \
             {from_centre:.1} px at {x:.0}, {y:.0}",
            field.radius_px[0],
        );
        let angle = (degrees * 100.0).floor() / 100.0;
        Err(Invalid::new("distortion", message).help(format!(
            "take weaker coefficients, a longer focal length or fewer pixels; or write lens.max_angle_deg = {angle} to \
             leave black what lies farther out"
        )))
    }

    /// The place of a pixel position in normalised image coordinates.
    #[inline(always)]
    fn place(&self, pixel: DVec2) -> DVec2 {
        let i = &self.intrinsics;
        let row = if self.scans { pixel.y - pixel.y.floor() } else { pixel.y };
        let y = (row - i.cy) / i.fy;
        DVec2::new((pixel.x - i.cx - i.skew * y) / i.fx, y)
    }

    /// What a pixel position sees, in camera space of glTF (x right, y up, z backward); `None` out of the lens's reach.
    #[inline]
    pub fn seen(&self, pixel: DVec2) -> Option<Seen> {
        self.seen_at(self.place(pixel))
    }

    #[inline]
    fn seen_at(&self, place: DVec2) -> Option<Seen> {
        self.projection.unproject(place, &self.reach).map(turned)
    }

    /// The ray through the centre of the lens, in world space. Its parameter t is the distance in metres that focusing
    /// counts: along the axis, or along the ray where the lens can see more than a half-space.
    pub fn chief_ray(&self, pixel: DVec2) -> Option<Ray> {
        let direction = self.to_world.transform_vector3(self.seen(pixel)?.chief);
        Some(Ray::new(self.to_world.translation.as_vec3(), direction.as_vec3()).at_time(self.time))
    }

    /// The ray of a pixel position (continuous coordinates) and an aperture sample. `None` where the position sees
    /// nothing: its irradiance is zero.
    ///
    /// By the étendue that a lens keeps, E(x, λ) = τ(λ) ∫_A L·cosθ dA·dΩ/dA_s ([Born99](photosite_core::references#born99) §4.8), where
    /// the piece dA_s of the sensor sees the solid angle dΩ. For a rectilinear lens dΩ/dA_s = cos³θ/v², which makes
    /// E = τ ∫_A L·cos⁴θ/v² dA with θ between the axis and x → a; one uniform sample of A weighs A·cos⁴θ/v². Distortion
    /// multiplies that by the area in the ideal over that in the distorted picture: a barrel is brighter at its edge.
    /// A lens that can see more than a half-space has an entrance pupil that faces each direction, so that the cosine
    /// is 1, and behind it the cone of light that it has on the axis.
    ///
    /// The only ray of a pinhole stands for all of the aperture as the axis sees it: it weighs Ω·cos⁴α at the field angle α, with
    /// the Ω of [`Self::on_axis_sr`]. Without falloff a sample of either weighs Ω everywhere, so that one f-number has one
    /// exposure on the axis.
    #[inline]
    pub fn generate(&self, pixel: DVec2, aperture_sample: [f32; 2]) -> Option<CameraRay> {
        self.ray(self.place(pixel), pixel.y.floor(), aperture_sample, 0.0)
    }

    /// Whether a ray needs a sample of the aperture.
    pub fn has_aperture(&self) -> bool {
        self.kind == LensKind::Thin
    }

    /// Whether a path needs a sample of the point spread.
    pub fn spreads_points(&self) -> bool {
        self.point_spread.is_some()
    }

    /// Whether a point spreads by wavelength, so that the weights of wavelengths are right for all four together alone.
    pub fn spreads_by_wavelength(&self) -> bool {
        matches!(self.point_spread, Some(PointSpread::Airy | PointSpread::Measured(_)))
    }

    /// The same ray through a lens with a point spread and lateral colour, at a time within the exposure of the pixel's row, and
    /// what each wavelength counts. Lateral colour leaves only the hero, whose direction it is.
    #[inline]
    pub fn generate_spectral(
        &self,
        sample: &CameraSample,
        wavelengths: &mut Wavelengths,
    ) -> Option<(CameraRay, SampledSpectrum)> {
        let &CameraSample { pixel, aperture, time, spread } = sample;
        if self.lateral_colour.is_some() {
            wavelengths.terminate_secondary();
        }
        let (place, weights) = self.spread_place(pixel, spread, wavelengths);
        Some((self.ray(place, pixel.y.floor(), aperture, time)?, weights))
    }

    /// The place of a pixel position behind a lens with lateral colour and a point spread, at the hero's wavelength, and what
    /// each wavelength counts.
    #[inline]
    fn spread_place(
        &self,
        pixel: DVec2,
        spread_sample: [f32; 2],
        wavelengths: &Wavelengths,
    ) -> (DVec2, SampledSpectrum) {
        let mut place = self.place(pixel);
        let mut weights = SampledSpectrum::ONE;
        if let Some(lateral) = &self.lateral_colour {
            place /= lateral.magnification(f64::from(wavelengths.lambda_nm(0)));
        }
        if let Some(spread) = &self.point_spread {
            let in_picture = pixel / DVec2::from_array(self.resolution.map(f64::from)) * 2.0 - 1.0;
            let (offset, of_wavelengths) = spread.sample(spread_sample, wavelengths, self.working_f_number, in_picture);
            let Intrinsics { fx, fy, .. } = self.intrinsics;
            place += offset / DVec2::new(self.pitch_m[0] * fx, self.pitch_m[1] * fy);
            weights = of_wavelengths;
        }
        (place, weights)
    }

    #[inline]
    fn ray(&self, place: DVec2, row: f64, aperture_sample: [f32; 2], u_time: f32) -> Option<CameraRay> {
        let (to_world, time) = self.pose(row, u_time);
        let opening = self.opening(aperture_sample);
        let aim = self.aim(place, opening)?;
        if !self.passes(aim.seen.chief, opening, aim.towards) {
            return None;
        }
        let (origin, direction) = aim.in_world(&to_world);
        let ray = Ray::new(origin.as_vec3(), direction.as_vec3()).at_time(time);
        Some(CameraRay { ray, weight: self.weight(&aim, opening) })
    }

    /// A point of the aperture.
    #[inline]
    fn opening(&self, aperture_sample: [f32; 2]) -> DVec2 {
        match self.kind {
            LensKind::Pinhole => DVec2::ZERO,
            LensKind::Thin => self.aperture.sample(aperture_sample),
        }
    }

    /// Where the ray of a place goes through a point of the aperture, whatever stops are in its way.
    #[inline]
    fn aim(&self, place: DVec2, opening: DVec2) -> Option<Aim> {
        Some(self.aim_at(self.seen_at(place)?, opening))
    }

    /// The same to what is seen.
    #[inline(always)]
    fn aim_at(&self, seen: Seen, opening: DVec2) -> Aim {
        let origin = self.in_pupil(opening, &seen);
        Aim { seen, origin, towards: self.towards(seen.chief, origin) }
    }

    /// [`CameraRay::weight`].
    #[inline(always)]
    fn weight(&self, aim: &Aim, opening: DVec2) -> f32 {
        (self.sample_sr * self.falloff_at(&aim.seen, opening)) as f32
    }

    /// The pixel position whose ray goes by a point in world space, of the same samples as [`Self::generate_spectral`] takes:
    /// its inverse, found by Newton's method, since neither distortion nor an entrance pupil that turns has one in closed
    /// form. `None` where the lens does not see the point. Of a camera that stands still.
    pub fn connect(
        &self,
        point: Vec3,
        aperture_sample: [f32; 2],
        spread_sample: [f32; 2],
        wavelengths: &mut Wavelengths,
    ) -> Option<Connection> {
        /// Finite differences are this wide, px: as exact as an f64 makes them of functions that are smooth over pixels.
        const STEP_PX: f64 = 0.01;
        const NEAR_PX: f64 = 1e-4;
        const MOST_STEPS: u32 = 8;
        if self.lateral_colour.is_some() {
            wavelengths.terminate_secondary();
        }
        let opening = self.opening(aperture_sample);
        let point = self.to_world.inverse().transform_point3(point.as_dvec3());
        let aim = |pixel| self.aim(self.spread_place(pixel, spread_sample, wavelengths).0, opening);
        let across = DQuat::from_rotation_arc(DVec3::Z, point.try_normalize()?);
        let (right, up, forward) = (across * DVec3::X, across * DVec3::Y, across * DVec3::Z);
        // Where the ray of a pixel position meets the plane across the direction of the point, seen from the point.
        let miss = |pixel: DVec2| -> Option<DVec2> {
            let Aim { origin, towards, .. } = aim(pixel)?;
            let t = (point - origin).dot(forward) / towards.dot(forward);
            let miss = origin + towards * t - point;
            (t > 0.0).then(|| DVec2::new(miss.dot(right), miss.dot(up)))
        };
        let mut pixel = self.project_camera(point)?;
        for _ in 0..MOST_STEPS {
            let here = miss(pixel)?;
            let along = |step: DVec2| Some((miss(pixel + step)? - miss(pixel - step)?) / (2.0 * STEP_PX));
            let (by_x, by_y) = (along(DVec2::X * STEP_PX)?, along(DVec2::Y * STEP_PX)?);
            let m2_per_px2 = by_x.perp_dot(by_y);
            let step = DVec2::new(by_y.perp_dot(here), here.perp_dot(by_x)) / m2_per_px2;
            pixel += step;
            if step.length_squared() > NEAR_PX * NEAR_PX {
                continue;
            }
            let found = aim(pixel)?;
            if !self.passes(found.seen.chief, opening, found.towards) {
                return None;
            }
            let direction = found.towards.normalize();
            let origin = self.to_world.transform_point3(found.origin).as_vec3();
            let ray = Ray::new(origin, self.to_world.transform_vector3(direction).as_vec3()).at_time(self.time);
            let (_, weights) = self.spread_place(pixel, spread_sample, wavelengths);
            // The plane is across the line to the lens's centre; what is seen of it is across the ray.
            let tilt = direction.dot(forward).abs();
            return Some(Connection {
                pixel,
                ray: CameraRay { ray, weight: self.weight(&found, opening) },
                weights,
                px2_per_m2: (1.0 / (m2_per_px2.abs() * tilt)) as f32,
            });
        }
        None
    }

    /// Pixels per solid angle in the middle of the picture, px²·sr⁻¹.
    pub fn px2_per_sr(&self) -> f64 {
        self.intrinsics.fx * self.intrinsics.fy
    }

    /// From a point of the pupil to what is in focus, in units of the focus distance.
    #[inline(always)]
    fn towards(&self, chief: DVec3, origin: DVec3) -> DVec3 {
        if self.focus_distance_m.is_finite() { chief - origin / self.focus_distance_m } else { chief }
    }

    /// Whether all stops let light through.
    #[inline]
    fn passes(&self, chief: DVec3, opening: DVec2, towards: DVec3) -> bool {
        let v = self.image_distance_m;
        // The picture lies upside down behind the lens.
        let sensor = DVec2::new(chief.x, chief.y) * -v;
        self.stops.iter().all(|stop| stop.passes(opening, towards, sensor, v))
    }

    /// A point of the entrance pupil in camera space: across the axis, or turned about the centre on the shortest way to
    /// face the direction seen.
    #[inline(always)]
    fn in_pupil(&self, opening: DVec2, seen: &Seen) -> DVec3 {
        if self.projection.is_flat() {
            return opening.extend(0.0);
        }
        DQuat::from_rotation_arc(DVec3::NEG_Z, seen.direction) * opening.extend(0.0)
    }

    /// Irradiance through a point of the opening over that through the centre on the axis.
    #[inline(always)]
    fn falloff_at(&self, seen: &Seen, opening: DVec2) -> f64 {
        match self.falloff {
            Falloff::None => 1.0,
            Falloff::Cos4 => {
                let v = self.image_distance_m;
                let cos = -seen.direction.z;
                let (across, of_picture) = if self.projection.is_flat() {
                    // The sensor point is where the undistorted chief ray, carried on behind the lens, meets z = v.
                    (opening + seen.chief.truncate() * v, seen.solid_angle / (cos * cos * cos))
                } else {
                    (opening, seen.solid_angle)
                };
                let cos2 = v * v / (v * v + across.length_squared());
                cos2 * cos2 * of_picture
            }
        }
    }

    /// Irradiance at a pixel position over that on the axis, under even light. `None` where the position sees nothing.
    pub fn relative_illumination(&self, pixel: DVec2) -> Option<f64> {
        // The integrand is smooth: 16 × 16 cells leave an error below 1e-4 even at f/1. The edge of a stop crosses some 4·128
        // of 128² cells, each right to a half of itself at random: 1e-3.
        let cells: u16 = if self.stops.is_empty() { 16 } else { 128 };
        let mean = |seen: &Seen| -> f64 {
            let centre = |i: u16| (f32::from(i) + 0.5) / f32::from(cells);
            let through = |i: u16| {
                let opening = match self.kind {
                    LensKind::Pinhole => DVec2::ZERO,
                    LensKind::Thin => self.aperture.sample([centre(i % cells), centre(i / cells)]),
                };
                let towards = self.towards(seen.chief, self.in_pupil(opening, seen));
                if self.passes(seen.chief, opening, towards) { self.falloff_at(seen, opening) } else { 0.0 }
            };
            (0..cells * cells).map(through).sum()
        };
        Some(mean(&self.seen(pixel)?) / mean(&self.seen_at(DVec2::ZERO)?))
    }

    /// Where a world point appears: continuous pixel coordinates of its sharp picture through the whole lens model, on the
    /// sensor or beside it; `None` out of the lens's reach. Of a moving camera at time 0.
    pub fn project(&self, point: Vec3) -> Option<DVec2> {
        self.project_camera(self.to_world.inverse().transform_point3(point.as_dvec3()))
    }

    /// The same for a point in camera space of glTF (x right, y up, z backward).
    pub fn project_camera(&self, point: DVec3) -> Option<DVec2> {
        let place = self.projection.project(DVec3::new(point.x, -point.y, -point.z), &self.reach)?;
        let i = &self.intrinsics;
        Some(DVec2::new(i.fx * place.x + i.skew * place.y + i.cx, i.fy * place.y + i.cy))
    }
}
