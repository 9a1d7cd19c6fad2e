// Mathematics that knows nothing of light; photosite-core's math/warp.rs, math/frame.rs, math/pdf.rs, math/float.rs, and
// photosite-transport's geometry/ray.rs.

const PI = 3.14159265358979f;
const TAU = 6.28318530717959f;
const FRAC_1_PI = 0.318309886183791f;
const FRAC_2_PI = 0.636619772367581f;
const MIN_POSITIVE = 1.17549435e-38f;
/// Largest number below 1.
const BELOW_ONE = 0.99999994f;
/// Half a unit in the last place of 1.
const ROUNDING = 5.9604645e-8f;
/// Distance that stands for no end.
const FAR = 1e30f;
const NONE = 0xffffffffu;

/// Bound on the relative error of n roundings.
fn gamma(n: f32) -> f32 {
    return n * ROUNDING / (1.0 - n * ROUNDING);
}

fn with_sign(magnitude: f32, sign: f32) -> f32 {
    return bitcast<f32>((bitcast<u32>(magnitude) & 0x7fffffffu) | (bitcast<u32>(sign) & 0x80000000u));
}

fn normalized_or(v: vec3<f32>, other: vec3<f32>) -> vec3<f32> {
    let size = length(v);
    return select(other, v / size, size > 0.0 && size < FAR);
}

/// A right-handed orthonormal frame.
struct Frame {
    x: vec3<f32>,
    y: vec3<f32>,
    z: vec3<f32>,
}

fn frame_from_normal(z: vec3<f32>) -> Frame {
    let sign = with_sign(1.0, z.z);
    let a = -1.0 / (sign + z.z);
    let b = z.x * z.y * a;
    return Frame(vec3<f32>(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x), vec3<f32>(b, sign + z.y * z.y * a, -z.y), z);
}

fn frame_from_normal_tangent(z: vec3<f32>, tangent: vec3<f32>) -> Frame {
    let y = normalized_or(cross(z, tangent), vec3<f32>(0.0));
    let x = normalized_or(cross(y, z), vec3<f32>(0.0));
    if (all(x == vec3<f32>(0.0))) {
        return frame_from_normal(z);
    }
    return Frame(x, cross(z, x), z);
}

fn to_local(frame: Frame, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(frame.x, v), dot(frame.y, v), dot(frame.z, v));
}

fn to_world(frame: Frame, v: vec3<f32>) -> vec3<f32> {
    return frame.x * v.x + frame.y * v.y + frame.z * v.z;
}

/// Sine and cosine of an angle of −π/4 to π/4.
fn sin_cos_of_eighth(x: f32) -> vec2<f32> {
    let x2 = x * x;
    let sine = x + x * x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 * (1.0 / 362880.0))));
    let cosine = 1.0
        + x2 * (-0.5 + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0 - x2 * (1.0 / 3628800.0)))));
    return vec2<f32>(sine, cosine);
}

/// Sine and cosine of 2π·u for u in 0–1.
fn sin_cos_turn(u: f32) -> vec2<f32> {
    let quarter = u32(4.0 * u + 0.5);
    let x = (u - 0.25 * f32(quarter)) * TAU;
    var both = sin_cos_of_eighth(x);
    both = select(vec2<f32>(both.y, -both.x), both, (quarter & 1u) == 0u);
    return select(-both, both, (quarter & 2u) == 0u);
}

/// Angle of a cosine, to 2e-7: the function of WGSL may be off by a thousand times that (Abramowitz and Stegun 4.4.46).
fn arc_cosine(x: f32) -> f32 {
    let y = abs(x);
    let low = 1.5707963050 + y * (-0.2145988016 + y * (0.0889789874 + y * -0.0501743046));
    let high = 0.0308918810 + y * (-0.0170881256 + y * (0.0066700901 + y * -0.0012624911));
    let y2 = y * y;
    let angle = sqrt(max(1.0 - y, 0.0)) * (low + high * y2 * y2);
    return select(angle, PI - angle, x < 0.0);
}

/// Angle of a vector (x, y) from +x, to 2e-7; as above (4.4.49).
fn arc_tangent(y: f32, x: f32) -> f32 {
    let larger = max(abs(x), abs(y));
    let t = min(abs(x), abs(y)) / max(larger, MIN_POSITIVE);
    let s = t * t;
    let high = 0.1065626393 + s * (-0.0752896400 + s * (0.0429096138 + s * (-0.0161657367 + s * 0.0028662257)));
    var angle = t * (1.0 + s * (-0.3333314528 + s * (0.1999355085 + s * (-0.1420889944 + s * high))));
    angle = select(angle, 0.5 * PI - angle, abs(y) > abs(x));
    angle = select(angle, PI - angle, x < 0.0);
    return with_sign(angle, y);
}

fn concentric_disk(u: vec2<f32>) -> vec2<f32> {
    let p = 2.0 * u - 1.0;
    let is_x = abs(p.y) < abs(p.x);
    let larger = select(p.y, p.x, is_x);
    let smaller = select(p.x, p.y, is_x);
    let angle = 0.785398163397448 * (smaller / select(larger, 1.0, larger == 0.0));
    let both = larger * sin_cos_of_eighth(angle);
    return select(both.xy, both.yx, is_x);
}

/// A vector turned by a unit quaternion, whose real part is last.
fn rotated(quaternion: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let b = quaternion.xyz;
    let w = quaternion.w;
    return v * (w * w - dot(b, b)) + b * (2.0 * dot(v, b)) + cross(b, v) * (2.0 * w);
}

/// The quaternion of the rotation back.
fn conjugate(quaternion: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(-quaternion.xyz, quaternion.w);
}

fn cosine_hemisphere(u: vec2<f32>) -> vec3<f32> {
    let p = concentric_disk(u);
    return vec3<f32>(p, sqrt(max(1.0 - dot(p, p), 0.0)));
}

fn uniform_cone(u: vec2<f32>, cos_max: f32) -> vec3<f32> {
    let z = (1.0 - u.x) + u.x * cos_max;
    let radius = sqrt(max(1.0 - z * z, 0.0));
    let turn = sin_cos_turn(u.y);
    return vec3<f32>(radius * turn.y, radius * turn.x, z);
}

/// Weights of the second and the third corner.
fn uniform_triangle(u: vec2<f32>) -> vec2<f32> {
    let is_below = u.x < u.y;
    let half = 0.5 * select(u.y, u.x, is_below);
    let rest = select(u.x, u.y, is_below) - half;
    return select(vec2<f32>(rest, half), vec2<f32>(half, rest), is_below);
}

fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = other / own;
    return select(0.0, 1.0 / (1.0 + ratio * ratio), own > 0.0);
}

fn to_solid_angle(area_density: f32, distance_squared: f32, cos_surface: f32) -> f32 {
    return select(0.0, area_density * distance_squared / cos_surface, cos_surface > 0.0);
}

/// Remainder of a random number after a choice.
fn rest_of(u: f32, start: f32, length: f32) -> f32 {
    return clamp((u - start) / length, 0.0, BELOW_ONE);
}

/// A ray origin off the surface at `p`, on the side that `direction` points to; `offset_origin`.
fn offset_origin(p: vec3<f32>, error: vec3<f32>, normal: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let distance = dot(abs(normal), error + abs(p) * (2.0 * ROUNDING)) * (1.0 + 4.0 * ROUNDING);
    return p + normal * with_sign(distance, dot(direction, normal));
}
