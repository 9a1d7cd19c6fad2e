//! Surface profiles: sag, normal, and intersection with a ray.

use glam::DVec3;

use crate::prescription::Surface;

/// Step of Newton's method, mm, below which the surface counts as reached.
const SHORTEST_STEP_MM: f64 = 1e-12;
/// Largest number of steps, after which a ray counts as one that misses the surface.
const MOST_STEPS: usize = 20;

/// Way of a ray through the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Travel {
    /// Way in, from the scene to the sensor: towards +z, except for rays from more than 90° off the axis.
    ToSensor,
    /// Way out, from the sensor to the scene.
    ToScene,
}

impl Travel {
    /// Sign of the z component of the direction of a ray that runs this way along the axis.
    pub fn sign(self) -> f64 {
        match self {
            Self::ToSensor => 1.0,
            Self::ToScene => -1.0,
        }
    }

    /// Opposite way.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::ToSensor => Self::ToScene,
            Self::ToScene => Self::ToSensor,
        }
    }
}

/// Profile of a surface of revolution about z with its vertex at the origin: the sag at the distance r from the axis,
/// mm, is
///
/// z(r) = c·r²/(1 + √(1 − (1 + k)·c²·r²)) + Σ a_m·r^m
///
/// with the curvature c = 1/R in mm⁻¹ ([Welford86](photosite_core::references#welford86) §4.8).
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    curvature: f64,
    conic: f64,
    polynomial: Polynomial,
}

/// Aspheric terms Σ a_m·r^m as r²·Σ aᵢ·uⁱ, with u = r² where all orders are even, else u = r.
#[derive(Clone, Debug, Default, PartialEq)]
struct Polynomial {
    is_even: bool,
    /// Coefficients a_m, from order 2 on.
    sag: Vec<f64>,
    /// Products m·a_m.
    slope: Vec<f64>,
}

impl Polynomial {
    fn new(terms: &[(u32, f64)]) -> Self {
        let is_even = terms.iter().all(|(order, _)| order % 2 == 0);
        let step = if is_even { 2 } else { 1 };
        let highest = terms.iter().map(|(order, _)| *order).max().unwrap_or(0);
        let coefficient = |m: u32| terms.iter().filter(|(order, _)| *order == m).map(|(_, a)| *a).sum::<f64>();
        let orders = || (2..=highest).step_by(step);
        Self {
            is_even,
            sag: orders().map(coefficient).collect(),
            slope: orders().map(|m| f64::from(m) * coefficient(m)).collect(),
        }
    }

    fn is_zero(&self) -> bool {
        self.sag.is_empty()
    }

    /// Sum over r², of `coefficients` at r².
    fn over_r2(&self, coefficients: &[f64], r2: f64) -> f64 {
        let u = if self.is_even { r2 } else { r2.sqrt() };
        coefficients.iter().rev().fold(0.0, |sum, a| sum * u + a)
    }
}

/// Intersection of a ray with a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Distance along the ray from its origin, mm.
    pub(crate) distance: f64,
    /// Point relative to the vertex, mm.
    pub(crate) point: DVec3,
    /// Unit normal, which points to +z at the vertex.
    pub(crate) normal: DVec3,
}

impl Profile {
    /// Profile of a surface of a prescription, whose values are checked.
    pub(crate) fn new(surface: &Surface) -> Self {
        Self {
            curvature: surface.radius_mm.map_or(0.0, f64::recip),
            conic: surface.conic,
            polynomial: Polynomial::new(&surface.asphere),
        }
    }

    /// Curvature c, mm⁻¹.
    pub(crate) fn curvature(&self) -> f64 {
        self.curvature
    }

    /// Conic constant k.
    pub(crate) fn conic(&self) -> f64 {
        self.conic
    }

    /// Aspheric terms Σ a_m·r^m as r²·Σ aᵢ·uⁱ: whether u = r² rather than r, the coefficients, and those of the slope
    /// over r, m·a_m. `None` of a conic.
    pub(crate) fn polynomial(&self) -> Option<(bool, &[f64], &[f64])> {
        let Polynomial { is_even, sag, slope } = &self.polynomial;
        (!self.polynomial.is_zero()).then_some((*is_even, sag, slope))
    }

    /// Curvature at the vertex, mm⁻¹: c + 2·a₂.
    pub fn vertex_curvature(&self) -> f64 {
        self.curvature + self.polynomial.slope.first().copied().unwrap_or(0.0)
    }

    /// Sag z(r) at r², mm; `None` where the conic ends before r.
    pub fn sag(&self, r2: f64) -> Option<f64> {
        let root = self.root(r2)?;
        Some(self.curvature * r2 / (1.0 + root) + r2 * self.polynomial.over_r2(&self.polynomial.sag, r2))
    }

    /// Slope over radius, z′(r)/r, at r², mm⁻¹: infinite at the rim of a hemisphere, `None` where the conic ends before
    /// r.
    pub fn slope_over_r(&self, r2: f64) -> Option<f64> {
        Some(self.curvature / self.root(r2)? + self.polynomial.over_r2(&self.polynomial.slope, r2))
    }

    /// Root √(1 − (1 + k)·c²·r²); `None` where the conic ends before r.
    fn root(&self, r2: f64) -> Option<f64> {
        let radicand = 1.0 - (1.0 + self.conic) * self.curvature * self.curvature * r2;
        (radicand >= 0.0).then(|| radicand.sqrt())
    }

    /// Intersection of a ray with the surface, from the side given by its way; `origin` is relative to the vertex.
    /// `None` where it misses.
    pub(crate) fn meet(&self, origin: DVec3, direction: DVec3, travel: Travel) -> Option<Meeting> {
        // From the point nearest to the vertex, so that a far origin costs no digits.
        let to_nearest = -origin.dot(direction);
        let nearest = origin + direction * to_nearest;
        let conic = self.meet_conic(nearest, direction, travel);
        let distance = if self.polynomial.is_zero() {
            conic?
        } else {
            // A polynomial may reach out to a ray that passes the conic by.
            self.meet_asphere(conic.unwrap_or(-nearest.z / direction.z), nearest, direction)?
        };
        let point = nearest + direction * distance;
        let normal = self.normal(point)?;
        let is_met = distance.is_finite() && normal.dot(direction) * travel.sign() > 0.0;
        is_met.then_some(Meeting { distance: to_nearest + distance, point, normal })
    }

    /// Unit normal of (−x·s, −y·s, 1), s = z′(r)/r, or its limit at the rim of a hemisphere.
    fn normal(&self, point: DVec3) -> Option<DVec3> {
        let r2 = point.x * point.x + point.y * point.y;
        if self.polynomial.is_zero() {
            // That of the conic times its root, which keeps all digits up to the rim.
            let z = 1.0 - self.curvature * (1.0 + self.conic) * point.z;
            // Else it is on the far half of the sphere, or on the other branch of the hyperbola.
            return (z >= 0.0).then(|| DVec3::new(-self.curvature * point.x, -self.curvature * point.y, z).normalize());
        }
        let s = self.slope_over_r(r2)?;
        Some(DVec3::new(-s * point.x, -s * point.y, 1.0).normalize())
    }

    /// Distance to the conic c·(x² + y² + (1 + k)·z²) = 2·z, to the one of two points at which normal·ray has the sign
    /// of the way. This is not always the nearer one, nor the one nearer to the vertex's plane, and it is right for
    /// rays beyond 90° from the axis.
    fn meet_conic(&self, from: DVec3, direction: DVec3, travel: Travel) -> Option<f64> {
        let (c, k1) = (self.curvature, 1.0 + self.conic);
        let a = c * (1.0 + self.conic * direction.z * direction.z);
        let b = direction.z - c * (from.x * direction.x + from.y * direction.y + k1 * from.z * direction.z);
        let offset = c * (from.x * from.x + from.y * from.y + k1 * from.z * from.z) - 2.0 * from.z;
        let radicand = b * b - a * offset;
        if radicand < 0.0 {
            return None;
        }
        let root = travel.sign() * radicand.sqrt();
        // (b − root)/a, written so that nothing cancels.
        let distance = if b * root > 0.0 { offset / (b + root) } else { (b - root) / a };
        distance.is_finite().then_some(distance)
    }

    /// Intersection with an asphere by Newton's method on F = z − z(r) along the ray.
    fn meet_asphere(&self, start: f64, from: DVec3, direction: DVec3) -> Option<f64> {
        let mut distance = start;
        for _ in 0..MOST_STEPS {
            let point = from + direction * distance;
            let r2 = point.x * point.x + point.y * point.y;
            let off = point.z - self.sag(r2)?;
            let slope = direction.z - self.slope_over_r(r2)? * (point.x * direction.x + point.y * direction.y);
            let step = off / slope;
            distance -= step;
            if step.abs() < SHORTEST_STEP_MM {
                return Some(distance);
            }
        }
        None
    }
}
