//! A camera for scenes that have none: it looks at everything from the front right and a little above.

use glam::{DAffine3, DVec3};

use photosite_sensor::SensorModel;
use photosite_transport::scene::description::{SceneDescription, look_at};

/// Direction from the centre of the scene towards the camera: glTF's models face +Z.
pub(crate) const TOWARDS_CAMERA: DVec3 = DVec3::new(0.5, 0.35, 1.0);
/// Part of the image's shorter side that the scene's bounding sphere fills.
const FILLED: f64 = 0.9;

/// A sphere around a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sphere {
    pub(crate) centre: DVec3,
    /// Radius of the sphere, m, above 0.
    pub(crate) radius: f64,
}

/// The sphere around the centre of the bounding box that holds all of the subject; `None` without geometry.
pub(crate) fn bounding_sphere(scene: &SceneDescription) -> Option<Sphere> {
    let (low, high) = scene.subject_bounds()?;
    let centre = (low + high) / 2.0;
    if !centre.is_finite() {
        return None;
    }
    let radius = scene.subject_points().map(|p| p.distance(centre)).fold(0.0, f64::max);
    Some(Sphere { centre, radius: radius.max(f64::MIN_POSITIVE.sqrt()) })
}

/// Position of a camera, and the point that it looks at, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Framing {
    pub(crate) position: DVec3,
    pub(crate) look_at: DVec3,
}

/// Size of a lens before it is focused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LensSize {
    /// Focal length, m.
    FocalLength(f64),
    /// Distance from the sensor once the lens is focused, m, from which its field of view follows.
    ImageDistance(f64),
}

impl Framing {
    /// Frames the whole sphere through a lens focused on its centre. Positions have six digits of the distance, so that
    /// a file which states them is read with ease, and gives the same image.
    pub(crate) fn of(sphere: &Sphere, sensor: &SensorModel, lens: LensSize) -> Self {
        let half_side =
            (0..2).map(|i| sensor.resolution[i] as f64 * sensor.pixel_pitch_m[i] / 2.0).fold(f64::INFINITY, f64::min);
        let distance = match lens {
            LensSize::FocalLength(f) => framing_distance(sphere.radius, FILLED * half_side, f),
            // The outline is seen under the angle asin(r/u).
            LensSize::ImageDistance(v) => sphere.radius / (FILLED * half_side / v).atan().sin(),
        };
        let power = distance.log10().floor() as i32 - 5;
        let rounded = |place: DVec3| DVec3::from_array(place.to_array().map(|x| to_power(x, power)));
        let position = rounded(sphere.centre + TOWARDS_CAMERA.normalize() * distance);
        Self { position, look_at: rounded(sphere.centre) }
    }

    /// Camera → world.
    pub(crate) fn to_world(self) -> DAffine3 {
        let towards = TOWARDS_CAMERA.normalize();
        // So far out, or so small, that both places are one.
        let by_direction = || look_at(self.position, self.position - towards, DVec3::Y);
        look_at(self.position, self.look_at, DVec3::Y).or_else(by_direction).unwrap_or(DAffine3::IDENTITY)
    }
}

/// A number rounded to a power of ten, in the form that prints shortest.
pub(crate) fn to_power(x: f64, power: i32) -> f64 {
    let scale = 10f64.powi(power.abs());
    if power < 0 { (x * scale).round() / scale } else { (x / scale).round() * scale }
}

/// The distance u of a sphere of radius r whose outline is imaged at the height h of the sensor, when the lens is
/// focused on its centre: r = u·sin(atan(h/v)) with v = u·f/(u − f). The right-hand side grows with u from 0 at u = f,
/// so halving intervals finds it.
fn framing_distance(radius: f64, half_side: f64, f: f64) -> f64 {
    let seen_radius = |u: f64| u * (half_side * (u - f) / (u * f)).atan().sin();
    // The sphere itself must lie in front of the lens.
    let mut near = f.max(radius);
    let mut far = near * 2.0;
    while seen_radius(far) < radius && far < f64::MAX / 4.0 {
        (near, far) = (far, far * 2.0);
    }
    for _ in 0..60 {
        let middle = (near + far) / 2.0;
        if seen_radius(middle) < radius { near = middle } else { far = middle }
    }
    far
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_sensor::presets;

    #[test]
    fn the_outline_of_the_sphere_touches_the_edge() {
        for (radius, half_side, f) in
            [(1.0, 1.8e-3, 16e-3), (0.1, 1.8e-3, 16e-3), (1e-3, 5e-3, 50e-3), (1e4, 18e-3, 24e-3)]
        {
            let u = framing_distance(radius, half_side, f);
            let v = u * f / (u - f);
            // The outline is seen under the angle asin(r/u), and imaged at v·tan of it.
            let height = v * (radius / u).asin().tan();
            assert!((height / half_side - 1.0).abs() < 1e-9, "{radius} m: {height} instead of {half_side}");
        }
    }

    #[test]
    fn the_camera_looks_at_the_centre_from_above_and_in_front() {
        let sensor = presets::model(presets::DEFAULT).expect("the default preset");
        let sphere = Sphere { centre: DVec3::new(1.0, 2.0, 3.0), radius: 0.5 };
        let framing = Framing::of(&sphere, &sensor, LensSize::FocalLength(0.016));
        let pose = framing.to_world();
        let centre = pose.inverse().transform_point3(sphere.centre);
        let distance = framing.position.distance(sphere.centre);
        // Rounded to 1e-5 of the leading digit of the distance.
        assert!((centre - DVec3::new(0.0, 0.0, -distance)).length() < 2e-5 * distance, "{centre}");
        // Some metres, hence five decimals.
        assert_eq!(framing.position, framing.position.to_array().map(|x| (x * 1e5).round() / 1e5).into());
        let offset = pose.translation - sphere.centre;
        assert!(offset.x > 0.0 && offset.y > 0.0 && offset.z > offset.x, "{offset}");
        assert!(pose.matrix3.y_axis.y > 0.9 && (pose.matrix3.determinant() - 1.0).abs() < 1e-12);
    }
}
