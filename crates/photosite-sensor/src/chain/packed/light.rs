//! Light as plain data.

use photosite_core::Invalid;
use photosite_core::cells::CellLayout;
use photosite_core::image::Planes;
use photosite_raw::Cfa;

use crate::SensorModel;
use crate::chain::expose::collect;

/// Mean electrons of an exposure as a card takes them: e⁻, a number for each value of a pixel that the sensor reads out
/// of it, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedLight {
    layout: LightLayout,
    electrons: Vec<f32>,
}

/// Layout of light: the size of its image, and the colour filters and the image circle by which pixels see it.
#[derive(Clone, Debug, PartialEq)]
pub struct LightLayout {
    image: [usize; 2],
    cfa: Cfa,
    cells: CellLayout,
}

impl LightLayout {
    /// Layout of the light of an image of so many columns and rows on a sensor.
    pub(super) fn new(image: [usize; 2], sensor: &SensorModel) -> Self {
        Self { image, cfa: sensor.cfa.clone(), cells: sensor.cells }
    }

    /// Columns and rows of the image.
    pub fn image(&self) -> [usize; 2] {
        self.image
    }
}

impl PackedLight {
    /// Packs light that frees `mean_electrons` on average, as [`expose`](crate::expose()) takes it: each pixel takes
    /// the channel that it sees. Of the sensor, its colour filter array and its image circle count alone.
    ///
    /// # Errors
    ///
    /// Channels of the sensor that the planes do not have, numbers that are negative or not finite.
    pub fn new(mean_electrons: &Planes, sensor: &SensorModel) -> Result<Self, Invalid> {
        let layout = LightLayout::new([mean_electrons.width(), mean_electrons.height()], sensor);
        Ok(Self { layout, electrons: collect(mean_electrons, sensor)?.electrons })
    }

    /// Layout, which is that of all exposures of this light.
    pub fn layout(&self) -> &LightLayout {
        &self.layout
    }

    /// Mean electrons row by row, the values of a pixel beside each other.
    pub fn electrons(&self) -> &[f32] {
        &self.electrons
    }
}
