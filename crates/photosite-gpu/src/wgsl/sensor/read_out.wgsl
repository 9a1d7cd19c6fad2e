// Stages from charge to signals; photosite-sensor's stages/reset_noise.rs, dark_offset.rs, line_noise.rs,
// amplifiers.rs, read_noise.rs.

/// Charge at the input of the amplifiers, with what the read-out adds to it.
fn at_amplifiers(held_charge: vec2<f32>, place: vec2<u32>) -> vec2<f32> {
    var charge = held_charge;
    let x = 2u * place.x;
    if (exposure.reset_noise.streams.is_there == 1u) {
        let spread = vec2<f32>(exposure.reset_noise.standard_deviation_e);
        charge = rounded_sum(charge, rounded_product(spread, normals(OF_RESET_NOISE)));
    }
    if (is_there(exposure.dark_offset)) {
        charge = rounded_sum(charge, deviations(exposure.dark_offset, OF_DARK_OFFSET, place));
    }
    if (exposure.row_noise != NONE) {
        charge = rounded_sum(charge, vec2<f32>(of_row(exposure.row_noise, place.y)));
    }
    if (exposure.column_noise != NONE) {
        charge = rounded_sum(charge, of_columns(exposure.column_noise, x));
    }
    return nonlinear(charge);
}

/// q·(1 + c₁·q/F + c₂·(q/F)² + …): what is added to the charge is small, so that its rounding is nothing against that
/// of the sum.
fn nonlinear(charge: vec2<f32>) -> vec2<f32> {
    if (exposure.amplifiers.count == 0u) {
        return charge;
    }
    let part = clamp(charge / exposure.amplifiers.full_well_e, vec2<f32>(0.0), vec2<f32>(1.0));
    var sum = vec2<f32>(0.0);
    for (var i = exposure.amplifiers.count; i > 0u; i -= 1u) {
        sum = bitcast<f32>(tables[exposure.amplifiers.coefficients + i - 1u]) + sum * part;
    }
    return charge + charge * (part * sum);
}

/// Signals at the converter, DN above its black level, of a sensor with one gain.
fn amplified(charge: vec2<f32>, place: vec2<u32>) -> vec2<f32> {
    var signal = charge;
    let noise = exposure.read_noise;
    if (noise.streams.is_there == 1u) {
        var spread = vec2<f32>(noise.standard_deviation_e);
        if (noise.factors.streams.is_there == 1u) {
            for (var i = 0u; i < 2u; i += 1u) {
                let own = factor(noise.factors, OF_READ_NOISE_SPREAD, i);
                spread[i] = nearest_f32(wide_product_of(noise.standard_deviation, own));
            }
        }
        signal = rounded_sum(signal, rounded_product(spread, normals(OF_READ_NOISE)));
    }
    signal = rounded_product(signal, vec2<f32>(exposure.gain));
    let x = 2u * place.x;
    if (exposure.column_gains != NONE) {
        signal = rounded_sum(signal, rounded_product(signal, of_columns(exposure.column_gains, x)));
    }
    if (exposure.column_offsets != NONE) {
        signal = rounded_sum(signal, of_columns(exposure.column_offsets, x));
    }
    return signal;
}
