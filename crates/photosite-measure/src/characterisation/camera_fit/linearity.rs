//! Response that bends: signals over the light that made them.

use super::lines::MeasuredLine;
use super::measured::Measured;

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
    /// Bend of signals in DN with their light in any unit: photons, or the exposure times of steady light. The line of y/H over
    /// H has the slope a²·b and the offset a, the response to little light. `None` where light hardly changes.
    pub(super) fn of(points: &[(f64, Measured)]) -> Option<Self> {
        let lit = points.iter().filter(|(light, _)| *light > 0.0);
        let ratios: Vec<(f64, Measured)> = lit.map(|(light, signal)| (*light, signal.times(1.0 / light))).collect();
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
        linear * self.slope(linear)
    }

    /// Slope 1 + 2·b·y₀ of the response, by which noise passes.
    pub(super) fn slope(&self, linear: f64) -> f64 {
        1.0 + 2.0 * self.per_dn.value * linear
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light and signals of 0.5 DN for each unit whose response bends by b.
    fn points(b: f64) -> Vec<(f64, Measured)> {
        let point = |i: u32| {
            let light = 1000.0 * f64::from(i);
            let signal = 0.5 * light * (1.0 + b * 0.5 * light);
            (light, Measured::new(signal, 1e-4 * signal))
        };
        (1..=12).map(point).collect()
    }

    #[test]
    fn bends_are_found_and_straightened() {
        for b in [-5e-6, 2e-6] {
            let points = points(b);
            let bend = Bend::of(&points).expect("a bend");
            assert!(bend.is_told() && (bend.per_dn.value / b - 1.0).abs() < 0.01, "{bend:?}");
            for (light, signal) in &points {
                let linear = bend.linear(signal.value);
                assert!((linear / (0.5 * light) - 1.0).abs() < 1e-3, "{linear}");
                // Response and slope are those of y₀·(1 + b·y₀) and its derivative.
                let more = 1.001 * linear;
                let rise = more * (1.0 + bend.per_dn.value * more) - signal.value;
                assert!((rise / (more - linear) / bend.slope(linear) - 1.0).abs() < 1e-4, "{rise}");
            }
        }
        assert!(!Bend::of(&points(0.0)).expect("a bend").is_told());
        assert_eq!(Bend::of(&[]), None);
        assert_eq!(Bend::of(&points(1e-6)[..3]), None);
        assert_eq!(Bend::of(&points(1e-6)[7..]), None);
    }
}
