//! The kernel of an exposure as one text: the words of its stages, made of Rust's, then a file for each concept.

use photosite_sensor::packed::{PLACES, declarations};

use crate::shaders::WORKGROUP_SIZE;

/// Files in the order of what they need.
const FILES: [&str; 9] = [
    include_str!("../wgsl/hash.wgsl"),
    include_str!("../wgsl/sensor/fixed.wgsl"),
    include_str!("../wgsl/sensor/random.wgsl"),
    include_str!("../wgsl/sensor/poisson.wgsl"),
    include_str!("../wgsl/sensor/values.wgsl"),
    include_str!("../wgsl/sensor/draws.wgsl"),
    include_str!("../wgsl/sensor/charge.wgsl"),
    include_str!("../wgsl/sensor/read_out.wgsl"),
    include_str!("../wgsl/sensor/converter.wgsl"),
];

/// What the kernel reads and writes, whose places are those of the layouts in `kernel`.
const BINDINGS: &str = "\
struct Strip { first_row: u32, padding_0: u32, padding_1: u32, padding_2: u32 }
@group(0) @binding(0) var<storage, read> exposure: ExposureWords;
@group(0) @binding(1) var<storage, read> tables: array<u32>;
@group(0) @binding(2) var<storage, read> random_tables: array<u32>;
@group(0) @binding(3) var<storage, read> light: array<f32>;
";

/// Bindings of the kernel alone.
const OF_KERNEL: &str = "\
@group(1) @binding(0) var<storage, read_write> numbers: array<u32>;
@group(1) @binding(1) var<uniform> strip: Strip;
";

/// Text of the functions, without the kernel.
pub fn functions() -> String {
    let mut text = format!("const WORKGROUP_SIZE = {WORKGROUP_SIZE}u;\n");
    for (name, place) in PLACES {
        text += &format!("const {name} = {place}u;\n");
    }
    text += &declarations();
    text += BINDINGS;
    FILES.iter().for_each(|file| text += file);
    text
}

/// Text of the kernel.
pub fn exposure() -> String {
    functions() + OF_KERNEL + include_str!("../wgsl/sensor/expose.wgsl")
}
