// Metals; photosite-transport's bsdf/conductor.rs, without energy compensation.

fn eval_conductor(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if (is_smooth(bsdf.roughness) || !(is_above(wo) && is_above(wi))) {
        return no_scattering();
    }
    let kernel = reflection(bsdf.roughness, wo, wi);
    return BsdfEval(metal_reflectance(kernel.cos_facet, bsdf.first, bsdf.second) * kernel.value, kernel.pdf);
}

fn sample_conductor(bsdf: Bsdf, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    if (!is_above(wo)) {
        return no_sample();
    }
    if (is_smooth(bsdf.roughness)) {
        let wi = vec3<f32>(-wo.xy, wo.z);
        return mirror_sample(metal_reflectance(min(wo.z, 1.0), bsdf.first, bsdf.second), wi, 1.0);
    }
    let m = sample_visible(bsdf.roughness, wo, u);
    let wi = reflect_at(wo, m);
    if (!(wi.z > GRAZING)) {
        return no_sample();
    }
    let kernel = reflection_at(bsdf.roughness, wo, wi, m);
    return reflected_sample(metal_reflectance(kernel.cos_facet, bsdf.first, bsdf.second) * kernel.value, wi, kernel.pdf);
}
