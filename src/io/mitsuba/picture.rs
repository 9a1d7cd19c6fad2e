//! Pictures as Mitsuba is to see them: linear, in EXR files.

use crate::image::{Channel, Planes};
use crate::scene::description::TextureDescription;
use crate::texture::{Bitmap, Filter, Texels, Wrap};

use super::{Element, Output};

/// Planes of a picture, one value per texel.
pub(super) fn planes(image: &Bitmap, names: &[&str], texel: impl Fn(usize) -> [f32; 3]) -> Planes {
    let texels: Vec<[f32; 3]> = (0..image.width * image.height).map(texel).collect();
    let channel = |(i, name): (usize, &&str)| Channel {
        name: (*name).to_owned(),
        data: texels.iter().map(|texel| texel[i]).collect(),
    };
    let channels = names.iter().enumerate().map(channel).collect();
    Planes::new(image.width, image.height, channels).expect("every plane has one value per texel")
}

/// Colours of an environment picture for Mitsuba, whose first and last rows lie at the poles, where ours lie half a row
/// from them: twice as many rows, so that both interpolate alike, as linear functions between the same points.
pub(super) fn panorama(image: &Bitmap) -> Planes {
    let (width, height) = (image.width, image.height);
    let colour = |x: usize, y: usize| match &image.texels {
        Texels::Rgb32F(texels) => texels[y * width + x],
        Texels::Rgba8(_) | Texels::Rgba16(_) => {
            let [r, g, b, _] = image.srgb_texel(y * width + x);
            [r, g, b]
        }
    };
    // Row j lies at j/(2·height) of the way down: odd rows are centres of ours, even ones lie between two.
    let row = |j: usize| [j.saturating_sub(1) / 2, (j / 2).min(height - 1)];
    let tall = Bitmap { name: image.name.clone(), width, height: 2 * height + 1, texels: Texels::Rgb32F(Vec::new()) };
    planes(&tall, &["R", "G", "B"], |i| {
        let [above, below] = row(i / width).map(|y| colour(i % width, y));
        [0, 1, 2].map(|c| 0.5 * (above[c] + below[c]))
    })
}

/// A `bitmap` texture of a file, looked up as the description says. Its UV transform is in the mesh already.
pub(super) fn bitmap(tag_name: &str, file: &str, raw: bool, t: &TextureDescription, out: &mut Output) -> Element {
    let [u, v] = t.sampler.wrap;
    if u != v {
        out.approximate("wrap modes that differ in u and v: that of u serves both");
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
