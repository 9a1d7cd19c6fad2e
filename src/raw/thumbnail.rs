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
    let tile = if raw.cfa.is_full() { 1 } else { tile_width.max(tile_height) };
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

/// Mean colour of a block of pixels, as far as it lies in the picture. Colours that the camera does not tell apart are
/// shown grey.
fn block_colour(raw: &RawImage, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> [u8; 3] {
    let channels = raw.cfa.channels();
    let samples = raw.cfa.samples_per_pixel();
    let mut sums = vec![0.0; channels.len()];
    let mut counts = vec![0u32; channels.len()];
    for y in rows.start..rows.end.min(raw.height) {
        for x in columns.start * samples..columns.end.min(raw.width) * samples {
            let channel = raw.cfa.channel_at(x, y);
            sums[channel] += f64::from(raw.data[y * raw.row_length() + x]) - f64::from(raw.black_level_dn.at(x, y));
            counts[channel] += 1;
        }
    }
    let range = f64::from((f32::from(raw.white_level_dn) - raw.black_level_dn.mean()).max(1.0));
    let neutral = raw.metadata.as_shot_neutral.as_deref().unwrap_or_default();
    let balanced = |channel: usize| {
        let balance = neutral.get(channel).map_or(1.0, |component| component.max(1e-6));
        sums[channel] / f64::from(counts[channel].max(1)) / range / balance
    };
    let grey = (0..channels.len()).map(balanced).sum::<f64>() / channels.len() as f64;
    ["R", "G", "B"].map(|colour| {
        let all = ["R", "G", "B"].iter().all(|colour| channels.iter().any(|name| name == colour));
        let channel = channels.iter().position(|name| all && name == colour);
        let linear = channel.map_or(grey, balanced);
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
        // 255 · 0.25^(1/2.2) = 135.8
        for (width, height, cfa, small) in [
            (1000, 500, "RGGB", (250, 125)),
            (1, 1, "mono", (1, 1)),
            (3, 2, "GBRG", (1, 1)),
            (2000, 1, "mono", (250, 1)),
            (600, 300, "full:RGB", (200, 100)),
            (600, 300, "x-trans", (100, 50)),
            (600, 300, "cygm", (150, 75)),
        ] {
            let thumbnail = thumbnail(&grey(width, height, cfa));
            assert_eq!((thumbnail.width, thumbnail.height), small);
            assert!(thumbnail.rgb.iter().all(|&v| v == 136), "{width} × {height} {cfa}: {:?}", &thumbnail.rgb[..3]);
        }
    }
}
