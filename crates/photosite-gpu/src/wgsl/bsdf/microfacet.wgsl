// GGX microfacets; photosite-transport's bsdf/microfacet.rs, bsdf/refraction.rs.

fn is_smooth(alpha: vec2<f32>) -> bool {
    return alpha.x == 0.0;
}

/// Area of facets whose normal is m, per unit of surface.
fn facet_density(alpha: vec2<f32>, m: vec3<f32>) -> f32 {
    let p = m.xy / alpha;
    let stretched = dot(p, p) + m.z * m.z;
    return FRAC_1_PI / (alpha.x * alpha.y * stretched * stretched);
}

fn stretched_length(alpha: vec2<f32>, w: vec3<f32>) -> f32 {
    let p = alpha * w.xy;
    return sqrt(dot(p, p) + w.z * w.z);
}

/// A facet normal that wo sees.
fn sample_visible(alpha: vec2<f32>, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    let stretched = normalize(vec3<f32>(alpha * wo.xy, wo.z));
    let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    let radius = sqrt(max(1.0 - z * z, 0.0));
    let turn = sin_cos_turn(u.x);
    let m = vec3<f32>(radius * turn.y, radius * turn.x, z) + stretched;
    return normalize(vec3<f32>(alpha * m.xy, max(m.z, MIN_POSITIVE)));
}

/// D·G₂/(4·zₒ·zᵢ), the density of wi, and the cosine to the facet.
struct ReflectionKernel {
    value: f32,
    pdf: f32,
    cos_facet: f32,
}

fn reflection_at(alpha: vec2<f32>, wo: vec3<f32>, wi: vec3<f32>, m: vec3<f32>) -> ReflectionKernel {
    let density = facet_density(alpha, m);
    let s_o = stretched_length(alpha, wo);
    let s_i = stretched_length(alpha, wi);
    return ReflectionKernel(density / (2.0 * (s_o * wi.z + s_i * wo.z)), density / (2.0 * (wo.z + s_o)), clamp(dot(wo, m), 0.0, 1.0));
}

fn reflection(alpha: vec2<f32>, wo: vec3<f32>, wi: vec3<f32>) -> ReflectionKernel {
    return reflection_at(alpha, wo, wi, normalize(wo + wi));
}

fn reflect_at(w: vec3<f32>, m: vec3<f32>) -> vec3<f32> {
    return (2.0 * dot(w, m)) * m - w;
}

/// A facet that refracts wo into wi.
struct Refraction {
    eta: f32,
    m: vec3<f32>,
    cos_o: f32,
    cos_i: f32,
    stretch: f32,
    transmittance: f32,
}

/// The facet that refracts wo, above it, into wi, below it, with a transmittance of 1; `Refraction::between`.
fn refracting_facet(wo: vec3<f32>, wi: vec3<f32>, eta: f32) -> Refraction {
    let sum = wo + eta * wi;
    let stretch = length(sum);
    let m = sum / with_sign(stretch, sum.z);
    return Refraction(eta, m, dot(wo, m), -dot(wi, m), stretch, 1.0);
}

const SMALLEST_BLUR = 2e-6f;

/// Whether an interface sends light into two directions only; `refraction::is_delta`.
fn is_delta_interface(eta: f32, alpha: vec2<f32>) -> bool {
    return is_smooth(alpha) || max(alpha.x, alpha.y) * abs(eta - 1.0) < SMALLEST_BLUR;
}

/// A value for the hero, and for the other wavelengths unless the direction depends on them.
fn lanes_of(value: f32, is_dispersive: bool) -> vec4<f32> {
    return select(vec4<f32>(value), vec4<f32>(value, 0.0, 0.0, 0.0), is_dispersive);
}

/// Value and density of refraction.
fn refraction(alpha: vec2<f32>, wo: vec3<f32>, wi: vec3<f32>, facet: Refraction) -> vec2<f32> {
    let seen = wo.z + stretched_length(alpha, wo);
    let lit = -wi.z + stretched_length(alpha, wi);
    let shared_part = 2.0 * facet.transmittance * facet_density(alpha, facet.m) * facet.cos_o * facet.cos_i / (seen * facet.stretch * facet.stretch);
    return vec2<f32>(shared_part * 2.0 / lit, shared_part * facet.eta * facet.eta);
}
