// Bilinear interpolation corrected by the curvature of a pixel's own channel; photosite-develop's demosaic/malvar.rs.

/// Value of the mosaic that lies so many columns and rows from a pixel.
fn near(i: u32, dx: i32, dy: i32) -> f32 {
    return mosaic[u32(i32(i) + dy * i32(params.columns) + dx)];
}

/// Sum of the four neighbours at the corners.
fn diagonal_sum(i: u32) -> f32 {
    return near(i, -1, -1) + near(i, 1, -1) + near(i, -1, 1) + near(i, 1, 1);
}

/// Sum of the four pixels two steps away.
fn far_sum(i: u32) -> f32 {
    return near(i, 0, -2) + near(i, 0, 2) + near(i, -2, 0) + near(i, 2, 0);
}

fn green_at_coloured(i: u32) -> f32 {
    let crossed = near(i, 0, -1) + near(i, 0, 1) + near(i, -1, 0) + near(i, 1, 0);
    return (4.0 * mosaic[i] + 2.0 * crossed - far_sum(i)) * 0.125;
}

/// Red or blue at green, with pixels of that colour along a step.
fn at_green(i: u32, along: vec2<i32>) -> f32 {
    let across = along.yx;
    let beside_it = near(i, -along.x, -along.y) + near(i, along.x, along.y);
    let behind = near(i, 2 * along.x, 2 * along.y);
    let far_across = near(i, -2 * across.x, -2 * across.y) + near(i, 2 * across.x, 2 * across.y);
    let bent = 5.0 * mosaic[i] + 4.0 * beside_it - diagonal_sum(i) - near(i, -2 * along.x, -2 * along.y) - behind;
    return (bent + 0.5 * far_across) * 0.125;
}

/// Blue at red and red at blue.
fn other_at_coloured(i: u32) -> f32 {
    return (6.0 * mosaic[i] + 2.0 * diagonal_sum(i) - 1.5 * far_sum(i)) * 0.125;
}

@compute @workgroup_size(8, 8)
fn malvar(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= params.width || id.y >= params.strip_rows) {
        return;
    }
    let x = id.x + params.margin;
    let y = id.y + params.margin;
    let i = index_of(x, y);
    let own = channel_at(place_of(column_of(x), row_of(y)));
    var rgb: vec3<f32>;
    if (own == GREEN) {
        let beside_it = channel_at(place_of(column_of(x) + 1u, row_of(y)));
        let by_row = at_green(i, vec2<i32>(1, 0));
        let by_column = at_green(i, vec2<i32>(0, 1));
        let is_red_row = beside_it == RED;
        rgb = vec3<f32>(
            select(by_column, by_row, is_red_row),
            mosaic[i],
            select(by_row, by_column, is_red_row),
        );
    } else {
        let other = other_at_coloured(i);
        let is_red = own == RED;
        rgb = vec3<f32>(select(other, mosaic[i], is_red), green_at_coloured(i), select(mosaic[i], other, is_red));
    }
    planes[i] = rgb.x;
    planes[params.plane + i] = rgb.y;
    planes[2u * params.plane + i] = rgb.z;
}
