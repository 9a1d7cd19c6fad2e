//! Physical effects that a sensor has: those whose figures are not zero.

use photosite_core::units::Electrons;

use super::architecture::Architecture;
use super::reset_noise::Reset;
use super::sensor_model::SensorModel;
use crate::signal::effects::{NoiseMap, Stage};

impl SensorModel {
    /// Whether a stage can change a number of this sensor: to leave out any other makes no difference.
    pub fn has_stage(&self, stage: Stage) -> bool {
        let (noise, converter) = (&self.noise, &self.converter);
        let dual_gain = converter.dual_gain.as_deref();
        let ccd = self.architecture.ccd();
        let is_noisy = |noise: Electrons| noise.0 > 0.0;
        let read_out = noise.read_out.largest();
        match stage {
            Stage::ShotNoise | Stage::FullWell => true,
            Stage::Crosstalk => self.crosstalk.is_some(),
            Stage::Smear => ccd.is_some_and(|ccd| ccd.smear_row_time.0 > 0.0),
            Stage::PhotoResponse => noise.prnu.total() > 0.0,
            Stage::DeadPixels => noise.defects.dead > 0.0,
            Stage::DarkCurrent => noise.dark_current_e_per_s > 0.0,
            Stage::DarkCurrentNonuniformity => {
                noise.dark_current_e_per_s > 0.0 && noise.dark_current_nonuniformity > 0.0
            }
            Stage::HotPixels => noise.defects.hot > 0.0 && noise.defects.hot_dark_current_e_per_s > 0.0,
            Stage::PhotonCounting => matches!(self.architecture, Architecture::Spad(_)),
            Stage::BrighterFatter => self.brighter_fatter_per_e != [0.0; 2],
            Stage::Blooming => ccd.is_some(),
            Stage::ImageLag => self.image_lag.is_some(),
            Stage::VerticalTransfer => ccd.is_some_and(|ccd| ccd.vertical_inefficiency > 0.0),
            Stage::HorizontalTransfer => ccd.is_some_and(|ccd| ccd.horizontal_inefficiency > 0.0),
            Stage::Flicker => is_noisy(noise.flicker.noise),
            Stage::ResetNoise => match noise.reset {
                Reset::Cancelled => false,
                Reset::Fixed(noise) => is_noisy(noise),
                Reset::Capacitance(farad) => farad > 0.0,
            },
            Stage::Telegraph => noise.telegraph.pixels > 0.0 && is_noisy(noise.telegraph.amplitude),
            Stage::DarkOffset => read_out.dsnu.total() > 0.0,
            Stage::ReadNoise => is_noisy(read_out.read),
            Stage::LowGainReadNoise => dual_gain.is_some_and(|dual| is_noisy(dual.low_read_noise)),
            Stage::RowNoise => is_noisy(read_out.row),
            Stage::ColumnNoise => is_noisy(read_out.column),
            Stage::AmplifierNonlinearity => !converter.amplifier_nonlinearity.is_empty(),
            Stage::ColumnAmplifiers => {
                dual_gain.is_none() && (converter.column_gain > 0.0 || converter.column_offset_dn > 0.0)
            }
            Stage::VideoBandwidth => self.video.low_pass.is_some(),
            Stage::ConverterNonlinearity => {
                let converters = dual_gain.map_or([converter; 2], |dual| [&dual.high, &dual.low]);
                converters.iter().any(|converter| converter.inl_dn != 0.0 || converter.dnl_dn != 0.0)
            }
            Stage::StuckPixels => noise.defects.stuck > 0.0,
            Stage::TransmissionErrors => noise.transmission_errors > 0.0,
        }
    }

    /// Whether a noise map of this sensor can hold anything: all others are the same in every pixel.
    pub fn has_map(&self, map: NoiseMap) -> bool {
        const ALWAYS: [NoiseMap; 6] = [
            NoiseMap::PhotoElectronsE,
            NoiseMap::ClippingDn,
            NoiseMap::QuantisationDn,
            NoiseMap::RoundingDn,
            NoiseMap::RawClean,
            NoiseMap::Saturated,
        ];
        // What is recorded beside the maps of stages, and beyond them.
        let others = [
            (NoiseMap::DarkCurrentE, self.has_stage(Stage::DarkCurrent)),
            (NoiseMap::PrnuGain, self.has_stage(Stage::PhotoResponse)),
            (NoiseMap::LogarithmicResponseE, self.logarithmic.is_some()),
            (NoiseMap::ChargeTransferE, self.architecture.ccd().is_some()),
            (NoiseMap::VideoCurveDn, self.video.curve.is_some()),
            (NoiseMap::CompandingDn, self.converter.companding.is_some()),
        ];
        // With two gains the map of quantisation has what converters do.
        let is_hidden = map == NoiseMap::AdcNonlinearityDn && self.converter.dual_gain.is_some();
        let of_stage = Stage::ALL.into_iter().any(|stage| stage.map() == map && self.has_stage(stage));
        ALWAYS.contains(&map) || others.contains(&(map, true)) || (of_stage && !is_hidden)
    }
}
