//! Ground truth: what the chief ray through the centre of each pixel meets first.
//!
//! In: a picture, as a camera and what is in front of it; the next one for flow, that of a partner for disparity. Out:
//! planes named as in [`TruthLayer::channels`], one value a pixel, without noise, blur or anti-aliasing. Surfaces count
//! whatever they are made of: glass is what is seen of a window. Holes of a material's alpha let the ray through.

mod albedo;
mod correspondence;
mod extent;
mod layer;
mod objects;
mod row_search;
mod silhouettes;
mod trace;
mod way;

pub use correspondence::{Correspondence, NotFound, View, project};
pub use layer::TruthLayer;
pub use objects::TruthObject;
pub use silhouettes::{Mask, Silhouettes, silhouettes};
pub use trace::{TruthJob, truth};
