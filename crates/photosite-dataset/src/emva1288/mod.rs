//! EMVA 1288: the image sets that the standard asks for, taken and evaluated, and sensors fitted to the images of a
//! camera. The formulas are those of
//! [`characterisation`](photosite_measure::characterisation); here are files and order.

mod evaluate;
mod fit;
mod measured;
mod take;

pub use evaluate::{evaluate_descriptor, evaluate_sets};
pub use fit::{FitReport, FitRequest, FittedCamera, fit_images};
pub use measured::MeasuredChannel;
pub use take::{SetPlan, SetRequest, refuse_image_sets};
