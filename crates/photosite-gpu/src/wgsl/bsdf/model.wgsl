// A BSDF at a shading point, and what all models have in common; photosite-transport's bsdf/mod.rs, bsdf/sample.rs,
// bsdf/directions.rs.

/// Scattering model with its parameters at the wavelengths of a path.
struct Bsdf {
    model: u32,
    /// Roughness α along x and y; the exponent of Phong's model; the relief of a diffuse surface.
    roughness: vec2<f32>,
    /// Reflectance; index η; diffuse reflectance of Phong's model.
    first: vec4<f32>,
    /// Extinction coefficient k; transmittance; specular reflectance.
    second: vec4<f32>,
    is_dispersive: bool,
    /// Whether light counts that bounces more than once between facets.
    is_compensated: bool,
    /// Whether a clear medium has the index 1 at all wavelengths.
    has_index_one: bool,
    /// Index of cube corners, and their mean active part.
    corners: vec2<f32>,
}

struct BsdfEval {
    f: vec4<f32>,
    pdf: f32,
}

struct BsdfSample {
    f: vec4<f32>,
    /// 0 where the draw leads nowhere.
    pdf: f32,
    wi: vec3<f32>,
    /// Index on the side of wi over that on the side of wo.
    eta: f32,
    is_delta: bool,
    is_transmission: bool,
    terminates_secondary: bool,
}

const GRAZING = 1e-7f;

fn is_above(w: vec3<f32>) -> bool {
    return w.z > GRAZING;
}

fn is_grazing(w: vec3<f32>) -> bool {
    return abs(w.z) <= GRAZING;
}

fn mirrored(w: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(w.xy, -w.z);
}

fn mean_of(s: vec4<f32>) -> f32 {
    return dot(s, vec4<f32>(0.25));
}

fn no_scattering() -> BsdfEval {
    return BsdfEval(vec4<f32>(0.0), 0.0);
}

fn no_sample() -> BsdfSample {
    return BsdfSample(vec4<f32>(0.0), 0.0, vec3<f32>(0.0), 1.0, false, false, false);
}

/// A reflected direction of a lobe of some width.
fn reflected_sample(f: vec4<f32>, wi: vec3<f32>, pdf: f32) -> BsdfSample {
    return BsdfSample(f, pdf, wi, 1.0, false, false, false);
}

/// The one direction of a mirror.
fn mirror_sample(reflectance: vec4<f32>, wi: vec3<f32>, probability: f32) -> BsdfSample {
    return BsdfSample(reflectance / abs(wi.z), probability, wi, 1.0, true, false, false);
}
