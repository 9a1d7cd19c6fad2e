//! Settings of a capture, from the tables `[sensor]`, `[exposure]`, `[render]`, `[develop]` and `[output]`.

pub(crate) mod converter_bits;
pub(crate) mod develop;
pub(crate) mod exposure;
pub(crate) mod output;
pub(crate) mod sensor;
pub(crate) mod sensor_size;
