//! Encoding: linear values become the codes of an image file.

use rayon::prelude::*;

use photosite_core::rows::{for_each_row, for_each_value};

use super::sharpening;
use photosite_core::colour::{ColourSpace, Transfer};
use photosite_core::image::Planes;
use photosite_core::math::hash::{hash64, unit_f32};

/// An image for display: encoded, rows from the top, components interleaved.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedImage {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// 1 for grey, 3 for red, green, blue.
    pub components: usize,
    /// width × height × components codes.
    pub codes: Codes,
    /// Colour space of the components.
    pub colour_space: ColourSpace,
    /// Transfer function of the codes.
    pub transfer: Transfer,
    /// Width of a pixel over its height.
    pub pixel_aspect: f64,
}

/// Codes of an image, white at their largest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Codes {
    /// 0–255.
    U8(Vec<u8>),
    /// 0–65 535.
    U16(Vec<u16>),
}

impl EncodedImage {
    /// An sRGB image of 8 bits.
    pub fn srgb8(width: usize, height: usize, components: usize, codes: Vec<u8>) -> Self {
        let (colour_space, transfer) = (ColourSpace::Srgb, Transfer::Srgb);
        Self { width, height, components, codes: Codes::U8(codes), colour_space, transfer, pixel_aspect: 1.0 }
    }
}

/// Encoding of planes as codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    /// Colour space of the planes.
    pub colour_space: ColourSpace,
    /// Transfer function from linear values to codes.
    pub transfer: Transfer,
    /// 8 or 16.
    pub bits: u8,
    /// Whether noise of one code is added before rounding.
    pub dither: bool,
    /// Amount of the unsharp mask.
    pub sharpening: f64,
    /// Standard deviation of the unsharp mask, pixels.
    pub sharpening_radius_px: f64,
}

impl Default for Encoding {
    /// sRGB of 8 bits.
    fn default() -> Self {
        Self {
            colour_space: ColourSpace::Srgb,
            transfer: Transfer::Srgb,
            bits: 8,
            dither: false,
            sharpening: 0.0,
            sharpening_radius_px: 1.0,
        }
    }
}

/// Encodes linear planes, 1 or 3 of them with white at 1: each value becomes the nearest code after the transfer
/// function, clipped to 0–1 first; not-a-number becomes black. With dithering, a value between two codes becomes
/// either, in proportion to its nearness, by a pattern that is always the same. Pixels are square.
pub fn encode(mut linear: Planes, encoding: &Encoding) -> EncodedImage {
    let curve = Curve::new(encoding.transfer);
    let encoded = encoding.sharpening != 0.0;
    if encoded {
        for channel in linear.channels_mut() {
            for_each_value(&mut channel.data, |value| *value = curve.encode(*value));
        }
        sharpening::apply(&mut linear, encoding.sharpening, encoding.sharpening_radius_px);
    }
    let value = |v: f32| if encoded { v } else { curve.encode(v) };
    let codes = match encoding.bits {
        // A cast takes not-a-number and all below 0 to 0, and all above to the largest.
        8 => Codes::U8(quantised(&linear, encoding.dither, |v, rounding| placed(value(v), 255.0, rounding) as u8)),
        _ => Codes::U16(quantised(&linear, encoding.dither, |v, rounding| placed(value(v), 65_535.0, rounding) as u16)),
    };
    EncodedImage {
        width: linear.width(),
        height: linear.height(),
        components: linear.channels().len(),
        codes,
        colour_space: encoding.colour_space,
        transfer: encoding.transfer,
        pixel_aspect: 1.0,
    }
}

/// Encoded value on the scale of codes up to `largest`, before it is cut off.
#[inline]
fn placed(encoded: f32, largest: f32, rounding: f32) -> f32 {
    encoded * largest + rounding
}

/// Numbers of single precision between a level and the exact inverse of its code: about as many as straight lines
/// between the entries of the curve's table are off by, 4e-8/0.05 where it begins.
const NEAR: u32 = 64;

/// Least linear value of every code from 1 on: the code of a value is the number of these that it reaches. Found by
/// bisection of [`encode`]'s own curve over the numbers of single precision, so that both give the same codes.
pub(super) fn levels(transfer: Transfer, bits: u8) -> Vec<f32> {
    let curve = Curve::new(transfer);
    let largest = (1u32 << bits) - 1;
    let code = |bits: u32| placed(curve.encode(f32::from_bits(bits)), largest as f32, 0.5) as u32;
    let level = |wanted: u32| {
        // Bits of numbers above 0 have the order of the numbers. Devices take those below the normal ones for 0.
        let (mut below, mut reached) = (f32::MIN_POSITIVE.to_bits() - 1, 1f32.to_bits());
        // The exact inverse lies near, so that few halves are left.
        let inverse = transfer.decode((wanted as f32 - 0.5) / largest as f32).to_bits();
        let mut first = [inverse.saturating_sub(NEAR), inverse + NEAR].into_iter();
        while reached - below > 1 {
            let middle = first.next().unwrap_or(below + (reached - below) / 2).clamp(below + 1, reached - 1);
            if code(middle) >= wanted { reached = middle } else { below = middle }
        }
        f32::from_bits(reached)
    };
    (1..=largest).into_par_iter().map(level).collect()
}

/// Interleaved codes of all planes; `code` gets a value and what to add before it is cut off.
fn quantised<T: Copy + Default + Send + Sync>(
    planes: &Planes,
    dither: bool,
    code: impl Fn(f32, f32) -> T + Sync,
) -> Vec<T> {
    let (width, components) = (planes.width(), planes.channels().len());
    let mut codes = vec![T::default(); width * planes.height() * components];
    for_each_row(&mut codes, width * components, |y, row| {
        for (component, channel) in planes.channels().iter().enumerate() {
            let values = &channel.data[y * width..(y + 1) * width];
            let to = row[component..].iter_mut().step_by(components).zip(values);
            if dither {
                for (x, (to, &value)) in to.enumerate() {
                    let key = hash64((y * width + x) as u64, component as u64);
                    *to = code(value, unit_f32((key >> 32) as u32));
                }
            } else {
                to.for_each(|(to, &value)| *to = code(value, 0.5));
            }
        }
    });
    codes
}

/// The transfer function by look-up: no power a pixel.
struct Curve {
    transfer: Transfer,
    /// Encoded value at 0, 1/[`Self::INTERVALS`] … 1.
    table: Vec<f32>,
}

impl Curve {
    const INTERVALS: usize = 65_536;
    /// Below it the function bends too much for straight lines: between entries they would be off by more than 4e-8, a
    /// 400th of a 16-bit code.
    const EXACT_BELOW: f32 = 1.0 / 256.0;

    fn new(transfer: Transfer) -> Self {
        let entry = |i: usize| transfer.encode(i as f32 / Self::INTERVALS as f32);
        Self { transfer, table: (0..=Self::INTERVALS).map(entry).collect() }
    }

    /// The encoded value, clipped to 0–1.
    #[inline]
    fn encode(&self, linear: f32) -> f32 {
        // Not-a-number fails both comparisons.
        if linear.is_nan() || linear <= 0.0 {
            return 0.0;
        }
        if linear < Self::EXACT_BELOW {
            return self.transfer.encode(linear);
        }
        let place = linear.min(1.0) * Self::INTERVALS as f32;
        let i = (place as usize).min(Self::INTERVALS - 1);
        let (low, high) = (self.table[i], self.table[i + 1]);
        low + (high - low) * (place - i as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::image::Channel;
    use photosite_core::spectrum::rgb;

    fn encoded(values: &[f32], encoding: &Encoding) -> Codes {
        let plane = Channel { name: "Y".to_owned(), data: values.to_vec() };
        encode(Planes::new(values.len(), 1, vec![plane]).expect("right size"), encoding).codes
    }

    #[test]
    fn codes_are_the_nearest_ones() {
        let linear: Vec<f32> = (-100..70_000).map(|i| i as f32 / 65_536.0 + 3e-6).collect();
        for transfer in [Transfer::Srgb, Transfer::Linear, Transfer::Gamma(2.2), Transfer::Gamma(1.8)] {
            for bits in [8, 16] {
                let codes: Vec<u16> = match encoded(&linear, &Encoding { transfer, bits, ..Encoding::default() }) {
                    Codes::U8(codes) => codes.into_iter().map(u16::from).collect(),
                    Codes::U16(codes) => codes,
                };
                let largest = f64::from((1u32 << bits) - 1);
                for (code, v) in codes.iter().zip(&linear) {
                    let v = f64::from(*v).clamp(0.0, 1.0);
                    let exact = largest
                        * match transfer {
                            Transfer::Linear => v,
                            Transfer::Gamma(gamma) => v.powf(1.0 / gamma),
                            Transfer::Srgb if v <= 0.003_130_8 => v * 12.92,
                            Transfer::Srgb => 1.055 * v.powf(1.0 / 2.4) - 0.055,
                        };
                    // Powers and products in f32 are off by a few 2⁻²⁴ of the largest code.
                    let tolerance = 0.5 + largest * 8.0 / 16_777_216.0;
                    assert!(
                        (f64::from(*code) - exact).abs() <= tolerance,
                        "{transfer:?} {bits} bits: {v} {code} {exact}"
                    );
                }
            }
        }
        let own: Vec<f32> = (0..=255u8).map(|code| rgb::decode(f32::from(code) / 255.0)).collect();
        assert_eq!(encoded(&own, &Encoding::default()), Codes::U8((0..=255).collect()));
        let extremes = [f32::NAN, f32::NEG_INFINITY, -0.0, f32::INFINITY, f32::MAX];
        assert_eq!(encoded(&extremes, &Encoding::default()), Codes::U8(vec![0, 0, 0, 255, 255]));
    }

    #[test]
    fn levels_tell_the_same_codes_as_the_curve() {
        let mut linear: Vec<f32> = (0..70_000u32).map(|i| i as f32 / 65_536.0).collect();
        for transfer in
            [Transfer::Srgb, Transfer::Linear, Transfer::Gamma(2.2), Transfer::Gamma(0.5), Transfer::Gamma(10.0)]
        {
            for bits in [8, 16] {
                let levels = levels(transfer, bits);
                assert_eq!(levels.len(), (1 << bits) - 1);
                // The levels themselves, and the numbers next to them.
                let below = levels.iter().map(|level| f32::from_bits(level.to_bits() - 1));
                linear.extend(levels.iter().copied().chain(below.filter(|value| value.is_normal())));
                let codes = match encoded(&linear, &Encoding { transfer, bits, ..Encoding::default() }) {
                    Codes::U8(codes) => codes.into_iter().map(usize::from).collect::<Vec<_>>(),
                    Codes::U16(codes) => codes.into_iter().map(usize::from).collect(),
                };
                for (code, value) in codes.iter().zip(&linear) {
                    let found = levels.partition_point(|level| level <= value);
                    assert_eq!(found, *code, "{transfer:?} {bits} bits: {value}");
                }
            }
        }
    }

    #[test]
    fn dithering_keeps_means_exact() {
        let n = 40_000;
        for level in [0.0, 0.25, 100.4 / 255.0, 1.0] {
            let encoding = Encoding { transfer: Transfer::Linear, dither: true, ..Encoding::default() };
            let Codes::U8(codes) = encoded(&vec![level; n], &encoding) else { panic!("8 bits") };
            let mean = codes.iter().map(|&code| f64::from(code)).sum::<f64>() / n as f64;
            // A choice between two codes has a standard deviation of at most ½; 4 of its mean.
            assert!((mean - f64::from(level) * 255.0).abs() < 4.0 * 0.5 / (n as f64).sqrt() + 1e-5, "{level}: {mean}");
        }
    }

    #[test]
    fn sharpening_overshoots_at_edges_only() {
        let edge: Vec<f32> = (0..40).map(|x| if x < 20 { 0.2 } else { 0.6 }).collect();
        let encoding = Encoding { sharpening: 1.0, transfer: Transfer::Linear, bits: 16, ..Encoding::default() };
        let Codes::U16(codes) = encoded(&edge, &encoding) else { panic!("16 bits") };
        let level = |v: f64| (v * 65_535.0).round() as u16;
        assert!(codes[5].abs_diff(level(0.2)) <= 1 && codes[34].abs_diff(level(0.6)) <= 1);
        assert!(codes[19] < level(0.2) && codes[20] > level(0.6));
    }

    #[test]
    fn components_are_interleaved() {
        let plane = |name: &str, data: [f32; 2]| Channel { name: name.to_owned(), data: data.to_vec() };
        let channels = vec![plane("R", [1.0, 0.0]), plane("G", [0.0, 1.0]), plane("B", [0.5, 0.25])];
        let image = encode(Planes::new(2, 1, channels).expect("right sizes"), &Encoding::default());
        assert_eq!(image, EncodedImage::srgb8(2, 1, 3, vec![255, 0, 188, 0, 255, 137]));
    }
}
