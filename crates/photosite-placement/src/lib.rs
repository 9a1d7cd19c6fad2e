//! Placement of rigid objects in a scene: anywhere in a box, on surfaces, standing by themselves, or dropped by a
//! rigid-body engine until at rest; never inside each other, by an exact test of all triangles.
//!
//! A [`Request`] of [`Shape`]s gives a [`Pose`] for each. Poses are a function of the request and its seed alone, so
//! that each frame of a data set can be made by anyone, in any order, with the same bytes on every machine.
//!
//! Lengths are in metres, +Y is up.

#![forbid(unsafe_code)]

mod bin;
mod body;
mod drop;
mod engine;
mod hull;
mod parts;
mod place;
mod pose;
mod request;
mod resting;
mod scatter;
mod shape;
mod surface;

pub use bin::{Bin, cuboid};
pub use place::place;
pub use pose::{Pose, Turn};
pub use request::{Contact, Fixed, Item, Method, Region, Request, Support};
pub use resting::RestingPose;
pub use shape::Shape;
