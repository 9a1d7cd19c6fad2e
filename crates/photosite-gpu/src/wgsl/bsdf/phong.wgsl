// Phong's model; photosite-transport's bsdf/phong.rs.

/// The part of the samples that go to the lobe; −1 where all is black.
fn phong_lobe_part(bsdf: Bsdf) -> f32 {
    let specular = mean_of(bsdf.second);
    let sum = mean_of(bsdf.first) + specular;
    return select(-1.0, specular / sum, sum > 0.0);
}

fn eval_phong(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    let lobe = phong_lobe_part(bsdf);
    if (lobe < 0.0 || !(is_above(wo) && is_above(wi))) {
        return no_scattering();
    }
    let exponent = bsdf.roughness.x;
    let cosine = clamp(dot(vec3<f32>(-wo.xy, wo.z), wi), 0.0, 1.0);
    // 0⁰ is 1, and no power of 0 is asked for.
    let power = select(select(0.0, pow(cosine, exponent), cosine > 0.0), 1.0, exponent == 0.0);
    let f = bsdf.first * FRAC_1_PI + bsdf.second * ((exponent + 2.0) / TAU * power);
    return BsdfEval(f, (1.0 - lobe) * wi.z * FRAC_1_PI + lobe * (exponent + 1.0) / TAU * power);
}

fn sample_phong(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    let lobe = phong_lobe_part(bsdf);
    if (lobe < 0.0) {
        return no_sample();
    }
    var wi = cosine_hemisphere(u);
    if (u_lobe < lobe) {
        let cosine = pow(1.0 - u.y, 1.0 / (bsdf.roughness.x + 1.0));
        let turn = sin_cos_turn(u.x);
        let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
        wi = to_world(frame_from_normal(vec3<f32>(-wo.xy, wo.z)), vec3<f32>(sine * turn.y, sine * turn.x, cosine));
    }
    let scattering = eval_phong(bsdf, wo, wi);
    return reflected_sample(scattering.f, wi, scattering.pdf);
}
