//! A small picture for file browsers: the mosaic averaged over blocks, white-balanced and brightened. It shows what is
//! in the file; development proper is [`develop`](crate::develop)'s.

use super::RawImage;

/// Longest side of a thumbnail, pixels.
const LONGEST_SIDE: usize = 256;

/// 8-bit RGB, row by row.
pub(super) struct Thumbnail {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) rgb: Vec<u8>,
}

/// The thumbnail of a picture that has pixels.
pub(super) fn thumbnail(raw: &RawImage) -> Thumbnail {
    let (tile_width, tile_height) = raw.cfa.tile_size();
    let tile = tile_width.max(tile_height);
    // Blocks of whole tiles, so that each holds every channel; the edge pixels that are left over are not shown.
    let block = raw.width.max(raw.height).div_ceil(LONGEST_SIDE * tile) * tile;
    let (width, height) = ((raw.width / block).max(1), (raw.height / block).max(1));
    let mut rgb = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for x in 0..width {
            rgb.extend(block_colour(raw, x * block..(x + 1) * block, y * block..(y + 1) * block));
        }
    }
    Thumbnail { width, height, rgb }
}

/// Mean colour of a block of pixels, as far as it lies in the picture.
fn block_colour(raw: &RawImage, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> [u8; 3] {
    let mut sums = [0.0; 3];
    let mut counts = [0u32; 3];
    for y in rows.start..rows.end.min(raw.height) {
        for x in columns.start..columns.end.min(raw.width) {
            let channel = raw.cfa.channel_at(x, y);
            sums[channel] += f64::from(raw.data[y * raw.width + x]) - f64::from(raw.black_level_dn.at(x, y));
            counts[channel] += 1;
        }
    }
    let range = f64::from((f32::from(raw.white_level_dn) - raw.black_level_dn.mean()).max(1.0));
    let neutral = raw.metadata.as_shot_neutral.as_deref().unwrap_or(&[1.0; 3]);
    std::array::from_fn(|component| {
        let channel = if raw.cfa.is_mono() { 0 } else { component };
        let balance = if raw.cfa.is_mono() { 1.0 } else { neutral[component].max(1e-6) };
        let linear = sums[channel] / f64::from(counts[channel].max(1)) / range / balance;
        (255.0 * linear.clamp(0.0, 1.0).powf(1.0 / 2.2)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raw::Cfa;

    fn grey(width: usize, height: usize, cfa: &str) -> RawImage {
        RawImage {
            width,
            height,
            data: vec![1024; width * height],
            cfa: Cfa::parse(cfa).expect("known"),
            bits: 12,
            black_level_dn: 24.into(),
            white_level_dn: 4024,
            ..RawImage::default()
        }
    }

    #[test]
    fn it_keeps_size_and_level() {
        // 255 · 0.25^(1/2.2) = 135.8
        for (width, height, cfa, small) in [
            (1000, 500, "RGGB", (250, 125)),
            (1, 1, "mono", (1, 1)),
            (3, 2, "GBRG", (1, 1)),
            (2000, 1, "mono", (250, 1)),
        ] {
            let thumbnail = thumbnail(&grey(width, height, cfa));
            assert_eq!((thumbnail.width, thumbnail.height), small);
            assert!(thumbnail.rgb.iter().all(|&v| v == 136), "{width} × {height} {cfa}: {:?}", &thumbnail.rgb[..3]);
        }
    }
}
