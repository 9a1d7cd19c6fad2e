//! The effects whose part of a picture can be told, by name.

use schemars::JsonSchema;
use serde::Deserialize;

/// Declares [`NoiseMap`] by its table: what a map holds, and its name in files, which ends with its unit.
macro_rules! noise_maps {
    ($($(#[$doc:meta])* $map:ident = $name:literal,)+) => {
        /// An effect whose part of a picture can be told. Its name ends with its unit, but for those that have none.
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
    /// The bend of logarithmic pixels, e⁻.
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
    /// The bend of the amplifiers, e⁻.
    AmplifierNonlinearityE = "amplifier_nonlinearity_e",
    /// Read noise, e⁻; with two gains, that of the amplifier that counts.
    ReadNoiseE = "read_noise_e",
    /// Gains and offsets of column amplifiers, DN.
    ColumnAmplifiersDn = "column_amplifiers_dn",
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
