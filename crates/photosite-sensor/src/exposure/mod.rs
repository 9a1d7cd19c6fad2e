//! Settings of an exposure and what follows from them: gains of a speed, times that light asks for, the way back from
//! nonlinear digital numbers.

mod auto_exposure;
mod binning;
mod gain_control;
mod iso;
mod linearisation;
mod read_out_grid;
mod settings;

pub use auto_exposure::{AutoExposed, AutoExposure, Metering, TimeLimit, auto_exposure};
pub use binning::{Binning, BinningMethod};
pub use gain_control::GainControl;
pub use linearisation::Linearisation;
pub use settings::{Exposure, RegionOfInterest};
