// Panes; photosite-transport's bsdf/thin_dielectric.rs.

/// Reflectance and transmittance of a pane at one wavelength.
fn pane_parts(cosine: f32, eta: f32, transmittance: f32) -> vec2<f32> {
    let surface = interface_of(cosine, eta);
    if (surface.cos_transmitted <= 0.0) {
        return vec2<f32>(1.0, 0.0);
    }
    let r = surface.reflectance;
    let t = surface.transmittance;
    let once = select(0.0, pow(transmittance, 1.0 / surface.cos_transmitted), transmittance > 0.0);
    let passed = t * t * once / max((t + r * (1.0 - once)) * (1.0 + r * once), MIN_POSITIVE);
    return vec2<f32>(r + r * once * passed, passed);
}

/// Reflectance and transmittance of a pane at the wavelengths of a path; `ThinDielectric::parts`.
struct PaneParts {
    reflected: vec4<f32>,
    passed: vec4<f32>,
}

fn pane_parts_of(bsdf: Bsdf, cosine: f32) -> PaneParts {
    let a = pane_parts(cosine, bsdf.first.x, bsdf.second.x);
    let b = pane_parts(cosine, bsdf.first.y, bsdf.second.y);
    let c = pane_parts(cosine, bsdf.first.z, bsdf.second.z);
    let d = pane_parts(cosine, bsdf.first.w, bsdf.second.w);
    return PaneParts(vec4<f32>(a.x, b.x, c.x, d.x), vec4<f32>(a.y, b.y, c.y, d.y));
}

fn straight_thin_dielectric(bsdf: Bsdf, wo: vec3<f32>) -> vec4<f32> {
    if (!is_above(wo)) {
        return vec4<f32>(0.0);
    }
    return pane_parts_of(bsdf, min(wo.z, 1.0)).passed;
}

fn sample_thin_dielectric(bsdf: Bsdf, wo: vec3<f32>, u_lobe: f32) -> BsdfSample {
    if (!is_above(wo)) {
        return no_sample();
    }
    let parts = pane_parts_of(bsdf, min(wo.z, 1.0));
    let part = mean_of(parts.reflected) / (mean_of(parts.reflected) + mean_of(parts.passed));
    if (u_lobe < part) {
        return mirror_sample(parts.reflected, vec3<f32>(-wo.xy, wo.z), part);
    }
    var sample = mirror_sample(parts.passed, -wo, 1.0 - part);
    sample.is_transmission = true;
    return sample;
}
