// Light that bounces more than once between facets; photosite-transport's bsdf/compensation.rs.

const NOTHING_LEFT = 1e-5f;

/// Part that metal facets give back after further bounces.
fn further_bounces(part: f32, mean_reflectance: vec4<f32>, mean_albedo: f32) -> vec4<f32> {
    let f = mean_reflectance;
    return f * f * (part * mean_albedo) / (1.0 - f * (1.0 - mean_albedo));
}

/// Mean of the reflectance of an interface of two clear media over the hemisphere; `mean_dielectric`.
fn mean_dielectric(eta: f32) -> f32 {
    let denser = select(eta, 1.0 / eta, eta < 1.0);
    let mean = (denser - 1.0) / (4.08567 + 1.00071 * denser);
    return select(mean, 1.0 - eta * eta * (1.0 - mean), eta < 1.0);
}

/// Shares of what one bounce at an interface leaves, on that side and on the other; `shared_out`.
fn shared_out(part: f32, eta: f32, here: vec4<f32>, there: vec4<f32>) -> array<vec4<f32>, 2> {
    let let_in = 1.0 - mean_dielectric(eta);
    let most = max(here, there);
    let is_something = most > vec4<f32>(NOTHING_LEFT);
    let crossing = let_in * there / most;
    let own = part * FRAC_1_PI * (1.0 - crossing) / max(here, vec4<f32>(NOTHING_LEFT));
    let other = part * FRAC_1_PI * let_in / (most * eta * eta);
    return array<vec4<f32>, 2>(select(vec4<f32>(0.0), own, is_something), select(vec4<f32>(0.0), other, is_something));
}
