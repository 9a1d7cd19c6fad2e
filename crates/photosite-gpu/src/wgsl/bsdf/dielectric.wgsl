// Clear media; photosite-transport's bsdf/dielectric.rs.

const HAS_GLASS_BOUNCES = (SCENE_FEATURES & GLASS_BOUNCES) != 0u;

fn is_delta_dielectric(bsdf: Bsdf) -> bool {
    return is_delta_interface(bsdf.first.x, bsdf.roughness);
}

/// Light that bounces more than once between facets: what one bounce leaves of wo, the factors of reflection and
/// transmission, and the part that crosses.
struct GlassBounces {
    left: f32,
    scales: vec2<f32>,
    crossing: f32,
}

/// Bounces between facets that `wo` sees from above; nothing is left where the model leaves them out.
fn glass_bounces(bsdf: Bsdf, eta: f32, wo: vec3<f32>) -> GlassBounces {
    if (!HAS_GLASS_BOUNCES || !bsdf.is_compensated) {
        return GlassBounces(0.0, vec2<f32>(0.0), 0.0);
    }
    let mean = 1.0 - glass_albedo(eta, bsdf.roughness, Sight(vec3<f32>(0.0, 0.0, 1.0), true));
    if (max(mean.x, mean.y) <= NOTHING_LEFT) {
        return GlassBounces(0.0, vec2<f32>(0.0), 0.0);
    }
    let shared_parts = shared_out(1.0, eta, vec4<f32>(mean.x), vec4<f32>(mean.y));
    let left = max(1.0 - glass_albedo(eta, bsdf.roughness, Sight(wo, false)).x, 0.0);
    return GlassBounces(left, vec2<f32>(shared_parts.here.x, shared_parts.behind.x), shared_parts.crossing.x);
}

/// Value and density of one bounce at facets, wo above them; `eval_rough`.
fn eval_glass_facets(bsdf: Bsdf, eta: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec2<f32> {
    if (wi.z > 0.0) {
        let kernel = reflection(bsdf.roughness, wo, wi);
        return vec2<f32>(kernel.value, kernel.pdf) * interface_of(kernel.cos_facet, eta).reflectance;
    }
    var facet = refracting_facet(wo, wi, eta);
    if (!(facet.cos_o > 0.0 && facet.cos_i > 0.0)) {
        return vec2<f32>(0.0);
    }
    facet.transmittance = interface_between(min(facet.cos_o, 1.0), min(facet.cos_i, 1.0), eta).transmittance;
    return refraction(bsdf.roughness, wo, wi, facet);
}

/// Value and density of both lobes together, of which the facets' own are given.
fn with_glass_bounces(bsdf: Bsdf, bounces: GlassBounces, eta: f32, wi: vec3<f32>, facets: vec2<f32>) -> vec2<f32> {
    let cosine = abs(wi.z);
    let is_behind = wi.z < 0.0;
    let bounced = glass_albedo(eta, bsdf.roughness, Sight(vec3<f32>(wi.xy, cosine), false));
    let other = max(1.0 - select(bounced.x, bounced.y, is_behind), 0.0);
    let share = select(1.0 - bounces.crossing, bounces.crossing, is_behind);
    let value = select(bounces.scales.x, bounces.scales.y, is_behind) * bounces.left * other;
    return vec2<f32>(facets.x + value, (1.0 - bounces.left) * facets.y + bounces.left * share * cosine * FRAC_1_PI);
}

fn eval_dielectric(bsdf: Bsdf, wo_seen: vec3<f32>, wi_seen: vec3<f32>) -> BsdfEval {
    if (is_delta_dielectric(bsdf) || is_grazing(wo_seen) || is_grazing(wi_seen)) {
        return no_scattering();
    }
    let is_below = wo_seen.z < 0.0;
    let eta = select(bsdf.first.x, 1.0 / bsdf.first.x, is_below);
    let wo = select(wo_seen, mirrored(wo_seen), is_below);
    let wi = select(wi_seen, mirrored(wi_seen), is_below);
    var both = eval_glass_facets(bsdf, eta, wo, wi);
    if (HAS_GLASS_BOUNCES) {
        let bounces = glass_bounces(bsdf, eta, wo);
        if (bounces.left > 0.0) {
            both = with_glass_bounces(bsdf, bounces, eta, wi, both);
        }
    }
    return BsdfEval(lanes_of(both.x, bsdf.is_dispersive), both.y);
}

/// Samples either lobe in proportion to the light that it gives back, wo above the facets; `Bounces::sample`.
fn sample_bounced_dielectric(bsdf: Bsdf, bounces: GlassBounces, eta: f32, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    let facets = 1.0 - bounces.left;
    var wi: vec3<f32>;
    if (u_lobe < facets) {
        let facet = sample_rough_dielectric(bsdf, eta, wo, u_lobe / facets, u);
        if (!(facet.pdf > 0.0)) {
            return no_sample();
        }
        wi = facet.wi;
    } else {
        let spread = cosine_hemisphere(u);
        wi = select(spread, mirrored(spread), u_lobe - facets < bounces.left * bounces.crossing);
    }
    if (is_grazing(wi)) {
        return no_sample();
    }
    let both = with_glass_bounces(bsdf, bounces, eta, wi, eval_glass_facets(bsdf, eta, wo, wi));
    let is_transmission = wi.z < 0.0;
    let f = lanes_of(both.x, bsdf.is_dispersive);
    return BsdfSample(f, both.y, wi, select(1.0, eta, is_transmission), false, is_transmission, bsdf.is_dispersive);
}

/// Samples a smooth interface, with wo above it.
fn sample_smooth_dielectric(eta: vec4<f32>, is_dispersive: bool, wo: vec3<f32>, u_lobe: f32) -> BsdfSample {
    let cos_o = min(wo.z, 1.0);
    let at_hero = interface_of(cos_o, eta.x);
    if (u_lobe < at_hero.reflectance) {
        var of_lanes = vec4<f32>(at_hero.reflectance);
        if (is_dispersive) {
            of_lanes.y = interface_of(cos_o, eta.y).reflectance;
            of_lanes.z = interface_of(cos_o, eta.z).reflectance;
            of_lanes.w = interface_of(cos_o, eta.w).reflectance;
        }
        return mirror_sample(of_lanes, vec3<f32>(-wo.xy, wo.z), at_hero.reflectance);
    }
    if (at_hero.cos_transmitted <= GRAZING) {
        return no_sample();
    }
    let f = at_hero.transmittance / (eta.x * eta.x * at_hero.cos_transmitted);
    let wi = vec3<f32>(-wo.xy / eta.x, -at_hero.cos_transmitted);
    return BsdfSample(lanes_of(f, is_dispersive), at_hero.transmittance, wi, eta.x, true, true, is_dispersive);
}

/// Samples facets, wo above them.
fn sample_rough_dielectric(bsdf: Bsdf, eta: f32, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    let m = sample_visible(bsdf.roughness, wo, u);
    let cos_o = clamp(dot(wo, m), 0.0, 1.0);
    let at_facet = interface_of(cos_o, eta);
    if (u_lobe < at_facet.reflectance) {
        let wi = reflect_at(wo, m);
        if (!(wi.z > GRAZING)) {
            return no_sample();
        }
        let kernel = reflection_at(bsdf.roughness, wo, wi, m);
        var sample = reflected_sample(lanes_of(kernel.value * at_facet.reflectance, bsdf.is_dispersive), wi, kernel.pdf * at_facet.reflectance);
        sample.terminates_secondary = bsdf.is_dispersive;
        return sample;
    }
    let cos_i = at_facet.cos_transmitted;
    let wi = (cos_o / eta - cos_i) * m - wo / eta;
    if (!(cos_o > 0.0 && cos_i > 0.0 && wi.z < -GRAZING)) {
        return no_sample();
    }
    let facet = Refraction(eta, m, cos_o, cos_i, abs(cos_o - eta * cos_i), at_facet.transmittance);
    let both = refraction(bsdf.roughness, wo, wi, facet);
    return BsdfSample(lanes_of(both.x, bsdf.is_dispersive), both.y, wi, eta, false, true, bsdf.is_dispersive);
}

fn sample_dielectric(bsdf: Bsdf, wo_seen: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    if (is_grazing(wo_seen)) {
        return no_sample();
    }
    let is_below = wo_seen.z < 0.0;
    let eta = select(bsdf.first, 1.0 / bsdf.first, is_below);
    let wo = select(wo_seen, mirrored(wo_seen), is_below);
    var sample: BsdfSample;
    if (is_delta_dielectric(bsdf)) {
        sample = sample_smooth_dielectric(eta, bsdf.is_dispersive, wo, u_lobe);
    } else {
        let bounces = glass_bounces(bsdf, eta.x, wo);
        if (HAS_GLASS_BOUNCES && bounces.left > 0.0) {
            sample = sample_bounced_dielectric(bsdf, bounces, eta.x, wo, u_lobe, u);
        } else {
            sample = sample_rough_dielectric(bsdf, eta.x, wo, u_lobe, u);
        }
    }
    sample.wi = select(sample.wi, mirrored(sample.wi), is_below);
    return sample;
}

/// The boundary of a medium of index 1 lets all light straight on.
fn straight_dielectric(bsdf: Bsdf, wo: vec3<f32>) -> vec4<f32> {
    return select(vec4<f32>(0.0), vec4<f32>(1.0), bsdf.has_index_one && !is_grazing(wo));
}
