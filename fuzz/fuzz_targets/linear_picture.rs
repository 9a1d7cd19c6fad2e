//! Pictures that are measured and compared, with what they say of their colours. The first byte says which kind the
//! file's name says.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite::io::linear_picture::read_linear_picture;
use photosite::raw::Pixels;
use photosite_fuzz::written;

const KINDS: [&str; 6] = ["png", "tiff", "jpg", "exr", "ppm", "dng"];

fuzz_target!(|data: &[u8]| {
    if let [kind, file @ ..] = data {
        let kind = KINDS[usize::from(*kind) % KINDS.len()];
        let _ = read_linear_picture(&written(&format!("picture.{kind}"), file), false, Pixels::Active);
    }
});
