//! Camera, `[camera]` and `[lens]`: its pose and its optics.

pub(crate) mod aberrations;
pub(crate) mod calibration;
pub(crate) mod focus;
pub(crate) mod framing;
pub(crate) mod lens;
pub(crate) mod lens_elements;
pub(crate) mod pose;
pub(crate) mod prescription;
pub(crate) mod projection;
