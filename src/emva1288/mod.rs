//! EMVA 1288: the image sets that the standard asks for, taken and evaluated. The formulas are those of
//! [`characterisation`](crate::characterisation); here are files and order.

mod evaluate;
mod measured;
mod take;

pub use evaluate::{evaluate_descriptor, evaluate_sets};
pub use measured::MeasuredChannel;
pub use take::{SetPlan, SetRequest, refuse_image_sets};
