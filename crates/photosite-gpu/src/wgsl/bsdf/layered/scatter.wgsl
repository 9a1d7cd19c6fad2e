// The lobes of the layers: their choice, their sampling and their values; photosite-transport's bsdf/layered/mod.rs and
// bsdf/layered/view/scatter.rs.

/// Prepares the layers for the direction from which they are seen; no lobe has a probability where no light is scattered.
fn view_layers(bsdf: Bsdf, wo: vec3<f32>) {
    view.lobes = Lobes(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let is_inside = wo.z < 0.0;
    if (is_grazing(wo) || is_inside && !refracts_layered()) {
        return;
    }
    view.wo = select(wo, mirrored(wo), is_inside);
    view.is_inside = is_inside;
    view.refracts = refracts_layered();
    view.eta = select(layers.eta, 1.0 / layers.eta, is_inside);
    if (HAS_FILM && layers.film_weight > 0.0) {
        for (var j = 0u; j < FILM_NODES; j += 1u) {
            view.film[j] = film_reflectance(film_node(j), bsdf.second);
        }
    }
    // In a loop, so that kernels hold the tables' look-ups once.
    for (var k = SEEN; k <= MEAN; k += 1u) {
        let split = energy_split(bsdf, Sight(select(vec3<f32>(0.0, 0.0, 1.0), view.wo, k == SEEN), k == MEAN));
        view.splits[k] = split;
    }
    spread_layers(bsdf);
    choose_lobes(bsdf);
}

/// Probabilities in proportion to what each lobe gives back.
fn choose_lobes(bsdf: Bsdf) {
    let parts = parts_of();
    let seen = view.splits[SEEN];
    let layered = layered_part(bsdf);
    var lobes = Lobes(
        layered * seen.coat,
        layered * mean_of(seen.sheen) * (1.0 - seen.coat),
        parts.y * mean_of(seen.dielectric),
        0.0,
        mean_of(base_albedo(false)),
        0.0,
    );
    if (LAYERS_PASS) {
        lobes.base_behind = mean_of(base_albedo(true));
    }
    if (parts.x > 0.0) {
        lobes.facets += parts.x * mean_of(seen.white * facet_reflectance(bsdf.first, view.wo.z));
    }
    if (HAS_VOLUMES && view.refracts) {
        var reflected = clear_reflectance(bsdf, view.eta, view.is_inside, min(view.wo.z, 1.0));
        if (!passes_undisturbed(bsdf)) {
            // Where the surface as a whole reflects all or nothing, some of its facets do not.
            reflected = clamp(reflected, vec4<f32>(0.1), vec4<f32>(0.9));
        }
        lobes.facets += parts.z * mean_of(reflected);
        lobes.through = parts.z * mean_of((1.0 - reflected) * bsdf.first);
    } else if (HAS_TRANSMISSION && parts.z > 0.0) {
        lobes.facets += parts.z * mean_of(seen.dielectric);
        lobes.through = parts.z * mean_of(at_least_zero(seen.white - seen.dielectric) * bsdf.first);
    }
    let sum = lobes.coat + lobes.sheen + lobes.facets + lobes.through + lobes.base + lobes.base_behind;
    let scale = select(0.0, 1.0 / sum, sum > 0.0);
    view.lobes = Lobes(
        lobes.coat * scale, lobes.sheen * scale, lobes.facets * scale, lobes.through * scale, lobes.base * scale,
        lobes.base_behind * scale,
    );
}

/// Whether any lobe has a probability.
fn scatters() -> bool {
    let lobes = view.lobes;
    return lobes.coat + lobes.sheen + lobes.facets + lobes.through + lobes.base + lobes.base_behind > 0.0;
}

/// Part of the remaining light that is sampled evenly over the hemisphere.
fn even_part(bsdf: Bsdf) -> f32 {
    return select(0.0, 0.5, parts_of().y < 1.0);
}

fn base_density(bsdf: Bsdf, z: f32) -> f32 {
    let even = even_part(bsdf);
    return FRAC_1_PI * ((1.0 - even) * z + even * 0.5);
}

fn sample_base(bsdf: Bsdf, u_part: f32, u: vec2<f32>) -> vec3<f32> {
    return select(cosine_hemisphere(u), uniform_cone(u, 0.0), u_part < even_part(bsdf));
}

/// Whether light passes the layers in one direction only.
fn passes_undisturbed(bsdf: Bsdf) -> bool {
    return is_smooth(bsdf.roughness) || HAS_VOLUMES && view.refracts && is_delta_interface(view.eta.x, bsdf.roughness);
}

/// The part of the surface that layers lie on: all but the refracting one.
fn layered_part(bsdf: Bsdf) -> f32 {
    return select(1.0, 1.0 - parts_of().z, view.refracts);
}

/// The facets' reflectance, all parts of the base together, under the layers; `facets`.
fn all_facets(bsdf: Bsdf, cosine: f32, other: EnergySplit) -> vec4<f32> {
    let parts = parts_of();
    var sum = vec4<f32>(0.0);
    if (parts.x > 0.0) {
        sum += facet_reflectance(bsdf.first, cosine) * parts.x;
    }
    let schlick = select(parts.y + parts.z, parts.y, view.refracts);
    if (schlick > 0.0) {
        sum += facet_reflectance(bsdf.second, cosine) * (layers.specular * schlick);
    }
    sum *= cover(other);
    if (HAS_VOLUMES && view.refracts) {
        sum += clear_reflectance(bsdf, view.eta, view.is_inside, cosine) * parts.z;
    }
    return sum;
}

fn eval_reflection(bsdf: Bsdf, wi: vec3<f32>, other: EnergySplit) -> BsdfEval {
    let lobes = view.lobes;
    let wo = view.wo;
    var f = base_value(other, false);
    var pdf = lobes.base * base_density(bsdf, wi.z);
    if (!is_smooth(bsdf.roughness) && lobes.facets > 0.0) {
        let kernel = reflection(bsdf.roughness, wo, wi);
        f += all_facets(bsdf, kernel.cos_facet, other) * kernel.value;
        pdf += lobes.facets * kernel.pdf;
    }
    if (HAS_SHEEN && layers.has_sheen) {
        let below_coat = 1.0 - max(view.splits[SEEN].coat, other.coat);
        let excess = max(view.splits[SEEN].sheen_excess, other.sheen_excess);
        let value = published_sheen(layers.sheen_alpha, wo, wi) / excess;
        f += layers.sheen_colour * (value * below_coat * layered_part(bsdf));
        pdf += lobes.sheen / TAU;
    }
    if (HAS_COAT && layers.has_coat && layers.coat_alpha > 0.0) {
        let frame = frame_from_normal(layers.coat_normal);
        let wo_coat = to_local(frame, wo);
        let wi_coat = to_local(frame, wi);
        if (is_above(wo_coat) && is_above(wi_coat)) {
            let kernel = reflection(vec2<f32>(layers.coat_alpha), wo_coat, wi_coat);
            let value = layered_part(bsdf) * layers.coat_weight * coat_fresnel(kernel.cos_facet) * kernel.value;
            f += vec4<f32>(value * wi_coat.z / wi.z);
            pdf += lobes.coat * kernel.pdf;
        }
    }
    return BsdfEval(f, pdf);
}

fn eval_transmission(bsdf: Bsdf, wi: vec3<f32>, other: EnergySplit) -> BsdfEval {
    let lobes = view.lobes;
    let clear = parts_of().z;
    let mirror = mirrored(wi);
    var f = base_value(other, true);
    var pdf = lobes.base_behind * base_density(bsdf, mirror.z);
    if (!HAS_TRANSMISSION || clear <= 0.0 || passes_undisturbed(bsdf)) {
        return BsdfEval(f, pdf);
    }
    let tint = bsdf.first * clear;
    if (HAS_VOLUMES && view.refracts) {
        let eta = view.eta.x;
        let facet = refracting_facet(view.wo, wi, eta);
        if (facet.cos_o > 0.0 && facet.cos_i > 0.0) {
            let cos_o = min(facet.cos_o, 1.0);
            let cos_i = min(facet.cos_i, 1.0);
            let exact = min(interface_between(cos_o, cos_i, eta).reflectance, 1.0);
            let cos_outside = select(cos_o, cos_i, view.is_inside);
            let reflected = refracting_reflectance(bsdf, vec4<f32>(exact), view.eta, cos_outside);
            let both = refraction(bsdf.roughness, view.wo, wi, facet);
            f += at_least_zero(1.0 - reflected) * tint * both.x;
            pdf += lobes.through * both.y;
        }
        return BsdfEval(f, pdf);
    }
    let kernel = reflection(bsdf.roughness, view.wo, mirror);
    let let_in = 1.0 - facet_reflectance(bsdf.second, kernel.cos_facet) * layers.specular;
    f += let_in * tint * cover(other) * kernel.value;
    pdf += lobes.through * kernel.pdf;
    return BsdfEval(f, pdf);
}

/// Light that the layers take and leave for the direction `wi`, which may lie behind.
fn split_at(bsdf: Bsdf, wi: vec3<f32>) -> EnergySplit {
    return energy_split(bsdf, Sight(vec3<f32>(wi.xy, abs(wi.z)), false));
}

/// Values and density of all lobes of some width.
fn eval_view(bsdf: Bsdf, wi: vec3<f32>, other: EnergySplit) -> BsdfEval {
    if (wi.z > 0.0) {
        return eval_reflection(bsdf, wi, other);
    }
    if (LAYERS_PASS) {
        return eval_transmission(bsdf, wi, other);
    }
    return no_scattering();
}

fn eval_layered(bsdf: Bsdf, wi_seen: vec3<f32>) -> BsdfEval {
    let wi = select(wi_seen, mirrored(wi_seen), view.is_inside);
    if (!scatters() || is_grazing(wi) || is_delta_layered(bsdf) || wi.z < 0.0 && !transmits_layered()) {
        return no_scattering();
    }
    return eval_view(bsdf, wi, split_at(bsdf, wi));
}

/// Passes light refracted by a polished surface; `pass_undisturbed` with a volume behind.
fn pass_refracted(bsdf: Bsdf) -> BsdfSample {
    let wo = view.wo;
    let cosine = min(wo.z, 1.0);
    let eta = view.eta.x;
    let through = interface_of(cosine, eta).cos_transmitted;
    if (through <= GRAZING) {
        return no_sample();
    }
    let let_in = at_least_zero(1.0 - clear_reflectance(bsdf, view.eta, view.is_inside, cosine));
    let part = let_in * bsdf.first * parts_of().z;
    let f = part * lanes_of(1.0 / (eta * eta * through), bsdf.is_dispersive);
    let wi = vec3<f32>(-wo.xy / eta, -through);
    return BsdfSample(f, view.lobes.through, wi, eta, true, true, bsdf.is_dispersive);
}

/// Passes light straight on; `pass_undisturbed` without a volume.
fn pass_straight(bsdf: Bsdf, wi: vec3<f32>, other: EnergySplit) -> BsdfSample {
    let let_in = at_least_zero(1.0 - facet_reflectance(bsdf.second, -wi.z) * layers.specular);
    let part = let_in * bsdf.first * cover(other) * parts_of().z;
    return BsdfSample(part / -wi.z, view.lobes.through, wi, 1.0, true, true, false);
}

/// A direction through a facet; zero where there is none.
fn sample_through(bsdf: Bsdf, u: vec2<f32>) -> vec3<f32> {
    let wo = view.wo;
    let m = sample_visible(bsdf.roughness, wo, u);
    if (!(HAS_VOLUMES && view.refracts)) {
        let wi = reflect_at(wo, m);
        return select(vec3<f32>(0.0), mirrored(wi), wi.z > GRAZING);
    }
    let cos_o = clamp(dot(wo, m), 0.0, 1.0);
    let eta = view.eta.x;
    let cos_i = interface_of(cos_o, eta).cos_transmitted;
    let wi = (cos_o / eta - cos_i) * m - wo / eta;
    return select(vec3<f32>(0.0), wi, cos_o > 0.0 && cos_i > 0.0 && wi.z < -GRAZING);
}

fn sample_view(bsdf: Bsdf, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    let lobes = view.lobes;
    let wo = view.wo;
    // Where u_lobe lies among the probabilities laid end to end.
    let to_sheen = lobes.coat + lobes.sheen;
    let to_facets = to_sheen + lobes.facets;
    let to_through = to_facets + lobes.through;
    let to_base = to_through + lobes.base;
    var wi = vec3<f32>(0.0);
    var is_undisturbed = false;
    if (HAS_COAT && u_lobe < lobes.coat) {
        let frame = frame_from_normal(layers.coat_normal);
        let wo_coat = to_local(frame, wo);
        if (!is_above(wo_coat)) {
            return no_sample();
        }
        if (layers.coat_alpha == 0.0) {
            let mirror = to_world(frame, vec3<f32>(-wo_coat.xy, wo_coat.z));
            let part = layered_part(bsdf) * layers.coat_weight * coat_fresnel(min(wo_coat.z, 1.0));
            if (!is_above(mirror)) {
                return no_sample();
            }
            return mirror_sample(vec4<f32>(part), mirror, lobes.coat);
        }
        let alpha = vec2<f32>(layers.coat_alpha);
        let wi_coat = reflect_at(wo_coat, sample_visible(alpha, wo_coat, u));
        if (!is_above(wi_coat)) {
            return no_sample();
        }
        wi = to_world(frame, wi_coat);
    } else if (HAS_SHEEN && u_lobe < to_sheen) {
        wi = uniform_cone(u, 0.0);
    } else if (u_lobe < to_facets) {
        is_undisturbed = is_smooth(bsdf.roughness);
        if (is_undisturbed) {
            wi = vec3<f32>(-wo.xy, wo.z);
        } else {
            wi = reflect_at(wo, sample_visible(bsdf.roughness, wo, u));
            if (!is_above(wi)) {
                return no_sample();
            }
        }
    } else if (HAS_TRANSMISSION && u_lobe < to_through) {
        is_undisturbed = passes_undisturbed(bsdf);
        if (is_undisturbed) {
            if (HAS_VOLUMES && view.refracts) {
                return pass_refracted(bsdf);
            }
            wi = vec3<f32>(-wo.xy, -min(wo.z, 1.0));
        } else {
            wi = sample_through(bsdf, u);
        }
    } else if (u_lobe < to_base) {
        wi = sample_base(bsdf, (u_lobe - to_through) / lobes.base, u);
    } else if (LAYERS_PASS && lobes.base_behind > 0.0) {
        wi = mirrored(sample_base(bsdf, (u_lobe - to_base) / lobes.base_behind, u));
    }
    if (is_grazing(wi)) {
        return no_sample();
    }
    let other = split_at(bsdf, wi);
    if (is_undisturbed) {
        if (LAYERS_PASS && wi.z < 0.0) {
            return pass_straight(bsdf, wi, other);
        }
        return mirror_sample(all_facets(bsdf, min(wo.z, 1.0), other), wi, lobes.facets);
    }
    let scattering = eval_view(bsdf, wi, other);
    var sample = reflected_sample(scattering.f, wi, scattering.pdf);
    if (LAYERS_PASS && wi.z < 0.0) {
        sample.is_transmission = true;
        sample.eta = select(1.0, view.eta.x, view.refracts);
    }
    return sample;
}

fn sample_layered(bsdf: Bsdf, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    if (!scatters()) {
        return no_sample();
    }
    var sample = sample_view(bsdf, u_lobe, u);
    sample.wi = select(sample.wi, mirrored(sample.wi), view.is_inside);
    return sample;
}

/// The part of the light from `wo` that goes straight on.
fn straight_layered(bsdf: Bsdf, wo: vec3<f32>) -> vec4<f32> {
    view_layers(bsdf, wo);
    let is_clear = select(is_smooth(bsdf.roughness), all(view.eta == vec4<f32>(1.0)), view.refracts);
    if (!scatters() || !is_clear || layers.transmission <= 0.0) {
        return vec4<f32>(0.0);
    }
    var sample: BsdfSample;
    if (HAS_VOLUMES && view.refracts) {
        sample = pass_refracted(bsdf);
    } else {
        let wi = vec3<f32>(-view.wo.xy, -min(view.wo.z, 1.0));
        sample = pass_straight(bsdf, wi, split_at(bsdf, wi));
    }
    return sample.f * abs(sample.wi.z);
}
