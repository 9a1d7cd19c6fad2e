// Camera channels become the light that is shown; photosite-develop's highlights.rs, colour.rs, tone/filmic.rs and
// colour_model.rs.

/// x(2.51x + 0.03)/(x(2.43x + 0.59) + 0.14), up to where squares would overflow.
fn filmic(light: vec3<f32>) -> vec3<f32> {
    let x = clamp(light, vec3<f32>(0.0), vec3<f32>(1e6));
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

/// Linear components of a pixel; of grey the first alone counts.
fn shown(i: u32) -> vec3<f32> {
    // What demosaicking took beyond white is clipped
    let first = min(planes[i], params.ceiling);
    let a = vec3<f32>(params.a_r, params.a_g, params.a_b);
    var light = a * first;
    if (params.channels == 3u) {
        let second = min(planes[params.plane + i], params.ceiling);
        let third = min(planes[2u * params.plane + i], params.ceiling);
        let b = vec3<f32>(params.b_r, params.b_g, params.b_b);
        let c = vec3<f32>(params.c_r, params.c_g, params.c_b);
        light = light + b * second + c * third;
    }
    if (params.is_filmic == 1u) {
        light = filmic(light);
    }
    if (params.is_grey == 1u) {
        light.x = params.weight_r * light.x + params.weight_g * light.y + params.weight_b * light.z;
    }
    return light;
}
