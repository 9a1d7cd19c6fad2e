//! Noise maps as files: all in one OpenEXR file, or each as a NumPy array of `float32`.
//!
//! The attributes `systemGain` (DN/e⁻) and `blackLevel` (DN) of the EXR file are those by which the maps sum to the raw
//! image: [`NoiseMaps`].

use std::io::{self, Seek, Write};

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_sensor::{NoiseMap, NoiseMaps};

use super::exr::{Attribute, write_exr};
use super::npy::write_planes;

/// File format of noise maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseFormat {
    /// One OpenEXR file of all maps.
    Exr,
    /// NumPy array for each map.
    Npy,
}

/// Writes all maps as one OpenEXR file.
pub fn write_noise_exr<W: Write + Seek>(maps: &NoiseMaps, to: W) -> io::Result<()> {
    let attributes = [
        ("unit", Attribute::Text("names that end with _e: e-; with _dn: DN".to_owned())),
        ("systemGain", Attribute::Number(maps.system_gain)),
        ("blackLevel", Attribute::Number(maps.black_level_dn)),
    ];
    write_exr(&maps.planes, &attributes, to)
}

/// Writes a map as an array of shape (rows, columns), or (rows, columns, channels) where a pixel has several.
pub fn write_noise_npy<W: Write>(maps: &NoiseMaps, map: NoiseMap, to: W) -> io::Result<()> {
    let is_of_map = |name: &str| name.split_once('.').map_or(name, |(map, _)| map) == map.name();
    let planes: Vec<&[f32]> =
        maps.planes.channels().iter().filter(|c| is_of_map(&c.name)).map(|c| &c.data[..]).collect();
    write_planes([maps.planes.width(), maps.planes.height()], &planes, |value| value, to)
}
