//! RGB colour spaces: primaries and white point, and with them the matrix to XYZ.

use std::sync::OnceLock;

use crate::keys::Keys;
use glam::{DMat3, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::adaptation::bradford;
use crate::spectrum::{cie, illuminant, rgb};

/// A colour space for images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum ColourSpace {
    /// sRGB, which screens and browsers expect (IEC 61966-2-1).
    #[default]
    Srgb,
    /// Display P3: wider, of recent screens and phones.
    DisplayP3,
    /// ITU-R BT.2020: wider still, of ultra-high-definition television.
    Rec2020,
    /// ACEScg (AP1 primaries, white near D60), in which films are composited.
    Acescg,
    /// CIE XYZ relative to D65, Y = 1 for white; for EXR, TIFF and NPY files, since X and Z pass 1.
    Xyz,
}

impl ColourSpace {
    /// All colour spaces.
    pub const ALL: [Self; 5] = [Self::Srgb, Self::DisplayP3, Self::Rec2020, Self::Acescg, Self::Xyz];

    /// Name for messages, as `sRGB` or `Display P3`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Srgb => "sRGB",
            Self::DisplayP3 => "Display P3",
            Self::Rec2020 => "Rec. 2020",
            Self::Acescg => "ACEScg",
            Self::Xyz => "CIE XYZ",
        }
    }

    /// Chromaticities of red, green and blue ([Srgb](crate::references#srgb),
    /// [SmpteEg432](crate::references#smpteeg432), [Bt2020](crate::references#bt2020),
    /// [Aces14](crate::references#aces14)).
    fn primaries(self) -> Option<[[f64; 2]; 3]> {
        match self {
            Self::Srgb => Some(rgb::PRIMARIES),
            Self::DisplayP3 => Some([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]]),
            Self::Rec2020 => Some([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]]),
            Self::Acescg => Some([[0.713, 0.293], [0.165, 0.830], [0.128, 0.044]]),
            Self::Xyz => None,
        }
    }

    /// XYZ of white with Y = 1. For D65 these are the tabulated illuminant's, of which (0.3127, 0.3290) is the rounded
    /// chromaticity.
    pub fn white(self) -> DVec3 {
        // Searches for matrices ask for it a million times.
        static D65: OnceLock<DVec3> = OnceLock::new();
        match self {
            Self::Srgb | Self::DisplayP3 | Self::Rec2020 | Self::Xyz => *D65.get_or_init(|| {
                cie::xyz_of_chromaticity(cie::chromaticity(illuminant::d65()).expect("D65 is not black"))
            }),
            Self::Acescg => cie::xyz_of_chromaticity([0.321_68, 0.337_67]),
        }
    }

    /// CIE x and y of red, green, blue and white; for XYZ, its axes and the equal-energy point.
    pub fn chromaticities(self) -> [[f64; 2]; 4] {
        match self.primaries() {
            Some([red, green, blue]) => {
                let white = self.white();
                let sum = white.element_sum();
                [red, green, blue, [white.x / sum, white.y / sum]]
            }
            None => [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]],
        }
    }

    /// Linear RGB → XYZ relative to the space's own white.
    pub fn to_xyz(self) -> DMat3 {
        match self.primaries() {
            Some(primaries) => rgb::matrix(primaries, self.white()),
            None => DMat3::IDENTITY,
        }
    }

    /// Channel names, as image files have them.
    pub fn channels(self) -> [&'static str; 3] {
        match self {
            Self::Srgb | Self::DisplayP3 | Self::Rec2020 | Self::Acescg => ["R", "G", "B"],
            Self::Xyz => ["X", "Y", "Z"],
        }
    }

    /// Weights of the three components in relative luminance Y: the second row of [`Self::to_xyz`].
    pub fn luminance_weights(self) -> DVec3 {
        self.to_xyz().row(1)
    }

    /// XYZ relative to a white → linear RGB, in which that white is white (Bradford adaptation).
    pub fn from_xyz(self, white: DVec3) -> DMat3 {
        self.to_xyz().inverse() * bradford(white, self.white())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_everywhere() {
        for space in ColourSpace::ALL {
            let white = DVec3::new(1.1, 1.0, 0.36);
            let expected = if space == ColourSpace::Xyz { space.white() } else { DVec3::ONE };
            assert!((space.from_xyz(white) * white).abs_diff_eq(expected, 1e-12), "{}", space.name());
            assert!((space.to_xyz() * expected).abs_diff_eq(space.white(), 1e-12), "{}", space.name());
        }
    }

    #[test]
    fn matrices_are_the_published_ones() {
        // Green's share of luminance: BT.2020 table 4, SMPTE EG 432-1 annex H, ACES TB-2014-004; the white points there
        // are rounded to four decimals.
        for (space, green) in
            [(ColourSpace::Rec2020, 0.6780), (ColourSpace::DisplayP3, 0.6917), (ColourSpace::Acescg, 0.674_081_7)]
        {
            assert!((space.to_xyz().col(1).y - green).abs() < 1e-4, "{}: {}", space.name(), space.to_xyz());
        }
    }
}
