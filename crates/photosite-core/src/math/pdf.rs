//! Probability densities that carry their measure, so that a density per area is never weighed against one per solid
//! angle, and the power heuristic that weighs two of the same measure.

use std::marker::PhantomData;

use super::Real;

/// Marks a density per unit of solid angle, sr⁻¹.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidAngle;

/// Marks a density per unit of surface area, m⁻².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area;

/// A probability density with respect to the measure `M`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pdf<M>(pub f32, PhantomData<M>);

impl<M> Pdf<M> {
    /// A density of `value` per unit of `M`.
    #[inline]
    pub const fn new(value: f32) -> Self {
        Self(value, PhantomData)
    }

    /// The joint density with an independent discrete choice of probability `probability`.
    #[inline]
    #[must_use]
    pub fn times(self, probability: f32) -> Self {
        Self::new(self.0 * probability)
    }

    /// Weight of a sample drawn with density `self` when `other` could have drawn it too: the power heuristic with
    /// β = 2 ([Veach97](crate::references#veach97) eq. 9.14), p²/(p² + q²), written so that it cannot overflow.
    #[inline]
    pub fn power_heuristic(self, other: Self) -> f32 {
        power_heuristic(self.0, other.0)
    }
}

impl Pdf<Area> {
    /// The density per solid angle seen from a point at squared distance `distance_squared` (m²), where
    /// `cos_surface` ≥ 0 is the cosine between the surface's normal and the line of sight: p_ω = p_A·r²/cos θ.
    /// Zero where the surface is seen edge-on.
    #[inline]
    pub fn to_solid_angle(self, distance_squared: f32, cos_surface: f32) -> Pdf<SolidAngle> {
        Pdf::new(to_solid_angle(self.0, distance_squared, cos_surface))
    }
}

/// [`Pdf::power_heuristic`] of any numbers.
#[inline(always)]
pub fn power_heuristic<R: Real>(own: R, other: R) -> R {
    let (zero, one) = (own.broadcast(0.0), own.broadcast(1.0));
    let ratio = other / own;
    R::select(zero.lt(own), one / (one + ratio * ratio), zero)
}

/// [`Pdf::to_solid_angle`] of any numbers.
#[inline(always)]
pub fn to_solid_angle<R: Real>(area_density: R, distance_squared: R, cos_surface: R) -> R {
    let zero = cos_surface.broadcast(0.0);
    R::select(zero.lt(cos_surface), area_density * distance_squared / cos_surface, zero)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_two_techniques_sum_to_one() {
        for (a, b) in [(0.3, 0.7), (1e-20, 1e20), (5.0, 0.0), (1e-30, 1e-30)] {
            let (p, q) = (Pdf::<SolidAngle>::new(a), Pdf::new(b));
            assert!((p.power_heuristic(q) + q.power_heuristic(p) - 1.0).abs() < 1e-6, "{a} {b}");
        }
    }
}
