//! The physical effects of a sensor by name: [`Stage`]s, which of them take part in an exposure, and the [`NoiseMap`]s
//! of what each has changed.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Declares [`Stage`] by its table: what a stage does, its name and its number.
macro_rules! stages {
    ($($(#[$doc:meta])* $stage:ident = $number:literal,)+) => {
        /// A physical effect between mean electrons and digital numbers that can be left out, in the order of
        /// [`expose`](crate::sensor::expose()). Its number keys its random numbers and is part of what a seed means:
        /// it stays when others come.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
        #[serde(rename_all = "kebab-case")]
        pub enum Stage {
            $($(#[$doc])* $stage = $number,)+
        }

        impl Stage {
            /// All stages, in the order of the chain.
            pub const ALL: [Self; [$($number),+].len()] = [$(Self::$stage),+];
        }
    };
}

stages! {
    /// Electrons that are collected by a neighbour of the pixel that the light fell on.
    Crosstalk = 7,
    /// Light that reaches the columns of a CCD while their charge is on the move.
    Smear = 40,
    /// Pixels that respond a little more or less to light than others (PRNU).
    PhotoResponse = 1,
    /// Pixels that do not see light.
    DeadPixels = 8,
    /// Whole photo-electrons, freed at random.
    ShotNoise = 2,
    /// Thermal electrons, freed at random.
    DarkCurrent = 3,
    /// Pixels with more or less dark current than others.
    DarkCurrentNonuniformity = 9,
    /// Pixels with far more dark current than others.
    HotPixels = 10,
    /// The dead time and the saturation of single-photon counters.
    PhotonCounting = 41,
    /// Boundaries between pixels that move with their charge.
    BrighterFatter = 42,
    /// Charge that overflows into the neighbours along a column.
    Blooming = 43,
    /// The end of what a pixel can hold.
    FullWell = 6,
    /// Charge that stays in the pixel when it is read out, and comes with later frames.
    ImageLag = 47,
    /// Electrons that stay behind when rows are shifted.
    VerticalTransfer = 44,
    /// Electrons that stay behind in the read-out register.
    HorizontalTransfer = 45,
    /// Noise whose power falls with frequency (1/f).
    Flicker = 13,
    /// Noise of resetting the sense node (kTC).
    ResetNoise = 11,
    /// Pixels that jump between two levels.
    Telegraph = 12,
    /// Pixels whose read-out starts from an offset of their own (DSNU).
    DarkOffset = 4,
    /// Noise of the amplifiers.
    ReadNoise = 5,
    /// Noise of the second amplifier of sensors with two gains.
    LowGainReadNoise = 46,
    /// Noise that the pixels of a row share.
    RowNoise = 14,
    /// Noise that the pixels of a column share.
    ColumnNoise = 15,
    /// Amplifiers whose gain depends on the signal.
    AmplifierNonlinearity = 16,
    /// Columns whose amplifiers differ in gain and offset.
    ColumnAmplifiers = 17,
    /// The bandwidth of the line to the converter.
    VideoBandwidth = 48,
    /// Converters whose steps are not of equal width.
    ConverterNonlinearity = 18,
    /// Pixels that always read the same number.
    StuckPixels = 19,
    /// Numbers that arrive as others.
    TransmissionErrors = 20,
}

/// Which stages take part. Leaving one out leaves the random numbers of all others as they were.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stages(u64);

impl Stages {
    /// The real sensor.
    pub const ALL: Self = Self::only(&Stage::ALL);
    /// Nothing but gain and converter.
    pub const NONE: Self = Self(0);

    /// These stages alone.
    pub const fn only(stages: &[Stage]) -> Self {
        let mut set = Self::NONE;
        let mut i = 0;
        while i < stages.len() {
            set = set.with(stages[i]);
            i += 1;
        }
        set
    }

    /// One more stage.
    #[must_use]
    pub const fn with(self, stage: Stage) -> Self {
        Self(self.0 | 1 << stage as u32)
    }

    /// All of these but one.
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
        /// An effect whose part of a picture can be recorded. Its name ends with its unit, but for those that have
        /// none.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
        pub enum NoiseMap {
            $($(#[$doc])* #[serde(rename = $name)] $map,)+
        }

        impl NoiseMap {
            /// All maps, in the order of the chain.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$map),+];

            /// Its name in files, which ends with its unit.
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
    /// What dead pixels do not see, e⁻.
    DeadPixelsE = "dead_pixels_e",
    /// Photon shot noise, e⁻.
    PhotonShotNoiseE = "photon_shot_noise_e",
    /// Of single-photon counters: shot noise, dark counts, what is lost in dead times and what afterpulses add, e⁻.
    PhotonCountingE = "photon_counting_e",
    /// Mean dark current, e⁻.
    DarkCurrentE = "dark_current_e",
    /// Dark current non-uniformity, e⁻.
    DarkCurrentNonuniformityE = "dark_current_nonuniformity_e",
    /// Shot noise of the dark current, e⁻.
    DarkShotNoiseE = "dark_shot_noise_e",
    /// What hot pixels have more, with its shot noise, e⁻.
    HotPixelsE = "hot_pixels_e",
    /// Boundaries between pixels that move with their charge, e⁻.
    BrighterFatterE = "brighter_fatter_e",
    /// Charge that overflows along columns, e⁻.
    BloomingE = "blooming_e",
    /// What does not fit into the full well, e⁻.
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
    /// What the bandwidth of the video line moves to the pixels after, DN.
    VideoBandwidthDn = "video_bandwidth_dn",
    /// What lies beyond the ends of the converter, DN.
    ClippingDn = "clipping_dn",
    /// Steps of the converter that are not of equal width, DN.
    AdcNonlinearityDn = "adc_nonlinearity_dn",
    /// Rounding to whole numbers, DN; with two gains, all that their converters do.
    QuantisationDn = "quantisation_dn",
    /// What stuck pixels read in place of the signal, DN.
    StuckPixelsDn = "stuck_pixels_dn",
    /// Rounding and ends of numbers that are binned and multiplied, DN.
    RoundingDn = "rounding_dn",
    /// Companding, DN.
    CompandingDn = "companding_dn",
    /// Transmission errors, DN.
    TransmissionErrorsDn = "transmission_errors_dn",
    /// The gain map behind `prnu_e`: response over the mean response. It is no part of the sum.
    PrnuGain = "prnu_gain",
    /// 1 where a full well or the end of the converter has cut the signal, 0 elsewhere. It is no part of the sum.
    Saturated = "saturated",
    /// The raw picture without temporal noise, DN: the number that a pixel has on average, before it is rounded. Fixed
    /// patterns, black level and saturation are in it. It is no part of the sum.
    RawClean = "raw_clean",
}

/// What the numbers of a map count.
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
    /// What it counts, as the end of its name says.
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
