//! Pictures of one texel, for textures that are missing or broken where that is allowed.
//!
//! Grey, not a colour that cries: pictures are made to be measured and learned from, and a warning says which texture it
//! is. What is no colour gets the texel that leaves everything as it would be without a texture.

use photosite_transport::texture::{Bitmap, Texels};

/// What a texture holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Holds {
    /// Colours, sRGB-encoded.
    Colours,
    /// Factors.
    Factors,
    /// Normals in the space of tangents.
    Normals,
    /// Directions in the plane of tangents, in red and green, and a factor.
    Directions,
}

/// The picture that stands for one of that name.
pub(crate) fn stand_in(holds: Holds, name: String) -> Bitmap {
    let texel = match holds {
        Holds::Colours => [128, 128, 128, 255],
        Holds::Factors => [255; 4],
        Holds::Normals => [128, 128, 255, 255],
        Holds::Directions => [255, 128, 255, 255],
    };
    Bitmap { name, width: 1, height: 1, texels: Texels::Rgba8(vec![texel]) }
}

/// Says that a picture stands for one that cannot be had.
pub(crate) fn stands_in(problem: &str, holds: Holds) -> String {
    let what = match holds {
        Holds::Colours => "grey is used instead",
        Holds::Factors | Holds::Normals | Holds::Directions => "the surface is left as if there were none",
    };
    format!("{problem}; {what}")
}
