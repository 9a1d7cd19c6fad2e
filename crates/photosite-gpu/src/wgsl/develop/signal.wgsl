// Raw numbers become a white-balanced signal, black at 0 and saturation of the most sensitive channel at 1;
// photosite-develop's linearisation.rs, black_level.rs, opcodes.rs, white_balance.rs and photosite-raw's gain_map.rs.

/// First word of the place of the tile that a number of the active area has.
fn place_of(number: u32, row: u32) -> u32 {
    let place = row % params.tile_rows * params.tile_columns + number % params.tile_columns;
    return params.places + PLACE_WORDS * place;
}

fn channel_at(place: u32) -> u32 {
    return tables[place + 3u];
}

/// Stored number at a place along a row of the active area, made linear.
fn linear_number(number: u32, row: u32) -> f32 {
    // Wraps where the first number that is here comes later in the image
    let at = params.first_number + row * params.row_length + number;
    let stored = (numbers[at >> 1u] >> (16u * (at & 1u))) & 0xffffu;
    if (params.linear_entries == 0u) {
        return f32(stored);
    }
    return f32(tables[params.linearisation + min(stored, params.linear_entries - 1u)]);
}

fn mix_gains(a: f32, b: f32, part: f32) -> f32 {
    return a + (b - a) * part;
}

/// Value after the gains of a map.
fn with_gain(value: f32, map: u32, number: u32, row: u32) -> f32 {
    let across = tables[map] + LINE_WORDS * number;
    let down = tables[map + 1u] + LINE_WORDS * row;
    let gains = tables[map + 2u];
    let left = tables[across];
    let above = tables[down];
    if (left == NONE || above == NONE) {
        return value;
    }
    let right = tables[across + 1u];
    let below = tables[down + 1u];
    let part = number_at(across + 2u);
    // Along both rows of gains, and then between them
    let upper = mix_gains(number_at(gains + above + left), number_at(gains + above + right), part);
    let lower = mix_gains(number_at(gains + below + left), number_at(gains + below + right), part);
    return value * mix_gains(upper, lower, number_at(down + 2u));
}

@compute @workgroup_size(8, 8)
fn signal(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = id.x / params.samples;
    let y = id.y;
    if (x >= params.columns || y >= params.rows) {
        return;
    }
    // Pixels of the margin are those of the mirrored image
    let column = mirror(x, params.margin, params.width);
    let row = mirror(params.top + y, params.margin, params.height);
    let number = column * params.samples + id.x % params.samples;

    let place = place_of(number, row);
    var value = (linear_number(number, row) - number_at(place)) * number_at(place + 1u);
    for (var i = 0u; i < params.gain_map_count; i++) {
        value = with_gain(value, params.gain_maps + MAP_WORDS * i, number, row);
    }
    value = min(value * number_at(place + 2u), params.ceiling);

    // Values that need no demosaicking are those of their planes
    if (params.margin == 0u) {
        planes[channel_at(place) * params.plane + index_of(x, y)] = value;
    } else {
        mosaic[index_of(x, y)] = value;
    }
}
