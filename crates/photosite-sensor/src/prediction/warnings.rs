//! Warnings about sensors that can be, but are hardly meant so.

use photosite_core::math::float::rounded;
use photosite_core::units::Seconds;

use super::shares::Shares;
use crate::exposure::Exposure;
use crate::model::{FixedPattern, SensorModel};
use crate::signal::effects::{Stage, Stages};

impl SensorModel {
    /// Warnings about a sensor that can be, but is hardly meant so. Keys are those of the capture file.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.cell_warnings();
        warnings.extend(self.full_well_out_of_reach());
        for (key, own, of_steps) in self.noise.read_out.idle_keys() {
            warnings.push(format!(
                "sensor.noise.{key} = {own} has no effect: sensor.noise.gain_steps has {} at 0 dB; change the steps, or \
                 remove it",
                rounded(of_steps, 4)
            ));
        }
        let least = self.converter.gain_range[0];
        warnings.extend(self.converter.black_level.idle(least).map(|[own, of_steps]| {
            format!(
                "sensor.adc.black_level_dn = {own} has no effect: by sensor.noise.gain_steps it is {of_steps} at {} dB; change \
                 the steps, or write {of_steps}",
                rounded(least.0, 4)
            )
        }));
        warnings
    }

    /// Tells where the gain lies outside of the steps for which noise is known, so that the nearest stands for it.
    pub fn gain_beyond_steps(&self, exposure: &Exposure) -> Option<String> {
        let [least, most] = self.noise.read_out.beyond(exposure.gain)?.map(|gain| gain.0);
        Some(format!(
            "sensor.noise.gain_steps: they go from {least} to {most} dB, and the gain is {} dB; what the nearest step \
             has is taken",
            rounded(exposure.gain.0, 4)
        ))
    }

    /// Tells where noise of the dark reaches the low end of the converter, which cuts it off and makes black too bright.
    /// Keys are those of the capture file.
    pub fn clipped_blacks(&self, exposure: &Exposure, stages: Stages) -> Option<String> {
        // Noise that is cut off farther away moves the mean by less than φ(3) − 3·Φ(−3) = 4e-4 of σ.
        const SIGMAS: f64 = 3.0;
        let noise = &self.noise;
        let pattern = |p: FixedPattern| p.pixel.powi(2) + p.row.powi(2) + p.column.powi(2);
        let shares = Shares::new(self, exposure, stages);
        let pattern_e2 =
            if stages.has(Stage::DarkOffset) { pattern(noise.read_out.at(exposure.gain).dsnu) } else { 0.0 };
        let variance_e2 = shares.pixel_e2[0] + shares.shared_e2([1.0; 2]) + pattern_e2;
        let (converter, key) = match &self.converter.dual_gain {
            Some(dual) => (&dual.high, "sensor.adc.dual_gain.black_level_dn"),
            None if self.converter.black_level.is_of_steps() => (&self.converter, "sensor.noise.gain_steps"),
            None => (&self.converter, "sensor.adc.black_level_dn"),
        };
        let gain = converter.system_gain(exposure.gain);
        let dark = if stages.has(Stage::DarkCurrent) {
            noise.dark_electrons(exposure.temperature, exposure.time).0
        } else {
            0.0
        };
        let black = converter.black_level_dn(exposure.gain);
        let level = f64::from(black) + gain * dark;
        let sigma = gain * variance_e2.sqrt();
        (level < SIGMAS * sigma).then(|| {
            format!(
                "{key}: blacks are clipped: {black} DN are only {:.1} σ of the noise in the dark above 0, so that black is too \
                 bright on average; write {} or more",
                level / sigma,
                (4.0 * sigma).ceil()
            )
        })
    }

    /// Tells where the converter ends before the full well at any gain, by more than figures are rounded and numbers are
    /// apart.
    fn full_well_out_of_reach(&self) -> Option<String> {
        const ROUNDED: f64 = 0.02;
        let gain = self.converter.gain_range[0];
        // Logarithmic pixels end where their time says.
        let reached = self.saturation_capacity(&Exposure { gain, ..Exposure::of(Seconds(1.0)) }).0;
        let step = 1.0 / self.converter.system_gain(gain);
        let is_short = reached + step < (1.0 - ROUNDED) * self.full_well.0;
        (is_short && self.logarithmic.is_none()).then(|| {
            format!(
                "sensor.charge.full_well_e: {} e⁻ are never reached, as the converter ends at {} e⁻ even at {} dB: lower \
                 sensor.adc.conversion_gain_dn_per_e (of dual_gain, low_gain_dn_per_e), raise sensor.adc.bits, or write \
                 that as the full well",
                self.full_well.0,
                reached.round(),
                gain.0
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::ReadOutNoise;
    use crate::model::{BlackLevelByGain, GainStepDescription};
    use crate::prediction::warnings::{Exposure, Seconds, Stage, Stages};
    use crate::presets;
    use photosite_core::units::{Decibels, Electrons};

    /// Test of black levels that steps of gain state: keys that act are named, and those that do not.
    #[test]
    fn black_levels_of_steps_are_told_by_their_key() {
        let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
        let step = GainStepDescription { black_level_dn: Some(1), ..GainStepDescription::default() };
        sensor.converter.black_level = BlackLevelByGain::new(64, 4095, &[step]).expect("valid");
        let told = sensor.warnings();
        assert!(told.iter().any(|what| what.contains("sensor.adc.black_level_dn = 64 has no effect")), "{told:?}");
        let clipped = sensor.clipped_blacks(&Exposure::of(Seconds(1e-5)), Stages::ALL).expect("1 DN");
        assert!(clipped.starts_with("sensor.noise.gain_steps: ") && clipped.contains("1 DN are only"), "{clipped}");
    }

    #[test]
    fn blacks_that_the_converter_clips_are_told() {
        for name in presets::names() {
            let mut sensor = presets::model(name).expect("listed");
            let exposure = Exposure::of(Seconds(1e-5));
            assert_eq!(sensor.clipped_blacks(&exposure, Stages::ALL), None, "{name}");
            // 2 σ of 20 DN; a counter without read noise has nothing to clip.
            sensor.converter.black_level = 40.into();
            sensor.converter.conversion_gain_dn_per_e = 2.0;
            sensor.noise.read_out = ReadOutNoise { read: Electrons(10.0), ..ReadOutNoise::NONE }.into();
            let told = sensor.clipped_blacks(&exposure, Stages::NONE.with(Stage::ReadNoise));
            if sensor.converter.dual_gain.is_none() {
                let told = told.expect("2 σ");
                assert!(
                    told.contains("sensor.adc.black_level_dn: ")
                        && told.contains(" 2.0 σ")
                        && told.contains("write 80")
                );
            }
            assert_eq!(sensor.clipped_blacks(&exposure, Stages::NONE), None, "{name}: no noise, nothing to clip");
            sensor.converter.black_level = 64.into();
            let loud = Exposure { gain: Decibels(12.0), ..exposure };
            if sensor.converter.dual_gain.is_none() {
                assert!(sensor.clipped_blacks(&loud, Stages::NONE.with(Stage::ReadNoise)).is_some(), "{name}");
            }
        }
    }

    #[test]
    fn a_full_well_that_the_converter_never_reaches_is_told() {
        for name in presets::names() {
            let mut sensor = presets::model(name).expect("listed");
            assert!(sensor.warnings().is_empty(), "{name}: {:?}", sensor.warnings());
            sensor.full_well.0 *= 1.5;
            let told = sensor.warnings().join("\n");
            let is_logarithmic = sensor.logarithmic.is_some();
            assert!(is_logarithmic || told.contains("sensor.charge.full_well_e: "), "{name}: {told}");
        }
    }
}
