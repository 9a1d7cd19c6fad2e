//! Figures of a lens from a prescription, as optical design programs list them: first order, colour, distortion,
//! illumination, spots, modulation transfer, by field and wavelength. As values for JSON, as text, and as one page of
//! HTML.

mod compute;
mod figures;
mod mtf;
mod page;
mod plots;
mod section;
mod shipped;
mod spots;
mod text;

pub(crate) use compute::Options;
pub(crate) use figures::LensFigures;
pub(crate) use page::html;
pub(crate) use shipped::{ShippedLens, shipped_lenses};
