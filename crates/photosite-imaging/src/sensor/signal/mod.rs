//! What stages have in common: rows and planes of charge, their names, their random numbers and the names of noise
//! maps.

pub(super) mod charge_generation;
pub(super) mod charge_plane;
pub(super) mod effects;
pub(super) mod noise_key;
