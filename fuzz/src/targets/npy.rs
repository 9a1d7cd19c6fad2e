//! NPY files of digital numbers, and of any others.

use photosite::raw::{NpyValues, read_npy, read_npy_image};

pub(crate) fn target(data: &[u8]) {
    if let Ok(raw) = read_npy(data) {
        raw.validate().expect("whole");
    }
    if let Ok(image) = read_npy_image(data) {
        let numbers = match image.numbers {
            NpyValues::U8(numbers) => numbers.len(),
            NpyValues::U16(numbers) => numbers.len(),
            NpyValues::F32(numbers) => numbers.len(),
        };
        assert_eq!(numbers, image.width * image.height * image.channels);
    }
}
