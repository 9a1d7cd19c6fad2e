//! A small image for file browsers: the mosaic averaged over blocks, white-balanced, in sRGB as far as the matrix for
//! D65 knows. It shows what is in the file; development proper is `photosite-develop`'s.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{RawImage, RawMetadata};
use photosite_core::colour::{ColourSpace, Transfer};
use photosite_core::spectrum::{cie, illuminant};

/// 8-bit RGB, row by row.
pub(super) struct Thumbnail {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) rgb: Vec<u8>,
}

/// Thumbnail of a raw image that has pixels, of square pixels, at most `longest_side` along its longer side.
pub(super) fn thumbnail(raw: &RawImage, longest_side: usize) -> Thumbnail {
    let aspect = raw.metadata.pixel_aspect();
    let scale = [aspect.max(1.0), (1.0 / aspect).max(1.0)];
    let blocks = of_blocks(raw, ((longest_side as f64 / scale[0].max(scale[1])) as usize).max(1));
    if scale == [1.0; 2] { blocks } else { stretched(&blocks, scale) }
}

/// Stretches an image by these factors across and down, with linear interpolation.
fn stretched(from: &Thumbnail, scale: [f64; 2]) -> Thumbnail {
    let size = [from.width, from.height];
    let [width, height] = [0, 1].map(|axis| ((size[axis] as f64 * scale[axis]).round() as usize).max(1));
    // The pixel before a place and the one behind it, and how far it is on the way to that.
    let between = |i: usize, axis: usize| {
        let place = ((i as f64 + 0.5) / scale[axis] - 0.5).clamp(0.0, size[axis] as f64 - 1.0);
        (place as usize, (place as usize + 1).min(size[axis] - 1), place.fract())
    };
    let mut rgb = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        let (top, bottom, down) = between(y, 1);
        for x in 0..width {
            let (left, right, across) = between(x, 0);
            for c in 0..3 {
                let code = |x: usize, y: usize| f64::from(from.rgb[3 * (y * from.width + x) + c]);
                let row = |y: usize| code(left, y) + (code(right, y) - code(left, y)) * across;
                rgb.push((row(top) + (row(bottom) - row(top)) * down).round() as u8);
            }
        }
    }
    Thumbnail { width, height, rgb }
}

/// Thumbnail of block means; blocks are as wide as high in pixels of the raw image.
fn of_blocks(raw: &RawImage, longest_side: usize) -> Thumbnail {
    let (tile_width, tile_height) = raw.cfa.tile_size();
    let tile = if raw.cfa.is_full() { 1 } else { tile_width.max(tile_height) };
    // Blocks of whole tiles, so that each holds every channel; the edge pixels that are left over are not shown.
    let block = raw.width.max(raw.height).div_ceil(longest_side * tile) * tile;
    let (width, height) = ((raw.width / block).max(1), (raw.height / block).max(1));
    let mut rgb = vec![0; 3 * width * height];
    let colours = Colours::new(raw);
    rgb.par_chunks_exact_mut(3 * width).enumerate().for_each(|(y, row)| {
        let mut sums = vec![0.0; raw.cfa.channels().len() * width];
        let mut counts = vec![0u32; sums.len()];
        for y in (y * block..(y + 1) * block).take_while(|&y| y < raw.height) {
            add_row(raw, y, block, &mut sums, &mut counts);
        }
        let channels = raw.cfa.channels().len();
        let means = sums.chunks_exact(channels).zip(counts.chunks_exact(channels));
        for (to, (sums, counts)) in row.as_chunks_mut().0.iter_mut().zip(means) {
            *to = colours.of(sums, counts);
        }
    });
    Thumbnail { width, height, rgb }
}

/// Adds the signal of a row's pixels to their blocks' sums, channel by channel.
fn add_row(raw: &RawImage, y: usize, block: usize, sums: &mut [f32], counts: &mut [u32]) {
    let (channels, samples) = (raw.cfa.channels().len(), raw.cfa.samples_per_pixel());
    let period = raw.cfa.tile_size().0;
    let of_column: Vec<usize> = (0..period).map(|x| raw.cfa.channel_at(x, y)).collect();
    let uniform = raw.black_level_dn.as_uniform();
    let numbers = &raw.data[y * raw.row_length()..][..raw.row_length()];
    let blocks = sums.chunks_exact_mut(channels).zip(counts.chunks_exact_mut(channels));
    for (i, ((sums, counts), numbers)) in blocks.zip(numbers.chunks(block * samples)).enumerate() {
        let first = i * block * samples;
        let mut place = first % period;
        for (x, &dn) in numbers.iter().enumerate() {
            let channel = of_column[place];
            place = if place + 1 == period { 0 } else { place + 1 };
            sums[channel] += f32::from(dn) - uniform.unwrap_or_else(|| raw.black_level_dn.at(first + x, y));
            counts[channel] += 1;
        }
    }
}

/// Conversion of the sums of a block into a colour.
struct Colours {
    /// DN from black to white times the response to white, per channel.
    full: Vec<f32>,
    /// Channels red, green and blue, with the matrix from them to linear sRGB. `None` for other filters: colours that
    /// cannot be told apart so easily are shown grey.
    rgb: Option<([usize; 3], DMat3)>,
}

impl Colours {
    fn new(raw: &RawImage) -> Self {
        let channels = raw.cfa.channels();
        let range = |channel: usize| (f32::from(raw.white_of(channel)) - raw.black_level_dn.mean()).max(1.0);
        let neutral = raw.metadata.as_shot_neutral.as_deref().unwrap_or_default();
        let full = |channel: usize| {
            range(channel) * neutral.get(channel).map_or(1.0, |component: &f64| component.max(1e-6)) as f32
        };
        let places = ["R", "G", "B"].map(|colour| channels.iter().position(|name| name == colour));
        let rgb = if let [Some(r), Some(g), Some(b)] = places {
            let matrix = if channels.len() == 3 { camera_to_srgb(&raw.metadata) } else { None };
            Some(([r, g, b], matrix.unwrap_or(DMat3::IDENTITY)))
        } else {
            None
        };
        Self { full: (0..channels.len()).map(full).collect(), rgb }
    }

    fn of(&self, sums: &[f32], counts: &[u32]) -> [u8; 3] {
        // Beyond white nothing is known of the colour.
        let mean = |c: usize| f64::from(sums[c] / counts[c].max(1) as f32 / self.full[c]).min(1.0);
        let linear = match self.rgb {
            Some((channels, matrix)) => matrix * DVec3::from_array(channels.map(mean)),
            None => DVec3::splat((0..sums.len()).map(mean).sum::<f64>() / sums.len() as f64),
        };
        linear.to_array().map(|v| (255.0 * Transfer::Srgb.encode(v.clamp(0.0, 1.0) as f32)).round() as u8)
    }
}

/// White-balanced R, G, B → linear sRGB by the matrix for D65; `None` where there is none.
fn camera_to_srgb(metadata: &RawMetadata) -> Option<DMat3> {
    let rows: &[[f64; 3]; 3] = metadata.colour_matrix_d65()?.as_slice().try_into().ok()?;
    let from_xyz = DMat3::from_cols_array_2d(rows).transpose();
    let white = DVec3::from_array(cie::xyz(illuminant::d65()));
    let white = white / white.y;
    let matrix = ColourSpace::Srgb.from_xyz(white) * from_xyz.inverse() * DMat3::from_diagonal(from_xyz * white);
    matrix.is_finite().then_some(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_pixels_are_shown_square() {
        // A ramp of columns, 16.6 × 12.4.
        let metadata = RawMetadata { pixel_pitch_m: Some([16.6e-6, 12.4e-6]), ..RawMetadata::default() };
        let data = (0..60 * 40).map(|i| (i % 60) * 1000).collect();
        let raw = RawImage { width: 60, height: 40, data, metadata, ..RawImage::default() };
        let shown = thumbnail(&raw, 1024);
        assert_eq!((shown.width, shown.height, shown.rgb.len()), (80, 40, 3 * 80 * 40));
        let square = thumbnail(&RawImage { metadata: RawMetadata::default(), ..raw.clone() }, 1024);
        for x in 0..80 {
            // Where it lies on the ramp, between the codes of its neighbours.
            let place = ((x as f64 + 0.5) * 12.4 / 16.6 - 0.5).clamp(0.0, 59.0);
            let code = |i: usize| f64::from(square.rgb[3 * i.min(59)]);
            let wanted = code(place as usize) + (code(place as usize + 1) - code(place as usize)) * place.fract();
            assert!((f64::from(shown.rgb[3 * x]) - wanted).abs() <= 0.5 + 1e-9, "{x}");
        }
        assert!(thumbnail(&raw, 30).width <= 30);
    }
    use crate::Cfa;

    fn grey(width: usize, height: usize, cfa: &str) -> RawImage {
        RawImage {
            width,
            height,
            data: vec![1024; width * height * Cfa::parse(cfa).expect("known").samples_per_pixel()],
            cfa: Cfa::parse(cfa).expect("known"),
            bits: 12,
            black_level_dn: 24.into(),
            white_level_dn: 4024,
            ..RawImage::default()
        }
    }

    #[test]
    fn it_keeps_size_and_level() {
        // 255 · (1.055 · 0.25^(1/2.4) − 0.055) = 136.96
        for (width, height, cfa, small) in [
            (1000, 500, "RGGB", (250, 125)),
            (1, 1, "mono", (1, 1)),
            (3, 2, "GBRG", (1, 1)),
            (2000, 1, "mono", (250, 1)),
            (600, 300, "full:RGB", (200, 100)),
            (600, 300, "x-trans", (100, 50)),
            (600, 300, "cygm", (150, 75)),
        ] {
            let thumbnail = thumbnail(&grey(width, height, cfa), 256);
            assert_eq!((thumbnail.width, thumbnail.height), small);
            assert!(thumbnail.rgb.iter().all(|&v| v == 137), "{width} × {height} {cfa}: {:?}", &thumbnail.rgb[..3]);
        }
    }
}
