//! Black level of a converter, which may change with the analogue gain.
//!
//! An offset before the amplifier grows with the gain, and one behind it stays: b = b₀ + b₁·K. So it is between two of
//! `[[noise.gain_steps]]`; beyond the first and the last the black level stays.

use photosite_core::Invalid;
use photosite_core::units::Decibels;

use super::gain_steps::{GainStepDescription, around, missing};

/// Digital number of no charge at each gain.
#[derive(Clone, Debug, PartialEq)]
pub struct BlackLevelByGain {
    /// Black level without steps.
    of_all: u16,
    /// Steps in the order of their gains; none of a black level that is the same at all gains.
    steps: Vec<(Decibels, u16)>,
}

impl BlackLevelByGain {
    /// Steps over the black level of `[adc]`, which stands where no step states one. `max_dn` is the largest number of
    /// the converter. Keys of errors are those of `[noise]`.
    pub(crate) fn new(of_all: u16, max_dn: u16, steps: &[GainStepDescription]) -> Result<Self, Invalid> {
        if steps.iter().all(|step| step.black_level_dn.is_none()) {
            return Ok(Self::from(of_all));
        }
        let step = |(i, step): (usize, &GainStepDescription)| {
            let within = |invalid: Invalid| invalid.within(&format!("gain_steps[{i}]"));
            let black = step.black_level_dn.ok_or_else(|| within(missing("black_level_dn")))?;
            let black = checked_black_level(black, max_dn).map_err(within)?;
            Ok::<_, Invalid>((Decibels(step.gain_db), black))
        };
        Ok(Self { of_all, steps: steps.iter().enumerate().map(step).collect::<Result<_, _>>()? })
    }

    /// Black level at an analogue gain, DN: between two steps on a straight line over K, rounded.
    pub fn at(&self, gain: Decibels) -> u16 {
        let Some([(from, below), (to, above)]) = around(&self.steps, gain) else { return self.of_all };
        if below == above {
            return below;
        }
        let part = (gain.factor() - from.factor()) / (to.factor() - from.factor());
        // Between two numbers of 16 bits.
        (f64::from(below) + part * (f64::from(above) - f64::from(below))).round() as u16
    }

    /// Whether gains differ in their black level.
    pub fn changes(&self) -> bool {
        self.steps.windows(2).any(|pair| pair[0].1 != pair[1].1)
    }

    /// Whether steps state it.
    pub(crate) fn is_of_steps(&self) -> bool {
        !self.steps.is_empty()
    }

    /// Black level of `[adc]`, which has no effect as steps state another at a gain.
    pub(crate) fn idle(&self, gain: Decibels) -> Option<[u16; 2]> {
        let stated = self.at(gain);
        (self.of_all != stated).then_some([self.of_all, stated])
    }
}

impl From<u16> for BlackLevelByGain {
    fn from(of_all: u16) -> Self {
        Self { of_all, steps: Vec::new() }
    }
}

/// A black level that leaves room below the largest number of a converter.
pub(super) fn checked_black_level(black_level_dn: u32, max_dn: u16) -> Result<u16, Invalid> {
    u16::try_from(black_level_dn).ok().filter(|&black| black < max_dn).ok_or_else(|| {
        let message = format!("{black_level_dn} leaves no room below the largest number, {max_dn}");
        let bits = (u32::from(max_dn) + 1).ilog2();
        Invalid::new("black_level_dn", message)
            .help(format!("write less than {max_dn}, the largest number of {bits} bits"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(values: &[(f64, u32)]) -> Result<BlackLevelByGain, Invalid> {
        let step = |&(gain_db, black): &(f64, u32)| GainStepDescription {
            gain_db,
            black_level_dn: Some(black),
            ..GainStepDescription::default()
        };
        BlackLevelByGain::new(64, 4095, &values.iter().map(step).collect::<Vec<_>>())
    }

    #[test]
    fn offsets_before_the_amplifier_grow_with_the_gain() {
        // 60 + 4·K/K₀.
        let black = steps(&[(0.0, 64), (20.0, 100)]).expect("valid");
        for (gain, wanted) in [(-6.0, 64), (0.0, 64), (20.0 * 4f64.log10(), 76), (20.0, 100), (30.0, 100)] {
            assert_eq!(black.at(Decibels(gain)), wanted, "{gain} dB");
        }
        assert!(black.changes() && black.idle(Decibels(0.0)).is_none());
        let same = steps(&[(0.0, 70), (20.0, 70)]).expect("valid");
        assert!(!same.changes());
        assert_eq!(same.idle(Decibels(0.0)), Some([64, 70]));
        assert_eq!(steps(&[]).expect("valid").at(Decibels(3.0)), 64);
    }

    #[test]
    fn steps_have_room_below_the_largest_number() {
        let error = steps(&[(0.0, 64), (20.0, 4095)]).expect_err("no room");
        assert!(error.to_string().contains("gain_steps[1].black_level_dn: 4095 leaves no room"), "{error}");
    }
}
