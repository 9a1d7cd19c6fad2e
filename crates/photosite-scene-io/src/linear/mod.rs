//! Images of linear light: OpenEXR and Radiance HDR, turned into linear sRGB by their headers.
//!
//! | header of an EXR file | |
//! |---|---|
//! | channels `R`, `G`, `B`; `Y`; `Y`, `RY`, `BY`; `X`, `Y`, `Z` | the image; those of the only layer where none has a plain name |
//! | other channels, transparency `A` below 1, other parts | named in a warning; light is that over black |
//! | `dataWindow`, `displayWindow` | the image is the display window, 0 where nothing is stored; with `envmap` the data window |
//! | `colorInteropID`, `chromaticities`, `acesImageContainerFlag`, photosite's own `colorSpace` | used, in this order; linear sRGB without any |
//! | `pixelAspectRatio`, `whiteLuminance`, `envmap` | for those who use them, such as surroundings |
//! | `adoptedNeutral`, `renderingTransform`, `lookModTransform`, `originalDataWindow`, other names of colour spaces | named in a warning |
//! | primaries that span nothing, codes in place of light, deep or subsampled channels | refused |
//!
//! | header of an HDR file | |
//! |---|---|
//! | first line `#?RADIANCE`, `#?RGBE` or another program's; lines that end with CR LF | read |
//! | `FORMAT` | `32-bit_rle_rgbe` and `32-bit_rle_xyze`; others are refused |
//! | `EXPOSURE`, `COLORCORR` | numbers are divided by the products of all of them |
//! | `PRIMARIES` | used; linear sRGB without |
//! | `PIXASPECT` | the shape of pixels, the product of all of them |
//! | `VIEW` | for those who use it, such as surroundings |
//! | `GAMMA` other than 1, `NCOMP` other than 3 | refused |
//! | axes in any of the eight orders | the image is turned upright |
//!
//! All else in a header says nothing of what the numbers mean.

pub mod colours;
mod decode;
mod openexr;
#[cfg(test)]
mod openexr_tests;
mod radiance;
#[cfg(test)]
mod radiance_tests;

use photosite_core::Invalid;
use photosite_core::image::{Channel, NotFinite, Planes};

pub(crate) use decode::decode_linear;
pub use openexr::of_exr;
pub use radiance::{decode_radiance, is_radiance};

/// An image of a file, in linear light.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearImage {
    /// Channels: first R, G and B of linear sRGB, or Y, then those that are not part of the image.
    pub planes: Planes,
    /// Number of channels of the image: 3, 1, or none.
    pub components: usize,
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
    /// Luminance of R = G = B = 1, cd/m².
    pub white_luminance_nit: Option<f64>,
    /// Mapping from directions to pixels.
    pub mapping: Mapping,
    /// Warnings of omitted, filled-in and assumed parts.
    pub warnings: Vec<String>,
}

/// Mapping from directions to pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum Mapping {
    /// No statement in the file.
    Unstated,
    /// Columns are longitudes, rows are latitudes, both with texels at their ends.
    LatitudeLongitude,
    /// Six faces of a cube, one below the other.
    Cube,
    /// View of a camera, in the words of the file.
    View(String),
}

impl LinearImage {
    /// Names of the channels that are not part of the image.
    pub fn others(&self) -> Vec<&str> {
        self.planes.channels().iter().skip(self.components).map(|channel| &channel.name[..]).collect()
    }

    /// Message on the channels that are left out where only the image is used; `None` where there are none.
    pub fn left_out(&self) -> Option<String> {
        let others = self.others();
        (!others.is_empty()).then(|| format!("of its planes, {} have no part in the image", others.join(", ")))
    }

    /// An image without further statements, whose first channels are R, G and B, or Y.
    pub fn plain(planes: Planes) -> Self {
        let names: Vec<&str> = planes.channels().iter().map(|channel| &channel.name[..]).collect();
        let components = match names[..] {
            ["R", "G", "B", ..] => 3,
            ["Y", ..] => 1,
            _ => 0,
        };
        Self {
            planes,
            components,
            pixel_aspect: 1.0,
            white_luminance_nit: None,
            mapping: Mapping::Unstated,
            warnings: Vec::new(),
        }
    }
}

/// Largest ratio of a negative value to the largest of its texel that counts as rounding of a colour matrix.
const ROUNDING: f32 = 1.0 / (1 << 20) as f32;

impl LinearImage {
    /// Texels of the image, with 0 for negative values, and a description of these. Values that are not finite are
    /// refused.
    pub(crate) fn into_texels(self) -> Result<(Vec<[f32; 3]>, Option<String>), Invalid> {
        let [width, height] = [self.planes.width(), self.planes.height()];
        let mut channels = self.planes.into_channels();
        channels.truncate(self.components);
        let planes = Planes::new(width, height, channels)?;
        if let Some(found) = NotFinite::of(&planes) {
            return Err(Invalid::new("", found.to_string())
                .help("correct the image; a sun brighter than 65504 does not fit into half-precision files"));
        }
        let texel = |i: usize| {
            let value = |channel: &Channel| channel.data.get(i).copied().unwrap_or_default();
            match planes.channels() {
                [r, g, b] => [r, g, b].map(value),
                grey => [grey.first().map(value).unwrap_or_default(); 3],
            }
        };
        let mut texels: Vec<[f32; 3]> = (0..width * height).map(texel).collect();
        let (mut count, mut first) = (0, None);
        // Grey stands in a texel three times.
        let copies = if planes.channels().len() == 3 { 1 } else { 3 };
        for (i, texel) in texels.iter_mut().enumerate() {
            let largest = texel.iter().fold(0.0f32, |most, value| most.max(value.abs()));
            for value in texel.iter_mut().filter(|value| **value < 0.0) {
                if -*value > ROUNDING * largest {
                    count += 1;
                    first.get_or_insert((*value, i % width, i / width));
                }
                *value = 0.0;
            }
        }
        let negative = first.map(|(value, x, y)| {
            let count = count / copies;
            let (are, the_first) = if count == 1 { ("value is", "") } else { ("values are", "the first ") };
            format!("{count} {are} negative in linear sRGB, {the_first}{value} in column {x}, row {y}")
        });
        Ok((texels, negative))
    }
}

/// Error of an image of that name, whose key is one of its header.
pub(crate) fn in_image(invalid: Invalid, name: &str) -> Invalid {
    let colon = if invalid.key.is_empty() { "" } else { ": " };
    let message = format!("{name}: {}{colon}{}", invalid.key, invalid.message);
    Invalid { key: String::new(), message, help: invalid.help }
}
