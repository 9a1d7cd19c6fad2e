//! When each row of a picture sees light.
//!
//! Row y of a picture that begins at t₀ sees light from t₀ + y·t_row on for the exposure time. What moves across the
//! picture with v pixels a second is skewed by v·t_row pixels a row.

use crate::Invalid;
use crate::raw::Cfa;
use crate::units::Seconds;

use super::description::{SensorDescription, SensorKind, ShutterDescription, ShutterKind};
use super::model::checks::positive;

/// When each row of a picture sees light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Shutter {
    /// All rows at once.
    #[default]
    Global,
    /// Row after row from the top.
    Rolling {
        /// Time from the start of one row's exposure to that of the next.
        row_time: Seconds,
    },
    /// A single row of pixels records all lines of the picture one after the other.
    Scanning {
        /// Time from the start of one line's exposure to that of the next.
        line_time: Seconds,
    },
}

impl Shutter {
    /// Keys of errors are those of the table `[shutter]`.
    pub(super) fn new(d: &ShutterDescription) -> Result<Self, Invalid> {
        let row_time = || {
            let missing = || Invalid::new("row_time_us", "missing; rows that follow each other need it");
            let us = d.row_time_us.ok_or_else(|| missing().help("for example row_time_us = 20.0"))?;
            positive("row_time_us", us, "20.0")?;
            Ok::<_, Invalid>(Seconds(us / 1e6))
        };
        match (d.kind, d.row_time_us) {
            (ShutterKind::Global, None) => Ok(Self::Global),
            (ShutterKind::Global, Some(_)) => Err(Invalid::new("row_time_us", "says nothing of a global shutter")
                .help("write kind = \"rolling\", or leave it out")),
            (ShutterKind::Rolling, _) => Ok(Self::Rolling { row_time: row_time()? }),
            (ShutterKind::Scanning, _) => Ok(Self::Scanning { line_time: row_time()? }),
        }
    }

    /// Refuses what sensors with this shutter do not have. Keys of errors are those of the sensor file.
    pub(super) fn check(&self, d: &SensorDescription, cfa: &Cfa) -> Result<(), Invalid> {
        if *self != Self::Global && d.kind == SensorKind::Ccd {
            let message = "a CCD takes up the charge of all its rows at once";
            return Err(
                Invalid::new("shutter.kind", message).help("leave it out, or write kind = \"cmos\" for the sensor")
            );
        }
        if !self.scans() {
            return Ok(());
        }
        let kernels = d.crosstalk.iter().chain(d.channels.values().filter_map(|channel| channel.crosstalk.as_ref()));
        let across_rows = [
            ("cfa", cfa.tile_size().1 > 1),
            ("masked_rows", d.masked_rows != [0, 0]),
            ("crosstalk", kernels.into_iter().any(|rows| rows.len() > 1)),
            ("charge.brighter_fatter_per_e", d.charge.brighter_fatter_per_e[1] > 0.0),
        ];
        match across_rows.iter().find(|(_, is_given)| *is_given) {
            None => Ok(()),
            Some((key, _)) => Err(Invalid::new(*key, "reaches over several rows, and a scanning sensor has one")
                .help("describe one row of pixels")),
        }
    }

    /// Time from the start of one row's exposure to that of the next.
    pub fn row_time(&self) -> Seconds {
        match *self {
            Self::Global => Seconds(0.0),
            Self::Rolling { row_time: time } | Self::Scanning { line_time: time } => time,
        }
    }

    /// Whether all rows of a picture come from the same row of pixels.
    pub fn scans(&self) -> bool {
        match self {
            Self::Global | Self::Rolling { .. } => false,
            Self::Scanning { .. } => true,
        }
    }
}
