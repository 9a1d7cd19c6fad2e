// Light from one direction that the layers take, and light that they leave; photosite-transport's
// bsdf/layered/view/energy_split.rs and state.rs.

/// Light that is taken and left, for one direction or on average.
struct EnergySplit {
    coat: f32,
    sheen: vec4<f32>,
    /// Divisor of the published sheen, at least 1.
    sheen_excess: f32,
    /// Albedo of the facets over the coloured or clear base, and of white facets, under the layers.
    dielectric: vec4<f32>,
    white: vec4<f32>,
    /// Light that is left under the facets of the coloured base, and under white ones.
    left: vec4<f32>,
    left_by_white: vec4<f32>,
    /// Light that one bounce at a refracting interface leaves, here and behind.
    left_here: vec4<f32>,
    left_behind: vec4<f32>,
}

/// Weights of a lobe that is spread over what is left.
struct Spread {
    coloured: vec4<f32>,
    white: vec4<f32>,
    glass: vec4<f32>,
}

/// The lobes that samples are drawn from, with their probabilities.
struct Lobes {
    coat: f32,
    sheen: f32,
    facets: f32,
    through: f32,
    base: f32,
    base_behind: f32,
}

/// Layers of the surface where the thread is, seen from one direction; set by `view_bsdf`.
var<private> view: LayeredView;

struct LayeredView {
    wo: vec3<f32>,
    /// Whether light is refracted, with the index of the other side over that of the side of `wo`.
    refracts: bool,
    eta: vec4<f32>,
    is_inside: bool,
    /// Reflectances of the film on the dielectric at its nodes.
    film: array<vec4<f32>, FILM_NODES>,
    /// Light that is taken and left, for `wo` and on average.
    splits: array<EnergySplit, 2>,
    here: Spread,
    behind: Spread,
    lobes: Lobes,
}

const SEEN = 0u;
const MEAN = 1u;

fn at_least_zero(s: vec4<f32>) -> vec4<f32> {
    return max(s, vec4<f32>(0.0));
}

/// Σ R(cⱼ)·Wⱼ.
fn at_nodes(nodes: array<vec4<f32>, FILM_NODES>, weights: FilmWeights) -> vec4<f32> {
    let low = nodes[0] * weights.low.x + nodes[1] * weights.low.y + nodes[2] * weights.low.z + nodes[3] * weights.low.w;
    return low + nodes[4] * weights.high.x + nodes[5] * weights.high.y + nodes[6] * weights.high.z + nodes[7] * weights.high.w;
}

/// Albedo of the facets without what lies above; its sum for white ones is known from the tables.
fn bare_albedo(bsdf: Bsdf, facets: vec2<f32>, sight: Sight) -> vec4<f32> {
    let schlick = bsdf.second * facets.x + facets.y;
    if (!HAS_FILM || layers.film_weight <= 0.0) {
        return schlick * layers.specular;
    }
    // The weights are those of isotropic facets; their sum is known better.
    let weights = film_weights(bsdf.roughness, sight);
    let sum = dot(weights.low + weights.high, vec4<f32>(1.0));
    let norm = layers.film_weight * (facets.x + facets.y) / max(sum, MIN_POSITIVE);
    return (schlick * (1.0 - layers.film_weight) + at_nodes(view.film, weights) * norm) * layers.specular;
}

/// Light that one bounce at a refracting interface leaves on one side; `left_by_glass`.
fn left_by_glass(bsdf: Bsdf, bounced: f32, sight: Sight, is_far: bool) -> vec4<f32> {
    let bare = vec4<f32>(1.0 - bounced);
    if (!HAS_FILM || layers.film_weight <= 0.0) {
        return at_least_zero(bare);
    }
    let outside = max(view.eta.x, 1.0 / view.eta.x);
    var change = view.film;
    for (var j = 0u; j < FILM_NODES; j += 1u) {
        change[j] -= interface_of(film_node(j), outside).reflectance;
    }
    let weights = film_glass_weights(view.eta.x, bsdf.roughness, sight, is_far);
    return at_least_zero(bare - at_nodes(change, weights) * layers.film_weight);
}

fn energy_split(bsdf: Bsdf, sight: Sight) -> EnergySplit {
    let facets = facet_albedo(bsdf.roughness, sight);
    let bare = bare_albedo(bsdf, facets, sight);
    let bare_white = facets.x + facets.y;
    var left_here = vec4<f32>(0.0);
    var left_behind = vec4<f32>(0.0);
    if (HAS_VOLUMES && view.refracts) {
        let bounced = glass_albedo(view.eta.x, bsdf.roughness, sight);
        left_here = left_by_glass(bsdf, bounced.x, sight, false);
        left_behind = left_by_glass(bsdf, bounced.y, sight, true);
    }
    var coat = 0.0;
    var coat_hides = vec2<f32>(0.0);
    if (HAS_COAT && layers.has_coat) {
        let in_coat = Sight(vec3<f32>(0.0, 0.0, clamp(dot(sight.w, layers.coat_normal), 0.0, 1.0)), sight.is_mean);
        let albedo = even_facet_albedo(layers.coat_alpha, in_coat);
        coat = layers.coat_weight * (COAT_F0 * albedo.x + albedo.y);
        let hidden = hidden_part(params.albedo_under_coat, layers.coat_alpha, bsdf.roughness, sight);
        coat_hides = layers.coat_weight * hidden_of(hidden, mean_of(bsdf.second));
    }
    var sheen = vec4<f32>(0.0);
    var sheen_excess = 1.0;
    var sheen_hides = vec2<f32>(0.0);
    if (HAS_SHEEN && layers.has_sheen) {
        let albedo = sheen_albedo(layers.sheen_alpha, sight);
        sheen = layers.sheen_colour * albedo.y;
        sheen_excess = max(albedo.x, 1.0);
        let hidden = hidden_part(params.albedo_under_sheen, sheen_position(layers.sheen_alpha), bsdf.roughness, sight);
        sheen_hides = hidden_of(hidden, mean_of(bsdf.second));
    }
    // The part of the facets' light that the layers let through.
    let dielectric = bare * (1.0 - layers.sheen_colour * sheen_hides.x) * (1.0 - coat_hides.x);
    let white = bare_white * (1.0 - layers.sheen_colour * sheen_hides.y) * (1.0 - coat_hides.y);
    let below = (1.0 - sheen) * (1.0 - coat);
    return EnergySplit(
        coat, sheen, sheen_excess, dielectric, white, at_least_zero(below - dielectric), at_least_zero(below - white),
        left_here, left_behind,
    );
}

fn per_mean(mean: vec4<f32>) -> vec4<f32> {
    return select(vec4<f32>(0.0), FRAC_1_PI / mean, mean > vec4<f32>(NOTHING_LEFT));
}

/// Colours of the lobes that share out what is left, on both sides; `spread`.
fn spread_layers(bsdf: Bsdf) {
    let parts = parts_of();
    let base_colour = bsdf.first;
    let by_coloured = per_mean(view.splits[MEAN].left) * parts.y;
    let by_white = per_mean(view.splits[MEAN].left_by_white);
    var bounced = vec4<f32>(0.0);
    if (parts.x > 0.0) {
        let f = mean_facet_reflectance(base_colour);
        let albedo = facet_albedo(bsdf.roughness, Sight(vec3<f32>(0.0, 0.0, 1.0), true));
        let e = albedo.x + albedo.y;
        bounced += further_bounces(parts.x, f, e);
    }
    var passed = vec4<f32>(0.0);
    var glass: Shared;
    if (HAS_VOLUMES && view.refracts) {
        glass = shared_out(parts.z, view.eta.x, view.splits[MEAN].left_here, view.splits[MEAN].left_behind);
    } else if (HAS_TRANSMISSION && parts.z > 0.0) {
        let f = mean_facet_reflectance(bsdf.second) * layers.specular;
        bounced += f * parts.z;
        passed = (1.0 - f) * base_colour * parts.z;
    }
    let dt = layers.diffuse_transmission;
    view.here = Spread(base_colour * by_coloured * (1.0 - dt), bounced * by_white, glass.here);
    view.behind = Spread(layers.diffuse_transmission_colour * by_coloured * dt, passed * by_white, base_colour * glass.behind);
}

/// Value of the base lobe between `wo` and a direction that sees `other`, on the same side or behind.
fn base_value(other: EnergySplit, is_behind: bool) -> vec4<f32> {
    var spread = view.here;
    var glass = other.left_here;
    if (is_behind) {
        spread = view.behind;
        glass = other.left_behind;
    }
    let seen = view.splits[SEEN];
    let f = spread.coloured * seen.left * other.left + spread.white * seen.left_by_white * other.left_by_white;
    return f + spread.glass * seen.left_here * glass;
}

/// Albedo of the base lobe, integrated over directions.
fn base_albedo(is_behind: bool) -> vec4<f32> {
    return base_value(view.splits[MEAN], is_behind) * PI;
}

/// Part of the light that passes coat and sheen to the facets and back.
fn cover(other: EnergySplit) -> vec4<f32> {
    return (1.0 - max(view.splits[SEEN].sheen, other.sheen)) * (1.0 - max(view.splits[SEEN].coat, other.coat));
}
