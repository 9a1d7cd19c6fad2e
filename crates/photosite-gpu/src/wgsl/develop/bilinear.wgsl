// Means of the nearest pixels of a channel on a Bayer mosaic; photosite-develop's demosaic/bilinear.rs.

/// Whether the step to a neighbour stays in the image.
fn stays(column: u32, row: u32, step: vec2<i32>) -> bool {
    let place = vec2<i32>(i32(column), i32(row)) + step;
    return all(place >= vec2<i32>(0)) && place.x < i32(params.width) && place.y < i32(params.height);
}

/// Value of the mosaic a step beside a pixel of the strip.
fn beside(x: u32, y: u32, step: vec2<i32>) -> f32 {
    return mosaic[index_of(u32(i32(x) + step.x), u32(i32(y) + step.y))];
}

fn step_of(tap: u32) -> vec2<i32> {
    return vec2<i32>(bitcast<i32>(tables[tap]), bitcast<i32>(tables[tap + 1u]));
}

/// Mean of the neighbours that lie in the image; at an edge its weights add up to less than those of all.
fn mean_of(first: u32, count: u32, x: u32, y: u32) -> f32 {
    let column = column_of(x);
    let row = row_of(y);
    var total = 0.0;
    var inside = 0u;
    for (var i = 0u; i < count; i++) {
        let tap = first + TAP_WORDS * i;
        total += number_at(tap + 2u);
        inside += u32(stays(column, row, step_of(tap)));
    }
    var sum = 0.0;
    if (inside == count) {
        for (var i = 0u; i < count; i++) {
            let tap = first + TAP_WORDS * i;
            sum += number_at(tap + 2u) / total * beside(x, y, step_of(tap));
        }
        return sum;
    }
    var weights = 0.0;
    for (var i = 0u; i < count; i++) {
        let tap = first + TAP_WORDS * i;
        if (stays(column, row, step_of(tap))) {
            sum += number_at(tap + 2u) * beside(x, y, step_of(tap));
            weights += number_at(tap + 2u);
        }
    }
    // An image of one row or column lacks the channels that it has no pixel of
    return select(0.0, sum / weights, inside > 0u);
}

@compute @workgroup_size(8, 8)
fn bilinear(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= params.width || id.y >= params.strip_rows) {
        return;
    }
    let x = id.x + params.margin;
    let y = id.y + params.margin;
    let place = row_of(y) % 2u * 2u + column_of(x) % 2u;
    for (var channel = 0u; channel < 3u; channel++) {
        let list = params.neighbours + 2u * (3u * place + channel);
        let first = tables[list];
        // The pixel itself, where it sees the channel, is the nearest
        let is_measured = all(step_of(first) == vec2<i32>(0));
        var value = beside(x, y, vec2<i32>(0));
        if (!is_measured) {
            value = mean_of(first, tables[list + 1u], x, y);
        }
        planes[channel * params.plane + index_of(x, y)] = value;
    }
}
