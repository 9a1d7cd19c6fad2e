//! Attributes in the header of an EXR file.

use std::fmt;

use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities};
use exr::meta::header::{ImageAttributes, LayerAttributes};

/// Value of an attribute in the header of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Text.
    Text(String),
    /// A number.
    Number(f64),
    /// CIE x and y of red, green, blue and white: the standard attribute `chromaticities`.
    Chromaticities([[f64; 2]; 4]),
    /// Width of a pixel over its height: the standard attribute `pixelAspectRatio`.
    PixelAspect(f64),
    /// A value of another type, as the file has it.
    Other(Box<AttributeValue>),
}

impl Attribute {
    /// Text of the attribute, if it is one.
    pub fn text(&self) -> Option<&str> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// Number of the attribute, if it is one.
    pub fn number(&self) -> Option<f64> {
        if let Self::Number(number) = self {
            return Some(*number);
        }
        if let AttributeValue::F32(number) = self.other()? { Some(f64::from(*number)) } else { None }
    }

    /// Value of another type, if the attribute is one.
    pub fn other(&self) -> Option<&AttributeValue> {
        if let Self::Other(value) = self { Some(value) } else { None }
    }

    fn of(value: AttributeValue) -> Self {
        if let AttributeValue::Text(text) = value {
            return Self::Text(text.to_string());
        }
        if let AttributeValue::F64(number) = value { Self::Number(number) } else { Self::Other(Box::new(value)) }
    }
}

impl fmt::Display for Attribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => write!(f, "{text:?}"),
            Self::Number(number) | Self::PixelAspect(number) => write!(f, "{number}"),
            Self::Chromaticities(points) => write!(f, "{points:?}"),
            Self::Other(value) => of_type(value, f),
        }
    }
}

fn of_type(value: &AttributeValue, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    if let AttributeValue::F32(number) = value {
        return write!(f, "{number}");
    }
    if let AttributeValue::I32(number) = value { write!(f, "{number}") } else { write!(f, "{value:?}") }
}

/// Pixel aspect ratio, where pixels are not square.
pub fn not_square(aspect: f64) -> Option<f64> {
    (aspect != 1.0).then_some(aspect)
}

/// Attributes that are not standard, and standard ones that give pixel values their meaning, sorted by name.
pub(super) fn of_headers(shared: &ImageAttributes, own: &LayerAttributes) -> Vec<(String, Attribute)> {
    let text = |value: &Option<exr::meta::attribute::Text>| value.clone().map(AttributeValue::Text);
    let standard = [
        ("adoptedNeutral", own.adopted_neutral.map(AttributeValue::FloatVec2)),
        ("envmap", own.environment_map.map(AttributeValue::EnvironmentMap)),
        ("lookModTransform", text(&own.look_modification_transform_name)),
        ("multiView", own.multi_view_names.clone().map(AttributeValue::TextVector)),
        ("originalDataWindow", own.original_data_window.map(AttributeValue::IntegerBounds)),
        ("renderingTransform", text(&own.rendering_transform_name)),
        ("whiteLuminance", own.white_luminance.map(AttributeValue::F32)),
        ("wrapmodes", text(&own.wrap_mode_name)),
    ];
    let standard = standard.into_iter().filter_map(|(name, value)| Some((name.to_owned(), Attribute::of(value?))));
    let others = own.other.iter().chain(&shared.other);
    let others = others.map(|(name, value)| (name.to_string(), Attribute::of(value.clone())));
    let chromaticities = shared.chromaticities.map(|Chromaticities { red, green, blue, white }| {
        let points = [red, green, blue, white].map(|Vec2(x, y)| [x, y].map(f64::from));
        ("chromaticities".to_owned(), Attribute::Chromaticities(points))
    });
    let aspect = not_square(shared.pixel_aspect.into())
        .map(|aspect| ("pixelAspectRatio".to_owned(), Attribute::PixelAspect(aspect)));
    let mut all: Vec<_> = standard.chain(others).chain(chromaticities).chain(aspect).collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all.dedup_by(|a, b| a.0 == b.0);
    all
}
