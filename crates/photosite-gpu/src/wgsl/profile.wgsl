// Lights whose intensity was measured in many directions; photosite-transport's light/profile.rs.

fn profile_number(index: u32) -> f32 {
    return bitcast<f32>(attributes[params.profiles + index]);
}

/// The two neighbours of an angle with their weights; weights of 0 outside.
struct Neighbours {
    low: u32,
    high: u32,
    weights: vec2<f32>,
}

/// The neighbours of an angle among `count` rising ones, the first of which has the number `first`; `between`.
fn neighbours(first: u32, count: u32, angle: f32) -> Neighbours {
    if (count == 1u) {
        return Neighbours(0u, 0u, vec2<f32>(1.0, 0.0));
    }
    // The number of angles that are not above
    var next = 0u;
    var end = count;
    while (next < end) {
        let middle = (next + end) / 2u;
        if (profile_number(first + middle) <= angle) {
            next = middle + 1u;
        } else {
            end = middle;
        }
    }
    next = min(next, count - 1u);
    if (next == 0u) {
        return Neighbours(0u, 0u, vec2<f32>(0.0));
    }
    let low = profile_number(first + next - 1u);
    let part = (angle - low) / (profile_number(first + next) - low);
    return Neighbours(next - 1u, next, select(vec2<f32>(0.0), vec2<f32>(1.0 - part, part), part <= 1.0));
}

/// Intensity, cd, in a unit direction of the light's space.
fn profile_intensity(at: u32, direction: vec3<f32>) -> f32 {
    let words = tables[at + 2u];
    let horizontals = words.x + words.y;
    let candela = horizontals + words.z;
    let angle = arc_tangent(direction.y, direction.x);
    let turned = min(select(angle, angle + TAU, angle < 0.0), profile_number(candela - 1u));
    let v = neighbours(words.x, words.y, arc_tangent(length(direction.xy), -direction.z));
    let h = neighbours(horizontals, words.z, turned);
    let low = candela + h.low * words.y;
    let high = candela + h.high * words.y;
    let at_low = profile_number(low + v.low) * v.weights.x + profile_number(low + v.high) * v.weights.y;
    let at_high = profile_number(high + v.low) * v.weights.x + profile_number(high + v.high) * v.weights.y;
    return at_low * h.weights.x + at_high * h.weights.y;
}

fn sample_profile(at: u32, level: u32, ctx: LightContext, lambda_nm: vec4<f32>) -> LightSample {
    let pose = light_pose(at);
    let away = normalized_or(ctx.point - pose.position, vec3<f32>(0.0));
    let candela = profile_intensity(at, rotated(pose.world_to_light, away));
    if (candela == 0.0) {
        return no_light();
    }
    return sample_from_point(ctx.point, pose.position, spectrum(level, lambda_nm) * candela);
}
