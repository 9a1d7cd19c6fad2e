// Lambert's law; photosite-transport's bsdf/diffuse.rs.

fn eval_diffuse(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if (!(is_above(wo) && is_above(wi))) {
        return no_scattering();
    }
    return BsdfEval(bsdf.first * FRAC_1_PI, wi.z * FRAC_1_PI);
}

fn sample_diffuse(bsdf: Bsdf, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    let wi = cosine_hemisphere(u);
    let scattering = eval_diffuse(bsdf, wo, wi);
    return reflected_sample(scattering.f, wi, scattering.pdf);
}
