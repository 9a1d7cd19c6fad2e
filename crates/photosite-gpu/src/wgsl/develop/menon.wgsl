// Demosaicking along edges, a kernel for each step of photosite-develop's demosaic/menon.rs. The own colour of a row is
// the one, of red and blue, that its pixels see beside green.

/// Pixel of a strip that is coloured, or that is green.
struct RowPixel {
    /// Index in the planes; NONE for what lies too close to the edge of the strip, or beyond.
    index: u32,
    /// Planes of the row's own colour, and of the other.
    own: u32,
    other: u32,
}

/// The id.x-th pixel of a row that is coloured, or green, `inset` pixels from the strip's edge.
fn row_pixel(id: vec3<u32>, is_green: bool, inset: u32) -> RowPixel {
    // The margin is even
    let is_red_row = (params.top + id.y) % 2u == params.red_row;
    let is_second = is_red_row == is_green;
    let x = 2u * id.x + select(params.red_column, 1u - params.red_column, is_second);
    let is_inside = min(x, id.y) >= inset && x + inset < params.columns && id.y + inset < params.rows;
    let own = select(BLUE, RED, is_red_row);
    return RowPixel(select(NONE, index_of(x, id.y), is_inside), own * params.plane, (BLUE - own) * params.plane);
}

/// Green at coloured pixels along rows and along columns: the mean of its neighbours, corrected by the second
/// difference of the pixel's colour.
@compute @workgroup_size(8, 8)
fn interpolate_green(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = row_pixel(id, false, 2u);
    if (pixel.index == NONE) {
        return;
    }
    let i = pixel.index;
    differences[i] = vec2<f32>(difference_along(i, 1u), difference_along(i, params.columns));
}

/// Own colour minus green that is interpolated along a step.
fn difference_along(i: u32, step: u32) -> f32 {
    let here = mosaic[i];
    let curvature = 2.0 * here - mosaic[i - 2u * step] - mosaic[i + 2u * step];
    let green = 0.5 * (mosaic[i - step] + mosaic[i + step]) + 0.25 * curvature;
    return here - green;
}

/// Change of colour difference from a pixel to the next but one.
fn change(direction: u32, step: u32, i: u32) -> f32 {
    return abs(differences[i][direction] - differences[i + 2u * step][direction]);
}

/// Changes before and behind a pixel along a line of its own colour.
fn own_line(direction: u32, step: u32, i: u32) -> f32 {
    return change(direction, step, i - 2u * step) + change(direction, step, i);
}

/// Changes of colour difference near a pixel: 3 times those on its own line, and those on the lines beside it.
fn roughness(direction: u32, step: u32, across: u32, i: u32) -> f32 {
    return 3.0 * own_line(direction, step, i)
        + own_line(direction, step, i - 2u * across)
        + own_line(direction, step, i + 2u * across)
        + change(direction, step, i - across - step)
        + change(direction, step, i + across - step);
}

/// Directions in which colour differences change less; green everywhere, and each coloured pixel's own colour.
@compute @workgroup_size(8, 8)
fn choose_directions(@builtin(global_invocation_id) id: vec3<u32>) {
    let green = row_pixel(id, true, 4u);
    if (green.index != NONE) {
        planes[params.plane + green.index] = mosaic[green.index];
    }
    let pixel = row_pixel(id, false, 4u);
    if (pixel.index == NONE) {
        return;
    }
    let i = pixel.index;
    let is_along_row = roughness(0u, 1u, params.columns, i) <= roughness(1u, params.columns, 1u, i);
    along_row[i] = u32(is_along_row);
    planes[params.plane + i] = mosaic[i] - differences[i][select(1u, 0u, is_along_row)];
    planes[pixel.own + i] = mosaic[i];
}

/// Colour at green pixels: green plus the mean difference to green of the two neighbours of that colour.
fn chroma_at(i: u32, plane: u32, step: u32) {
    let green = params.plane;
    let before = planes[plane + i - step] - planes[green + i - step];
    let behind = planes[plane + i + step] - planes[green + i + step];
    planes[plane + i] = planes[green + i] + 0.5 * (before + behind);
}

fn fill_chroma(pixel: RowPixel) {
    if (pixel.index != NONE) {
        chroma_at(pixel.index, pixel.own, 1u);
        chroma_at(pixel.index, pixel.other, params.columns);
    }
}

@compute @workgroup_size(8, 8)
fn chroma_at_green(@builtin(global_invocation_id) id: vec3<u32>) {
    fill_chroma(row_pixel(id, true, 5u));
}

/// The same after the refinement of green.
@compute @workgroup_size(8, 8)
fn chroma_again(@builtin(global_invocation_id) id: vec3<u32>) {
    fill_chroma(row_pixel(id, true, 8u));
}

/// Step along the chosen direction.
fn chosen_step(i: u32) -> u32 {
    return select(params.columns, 1u, along_row[i] == 1u);
}

/// Difference of two planes at a pixel.
fn between(plane: u32, other: u32, i: u32) -> f32 {
    return planes[plane + i] - planes[other + i];
}

/// Blue at red pixels and red at blue ones: the own colour plus the mean difference to it along the chosen direction.
@compute @workgroup_size(8, 8)
fn other_colour(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = row_pixel(id, false, 6u);
    if (pixel.index == NONE) {
        return;
    }
    let i = pixel.index;
    let step = chosen_step(i);
    let before = between(pixel.other, pixel.own, i - step);
    let behind = between(pixel.other, pixel.own, i + step);
    planes[pixel.other + i] = planes[pixel.own + i] + 0.5 * (before + behind);
}

/// Mean of the differences at a pixel and on both sides along the chosen direction.
fn mean_of_three(plane: u32, other: u32, i: u32) -> f32 {
    let step = chosen_step(i);
    return (between(plane, other, i - step) + between(plane, other, i) + between(plane, other, i + step)) / 3.0;
}

/// Green at coloured pixels, from differences that are now known at every pixel.
@compute @workgroup_size(8, 8)
fn green_again(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = row_pixel(id, false, 7u);
    if (pixel.index != NONE) {
        let i = pixel.index;
        planes[params.plane + i] = planes[pixel.own + i] - mean_of_three(pixel.own, params.plane, i);
    }
}

/// The other colour once more, from three differences.
@compute @workgroup_size(8, 8)
fn other_again(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = row_pixel(id, false, 9u);
    if (pixel.index != NONE) {
        let i = pixel.index;
        planes[pixel.other + i] = planes[pixel.own + i] + mean_of_three(pixel.other, pixel.own, i);
    }
}
