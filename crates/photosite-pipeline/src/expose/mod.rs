//! Exposure in memory: from light to raw images through the sensor, the frames of a series, and the light that serves
//! them.

pub(crate) mod chain;
pub(crate) mod frame_series;
pub(crate) mod ideal_image;
pub(crate) mod light_reuse;
pub(crate) mod sensor_card;
pub(crate) mod shot;
