// Metals; photosite-transport's bsdf/conductor.rs.

const HAS_METAL_BOUNCES = (SCENE_FEATURES & METAL_BOUNCES) != 0u;

/// Light that bounces more than once between facets: value f over what one bounce leaves of wi, and the probability of the
/// facets' lobe.
struct MetalBounces {
    value: vec4<f32>,
    facets: f32,
}

/// Mean reflectance of a metal over the hemisphere, by Gauss–Legendre quadrature; `mean_conductor`.
fn mean_metal_reflectance(eta: vec4<f32>, k: vec4<f32>) -> vec4<f32> {
    let cosines = vec4<f32>(0.06943184, 0.3300095, 0.6699905, 0.93056816);
    let weights = vec4<f32>(0.17392742, 0.32607258, 0.32607258, 0.17392742);
    var sum = vec4<f32>(0.0);
    for (var i = 0u; i < 4u; i += 1u) {
        sum += metal_reflectance(cosines[i], eta, k) * (2.0 * cosines[i] * weights[i]);
    }
    return sum;
}

/// Part of white light that one bounce leaves.
fn left_by_facets(bsdf: Bsdf, sight: Sight) -> f32 {
    let albedo = facet_albedo(bsdf.roughness, sight);
    return max(1.0 - albedo.x - albedo.y, 0.0);
}

fn metal_bounces(bsdf: Bsdf, wo: vec3<f32>) -> MetalBounces {
    let mean_left = left_by_facets(bsdf, Sight(vec3<f32>(0.0, 0.0, 1.0), true));
    if (mean_left <= NOTHING_LEFT) {
        return MetalBounces(vec4<f32>(0.0), 1.0);
    }
    let left = left_by_facets(bsdf, Sight(wo, false));
    let reflectance = mean_metal_reflectance(bsdf.first, bsdf.second);
    let given = further_bounces(1.0, reflectance, 1.0 - mean_left);
    let once = mean_of(reflectance) * (1.0 - left);
    let further = mean_of(given) * left;
    return MetalBounces(given * (FRAC_1_PI * left / mean_left), once / max(once + further, MIN_POSITIVE));
}

fn eval_conductor(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if (is_smooth(bsdf.roughness) || !(is_above(wo) && is_above(wi))) {
        return no_scattering();
    }
    let kernel = reflection(bsdf.roughness, wo, wi);
    let f = metal_reflectance(kernel.cos_facet, bsdf.first, bsdf.second) * kernel.value;
    if (!HAS_METAL_BOUNCES || !bsdf.is_compensated) {
        return BsdfEval(f, kernel.pdf);
    }
    let bounces = metal_bounces(bsdf, wo);
    let pdf = bounces.facets * kernel.pdf + (1.0 - bounces.facets) * wi.z * FRAC_1_PI;
    return BsdfEval(f + bounces.value * left_by_facets(bsdf, Sight(wi, false)), pdf);
}

fn sample_conductor(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    if (!is_above(wo)) {
        return no_sample();
    }
    if (is_smooth(bsdf.roughness)) {
        let wi = vec3<f32>(-wo.xy, wo.z);
        return mirror_sample(metal_reflectance(min(wo.z, 1.0), bsdf.first, bsdf.second), wi, 1.0);
    }
    let m = sample_visible(bsdf.roughness, wo, u);
    let wi = reflect_at(wo, m);
    if (HAS_METAL_BOUNCES && bsdf.is_compensated) {
        let either = select(cosine_hemisphere(u), wi, u_lobe < metal_bounces(bsdf, wo).facets);
        let scattering = eval_conductor(bsdf, wo, either);
        return reflected_sample(scattering.f, either, scattering.pdf);
    }
    if (!(wi.z > GRAZING)) {
        return no_sample();
    }
    let kernel = reflection_at(bsdf.roughness, wo, wi, m);
    return reflected_sample(metal_reflectance(kernel.cos_facet, bsdf.first, bsdf.second) * kernel.value, wi, kernel.pdf);
}
