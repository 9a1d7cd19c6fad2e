//! Encoding: linear values become 8-bit sRGB for display.

use rayon::prelude::*;

use crate::image::Planes;
use crate::spectrum::rgb;

/// A picture for display: sRGB-encoded, 8 bits, rows from the top, components interleaved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture8 {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// 1 for grey, 3 for red, green, blue.
    pub components: usize,
    /// width × height × components values.
    pub data: Vec<u8>,
}

/// Encodes linear planes, 1 or 3 of them with white at 1: each value becomes the nearest of the 256 codes of the sRGB
/// transfer function ([Srgb](crate::references#srgb)), clipped to 0–1 first. Not-a-number becomes black.
pub fn encode_srgb(linear: &Planes) -> Picture8 {
    let encoder = Encoder::new();
    let (width, height, components) = (linear.width(), linear.height(), linear.channels().len());
    let mut data = vec![0; width * height * components];
    data.par_chunks_mut((width * components).max(1)).enumerate().for_each(|(y, row)| {
        for (component, channel) in linear.channels().iter().enumerate() {
            let values = &channel.data[y * width..(y + 1) * width];
            for (code, &value) in row[component..].iter_mut().step_by(components).zip(values) {
                *code = encoder.code(value);
            }
        }
    });
    Picture8 { width, height, components, data }
}

/// The transfer function by look-up: no power a pixel.
struct Encoder {
    /// Linear value from which on a code is used, for codes 0–255, and a last one that none reaches.
    threshold: [f32; 257],
    /// Code at the lower end of each of 4096 equal intervals of 0–1, and at 1.
    start: [u8; Self::INTERVALS + 1],
}

impl Encoder {
    const INTERVALS: usize = 4096;

    fn new() -> Self {
        // No value reaches not-a-number.
        let mut threshold = [f32::NAN; 257];
        threshold[0] = f32::NEG_INFINITY;
        for (code, threshold) in threshold.iter_mut().enumerate().take(256).skip(1) {
            *threshold = rgb::decode((code as f32 - 0.5) / 255.0);
        }
        let start = std::array::from_fn(|i| {
            let value = i as f32 / Self::INTERVALS as f32;
            (threshold.partition_point(|&t| t <= value) - 1) as u8
        });
        Self { threshold, start }
    }

    #[inline]
    fn code(&self, linear: f32) -> u8 {
        // A cast takes not-a-number and all below 0 to 0.
        let interval = ((linear * Self::INTERVALS as f32) as usize).min(Self::INTERVALS);
        let mut code = usize::from(self.start[interval]);
        while linear >= self.threshold[code + 1] {
            code += 1;
        }
        code as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channel;

    #[test]
    fn codes_are_the_nearest_ones() {
        let encoder = Encoder::new();
        for i in -100..70_000 {
            let linear = i as f32 / 65_536.0;
            let exact = (255.0 * rgb::encode(linear)).clamp(0.0, 255.0);
            // The two routes round differently within 1e-4 of the middle between codes.
            assert!((f32::from(encoder.code(linear)) - exact).abs() <= 0.5 + 1e-4, "{linear}");
        }
        for code in 0..=255u8 {
            assert_eq!(encoder.code(rgb::decode(f32::from(code) / 255.0)), code);
        }
        let extremes = [f32::NAN, f32::NEG_INFINITY, -0.0, f32::INFINITY, f32::MAX].map(|v| encoder.code(v));
        assert_eq!(extremes, [0, 0, 0, 255, 255]);
    }

    #[test]
    fn components_are_interleaved() {
        let plane = |name: &str, data: [f32; 2]| Channel { name: name.to_owned(), data: data.to_vec() };
        let channels = vec![plane("R", [1.0, 0.0]), plane("G", [0.0, 1.0]), plane("B", [0.5, 0.25])];
        let picture = encode_srgb(&Planes::new(2, 1, channels).expect("right sizes"));
        assert_eq!((picture.components, picture.data), (3, vec![255, 0, 188, 0, 255, 137]));
    }
}
