//! The figures of an EMVA 1288 data sheet.

use serde::{Deserialize, Serialize};

/// The figures that characterise a sensor at one operating point ([Emva1288](photosite_core::references#emva1288)
/// release 4.0 linear). Those that cannot be known are `None`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// System gain K, DN/e⁻.
    pub system_gain_dn_per_e: f64,
    /// Responsivity R = K·η, DN per photon.
    pub responsivity_dn_per_p: f64,
    /// Quantum efficiency η, electrons per photon that falls on the pixel's whole area, 0–1.
    pub quantum_efficiency: f64,
    /// Temporal dark noise σ_d at no exposure time, without quantisation, e⁻.
    pub dark_noise_e: f64,
    /// Temporal dark noise with quantisation at the output, σ_y.dark, DN.
    pub dark_noise_dn: f64,
    /// Saturation capacity μ_e.sat, e⁻.
    pub saturation_e: f64,
    /// Saturation capacity μ_p.sat, photons.
    pub saturation_p: f64,
    /// Absolute sensitivity threshold μ_p.min, photons: where the signal equals its noise.
    pub sensitivity_threshold_p: f64,
    /// Absolute sensitivity threshold in electrons, μ_e.min.
    pub sensitivity_threshold_e: f64,
    /// Largest signal-to-noise ratio, √μ_e.sat.
    pub snr_max: f64,
    /// Dynamic range μ_p.sat/μ_p.min.
    pub dynamic_range: f64,
    /// Dark signal non-uniformity, e⁻.
    pub dsnu_e: SpatialFigures,
    /// Photo response non-uniformity, percent.
    pub prnu_percent: SpatialFigures,
    /// Smallest (most negative) linearity error, percent.
    pub linearity_error_min_percent: Option<f64>,
    /// Largest linearity error, percent.
    pub linearity_error_max_percent: Option<f64>,
    /// Dark current from the mean, e⁻/s.
    pub dark_current_mean_e_per_s: Option<f64>,
    /// Dark current from the variance, e⁻/s.
    pub dark_current_variance_e_per_s: Option<f64>,
    /// Standard error of the dark current from the mean, e⁻/s.
    #[serde(default)]
    pub dark_current_mean_error_e_per_s: Option<f64>,
    /// Standard error of the dark current from the variance, e⁻/s.
    #[serde(default)]
    pub dark_current_variance_error_e_per_s: Option<f64>,
}

/// A spatial non-uniformity: total² = row² + column² + pixel². A part that the stack's temporal noise hides is `None`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpatialFigures {
    /// Total of all parts.
    pub total: Option<f64>,
    /// Whole rows.
    pub row: Option<f64>,
    /// Whole columns.
    pub column: Option<f64>,
    /// Single pixels.
    pub pixel: Option<f64>,
}

/// One line of a data sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Name of the figure, in words.
    pub name: &'static str,
    /// The standard's symbol.
    pub symbol: &'static str,
    /// Unit, empty for figures without one.
    pub unit: &'static str,
    /// The figure, where it is known.
    pub value: Option<f64>,
    /// Bound below which the absolute value lies at 95 %, where the figure is not told apart from 0.
    pub bound: Option<f64>,
}

impl Row {
    /// Text of the figure, its digits by `number`.
    pub fn cell(&self, number: impl Fn(f64) -> String) -> String {
        match (self.bound, self.value) {
            (Some(bound), _) => format!("not told apart from 0 (< {})", number(bound)),
            (None, Some(value)) => number(value),
            (None, None) => "–".to_owned(),
        }
    }
}

/// Standard errors above 0 from which on a figure is told apart from it.
const TOLD_APART: f64 = 3.0;
/// Standard errors on either side within which a figure lies at 95 %.
const AT_95_PERCENT: f64 = 1.96;

/// Bound below which the absolute value of a figure that cannot be negative lies at 95 %; `None` where its standard
/// error tells it apart from 0.
pub fn bound_at_95_percent(value: f64, error: f64) -> Option<f64> {
    (value <= TOLD_APART * error).then_some(value.abs() + AT_95_PERCENT * error)
}

impl Figures {
    /// Symbols of the dark currents from the mean and from the variance, and what the absolute value of one that is not
    /// told apart from 0 lies below at 95 %, e⁻/s.
    pub fn dark_current_bounds(&self) -> [(&'static str, Option<f64>); 2] {
        let bound = |value: Option<f64>, error| value.zip(error).and_then(|(x, error)| bound_at_95_percent(x, error));
        [
            ("μ_I.mean", bound(self.dark_current_mean_e_per_s, self.dark_current_mean_error_e_per_s)),
            ("μ_I.var", bound(self.dark_current_variance_e_per_s, self.dark_current_variance_error_e_per_s)),
        ]
    }

    /// The data sheet, in the order of the standard.
    pub fn rows(&self) -> Vec<Row> {
        let row = |name, symbol, unit, value: Option<f64>| Row { name, symbol, unit, value, bound: None };
        let some = |name, symbol, unit, value| row(name, symbol, unit, Some(value));
        let [(_, mean), (_, variance)] = self.dark_current_bounds();
        vec![
            some("Quantum efficiency", "η", "%", 100.0 * self.quantum_efficiency),
            some("System gain", "K", "DN/e⁻", self.system_gain_dn_per_e),
            some("Inverse of the system gain", "1/K", "e⁻/DN", 1.0 / self.system_gain_dn_per_e),
            some("Responsivity", "R", "DN/p", self.responsivity_dn_per_p),
            some("Temporal dark noise", "σ_d", "e⁻", self.dark_noise_e),
            some("Temporal dark noise at the output", "σ_y.dark", "DN", self.dark_noise_dn),
            some("Saturation capacity", "μ_e.sat", "e⁻", self.saturation_e),
            some("Saturation capacity", "μ_p.sat", "p", self.saturation_p),
            some("Absolute sensitivity threshold", "μ_p.min", "p", self.sensitivity_threshold_p),
            some("Absolute sensitivity threshold", "μ_e.min", "e⁻", self.sensitivity_threshold_e),
            some("Largest signal-to-noise ratio", "SNR_max", "dB", self.snr_max.db()),
            some("Largest signal-to-noise ratio", "SNR_max", "bit", self.snr_max.bits()),
            some("Dynamic range", "DR", "dB", self.dynamic_range.db()),
            some("Dynamic range", "DR", "bit", self.dynamic_range.bits()),
            row("Dark signal non-uniformity", "DSNU₁₂₈₈", "e⁻", self.dsnu_e.total),
            row("of which rows", "DSNU₁₂₈₈.row", "e⁻", self.dsnu_e.row),
            row("of which columns", "DSNU₁₂₈₈.col", "e⁻", self.dsnu_e.column),
            row("of which pixels", "DSNU₁₂₈₈.pixel", "e⁻", self.dsnu_e.pixel),
            row("Photo response non-uniformity", "PRNU₁₂₈₈", "%", self.prnu_percent.total),
            row("of which rows", "PRNU₁₂₈₈.row", "%", self.prnu_percent.row),
            row("of which columns", "PRNU₁₂₈₈.col", "%", self.prnu_percent.column),
            row("of which pixels", "PRNU₁₂₈₈.pixel", "%", self.prnu_percent.pixel),
            row("Smallest linearity error", "LE_min", "%", self.linearity_error_min_percent),
            row("Largest linearity error", "LE_max", "%", self.linearity_error_max_percent),
            Row {
                bound: mean,
                ..row("Dark current from the mean", "μ_I.mean", "e⁻/s", self.dark_current_mean_e_per_s)
            },
            row("its standard error", "", "e⁻/s", self.dark_current_mean_error_e_per_s),
            Row {
                bound: variance,
                ..row("Dark current from the variance", "μ_I.var", "e⁻/s", self.dark_current_variance_e_per_s)
            },
            row("its standard error", "", "e⁻/s", self.dark_current_variance_error_e_per_s),
        ]
    }
}

/// Ratios of amplitudes as decibels and bits.
pub trait Decibel {
    /// 20·log₁₀ of the ratio.
    fn db(self) -> f64;
    /// log₂ of the ratio.
    fn bits(self) -> f64;
}

impl Decibel for f64 {
    fn db(self) -> f64 {
        20.0 * self.log10()
    }
    fn bits(self) -> f64 {
        self.log2()
    }
}

/// Absolute sensitivity threshold in electrons, at which μ_e² = σ_dark² + μ_e:
///
/// μ_e.min = √(σ_dark² + ¼) + ½
///
/// with the dark noise σ_dark = σ_y.dark/K, quantisation included, in e⁻
/// ([Emva1288](photosite_core::references#emva1288), section on absolute sensitivity threshold; the approximation
/// σ_dark + ½ that some programs use is up to ½ e⁻ too small).
pub(super) fn sensitivity_threshold_e(dark_noise_e: f64) -> f64 {
    (dark_noise_e.powi(2) + 0.25).sqrt() + 0.5
}
