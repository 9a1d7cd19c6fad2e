//! Images as Mitsuba is to see them: linear, in EXR files.

use glam::{Vec3, Vec4};

use photosite_core::image::{Channel, Planes};
use photosite_transport::scene::description::TextureDescription;
use photosite_transport::texture::{Bitmap, Filter, Texels, Wrap};

use super::difference::Difference;
use super::element::Element;
use super::output::Output;

/// Planes of an image, one value per texel.
pub(super) fn planes(image: &Bitmap, names: &[&str], texel: impl Fn(usize) -> [f32; 3]) -> Planes {
    let texels: Vec<[f32; 3]> = (0..image.width * image.height).map(texel).collect();
    let channel = |(i, name): (usize, &&str)| Channel {
        name: (*name).to_owned(),
        data: texels.iter().map(|texel| texel[i]).collect(),
    };
    let channels = names.iter().enumerate().map(channel).collect();
    Planes::new(image.width, image.height, channels).expect("every plane has one value per texel")
}

/// Largest number of texels of an exported environment map where its colours call for more of them than the image has.
const MOST_TEXELS: usize = 1 << 23;

/// Colours of an environment map for Mitsuba, whose first and last rows lie at the poles, where those of photosite lie
/// half a row from them: an even multiple of the rows and an odd one of the columns, so that the original texels are
/// among them and both interpolate alike, as linear functions between the same points. Between texels photosite mixes
/// RGB and Mitsuba spectra; where that matters, `finer` makes the steps short.
pub(super) fn panorama(image: &Bitmap, finer: bool) -> Planes {
    let (width, height) = (image.width, image.height);
    let colour = |x: usize, y: usize| match &image.texels {
        Texels::Rgb32F(texels) => Vec3::from(texels[y * width + x]),
        Texels::Rgba8(_) | Texels::Rgba16(_) => Vec4::from(image.srgb_texel(y * width + x)).truncate(),
    };
    let steps = [7, 5, 3].into_iter().find(|n| finer && n * (n + 1) * width * height <= MOST_TEXELS).unwrap_or(1);
    let fine = Bitmap {
        name: image.name.clone(),
        width: steps * width,
        height: (steps + 1) * height + 1,
        texels: Texels::Rgb32F(Vec::new()),
    };
    // The columns or rows on both sides of a place in texels, and how far it is from one to the other.
    let between = |place: f32| ((place - 0.5).floor(), (place - 0.5).rem_euclid(1.0));
    planes(&fine, &["R", "G", "B"], |i| {
        let (left, right_part) = between(((i % fine.width) as f32 + 0.5) / steps as f32);
        let (above, below_part) = between((i / fine.width) as f32 / (steps + 1) as f32);
        let column = |x: f32| x.rem_euclid(width as f32) as usize;
        let row = |y: f32| (y.max(0.0) as usize).min(height - 1);
        let along = |y: f32| colour(column(left), row(y)).lerp(colour(column(left + 1.0), row(y)), right_part);
        along(above).lerp(along(above + 1.0), below_part).to_array()
    })
}

/// Whether all texels of an environment map have one colour, and differ in brightness at most.
pub(super) fn is_of_one_colour(image: &Bitmap) -> bool {
    let texels = (0..image.width * image.height).map(|i| match &image.texels {
        Texels::Rgb32F(texels) => Vec3::from(texels[i]),
        Texels::Rgba8(_) | Texels::Rgba16(_) => Vec4::from(image.srgb_texel(i)).truncate(),
    });
    let mut colours = texels.filter(|texel| *texel != Vec3::ZERO).map(|texel| texel / texel.max_element());
    let first = colours.next().unwrap_or(Vec3::ONE);
    colours.all(|colour| colour.abs_diff_eq(first, 1e-4))
}

/// Texture `bitmap` of a file, looked up as the description says. Its UV transform is in the mesh already.
pub(super) fn bitmap(tag_name: &str, file: &str, raw: bool, t: &TextureDescription, out: &mut Output) -> Element {
    let [u, v] = t.sampler.wrap;
    if u != v {
        out.approximate(Difference::WrapModes);
    }
    Element::object("texture", "bitmap")
        .named(tag_name)
        .string("filename", file)
        .boolean("raw", raw)
        .string(
            "filter_type",
            match t.sampler.filter {
                Filter::Nearest => "nearest",
                Filter::Linear => "bilinear",
            },
        )
        .string(
            "wrap_mode",
            match u {
                Wrap::Repeat => "repeat",
                Wrap::MirroredRepeat => "mirror",
                Wrap::ClampToEdge => "clamp",
            },
        )
}
