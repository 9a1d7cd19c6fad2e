// The choice of the model; photosite-transport's bsdf/model.rs.

fn eval_bsdf(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    switch bsdf.model {
        case MODEL_DIFFUSE: { return eval_diffuse(bsdf, wo, wi); }
        case MODEL_CONDUCTOR: { return eval_conductor(bsdf, wo, wi); }
        case MODEL_DIELECTRIC: { return eval_dielectric(bsdf, wo, wi); }
        case MODEL_OREN_NAYAR: { return eval_oren_nayar(bsdf, wo, wi); }
        case MODEL_PHONG: { return eval_phong(bsdf, wo, wi); }
        case MODEL_TRANSLUCENT: { return eval_translucent(bsdf, wo, wi); }
        case MODEL_LAYERED: { return eval_layered(bsdf, wo, wi); }
        // A pane scatters into single directions.
        default: { return no_scattering(); }
    }
}

fn sample_bsdf(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32, u: vec2<f32>) -> BsdfSample {
    switch bsdf.model {
        case MODEL_DIFFUSE: { return sample_diffuse(bsdf, wo, u); }
        case MODEL_CONDUCTOR: { return sample_conductor(bsdf, wo, u); }
        case MODEL_DIELECTRIC: { return sample_dielectric(bsdf, wo, u_lobe, u); }
        case MODEL_OREN_NAYAR: { return sample_oren_nayar(bsdf, wo, u_lobe, u); }
        case MODEL_PHONG: { return sample_phong(bsdf, wo, u_lobe, u); }
        case MODEL_TRANSLUCENT: { return sample_translucent(bsdf, wo, u_lobe, u); }
        case MODEL_LAYERED: { return sample_layered(bsdf, wo, u_lobe, u); }
        default: { return sample_thin_dielectric(bsdf, wo, u_lobe); }
    }
}

/// The part of the light from wo that goes straight on, to −wo.
fn straight(bsdf: Bsdf, wo: vec3<f32>) -> vec4<f32> {
    switch bsdf.model {
        case MODEL_DIELECTRIC: { return straight_dielectric(bsdf, wo); }
        case MODEL_THIN_DIELECTRIC: { return straight_thin_dielectric(bsdf, wo); }
        default: { return vec4<f32>(0.0); }
    }
}

/// Whether sampling chooses among lobes, so that its first random number matters.
fn has_lobes(bsdf: Bsdf) -> bool {
    return bsdf.model != MODEL_DIFFUSE && bsdf.model != MODEL_CONDUCTOR;
}

fn transmits(bsdf: Bsdf) -> bool {
    return bsdf.model == MODEL_DIELECTRIC || bsdf.model == MODEL_TRANSLUCENT || bsdf.model == MODEL_THIN_DIELECTRIC;
}

/// Whether every lobe is a single direction.
fn is_delta(bsdf: Bsdf) -> bool {
    switch bsdf.model {
        case MODEL_CONDUCTOR: { return is_smooth(bsdf.roughness); }
        case MODEL_DIELECTRIC: { return is_delta_dielectric(bsdf); }
        case MODEL_LAYERED: { return is_delta_layered(bsdf); }
        case MODEL_THIN_DIELECTRIC: { return true; }
        default: { return false; }
    }
}

/// Whether the surface separates two media, so that the frame keeps its side.
fn refracts(model: u32) -> bool {
    return model == MODEL_DIELECTRIC;
}
