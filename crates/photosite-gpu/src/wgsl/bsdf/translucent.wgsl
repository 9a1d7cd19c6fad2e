// Thin diffuse sheets; photosite-transport's bsdf/translucent.rs.

/// The part of the samples that stay on the side of wo; −1 where all is black.
fn translucent_part(bsdf: Bsdf) -> f32 {
    let reflected = mean_of(bsdf.first);
    let sum = reflected + mean_of(bsdf.second);
    return select(-1.0, reflected / sum, sum > 0.0);
}

fn eval_translucent(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    let part = translucent_part(bsdf);
    if (part < 0.0 || !is_above(wo) || is_grazing(wi)) {
        return no_scattering();
    }
    let is_reflected = wi.z > 0.0;
    let albedo = select(bsdf.second, bsdf.first, is_reflected);
    let pdf = select(1.0 - part, part, is_reflected) * abs(wi.z) * FRAC_1_PI;
    if (!(pdf > 0.0)) {
        return no_scattering();
    }
    return BsdfEval(albedo * FRAC_1_PI, pdf);
}

fn sample_translucent(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    let part = translucent_part(bsdf);
    if (part < 0.0) {
        return no_sample();
    }
    let is_transmission = u_lobe >= part;
    let up = cosine_hemisphere(u);
    let wi = select(up, mirrored(up), is_transmission);
    let scattering = eval_translucent(bsdf, wo, wi);
    var sample = reflected_sample(scattering.f, wi, scattering.pdf);
    sample.is_transmission = is_transmission;
    return sample;
}
