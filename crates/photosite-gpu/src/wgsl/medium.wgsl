// Volumes that absorb behind surfaces; the functions of photosite-transport's scene/mod.rs on media.

/// Spectrum of what a point's material bounds; [`NONE`] for none.
fn absorption_of(point: SurfacePoint) -> u32 {
    return normal_map_of(point).z;
}

/// Medium that light to `wo` has come through, where the point is seen from within a volume.
fn absorption_behind(point: SurfacePoint, wo: vec3<f32>) -> u32 {
    return select(NONE, absorption_of(point), dot(wo, point.geometric_normal) < 0.0);
}

/// Medium beyond a point for light that passes it in the direction `wi` and was in `medium` before.
fn medium_across(point: SurfacePoint, wi: vec3<f32>, medium: u32) -> u32 {
    let absorption = absorption_of(point);
    let entered = select(NONE, absorption, dot(wi, point.geometric_normal) < 0.0);
    return select(entered, medium, absorption == NONE);
}

/// Part of the light that is left after a distance in a medium: exp(−σ·d).
fn transmittance(medium: u32, distance: f32, lambda_nm: vec4<f32>) -> vec4<f32> {
    if (medium == NONE) {
        return vec4<f32>(1.0);
    }
    return exp(-distance * spectrum(medium, lambda_nm));
}

/// A medium beside a bit, in the word of a path that says so.
fn medium_bits(medium: u32) -> u32 {
    return (medium + 1u) << 1u;
}

/// The medium of such a word; [`NONE`] where there is none.
fn medium_of(word: u32) -> u32 {
    return (word >> 1u) - 1u;
}
