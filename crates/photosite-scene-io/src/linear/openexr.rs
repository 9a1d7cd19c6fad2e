//! Linear light of OpenEXR images.

use exr::meta::attribute::{AttributeValue, EnvironmentMap};
use exr::prelude::Vec2;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::colours::{ACES, Chromaticities, Interop, are_alike, luminance_weights, to_srgb};
use super::{LinearImage, Mapping};
use crate::exr::{Attribute, ExrImage};
use photosite_core::Invalid;
use photosite_core::colour::ColourSpace;
use photosite_core::image::{Channel, Planes};

/// Kind of the channels that are the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Rgb,
    Xyz,
    /// Luminance, and (R − Y)/Y and (B − Y)/Y.
    LuminanceChroma,
    Grey,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Rgb, Self::Xyz, Self::LuminanceChroma, Self::Grey];

    fn names(self) -> &'static [&'static str] {
        match self {
            Self::Rgb => &["R", "G", "B"],
            Self::Xyz => &["X", "Y", "Z"],
            Self::LuminanceChroma => &["Y", "RY", "BY"],
            Self::Grey => &["Y"],
        }
    }
}

/// Attributes on display or origin of an image, which are not applied.
const NOT_APPLIED: [(&str, &str); 3] = [
    ("renderingTransform", "light is not rendered for a display"),
    ("lookModTransform", "light is not rendered for a display"),
    ("originalDataWindow", "the image is a part of that, and taken as a whole"),
];
/// Attributes by which programs name colour spaces.
const NAMES_OF_SPACES: [&str; 3] = ["oiio:ColorSpace", "colorSpace", "color_space"];

/// Linear light of a file that holds an image.
///
/// # Errors
///
/// Colours that are not linear light, or have no meaning.
pub fn of_exr(image: ExrImage) -> Result<LinearImage, Invalid> {
    let colours = Colours::of(&image)?;
    let pixel_aspect = image.pixel_aspect();
    let white_luminance_nit = image.number("whiteLuminance").filter(|nit| nit.is_finite() && *nit > 0.0);
    let mapping = match image.attribute("envmap").and_then(Attribute::other) {
        Some(AttributeValue::EnvironmentMap(EnvironmentMap::LatitudeLongitude)) => Mapping::LatitudeLongitude,
        Some(AttributeValue::EnvironmentMap(EnvironmentMap::Cube)) => Mapping::Cube,
        Some(_) | None => Mapping::Unstated,
    };
    let mut warnings = image.warnings.clone();
    warnings.extend(not_applied(&image, &colours));
    let [width, height] = [image.planes.width(), image.planes.height()];
    let mut others = image.planes.into_channels();
    let Some((kind, layer)) = kind_and_layer(&others) else {
        let planes = Planes::new(width, height, others)?;
        return Ok(LinearImage { planes, components: 0, pixel_aspect, white_luminance_nit, mapping, warnings });
    };
    if !layer.is_empty() {
        warnings.push(format!("the image is its layer {}", layer.trim_end_matches('.')));
    }
    let mut chosen = Vec::new();
    for name in kind.names() {
        if let Some(i) = others.iter().position(|channel| channel.name == format!("{layer}{name}")) {
            chosen.push(others.remove(i).data);
        }
    }
    // Opaque pixels lose nothing.
    others.retain(|channel| channel.name != format!("{layer}A") || channel.data.iter().any(|&a| a != 1.0));
    if kind == Kind::Xyz && !colours.is_xyz {
        warnings.push("its X, Y and Z are taken to be relative to D65".to_owned());
    }
    let planes: Vec<Channel> = names_of_result(kind).iter().zip(colours.srgb(kind, chosen)?).map(named).collect();
    let components = planes.len();
    let planes = Planes::new(width, height, planes.into_iter().chain(others).collect())?;
    Ok(LinearImage { planes, components, pixel_aspect, white_luminance_nit, mapping, warnings })
}

fn names_of_result(kind: Kind) -> &'static [&'static str] {
    if kind == Kind::Grey { &["Y"] } else { &["R", "G", "B"] }
}

fn named((name, data): (&&str, Vec<f32>)) -> Channel {
    Channel { name: (*name).to_owned(), data }
}

/// Kind of the channels, and the prefix of their names: nothing, or the name of the only layer of colours or grey.
fn kind_and_layer(channels: &[Channel]) -> Option<(Kind, String)> {
    let holds = |layer: &str, kind: Kind| {
        kind.names().iter().all(|name| channels.iter().any(|channel| channel.name == format!("{layer}{name}")))
    };
    let kind_of = |layer: &str| Kind::ALL.into_iter().find(|kind| holds(layer, *kind));
    if let Some(kind) = kind_of("") {
        return Some((kind, String::new()));
    }
    let mut layers: Vec<&str> = channels.iter().filter_map(|c| Some(&c.name[..=c.name.rfind('.')?])).collect();
    layers.dedup();
    // Normals and positions have X, Y and Z, too.
    let of_colours = layers.into_iter().filter_map(|layer| Some((kind_of(layer)?, layer.to_owned())));
    let mut of_colours = of_colours.filter(|(kind, _)| *kind != Kind::Xyz);
    let first = of_colours.next()?;
    of_colours.next().is_none().then_some(first)
}

/// Colours as the header states them.
struct Colours {
    /// Chromaticities of R, G and B; `None` for sRGB.
    chromaticities: Option<Chromaticities>,
    /// Whether X, Y and Z are relative to D65.
    is_xyz: bool,
    warning: Option<String>,
}

impl Colours {
    fn of(image: &ExrImage) -> Result<Self, Invalid> {
        let stated = image.attribute("chromaticities");
        let stated = if let Some(Attribute::Chromaticities(points)) = stated { Some(*points) } else { None };
        let is_xyz = image.text("colorSpace") == Some(ColourSpace::Xyz.name());
        let plain = Self { chromaticities: stated, is_xyz, warning: None };
        if let Some(id) = image.text("colorInteropID") {
            return match Interop::of(id) {
                Interop::Linear(points) => {
                    let warning = stated.filter(|stated| !are_alike(*stated, points)).map(|_| {
                        format!("its chromaticities are not those of its colorInteropID, {id}, which is used")
                    });
                    Ok(Self { chromaticities: Some(points), warning, ..plain })
                }
                Interop::Xyz => Ok(Self { is_xyz: true, ..plain }),
                Interop::Unknown => Ok(plain),
                Interop::Other => Err(Invalid::new("colorInteropID", format!("{id:?} is no linear light of colours"))
                    .help("convert the image to lin_rec709_scene first")),
            };
        }
        let is_aces =
            image.attribute("acesImageContainerFlag").and_then(Attribute::other) == Some(&AttributeValue::I32(1));
        Ok(if is_aces && stated.is_none() { Self { chromaticities: Some(ACES), ..plain } } else { plain })
    }

    /// Linear sRGB, or grey, of the channels of a kind.
    fn srgb(&self, kind: Kind, planes: Vec<Vec<f32>>) -> Result<Vec<Vec<f32>>, Invalid> {
        let of_rgb = || self.chromaticities.map_or(Ok(DMat3::IDENTITY), to_srgb);
        match kind {
            Kind::Grey => Ok(planes),
            Kind::Rgb if self.is_xyz => Ok(converted(planes, |xyz| ColourSpace::Srgb.to_xyz().inverse() * xyz)),
            Kind::Rgb => {
                let to_srgb = of_rgb()?;
                let is_srgb = to_srgb == DMat3::IDENTITY;
                Ok(if is_srgb { planes } else { converted(planes, |rgb| to_srgb * rgb) })
            }
            Kind::Xyz => {
                let to_srgb = ColourSpace::Srgb.to_xyz().inverse();
                Ok(converted(planes, |xyz| to_srgb * xyz))
            }
            Kind::LuminanceChroma => {
                let points = self.chromaticities.unwrap_or(ColourSpace::Srgb.chromaticities());
                let (weights, to_srgb) = (luminance_weights(points)?, of_rgb()?);
                Ok(converted(planes, |ycc| {
                    let (r, b) = ((ycc.y + 1.0) * ycc.x, (ycc.z + 1.0) * ycc.x);
                    to_srgb * DVec3::new(r, (ycc.x - weights.x * r - weights.z * b) / weights.y, b)
                }))
            }
        }
    }
}

/// Three channels after a conversion of each pixel. Values that are not finite stay as they are: where one component is
/// infinite, a matrix would turn all of them into NaN.
pub(super) fn converted(mut planes: Vec<Vec<f32>>, convert: impl Fn(DVec3) -> DVec3 + Sync) -> Vec<Vec<f32>> {
    if let [x, y, z] = &mut planes[..] {
        x.par_iter_mut().zip(y).zip(z).for_each(|((x, y), z)| {
            let before = [*x, *y, *z];
            if before.iter().all(|value| value.is_finite()) {
                [*x, *y, *z] = convert(DVec3::from_array(before.map(f64::from))).to_array().map(|value| value as f32);
            }
        });
    }
    planes
}

/// Statements of the header that are not applied.
fn not_applied(image: &ExrImage, colours: &Colours) -> Vec<String> {
    let mut said: Vec<String> = colours.warning.iter().cloned().collect();
    let white = colours.chromaticities.unwrap_or(ColourSpace::Srgb.chromaticities())[3];
    if let Some(AttributeValue::FloatVec2(Vec2(x, y))) = image.attribute("adoptedNeutral").and_then(Attribute::other)
        && [*x, *y].iter().zip(white).any(|(stated, white)| (f64::from(*stated) - white).abs() > 1e-3)
    {
        said.push(format!("its adoptedNeutral ({x}, {y}) is left out: white is that of its chromaticities"));
    }
    let present = NOT_APPLIED.iter().filter(|(name, _)| image.attribute(name).is_some());
    said.extend(present.map(|(name, why)| format!("its {name} is left out: {why}")));
    if colours.chromaticities.is_none() && !colours.is_xyz && image.attribute("colorInteropID").is_none() {
        let stated = NAMES_OF_SPACES.iter().filter_map(|name| Some((name, image.text(name)?)));
        let unknown = stated.filter(|(_, space)| !is_name_of_srgb(space));
        said.extend(unknown.map(|(name, space)| {
            format!("its {name} {space:?} is not known here: it is taken for linear sRGB; state chromaticities")
        }));
    }
    said
}

/// Whether a name of a colour space means the default of a file without one.
fn is_name_of_srgb(name: &str) -> bool {
    let plain: String = name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect();
    ["srgb", "linear", "linearsrgb", "linrec709", "linrec709scene", "linearrec709", "linearrec709srgb", "lin709"]
        .contains(&&plain[..])
}
