// The choice of a light; photosite-transport's light/tree.rs, light/selection.rs, light/light_sample_context.rs.

/// A point that lights are sampled from.
struct LightContext {
    point: vec3<f32>,
    normal: vec3<f32>,
    /// Whether light matters on both sides of the normal.
    is_both: bool,
}

struct Choice {
    /// [`NONE`] where no light of the part that was chosen can reach the point.
    light: u32,
    probability: f32,
    /// Remainder of the random number that chose.
    rest: f32,
}

/// Cosine to an axis of the direction that goes farthest along it.
fn farthest_cosine(along: f32, spread: f32, nearest2: f32, farthest2: f32) -> f32 {
    let most = along + spread;
    if (most >= 0.0 && most * most >= nearest2) {
        return 1.0;
    }
    return most / sqrt(select(farthest2, nearest2, most > 0.0));
}

/// An estimate of the irradiance from the lights of a node; 0 only where none of them can reach the point.
fn importance(node: u32, ctx: LightContext) -> f32 {
    let at = params.tree + node * TREE_WORDS;
    let a = bitcast<vec4<f32>>(tables[at]);
    let b = bitcast<vec4<f32>>(tables[at + 1u]);
    let c = bitcast<vec4<f32>>(tables[at + 2u]);
    let is_two_sided = (tables[at + 3u].x & 2u) != 0u;
    let to_centre = a.xyz - ctx.point;
    let half = b.xyz;
    let cos_cone = b.w;
    let axis = c.xyz;
    let aside = abs(to_centre);
    let near = max(aside - half, vec3<f32>(0.0));
    let nearest2 = dot(near, near);
    let far = aside + half;
    let farthest2 = dot(far, far);
    var along_axis = -dot(axis, to_centre);
    along_axis = select(along_axis, abs(along_axis), is_two_sided);
    let cos_axis = farthest_cosine(along_axis, dot(abs(axis), half), nearest2, farthest2);
    var at_light = 1.0;
    if (cos_axis < cos_cone) {
        let sines = (1.0 - cos_axis * cos_axis) * (1.0 - cos_cone * cos_cone);
        at_light = cos_axis * cos_cone + sqrt(max(sines, 0.0));
    }
    if (at_light < c.w) {
        return 0.0;
    }
    let height = dot(ctx.normal, to_centre);
    let spread = dot(abs(ctx.normal), half);
    let at_front = max(farthest_cosine(height, spread, nearest2, farthest2), 0.0);
    let at_both = farthest_cosine(abs(height), spread, nearest2, farthest2);
    let at_receiver = select(at_front, at_both, ctx.is_both);
    let distance2 = max(dot(to_centre, to_centre), dot(half, half));
    return a.w * at_light * at_receiver / max(distance2, 1e-30);
}

/// Probability of the left half of two nodes side by side; −1 where neither can reach the point.
fn probability_of_left(left_node: u32, ctx: LightContext) -> f32 {
    let left = importance(left_node, ctx);
    let right = importance(left_node + 1u, ctx);
    if (left == 0.0 || right == 0.0) {
        return select(-1.0, select(0.0, 1.0, left > 0.0), left + right > 0.0);
    }
    return clamp(left / (left + right), 1e-6, 1.0 - 1e-6);
}

fn choose_in_tree(ctx: LightContext, number: f32) -> Choice {
    var u = number;
    var probability = 1.0;
    var node = 0u;
    if (params.tree_nodes == 0u) {
        return Choice(NONE, 0.0, 0.0);
    }
    loop {
        let link = tables[params.tree + node * TREE_WORDS + 3u];
        if ((link.x & 1u) != 0u) {
            let of_first = bitcast<f32>(link.w);
            let is_second = u >= of_first;
            let part = select(of_first, 1.0 - of_first, is_second);
            let rest = rest_of(u, select(0.0, of_first, is_second), part);
            return Choice(select(link.y, link.z, is_second), probability * part, rest);
        }
        let of_left = probability_of_left(link.y, ctx);
        if (of_left < 0.0) {
            return Choice(NONE, 0.0, 0.0);
        }
        let is_right = u >= of_left;
        let part = select(of_left, 1.0 - of_left, is_right);
        u = rest_of(u, select(0.0, of_left, is_right), part);
        probability *= part;
        node = link.y + select(0u, 1u, is_right);
    }
    return Choice(NONE, 0.0, 0.0);
}

/// Probability with which the tree finds a light of that rank.
fn probability_in_tree(ctx: LightContext, light: u32, rank: u32) -> f32 {
    if (rank == NONE || params.tree_nodes == 0u) {
        return 0.0;
    }
    var probability = 1.0;
    var node = 0u;
    loop {
        let link = tables[params.tree + node * TREE_WORDS + 3u];
        if ((link.x & 1u) != 0u) {
            let of_first = bitcast<f32>(link.w);
            return probability * select(1.0 - of_first, of_first, light == link.y);
        }
        let of_left = probability_of_left(link.y, ctx);
        if (of_left < 0.0) {
            return 0.0;
        }
        let is_right = rank >= link.z;
        probability *= select(of_left, 1.0 - of_left, is_right);
        node = link.y + select(0u, 1u, is_right);
    }
    return 0.0;
}

/// Probability of a light infinitely far.
fn part_of_distant(ctx: LightContext) -> f32 {
    if (params.distant_count == 0u) {
        return 0.0;
    }
    if (params.tree_nodes == 0u) {
        return 1.0;
    }
    let near = importance(0u, ctx);
    if (near == 0.0) {
        return 1.0;
    }
    if (params.irradiance == 0.0) {
        return 0.0;
    }
    return clamp(params.irradiance / (params.irradiance + near), 0.1, 0.9);
}

fn choose_light(ctx: LightContext, u: f32) -> Choice {
    if (params.distant_count == 0u) {
        return choose_in_tree(ctx, u);
    }
    let distant = part_of_distant(ctx);
    if (u < distant) {
        let scaled = rest_of(u, 0.0, distant) * f32(params.distant_count);
        let number = min(u32(scaled), params.distant_count - 1u);
        let within = scaled - f32(number);
        let bin = tables[params.distant + number];
        let keep = bitcast<f32>(bin.y);
        let is_kept = within < keep;
        let entry = select(bin.z, number, is_kept);
        let rest = select(rest_of(within, keep, 1.0 - keep), rest_of(within, 0.0, keep), is_kept);
        let chosen = tables[params.distant + entry];
        return Choice(chosen.x, bitcast<f32>(chosen.w) * distant, rest);
    }
    let near = 1.0 - distant;
    var choice = choose_in_tree(ctx, rest_of(u, distant, near));
    choice.probability *= near;
    return choice;
}
