//! `[noise]`: the noise sources of a sensor, as its file states them, and checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_core::units::{Celsius, Electrons, Seconds};

use super::checks::{finite, in_a_million, not_negative, positive};
use super::defective_pixels::DefectivePixels;
use super::defects::{Defects, DefectsDescription};
use super::fixed_pattern::FixedPattern;
use super::flicker::{Flicker, FlickerDescription, FlickerOrder};
use super::gain_steps::{GainStepDescription, ReadOutNoiseByGain, of_all};
use super::measured_pattern::{MeasuredPattern, PatternFile};
use super::reset_noise::{Reset, ResetDescription};
use super::telegraph::{TelegraphDescription, TelegraphSignal};

/// Noise sources, referred to electrons; those that change with gain have gain_steps. What is left out is not there.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseDescription {
    /// Temporal dark noise of the read-out, standard deviation in e⁻.
    #[schemars(transform = within(0.0..))]
    pub read_noise_e: f64,
    /// Gives read noise the heavy tails of Student's t distribution with this number of degrees of freedom, above 2 (few:
    /// heavy); its standard deviation stays. Left out: a normal distribution.
    #[schemars(transform = above(2.0..))]
    pub read_noise_degrees_of_freedom: Option<f64>,
    /// Read noise of each pixel's own: spatial standard deviation of the pixels' standard deviations in percent of
    /// their mean. Pixels follow a log-normal distribution, by the serial number; read_noise_e is the root mean square
    /// over all of them.
    #[schemars(transform = within(0.0..=1000.0))]
    pub read_noise_spread_percent: f64,
    /// Dark current at the reference temperature, mean of all pixels without the hot ones, e⁻/s per pixel.
    #[schemars(transform = within(0.0..))]
    pub dark_current_e_per_s: f64,
    /// Temperature at which the dark current is as stated, that of hot pixels too, °C; needed where there is any.
    #[schemars(transform = above(-273.15..))]
    pub dark_current_reference_c: Option<f64>,
    /// Temperature dependence of the dark current. Left out: "doubling".
    pub dark_current_law: DarkCurrentLawName,
    /// Rise of temperature that doubles the dark current, K; needed where that is the law and there is any.
    #[schemars(transform = above(0.0..))]
    pub dark_current_doubling_k: Option<f64>,
    /// Band gap for the law "arrhenius", eV. Left out: that of silicon, which shrinks with temperature.
    #[schemars(transform = above(0.0..))]
    pub dark_current_band_gap_ev: Option<f64>,
    /// Dark current non-uniformity: spatial standard deviation of the dark current in percent of its mean. Pixels
    /// follow a log-normal distribution.
    #[schemars(transform = within(0.0..))]
    pub dark_current_nonuniformity_percent: f64,
    /// Photo response non-uniformity: spatial standard deviation of the response in percent of its mean.
    #[schemars(transform = within(0.0..))]
    pub prnu_percent: f64,
    /// Part of PRNU that the pixels of a row share, in addition, %.
    #[schemars(transform = within(0.0..))]
    pub prnu_row_percent: f64,
    /// Part of PRNU that the pixels of a column share, in addition, %.
    #[schemars(transform = within(0.0..))]
    pub prnu_column_percent: f64,
    /// Dark signal non-uniformity: spatial standard deviation of the dark signal, e⁻.
    #[schemars(transform = within(0.0..))]
    pub dsnu_e: f64,
    /// Part of DSNU that the pixels of a row share, in addition, e⁻.
    #[schemars(transform = within(0.0..))]
    pub dsnu_row_e: f64,
    /// Part of DSNU that the pixels of a column share, in addition, e⁻.
    #[schemars(transform = within(0.0..))]
    pub dsnu_column_e: f64,
    /// Response of each pixel, measured, in place of the three keys of PRNU: an image of the sensor's columns and rows,
    /// 1 of most. Its mean does not count, as the quantum efficiency has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prnu_map: Option<PatternFile>,
    /// Offset of each pixel's dark signal in e⁻, measured, in place of the three keys of DSNU, at all gains. Its mean does
    /// not count, as the black level has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dsnu_map: Option<PatternFile>,
    /// Temporal noise that the pixels of a row share, standard deviation in e⁻.
    #[schemars(transform = within(0.0..))]
    pub row_noise_e: f64,
    /// Temporal noise that the pixels of a column share, standard deviation in e⁻.
    #[schemars(transform = within(0.0..))]
    pub column_noise_e: f64,
    /// Read noise, row and column noise, DSNU and black level that change with the analogue gain, in place of the figures
    /// here and of adc.black_level_dn: for each of some gains, in their order, gain_db with read_noise_e, row_noise_e,
    /// column_noise_e, dsnu_e, dsnu_row_e, dsnu_column_e or black_level_dn. Between them log σ goes along a straight line
    /// over log K, and the black level along one over K; beyond them the first and the last hold.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gain_steps: Vec<GainStepDescription>,
    /// Noise of resetting the sense node (kTC).
    pub reset: ResetDescription,
    /// Noise whose power falls with frequency (1/f).
    pub flicker: FlickerDescription,
    /// Pixels that jump between two levels (random telegraph signal).
    pub telegraph: TelegraphDescription,
    /// Pixels of a million that arrive as 0 or the largest number, new ones in every image (salt and pepper).
    #[schemars(transform = within(0.0..=1e6))]
    pub transmission_errors_per_million: f64,
}

/// Noise sources, referred to electrons.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Noise of the read-out at each gain: read noise, row and column noise, DSNU.
    pub read_out: ReadOutNoiseByGain,
    /// Degrees of freedom of a read noise that follows Student's t distribution, above 2; `None` for a normal one.
    pub read_degrees_of_freedom: Option<f64>,
    /// Spatial standard deviation of the pixels' read noise over its mean (a ratio), log-normal; the read noise is the root
    /// mean square over all pixels.
    pub read_spread: f64,
    /// Dark current at the reference temperature, e⁻/s.
    pub dark_current_e_per_s: f64,
    /// Reference temperature of the dark current.
    pub dark_current_reference: Celsius,
    /// Dependence of the dark current on temperature.
    pub dark_current_law: DarkCurrentLaw,
    /// Spatial standard deviation of the dark current over its mean (DCNU, a ratio), log-normal.
    pub dark_current_nonuniformity: f64,
    /// Photo response over its mean (PRNU, a ratio: 0.01 is 1 %).
    pub prnu: FixedPattern,
    /// Deviations of the pixels' responses from their mean, measured (ratios); their standard deviation is `prnu`.
    pub prnu_map: Option<MeasuredPattern>,
    /// Deviations of the dark signal from its mean, measured, e⁻; their standard deviation is DSNU.
    pub dsnu_map: Option<MeasuredPattern>,
    /// Reset of the sense node.
    pub reset: Reset,
    /// 1/f noise.
    pub flicker: Flicker,
    /// Random telegraph signals.
    pub telegraph: TelegraphSignal,
    /// Part of the pixels that arrive as another number, 0–1.
    pub transmission_errors: f64,
    /// Defective pixels.
    pub defects: Defects,
    /// Defective pixels by their places; their parts of all are those of `defects`.
    pub defective_pixels: Option<DefectivePixels>,
}

/// Temperature dependence of the dark current.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum DarkCurrentLawName {
    /// Doubling every dark_current_doubling_k kelvin.
    #[default]
    Doubling,
    /// Arrhenius' law of thermal generation across the band gap, in proportion to T^(3/2)·exp(−E_g/(2kT)).
    Arrhenius,
}

/// Dependence of the dark current on temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DarkCurrentLaw {
    /// Doubling with every rise of `interval_k` kelvin.
    Doubling {
        /// Doubling interval, K.
        interval_k: f64,
    },
    /// Thermal generation across a band gap.
    Arrhenius {
        /// Band gap, eV; `None` for that of silicon.
        band_gap_ev: Option<f64>,
    },
}

impl Noise {
    /// Noise of a sensor that has none but that of light itself.
    pub const NONE: Self = Self {
        read_out: ReadOutNoiseByGain::NONE,
        read_degrees_of_freedom: None,
        read_spread: 0.0,
        dark_current_e_per_s: 0.0,
        dark_current_reference: Celsius(25.0),
        dark_current_law: DarkCurrentLaw::Doubling { interval_k: 8.0 },
        dark_current_nonuniformity: 0.0,
        prnu: FixedPattern::of_pixels(0.0),
        prnu_map: None,
        dsnu_map: None,
        reset: Reset::Cancelled,
        flicker: Flicker { noise: Electrons(0.0), exponent: 1.0, order: FlickerOrder::ColumnParallel },
        telegraph: TelegraphSignal { pixels: 0.0, amplitude: Electrons(0.0), high: Seconds(1.0), low: Seconds(1.0) },
        transmission_errors: 0.0,
        defects: Defects { hot: 0.0, hot_dark_current_e_per_s: 0.0, dead: 0.0, stuck: 0.0 },
        defective_pixels: None,
    };

    /// Keys of errors are those of the sensor file, tables included.
    pub(super) fn new(d: &NoiseDescription, defects: &DefectsDescription) -> Result<Self, Invalid> {
        Ok(Self {
            defects: Defects::new(defects).map_err(|e| e.within("defects"))?,
            ..Self::without_defects(d, defects).map_err(|e| e.within("noise"))?
        })
    }

    fn without_defects(d: &NoiseDescription, defects: &DefectsDescription) -> Result<Self, Invalid> {
        let hot_pixels = defects.hot_per_million != 0.0 && defects.hot_dark_current_e_per_s != 0.0;
        let has_dark_current = d.dark_current_e_per_s != 0.0 || hot_pixels;
        let reference = reference(d.dark_current_reference_c, has_dark_current)?;
        if let Some(freedom) = d.read_noise_degrees_of_freedom.filter(|&n| !(n > 2.0 && n.is_finite())) {
            return Err(Invalid::new("read_noise_degrees_of_freedom", format!("must be above 2, got {freedom}"))
                .help("at 2 and below the distribution has no standard deviation; 3 to 10 give heavy tails"));
        }
        let dsnu = FixedPattern {
            pixel: not_negative("dsnu_e", d.dsnu_e)?,
            row: not_negative("dsnu_row_e", d.dsnu_row_e)?,
            column: not_negative("dsnu_column_e", d.dsnu_column_e)?,
        };
        let at_all_gains = of_all([d.read_noise_e, d.row_noise_e, d.column_noise_e], dsnu)?;
        Ok(Self {
            read_out: ReadOutNoiseByGain::new(at_all_gains, &d.gain_steps)?,
            read_degrees_of_freedom: d.read_noise_degrees_of_freedom,
            read_spread: read_spread(d.read_noise_spread_percent)?,
            dark_current_e_per_s: not_negative("dark_current_e_per_s", d.dark_current_e_per_s)?,
            dark_current_reference: reference,
            dark_current_law: DarkCurrentLaw::new(d, has_dark_current)?,
            dark_current_nonuniformity: ratio(
                "dark_current_nonuniformity_percent",
                d.dark_current_nonuniformity_percent,
            )?,
            prnu: FixedPattern {
                pixel: ratio("prnu_percent", d.prnu_percent)?,
                row: ratio("prnu_row_percent", d.prnu_row_percent)?,
                column: ratio("prnu_column_percent", d.prnu_column_percent)?,
            },
            prnu_map: None,
            dsnu_map: None,
            reset: Reset::new(&d.reset).map_err(|e| e.within("reset"))?,
            flicker: Flicker::new(&d.flicker).map_err(|e| e.within("flicker"))?,
            telegraph: TelegraphSignal::new(&d.telegraph).map_err(|e| e.within("telegraph"))?,
            transmission_errors: in_a_million("transmission_errors_per_million", d.transmission_errors_per_million)?,
            defects: Defects::default(),
            defective_pixels: None,
        })
    }
}

/// Refuses a dark current, such as that of hot pixels, whose dependence on temperature is not stated.
pub(super) fn needs_dark_current(d: &NoiseDescription) -> Result<(), Invalid> {
    reference(d.dark_current_reference_c, true)?;
    DarkCurrentLaw::new(d, true).map(drop)
}

/// The temperature of the dark current; without any, it makes no difference.
fn reference(stated_c: Option<f64>, has_dark_current: bool) -> Result<Celsius, Invalid> {
    const KEY: &str = "dark_current_reference_c";
    let refuse = |message: String| Err(Invalid::new(KEY, message).help("for example dark_current_reference_c = 25.0"));
    match stated_c {
        Some(celsius) if finite(KEY, celsius)? <= -photosite_core::units::ZERO_CELSIUS => {
            refuse(format!("{celsius} °C lies below absolute zero"))
        }
        Some(celsius) => Ok(Celsius(celsius)),
        None if has_dark_current => refuse("is missing, although there is dark current".to_owned()),
        None => Ok(Noise::NONE.dark_current_reference),
    }
}

impl DarkCurrentLaw {
    fn new(d: &NoiseDescription, has_dark_current: bool) -> Result<Self, Invalid> {
        let [doubling, band_gap] = [
            ("dark_current_doubling_k", d.dark_current_doubling_k, "8.0"),
            ("dark_current_band_gap_ev", d.dark_current_band_gap_ev, "1.12"),
        ]
        .map(|(key, value, example)| value.map(|value| positive(key, value, example)).transpose());
        match d.dark_current_law {
            DarkCurrentLawName::Doubling => match doubling? {
                Some(interval_k) => Ok(Self::Doubling { interval_k }),
                None if !has_dark_current => Ok(Noise::NONE.dark_current_law),
                None => Err(Invalid::new("dark_current_doubling_k", "is missing")
                    .help("for example dark_current_doubling_k = 8.0, or dark_current_law = \"arrhenius\"")),
            },
            DarkCurrentLawName::Arrhenius => Ok(Self::Arrhenius { band_gap_ev: band_gap? }),
        }
    }
}

/// A spread of more than ten times the mean is a slip of the pen, and its rare pixels would hold all of the noise.
fn read_spread(percent: f64) -> Result<f64, Invalid> {
    if (0.0..=1000.0).contains(&percent) {
        return Ok(percent / 100.0);
    }
    Err(Invalid::new("read_noise_spread_percent", format!("must lie from 0 to 1000, got {percent}"))
        .help("write 0 where all pixels have the same read noise"))
}

fn ratio(key: &str, percent: f64) -> Result<f64, Invalid> {
    not_negative(key, percent).map(|percent| percent / 100.0)
}
