//! Captures that can be read are rendered: 8 × 8 pixels, one sample each.
#![no_main]

use libfuzzer_sys::fuzz_target;
use photosite_fuzz::{Captures, render};

fuzz_target!(|capture: Captures| render(&capture));
