//! Ground truth of the surface that the chief ray through the centre of each pixel meets first.
//!
//! In: an image, as a camera and what is in front of it; the next one for flow, that of a partner for disparity. Out:
//! planes named as in [`TruthLayer::channels`], one value a pixel, without noise, blur or anti-aliasing. Surfaces count
//! whatever they are made of: glass is what is seen of a window. Holes of a material's alpha let the ray through.

mod albedo;
mod correspondence;
mod extent;
mod layer;
mod objects;
mod pose_path;
mod row_search;
mod silhouettes;
mod trace;

pub use correspondence::{Correspondence, NotFound, View, project};
pub use layer::{Needs, PngRule, TruthLayer, Values};
pub use objects::TruthObject;
pub use silhouettes::{Mask, Silhouettes, silhouettes};
pub use trace::{TruthJob, truth};
