//! Shutter: the times at which each row of an image sees light.
//!
//! Row y of an image that begins at t₀ sees light from t₀ + n·t_row on for the exposure time, where
//!
//! n = |y + ½ − m| − ½
//!
//! rows come before it: all above it for m = 0, those nearer to the middle for m = rows/2. What moves across the
//! image with v pixels a second is skewed by v·t_row pixels a row.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::above;
use photosite_core::units::Seconds;

use super::checks::positive;

/// Shutter: the times at which rows are exposed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct ShutterDescription {
    /// Left out: "global".
    #[serde(default)]
    pub kind: ShutterKind,
    /// Time from the start of one row's exposure to that of the next, µs; needed unless the shutter is global.
    #[schemars(transform = above(0.0..))]
    pub row_time_us: Option<f64>,
    /// Direction of a rolling shutter. Left out: "from-top".
    #[serde(default)]
    pub order: RowOrder,
}

/// In which order the rows of a rolling shutter are exposed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum RowOrder {
    /// One after the other from the top.
    #[default]
    FromTop,
    /// Upwards and downwards from the middle at the same time, as sensors do that are read from both sides.
    FromMiddle,
}

/// Kinds of shutters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum ShutterKind {
    /// All rows at once.
    #[default]
    Global,
    /// Row after row.
    Rolling,
    /// Line scan (pushbroom): a single row of pixels records one line of the image after the other as the camera moves.
    /// The second number of resolution_px counts the lines of an image.
    Scanning,
}

/// Shutter: the times at which each row of an image sees light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Shutter {
    /// Global shutter: all rows at once.
    #[default]
    Global,
    /// Row after row.
    Rolling {
        /// Time from the start of one row's exposure to that of the next.
        row_time: Seconds,
        /// Order in which rows are exposed.
        order: RowOrder,
    },
    /// A single row of pixels records all lines of the image one after the other.
    Scanning {
        /// Time from the start of one line's exposure to that of the next.
        line_time: Seconds,
    },
}

impl Shutter {
    /// Keys of errors are those of the table `[shutter]`.
    pub(super) fn new(d: &ShutterDescription) -> Result<Self, Invalid> {
        let row_time = || {
            let missing = || Invalid::new("row_time_us", "missing; a rolling shutter needs it");
            let us = d.row_time_us.ok_or_else(|| missing().help("for example row_time_us = 20.0"))?;
            positive("row_time_us", us, "20.0")?;
            Ok::<_, Invalid>(Seconds(us / 1e6))
        };
        if d.kind != ShutterKind::Rolling && d.order != RowOrder::FromTop {
            return Err(
                Invalid::new("order", "belongs to rolling shutters").help("write kind = \"rolling\", or leave it out")
            );
        }
        match (d.kind, d.row_time_us) {
            (ShutterKind::Global, None) => Ok(Self::Global),
            (ShutterKind::Global, Some(_)) => Err(Invalid::new("row_time_us", "does not apply to a global shutter")
                .help("write kind = \"rolling\", or leave it out")),
            (ShutterKind::Rolling, _) => Ok(Self::Rolling { row_time: row_time()?, order: d.order }),
            (ShutterKind::Scanning, _) => Ok(Self::Scanning { line_time: row_time()? }),
        }
    }

    /// Time from the start of one row's exposure to that of the next.
    pub fn row_time(&self) -> Seconds {
        match *self {
            Self::Global => Seconds(0.0),
            Self::Rolling { row_time: time, .. } | Self::Scanning { line_time: time } => time,
        }
    }

    /// First row m of the equation above, for an image of `rows` rows.
    pub fn first_row(&self, rows: usize) -> f64 {
        match self {
            Self::Rolling { order: RowOrder::FromMiddle, .. } => rows as f64 / 2.0,
            Self::Global | Self::Rolling { order: RowOrder::FromTop, .. } | Self::Scanning { .. } => 0.0,
        }
    }

    /// Time from the first row's start to that of another one, in an image of `rows` rows.
    pub fn delay(&self, row: usize, rows: usize) -> Seconds {
        let before = (row as f64 + 0.5 - self.first_row(rows)).abs() - 0.5;
        Seconds(before * self.row_time().0)
    }

    /// Time that `rows` rows take one after the other.
    pub fn duration(&self, rows: usize) -> Seconds {
        Seconds(self.delay(rows, rows).0.max(self.row_time().0))
    }

    /// Whether all rows of an image come from the same row of pixels.
    pub fn scans(&self) -> bool {
        match self {
            Self::Global | Self::Rolling { .. } => false,
            Self::Scanning { .. } => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_start_in_their_order() {
        let row_time = Seconds(2.0);
        let delays = |order| {
            let shutter = Shutter::Rolling { row_time, order };
            ([0, 1, 2, 3].map(|row| shutter.delay(row, 4).0), shutter.duration(4).0)
        };
        assert_eq!(delays(RowOrder::FromTop), ([0.0, 2.0, 4.0, 6.0], 8.0));
        assert_eq!(delays(RowOrder::FromMiddle), ([2.0, 0.0, 0.0, 2.0], 4.0));
        assert_eq!((Shutter::Global.delay(3, 4).0, Shutter::Global.duration(4).0), (0.0, 0.0));
    }
}
