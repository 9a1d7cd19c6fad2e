//! Rays from the sensor through the lens into the scene, and the weight that makes irradiance of their radiance.
//!
//! Camera space is that of glTF: x right, y up, the camera looks along −z, the origin is the centre of the lens. The
//! sensor stands at z = +v, where the picture lies upside down.

use glam::{DAffine3, DVec2, DVec3, Vec3};

use super::aperture::Aperture;
use super::{Falloff, Focus, Intrinsics, LensDescription, LensKind, Recording};
use crate::Invalid;
use crate::geometry::Ray;
use crate::sabotage::{Fault, flip};

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
    intrinsics: Intrinsics,
    distortion: super::Distortion,
    falloff: Falloff,
    /// `None` where nothing moves.
    recording: Option<Recording>,
    /// Whether all lines of the picture are seen by one row of pixels.
    scans: bool,
}

/// A ray into the scene and what its radiance counts.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// In world space, direction of unit length.
    pub ray: Ray,
    /// E = weight · L for one sample of the aperture, sr: A·cos⁴θ/v², without the lens's transmittance.
    pub weight: f32,
}

impl Camera {
    /// Places a lens. `autofocus_distance_m` is what [`Focus::Autofocus`] found along the axis (infinite for nothing)
    /// and not looked at for other kinds of focus.
    pub fn new(
        lens: &LensDescription,
        grid: &PixelGrid,
        to_world: DAffine3,
        autofocus_distance_m: f64,
    ) -> Result<Self, Invalid> {
        lens.validate()?;
        let f = lens.focal_length_m;
        let u = match lens.focus {
            Focus::Distance(u) => u,
            Focus::Infinity => f64::INFINITY,
            Focus::Autofocus { .. } if autofocus_distance_m > f => autofocus_distance_m,
            Focus::Autofocus { .. } => {
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
        Ok(Self {
            to_world,
            kind: lens.kind,
            aperture: Aperture::new(f / lens.f_number / 2.0, lens.blades, lens.blade_rotation_deg),
            focus_distance_m: u,
            image_distance_m: v,
            intrinsics,
            distortion: lens.distortion,
            falloff: lens.falloff,
            recording: None,
            scans: false,
        })
    }

    /// The same camera taking a picture in whose time something moves.
    #[must_use]
    pub fn recording(self, recording: Recording) -> Self {
        Self { recording: Some(recording), ..self }
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

    /// Camera → world, of a moving camera at time 0.
    pub fn to_world(&self) -> DAffine3 {
        self.to_world
    }

    /// Pinhole matrix of the picture, pixels.
    pub fn intrinsics(&self) -> Intrinsics {
        self.intrinsics
    }

    /// Distance lens → plane of focus, m.
    pub fn focus_distance_m(&self) -> f64 {
        self.focus_distance_m
    }

    /// Distance lens → sensor, m.
    pub fn image_distance_m(&self) -> f64 {
        self.image_distance_m
    }

    /// Direction in camera space, with z = −1, of the chief ray of a pixel position; `None` where distortion leaves the
    /// position without one.
    #[inline]
    fn chief_direction(&self, pixel: DVec2) -> Option<DVec3> {
        let i = &self.intrinsics;
        let row = if self.scans { pixel.y - pixel.y.floor() } else { pixel.y };
        let y = (row - i.cy) / i.fy;
        let x = (pixel.x - i.cx - i.skew * y) / i.fx;
        let ideal = self.distortion.undistort(DVec2::new(x, y))?;
        Some(DVec3::new(ideal.x, -ideal.y, -1.0))
    }

    /// The ray through the centre of the lens, in world space; parameter t is the distance along the axis in metres.
    pub fn chief_ray(&self, pixel: DVec2) -> Option<Ray> {
        let direction = self.to_world.transform_vector3(self.chief_direction(pixel)?);
        Some(Ray::new(self.to_world.translation.as_vec3(), direction.as_vec3()))
    }

    /// The ray of a pixel position (continuous coordinates) and an aperture sample. `None` where the position sees
    /// nothing through a distorted lens: its irradiance is zero.
    ///
    /// E(x, λ) = τ(λ) ∫_A L·cos⁴θ/v² dA with θ between the axis and x → a; one uniform sample of A weighs A·cos⁴θ/v².
    /// Without falloff cos θ is 1.
    #[inline]
    pub fn generate(&self, pixel: DVec2, aperture_sample: [f32; 2]) -> Option<CameraRay> {
        self.generate_at(pixel, aperture_sample, 0.0)
    }

    /// The same ray at the sample `u_time` in [0, 1) of the exposure of the pixel's row.
    #[inline]
    pub fn generate_at(&self, pixel: DVec2, aperture_sample: [f32; 2], u_time: f32) -> Option<CameraRay> {
        let (to_world, time) = match &self.recording {
            None => (self.to_world, 0.0),
            Some(recording) => {
                let time_s = recording.time_s(pixel.y.floor(), u_time);
                let pose =
                    recording.motion.as_ref().map_or(self.to_world, |motion| motion.pose(&self.to_world, time_s));
                (pose, recording.part(time_s))
            }
        };
        let chief = self.chief_direction(pixel)?;
        let (opening, direction) = match self.kind {
            LensKind::Pinhole => (DVec2::ZERO, chief),
            LensKind::Thin => {
                let a = self.aperture.sample(aperture_sample) * flip(Fault::ApertureRadiusDoubled, 1.0, 2.0);
                let towards = if self.focus_distance_m.is_finite() {
                    chief - DVec3::new(a.x, a.y, 0.0) / self.focus_distance_m
                } else {
                    chief
                };
                (a, towards)
            }
        };
        let v = self.image_distance_m;
        let cos4 = self.falloff_at(chief, opening);
        let origin = to_world.transform_point3(DVec3::new(opening.x, opening.y, 0.0));
        let direction = to_world.transform_vector3(direction).normalize();
        let ray = Ray::new(origin.as_vec3(), direction.as_vec3()).at_time(time);
        Some(CameraRay { ray, weight: (self.aperture.area() * cos4 / (v * v)) as f32 })
    }

    /// cos⁴θ of the way from a sensor point to a point of the opening, or 1 without falloff.
    #[inline]
    fn falloff_at(&self, chief: DVec3, opening: DVec2) -> f64 {
        match self.falloff {
            Falloff::None => 1.0,
            Falloff::Cos4 => {
                let v = self.image_distance_m;
                // The sensor point is where the undistorted chief ray, carried on behind the lens, meets z = v.
                let across = opening + DVec2::new(chief.x, chief.y) * v;
                let cos2 = v * v / (v * v + across.length_squared());
                cos2 * cos2
            }
        }
    }

    /// Irradiance at a pixel position over that on the axis, under even light: the mean of cos⁴θ over the opening, over
    /// the same on the axis. `None` where the position sees nothing.
    pub fn relative_illumination(&self, pixel: DVec2) -> Option<f64> {
        // The integrand is smooth: 16 × 16 cells leave an error below 1e-4 even at f/1.
        const CELLS: u16 = 16;
        let mean = |chief: DVec3| -> f64 {
            let centre = |i: u16| (f32::from(i) + 0.5) / f32::from(CELLS);
            let opening = |i: u16| match self.kind {
                LensKind::Pinhole => DVec2::ZERO,
                LensKind::Thin => self.aperture.sample([centre(i % CELLS), centre(i / CELLS)]),
            };
            (0..CELLS * CELLS).map(|i| self.falloff_at(chief, opening(i))).sum()
        };
        Some(mean(self.chief_direction(pixel)?) / mean(DVec3::NEG_Z))
    }

    /// Where a world point appears: continuous pixel coordinates of its sharp picture, without distortion; `None`
    /// behind the camera.
    pub fn project(&self, point: Vec3) -> Option<DVec2> {
        let p = self.to_world.inverse().transform_point3(point.as_dvec3());
        if p.z >= 0.0 {
            return None;
        }
        let distorted = self.distortion.distort(DVec2::new(p.x, -p.y) / -p.z);
        let i = &self.intrinsics;
        Some(DVec2::new(i.fx * distorted.x + i.skew * distorted.y + i.cx, i.fy * distorted.y + i.cy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: PixelGrid = PixelGrid { resolution: [640, 480], pitch_m: [5e-6, 6e-6] };

    fn camera(lens: &LensDescription) -> Camera {
        Camera::new(lens, &GRID, DAffine3::IDENTITY, f64::NAN).expect("a valid lens")
    }

    #[test]
    fn the_image_distance_follows_the_thin_lens_equation() {
        let lens = camera(&LensDescription::thin(0.05, 2.0, Focus::Distance(1.0)));
        let (u, v) = (lens.focus_distance_m(), lens.image_distance_m());
        assert!((1.0 / 0.05 - 1.0 / u - 1.0 / v).abs() < 1e-12);
        assert_eq!(camera(&LensDescription::thin(0.05, 2.0, Focus::Infinity)).image_distance_m(), 0.05);
        assert!((lens.intrinsics().fx - v / 5e-6).abs() < 1e-9 && (lens.intrinsics().fy - v / 6e-6).abs() < 1e-9);
    }

    #[test]
    fn all_rays_of_a_pixel_meet_where_it_is_focused() {
        let lens = camera(&LensDescription::thin(0.05, 1.4, Focus::Distance(0.8)));
        let pixel = DVec2::new(100.25, 400.75);
        let sharp = lens.chief_ray(pixel).expect("no distortion").at(0.8);
        for u in [[0.0, 0.0], [0.99, 0.3], [0.2, 0.9]] {
            let ray = lens.generate(pixel, u).expect("no distortion").ray;
            let t = (sharp - ray.origin).dot(ray.direction);
            // f32 rays at a distance of 0.8 m.
            assert!((ray.at(t) - sharp).length() < 2e-7, "{:?}", ray.at(t) - sharp);
        }
        assert!((lens.project(sharp).expect("in front") - pixel).length() < 1e-3);
    }

    #[test]
    fn the_picture_is_upright_and_not_mirrored() {
        let lens = camera(&LensDescription::thin(0.05, 8.0, Focus::Infinity));
        let top_right = lens.chief_ray(DVec2::new(600.0, 20.0)).expect("no distortion").direction;
        assert!(top_right.x > 0.0 && top_right.y > 0.0 && top_right.z < 0.0);
    }

    #[test]
    fn autofocus_within_the_focal_length_is_refused() {
        let lens = LensDescription::thin(0.05, 2.0, Focus::Autofocus { pixel: [320.0, 240.0] });
        assert!(Camera::new(&lens, &GRID, DAffine3::IDENTITY, 0.04).is_err());
        let focused = Camera::new(&lens, &GRID, DAffine3::IDENTITY, 2.0).expect("in front");
        assert_eq!(focused.focus_distance_m(), 2.0);
    }
}
