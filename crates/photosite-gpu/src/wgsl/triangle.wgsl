// Triangles against a ray; photosite-transport's geometry/triangle_block.rs and geometry/near_hit.rs (Woop, Benthin and
// Wald 2013).

/// A ray in the space of a hierarchy, as boxes and triangles meet it.
struct LocalRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
    /// 1/direction, of components away from 0.
    inverse: vec3<f32>,
    /// Bits of the axes along which it runs down.
    negative: u32,
    /// Axis along which it is longest, and the shear that turns it into +z.
    longest: u32,
    shear: vec3<f32>,
}

/// Components in the order of the two other axes and the longest.
fn along(v: vec3<f32>, longest: u32) -> vec3<f32> {
    return select(select(v.xyz, v.zxy, longest == 1u), v.yzx, longest == 0u);
}

fn local_ray(origin: vec3<f32>, direction: vec3<f32>) -> LocalRay {
    let size = abs(direction);
    let of_two = select(2u, 1u, size.y > size.z);
    let longest = select(of_two, 0u, size.x > size.y && size.x > size.z);
    let turned = along(direction, longest);
    let scale = 1.0 / turned.z;
    let tiny = vec3<f32>(with_sign(1e-20, direction.x), with_sign(1e-20, direction.y), with_sign(1e-20, direction.z));
    let inverse = 1.0 / select(direction, tiny, size < vec3<f32>(1e-20));
    let negative = select(0u, 1u, inverse.x < 0.0) | select(0u, 2u, inverse.y < 0.0) | select(0u, 4u, inverse.z < 0.0);
    return LocalRay(origin, direction, inverse, negative, longest, vec3<f32>(turned.xy * scale, scale));
}

/// A corner relative to the origin, sheared so that the ray runs along z.
fn sheared(corner: vec3<f32>, ray: LocalRay) -> vec3<f32> {
    let p = along(corner - ray.origin, ray.longest);
    return vec3<f32>(p.xy - ray.shear.xy * p.z, ray.shear.z * p.z);
}

/// Twice the signed area between the ray and an edge. Whichever way round the edge is given, the products are the same, so
/// that neighbours agree even where a compiler joins a product and a sum.
fn double_area(p: vec3<f32>, q: vec3<f32>) -> f32 {
    let is_turned = p.x < q.x || (p.x == q.x && p.y < q.y);
    let a = select(p, q, is_turned);
    let b = select(q, p, is_turned);
    let area = a.x * b.y - a.y * b.x;
    return select(area, -area, is_turned);
}

/// Bound on the rounding error of the distance times the sum of the areas; `error_of_sum`.
fn error_of_sum(size: vec3<f32>, e: f32, inverse_scale: f32) -> f32 {
    let before = size.z * inverse_scale;
    let dx = (size.x + before) * gamma(5.0);
    let dy = (size.y + before) * gamma(5.0);
    let dz = size.z * gamma(3.0);
    let de = (gamma(2.0) * size.x * size.y + dy * size.x + dx * size.y) * 2.0;
    return (gamma(3.0) * e * size.z + de * size.z + dz * e) * 3.0;
}

/// A hit that the sheared test cannot decide, by heights over the plane: distance and both weights; t ≤ 0 for none. In
/// single precision the processor's f64 becomes a wider bound: what is nearer to the plane than it does not count.
fn near_hit(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, ray: LocalRay) -> vec3<f32> {
    let from_a = ray.origin - a;
    let ab = b - a;
    let ac = c - a;
    let q = cross(from_a, ab);
    let height = dot(ac, q);
    let p = cross(ray.direction, ac);
    let fall = dot(ab, p);
    if (!(height * fall > 0.0)) {
        return vec3<f32>(-1.0);
    }
    let b1 = clamp(dot(from_a, p) / fall, 0.0, 1.0);
    let b2 = clamp(dot(ray.direction, q) / fall, 0.0, 1.0 - b1);
    let magnitude = abs(a) * (1.0 - b1 - b2) + abs(b) * b1 + abs(c) * b2;
    let known = dot(abs(cross(ab, ac)), magnitude + 8.0 * abs(from_a)) * ROUNDING;
    return select(vec3<f32>(-1.0), vec3<f32>(height / fall, b1, b2), abs(height) > known);
}

/// Where a ray meets a triangle, from either side: distance and the weights of the second and third corner; t ≤ 0 where it
/// does not.
fn meet_triangle(a_world: vec3<f32>, b_world: vec3<f32>, c_world: vec3<f32>, is_slender: bool, ray: LocalRay) -> vec3<f32> {
    let a = sheared(a_world, ray);
    let b = sheared(b_world, ray);
    let c = sheared(c_world, ray);
    let u = double_area(c, b);
    let v = double_area(a, c);
    let w = double_area(b, a);
    let sum = u + v + w;
    let is_outside = min(u, min(v, w)) < 0.0 && max(u, max(v, w)) > 0.0;
    if (is_outside || sum == 0.0) {
        return vec3<f32>(-1.0);
    }
    let t = (u * a.z + v * b.z + w * c.z) / sum;
    let size = max(max(abs(a), abs(b)), abs(c));
    let error = error_of_sum(size, max(abs(u), max(abs(v), abs(w))), 1.0 / abs(ray.shear.z)) / abs(sum);
    if (abs(t) <= error || is_slender) {
        return near_hit(a_world, b_world, c_world, ray);
    }
    return vec3<f32>(t, v / sum, w / sum);
}
