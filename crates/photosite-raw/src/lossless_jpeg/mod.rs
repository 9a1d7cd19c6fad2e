//! Lossless JPEG as DNG files use it: differences between neighbouring numbers, in Huffman codes (process 14 of
//! [T81](photosite_core::references#t81), annex H).
//!
//! In and out: rows of numbers of up to 16 bits, in which the numbers of 1–4 components lie beside each other; each is
//! predicted from its own component. Which of the pixels of a mosaic make up a component is left to the caller.

mod decode;
mod encode;
mod huffman;

pub(super) use decode::decode;
pub(super) use encode::encode;

/// Start of image.
const SOI: u8 = 0xd8;
/// End of image.
const EOI: u8 = 0xd9;
/// Start of a frame of the lossless process with Huffman codes.
const SOF3: u8 = 0xc3;
/// Huffman tables.
const DHT: u8 = 0xc4;
/// Start of the scan.
const SOS: u8 = 0xda;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn noise(count: usize, mask: u16) -> Vec<u16> {
        (0..count as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 9) as u16 & mask).collect()
    }

    #[test]
    fn numbers_come_back_as_they_went() {
        for (components, columns, rows) in [(1, 1, 1), (1, 7, 5), (2, 64, 31), (3, 16, 16), (4, 5, 3)] {
            for mask in [0, 1, 0xff, 0xfff, 0xffff] {
                let numbers = noise(components * columns * rows, mask);
                let coded = encode(&numbers, components * columns, components);
                assert_eq!(decode(&coded, numbers.len()), Ok(numbers), "{components} × {columns} × {rows}, {mask:#x}");
            }
        }
    }

    #[test]
    fn the_widest_differences_are_kept() {
        let numbers = vec![0, u16::MAX, 0, 0x8000, 0, 0x7fff, u16::MAX, 1];
        assert_eq!(decode(&encode(&numbers, 4, 1), 8), Ok(numbers));
    }

    #[test]
    fn smooth_images_shrink() {
        // Steps of 0 or 1 between neighbours need about 1.5 bits each, with tables and headers.
        let numbers: Vec<u16> = (0..256 * 256).map(|i| 1000 + (i % 256 / 2) as u16).collect();
        let coded = encode(&numbers, 256, 1);
        assert!(coded.len() < numbers.len() * 2 / 8, "{} bytes", coded.len());
    }

    #[test]
    fn cut_files_are_errors() {
        let numbers = noise(200, 0xfff);
        let coded = encode(&numbers, 20, 2);
        // The last two bytes are the marker of the end, without which nothing is lost.
        for length in 0..coded.len() - 2 {
            assert!(decode(&coded[..length], 200).is_err(), "cut to {length} of {} bytes", coded.len());
        }
        assert!(decode(&coded, 199).is_err(), "another size");
        assert!(decode(&coded, usize::MAX).is_err(), "more numbers than the bytes can hold");
    }

    proptest! {
        #[test]
        fn damaged_files_are_no_panics(changes in proptest::collection::vec((0usize..400, any::<u8>()), 1..8)) {
            let mut coded = encode(&noise(200, 0xfff), 20, 2);
            for (at, value) in changes {
                let at = at % coded.len();
                coded[at] = value;
            }
            if let Ok(numbers) = decode(&coded, 200) {
                prop_assert_eq!(numbers.len(), 200);
            }
        }
    }
}
