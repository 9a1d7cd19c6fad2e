//! The report of a characterisation: one HTML page that needs nothing besides itself, with tables of what was expected
//! and what was measured, and with vector plots.
//!
//! In: what was measured of each channel. Out: the text of the page. Files are left to the caller.

mod chart;
mod curves;
mod page;
mod points;

pub use page::{ChannelReport, Comparison, Report};
pub use points::{SpectralPoint, ThermalPoint};
