// Rays through the hierarchies; photosite-transport's geometry/accel/packed.rs tells how they are packed.

struct Ray {
    origin: vec3<f32>,
    t_max: f32,
    direction: vec3<f32>,
    /// Triangle that the ray leaves, and its instance.
    leaves: u32,
    leaves_instance: u32,
    /// Primitive of a light that a shadow ray ends at.
    target_primitive: u32,
    /// Time from 0 to 1.
    time: f32,
}

struct Hit {
    t: f32,
    /// Position on the primitive.
    uv: vec2<f32>,
    /// Place of the triangle, or [`IS_QUADRIC`] and the index of a quadric; [`NONE`] for no hit.
    slot: u32,
    instance: u32,
}

const IS_QUADRIC = 0x80000000u;
/// Factor by which far planes are moved away, the bound on rounding.
const ENLARGED = 1.0000004f;
/// Factor of t.
const FIRST_MASK = (1u << FIRST_BITS) - 1u;

/// Children of a node whose boxes a ray enters, a bit for each in the order in which it comes to them.
fn entered(node: u32, ray: LocalRay, t_max: f32) -> u32 {
    let at = node * NODE_WORDS;
    let head = nodes[at];
    let origin = bitcast<vec3<f32>>(head.xyz);
    let exponents = (vec3<u32>(head.w) >> vec3<u32>(0u, 8u, 16u)) & vec3<u32>(255u);
    let scale = bitcast<vec3<f32>>(exponents << vec3<u32>(23u));
    let x = nodes[at + 3u];
    let y = nodes[at + 4u];
    let z = nodes[at + 5u];
    let runs_down = (vec3<u32>(ray.negative) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u);
    let reach = t_max * ENLARGED;
    var mask = 0u;
    for (var slot = 0u; slot < 8u; slot += 1u) {
        let shift = 8u * (slot & 3u);
        let is_upper = slot >= 4u;
        let low = (vec3<u32>(select(x.x, x.y, is_upper), select(y.x, y.y, is_upper), select(z.x, z.y, is_upper)) >> vec3<u32>(shift)) & vec3<u32>(255u);
        let high = (vec3<u32>(select(x.z, x.w, is_upper), select(y.z, y.w, is_upper), select(z.z, z.w, is_upper)) >> vec3<u32>(shift)) & vec3<u32>(255u);
        // A product with a power of two is exact: the planes are those that were packed.
        let low_plane = origin + vec3<f32>(low) * scale;
        let high_plane = origin + vec3<f32>(high) * scale;
        let to_near = (select(low_plane, high_plane, runs_down) - ray.origin) * ray.inverse;
        let to_far = (select(high_plane, low_plane, runs_down) - ray.origin) * ray.inverse * ENLARGED;
        let near = max(max(to_near.x, to_near.y), max(to_near.z, 0.0));
        let far = min(min(to_far.x, to_far.y), min(to_far.z, reach));
        mask |= select(0u, 1u << (slot ^ ray.negative), near <= far);
    }
    return mask;
}

fn child_of(node: u32, slot: u32) -> u32 {
    return nodes[node * NODE_WORDS + 1u + (slot >> 2u)][slot & 3u];
}

/// Number by which the lower of two primitives at the same distance is told.
fn order_of(slot: u32) -> u32 {
    return select(triangles[slot * TRIANGLE_WORDS].w, slot, (slot & IS_QUADRIC) != 0u);
}

/// Meets the triangles of a leaf. Returns whether one is in the way of a shadow ray.
fn visit_triangles(first: u32, count: u32, local: LocalRay, ray: Ray, instance: u32, is_shadow: bool, hit: ptr<function, Hit>) -> bool {
    for (var slot = first; slot < first + count; slot += 1u) {
        let at = slot * TRIANGLE_WORDS;
        let a = triangles[at];
        let b = triangles[at + 1u];
        let c = triangles[at + 2u];
        if (a.w == ray.leaves && instance == ray.leaves_instance) {
            continue;
        }
        var corners = Corners(bitcast<vec3<f32>>(a.xyz), bitcast<vec3<f32>>(b.xyz), bitcast<vec3<f32>>(c.xyz));
        if (b.w > 1u) {
            corners = corners_at(slot, b.w >> 1u, ray.time);
        }
        let met = meet_triangle(corners.a, corners.b, corners.c, (b.w & 1u) != 0u, local);
        if (!(met.x > 0.0)) {
            continue;
        }
        if (is_shadow) {
            if (met.x < ray.t_max && a.w != ray.target_primitive && is_there(a.w, c.w, met.yz, ray)) {
                return true;
            }
            continue;
        }
        let is_tie = met.x == (*hit).t && (*hit).slot != NONE;
        let is_nearer = met.x < (*hit).t || (is_tie && a.w < order_of((*hit).slot));
        if (is_nearer && is_there(a.w, c.w, met.yz, ray)) {
            *hit = Hit(met.x, met.yz, slot, instance);
        }
    }
    return false;
}

/// Meets a quadric. Returns whether it is in the way of a shadow ray.
fn visit_quadric(index: u32, ray: Ray, instance: u32, is_shadow: bool, hit: ptr<function, Hit>) -> bool {
    // Numbers of quadrics as targets count down from that of no triangle.
    if (is_shadow && ray.target_primitive == NONE - 1u - index) {
        return false;
    }
    let quadric = load_quadric(index);
    let sides = meet_quadric(quadric, ray.origin, ray.direction);
    let slot = IS_QUADRIC | index;
    for (var side = 0u; side < 2u; side += 1u) {
        let t = sides[side];
        let is_tie = !is_shadow && t == (*hit).t && (*hit).slot != NONE && slot < order_of((*hit).slot);
        if (t > 0.0 && (t < (*hit).t || is_tie)) {
            let parameters = quadric_parameters(quadric, ray.origin + ray.direction * t);
            // Of the two sides the nearer may have a hole.
            if (!is_there(slot, quadric.mesh, parameters, ray)) {
                continue;
            }
            if (is_shadow) {
                return true;
            }
            *hit = Hit(t, parameters, slot, instance);
            return false;
        }
    }
    return false;
}

fn transformed(row: u32, p: vec4<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(bitcast<vec4<f32>>(tables[row]), p),
        dot(bitcast<vec4<f32>>(tables[row + 1u]), p),
        dot(bitcast<vec4<f32>>(tables[row + 2u]), p),
    );
}

/// The nearest hit of a ray, or of a shadow ray any one, told by its slot alone.
fn trace(ray: Ray, is_shadow: bool) -> Hit {
    var hit = Hit(ray.t_max, vec2<f32>(0.0), NONE, 0u);
    if (params.root == NONE) {
        return hit;
    }
    var local = local_ray(ray.origin, ray.direction);
    var instance = 0u;
    // Groups of children that are yet to be visited: a node and their bits, or one child and none.
    var stack: array<vec2<u32>, STACK_SIZE>;
    var height = 0u;
    // Height of the stack at which an instance ends.
    var base = NONE;
    var node = 0u;
    var mask = 0u;
    var next = params.root;
    loop {
        // Visit the next child
        if ((next & LEAF) == 0u) {
            let children = entered(next, local, hit.t);
            if (children != 0u) {
                if (mask != 0u) {
                    stack[height] = vec2<u32>(node, mask);
                    height += 1u;
                }
                node = next;
                mask = children;
            }
        } else {
            let kind = (next >> 29u) & 3u;
            let count = ((next >> FIRST_BITS) & 7u) + 1u;
            let first = next & FIRST_MASK;
            if (kind == LEAF_TRIANGLES) {
                if (visit_triangles(first, count, local, ray, instance, is_shadow, &hit)) {
                    hit.slot = first;
                    return hit;
                }
            } else if (kind == LEAF_QUADRIC) {
                if (visit_quadric(first, ray, instance, is_shadow, &hit)) {
                    hit.slot = IS_QUADRIC | first;
                    return hit;
                }
            } else {
                // Of several instances the others wait
                if (mask != 0u) {
                    stack[height] = vec2<u32>(node, mask);
                    height += 1u;
                    mask = 0u;
                }
                if (count > 1u) {
                    stack[height] = vec2<u32>(LEAF | (LEAF_INSTANCES << 29u) | ((count - 2u) << FIRST_BITS) | (first + 1u), 0u);
                    height += 1u;
                }
                base = height;
                instance = first;
                let at = params.instances + first * INSTANCE_WORDS;
                let last = tables[at + 6u];
                next = last.x;
                if (last.y == PLACE_MOVING) {
                    let transform = motion_at(tables[at].x, tables[at].y, ray.time);
                    local = local_ray(into_object(transform, vec4<f32>(ray.origin, 1.0)), into_object(transform, vec4<f32>(ray.direction, 0.0)));
                } else if (last.y == PLACE_DEFORMING) {
                    next = root_at(at, ray.time);
                } else if (last.y != PLACE_WORLD) {
                    local = local_ray(transformed(at + 3u, vec4<f32>(ray.origin, 1.0)), transformed(at + 3u, vec4<f32>(ray.direction, 0.0)));
                }
                continue;
            }
        }

        // Choose the child after it
        loop {
            if (mask != 0u) {
                let place = firstTrailingBit(mask);
                mask &= mask - 1u;
                next = child_of(node, place ^ local.negative);
                break;
            }
            if (height == base) {
                base = NONE;
                local = local_ray(ray.origin, ray.direction);
            }
            if (height == 0u) {
                return hit;
            }
            height -= 1u;
            let group = stack[height];
            if (group.y == 0u) {
                next = group.x;
                break;
            }
            node = group.x;
            mask = group.y;
        }
    }
    return hit;
}
