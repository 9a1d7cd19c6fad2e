// Tabulated albedos of lobes; photosite-transport's bsdf/albedo. Each table is a grid of rows: for a roughness the values at
// all nodes of √μ and, twice, their mean over the hemisphere.

/// Place among even nodes: the node below, and the fraction of the way to the next.
struct Place {
    node: u32,
    fraction: f32,
}

fn locate(x: f32, nodes: u32) -> Place {
    let position = clamp(x, 0.0, 1.0) * f32(nodes - 1u);
    let node = min(u32(position), nodes - 2u);
    return Place(node, position - f32(node));
}

/// Direction above the surface for which an albedo is asked, or the mean over all.
struct Sight {
    w: vec3<f32>,
    is_mean: bool,
}

/// Place of a direction among the nodes of √μ, behind which the mean stands.
fn column_of(sight: Sight, nodes: u32) -> Place {
    if (sight.is_mean) {
        return Place(nodes, 0.0);
    }
    return locate(sqrt(max(sight.w.z, 0.0)), nodes);
}

fn pair_at(at: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(vec2<u32>(attributes[at], attributes[at + 1u]));
}

/// A pair of numbers of a grid that begins at a place among the attributes.
fn grid_pair(first: u32, nodes: u32, row: Place, column: Place) -> vec2<f32> {
    let at = first + 2u * (row.node * (nodes + 2u) + column.node);
    let next = at + 2u * (nodes + 2u);
    let below = mix(pair_at(at), pair_at(at + 2u), column.fraction);
    let above = mix(pair_at(next), pair_at(next + 2u), column.fraction);
    return mix(below, above, row.fraction);
}

/// A pair of one of several grids between two of which a layer lies.
fn stacked_pair(first: u32, rows: u32, nodes: u32, layer: Place, row: Place, column: Place) -> vec2<f32> {
    let size = 2u * rows * (nodes + 2u);
    let below = grid_pair(first + layer.node * size, nodes, row, column);
    let above = grid_pair(first + (layer.node + 1u) * size, nodes, row, column);
    return mix(below, above, layer.fraction);
}

/// Geometric mean of both roughnesses.
fn mean_alpha(alpha: vec2<f32>) -> f32 {
    return select(sqrt(alpha.x * alpha.y), alpha.x, alpha.x == alpha.y);
}

/// Pair of an anisotropic roughness by azimuth and cosine.
fn azimuthal_pair(first: u32, sight: Sight) -> vec2<f32> {
    if (sight.is_mean) {
        return pair_at(first + 2u * AZIMUTHAL_PHIS * AZIMUTHAL_MUS);
    }
    let phi = locate(arc_tangent(abs(sight.w.y), abs(sight.w.x)) * FRAC_2_PI, AZIMUTHAL_PHIS);
    let mu = locate(sqrt(max(sight.w.z, 0.0)), AZIMUTHAL_MUS);
    let at = first + 2u * (phi.node * AZIMUTHAL_MUS + mu.node);
    let next = at + 2u * AZIMUTHAL_MUS;
    let below = mix(pair_at(at), pair_at(at + 2u), mu.fraction);
    let above = mix(pair_at(next), pair_at(next + 2u), mu.fraction);
    return mix(below, above, phi.fraction);
}

const AZIMUTHAL_NUMBERS = 2u * (AZIMUTHAL_PHIS * AZIMUTHAL_MUS + 1u);

/// A and B of the albedo of facets as rough along x as along y, F₀·A + F₉₀·B; `Row`.
fn even_facet_albedo(alpha: f32, sight: Sight) -> vec2<f32> {
    return grid_pair(params.albedo_facets, ALBEDO_NODES, locate(sqrt(alpha), ALBEDO_NODES), column_of(sight, ALBEDO_NODES));
}

/// A and B of the albedo of facets, those with grooves between four entries.
fn facet_albedo(alpha: vec2<f32>, sight: Sight) -> vec2<f32> {
    if (!HAS_GROOVES || alpha.x == alpha.y) {
        return even_facet_albedo(alpha.x, sight);
    }
    let x = locate(sqrt(alpha.x), GROOVED_ALPHAS);
    let y = locate(sqrt(alpha.y), GROOVED_ALPHAS);
    var sum = vec2<f32>(0.0);
    for (var corner = 0u; corner < 4u; corner += 1u) {
        let up = vec2<u32>(corner & 1u, corner >> 1u);
        let fractions = vec2<f32>(x.fraction, y.fraction);
        let weights = select(1.0 - fractions, fractions, up == vec2<u32>(1u));
        let entry = (x.node + up.x) * GROOVED_ALPHAS + y.node + up.y;
        sum += azimuthal_pair(params.albedo_grooved_facets + entry * AZIMUTHAL_NUMBERS, sight) * (weights.x * weights.y);
    }
    return sum;
}

/// Part of a lobe that the layer above hides, by Schlick's parameters; `HiddenPart`.
struct HiddenPart {
    hidden: vec2<f32>,
    whole: vec2<f32>,
}

fn hidden_at(part: HiddenPart, f0: f32) -> f32 {
    return (f0 * part.hidden.x + part.hidden.y) / max(f0 * part.whole.x + part.whole.y, MIN_POSITIVE);
}

/// Parts hidden of facets that reflect `f0` at normal incidence, and of white ones.
fn hidden_of(part: HiddenPart, f0: f32) -> vec2<f32> {
    return vec2<f32>(hidden_at(part, f0), hidden_at(part, 1.0));
}

/// Part hidden by a layer at a place in one of two tables; `Hidden`.
fn hidden_part(first: u32, layer: f32, alpha: vec2<f32>, sight: Sight) -> HiddenPart {
    let base = mean_alpha(alpha);
    let row = locate(sqrt(base), HIDDEN_NODES);
    let stack = locate(sqrt(layer), HIDDEN_NODES);
    let hidden = stacked_pair(first, HIDDEN_NODES, HIDDEN_NODES, stack, row, column_of(sight, HIDDEN_NODES));
    return HiddenPart(hidden, even_facet_albedo(base, sight));
}

/// Place of a roughness of sheen in its tables; `position`.
fn sheen_position(alpha: f32) -> f32 {
    let smallest = sqrt(SHEEN_SMALLEST_ALPHA);
    let position = max((sqrt(alpha) - smallest) / (1.0 - smallest), 0.0);
    return position * position;
}

/// Albedos of sheen of colour 1, of the published lobe and of the one in use.
fn sheen_albedo(alpha: f32, sight: Sight) -> vec2<f32> {
    return grid_pair(params.albedo_sheen, ALBEDO_NODES, locate(sqrt(sheen_position(alpha)), ALBEDO_NODES), column_of(sight, ALBEDO_NODES));
}

/// Place of an index, or its inverse, among the tabulated ones.
fn index_position(eta: f32) -> f32 {
    return sqrt(max((select(eta, 1.0 / eta, eta < 1.0) - 1.0) / (LARGEST_INDEX - 1.0), 0.0));
}

/// Albedos of one bounce at an interface of index `eta`, for light from the near side and from the far one; `GlassRow`.
fn glass_albedo(eta: f32, alpha: vec2<f32>, sight: Sight) -> vec2<f32> {
    var pair: vec2<f32>;
    if (!HAS_GROOVES || alpha.x == alpha.y) {
        let index = locate(index_position(eta), GLASS_INDICES);
        let row = locate(sqrt(alpha.x), GLASS_ALPHAS);
        pair = stacked_pair(params.albedo_glass, GLASS_ALPHAS, GLASS_MUS, index, row, column_of(sight, GLASS_MUS));
    } else {
        pair = grooved_glass_albedo(eta, alpha, sight);
    }
    return select(pair, pair.yx, eta < 1.0);
}

/// Albedos of one bounce at an interface with anisotropic facets, between eight entries, of which those with the larger
/// roughness first are turned.
fn grooved_glass_albedo(eta: f32, alpha: vec2<f32>, sight: Sight) -> vec2<f32> {
    let index = locate(index_position(eta), GROOVED_GLASS_INDICES);
    let x = locate(sqrt(alpha.x), GROOVED_GLASS_ALPHAS);
    let y = locate(sqrt(alpha.y), GROOVED_GLASS_ALPHAS);
    var sum = vec2<f32>(0.0);
    for (var corner = 0u; corner < 8u; corner += 1u) {
        let up = vec3<u32>(corner & 1u, (corner >> 1u) & 1u, corner >> 2u);
        let fractions = vec3<f32>(index.fraction, x.fraction, y.fraction);
        let weights = select(1.0 - fractions, fractions, up == vec3<u32>(1u));
        let i = x.node + up.y;
        let j = y.node + up.z;
        let entry = ((index.node + up.x) * GROOVED_GLASS_ALPHAS + min(i, j)) * GROOVED_GLASS_ALPHAS + max(i, j);
        let w = select(sight.w, sight.w.yxz, i > j);
        let pair = azimuthal_pair(params.albedo_grooved_glass + entry * AZIMUTHAL_NUMBERS, Sight(w, sight.is_mean));
        sum += pair * (weights.x * weights.y * weights.z);
    }
    return sum;
}

/// Weights Wⱼ of the reflectances of a film at eight even cosines; `FilmWeights`.
struct FilmWeights {
    low: vec4<f32>,
    high: vec4<f32>,
}

fn weights_at(at: u32) -> FilmWeights {
    let low = vec4<u32>(attributes[at], attributes[at + 1u], attributes[at + 2u], attributes[at + 3u]);
    let high = vec4<u32>(attributes[at + 4u], attributes[at + 5u], attributes[at + 6u], attributes[at + 7u]);
    return FilmWeights(bitcast<vec4<f32>>(low), bitcast<vec4<f32>>(high));
}

fn mix_weights(a: FilmWeights, b: FilmWeights, t: f32) -> FilmWeights {
    return FilmWeights(mix(a.low, b.low, t), mix(a.high, b.high, t));
}

fn grid_weights(first: u32, nodes: u32, row: Place, column: Place) -> FilmWeights {
    let at = first + FILM_NODES * (row.node * (nodes + 2u) + column.node);
    let next = at + FILM_NODES * (nodes + 2u);
    let below = mix_weights(weights_at(at), weights_at(at + FILM_NODES), column.fraction);
    let above = mix_weights(weights_at(next), weights_at(next + FILM_NODES), column.fraction);
    return mix_weights(below, above, row.fraction);
}

/// Weights for a film on facets; `FilmRow`.
fn film_weights(alpha: vec2<f32>, sight: Sight) -> FilmWeights {
    let row = locate(sqrt(mean_alpha(alpha)), FILM_ALPHAS);
    return grid_weights(params.albedo_film, ALBEDO_NODES, row, column_of(sight, ALBEDO_NODES));
}

/// Weights for a film on a refracting interface, for light from the near side or from the far one; `FilmGlassRow`.
fn film_glass_weights(eta: f32, alpha: vec2<f32>, sight: Sight, is_far: bool) -> FilmWeights {
    let from_denser = is_far != (eta < 1.0);
    let size = FILM_NODES * GLASS_ALPHAS * (GLASS_MUS + 2u);
    let index = locate(index_position(eta), GLASS_INDICES);
    let row = locate(sqrt(mean_alpha(alpha)), GLASS_ALPHAS);
    let column = column_of(sight, GLASS_MUS);
    let at = params.albedo_film_glass + (select(0u, GLASS_INDICES, from_denser) + index.node) * size;
    let below = grid_weights(at, GLASS_MUS, row, column);
    return mix_weights(below, grid_weights(at + size, GLASS_MUS, row, column), index.fraction);
}
