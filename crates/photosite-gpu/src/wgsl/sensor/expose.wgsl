// Exposure of two neighbours of a row, from mean electrons to digital numbers; photosite-sensor's chain/expose.rs.

@compute @workgroup_size(WORKGROUP_SIZE)
fn expose(@builtin(global_invocation_id) id: vec3<u32>) {
    let words_of_row = (exposure.width + 1u) / 2u;
    let place = vec2<u32>(id.x, strip.first_row + id.y);
    if (place.x >= words_of_row || place.y >= exposure.height) {
        return;
    }
    let x = 2u * place.x;
    let from_left = i32(x) - i32(exposure.light_left);
    let from_top = i32(place.y) - i32(exposure.light_top);
    draw_normals(place);
    var mean = vec2<f32>(0.0);
    for (var i = 0; i < 2; i += 1) {
        mean[i] = collected(from_left + i, from_top);
    }
    let charge = at_amplifiers(held(freed(responded(mean, place), place), place), place);
    var signals = vec2<f32>(0.0);
    if (exposure.dual_gain.is_there == 0u) {
        signals = amplified(charge, place);
    }
    var word = 0u;
    for (var i = 0u; i < 2u && x + i < exposure.width; i += 1u) {
        var number: u32;
        if (exposure.dual_gain.is_there == 1u) {
            number = merged_number(charge[i], x + i);
        } else {
            number = digital_number(exposure.digitiser, level_of(signals[i]), x + i);
        }
        word |= sent(number, x + i, place.y) << (16u * i);
    }
    numbers[place.y * words_of_row + place.x] = word;
}
