//! Images on surfaces: bitmaps, wrap modes, filters, UV transforms.
//!
//! In: decoded images and a point in UV space, u to the right and v down from the top-left corner of the image
//! (glTF). Out: four numbers, linear. What they mean (a colour, a roughness, a normal) is left to whoever asks; turning
//! colours into spectra is left to [`spectrum::upsampling`](photosite_core::spectrum::upsampling).
//!
//! There are no maps of several sizes. Paths pass a pixel at places all over its area and the lens at places all over
//! its opening, so that their mean is the integral of the texture over what the pixel sees of it, which mip maps blur.
//! What an average of texels would look like need not be what the average of their spectra does.

mod bitmap;
pub(crate) mod packed;
mod sampler;
mod transform;

use std::sync::Arc;

use glam::{Affine2, Vec2};

pub use bitmap::{Bitmap, Texels};
pub use sampler::{Filter, SamplerSettings, Wrap};
pub use transform::UvTransform;

/// Texture: an image with everything needed to look it up at a point of a surface.
#[derive(Clone, Debug)]
pub struct Texture {
    image: Arc<Bitmap>,
    sampler: SamplerSettings,
    /// Surface UV → image UV.
    transform: Affine2,
    /// Index of the mesh's UV set that is looked up.
    pub uv_set: u32,
}

impl Texture {
    /// An image that is looked up through `transform` and `sampler` in a UV set of the mesh.
    ///
    /// # Panics
    /// If the image does not pass [`Bitmap::check`]; those that the readers make do.
    pub fn new(image: Arc<Bitmap>, sampler: SamplerSettings, transform: UvTransform, uv_set: u32) -> Self {
        if let Err(problem) = image.check() {
            panic!("{problem}");
        }
        Self { image, sampler, transform: transform.to_affine(), uv_set }
    }

    /// Wrap modes and filter.
    pub(crate) fn sampler(&self) -> SamplerSettings {
        self.sampler
    }

    /// Transform from the UV of the surface to that of the image.
    pub(crate) fn transform(&self) -> Affine2 {
        self.transform
    }

    /// Image of the texture.
    pub fn image(&self) -> &Bitmap {
        &self.image
    }

    /// RGBA at `uv` of the surface as stored, 0–1 for integer texels: roughness, normals, masks. Never fails: UVs that
    /// are no numbers count as 0.
    #[inline]
    pub fn sample_rgba_linear(&self, uv: Vec2) -> [f32; 4] {
        let taps = self.sampler.taps(self.transform.transform_point2(uv), self.image.width, self.image.height);
        self.image.mix_linear(&taps).to_array()
    }

    /// RGBA at `uv` of the surface with R, G, B decoded from sRGB before they are mixed: colours. Alpha is linear in
    /// any case, and so are images of floats.
    #[inline]
    pub fn sample_rgba_srgb(&self, uv: Vec2) -> [f32; 4] {
        let taps = self.sampler.taps(self.transform.transform_point2(uv), self.image.width, self.image.height);
        self.image.mix_srgb(&taps).to_array()
    }
}

#[cfg(test)]
mod tests {
    use glam::vec2;

    use super::*;
    use photosite_core::spectrum::rgb;

    fn texture(texels: Texels, [width, height]: [usize; 2], wrap: Wrap, filter: Filter) -> Texture {
        let image = Bitmap { name: "test".to_owned(), width, height, texels };
        let sampler = SamplerSettings { wrap: [wrap; 2], filter };
        Texture::new(Arc::new(image), sampler, UvTransform::default(), 0)
    }

    fn grey(values: &[u8]) -> Texels {
        Texels::Rgba8(values.iter().map(|&v| [v, v, v, 255]).collect())
    }

    /// White at the top left and bottom right, black elsewhere.
    fn checkerboard(wrap: Wrap, filter: Filter) -> Texture {
        texture(grey(&[255, 0, 0, 255]), [2, 2], wrap, filter)
    }

    fn red(texture: &Texture, u: f32, v: f32) -> f32 {
        texture.sample_rgba_linear(vec2(u, v))[0]
    }

    #[test]
    fn checkerboard_by_nearest_texel_under_every_wrap_mode() {
        // Along the top row v = 0.25, texels white, black; one period after the other to both sides.
        for (wrap, [far_left, left, right, far_right]) in [
            // … W B | W B | W B …
            (Wrap::Repeat, [1.0, 0.0, 1.0, 0.0]),
            // … B W | W B | B W …
            (Wrap::MirroredRepeat, [0.0, 1.0, 0.0, 1.0]),
            // … W W | W B | B B …
            (Wrap::ClampToEdge, [1.0, 1.0, 0.0, 0.0]),
        ] {
            let board = checkerboard(wrap, Filter::Nearest);
            for (u, expected) in
                [(-0.75, far_left), (-0.25, left), (0.25, 1.0), (0.75, 0.0), (1.25, right), (1.75, far_right)]
            {
                assert_eq!(red(&board, u, 0.25), expected, "{wrap:?} u = {u}");
                // The board is symmetric, so the left column is the same along v.
                assert_eq!(red(&board, 0.25, u), expected, "{wrap:?} v = {u}");
            }
        }
    }

    #[test]
    fn checkerboard_bilinear_under_every_wrap_mode() {
        // The top row at v = 0.25 is exactly its texels; their centres are at u = 0.25 and 0.75.
        for (wrap, at_left_border, at_right_border, at_minus_an_eighth) in [
            // At the border the neighbour is black, half-way: ½. At −⅛: ¾ texel from the white centre.
            (Wrap::Repeat, 0.5, 0.5, 0.25),
            // The neighbour is the same texel mirrored.
            (Wrap::MirroredRepeat, 1.0, 0.0, 1.0),
            (Wrap::ClampToEdge, 1.0, 0.0, 1.0),
        ] {
            let board = checkerboard(wrap, Filter::Linear);
            for (u, expected) in [
                (0.0, at_left_border),
                (1.0, at_right_border),
                (-0.125, at_minus_an_eighth),
                (0.25, 1.0),
                (0.375, 0.75),
                (0.5, 0.5),
                (0.75, 0.0),
            ] {
                assert!((red(&board, u, 0.25) - expected).abs() < 1e-6, "{wrap:?} u = {u}");
                assert!((red(&board, 0.25, u) - expected).abs() < 1e-6, "{wrap:?} v = {u}");
            }
            // The centre is where all four meet.
            assert!((red(&board, 0.5, 0.5) - 0.5).abs() < 1e-6);
        }
    }

    #[test]
    fn wrap_modes_are_per_axis() {
        let mut board = checkerboard(Wrap::Repeat, Filter::Nearest);
        board.sampler.wrap = [Wrap::ClampToEdge, Wrap::Repeat];
        assert_eq!(red(&board, 5.25, 0.25), 0.0);
        assert_eq!(red(&board, 0.25, 5.25), 1.0);
    }

    #[test]
    fn top_left_is_the_origin() {
        let image = texture(grey(&[0, 51, 102, 153, 204, 255]), [3, 2], Wrap::Repeat, Filter::Nearest);
        for (u, v, expected) in [(0.1, 0.1, 0.0), (0.9, 0.1, 102.0), (0.1, 0.9, 153.0), (0.9, 0.9, 255.0)] {
            assert!((red(&image, u, v) * 255.0 - expected).abs() < 1e-4, "{u} {v}");
        }
    }

    #[test]
    fn odd_uvs_give_a_texel_all_the_same() {
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e30, -1e-30, -1e9, 16_777_217.0];
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for filter in [Filter::Nearest, Filter::Linear] {
                for size in [[1, 1], [2, 3], [5, 1]] {
                    let texels = grey(&vec![128; size[0] * size[1]]);
                    let image = texture(texels, size, wrap, filter);
                    for (u, v) in odd.iter().flat_map(|&u| odd.map(|v| (u, v))) {
                        let value = red(&image, u, v);
                        assert!((value * 255.0 - 128.0).abs() < 1e-4, "{wrap:?} {filter:?} {u} {v}: {value}");
                    }
                }
            }
        }
    }

    #[test]
    fn colours_are_decoded_before_they_are_mixed_and_alpha_never() {
        let half = Texels::Rgba8(vec![[0, 0, 0, 0], [255, 188, 255, 128]]);
        let image = texture(half, [2, 1], Wrap::ClampToEdge, Filter::Linear);
        let [r, g, b, a] = image.sample_rgba_srgb(vec2(0.5, 0.5));
        assert!((r - 0.5).abs() < 1e-6 && (b - 0.5).abs() < 1e-6);
        assert!((g - 0.5 * rgb::decode(188.0 / 255.0)).abs() < 1e-6);
        assert!((a - 0.5 * 128.0 / 255.0).abs() < 1e-6);
        assert!((image.sample_rgba_linear(vec2(0.5, 0.5))[1] - 0.5 * 188.0 / 255.0).abs() < 1e-6);
    }

    #[test]
    fn sixteen_bits_and_floats_agree_with_eight_bits() {
        let eight = texture(Texels::Rgba8(vec![[10, 100, 200, 50]]), [1, 1], Wrap::Repeat, Filter::Linear);
        // 65535 = 255 · 257, so these are the same numbers.
        let wide = [10u16, 100, 200, 50].map(|v| v * 257);
        let sixteen = texture(Texels::Rgba16(vec![wide]), [1, 1], Wrap::Repeat, Filter::Linear);
        let uv = vec2(0.3, 0.6);
        for (a, b) in eight.sample_rgba_srgb(uv).into_iter().zip(sixteen.sample_rgba_srgb(uv)) {
            assert!((a - b).abs() < 1e-7);
        }
        let float = texture(Texels::Rgb32F(vec![[3.0, 0.5, 0.0]]), [1, 1], Wrap::Repeat, Filter::Nearest);
        assert_eq!(float.sample_rgba_srgb(uv), [3.0, 0.5, 0.0, 1.0]);
        assert_eq!(float.sample_rgba_linear(uv), [3.0, 0.5, 0.0, 1.0]);
    }

    #[test]
    fn images_of_the_wrong_size_are_refused() {
        for (width, height, count) in [(2, 2, 3), (0, 0, 0), (0, 5, 0), (usize::MAX, 2, 4)] {
            let image = Bitmap { name: "brick.png".to_owned(), width, height, texels: grey(&vec![0; count]) };
            assert!(image.check().expect_err("inconsistent").message.contains("brick.png"));
        }
    }
}
