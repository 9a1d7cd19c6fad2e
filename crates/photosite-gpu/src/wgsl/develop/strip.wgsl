// Strips of rows that are developed one after the other, with a margin on all sides in which the image is mirrored;
// photosite-develop's window.rs and the tiles of its demosaic/menon.rs.

/// Raw numbers, two in a word, the first in its lower half.
@group(0) @binding(1) var<storage, read> numbers: array<u32>;
/// Tables of the development, at the places that `params` names.
@group(0) @binding(2) var<storage, read> tables: array<u32>;
/// White-balanced values of a mosaic.
@group(0) @binding(3) var<storage, read_write> mosaic: array<f32>;
/// Channels, one plane after the other.
@group(0) @binding(4) var<storage, read_write> planes: array<f32>;
/// Colour differences along rows and along columns.
@group(0) @binding(5) var<storage, read_write> differences: array<vec2<f32>>;
/// Whether to interpolate along rows.
@group(0) @binding(6) var<storage, read_write> along_row: array<u32>;
/// Codes of the image, side by side in whole words.
@group(0) @binding(7) var<storage, read_write> codes: array<u32>;

/// The pixel of a line of `n` that lies `margin` before `i`, after reflection at the first and last pixel.
fn mirror(i: u32, margin: u32, n: u32) -> u32 {
    if (i >= margin && i - margin < n) {
        return i - margin;
    }
    if (n == 1u) {
        return 0u;
    }
    let period = 2u * (n - 1u);
    let place = (i + margin * period - margin) % period;
    return min(place, period - place);
}

/// Index of a pixel of the strip in its planes.
fn index_of(x: u32, y: u32) -> u32 {
    return y * params.columns + x;
}

/// Column of the active area of a pixel that lies in the image.
fn column_of(x: u32) -> u32 {
    return x - params.margin;
}

/// Row of the active area of a pixel that lies in the image.
fn row_of(y: u32) -> u32 {
    return params.top + y - params.margin;
}

fn number_at(at: u32) -> f32 {
    return bitcast<f32>(tables[at]);
}
