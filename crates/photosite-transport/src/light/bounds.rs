//! Bounds of lights: their places and the directions of their light.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Vec3, Vec3A};

use super::area_light::AreaLight;
use super::delta_light::DeltaLight;
use super::delta_model::DeltaExtent;
use super::emitter::{Emitter, EmitterShape};
use crate::geometry::{Geometry, Motion, Primitive};
use photosite_core::math::Cone;

/// Bounds of one or several lights at all times of the image ([Conty18](photosite_core::references#conty18) §4.1,
/// [pbrt4](photosite_core::references#pbrt4) §12.6.3, `LightBounds`).
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    /// Lower corner of the box that holds them, m.
    pub(super) low: Vec3,
    /// Upper corner of the box, m.
    pub(super) high: Vec3,
    /// Cone of the lights' axes: normals of triangles, axes of lights without a surface.
    pub(super) axes: Cone,
    /// Angle about an axis beyond which it is dark, rad. Up to there the intensity falls with the cosine.
    pub(super) beyond: f32,
    /// Intensity of all lights together along their axes, as the sensor sees it, in relative units.
    pub(super) intensity: f32,
    /// Whether any light shines against its axis too.
    pub(super) two_sided: bool,
}

/// Extract of [`LightBounds`] for [`LightSampleContext::importance`](super::LightSampleContext).
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    /// Middle of the box, m.
    pub(super) centre: Vec3A,
    /// Half its extent, m.
    pub(super) half: Vec3A,
    /// Middle of the cone of axes.
    pub(super) axis: Vec3A,
    /// Cosine of half the angle of the cone of axes.
    pub(super) cos_cone: f32,
    /// Smallest cosine to an axis with any light.
    pub(super) cos_beyond: f32,
    /// Intensity of all lights together, see [`LightBounds::intensity`].
    pub(super) intensity: f32,
    /// Whether any light shines against its axis too.
    pub(super) two_sided: bool,
}

/// Lights shine this far beyond their cones, rad, so that no rounding cuts light off.
const SLACK: f32 = 2e-3;

impl LightBounds {
    /// A light without a surface, of that power, wherever its motion takes it; `None` where it is infinitely far.
    pub(super) fn of_delta_light(light: &DeltaLight, motion: Option<&Motion>, power: f64) -> Option<Self> {
        let DeltaExtent { radius, directions: axes } = light.extent()?;
        let position = light.pose().position;
        let solid_angle = TAU * (1.0 - axes.widened(SLACK).angle.cos());
        let bounds = (position - radius, position + radius);
        let (low, high) = motion.map_or(bounds, |motion| motion.bounds(bounds));
        let axes = motion.map_or(axes, |motion| motion.directions(axes));
        let intensity = (power / f64::from(solid_angle)) as f32;
        Some(Self { low, high, axes, beyond: SLACK, intensity, two_sided: false })
    }

    /// A surface shines with the cosine to its normal.
    pub(super) fn of_area_light(light: &AreaLight, power: f64, geometry: &Geometry) -> Self {
        let shape = Emitter::at(geometry, light.primitive, 0.0);
        let (low, high, axes) = match light.primitive {
            Primitive::Triangle(triangle) => swept_triangle(triangle, geometry),
            Primitive::Quadric(quadric) => {
                let (low, high) = geometry.quadrics[quadric as usize].bounds;
                (low, high, shape.as_ref().map(EmitterShape::normals))
            }
        };
        let sides = if light.emission.two_sided { 2.0 } else { 1.0 };
        // Of all its area, what is seen at once.
        let seen = shape.map_or(1.0, |shape| f64::from(shape.widest()) / f64::from(shape.area()));
        Self {
            low,
            high,
            axes: axes.map_or(Cone::ALL, Cone::hull),
            beyond: FRAC_PI_2,
            intensity: (power * seen / (sides * std::f64::consts::PI)) as f32,
            two_sided: light.emission.two_sided,
        }
    }

    /// Bounds of both.
    pub(super) fn union(&self, other: &Self) -> Self {
        let two_sided = self.two_sided || other.two_sided;
        // Two axes of what shines along both ways are as near as the acute angle between them.
        let flip = self.two_sided && other.two_sided && self.axes.axis.dot(other.axes.axis) < 0.0;
        let other_axes = if flip { Cone { axis: -other.axes.axis, ..other.axes } } else { other.axes };
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            axes: self.axes.union(other_axes),
            beyond: self.beyond.max(other.beyond),
            intensity: self.intensity + other.intensity,
            two_sided,
        }
    }

    /// Cost of a choice among the lights within the bounds by their intensities alone: intensity × solid angle that
    /// they shine into × area ([Conty18](photosite_core::references#conty18) eq. 1 and §4.4). The area is the square of
    /// the box's diagonal, since lights in a row have boxes without surface.
    pub(super) fn cost(&self) -> f32 {
        let (cone, farthest) = (self.axes.angle, (self.axes.angle + self.beyond).min(PI));
        let solid_angle = TAU * (1.0 - cone.cos())
            + FRAC_PI_2
                * (2.0 * farthest * cone.sin() - (cone - 2.0 * farthest).cos() - 2.0 * cone * cone.sin() + cone.cos());
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        self.intensity * solid_angle * sides * (self.high - self.low).length_squared()
    }

    /// Middle of the box.
    pub(super) fn centre(&self) -> Vec3 {
        self.low + (self.high - self.low) * 0.5
    }

    /// Returns the extract for sampling, with `scale` times the intensity.
    pub(super) fn cluster(&self, scale: f32) -> Cluster {
        Cluster {
            centre: self.centre().into(),
            half: (0.5 * (self.high - self.low)).into(),
            axis: self.axes.axis.into(),
            cos_cone: self.axes.angle.cos(),
            cos_beyond: self.beyond.cos().max(0.0),
            intensity: self.intensity * scale,
            two_sided: self.two_sided,
        }
    }
}

/// Box and normals of a triangle at all times. While its corners move on straight lines the normal stays a sum of three
/// directions with positive weights: n(t) = (1−t)²·n₀ + 2t(1−t)·n₁ + t²·n₂, Bernstein's form of the product of two
/// edges.
fn swept_triangle(triangle: u32, geometry: &Geometry) -> (Vec3, Vec3, Option<Cone>) {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let mut axes: Option<Cone> = None;
    let mut before: Option<[Vec3; 2]> = None;
    for [a, b, c] in geometry.shapes(triangle) {
        (low, high) = (low.min(a).min(b).min(c), high.max(a).max(b).max(c));
        let edges = [b - a, c - a];
        let mut normals = [Some(edges[0].cross(edges[1])), None];
        if let Some([x, y]) = before {
            normals[1] = Some(x.cross(edges[1]) + edges[0].cross(y));
        }
        for normal in normals.into_iter().flatten().filter_map(Vec3::try_normalize) {
            axes = Some(axes.map_or(Cone::of(normal), |axes| axes.union(Cone::of(normal))));
        }
        before = Some(edges);
    }
    (low, high, axes)
}
