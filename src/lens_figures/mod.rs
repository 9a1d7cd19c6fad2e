//! What a lens of a prescription does, as optical programs tell it: first order, colour, distortion, illumination, spots,
//! modulation transfer, by field and wavelength. As values for JSON, as text, and as one page of HTML.

mod compute;
mod figures;
mod mtf;
mod page;
mod plots;
mod section;
mod shipped;
mod spots;
mod text;

pub use compute::Options;
pub use figures::{
    ChiefFigures, Claims, FieldFigures, FirstOrderRow, GlassRow, LensFigures, MtfFigures, PositionFigures, StopFigures,
    SurfaceRow,
};
pub use page::html;
pub use shipped::{ShippedLens, shipped_lenses};
