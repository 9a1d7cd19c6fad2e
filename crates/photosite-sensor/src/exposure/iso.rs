//! Sensitivity as photographers state it: the saturation-based ISO speed, and the gains that give it.

use photosite_core::Invalid;
use photosite_core::spectrum::{Spectrum, cie, illuminant};
use photosite_core::units::{Decibels, Electrons, Seconds};

use crate::{Binning, Exposure, RegionOfInterest, SensorModel};

/// The constant of the saturation-based speed, lx·s: a grey of 18 % then lies at 12.7 % of saturation, half a stop
/// below what would just fit.
const SATURATION_CONSTANT: f64 = 78.0;

impl SensorModel {
    /// Saturation-based ISO speed at the gains of an exposure ([Iso12232](photosite_core::references#iso12232)):
    ///
    /// S_sat = 78 lx·s / H_sat,  H_sat = q_sat/r
    ///
    /// with the electrons q_sat at which each pixel saturates and the electrons r for each lx·s on the sensor in light of illuminant
    /// D65. Of the channels it is the one that saturates first. The lens does not count, nor does dark current. `None`
    /// for logarithmic sensors, which have no one speed.
    pub fn iso(&self, exposure: &Exposure) -> Option<f64> {
        let speed = SATURATION_CONSTANT * self.electrons_per_lux_second() / self.pixel_saturation(exposure).0;
        self.logarithmic.is_none().then_some(speed)
    }

    /// The ISO speed at the smallest gain; there is no lower one.
    pub fn base_iso(&self, binning: Binning) -> Option<f64> {
        let region = RegionOfInterest { binning, pixels: None };
        self.iso(&Exposure { gain: self.converter.gain_range[0], region, ..Exposure::of(Seconds(1.0)) })
    }

    /// The analogue and the digital gain that give an ISO speed: as much of it as the sensor can by the first. Speeds
    /// below the base one, rounded, are refused.
    pub fn gains_for_iso(&self, iso: f64, binning: Binning) -> Result<[Decibels; 2], Invalid> {
        let Some(base) = self.base_iso(binning) else {
            let message = format!("sensor {} is logarithmic and has no speed", self.name);
            return Err(Invalid::new("iso", message).help("write gain_db"));
        };
        if !(iso.is_finite() && iso >= base.round().min(base)) {
            let message = format!("{iso} is not among the speeds of sensor {}", self.name);
            return Err(Invalid::new("iso", message).help(format!("its base ISO is {}", base.round())));
        }
        let capacity = Electrons(SATURATION_CONSTANT * self.electrons_per_lux_second() / iso);
        Ok(self.gains_for_capacity(capacity, binning))
    }

    /// The smallest analogue and digital gain at which each pixel saturates at no more than `capacity`.
    pub(crate) fn gains_for_capacity(&self, capacity: Electrons, binning: Binning) -> [Decibels; 2] {
        let [least, most] = self.converter.gain_range;
        let signal = self.amplified(capacity.0 * binning.pixels_per_number());
        let before_merging = self.converter.dual_gain.as_ref().map_or(f64::INFINITY, |dual| dual.low.range_e(least));
        let [across, down] = binning.numbers();
        let merged = |gain| self.converter.range_e(gain) / (binning.weight() * (across * down) as f64);
        if capacity.0 >= self.full_well.0 {
            return [least, Decibels(0.0)];
        }
        let saturating = |at: Decibels| Decibels::of_factor(before_merging.min(merged(at)) / signal);
        let mut analogue = saturating(least);
        if self.converter.black_level.changes() {
            // The black level is that of the gain that is looked for: halves of the range, down to 1e-12 of it.
            let (mut below, mut above) = (least.0, most.0);
            for _ in 0..40 {
                let middle = f64::midpoint(below, above);
                if saturating(Decibels(middle)).0 > middle { below = middle } else { above = middle }
            }
            analogue = if saturating(most).0 > most.0 { saturating(most) } else { Decibels(above) };
        }
        if analogue.0 <= most.0 {
            return [Decibels(analogue.0.max(least.0)), Decibels(0.0)];
        }
        // A curve bends before a digital gain multiplies: what is to be multiplied by d² through a root needs d.
        let power = self.video.curve.map_or(1.0, |curve| curve.gamma);
        [most, Decibels((power * Decibels::of_factor(merged(most) / (signal * most.factor())).0).max(0.0))]
    }

    /// Electrons that 1 lx·s of D65 frees in a pixel of the channel that sees most of it.
    fn electrons_per_lux_second(&self) -> f64 {
        let light = illuminant::d65();
        let electrons = |(_, response): (String, Spectrum)| response.product(light).integral();
        self.responses().into_iter().map(electrons).fold(0.0, f64::max) / cie::luminous(light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{BlackLevelByGain, GainStepDescription};
    use crate::presets;

    fn exposure([gain, digital_gain]: [Decibels; 2]) -> Exposure {
        Exposure { gain, digital_gain, ..Exposure::of(Seconds(0.01)) }
    }

    #[test]
    fn speed_of_a_monochromatic_world_by_hand() {
        // Pixels of 5 µm that count every photon between 370 and 790 nm, 10 000 e⁻ at most. One lx·s of D65 is
        // ∫S·λ/(hc)dλ / (683·∫V·S dλ) photons/m², summed here from the tables of CIE 015, 20 nm apart.
        let table = [
            (380.0, 49.9755),
            (400.0, 82.7549),
            (420.0, 93.4318),
            (440.0, 104.865),
            (460.0, 117.812),
            (480.0, 115.923),
            (500.0, 109.354),
            (520.0, 104.790),
            (540.0, 104.405),
            (560.0, 100.0),
            (580.0, 95.788),
            (600.0, 90.0062),
            (620.0, 87.6987),
            (640.0, 83.6992),
            (660.0, 80.2146),
            (680.0, 78.2842),
            (700.0, 71.6091),
            (720.0, 61.6040),
            (740.0, 75.0870),
            (760.0, 46.4182),
            (780.0, 63.3828),
        ];
        let photopic = [
            (400.0, 0.000396),
            (420.0, 0.004),
            (440.0, 0.023),
            (460.0, 0.06),
            (480.0, 0.13902),
            (500.0, 0.323),
            (520.0, 0.71),
            (540.0, 0.954),
            (560.0, 0.995),
            (580.0, 0.87),
            (600.0, 0.631),
            (620.0, 0.381),
            (640.0, 0.175),
            (660.0, 0.061),
            (680.0, 0.017),
            (700.0, 0.004102),
            (720.0, 0.001047),
        ];
        let photons: f64 = table.iter().map(|(l, s)| s * l * 1e-9 / (6.626_070_15e-34 * 299_792_458.0)).sum();
        let at = |lambda: f64| table.iter().find(|(l, _)| *l == lambda).map_or(0.0, |(_, s)| *s);
        let lumen: f64 = 683.0 * photopic.iter().map(|(l, v)| v * at(*l)).sum::<f64>();
        let by_hand = 78.0 * (25e-12 * photons / lumen) / 10_000.0;

        let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
        sensor.pixel_pitch_m = [5e-6, 5e-6];
        sensor.filter = Spectrum::from_fn(|lambda| if (370.0..790.0).contains(&lambda) { 1.0 } else { 0.0 });
        sensor.quantum_efficiency = vec![Spectrum::constant(1.0)];
        sensor.full_well = Electrons(10_000.0);
        // Sums in steps of 20 nm over a light of narrow features: 1 %.
        let base = sensor.base_iso(Binning::NONE).expect("linear");
        assert!((base / by_hand - 1.0).abs() < 0.01, "{base} for {by_hand}");
    }

    #[test]
    fn gains_give_the_speed_that_is_asked_for() {
        for name in presets::names() {
            let sensor = presets::model(name).expect("listed");
            let base = sensor.base_iso(Binning::NONE).expect("linear");
            assert!(base.is_finite() && base > 0.0, "{name}: {base}");
            for factor in [1.0, 1.01, 2.0, 7.7, 40.0, 100.0] {
                let gains = sensor.gains_for_iso(base * factor, Binning::NONE).expect("above the base speed");
                let [least, most] = sensor.converter.gain_range;
                assert!((least.0..=most.0).contains(&gains[0].0) && gains[1].0 >= 0.0, "{name}: {gains:?}");
                assert!(gains[1].0 == 0.0 || gains[0] == most, "{name}: digital gain before the analogue one ends");
                // Rounding of logarithms and powers, and the inverse of nonlinear amplifiers to 2⁻⁶⁰.
                let found = sensor.iso(&exposure(gains)).expect("linear") / base;
                assert!((found / factor - 1.0).abs() < 1e-9, "{name}: {found} for {factor}");
            }
            for iso in [base.round() - 1.0, f64::NAN] {
                assert!(sensor.gains_for_iso(iso, Binning::NONE).is_err());
            }
        }
    }

    /// Property: a black level that changes with gain, however much, leaves speeds as they are asked for. A step of it
    /// moves the range by 1 of its numbers, of which 95 are left at the least here.
    #[test]
    fn speeds_count_the_black_level_of_their_gain() {
        let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
        let [least, most] = sensor.converter.gain_range;
        for last in [10, 64, 400, 2000, 4000] {
            let step = |gain: Decibels, black| GainStepDescription {
                gain_db: gain.0,
                black_level_dn: Some(black),
                ..GainStepDescription::default()
            };
            sensor.converter.black_level =
                BlackLevelByGain::new(64, 4095, &[step(least, 64), step(most, last)]).expect("valid");
            let base = sensor.base_iso(Binning::NONE).expect("linear");
            for factor in [1.0, 1.5, 4.0, 15.0, 40.0] {
                let gains = sensor.gains_for_iso(base * factor, Binning::NONE).expect("above the base speed");
                let found = sensor.iso(&exposure(gains)).expect("linear") / base;
                let left = f64::from(4095 - sensor.converter.black_level_dn(gains[0]));
                assert!((found / factor - 1.0).abs() < 1.0 / left + 1e-9, "{last}: {found} for {factor}");
            }
        }
    }
}
