// Stages by which light and heat free charge, and wells hold it; photosite-sensor's stages/crosstalk.rs,
// masked_pixels.rs, fixed_pattern.rs, photo_response.rs, dead_pixels.rs, shot_noise.rs, dark_current.rs, full_well.rs.

/// Mean electrons of a value of the light, with those that neighbours lose to it.
fn collected(x: i32, y: i32) -> f32 {
    let width = i32(exposure.light_width);
    let height = i32(exposure.light_height);
    if (x < 0 || y < 0 || x >= width || y >= height) {
        return 0.0;
    }
    if (exposure.crosstalk.displacements == NONE) {
        return light[y * width + x];
    }
    var sum = vec2<f32>(0.0);
    for (var i = 0u; i < exposure.crosstalk.count; i += 1u) {
        let at = exposure.crosstalk.displacements + 4u * i;
        let channel = tables[at];
        let step = vec2<i32>(i32(tables[at + 1u]), i32(tables[at + 2u]));
        let part = bitcast<f32>(tables[at + 3u]);
        let source = vec2<i32>(x, y) - step;
        if (is_inside(source) && channel_at(source) == channel) {
            let given = rounded_product(vec2<f32>(part), vec2<f32>(light[source.y * width + source.x]));
            sum = rounded_sum(sum, given);
        }
        // What would leave the image stays
        if (!is_inside(vec2<i32>(x, y) + step) && channel_at(vec2<i32>(x, y)) == channel) {
            sum = rounded_sum(sum, rounded_product(vec2<f32>(part), vec2<f32>(light[y * width + x])));
        }
    }
    return sum.x;
}

fn is_inside(at: vec2<i32>) -> bool {
    return all(at >= vec2<i32>(0)) && at.x < i32(exposure.light_width) && at.y < i32(exposure.light_height);
}

/// Channel of a value inside of the light.
fn channel_at(at: vec2<i32>) -> u32 {
    let column = u32(at.x) % exposure.crosstalk.tile_width;
    let row = u32(at.y) % exposure.crosstalk.tile_height;
    return tables[exposure.crosstalk.tile + row * exposure.crosstalk.tile_width + column];
}

/// Deviations of both neighbours from a pattern, which takes the normal numbers of a stage.
fn deviations(pattern: PatternWords, stage: u32, place: vec2<u32>) -> vec2<f32> {
    let x = 2u * place.x;
    if (pattern.measured != NONE) {
        return of_columns(pattern.measured + place.y * exposure.width, x);
    }
    var of_lines = vec2<f32>(of_row(pattern.rows, place.y));
    if (pattern.columns != NONE) {
        of_lines = rounded_sum(of_lines, of_columns(pattern.columns, x));
    }
    if (pattern.streams.is_there == 1u) {
        return rounded_sum(rounded_product(vec2<f32>(pattern.pixel), normals(stage)), of_lines);
    }
    return of_lines;
}

fn is_there(pattern: PatternWords) -> bool {
    return pattern.rows != NONE || pattern.measured != NONE;
}

/// Mean electrons of both neighbours that respond to light.
fn responded(mean: vec2<f32>, place: vec2<u32>) -> vec2<f32> {
    var charge = mean;
    if (is_there(exposure.photo_response)) {
        let deviation = deviations(exposure.photo_response, OF_PHOTO_RESPONSE, place);
        charge = rounded_product(charge, max(rounded_sum(vec2<f32>(1.0), deviation), vec2<f32>(0.0)));
    }
    for (var i = 0u; i < 2u; i += 1u) {
        if (listed(exposure.dead_pixels, 2u * place.x + i, place.y) != NONE) {
            charge[i] = 0.0;
        }
    }
    return charge;
}

/// Electrons that light frees, drawn from the distribution of their mean, and then those that heat does.
fn freed(mean: vec2<f32>, place: vec2<u32>) -> vec2<f32> {
    var charge = mean;
    for (var stage = 0u; stage < 2u; stage += 1u) {
        let is_dark = stage == 1u;
        var streams = exposure.shot_noise;
        if (is_dark) {
            streams = exposure.dark_current.streams;
        }
        if (streams.is_there == 0u) {
            continue;
        }
        let block = first_block(streams, place);
        var counts = vec2<f32>(0.0);
        for (var i = 0u; i < 2u; i += 1u) {
            var own = wide_of_f32(mean[i]);
            if (is_dark) {
                own = dark_mean(i);
            }
            // Where pixels are alike in the dark it is known
            let dark = exposure.dark_current;
            var e_to_minus_mean = vec2<u32>(dark.e_to_minus_mean_low, dark.e_to_minus_mean_high);
            if (is_few(own) && !(is_dark && dark.factors.streams.is_there == 0u)) {
                e_to_minus_mean = e_to_minus(own);
            }
            var random = stream_of(streams, place, block, i);
            counts[i] = counted(own, e_to_minus_mean, &random);
        }
        if (is_dark) {
            charge = rounded_sum(charge, counts);
        } else {
            charge = counts;
        }
    }
    return charge;
}

/// Mean thermal electrons of the first or the second neighbour.
fn dark_mean(index: u32) -> Wide {
    let mean = exposure.dark_current.mean;
    if (exposure.dark_current.factors.streams.is_there == 0u) {
        return mean;
    }
    return wide_product_of(mean, factor(exposure.dark_current.factors, OF_DARK_CURRENT, index));
}

/// Charge in the wells of both neighbours.
fn held(freed: vec2<f32>, place: vec2<u32>) -> vec2<f32> {
    var charge = freed;
    for (var i = 0u; i < 2u; i += 1u) {
        let hot = listed(exposure.hot_pixels, 2u * place.x + i, place.y);
        if (hot != NONE) {
            charge[i] = rounded_sum(charge, vec2<f32>(bitcast<f32>(tables[hot])))[i];
        }
    }
    return min(charge, vec2<f32>(exposure.full_well_e));
}
