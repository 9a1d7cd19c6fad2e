//! Common ground of the stages: rows and planes of charge, names of stages and of noise maps, random numbers.

pub(super) mod charge_generation;
pub(super) mod charge_plane;
pub(super) mod effects;
pub(super) mod noise_key;
pub(super) mod words;
