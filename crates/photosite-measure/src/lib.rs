//! Measures of images and of sensors.
//!
//! [`measures`] takes figures of images: sharpness, similarity, levels; [`validation`] tells whether two images of one
//! scene agree; [`characterisation`] finds the parameters of a sensor after EMVA 1288; [`synthetic_noise`] adds textbook
//! noise to any image, and estimates it.

#![forbid(unsafe_code)]

pub mod characterisation;
pub mod measures;
pub mod synthetic_noise;
pub mod validation;
