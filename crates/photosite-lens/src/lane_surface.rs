//! Rays in lanes at one surface: intersection, clipping by its aperture, and refraction.

use glam::Vec2;
use photosite_simd::{LaneMask, Real, Vector, WideLanes};

use crate::films::TERMS;
use crate::lens::Lens;
use crate::profile::{Profile, Travel};

/// Step of Newton's method, mm, below which an asphere counts as reached: single precision has no shorter steps far
/// from the axis.
const SHORTEST_STEP_MM: f32 = 1e-5;
/// Largest number of steps, after which a ray counts as one that misses.
const MOST_STEPS: u32 = 20;

/// A surface for rays in lanes, with z along the way of the ray.
#[derive(Clone, Debug)]
pub(crate) struct LaneSurface {
    /// Number of the surface in the lens.
    pub(crate) number: usize,
    curvature: f32,
    /// Sum 1 + k of the conic.
    conic1: f32,
    asphere: Option<LaneAsphere>,
    semi_aperture2: f32,
    /// Distance to the next surface, mm.
    pub(crate) gap_mm: f32,
    /// Whether there is glass on either side.
    pub(crate) is_of_glass: bool,
    /// Normals of the edges of a stop with blades, and the edges' distance from the axis, mm.
    blades: Option<(Vec<Vec2>, f32)>,
}

/// Aspheric terms Σ a_m·r^m as r²·Σ aᵢ·uⁱ, with u = r² where all orders are even, else u = r.
#[derive(Clone, Debug)]
struct LaneAsphere {
    is_even: bool,
    sag: Vec<f32>,
    slope: Vec<f32>,
}

/// Rays in lanes, z along their way from the vertex of the surface that they come to.
pub(crate) struct Rays<W> {
    pub(crate) point: Vector<W>,
    pub(crate) direction: Vector<W>,
    /// Fraction of the light that has passed; 0 for blocked rays.
    pub(crate) passed: W,
}

/// Intersection of rays with a surface.
pub(crate) struct Met<W: Real> {
    /// Unit normal, on the side of the ray's direction.
    normal: Vector<W>,
    /// Cosine of the angle of incidence.
    cosine: W,
    /// Mask of rays that meet the surface.
    is_met: W::Mask,
}

impl LaneSurface {
    /// Surface of a lens, for rays of one way.
    pub(crate) fn new(lens: &Lens, number: usize, travel: Travel) -> Self {
        let surface = &lens.surfaces()[number];
        let sign = travel.sign();
        let next_gap = match travel {
            Travel::ToSensor => Some(number),
            Travel::ToScene => number.checked_sub(1),
        };
        let asphere = |profile: &Profile| {
            let (is_even, sag, slope) = profile.polynomial()?;
            let signed = |terms: &[f64]| terms.iter().map(|a| (sign * a) as f32).collect();
            Some(LaneAsphere { is_even, sag: signed(sag), slope: signed(slope) })
        };
        let edges = lens.stop_edges().filter(|_| number == lens.stop());
        Self {
            number,
            curvature: (sign * surface.profile.curvature()) as f32,
            conic1: (1.0 + surface.profile.conic()) as f32,
            asphere: asphere(&surface.profile),
            semi_aperture2: surface.semi_aperture_mm.powi(2) as f32,
            gap_mm: next_gap.map_or(0.0, |gap| lens.gap_mm(gap) as f32),
            is_of_glass: surface.glass.is_some() || number > 0 && lens.surfaces()[number - 1].glass.is_some(),
            blades: edges.map(|(normals, distance)| (normals.iter().map(|n| n.as_vec2()).collect(), distance as f32)),
        }
    }
}

impl<W: WideLanes> Rays<W> {
    /// Advances the rays from z = 0 at `origin` to the plane z = `plane`.
    #[inline(always)]
    pub(crate) fn go_to(&mut self, origin: f32, plane: f32) {
        let z = self.point.z + self.passed.broadcast(origin);
        let plane = self.passed.broadcast(plane);
        let distance = (plane - z) / self.direction.z;
        let Vector { x, y, .. } = self.point + self.direction * distance;
        self.point = Vector::new(x, y, plane);
    }

    /// Whether any ray is not blocked.
    #[inline(always)]
    pub(crate) fn any(&self) -> bool {
        self.passed.broadcast(0.0).lt(self.passed).bits() != 0
    }

    /// Advances the rays to a surface.
    #[inline(always)]
    pub(crate) fn meet(&mut self, surface: &LaneSurface) -> Met<W> {
        let Self { point, direction, passed } = self;
        let (zero, one) = (passed.broadcast(0.0), passed.broadcast(1.0));
        let (c, k1) = (passed.broadcast(surface.curvature), passed.broadcast(surface.conic1));

        // The conic c·(x² + y² + (1 + k)·z²) = 2·z: of its two points that at which normal·ray is above 0
        let is_sphere = surface.conic1 == 1.0;
        let flattened = Vector::new(point.x, point.y, if is_sphere { point.z } else { k1 * point.z });
        let a = if is_sphere {
            c
        } else {
            c * (direction.x * direction.x + direction.y * direction.y + k1 * direction.z * direction.z)
        };
        let b = direction.z - c * flattened.dot(*direction);
        let offset = c * flattened.dot(*point) - point.z - point.z;
        let root = (b * b - a * offset).sqrt();
        // (b − root)/a, written so that nothing cancels
        let is_ahead = zero.lt(b);
        let distance = W::select(is_ahead, offset, b - root) / W::select(is_ahead, b + root, a);

        if let Some(asphere) = &surface.asphere {
            // A polynomial may reach out to a ray that passes the conic by
            let start = W::select(zero.le(root), distance, -point.z / direction.z);
            return self.meet_asphere((c, k1), asphere, start);
        }
        *point = *point + *direction * distance;
        let normal = Vector::new(-(c * point.x), -(c * point.y), one - c * k1 * point.z);
        // Else it is on the far half of the sphere, or on the other branch of the hyperbola; a root that is no number is a miss
        let is_met = zero.le(root) & zero.le(normal.z);
        if is_sphere {
            // The normal has length 1, and the root is the cosine of the angle of incidence
            return Met { normal, cosine: root, is_met };
        }
        let normal = normal * (one / normal.dot(normal).sqrt());
        let cosine = normal.dot(*direction);
        Met { normal, cosine, is_met: is_met & zero.lt(cosine) }
    }

    /// Advances the rays to an asphere by Newton's method on F = z − z(r).
    #[inline(always)]
    fn meet_asphere(&mut self, (c, k1): (W, W), asphere: &LaneAsphere, start: W) -> Met<W> {
        let Self { point, direction, passed } = self;
        let (zero, one) = (passed.broadcast(0.0), passed.broadcast(1.0));
        let shortest = passed.broadcast(SHORTEST_STEP_MM);
        let mut distance = start;
        let mut is_reached = zero.lt(zero);
        for _ in 0..MOST_STEPS {
            let at = *point + *direction * distance;
            let r2 = at.x * at.x + at.y * at.y;
            let root = (one - k1 * c * c * r2).sqrt();
            let sag = r2 * (c / (one + root) + asphere.over_r2(&asphere.sag, r2));
            let slope = c / root + asphere.over_r2(&asphere.slope, r2);
            let step = (at.z - sag) / (direction.z - slope * (at.x * direction.x + at.y * direction.y));
            // A ray that has reached it stays there while others go on: what becomes of it must not depend on these
            distance = W::select(is_reached, distance, distance - step);
            is_reached = is_reached | step.abs().lt(shortest);
            if (zero.lt(*passed) & !is_reached).bits() == 0 {
                break;
            }
        }
        *point = *point + *direction * distance;
        let r2 = point.x * point.x + point.y * point.y;
        let slope = c / (one - k1 * c * c * r2).sqrt() + asphere.over_r2(&asphere.slope, r2);
        let normal = Vector::new(-(slope * point.x), -(slope * point.y), one);
        let normal = normal * (one / normal.dot(normal).sqrt());
        let cosine = normal.dot(*direction);
        Met { normal, cosine, is_met: is_reached & zero.lt(cosine) }
    }

    /// Blocks the rays that have missed the surface, or are outside its aperture or on a blade.
    #[inline(always)]
    pub(crate) fn clip(&mut self, surface: &LaneSurface, met: &Met<W>) {
        let Vector { x, y, .. } = self.point;
        let mut passes = met.is_met & (x * x + y * y).le(x.broadcast(surface.semi_aperture2));
        if let Some((normals, distance)) = &surface.blades {
            let distance = x.broadcast(*distance);
            for normal in normals {
                passes = passes & (x.broadcast(normal.x) * x + x.broadcast(normal.y) * y).le(distance);
            }
        }
        self.passed = W::select(passes, self.passed, x.broadcast(0.0));
    }

    /// Refracts the rays by a film's terms, which are the ratio µ of the indices and the coefficients of its
    /// transmittance: D′ = µ·D + (√(1 − µ²·(1 − cos²i)) − µ·cos i)·N ([Welford86](photosite_core::references#welford86)
    /// §4.3). Totally reflected rays are blocked.
    #[inline(always)]
    pub(crate) fn refract(&mut self, met: &Met<W>, terms: &[W; TERMS], [middle, half_range]: [f32; 2]) {
        let Met { normal, cosine, .. } = *met;
        let (zero, one) = (cosine.broadcast(0.0), cosine.broadcast(1.0));
        let [ratio, c0, c1, c2, c3, c4] = *terms;
        let squared = one - ratio * ratio * (one - cosine * cosine);
        let behind = squared.sqrt();
        let turned = self.direction * ratio + normal * (behind - ratio * cosine);
        // Rounding has left it a little off its length, which 1/√x ≈ (3 − x)/2 puts right
        let half = cosine.broadcast(0.5);
        self.direction = turned * (one + half - half * turned.dot(turned));
        // On the side of the thinner medium, where the angle is larger
        let steeper = (cosine.min(behind) - cosine.broadcast(middle)) * cosine.broadcast(1.0 / half_range);
        let x = steeper.max(-one);
        let transmittance = c0 + x * (c1 + x * (c2 + x * (c3 + x * c4)));
        self.passed = W::select(zero.le(squared), self.passed * transmittance, zero);
    }
}

impl LaneAsphere {
    /// Sum over r², of `coefficients` at r².
    #[inline(always)]
    fn over_r2<W: Real>(&self, coefficients: &[f32], r2: W) -> W {
        let u = if self.is_even { r2 } else { r2.sqrt() };
        let mut sum = r2.broadcast(0.0);
        for coefficient in coefficients.iter().rev() {
            sum = sum * u + r2.broadcast(*coefficient);
        }
        sum
    }
}
