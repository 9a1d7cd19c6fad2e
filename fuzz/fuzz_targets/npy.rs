//! NPY files of digital numbers, and of any others.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::raw::{NpyNumbers, read_npy, read_npy_picture};

fuzz_target!(|data: &[u8]| {
    if let Ok(raw) = read_npy(data) {
        raw.validate().expect("whole");
    }
    if let Ok(picture) = read_npy_picture(data) {
        let numbers = match picture.numbers {
            NpyNumbers::U8(numbers) => numbers.len(),
            NpyNumbers::U16(numbers) => numbers.len(),
            NpyNumbers::F32(numbers) => numbers.len(),
        };
        assert_eq!(numbers, picture.width * picture.height * picture.channels);
    }
});
