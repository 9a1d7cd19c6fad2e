//! Filters of meshopt: unpacked attributes decoded into directions, rotations, real numbers and colours.

/// Component of a vector of four, little-endian.
pub(super) trait Component: Copy {
    /// Largest value of the type.
    const LARGEST: f32;

    fn read(bytes: &[u8]) -> [Self; 4];
    fn write(components: [Self; 4], bytes: &mut [u8]);
    fn float(self) -> f32;
    /// Nearest value of the type; 0 for NaN.
    fn nearest(value: f32) -> Self;
}

macro_rules! component {
    ($($type:ty),*) => {$(
        impl Component for $type {
            const LARGEST: f32 = <$type>::MAX as f32;

            fn read(bytes: &[u8]) -> [Self; 4] {
                const SIZE: usize = size_of::<$type>();
                let at = |i: usize| std::array::from_fn(|b| bytes[i * SIZE + b]);
                std::array::from_fn(|i| <$type>::from_le_bytes(at(i)))
            }

            fn write(components: [Self; 4], bytes: &mut [u8]) {
                for (component, bytes) in components.iter().zip(bytes.chunks_exact_mut(size_of::<$type>())) {
                    bytes.copy_from_slice(&component.to_le_bytes());
                }
            }

            fn float(self) -> f32 {
                f32::from(self)
            }

            fn nearest(value: f32) -> Self {
                value.round() as $type
            }
        }
    )*};
}

component!(i8, i16, u8, u16);

fn each<T: Component>(bytes: &mut [u8], decode: impl Fn([T; 4]) -> [T; 4]) {
    bytes.chunks_exact_mut(4 * size_of::<T>()).for_each(|four| T::write(decode(T::read(four)), four));
}

/// Unit vectors from their place on an octahedron; the third component holds the largest value that the first two can
/// have.
pub(super) fn octahedral<T: Component>(bytes: &mut [u8]) {
    each(bytes, |[x, y, one, fourth]: [T; 4]| {
        let [x, y] = [x, y].map(|c| c.float() / one.float());
        let z = 1.0 - x.abs() - y.abs();
        // What lies below is folded out.
        let fold = z.min(0.0);
        let [x, y] = [x, y].map(|c| c - fold.copysign(c));
        let length = (x * x + y * y + z * z).sqrt();
        let [x, y, z] = [x, y, z].map(|c| T::nearest(c / length * T::LARGEST));
        [x, y, z, fourth]
    });
}

/// Unit quaternions from all components but the largest. The fourth number holds the index of that one in its two
/// lowest bits; with these set, it is the largest value that the others can have.
pub(super) fn quaternion(bytes: &mut [u8]) {
    each(bytes, |[x, y, z, code]: [i16; 4]| {
        let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(code | 3);
        let others = [x, y, z].map(|c| f32::from(c) * scale);
        let largest = (1.0 - others.iter().map(|c| c * c).sum::<f32>()).max(0.0).sqrt();
        let [x, y, z] = others;
        let mut components = [largest, x, y, z].map(|c| i16::nearest(c * i16::LARGEST));
        components.rotate_right((code & 3) as usize);
        components
    });
}

/// Real numbers from an exponent of 8 bits and a mantissa of 24.
pub(super) fn exponential(bytes: &mut [u8]) {
    for bytes in bytes.as_chunks_mut::<4>().0 {
        let number = i32::from_le_bytes(*bytes);
        let (exponent, mantissa) = (number >> 24, (number << 8) >> 8);
        *bytes = ((f64::from(mantissa) * 2f64.powi(exponent)) as f32).to_le_bytes();
    }
}

/// Colours from luma and two differences. The highest bit of the alpha gives the number of bits of all.
pub(super) fn colour<T: Component>(bytes: &mut [u8])
where
    u32: From<T>,
{
    each(bytes, |[y, orange, green, alpha]: [T; 4]| {
        // The differences are signed.
        let signed = |c: T| {
            let (c, half) = (c.float(), T::LARGEST / 2.0);
            if c > half { c - T::LARGEST - 1.0 } else { c }
        };
        let (y, orange, green) = (y.float(), signed(orange), signed(green));
        let alpha = u32::from(alpha);
        let largest = (1u32 << alpha.checked_ilog2().map_or(0, |bit| bit + 1)) - 1;
        let low = alpha & (largest >> 1);
        let alpha = (low << 1 | low & 1) as f32;
        let scale = T::LARGEST / largest as f32;
        [y + orange - green, y + green, y - orange - green, alpha].map(|c| T::nearest(c * scale))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filtered<const N: usize>(mut bytes: [u8; N], filter: fn(&mut [u8])) -> [u8; N] {
        filter(&mut bytes);
        bytes
    }

    #[test]
    fn directions_are_found_on_the_octahedron() {
        let [axis, corner, below] = [[0, 0, 127, 5], [127, 0, 127, 5], [64, 63, 127, 5]];
        assert_eq!(filtered(axis, octahedral::<i8>), [0, 0, 127, 5]);
        assert_eq!(filtered(corner, octahedral::<i8>), [127, 0, 0, 5]);
        // x = 64/127, y = 63/127, z = 0: (0.7127, 0.7015, 0).
        assert_eq!(filtered(below, octahedral::<i8>), [91, 89, 0, 5]);
        // |x| + |y| > 1 is below: −Z is at all four corners.
        assert_eq!(filtered([127, 129, 127, 5], octahedral::<i8>), [0, 0, 129, 5]);
        // No direction at all.
        assert_eq!(filtered([1, 1, 0, 5], octahedral::<i8>)[3], 5);
    }

    #[test]
    fn rotations_get_their_largest_component_back() {
        let words = |words: [i16; 4]| -> [u8; 8] { std::array::from_fn(|i| words[i / 2].to_le_bytes()[i % 2]) };
        for largest in 0..4i16 {
            // Components of ½ each: ½·√2·32767.
            let half = 23170;
            let read = i16::read(&filtered(words([half, -half, half, 32764 | largest]), quaternion));
            let mut expected = [1, 1, -1, 1];
            expected.rotate_right(largest as usize);
            for (c, sign) in read.into_iter().zip(expected) {
                assert!((c - sign * 16384).abs() <= 1, "{largest}: {read:?}");
            }
        }
    }

    #[test]
    fn real_numbers_are_mantissa_times_power_of_two() {
        let number = |exponent: i32, mantissa: i32| ((exponent << 24) | (mantissa & 0xff_ffff)).to_le_bytes();
        for (exponent, mantissa, expected) in [(0, 3, 3.0), (-3, -5, -0.625), (10, 1, 1024.0), (-100, 0, 0.0)] {
            let read = f32::from_le_bytes(filtered(number(exponent, mantissa), exponential));
            assert_eq!(read, expected);
        }
    }

    #[test]
    fn colours_are_undone() {
        // 8 bits: r = 200, g = 100, b = 50: Co = (r − b)/2 = 75, Cg = (2g − r − b)/4 → −12.5 as −12, Y = 112.
        let [r, g, b, a] = filtered([112, 75, 244, 0x80 | 0x7f], colour::<u8>);
        assert_eq!([r, g, b, a], [199, 100, 49, 255]);
        // 4 bits, of 15.
        assert_eq!(filtered([15, 0, 0, 0x8 | 0x5], colour::<u8>), [255, 255, 255, 187]);
        let _ = filtered([15, 0, 0, 0], colour::<u8>);
    }
}
