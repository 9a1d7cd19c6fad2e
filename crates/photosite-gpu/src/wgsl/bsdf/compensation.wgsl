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

/// Shares of reflection and transmission in the light that one bounce at an interface leaves: factors of radiance on that side
/// and on the other, and the part that crosses.
struct Shared {
    here: vec4<f32>,
    behind: vec4<f32>,
    crossing: vec4<f32>,
}

/// Shares of what is left on that side and on the other, all zero where nothing is; `shared_out`.
fn shared_out(part: f32, eta: f32, here: vec4<f32>, there: vec4<f32>) -> Shared {
    let let_in = 1.0 - mean_dielectric(eta);
    let most = max(here, there);
    let is_something = most > vec4<f32>(NOTHING_LEFT);
    let crossing = let_in * there / most;
    let own = part * FRAC_1_PI * (1.0 - crossing) / max(here, vec4<f32>(NOTHING_LEFT));
    let other = part * FRAC_1_PI * let_in / (most * eta * eta);
    let zero = vec4<f32>(0.0);
    return Shared(select(zero, own, is_something), select(zero, other, is_something), select(zero, crossing, is_something));
}
