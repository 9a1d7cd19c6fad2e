//! Kernels of development in one text.

use std::fmt::Write;

use super::{params, tables};
use crate::uniform::wgsl;

/// Side of the tiles of pixels that a workgroup of development has.
pub(crate) const DEVELOP_TILE: u32 = 8;

/// Files of development in the order of what they need.
const DEVELOPMENT: [&str; 7] = [
    include_str!("../wgsl/develop/strip.wgsl"),
    include_str!("../wgsl/develop/signal.wgsl"),
    include_str!("../wgsl/develop/bilinear.wgsl"),
    include_str!("../wgsl/develop/malvar.wgsl"),
    include_str!("../wgsl/develop/menon.wgsl"),
    include_str!("../wgsl/develop/colour.wgsl"),
    include_str!("../wgsl/develop/encode.wgsl"),
];

/// Text of all kernels of development.
pub fn development() -> String {
    let mut text = String::new();
    for (name, value) in [
        ("PLACE_WORDS", tables::PLACE_WORDS as u32),
        ("LINE_WORDS", tables::LINE_WORDS as u32),
        ("MAP_WORDS", tables::MAP_WORDS as u32),
        ("TAP_WORDS", tables::TAP_WORDS as u32),
        ("NONE", tables::NONE),
        ("RED", 0),
        ("GREEN", 1),
        ("BLUE", 2),
    ] {
        let _ = writeln!(text, "const {name} = {value}u;");
    }
    text += &wgsl("Params", params::FIELDS);
    text += "@group(0) @binding(0) var<uniform> params: Params;\n";
    DEVELOPMENT.iter().for_each(|file| text += file);
    text
}
