// Linear light becomes the codes of an image that stands upright; photosite-develop's encode.rs and photosite-raw's
// orientation.rs.

/// The code of a value: the number of levels that it reaches, none for what is no number.
fn code_of(value: f32) -> u32 {
    var code = 0u;
    // Halves what is left of the levels: 255 or 65535 of them
    for (var step = 1u << (params.bits - 1u); step > 0u; step >>= 1u) {
        if (value >= number_at(params.levels + code + step - 1u)) {
            code += step;
        }
    }
    return code;
}

/// Four pixels each, whose codes fill whole words.
@compute @workgroup_size(64)
fn encode(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixels = params.turned_columns * params.turned_rows;
    if (4u * id.x >= pixels) {
        return;
    }
    var at = id.x * params.components * params.bits / 8u;
    var word = 0u;
    var shift = 0u;
    for (var k = 0u; k < 4u; k++) {
        let pixel = 4u * id.x + k;
        var light = vec3<f32>(0.0);
        if (pixel < pixels) {
            // Pixel of the strip that stands there
            let x = i32(pixel % params.turned_columns);
            let y = i32(pixel / params.turned_columns);
            let column = params.first_x + x * params.right_x + y * params.down_x;
            let row = params.first_y + x * params.right_y + y * params.down_y;
            light = shown(index_of(u32(column) + params.margin, u32(row) + params.margin));
        }
        for (var component = 0u; component < params.components; component++) {
            word |= code_of(light[component]) << shift;
            shift += params.bits;
            if (shift == 32u) {
                codes[at] = word;
                at++;
                word = 0u;
                shift = 0u;
            }
        }
    }
}
