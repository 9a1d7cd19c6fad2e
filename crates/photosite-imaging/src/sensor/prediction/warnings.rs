//! Warnings about sensors that can be, but are hardly meant so.

use photosite_core::units::Seconds;

use crate::sensor::exposure::Exposure;
use crate::sensor::model::SensorModel;

impl SensorModel {
    /// Warnings about a sensor that can be, but is hardly meant so. Keys are those of the capture file.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.cell_warnings();
        warnings.extend(self.full_well_out_of_reach());
        warnings
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
    use crate::sensor::presets;

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
