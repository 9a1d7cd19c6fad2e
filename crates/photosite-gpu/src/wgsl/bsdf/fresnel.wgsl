// Fresnel reflectance; photosite-transport's bsdf/fresnel.rs.

struct Interface {
    reflectance: f32,
    transmittance: f32,
    cos_transmitted: f32,
}

/// An interface where both cosines are known; `between`.
fn interface_between(cos_incident: f32, cos_transmitted: f32, eta: f32) -> Interface {
    let eta_cos_incident = eta * cos_incident;
    let eta_cos_transmitted = eta * cos_transmitted;
    let parallel = 1.0 / (eta_cos_incident + cos_transmitted);
    let perpendicular = 1.0 / (cos_incident + eta_cos_transmitted);
    let r_p = (eta_cos_incident - cos_transmitted) * parallel;
    let r_s = (cos_incident - eta_cos_transmitted) * perpendicular;
    let transmittance = 2.0 * cos_incident * eta_cos_transmitted * (parallel * parallel + perpendicular * perpendicular);
    return Interface(0.5 * (r_p * r_p + r_s * r_s), transmittance, cos_transmitted);
}

/// An interface of two clear media; `dielectric`.
fn interface_of(cos_incident: f32, eta: f32) -> Interface {
    let far_squared = (eta - 1.0) * (eta + 1.0) + cos_incident * cos_incident;
    if (far_squared <= 0.0) {
        let transmittance = select(0.0, 1.0, eta == 1.0);
        return Interface(1.0 - transmittance, transmittance, 0.0);
    }
    return interface_between(cos_incident, min(sqrt(far_squared) / eta, 1.0), eta);
}

/// Reflectance of a metal of index η + i·k; `conductor`.
fn metal_reflectance(cos_incident: f32, eta: vec4<f32>, k: vec4<f32>) -> vec4<f32> {
    let cos_squared = cos_incident * cos_incident;
    let sin_squared = max(1.0 - cos_squared, 0.0);
    let real = (eta - k) * (eta + k) - sin_squared;
    let half_imaginary = eta * k;
    let modulus = sqrt(real * real + 4.0 * half_imaginary * half_imaginary);
    let larger = sqrt(0.5 * (modulus + abs(real)));
    let a = select(half_imaginary / max(larger, vec4<f32>(MIN_POSITIVE)), larger, real >= vec4<f32>(0.0));
    let first_sum = modulus + cos_squared;
    let first_cross = (2.0 * cos_incident) * a;
    let perpendicular = (first_sum - first_cross) / max(first_sum + first_cross, vec4<f32>(MIN_POSITIVE));
    let sum = cos_squared * modulus + sin_squared * sin_squared;
    let cross = sin_squared * first_cross;
    let ratio = (sum - cross) / max(sum + cross, vec4<f32>(MIN_POSITIVE));
    return 0.5 * (perpendicular + perpendicular * ratio);
}
