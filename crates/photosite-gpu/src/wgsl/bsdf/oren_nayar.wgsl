// Diffuse surfaces with relief; photosite-transport's bsdf/oren_nayar.rs.

/// The function G at a cosine.
fn relief_g(cosine: f32) -> f32 {
    let z = min(cosine, 1.0);
    let sine = sqrt(max(1.0 - z * z, 0.0));
    let last = sine * z * (1.0 + sine + sine * sine) / (1.0 + sine);
    return sine * ((PI / 2.0 - asin(z)) - sine * z) + 2.0 / 3.0 * (last - sine);
}

fn eval_oren_nayar(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if (!(is_above(wo) && is_above(wi))) {
        return no_scattering();
    }
    let roughness = bsdf.roughness.x;
    let a = 1.0 / (1.0 + (0.5 - 2.0 / 3.0 * FRAC_1_PI) * roughness);
    let s = dot(wo, wi) - wo.z * wi.z;
    let t = select(1.0, max(wo.z, wi.z), s > 0.0);
    var f = bsdf.first * max(a * (1.0 + roughness * s / t), 0.0);
    let mean = a * (1.0 + (2.0 / 3.0 - 28.0 / 15.0 * FRAC_1_PI) * roughness);
    if (1.0 - mean > 1e-5) {
        let lost_o = max(1.0 - a * (1.0 + roughness * FRAC_1_PI * relief_g(wo.z)), 0.0);
        let lost_i = max(1.0 - a * (1.0 + roughness * FRAC_1_PI * relief_g(wi.z)), 0.0);
        let bounced = bsdf.first * bsdf.first * mean / (1.0 - bsdf.first * (1.0 - mean));
        f += bounced * (lost_o * lost_i / (1.0 - mean));
    }
    return BsdfEval(f * FRAC_1_PI, (0.5 * wi.z + 0.25) * FRAC_1_PI);
}

fn sample_oren_nayar(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    let wi = select(cosine_hemisphere(u), uniform_cone(u, 0.0), u_lobe < 0.5);
    let scattering = eval_oren_nayar(bsdf, wo, wi);
    return reflected_sample(scattering.f, wi, scattering.pdf);
}
