// Fibres that stand on a surface; photosite-transport's bsdf/sheen.rs.

const SHEEN_SMALLEST_COSINE = 1e-4f;

fn sheen_density(cos_half: f32, alpha: f32) -> f32 {
    let sin_squared = max(1.0 - cos_half * cos_half, 0.0);
    let inverse = 1.0 / alpha;
    return (2.0 + inverse) * pow(max(sin_squared, MIN_POSITIVE), 0.5 * inverse) / TAU;
}

/// Fit of the logarithm of the area hidden over the area seen, for cosines up to a half.
fn sheen_fit(x: f32, t: f32) -> f32 {
    let a = mix(21.5473, 25.3245, t);
    let b = mix(3.82987, 3.32435, t);
    let c = mix(0.19823, 0.16801, t);
    let d = mix(-1.97760, -1.27393, t);
    let e = mix(-4.32054, -4.85967, t);
    return a / (1.0 + b * pow(max(x, MIN_POSITIVE), c)) + d * x + e;
}

fn sheen_lambda(cosine: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    if (cosine < 0.5) {
        return exp(sheen_fit(cosine, t));
    }
    return exp(2.0 * sheen_fit(0.5, t) - sheen_fit(1.0 - cosine, t));
}

/// The published value for a colour of 1; both directions above the surface.
fn published_sheen(alpha: f32, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if (!(is_above(wo) && is_above(wi))) {
        return 0.0;
    }
    let bounded = max(alpha, SHEEN_SMALLEST_ALPHA);
    let cos_o = max(wo.z, SHEEN_SMALLEST_COSINE);
    let cos_i = max(wi.z, SHEEN_SMALLEST_COSINE);
    let hidden = 1.0 + sheen_lambda(cos_o, bounded) + sheen_lambda(cos_i, bounded);
    return sheen_density(normalize(wo + wi).z, bounded) / (hidden * 4.0 * cos_o * cos_i);
}
