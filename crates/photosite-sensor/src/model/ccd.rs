//! `[ccd]`: how a CCD moves its charge, as a sensor file states it, and checked in SI units.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};
use photosite_core::units::Seconds;

use super::checks::{fraction_below_one, margin, not_negative, positive};

/// Charge transfer of a CCD.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields, default)]
pub struct CcdDescription {
    /// Architecture: where charge goes when the exposure ends.
    pub architecture: CcdArchitecture,
    /// Charge-transfer inefficiency along a column: the part of a packet that stays behind at each shift.
    #[schemars(transform = within(0.0..1.0))]
    pub vertical_cti: f64,
    /// Charge-transfer inefficiency along the read-out register.
    #[schemars(transform = within(0.0..1.0))]
    pub horizontal_cti: f64,
    /// Interline: light that leaks into the vertical registers, dB, as data sheets state it (a tenth of the rows lit,
    /// read in the time of the exposure). No smear where left out.
    #[schemars(transform = within(..=0.0))]
    pub smear_db: Option<f64>,
    /// Interline: time to read one line, µs; smear grows with it.
    #[schemars(transform = above(0.0..))]
    pub line_time_us: Option<f64>,
    /// Frame transfer: time to shift the image by one row towards its storage, µs; smear grows with it.
    #[schemars(transform = within(0.0..))]
    pub row_shift_time_us: Option<f64>,
    /// Multiple of the saturating light up to which a drain keeps a pixel from blooming. Left out: 1, no drain.
    #[schemars(transform = within(1.0..))]
    pub anti_blooming_factor: Option<f64>,
    /// Wells of the read-out register before the first column; they come first in every row.
    #[schemars(transform = within(0.0..=4096.0))]
    pub prescan_columns: u32,
    /// Shifts beyond the last column.
    #[schemars(transform = within(0.0..=4096.0))]
    pub overscan_columns: u32,
    /// Shifts beyond the last row.
    #[schemars(transform = within(0.0..=4096.0))]
    pub overscan_rows: u32,
}

/// Architecture of a CCD: the place where its charge goes when the exposure ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum CcdArchitecture {
    /// Into a shielded register beside each column of pixels.
    #[default]
    Interline,
    /// Quickly, through the pixels, into a shielded storage area as large as the image.
    FrameTransfer,
    /// Row by row, through the pixels, to the output, behind a shutter.
    FullFrame,
}

/// Charge transfer of a CCD.
#[derive(Clone, Debug, PartialEq)]
pub struct Ccd {
    /// Architecture: where charge goes when the exposure ends.
    pub architecture: CcdArchitecture,
    /// The time for which a packet collects light in each row that it passes.
    pub smear_row_time: Seconds,
    /// Part of the charge that stays behind at each shift along a column, 0 to below 1.
    pub vertical_inefficiency: f64,
    /// Part of the charge that stays behind at each shift along the read-out register, 0 to below 1.
    pub horizontal_inefficiency: f64,
    /// Light, as a multiple of the saturating light, up to which a drain keeps a pixel from blooming; 1 for no drain.
    pub anti_blooming_factor: f64,
    /// Wells beside the pixels.
    pub overscan: Overscan,
}

/// Wells without a pixel that are read out with the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Overscan {
    /// Wells of the register between the first column and the amplifier, which come first in every row.
    pub prescan_columns: usize,
    /// Further shifts after the last column.
    pub columns: usize,
    /// Further shifts after the last row.
    pub rows: usize,
}

impl Ccd {
    /// Keys of errors are those of the table `[ccd]`.
    pub(crate) fn new(d: &CcdDescription) -> Result<Self, Invalid> {
        Ok(Self {
            architecture: d.architecture,
            smear_row_time: smear_row_time(d)?,
            vertical_inefficiency: fraction_below_one("vertical_cti", d.vertical_cti)?,
            horizontal_inefficiency: fraction_below_one("horizontal_cti", d.horizontal_cti)?,
            anti_blooming_factor: anti_blooming_factor(d.anti_blooming_factor)?,
            overscan: Overscan {
                prescan_columns: margin("prescan_columns", d.prescan_columns)?,
                columns: margin("overscan_columns", d.overscan_columns)?,
                rows: margin("overscan_rows", d.overscan_rows)?,
            },
        })
    }
}

fn anti_blooming_factor(factor: Option<f64>) -> Result<f64, Invalid> {
    match factor.unwrap_or(1.0) {
        factor if factor.is_finite() && factor >= 1.0 => Ok(factor),
        factor => Err(Invalid::new("anti_blooming_factor", format!("must be 1 or more, got {factor}"))
            .help("data sheets state it like anti_blooming_factor = 1000.0; leave it out for no drain")),
    }
}

fn smear_row_time(d: &CcdDescription) -> Result<Seconds, Invalid> {
    let unused = |key: &str, of: &str| {
        Err(Invalid::new(key, format!("does not apply to a CCD whose architecture is {of:?}"))
            .help("smear_db and line_time_us are for interline CCDs, row_shift_time_us for frame-transfer CCDs"))
    };
    match d.architecture {
        CcdArchitecture::Interline => {
            if d.row_shift_time_us.is_some() {
                return unused("row_shift_time_us", "interline");
            }
            let Some(smear_db) = d.smear_db else { return Ok(Seconds(0.0)) };
            if !(smear_db.is_finite() && smear_db <= 0.0) {
                return Err(Invalid::new("smear_db", format!("must not be above 0, got {smear_db}"))
                    .help("data sheets state it like smear_db = -100.0; leave it out for no smear"));
            }
            let Some(line_time) = d.line_time_us else {
                return Err(Invalid::new("line_time_us", "missing; how strong smear_db is depends on it")
                    .help("write the time to read one line, for example line_time_us = 30.0"));
            };
            positive("line_time_us", line_time, "30.0")?;
            Ok(interline_time(smear_db, Seconds(line_time * 1e-6)))
        }
        CcdArchitecture::FrameTransfer => {
            if d.smear_db.is_some() {
                return unused("smear_db", "frame-transfer");
            }
            let time = d.row_shift_time_us.unwrap_or(0.0);
            not_negative("row_shift_time_us", time)?;
            Ok(Seconds(time * 1e-6))
        }
        // A shutter keeps light away while it is read.
        CcdArchitecture::FullFrame => match (d.smear_db, d.row_shift_time_us) {
            (None, None) => Ok(Seconds(0.0)),
            (Some(_), _) => unused("smear_db", "full-frame"),
            (None, Some(_)) => unused("row_shift_time_us", "full-frame"),
        },
    }
}

/// The time τ for which an interline sensor with this smear, as data sheets state it, collects in each row.
///
/// Their figure is the signal in a dark row over that in lit rows, when a tenth of the rows is lit (V/10) and reading
/// takes as long as the exposure: with H rows of a line time t_l each, it is τ·(H/10)/(H·t_l), so
///
/// τ = 10 · 10^(dB/20) · t_l.
fn interline_time(smear_db: f64, line_time: Seconds) -> Seconds {
    Seconds(10.0 * 10f64.powf(smear_db / 20.0) * line_time.0)
}
