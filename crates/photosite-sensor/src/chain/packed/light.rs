//! Light as plain data.

use photosite_core::Invalid;
use photosite_core::image::Planes;

use crate::SensorModel;
use crate::chain::expose::collect;

/// Mean electrons of an exposure as a card takes them: e⁻, a number for each value of a pixel that the sensor reads out
/// of it, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedLight {
    image: [usize; 2],
    electrons: Vec<f32>,
}

impl PackedLight {
    /// Packs light that frees `mean_electrons` on average, as [`expose`](crate::expose()) takes it: each pixel takes the
    /// channel that it sees. It depends on the sensor's colour filter array and image circle alone.
    ///
    /// # Errors
    ///
    /// Channels of the sensor that the planes do not have, numbers that are negative or not finite.
    pub fn new(mean_electrons: &Planes, sensor: &SensorModel) -> Result<Self, Invalid> {
        let image = [mean_electrons.width(), mean_electrons.height()];
        Ok(Self { image, electrons: collect(mean_electrons, sensor)?.electrons })
    }

    /// Columns and rows of the image.
    pub fn image(&self) -> [usize; 2] {
        self.image
    }

    /// Mean electrons row by row, the values of a pixel beside each other.
    pub fn electrons(&self) -> &[f32] {
        &self.electrons
    }
}
