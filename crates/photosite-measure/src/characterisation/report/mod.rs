//! Reports: HTML pages that need nothing besides themselves, with tables and with vector plots. [`Report`] is that of a
//! characterisation, what was expected beside what was measured, [`PairReport`] that of two; [`NoiseReport`] that of estimates of the noise of
//! images, whose plots are to be had as PNG files, too.
//!
//! In: what was measured. Out: the text of the page, the bytes of the plots. Files are left to the caller.

pub mod chart;
mod curves;
pub mod html;
mod noise_curves;
mod noise_page;
mod page;
mod pair_page;
pub mod plot;
mod points;

pub use html::LOOK;
pub use noise_page::{NoiseReport, PlaneNoise};
pub use page::{ChannelReport, Comparison, Report};
pub use pair_page::{PairReport, PairedFigure};
pub use points::{SpectralPoint, ThermalPoint};
