//! What an image's file says of its colours: how its codes become light, to be said by another file of the same codes.

use super::exr::Attribute;

/// Statements of a file about colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedColours {
    /// ICC profile of a PNG, TIFF or JPEG file.
    pub profile: Option<Vec<u8>>,
    /// Code points of a PNG file (cICP): primaries and transfer function by the numbers of H.273.
    pub code_points: Option<[u8; 2]>,
    /// Whether a PNG file says that it is sRGB.
    pub is_srgb: bool,
    /// Exponent by which a PNG file is encoded (gAMA).
    pub gamma: Option<f64>,
    /// CIE x and y of red, green, blue and white of a PNG file (cHRM).
    pub chromaticities: Option<[[f64; 2]; 4]>,
    /// Attributes of an EXR file.
    pub attributes: Vec<(String, Attribute)>,
}

impl StatedColours {
    /// Colours that a PNG file states.
    pub(super) fn of_png(info: &png::Info<'_>) -> Self {
        let number = |value: png::ScaledFloat| f64::from(value.into_value());
        let point = |(x, y)| [x, y].map(number);
        Self {
            profile: info.icc_profile.as_ref().map(|profile| profile.to_vec()),
            code_points: info.coding_independent_code_points.map(|c| [c.color_primaries, c.transfer_function]),
            is_srgb: info.srgb.is_some(),
            gamma: info.gama_chunk.map(number),
            chromaticities: info.chrm_chunk.map(|c| [c.red, c.green, c.blue, c.white].map(point)),
            attributes: Vec::new(),
        }
    }

    /// What only a file of the same kind can say.
    pub(super) fn not_carried(&self) -> Vec<&'static str> {
        // Those of sRGB say what a file without them says.
        let gamma = self.gamma.filter(|_| !self.is_srgb).map(|_| "gAMA");
        let chromaticities = self.chromaticities.filter(|_| !self.is_srgb).map(|_| "cHRM");
        let code_points = self.code_points.filter(|_| self.profile.is_none()).map(|_| "cICP");
        [gamma, chromaticities, code_points].into_iter().flatten().collect()
    }
}
