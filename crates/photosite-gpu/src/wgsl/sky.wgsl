// The sky by day, the sun and the ground; photosite-transport's light/sky.rs.

struct Sun {
    direction: vec3<f32>,
    /// Cosine of its radius.
    edge: f32,
    /// Part of the samples that go to it; 0 where it is not there.
    part: f32,
}

fn sun() -> Sun {
    let head = bitcast<vec4<f32>>(tables[params.sky]);
    return Sun(head.xyz, head.w, bitcast<f32>(tables[params.sky + 1u].w));
}

/// Radiance at a knot of wavelength; `radiance_at`.
fn sky_at(knot: u32, cos_theta: f32, gamma: f32, cos_gamma: f32) -> f32 {
    let at = params.sky + 2u + 3u * knot;
    let abcd = bitcast<vec4<f32>>(tables[at]);
    let efgh = bitcast<vec4<f32>>(tables[at + 1u]);
    let i = bitcast<f32>(tables[at + 2u].x);
    let level = bitcast<f32>(tables[at + 2u].y);
    let stretch = 1.0 + i * i - 2.0 * i * cos_gamma;
    let chi = (1.0 + cos_gamma * cos_gamma) / (stretch * sqrt(stretch));
    let low = 1.0 + abcd.x * exp(abcd.y / (cos_theta + 0.01));
    let high = abcd.z + abcd.w * exp(efgh.x * gamma) + efgh.y * cos_gamma * cos_gamma + efgh.z * chi + efgh.w * sqrt(max(cos_theta, 0.0));
    return max(low * high * level, 0.0);
}

fn sky_radiance(towards: vec3<f32>, lambda_nm: vec4<f32>) -> vec4<f32> {
    let spectra_words = tables[params.sky + 1u];
    if (towards.y <= 0.0) {
        return spectrum(spectra_words.z, lambda_nm);
    }
    let the_sun = sun();
    let cos_gamma = clamp(dot(towards, the_sun.direction), -1.0, 1.0);
    let gamma = arc_cosine(cos_gamma);
    var sky = vec4<f32>(0.0);
    for (var lane = 0u; lane < 4u; lane += 1u) {
        let last = SKY_FIRST_NM + SKY_STEP_NM * f32(SKY_KNOTS - 1u);
        let position = (clamp(lambda_nm[lane], SKY_FIRST_NM, last) - SKY_FIRST_NM) / SKY_STEP_NM;
        let knot = min(u32(position), SKY_KNOTS - 2u);
        let part = position - f32(knot);
        sky[lane] = sky_at(knot, towards.y, gamma, cos_gamma) * (1.0 - part) + sky_at(knot + 1u, towards.y, gamma, cos_gamma) * part;
    }
    sky *= spectrum(spectra_words.x, lambda_nm);
    if (the_sun.part > 0.0 && cos_gamma >= the_sun.edge) {
        sky += spectrum(spectra_words.y, lambda_nm);
    }
    return sky;
}

fn density_of_sky(towards: vec3<f32>) -> f32 {
    let sine = length(towards.xz);
    if (sine == 0.0) {
        return 0.0;
    }
    let uv = vec2<f32>(0.5 + arc_tangent(towards.x, -towards.z) / TAU, arc_tangent(sine, towards.y) / PI);
    let of_rest = density_in_square(clamp(uv, vec2<f32>(0.0), vec2<f32>(0.99999988))) / (TAU * PI * sine);
    let the_sun = sun();
    let is_sun = dot(towards, the_sun.direction) >= the_sun.edge;
    let of_sun = select(0.0, 1.0 / (TAU * (1.0 - the_sun.edge)), is_sun);
    return the_sun.part * of_sun + (1.0 - the_sun.part) * of_rest;
}

/// A direction towards the sky, the sun or the ground, with its density; 0 for none.
fn sample_sky(u: vec2<f32>) -> vec4<f32> {
    let the_sun = sun();
    var towards: vec3<f32>;
    if (u.x < the_sun.part) {
        towards = to_world(frame_from_normal(the_sun.direction), uniform_cone(vec2<f32>(u.x / the_sun.part, u.y), the_sun.edge));
    } else {
        let uv = sample_square(vec2<f32>((u.x - the_sun.part) / (1.0 - the_sun.part), u.y));
        let theta = PI * uv.y;
        let phi = TAU * (uv.x - 0.5);
        towards = vec3<f32>(sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi));
    }
    return vec4<f32>(towards, density_of_sky(towards));
}
