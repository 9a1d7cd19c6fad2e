//! What is in front of the camera: the [`description`] that files give, and the immutable [`Scene`](build) that light
//! transport reads.

pub mod description;
