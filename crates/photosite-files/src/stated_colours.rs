//! Statements of an image file's colours: how its codes become light, to be repeated by another file of the same codes.

use photosite_scene_io::exr::Attribute;

/// Statements of a file about colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedColours {
    /// ICC profile of a PNG, TIFF or JPEG file.
    pub profile: Option<Vec<u8>>,
    /// Code points of a PNG file (cICP): primaries and transfer function by H.273.
    pub code_points: Option<[u8; 2]>,
    /// Rendering intent of a PNG file that declares sRGB.
    pub srgb: Option<png::SrgbRenderingIntent>,
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
            srgb: info.srgb,
            gamma: info.gama_chunk.map(number),
            chromaticities: info.chrm_chunk.map(|c| [c.red, c.green, c.blue, c.white].map(point)),
            attributes: Vec::new(),
        }
    }

    /// Statements by the attributes of an EXR file.
    pub fn of_exr<'a>(attributes: impl IntoIterator<Item = (&'a str, Attribute)>) -> Self {
        let attributes = attributes.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        Self { attributes, ..Self::default() }
    }

    /// Writes the statements into the header of a PNG file, all but code points, which are a chunk of their own.
    pub(super) fn write_png<'a>(&'a self, info: &mut png::Info<'a>) {
        let number = |value: f64| png::ScaledFloat::from_scaled((value * 1e5).round() as u32);
        info.icc_profile = self.profile.as_deref().map(Into::into);
        // A file has one of both.
        info.srgb = self.srgb.filter(|_| self.profile.is_none());
        info.source_gamma = self.gamma.map(number);
        info.source_chromaticities = self.chromaticities.map(|points| {
            let [red, green, blue, white] = points.map(|[x, y]| (number(x), number(y)));
            png::SourceChromaticities { white, red, green, blue }
        });
    }
}
