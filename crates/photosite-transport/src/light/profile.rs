//! Lights whose intensity was measured in many directions.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::delta_model::{DeltaExtent, DeltaModel, LightPose};
use super::sample::{LiContext, LiSample};
use photosite_core::math::Cone;
use photosite_core::spectrum::SpectrumId;

/// Luminous intensity, cd, over a sphere of directions around a luminaire, in coordinates of photometric type C
/// ([LM63](photosite_core::references#lm63)): vertical angles from the luminaire's axis, horizontal ones around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Vertical angles, rad from −z of the luminaire's space, rising.
    vertical_rad: Vec<f32>,
    /// Horizontal angles, rad about the axis, from +x towards +y, rising; one alone for a luminaire that is the same
    /// all around. That is counter-clockwise seen from above a luminaire that shines down, as LM-63-2002 §3.0,
    /// "Horizontal angles", has type C.
    horizontal_rad: Vec<f32>,
    /// Intensities, candela[horizontal · number of vertical angles + vertical].
    candela: Vec<f32>,
}

impl Profile {
    /// Takes at least one angle of each kind, rising, and as many intensities as their product, those of a horizontal
    /// angle together. Several horizontal angles go from 0 to 2π.
    pub fn new(vertical_rad: Vec<f32>, horizontal_rad: Vec<f32>, candela: Vec<f32>) -> Self {
        Self { vertical_rad, horizontal_rad, candela }
    }

    /// Intensity, cd, in a unit direction of the luminaire's space: linear in both angles, 0 beyond the vertical ones.
    #[inline]
    pub fn intensity(&self, direction: Vec3) -> f32 {
        let vertical = direction.x.hypot(direction.y).atan2(-direction.z);
        let horizontal = direction.y.atan2(direction.x).rem_euclid(TAU);
        self.at(vertical, horizontal)
    }

    /// Numbers of vertical and of horizontal angles.
    pub(super) fn counts(&self) -> [u32; 2] {
        [&self.vertical_rad, &self.horizontal_rad].map(|angles| angles.len() as u32)
    }

    /// Vertical angles, horizontal angles and intensities, one after the other.
    pub(super) fn numbers(&self) -> impl Iterator<Item = f32> {
        self.vertical_rad.iter().chain(&self.horizontal_rad).chain(&self.candela).copied()
    }

    fn at(&self, vertical: f32, horizontal: f32) -> f32 {
        let Some([(v0, w0), (v1, w1)]) = between(&self.vertical_rad, vertical) else { return 0.0 };
        let Some(horizontals) =
            between(&self.horizontal_rad, horizontal.min(self.horizontal_rad[self.horizontal_rad.len() - 1]))
        else {
            return 0.0;
        };
        let row = |h: usize| {
            let row = &self.candela[h * self.vertical_rad.len()..];
            row[v0] * w0 + row[v1] * w1
        };
        horizontals.into_iter().map(|(h, weight)| row(h) * weight).sum()
    }

    /// Largest angle from −z of the luminaire's space with any light, rad.
    fn reach_rad(&self) -> f32 {
        let n = self.vertical_rad.len();
        let last = (0..self.candela.len()).filter(|i| self.candela[*i] > 0.0).map(|i| i % n).max();
        // One angle alone stands for all. Light fades to the next angle.
        if n == 1 { PI } else { last.map_or(0.0, |last| self.vertical_rad[(last + 1).min(n - 1)]) }
    }

    /// Luminous flux, lm: ∫ I dω by the midpoint rule over half degrees.
    pub fn flux_lm(&self) -> f64 {
        let (rows, columns) = (360u16, if self.horizontal_rad.len() == 1 { 1u16 } else { 720 });
        let mut sum = 0.0;
        for row in 0..rows {
            let vertical = (f32::from(row) + 0.5) * PI / f32::from(rows);
            let mean: f64 = (0..columns)
                .map(|c| f64::from(self.at(vertical, (f32::from(c) + 0.5) * TAU / f32::from(columns))))
                .sum::<f64>()
                / f64::from(columns);
            sum += mean * f64::from(vertical.sin());
        }
        sum * f64::from(TAU) * f64::from(PI) / f64::from(rows)
    }
}

/// The two neighbours of an angle with their weights; `None` outside, unless there is one alone.
#[inline]
fn between(angles: &[f32], angle: f32) -> Option<[(usize, f32); 2]> {
    if angles.len() == 1 {
        return Some([(0, 1.0), (0, 0.0)]);
    }
    let next = angles.partition_point(|a| *a <= angle).min(angles.len() - 1);
    let low = next.checked_sub(1)?;
    let part = (angle - angles[low]) / (angles[next] - angles[low]);
    (part <= 1.0).then_some([(low, 1.0 - part), (next, part)])
}

/// Light of a measured profile. Its level is W·sr⁻¹·nm⁻¹ for each candela.
impl DeltaModel for Profile {
    fn extent(&self, pose: &LightPose) -> Option<DeltaExtent> {
        let directions = Cone::of(pose.world_to_light.inverse() * Vec3::NEG_Z).widened(self.reach_rad());
        Some(DeltaExtent { radius: 0.0, directions })
    }

    fn power_factor(&self, _: f64) -> f64 {
        self.flux_lm()
    }

    #[inline]
    fn sample_li(&self, pose: &LightPose, level: SpectrumId, _: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        let direction = pose.world_to_light * (li.point - pose.position).normalize_or_zero();
        let candela = self.intensity(direction);
        if candela == 0.0 {
            return None;
        }
        LiSample::from_point(li.point, pose.position, li.spectra.sample(level, li.wavelengths) * candela)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_those_of_the_file() {
        // 1 cd down and 3 cd up at 0°, 5 and 7 at 180°, and back.
        let profile = Profile::new(vec![0.0, PI], vec![0.0, PI, TAU], vec![1.0, 3.0, 5.0, 7.0, 1.0, 3.0]);
        for (direction, expected) in
            [(Vec3::X, 2.0), (Vec3::NEG_X, 6.0), (Vec3::Y, 4.0), (Vec3::new(1.0, 0.0, -1.0).normalize(), 1.5)]
        {
            assert!((profile.intensity(direction) - expected).abs() < 1e-5, "{direction}");
        }
        let half = Profile::new(vec![0.0, PI / 2.0], vec![0.0], vec![2.0, 2.0]);
        assert_eq!([Vec3::NEG_Z, Vec3::Z].map(|d| half.intensity(d)), [2.0, 0.0]);
        // Two candela into half of the sphere.
        assert!((half.flux_lm() / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4);
    }
}
