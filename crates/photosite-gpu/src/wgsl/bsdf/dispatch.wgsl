// The choice of the model; photosite-transport's bsdf/model.rs.

/// Prepares a BSDF for the direction from which it is seen, before it is evaluated or sampled.
fn view_bsdf(bsdf: Bsdf, wo: vec3<f32>) {
    if (HAS_LAYERED && bsdf.model == MODEL_LAYERED) {
        view_layers(bsdf, wo);
    }
}

fn eval_bsdf(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    switch bsdf.model {
        case MODEL_DIFFUSE: { return eval_diffuse(bsdf, wo, wi); }
        case MODEL_CONDUCTOR: { return eval_conductor(bsdf, wo, wi); }
        case MODEL_DIELECTRIC: { return eval_dielectric(bsdf, wo, wi); }
        case MODEL_OREN_NAYAR: { return eval_oren_nayar(bsdf, wo, wi); }
        case MODEL_PHONG: { return eval_phong(bsdf, wo, wi); }
        case MODEL_RETROREFLECTIVE: { return eval_retroreflective(bsdf, wo, wi); }
        case MODEL_TRANSLUCENT: { return eval_translucent(bsdf, wo, wi); }
        case MODEL_LAYERED: { if (HAS_LAYERED) { return eval_layered(bsdf, wi); } }
        // A pane scatters into single directions.
        default: {}
    }
    return no_scattering();
}

fn sample_bsdf(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    switch bsdf.model {
        case MODEL_DIFFUSE: { return sample_diffuse(bsdf, wo, u); }
        case MODEL_CONDUCTOR: { return sample_conductor(bsdf, wo, u_lobe, u); }
        case MODEL_DIELECTRIC: { return sample_dielectric(bsdf, wo, u_lobe, u); }
        case MODEL_OREN_NAYAR: { return sample_oren_nayar(bsdf, wo, u_lobe, u); }
        case MODEL_PHONG: { return sample_phong(bsdf, wo, u_lobe, u); }
        case MODEL_RETROREFLECTIVE: { return sample_retroreflective(bsdf, wo, u_lobe, u); }
        case MODEL_TRANSLUCENT: { return sample_translucent(bsdf, wo, u_lobe, u); }
        case MODEL_LAYERED: { if (HAS_LAYERED) { return sample_layered(bsdf, u_lobe, u); } }
        default: { return sample_thin_dielectric(bsdf, wo, u_lobe); }
    }
    return no_sample();
}

/// The part of the light from wo that goes straight on, to −wo.
fn straight(bsdf: Bsdf, wo: vec3<f32>) -> vec4<f32> {
    switch bsdf.model {
        case MODEL_DIELECTRIC: { return straight_dielectric(bsdf, wo); }
        case MODEL_THIN_DIELECTRIC: { return straight_thin_dielectric(bsdf, wo); }
        case MODEL_LAYERED: {
            if (HAS_TRANSMISSION) {
                return straight_layered(bsdf, wo);
            }
            return vec4<f32>(0.0);
        }
        default: { return vec4<f32>(0.0); }
    }
}

/// Whether sampling chooses among lobes, so that its first random number matters.
fn has_lobes(bsdf: Bsdf) -> bool {
    return bsdf.model != MODEL_DIFFUSE && (bsdf.model != MODEL_CONDUCTOR || bsdf.is_compensated);
}

fn transmits(bsdf: Bsdf) -> bool {
    switch bsdf.model {
        case MODEL_DIELECTRIC, MODEL_TRANSLUCENT, MODEL_THIN_DIELECTRIC: { return true; }
        case MODEL_LAYERED: { return transmits_layered(); }
        default: { return false; }
    }
}

/// Whether dispersion keeps the BSDF from serving all wavelengths of a path.
fn needs_single_wavelength(bsdf: Bsdf) -> bool {
    switch bsdf.model {
        case MODEL_DIELECTRIC: { return bsdf.is_dispersive && !is_delta_dielectric(bsdf); }
        case MODEL_LAYERED: { return layered_needs_single_wavelength(bsdf); }
        default: { return false; }
    }
}

/// Whether every lobe is a single direction.
fn is_delta(bsdf: Bsdf) -> bool {
    switch bsdf.model {
        case MODEL_CONDUCTOR: { return is_smooth(bsdf.roughness); }
        case MODEL_DIELECTRIC: { return is_delta_dielectric(bsdf); }
        case MODEL_LAYERED: { return is_delta_layered(bsdf); }
        case MODEL_THIN_DIELECTRIC: { return true; }
        case MODEL_RETROREFLECTIVE: { return is_smooth(bsdf.roughness) && all(bsdf.second == vec4<f32>(0.0)); }
        default: { return false; }
    }
}

/// Whether the surface separates two media, so that the frame keeps its side.
fn refracts(bsdf: Bsdf) -> bool {
    return bsdf.model == MODEL_DIELECTRIC || bsdf.model == MODEL_LAYERED && refracts_layered();
}
