//! Stand-in images of one texel, for textures that are missing or broken where that is allowed.
//!
//! Colours are grey, not a garish one: images are made to be measured and learned from, and a warning names the
//! texture. Other textures get the texel that has no effect.

use photosite_transport::texture::{Bitmap, Texels};

/// Content of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Holds {
    /// Colours, sRGB-encoded.
    Colours,
    /// Factors.
    Factors,
    /// Normals in tangent space.
    Normals,
    /// Directions in the tangent plane, in red and green, and a factor.
    Directions,
}

/// Stand-in image for an image of that name.
pub(crate) fn stand_in(holds: Holds, name: String) -> Bitmap {
    let texel = match holds {
        Holds::Colours => [128, 128, 128, 255],
        Holds::Factors => [255; 4],
        Holds::Normals => [128, 128, 255, 255],
        Holds::Directions => [255, 128, 255, 255],
    };
    Bitmap { name, width: 1, height: 1, texels: Texels::Rgba8(vec![texel]) }
}

/// Warning that an image stands in for one that is missing or broken.
pub(crate) fn stands_in(problem: &str, holds: Holds) -> String {
    let what = match holds {
        Holds::Colours => "grey is used instead",
        Holds::Factors | Holds::Normals | Holds::Directions => "the surface is left as if there were none",
    };
    format!("{problem}; {what}")
}
