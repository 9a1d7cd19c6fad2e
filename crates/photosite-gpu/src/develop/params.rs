//! Numbers of a strip of an image that all kernels of development read: one table, from which both the WGSL and the
//! bytes are made.

use photosite_develop::packed::{Demosaicking, PackedDevelopment};

use super::strips::Strip;
use super::tables::Sections;

/// Makes the table of names and values.
macro_rules! params {
    ($($name:ident: $kind:literal = $value:expr,)*) => {
        /// Names and WGSL types in their order; all take four bytes.
        pub(crate) const FIELDS: &[(&str, &str)] = &[$((stringify!($name), $kind)),*];

        /// Values in the same order.
        pub(crate) fn values(of: &PackedDevelopment, strip: &Strip, sections: &Sections) -> Vec<u32> {
            let row = Row { of, strip, sections };
            let mut values = vec![$({
                let of: fn(&Row<'_>) -> u32 = $value;
                of(&row)
            }),*];
            values.resize(values.len() + PADDING, 0);
            values
        }
    };
}

/// Numbers behind the others that mean nothing: sizes of uniform blocks are whole numbers of 16 bytes.
pub(crate) const PADDING: usize = FIELDS.len().next_multiple_of(4) - FIELDS.len();

struct Row<'a> {
    of: &'a PackedDevelopment,
    strip: &'a Strip,
    sections: &'a Sections,
}

impl Row<'_> {
    /// A number of the matrix from camera channels to components.
    fn colour(&self, channel: usize, component: usize) -> u32 {
        self.of.colour[channel][component].to_bits()
    }

    /// Weight of a component in luminance.
    fn weight(&self, component: usize) -> u32 {
        self.of.luminance.map_or(0.0, |weights| weights[component]).to_bits()
    }

    /// Parity of the rows that hold red pixels, and of the columns.
    fn red(&self) -> [usize; 2] {
        match self.of.demosaicking {
            Demosaicking::Menon { red } => red,
            Demosaicking::Apart | Demosaicking::Bilinear(_) | Demosaicking::Malvar => [0; 2],
        }
    }
}

params! {
    // The strip with its margin, and where it lies in the active area
    columns: "u32" = |r| r.strip.padded[0] as u32,
    rows: "u32" = |r| r.strip.padded[1] as u32,
    plane: "u32" = |r| (r.strip.padded[0] * r.strip.padded[1]) as u32,
    margin: "u32" = |r| r.of.demosaicking.margin() as u32,
    top: "u32" = |r| r.strip.top as u32,
    strip_rows: "u32" = |r| r.strip.rows as u32,
    width: "u32" = |r| r.of.active.width as u32,
    height: "u32" = |r| r.of.active.height as u32,
    // Raw numbers
    samples: "u32" = |r| r.of.samples as u32,
    row_length: "u32" = |r| (r.of.stored_px[0] * r.of.samples) as u32,
    first_number: "u32" = |r| r.strip.first_number,
    // Their meaning
    linearisation: "u32" = |r| r.sections.linearisation,
    linear_entries: "u32" = |r| r.of.linearisation.len() as u32,
    places: "u32" = |r| r.sections.places,
    tile_columns: "u32" = |r| r.of.tile_columns as u32,
    tile_rows: "u32" = |r| (r.of.places.len() / r.of.tile_columns) as u32,
    gain_maps: "u32" = |r| r.sections.gain_maps,
    gain_map_count: "u32" = |r| r.of.gain_maps.len() as u32,
    ceiling: "f32" = |r| r.of.ceiling.min(f32::MAX).to_bits(),
    // Demosaicking
    red_row: "u32" = |r| r.red()[0] as u32,
    red_column: "u32" = |r| r.red()[1] as u32,
    neighbours: "u32" = |r| r.sections.neighbours,
    // Colours
    channels: "u32" = |r| r.of.channels as u32,
    a_r: "f32" = |r| r.colour(0, 0),
    a_g: "f32" = |r| r.colour(0, 1),
    a_b: "f32" = |r| r.colour(0, 2),
    b_r: "f32" = |r| r.colour(1, 0),
    b_g: "f32" = |r| r.colour(1, 1),
    b_b: "f32" = |r| r.colour(1, 2),
    c_r: "f32" = |r| r.colour(2, 0),
    c_g: "f32" = |r| r.colour(2, 1),
    c_b: "f32" = |r| r.colour(2, 2),
    is_filmic: "u32" = |r| u32::from(r.of.is_filmic),
    is_grey: "u32" = |r| u32::from(r.of.luminance.is_some()),
    weight_r: "f32" = |r| r.weight(0),
    weight_g: "f32" = |r| r.weight(1),
    weight_b: "f32" = |r| r.weight(2),
    // Codes
    components: "u32" = |r| r.of.components() as u32,
    bits: "u32" = |r| u32::from(r.of.bits),
    levels: "u32" = |r| r.sections.levels,
    // Pixel (x, y) of the turned strip is first + x·right + y·down in the strip
    turned_columns: "u32" = |r| r.strip.turned[0] as u32,
    turned_rows: "u32" = |r| r.strip.turned[1] as u32,
    first_x: "i32" = |r| r.strip.turn.first[0] as u32,
    first_y: "i32" = |r| r.strip.turn.first[1] as u32,
    right_x: "i32" = |r| r.strip.turn.right[0] as u32,
    right_y: "i32" = |r| r.strip.turn.right[1] as u32,
    down_x: "i32" = |r| r.strip.turn.down[0] as u32,
    down_y: "i32" = |r| r.strip.turn.down[1] as u32,
}
