// glTF's material without what its extensions lay over it or let through; photosite-transport's bsdf/layered and
// bsdf/albedo/reflection.rs.

/// F₀·A + B of the albedo of facets, F₉₀ being 1.
fn albedo_node(row: u32, column: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(tables[params.albedos + row * (ALBEDO_NODES + 1u) + column].xy);
}

/// Place of x among the nodes: the node below, and the fraction of the way to the next.
fn albedo_place(x: f32) -> vec2<f32> {
    let position = clamp(x, 0.0, 1.0) * f32(ALBEDO_NODES - 1u);
    let below = min(floor(position), f32(ALBEDO_NODES - 2u));
    return vec2<f32>(below, position - below);
}

/// Albedo for light of a cosine.
fn facet_albedo(alpha: f32, cosine: f32) -> vec2<f32> {
    let row = albedo_place(sqrt(alpha));
    let column = albedo_place(sqrt(max(cosine, 0.0)));
    let i = u32(row.x);
    let j = u32(column.x);
    let below = mix(albedo_node(i, j), albedo_node(i, j + 1u), column.y);
    let above = mix(albedo_node(i + 1u, j), albedo_node(i + 1u, j + 1u), column.y);
    return mix(below, above, row.y);
}

/// Mean albedo over the hemisphere.
fn mean_facet_albedo(alpha: f32) -> vec2<f32> {
    let row = albedo_place(sqrt(alpha));
    let i = u32(row.x);
    return mix(albedo_node(i, ALBEDO_NODES), albedo_node(i + 1u, ALBEDO_NODES), row.y);
}

/// Light that facets take, and that they leave.
struct EnergySplit {
    dielectric: vec4<f32>,
    white: f32,
    left: vec4<f32>,
    left_by_white: f32,
}

fn energy_split(bsdf: Bsdf, albedo: vec2<f32>) -> EnergySplit {
    let dielectric = (bsdf.second * albedo.x + albedo.y) * bsdf.specular;
    let white = albedo.x + albedo.y;
    return EnergySplit(dielectric, white, max(1.0 - dielectric, vec4<f32>(0.0)), max(1.0 - white, 0.0));
}

fn schlick_weight(cosine: f32) -> f32 {
    let m = clamp(1.0 - cosine, 0.0, 1.0);
    let squared = m * m;
    return squared * squared * m;
}

fn schlick(f0: vec4<f32>, cosine: f32) -> vec4<f32> {
    let white = schlick_weight(cosine);
    return f0 * (1.0 - white) + white;
}

/// Layers as seen from one direction: what is left, how it spreads, and the probability of the facets' lobe.
struct LayeredView {
    seen: EnergySplit,
    coloured: vec4<f32>,
    spread_white: vec4<f32>,
    /// Probabilities of the lobes of the facets and of the base; 0 of both where no light is scattered.
    facets: f32,
    base: f32,
}

const NOTHING_LEFT = 1e-5f;

fn layered_view(bsdf: Bsdf, wo: vec3<f32>) -> LayeredView {
    let metal = bsdf.metallic;
    let coloured = 1.0 - metal;
    let alpha = bsdf.roughness.x;
    let seen = energy_split(bsdf, facet_albedo(alpha, wo.z));
    let mean_albedo = mean_facet_albedo(alpha);
    let mean = energy_split(bsdf, mean_albedo);
    let per_mean = select(vec4<f32>(0.0), FRAC_1_PI / mean.left, mean.left > vec4<f32>(NOTHING_LEFT));
    let per_white = select(0.0, FRAC_1_PI / mean.left_by_white, mean.left_by_white > NOTHING_LEFT);
    var bounced = vec4<f32>(0.0);
    if (metal > 0.0) {
        // Mean of Schlick's weight over the hemisphere, 1/21
        let f = bsdf.first * (1.0 - 1.0 / 21.0) + 1.0 / 21.0;
        let e = mean_albedo.x + mean_albedo.y;
        bounced = f * f * (metal * e) / (1.0 - f * (1.0 - e));
    }
    let spread = bsdf.first * per_mean * coloured;
    let spread_white = bounced * per_white;
    var facets = coloured * mean_of(seen.dielectric);
    if (metal > 0.0) {
        facets += metal * mean_of(seen.white * schlick(bsdf.first, wo.z));
    }
    let base = mean_of((spread * seen.left * mean.left + spread_white * seen.left_by_white * mean.left_by_white) * PI);
    let sum = facets + base;
    let scale = select(0.0, 1.0 / sum, sum > 0.0);
    return LayeredView(seen, spread, spread_white, facets * scale, base * scale);
}

/// Reflectance of the facets, metal and others.
fn layered_facets(bsdf: Bsdf, cosine: f32) -> vec4<f32> {
    let coloured = 1.0 - bsdf.metallic;
    return schlick(bsdf.first, cosine) * bsdf.metallic + schlick(bsdf.second, cosine) * (bsdf.specular * coloured);
}

fn is_delta_layered(bsdf: Bsdf) -> bool {
    return is_smooth(bsdf.roughness) && bsdf.metallic >= 1.0;
}

/// Part of the remaining light that is sampled evenly over the hemisphere.
fn layered_even_part(bsdf: Bsdf) -> f32 {
    return select(0.0, 0.5, 1.0 - bsdf.metallic < 1.0);
}

fn eval_layered_view(bsdf: Bsdf, view: LayeredView, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    let other = energy_split(bsdf, facet_albedo(bsdf.roughness.x, wi.z));
    var f = view.coloured * view.seen.left * other.left + view.spread_white * (view.seen.left_by_white * other.left_by_white);
    let even = layered_even_part(bsdf);
    var pdf = view.base * (FRAC_1_PI * ((1.0 - even) * wi.z + even * 0.5));
    if (!is_smooth(bsdf.roughness) && view.facets > 0.0) {
        let kernel = reflection(bsdf.roughness, wo, wi);
        f += layered_facets(bsdf, kernel.cos_facet) * kernel.value;
        pdf += view.facets * kernel.pdf;
    }
    return BsdfEval(f, pdf);
}

fn eval_layered(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if (!is_above(wo) || !is_above(wi) || is_delta_layered(bsdf)) {
        return no_scattering();
    }
    let view = layered_view(bsdf, wo);
    if (view.facets + view.base == 0.0) {
        return no_scattering();
    }
    return eval_layered_view(bsdf, view, wo, wi);
}

fn sample_layered(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    if (!is_above(wo)) {
        return no_sample();
    }
    let view = layered_view(bsdf, wo);
    var wi = vec3<f32>(0.0);
    if (u_lobe < view.facets) {
        if (is_smooth(bsdf.roughness)) {
            return mirror_sample(layered_facets(bsdf, min(wo.z, 1.0)), vec3<f32>(-wo.xy, wo.z), view.facets);
        }
        wi = reflect_at(wo, sample_visible(bsdf.roughness, wo, u));
    } else if (u_lobe < view.facets + view.base) {
        let u_part = (u_lobe - view.facets) / view.base;
        wi = select(cosine_hemisphere(u), uniform_cone(u, 0.0), u_part < layered_even_part(bsdf));
    }
    if (!is_above(wi)) {
        return no_sample();
    }
    let scattering = eval_layered_view(bsdf, view, wo, wi);
    return reflected_sample(scattering.f, wi, scattering.pdf);
}
