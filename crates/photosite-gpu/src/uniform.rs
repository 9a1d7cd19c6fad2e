//! Blocks of numbers that kernels read: one table of names and values, from which both the WGSL and the bytes are made.

use std::fmt::Write;

/// Makes the table of a block whose values come from a `$row`.
macro_rules! uniform_block {
    ($row:ty: $($name:ident: $kind:literal = $value:expr,)*) => {
        /// Names and WGSL types in their order; all take four bytes.
        pub(crate) const FIELDS: &[(&str, &str)] = &[$((stringify!($name), $kind)),*];

        /// Values in the same order, as a whole number of 16 bytes.
        pub(crate) fn values(row: &$row) -> Vec<u32> {
            let mut values = vec![$({
                let of: fn(&$row) -> u32 = $value;
                of(row)
            }),*];
            values.resize(values.len().next_multiple_of(4), 0);
            values
        }
    };
}
pub(crate) use uniform_block;

/// Text of the struct of a block in WGSL. Sizes of uniform blocks are whole numbers of 16 bytes, so that numbers that
/// mean nothing fill it up.
pub(crate) fn wgsl(name: &str, fields: &[(&str, &str)]) -> String {
    let mut text = format!("struct {name} {{\n");
    for (name, kind) in fields {
        let _ = writeln!(text, "    {name}: {kind},");
    }
    for i in fields.len()..fields.len().next_multiple_of(4) {
        let _ = writeln!(text, "    padding_{i}: u32,");
    }
    text + "}\n"
}
