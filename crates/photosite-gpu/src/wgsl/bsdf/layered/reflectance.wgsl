// Reflectance of the facets and interfaces of the layers; photosite-transport's bsdf/layered/view/reflectance.rs.

/// Mean of Schlick's weight over the hemisphere.
const MEAN_WEIGHT = 1.0f / 21.0f;
/// Reflectance of a coat at normal incidence.
const COAT_F0 = 0.04f;

fn schlick_weight(cosine: f32) -> f32 {
    let m = clamp(1.0 - cosine, 0.0, 1.0);
    let squared = m * m;
    return squared * squared * m;
}

fn with_film(bare: vec4<f32>, f0: vec4<f32>, cosine: f32) -> vec4<f32> {
    if (HAS_FILM && layers.film_weight > 0.0) {
        return bare * (1.0 - layers.film_weight) + film_reflectance(cosine, f0) * layers.film_weight;
    }
    return bare;
}

/// The facets' reflectance with Schlick's weight and the film if there is one; `reflectance`.
fn facet_reflectance(f0: vec4<f32>, cosine: f32) -> vec4<f32> {
    let white = schlick_weight(cosine);
    return with_film(f0 * (1.0 - white) + white, f0, cosine);
}

/// Cosine of a node of the film's reflectances.
fn film_node(j: u32) -> f32 {
    return f32(j) / f32(FILM_NODES - 1u);
}

/// Mean of the facets' reflectance over the hemisphere; `mean_reflectance`.
fn mean_facet_reflectance(f0: vec4<f32>) -> vec4<f32> {
    let bare = f0 * (1.0 - MEAN_WEIGHT) + MEAN_WEIGHT;
    if (!HAS_FILM || layers.film_weight <= 0.0) {
        return bare;
    }
    let h = 1.0 / f32(FILM_NODES - 1u);
    var sum = vec4<f32>(0.0);
    for (var j = 0u; j < FILM_NODES; j += 1u) {
        var weight = 2.0 * h * film_node(j);
        if (j == 0u) {
            weight = h * h / 3.0;
        } else if (j == FILM_NODES - 1u) {
            weight = h - h * h / 3.0;
        }
        sum += film_reflectance(film_node(j), f0) * weight;
    }
    return bare * (1.0 - layers.film_weight) + sum * layers.film_weight;
}

/// Reflectance of a refracting facet whose exact reflectance is known; `refracting_reflectance`.
fn refracting_reflectance(bsdf: Bsdf, exact: vec4<f32>, eta: vec4<f32>, cos_outside: f32) -> vec4<f32> {
    let root = (eta - 1.0) / (eta + 1.0);
    let normal = root * root;
    let weight = clamp((exact - normal) / (1.0 - normal), vec4<f32>(0.0), vec4<f32>(1.0));
    let f0 = bsdf.second;
    let partial = with_film(f0 * (1.0 - weight) + weight, f0, cos_outside) * layers.specular;
    // Nothing is let through where reflection is total.
    return select(partial, vec4<f32>(1.0), exact >= vec4<f32>(1.0));
}

/// Reflectance of the clear base for light that meets a facet on the side of the viewer; `clear_reflectance`.
fn clear_reflectance(bsdf: Bsdf, eta: vec4<f32>, is_inside: bool, cosine: f32) -> vec4<f32> {
    let at_hero = interface_of(cosine, eta.x);
    var exact = vec4<f32>(at_hero.reflectance);
    if (bsdf.is_dispersive) {
        exact.y = interface_of(cosine, eta.y).reflectance;
        exact.z = interface_of(cosine, eta.z).reflectance;
        exact.w = interface_of(cosine, eta.w).reflectance;
    }
    return refracting_reflectance(bsdf, exact, eta, select(cosine, at_hero.cos_transmitted, is_inside));
}

fn coat_fresnel(cosine: f32) -> f32 {
    return COAT_F0 + (1.0 - COAT_F0) * schlick_weight(cosine);
}
