//! The noise sources of a sensor.

use crate::sensor::description::{
    DarkCurrentLawName, DefectsDescription, FlickerDescription, FlickerOrder, NoiseDescription, ResetDescription,
    TelegraphDescription,
};
use photosite_core::Invalid;
use photosite_core::units::{Celsius, Electrons, Seconds};

use super::checks::{finite, in_a_million, not_negative, positive};

/// Noise sources, referred to electrons.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the read noise.
    pub read: Electrons,
    /// Degrees of freedom of a read noise that follows Student's t distribution, above 2; `None` for a normal one.
    pub read_degrees_of_freedom: Option<f64>,
    /// Dark current at the reference temperature, e⁻/s.
    pub dark_current_e_per_s: f64,
    /// Reference temperature of the dark current.
    pub dark_current_reference: Celsius,
    /// How the dark current depends on temperature.
    pub dark_current_law: DarkCurrentLaw,
    /// Spatial standard deviation of the dark current over its mean (DCNU, a ratio), log-normal.
    pub dark_current_nonuniformity: f64,
    /// Photo response over its mean (PRNU, a ratio: 0.01 is 1 %).
    pub prnu: FixedPattern,
    /// Dark signal (DSNU), e⁻.
    pub dsnu: FixedPattern,
    /// Standard deviation of temporal noise that a row shares.
    pub row: Electrons,
    /// Standard deviation of temporal noise that a column shares.
    pub column: Electrons,
    /// Reset of the sense node.
    pub reset: ResetNoise,
    /// 1/f noise.
    pub flicker: Flicker,
    /// Random telegraph signals.
    pub telegraph: Telegraph,
    /// Part of the pixels that arrive as another number, 0–1.
    pub transmission_errors: f64,
    /// Pixels that do not work as the others.
    pub defects: Defects,
}

/// How the dark current depends on temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DarkCurrentLaw {
    /// It doubles with every rise of `interval_k` kelvin.
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

/// Spatial standard deviations of a pattern that is the same in every picture, in a unit of its own. Its parts are
/// independent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FixedPattern {
    /// What each pixel has to itself.
    pub pixel: f64,
    /// What the pixels of a row share.
    pub row: f64,
    /// What the pixels of a column share.
    pub column: f64,
}

impl FixedPattern {
    /// A pattern without rows and columns.
    pub const fn of_pixels(pixel: f64) -> Self {
        Self { pixel, row: 0.0, column: 0.0 }
    }

    /// Standard deviation of the whole pattern, √(pixel² + row² + column²).
    pub fn total(&self) -> f64 {
        (self.pixel * self.pixel + self.row * self.row + self.column * self.column).sqrt()
    }
}

/// Reset of the sense node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ResetNoise {
    /// Subtracted by correlated double sampling, or too small to matter.
    Cancelled,
    /// A standard deviation.
    Fixed(Electrons),
    /// That of a capacitance, F, at the sensor's temperature.
    Capacitance(f64),
}

/// 1/f noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flicker {
    /// Standard deviation of all frequencies together.
    pub noise: Electrons,
    /// The power falls as 1/f^exponent; above 0 up to 2.
    pub exponent: f64,
    /// Which samples follow each other.
    pub order: FlickerOrder,
}

/// Random telegraph signals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Telegraph {
    /// Part of the pixels that have one, 0–1.
    pub pixels: f64,
    /// Mean distance of the two levels; pixels follow an exponential distribution.
    pub amplitude: Electrons,
    /// Mean time on the high level.
    pub high: Seconds,
    /// Mean time on the low level.
    pub low: Seconds,
}

impl Telegraph {
    /// Part of the time on the high level.
    pub fn duty(&self) -> f64 {
        self.high.0 / (self.high.0 + self.low.0)
    }

    /// Variance of all pixels, (e⁻)²: a part of them has A²·d·(1 − d) with the duty d, and the mean square of an
    /// exponential distribution is twice the square of its mean.
    pub fn variance(&self) -> f64 {
        self.pixels * 2.0 * self.amplitude.0.powi(2) * self.duty() * (1.0 - self.duty())
    }
}

/// Pixels that do not work as the others, as parts of all, 0–1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Defects {
    /// Those with more dark current.
    pub hot: f64,
    /// The mean of what those have more at the reference temperature, e⁻/s, exponentially distributed.
    pub hot_dark_current_e_per_s: f64,
    /// Those that do not see light.
    pub dead: f64,
    /// Those that always read the same number.
    pub stuck: f64,
}

impl Noise {
    /// No noise but that of light itself.
    pub const NONE: Self = Self {
        read: Electrons(0.0),
        read_degrees_of_freedom: None,
        dark_current_e_per_s: 0.0,
        dark_current_reference: Celsius(25.0),
        dark_current_law: DarkCurrentLaw::Doubling { interval_k: 8.0 },
        dark_current_nonuniformity: 0.0,
        prnu: FixedPattern::of_pixels(0.0),
        dsnu: FixedPattern::of_pixels(0.0),
        row: Electrons(0.0),
        column: Electrons(0.0),
        reset: ResetNoise::Cancelled,
        flicker: Flicker { noise: Electrons(0.0), exponent: 1.0, order: FlickerOrder::ColumnParallel },
        telegraph: Telegraph { pixels: 0.0, amplitude: Electrons(0.0), high: Seconds(1.0), low: Seconds(1.0) },
        transmission_errors: 0.0,
        defects: Defects { hot: 0.0, hot_dark_current_e_per_s: 0.0, dead: 0.0, stuck: 0.0 },
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
        Ok(Self {
            read: electrons("read_noise_e", d.read_noise_e)?,
            read_degrees_of_freedom: d.read_noise_degrees_of_freedom,
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
            dsnu: FixedPattern {
                pixel: not_negative("dsnu_e", d.dsnu_e)?,
                row: not_negative("dsnu_row_e", d.dsnu_row_e)?,
                column: not_negative("dsnu_column_e", d.dsnu_column_e)?,
            },
            row: electrons("row_noise_e", d.row_noise_e)?,
            column: electrons("column_noise_e", d.column_noise_e)?,
            reset: ResetNoise::new(&d.reset).map_err(|e| e.within("reset"))?,
            flicker: Flicker::new(&d.flicker).map_err(|e| e.within("flicker"))?,
            telegraph: Telegraph::new(&d.telegraph).map_err(|e| e.within("telegraph"))?,
            transmission_errors: in_a_million("transmission_errors_per_million", d.transmission_errors_per_million)?,
            defects: Defects::default(),
        })
    }
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
        None if has_dark_current => refuse("is missing, and there is dark current".to_owned()),
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

impl ResetNoise {
    fn new(d: &ResetDescription) -> Result<Self, Invalid> {
        let noise = match (d.noise_e, d.capacitance_ff) {
            (Some(_), Some(_)) => {
                return Err(Invalid::new("capacitance_ff", "cannot go with noise_e").help("keep one of them"));
            }
            (Some(noise), None) => Self::Fixed(electrons("noise_e", noise)?),
            (None, Some(capacitance)) => Self::Capacitance(not_negative("capacitance_ff", capacitance)? * 1e-15),
            (None, None) => Self::Cancelled,
        };
        Ok(if d.correlated_double_sampling { Self::Cancelled } else { noise })
    }
}

impl Flicker {
    fn new(d: &FlickerDescription) -> Result<Self, Invalid> {
        if !(d.exponent > 0.0 && d.exponent <= 2.0) {
            return Err(Invalid::new("exponent", format!("must lie above 0 and up to 2, got {}", d.exponent))
                .help("for example exponent = 1.0"));
        }
        Ok(Self { noise: electrons("noise_e", d.noise_e)?, exponent: d.exponent, order: d.order })
    }
}

impl Telegraph {
    fn new(d: &TelegraphDescription) -> Result<Self, Invalid> {
        Ok(Self {
            pixels: in_a_million("pixels_per_million", d.pixels_per_million)?,
            amplitude: electrons("amplitude_e", d.amplitude_e)?,
            high: Seconds(positive("high_s", d.high_s, "0.5")?),
            low: Seconds(positive("low_s", d.low_s, "0.5")?),
        })
    }
}

impl Defects {
    fn new(d: &DefectsDescription) -> Result<Self, Invalid> {
        Ok(Self {
            hot: in_a_million("hot_per_million", d.hot_per_million)?,
            hot_dark_current_e_per_s: not_negative("hot_dark_current_e_per_s", d.hot_dark_current_e_per_s)?,
            dead: in_a_million("dead_per_million", d.dead_per_million)?,
            stuck: in_a_million("stuck_per_million", d.stuck_per_million)?,
        })
    }
}

fn electrons(key: &str, value: f64) -> Result<Electrons, Invalid> {
    not_negative(key, value).map(Electrons)
}

fn ratio(key: &str, percent: f64) -> Result<f64, Invalid> {
    not_negative(key, percent).map(|percent| percent / 100.0)
}
