//! Response that bends: signals over the light that made them.

use super::lines::MeasuredLine;
use super::measured::Measured;
use super::photon_transfer::TransferPoint;

/// Response y = y₀·(1 + b·y₀) of the signal y₀ that a linear one would give, DN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// b, 1/DN.
    pub per_dn: Measured,
}

/// Fewest points that tell a bend, and the least factor between their light.
const FEWEST: usize = 4;
const LEAST_RANGE: f64 = 3.0;

impl Bend {
    /// Bend of points with light in any unit: photons, or the exposure times of steady light. The line of y/H over H has
    /// the slope a²·b and the offset a, the response to little light. `None` where light is unknown or hardly changes.
    pub(super) fn of(points: &[TransferPoint], light: impl Fn(&TransferPoint) -> Option<f64>) -> Option<Self> {
        let ratio = |point: &TransferPoint| {
            let light = light(point).filter(|light| *light > 0.0)?;
            Some((light, point.signal.times(1.0 / light)))
        };
        let ratios: Vec<(f64, Measured)> = points.iter().map(ratio).collect::<Option<_>>()?;
        let light = ratios.iter().map(|(light, _)| *light);
        let (least, most) =
            light.fold((f64::INFINITY, 0.0), |(least, most), h| (f64::min(least, h), f64::max(most, h)));
        if ratios.len() < FEWEST || most < LEAST_RANGE * least {
            return None;
        }
        let line = MeasuredLine::through(&ratios)?;
        let square = line.offset.value.powi(2);
        Some(Self { per_dn: line.slope.times(1.0 / square) }).filter(|bend| bend.per_dn.value.is_finite())
    }

    /// Whether the bend is told apart from none.
    pub(super) fn is_told(&self) -> bool {
        self.per_dn.value.abs() > 3.0 * self.per_dn.standard_error
    }

    /// Signal that a linear response would give: y₀ = 2y/(1 + √(1 + 4·b·y)).
    pub(super) fn linear(&self, signal: f64) -> f64 {
        2.0 * signal / (1.0 + (1.0 + 4.0 * self.per_dn.value * signal).max(0.0).sqrt())
    }

    /// Signal y₀ times the slope 1 + 2·b·y₀, by which deviations of pixels are divided for those of their responses: at
    /// y = y₀·(1 + b·y₀) they are (1 + 2·b·y₀)/(1 + b·y₀) times as large.
    pub(super) fn scale_of_deviations(&self, signal: f64) -> f64 {
        let linear = self.linear(signal);
        linear * (1.0 + 2.0 * self.per_dn.value * linear)
    }

    /// The point that a linear response would give: noise passes with the slope 1 + 2·b·y₀.
    pub(super) fn straightened(&self, point: &TransferPoint) -> TransferPoint {
        let signal = self.linear(point.signal.value);
        let slope = 1.0 + 2.0 * self.per_dn.value * signal;
        let (of_signal, of_noise) = (slope.recip(), slope.powi(-2));
        let [bright, dark] = point.variances;
        TransferPoint {
            signal: Measured::new(signal, point.signal.standard_error * of_signal.abs()),
            noise: point.noise.times(of_noise),
            variances: [bright.times(of_noise), dark],
            ..*point
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a gain of 0.5 DN/e⁻ whose response bends by b.
    fn points(b: f64) -> Vec<TransferPoint> {
        let point = |i: u32| {
            let (photons, gain) = (1000.0 * f64::from(i), 0.5);
            let linear = gain * photons;
            let (signal, slope) = (linear * (1.0 + b * linear), 1.0 + 2.0 * b * linear);
            let noise = Measured::new(slope * slope * gain * linear, 1.0);
            TransferPoint {
                group: i as usize,
                photons: Some(photons),
                signal: Measured::new(signal, 1e-4 * signal),
                noise,
                variances: [noise, Measured::default()],
                clarity: 1.0,
                mean: Measured::new(signal, 0.1),
                clipped: 0.0,
                time: None,
                has_dark: true,
            }
        };
        (1..=12).map(point).collect()
    }

    #[test]
    fn bends_are_found_and_straightened() {
        for b in [-5e-6, 2e-6] {
            let points = points(b);
            let bend = Bend::of(&points, |point| point.photons).expect("a bend");
            assert!(bend.is_told() && (bend.per_dn.value / b - 1.0).abs() < 0.01, "{bend:?}");
            for point in &points {
                let straight = bend.straightened(point);
                let linear = 0.5 * point.photons.expect("known");
                assert!((straight.signal.value / linear - 1.0).abs() < 1e-3, "{straight:?}");
                assert!((straight.noise.value / (0.5 * linear) - 1.0).abs() < 2e-3, "{straight:?}");
            }
        }
        let none = Bend::of(&points(0.0), |point| point.photons).expect("a bend");
        assert!(!none.is_told());
        assert_eq!(Bend::of(&points(1e-6), |_| None), None);
        assert_eq!(Bend::of(&points(1e-6)[..3], |point| point.photons), None);
        assert_eq!(Bend::of(&points(1e-6)[7..], |point| point.photons), None);
    }
}
