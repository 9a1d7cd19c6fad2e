//! The physical effects of a sensor by name: [`Stage`]s, which of them take part in an exposure, and the [`NoiseMap`]s
//! of what each has changed.

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declares [`Stage`] by its table: what a stage does, its name, its number and the map that records what it changes.
macro_rules! stages {
    ($($(#[$doc:meta])* $stage:ident = $number:literal => $map:ident,)+) => {
        /// A physical effect between mean electrons and digital numbers that can be left out, in the order of
        /// [`expose`](crate::expose()). Its number keys its random numbers and is part of what a seed means:
        /// it stays when others come.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
        #[serde(rename_all = "kebab-case")]
        pub enum Stage {
            $($(#[$doc])* $stage = $number,)+
        }

        impl Stage {
            /// All stages, in the order of the chain.
            pub const ALL: [Self; [$($number),+].len()] = [$(Self::$stage),+];

            /// Noise map that records the stage's change.
            pub const fn map(self) -> NoiseMap {
                match self {
                    $(Self::$stage => NoiseMap::$map,)+
                }
            }
        }
    };
}

stages! {
    /// Electrons that are collected by a neighbour of the pixel that the light fell on.
    Crosstalk = 7 => CrosstalkE,
    /// Light that reaches the columns of a CCD while their charge is on the move.
    Smear = 40 => SmearE,
    /// Pixels that respond a little more or less to light than others (PRNU).
    PhotoResponse = 1 => PrnuE,
    /// Pixels that do not see light.
    DeadPixels = 8 => DeadPixelsE,
    /// Whole photo-electrons, freed at random.
    ShotNoise = 2 => PhotonShotNoiseE,
    /// Thermal electrons, freed at random.
    DarkCurrent = 3 => DarkShotNoiseE,
    /// Pixels with more or less dark current than others.
    DarkCurrentNonuniformity = 9 => DarkCurrentNonuniformityE,
    /// Pixels with far more dark current than others.
    HotPixels = 10 => HotPixelsE,
    /// The dead time and the saturation of single-photon counters.
    PhotonCounting = 41 => PhotonCountingE,
    /// Boundaries between pixels that move with their charge.
    BrighterFatter = 42 => BrighterFatterE,
    /// Charge that overflows into the neighbours along a column.
    Blooming = 43 => BloomingE,
    /// The end of what a pixel can hold.
    FullWell = 6 => FullWellE,
    /// Charge that stays in the pixel when it is read out, and comes with later frames.
    ImageLag = 47 => ImageLagE,
    /// Electrons that stay behind when rows are shifted.
    VerticalTransfer = 44 => ChargeTransferE,
    /// Electrons that stay behind in the read-out register.
    HorizontalTransfer = 45 => ChargeTransferE,
    /// Noise whose power falls with frequency (1/f).
    Flicker = 13 => FlickerNoiseE,
    /// Noise of resetting the sense node (kTC).
    ResetNoise = 11 => ResetNoiseE,
    /// Pixels that jump between two levels.
    Telegraph = 12 => TelegraphNoiseE,
    /// Pixels whose read-out starts from an offset of their own (DSNU).
    DarkOffset = 4 => DsnuE,
    /// Noise of the amplifiers.
    ReadNoise = 5 => ReadNoiseE,
    /// Noise of the second amplifier of sensors with two gains.
    LowGainReadNoise = 46 => ReadNoiseE,
    /// Noise that the pixels of a row share.
    RowNoise = 14 => RowNoiseE,
    /// Noise that the pixels of a column share.
    ColumnNoise = 15 => ColumnNoiseE,
    /// Amplifiers whose gain depends on the signal.
    AmplifierNonlinearity = 16 => AmplifierNonlinearityE,
    /// Columns whose amplifiers differ in gain and offset.
    ColumnAmplifiers = 17 => ColumnAmplifiersDn,
    /// The bandwidth of the line to the converter.
    VideoBandwidth = 48 => VideoBandwidthDn,
    /// Converters whose steps are not of equal width.
    ConverterNonlinearity = 18 => AdcNonlinearityDn,
    /// Pixels that always read the same number.
    StuckPixels = 19 => StuckPixelsDn,
    /// Errors of transmission: digital numbers that arrive as others.
    TransmissionErrors = 20 => TransmissionErrorsDn,
}

/// Set of stages that take part. Leaving one out leaves the random numbers of all others as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stages(u64);

impl Stages {
    /// The real sensor.
    pub const ALL: Self = Self::only(&Stage::ALL);
    /// Set without any stage but gain and converter.
    pub const NONE: Self = Self(0);

    /// Set of these stages alone.
    pub const fn only(stages: &[Stage]) -> Self {
        let mut set = Self::NONE;
        let mut i = 0;
        while i < stages.len() {
            set = set.with(stages[i]);
            i += 1;
        }
        set
    }

    /// Adds a stage to the set.
    #[must_use]
    pub const fn with(self, stage: Stage) -> Self {
        Self(self.0 | 1 << stage as u32)
    }

    /// Removes a stage from the set.
    #[must_use]
    pub const fn without(self, stage: Stage) -> Self {
        Self(self.0 & !(1 << stage as u32))
    }

    /// Whether a stage takes part.
    pub const fn has(self, stage: Stage) -> bool {
        self.0 & 1 << stage as u32 != 0
    }
}

impl Default for Stages {
    fn default() -> Self {
        Self::ALL
    }
}

/// Declares [`NoiseMap`] by its table: what a map holds, and its name in files, which ends with its unit.
macro_rules! noise_maps {
    ($($(#[$doc:meta])* $map:ident = $name:literal,)+) => {
        /// An effect whose part of an image can be recorded. Its name ends with its unit, but for those that have
        /// none.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
        pub enum NoiseMap {
            $($(#[$doc])* #[serde(rename = $name)] $map,)+
        }

        impl NoiseMap {
            /// All maps, in the order of the chain.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$map),+];

            /// Name of the map in files, which ends with its unit.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$map => $name,)+
                }
            }
        }
    };
}

noise_maps! {
    /// The noise-free mean photo-electrons of the pixel: what the others are added to, e⁻.
    PhotoElectronsE = "photo_electrons_e",
    /// Electrons that neighbours collect, e⁻.
    CrosstalkE = "crosstalk_e",
    /// Light that reaches charge on the move, e⁻.
    SmearE = "smear_e",
    /// Photo response non-uniformity, e⁻.
    PrnuE = "prnu_e",
    /// Signal that dead pixels miss, e⁻.
    DeadPixelsE = "dead_pixels_e",
    /// Photon shot noise, e⁻.
    PhotonShotNoiseE = "photon_shot_noise_e",
    /// Noise of single-photon counters: shot noise, dark counts, losses in dead times and additions of afterpulses, e⁻.
    PhotonCountingE = "photon_counting_e",
    /// Mean dark current, e⁻.
    DarkCurrentE = "dark_current_e",
    /// Dark current non-uniformity, e⁻.
    DarkCurrentNonuniformityE = "dark_current_nonuniformity_e",
    /// Shot noise of the dark current, e⁻.
    DarkShotNoiseE = "dark_shot_noise_e",
    /// Dark current of hot pixels beyond that of the others, with its shot noise, e⁻.
    HotPixelsE = "hot_pixels_e",
    /// Boundaries between pixels that move with their charge, e⁻.
    BrighterFatterE = "brighter_fatter_e",
    /// Charge that overflows along columns, e⁻.
    BloomingE = "blooming_e",
    /// Charge that does not fit into the full well, e⁻.
    FullWellE = "full_well_e",
    /// Nonlinearity of logarithmic pixels, e⁻.
    LogarithmicResponseE = "logarithmic_response_e",
    /// Image lag: charge of earlier frames less what stays in the pixel of this one, e⁻.
    ImageLagE = "image_lag_e",
    /// Charge that stays behind, or arrives late, when it is shifted, e⁻.
    ChargeTransferE = "charge_transfer_e",
    /// 1/f noise, e⁻.
    FlickerNoiseE = "flicker_noise_e",
    /// Reset noise (kTC), e⁻.
    ResetNoiseE = "reset_noise_e",
    /// Random telegraph noise, e⁻.
    TelegraphNoiseE = "telegraph_noise_e",
    /// Dark signal non-uniformity of the read-out, e⁻.
    DsnuE = "dsnu_e",
    /// Noise that rows share, e⁻.
    RowNoiseE = "row_noise_e",
    /// Noise that columns share, e⁻.
    ColumnNoiseE = "column_noise_e",
    /// Nonlinearity of the amplifiers, e⁻.
    AmplifierNonlinearityE = "amplifier_nonlinearity_e",
    /// Read noise, e⁻; with two gains, that of the amplifier that counts.
    ReadNoiseE = "read_noise_e",
    /// Gains and offsets of column amplifiers, DN.
    ColumnAmplifiersDn = "column_amplifiers_dn",
    /// Curve of the video amplifier, DN.
    VideoCurveDn = "video_curve_dn",
    /// Signal that the bandwidth of the video line moves to the pixels after, DN.
    VideoBandwidthDn = "video_bandwidth_dn",
    /// Signal beyond the ends of the converter's range, DN.
    ClippingDn = "clipping_dn",
    /// Steps of the converter that are not of equal width, DN.
    AdcNonlinearityDn = "adc_nonlinearity_dn",
    /// Rounding to whole numbers, DN; with two gains, all that their converters do.
    QuantisationDn = "quantisation_dn",
    /// Difference between the values of stuck pixels and the signal in their place, DN.
    StuckPixelsDn = "stuck_pixels_dn",
    /// Rounding and clipping of digital numbers that are binned and multiplied, DN.
    RoundingDn = "rounding_dn",
    /// Companding, DN.
    CompandingDn = "companding_dn",
    /// Transmission errors, DN.
    TransmissionErrorsDn = "transmission_errors_dn",
    /// The gain map behind `prnu_e`: response over the mean response. It is no part of the sum.
    PrnuGain = "prnu_gain",
    /// 1 where a full well or the end of the converter has cut the signal, 0 elsewhere. It is no part of the sum.
    Saturated = "saturated",
    /// The raw image without temporal noise, DN: the number that a pixel has on average, before it is rounded. Fixed
    /// patterns, black level and saturation are in it. It is no part of the sum.
    RawClean = "raw_clean",
}

/// Unit of a noise map's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapUnit {
    /// Electrons: K of them are a digital number.
    Electrons,
    /// Digital numbers.
    DigitalNumbers,
    /// Neither; the map is no part of the sum.
    None,
}

impl NoiseMap {
    /// Unit of the map's values, as the end of its name says.
    pub fn unit(self) -> MapUnit {
        match self.name().rsplit_once('_') {
            Some((_, "e")) => MapUnit::Electrons,
            Some((_, "dn")) => MapUnit::DigitalNumbers,
            Some(_) | None => MapUnit::None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_has_a_number_and_a_name_of_its_own() {
        for (i, a) in Stage::ALL.into_iter().enumerate() {
            assert!((a as u32) < u64::BITS);
            for b in Stage::ALL.into_iter().skip(i + 1) {
                assert_ne!(a as u32, b as u32, "{a:?} {b:?}");
            }
            assert!(!Stages::ALL.without(a).has(a) && Stages::NONE.with(a).has(a) && Stages::ALL.has(a));
            assert_eq!(Stages::ALL.without(a).with(a), Stages::ALL);
        }
    }
}
