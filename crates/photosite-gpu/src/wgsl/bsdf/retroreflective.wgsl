// Sheeting that sends light back to where it comes from; photosite-transport's bsdf/retroreflective.rs. Of the BSDF `first` is
// the part of the light along the normal that returns, `second` the reflectance of the rest.

/// Part of the light at a cosine that enters a corner and leaves it; `CubeCorners::active_part`.
fn active_part(bsdf: Bsdf, cosine: f32) -> f32 {
    let index = bsdf.corners.x;
    let sin_squared = max(1.0 - cosine * cosine, 0.0);
    // Along the surface of an index of 1 it is infinite.
    let squared = 2.0 * sin_squared / (index * index - sin_squared);
    if (!(squared >= 0.0 && squared < 1.0)) {
        return 0.0;
    }
    let s = sqrt(squared);
    let other = sqrt(1.0 - squared);
    return max(FRAC_2_PI * (arc_tangent(other, s) - s * other), 0.0);
}

/// Active part of light from wo, and the part of the samples that go back; negative where all is black.
fn retroreflective_parts(bsdf: Bsdf, wo: vec3<f32>) -> vec2<f32> {
    let active_o = active_part(bsdf, wo.z);
    let returned = bsdf.first * active_o;
    let lobe = mean_of(returned);
    let sum = lobe + mean_of(bsdf.second * (1.0 - returned));
    return vec2<f32>(active_o, select(-1.0, lobe / sum, sum > 0.0));
}

fn eval_retroreflective(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    let parts = retroreflective_parts(bsdf, wo);
    if (parts.y < 0.0 || !(is_above(wo) && is_above(wi))) {
        return no_scattering();
    }
    let active_i = active_part(bsdf, wi.z);
    let left = (1.0 - bsdf.first * parts.x) * (1.0 - bsdf.first * active_i);
    var f = bsdf.second * left / (1.0 - bsdf.first * bsdf.corners.y) * FRAC_1_PI;
    var pdf = (1.0 - parts.y) * wi.z * FRAC_1_PI;
    if (!is_smooth(bsdf.roughness)) {
        let kernel = reflection(bsdf.roughness, vec3<f32>(-wo.xy, wo.z), wi);
        f += bsdf.first * (min(parts.x, active_i) * kernel.value);
        pdf += parts.y * kernel.pdf;
    }
    return BsdfEval(f, pdf);
}

fn sample_retroreflective(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    let parts = retroreflective_parts(bsdf, wo);
    if (!is_above(wo) || parts.y < 0.0) {
        return no_sample();
    }
    var wi: vec3<f32>;
    if (u_lobe >= parts.y) {
        wi = cosine_hemisphere(u);
    } else if (is_smooth(bsdf.roughness)) {
        return mirror_sample(bsdf.first * parts.x, wo, parts.y);
    } else {
        let seen = vec3<f32>(-wo.xy, wo.z);
        wi = reflect_at(seen, sample_visible(bsdf.roughness, seen, u));
    }
    let scattering = eval_retroreflective(bsdf, wo, wi);
    return reflected_sample(scattering.f, wi, scattering.pdf);
}
