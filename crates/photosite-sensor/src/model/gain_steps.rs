//! `[[noise.gain_steps]]`: noise of the read-out that changes with the analogue gain. Black levels that do are in
//! [`black_level`](super::black_level).
//!
//! What amplifiers add before the gain stays when it rises, and what comes after it becomes less, referred to electrons:
//! a camera of 3.0 e⁻ at 0 dB may have 1.5 e⁻ at 24 dB. Between two steps the logarithm of a standard deviation goes
//! along a straight line over the gain in decibels, that is log σ against log K, which measured cameras follow
//! ([Wei20](photosite_core::references#wei20)); a line through an end of 0 e⁻ is straight itself. Beyond the
//! first and the last step their values stay.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::within;
use photosite_core::units::{Decibels, Electrons};

use super::checks::{electrons, finite, not_negative};
use super::fixed_pattern::FixedPattern;

/// Noise of the read-out and black level at one analogue gain. A figure that no step has is at all gains that of `[noise]`, or
/// of `[adc]` for the black level; one that a step has, all have.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct GainStepDescription {
    /// Analogue gain, dB.
    pub gain_db: f64,
    /// Temporal dark noise of the read-out, standard deviation in e⁻.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..))]
    pub read_noise_e: Option<f64>,
    /// Temporal noise that the pixels of a row share, standard deviation in e⁻.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..))]
    pub row_noise_e: Option<f64>,
    /// Temporal noise that the pixels of a column share, standard deviation in e⁻.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..))]
    pub column_noise_e: Option<f64>,
    /// Dark signal non-uniformity: spatial standard deviation of the dark signal, e⁻.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..))]
    pub dsnu_e: Option<f64>,
    /// Part of DSNU that the pixels of a row share, in addition, e⁻.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..))]
    pub dsnu_row_e: Option<f64>,
    /// Part of DSNU that the pixels of a column share, in addition, e⁻.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..))]
    pub dsnu_column_e: Option<f64>,
    /// Digital number of no charge, in place of `adc.black_level_dn`. Between two steps it goes along a straight line
    /// over the system gain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..65_535.0))]
    pub black_level_dn: Option<u32>,
}

/// Noise of the read-out at a gain, referred to electrons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOutNoise {
    /// Standard deviation of the read noise.
    pub read: Electrons,
    /// Standard deviation of temporal noise that a row shares.
    pub row: Electrons,
    /// Standard deviation of temporal noise that a column shares.
    pub column: Electrons,
    /// Dark signal (DSNU), e⁻.
    pub dsnu: FixedPattern,
}

/// Noise of the read-out at all gains.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOutNoiseByGain {
    /// Noise without steps.
    of_all: ReadOutNoise,
    /// Steps in the order of their gains.
    steps: Vec<(Decibels, ReadOutNoise)>,
}

/// Key of a figure, and its place in a step.
type Figure = (&'static str, fn(&GainStepDescription) -> Option<f64>, fn(&mut ReadOutNoise) -> &mut f64);

/// All figures that may change with gain.
const FIGURES: [Figure; 6] = [
    ("read_noise_e", |step| step.read_noise_e, |noise| &mut noise.read.0),
    ("row_noise_e", |step| step.row_noise_e, |noise| &mut noise.row.0),
    ("column_noise_e", |step| step.column_noise_e, |noise| &mut noise.column.0),
    ("dsnu_e", |step| step.dsnu_e, |noise| &mut noise.dsnu.pixel),
    ("dsnu_row_e", |step| step.dsnu_row_e, |noise| &mut noise.dsnu.row),
    ("dsnu_column_e", |step| step.dsnu_column_e, |noise| &mut noise.dsnu.column),
];

impl ReadOutNoise {
    /// No noise.
    pub const NONE: Self = Self {
        read: Electrons(0.0),
        row: Electrons(0.0),
        column: Electrons(0.0),
        dsnu: FixedPattern { pixel: 0.0, row: 0.0, column: 0.0 },
    };

    /// Noise whose figures are made of those of two others.
    fn combined(mut self, mut other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        for (_, _, place) in FIGURES {
            *place(&mut self) = of(*place(&mut self), *place(&mut other));
        }
        self
    }
}

impl ReadOutNoiseByGain {
    /// No noise.
    pub const NONE: Self = Self::constant(ReadOutNoise::NONE);

    /// The same noise at all gains.
    pub const fn constant(noise: ReadOutNoise) -> Self {
        Self { of_all: noise, steps: Vec::new() }
    }

    /// Steps over the noise that holds for figures which no step has. Keys of errors are those of `[noise]`.
    pub(crate) fn new(of_all: ReadOutNoise, steps: &[GainStepDescription]) -> Result<Self, Invalid> {
        let mut found: Vec<(Decibels, ReadOutNoise)> = Vec::new();
        for (i, step) in steps.iter().enumerate() {
            let at = |invalid: Invalid| invalid.within(&format!("gain_steps[{i}]"));
            let gain = finite("gain_db", step.gain_db).map_err(at)?;
            if let Some((before, _)) = found.last().filter(|(before, _)| before.0 >= gain) {
                let message = format!("must rise from step to step, got {gain} after {}", before.0);
                return Err(at(Invalid::new("gain_db", message).help("write the steps in the order of their gains")));
            }
            let mut noise = of_all;
            for (key, stated, place) in FIGURES {
                match stated(step) {
                    Some(value) => *place(&mut noise) = not_negative(key, value).map_err(at)?,
                    None if steps.iter().any(|other| stated(other).is_some()) => {
                        return Err(at(missing(key)));
                    }
                    None => {}
                }
            }
            if FIGURES.iter().all(|(_, stated, _)| stated(step).is_none()) && step.black_level_dn.is_none() {
                let message = "states neither noise nor black level";
                return Err(at(Invalid::new("", message).help("for example read_noise_e = 3.0")));
            }
            found.push((Decibels(gain), noise));
        }
        Ok(Self { of_all, steps: found })
    }

    /// Noise at an analogue gain: log σ on a straight line over log K between two steps.
    pub fn at(&self, gain: Decibels) -> ReadOutNoise {
        let Some([(from, below), (to, above)]) = around(&self.steps, gain) else { return self.of_all };
        // Without a value beyond the ends, where both are the same noise.
        let part = (gain.0 - from.0) / (to.0 - from.0);
        below.combined(above, |a, b| {
            if part == 0.0 || a == b {
                a
            } else if a > 0.0 && b > 0.0 {
                (a.ln() + part * (b.ln() - a.ln())).exp()
            } else {
                a + part * (b - a)
            }
        })
    }

    /// Largest noise at any gain, figure by figure.
    pub fn largest(&self) -> ReadOutNoise {
        match self.steps.split_first() {
            None => self.of_all,
            Some(((_, first), rest)) => rest.iter().fold(*first, |most, (_, step)| most.combined(*step, f64::max)),
        }
    }

    /// Changes the noise at all gains.
    pub fn change(&mut self, change: impl Fn(&mut ReadOutNoise)) {
        change(&mut self.of_all);
        self.steps.iter_mut().for_each(|(_, noise)| change(noise));
    }

    /// Gains of the steps and the noise there; none of a noise that is the same at all gains.
    pub fn steps(&self) -> &[(Decibels, ReadOutNoise)] {
        &self.steps
    }

    /// Least and largest gain of the steps, if a gain lies outside of them.
    pub fn beyond(&self, gain: Decibels) -> Option<[Decibels; 2]> {
        let range = [self.steps.first()?.0, self.steps.last()?.0];
        (gain.0 < range[0].0 || gain.0 > range[1].0).then_some(range)
    }

    /// Keys of `[noise]` that have no effect, as steps state another value at 0 dB.
    pub(crate) fn idle_keys(&self) -> Vec<(&'static str, f64, f64)> {
        if self.steps.is_empty() {
            return Vec::new();
        }
        let (mut of_all, mut stated) = (self.of_all, self.at(Decibels(0.0)));
        let figures = FIGURES.iter().map(|(key, _, place)| (*key, *place(&mut of_all), *place(&mut stated)));
        // A data sheet rounds to a tenth or so.
        figures.filter(|(_, own, of_steps)| *own != 0.0 && (own / of_steps - 1.0).abs() > 0.05).collect()
    }
}

/// Steps on both sides of a gain, the outermost one twice beyond the ends; `None` where there are no steps.
pub(super) fn around<T: Copy>(steps: &[(Decibels, T)], gain: Decibels) -> Option<[(Decibels, T); 2]> {
    let above = steps.partition_point(|(step, _)| step.0 <= gain.0);
    let last = steps.len().checked_sub(1)?;
    Some([steps[above.saturating_sub(1)], steps[above.min(last)]])
}

/// The error of a figure that one step leaves out and another has.
pub(super) fn missing(key: &str) -> Invalid {
    let message = format!("the key `{key}` is missing, which other steps have");
    Invalid::new("", message).help(format!("write {key} in all steps, or in none"))
}

impl From<ReadOutNoise> for ReadOutNoiseByGain {
    fn from(noise: ReadOutNoise) -> Self {
        Self::constant(noise)
    }
}

/// Noise of `[noise]` itself.
pub(super) fn of_all([read, row, column]: [f64; 3], dsnu: FixedPattern) -> Result<ReadOutNoise, Invalid> {
    Ok(ReadOutNoise {
        read: electrons("read_noise_e", read)?,
        row: electrons("row_noise_e", row)?,
        column: electrons("column_noise_e", column)?,
        dsnu,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(values: &[(f64, f64)]) -> ReadOutNoiseByGain {
        let step = |&(gain_db, read): &(f64, f64)| GainStepDescription {
            gain_db,
            read_noise_e: Some(read),
            ..GainStepDescription::default()
        };
        let own = ReadOutNoise { read: Electrons(9.0), row: Electrons(0.5), ..ReadOutNoise::NONE };
        ReadOutNoiseByGain::new(own, &values.iter().map(step).collect::<Vec<_>>()).expect("valid")
    }

    #[test]
    fn log_sigma_goes_along_a_line_over_decibels() {
        let noise = steps(&[(0.0, 3.0), (12.0, 2.0), (24.0, 1.5)]);
        for (gain, wanted) in
            [(-6.0, 3.0), (0.0, 3.0), (6.0, 6f64.sqrt()), (12.0, 2.0), (18.0, 3f64.sqrt()), (24.0, 1.5), (48.0, 1.5)]
        {
            let found = noise.at(Decibels(gain));
            // Two logarithms and an exponential.
            assert!((found.read.0 - wanted).abs() < 1e-14, "{gain} dB: {found:?}");
            // No step has it.
            assert_eq!(found.row, Electrons(0.5));
        }
        assert_eq!(noise.largest().read, Electrons(3.0));
        assert_eq!(noise.beyond(Decibels(24.5)), Some([Decibels(0.0), Decibels(24.0)]));
        assert_eq!((noise.beyond(Decibels(24.0)), noise.beyond(Decibels(0.0))), (None, None));
    }

    #[test]
    fn a_line_to_no_noise_is_straight_and_one_step_holds_everywhere() {
        assert_eq!(steps(&[(0.0, 3.0), (10.0, 0.0)]).at(Decibels(5.0)).read, Electrons(1.5));
        assert_eq!(steps(&[(6.0, 3.0)]).at(Decibels(0.0)).read, Electrons(3.0));
        assert_eq!(steps(&[]).at(Decibels(5.0)).read, Electrons(9.0));
        assert_eq!(steps(&[]).beyond(Decibels(5.0)), None);
    }
}
