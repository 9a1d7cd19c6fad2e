// Quadrics in world space; photosite-transport's geometry/quadric.

struct Quadric {
    /// Centre, or middle of the axis.
    place: vec3<f32>,
    radius: f32,
    x: vec3<f32>,
    half_length: f32,
    y: vec3<f32>,
    /// Normal of a disk, or axis of a cylinder.
    z: vec3<f32>,
    kind: u32,
    mesh: u32,
}

const SPHERE = 0u;
const DISK = 1u;
const CYLINDER = 2u;

fn load_quadric(index: u32) -> Quadric {
    let at = params.quadrics + index * QUADRIC_WORDS;
    let place = bitcast<vec4<f32>>(tables[at]);
    let x = bitcast<vec4<f32>>(tables[at + 1u]);
    let y = bitcast<vec3<f32>>(tables[at + 2u].xyz);
    let z = bitcast<vec3<f32>>(tables[at + 3u].xyz);
    let last = tables[at + 4u];
    return Quadric(place.xyz, place.w, x.xyz, x.w, y, z, last.x, last.y);
}

/// The two t at which a line comes through a round quadric, from the squares of the directions across; −1 for none.
fn both_sides(f: vec3<f32>, d: vec3<f32>, radius: f32) -> vec2<f32> {
    let a = dot(d, d);
    let b = -dot(f, d);
    let nearest = f + d * (b / a);
    let discriminant = radius * radius - dot(nearest, nearest);
    if (!(discriminant >= 0.0)) {
        return vec2<f32>(-1.0);
    }
    let q = b + with_sign(sqrt(a * discriminant), b);
    let t0 = (dot(f, f) - radius * radius) / q;
    let t1 = q / a;
    return vec2<f32>(min(t0, t1), max(t0, t1));
}

/// The two t at which a line meets a quadric; −1 where it does not.
fn meet_quadric(q: Quadric, origin: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    if (q.kind == DISK) {
        let to_centre = q.place - origin;
        let t = dot(to_centre, q.z) / dot(direction, q.z);
        let from_centre = direction * t - to_centre;
        let is_inside = dot(from_centre, from_centre) <= q.radius * q.radius;
        return vec2<f32>(select(-1.0, t, is_inside), -1.0);
    }
    let f = origin - q.place;
    if (q.kind == SPHERE) {
        return both_sides(f, direction, q.radius);
    }
    let f_along = dot(f, q.z);
    let d_along = dot(direction, q.z);
    let sides = both_sides(f - q.z * f_along, direction - q.z * d_along, q.radius);
    let is_within = abs(f_along + d_along * sides) <= vec2<f32>(q.half_length);
    return select(vec2<f32>(-1.0), sides, is_within);
}

fn sphere_normal(uv: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - abs(uv.x) - abs(uv.y);
    let beyond = max(-z, 0.0);
    return normalize(vec3<f32>(uv.x - with_sign(beyond, uv.x), uv.y - with_sign(beyond, uv.y), z));
}

fn sphere_parameters(from_centre: vec3<f32>) -> vec2<f32> {
    let size = abs(from_centre);
    let p = from_centre / (size.x + size.y + size.z);
    let folded = vec2<f32>(with_sign(1.0 - abs(p.y), p.x), with_sign(1.0 - abs(p.x), p.y));
    return select(p.xy, folded, p.z < 0.0);
}

fn cylinder_parameter(across: vec2<f32>) -> f32 {
    return with_sign(1.0 - across.x / (abs(across.x) + abs(across.y)), across.y);
}

/// Cosine and sine of a direction around the axis of a cylinder.
fn cylinder_direction(u: f32) -> vec2<f32> {
    let cosine = 1.0 - abs(u);
    return normalize(vec2<f32>(cosine, with_sign(1.0 - abs(cosine), u)));
}

/// Parameters of a point on a quadric, or near it.
fn quadric_parameters(q: Quadric, point: vec3<f32>) -> vec2<f32> {
    let from_place = point - q.place;
    if (q.kind == SPHERE) {
        return sphere_parameters(from_place);
    }
    if (q.kind == DISK) {
        return vec2<f32>(dot(from_place, q.x), dot(from_place, q.y)) / (q.radius * q.radius);
    }
    let across = vec2<f32>(dot(from_place, q.x), dot(from_place, q.y));
    return vec2<f32>(cylinder_parameter(across), dot(from_place, q.z) / q.half_length);
}

struct QuadricPoint {
    position: vec3<f32>,
    error: vec3<f32>,
    normal: vec3<f32>,
    tangent: vec3<f32>,
}

/// The point with these parameters.
fn quadric_point(q: Quadric, uv: vec2<f32>) -> QuadricPoint {
    if (q.kind == SPHERE) {
        let normal = sphere_normal(uv);
        let error = (abs(q.place) + q.radius) * gamma(3.0) + q.radius * gamma(12.0);
        return QuadricPoint(q.place + normal * q.radius, error, normal, vec3<f32>(normal.z, 0.0, -normal.x));
    }
    if (q.kind == DISK) {
        let error = (abs(q.place) + q.radius) * gamma(3.0) + q.radius * gamma(12.0);
        let tangent = select(q.y * uv.x - q.x * uv.y, q.x, all(uv == vec2<f32>(0.0)));
        return QuadricPoint(q.place + (q.x * uv.x + q.y * uv.y), error, q.z, tangent);
    }
    let turn = cylinder_direction(uv.x);
    let normal = normalize(q.x * turn.x + q.y * turn.y);
    let size = q.radius + q.half_length;
    let error = (abs(q.place) + size) * gamma(3.0) + size * gamma(16.0);
    let position = q.place + (q.z * (uv.y * q.half_length) + normal * q.radius);
    return QuadricPoint(position, error, normal, q.y * turn.x - q.x * turn.y);
}

/// Texture coordinates of the point with these parameters.
fn quadric_uv(q: Quadric, uv: vec2<f32>) -> vec2<f32> {
    if (q.kind == SPHERE) {
        let normal = sphere_normal(uv);
        return vec2<f32>(0.5 + atan2(normal.x, normal.z) / TAU, acos(clamp(normal.y, -1.0, 1.0)) * FRAC_1_PI);
    }
    if (q.kind == DISK) {
        return vec2<f32>(0.5 + atan2(uv.y, uv.x) / TAU, length(uv));
    }
    let turn = cylinder_direction(uv.x);
    return vec2<f32>(0.5 + atan2(turn.y, turn.x) / TAU, 0.5 - 0.5 * uv.y);
}
