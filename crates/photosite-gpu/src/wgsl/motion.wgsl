// Motions of instances and of lights; photosite-transport's geometry/motion.rs. Poses are found in single precision.

/// A transform with its inverse, row by row.
struct Transform {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    x_object: vec4<f32>,
    y_object: vec4<f32>,
    z_object: vec4<f32>,
}

/// Index of the part that a time falls into, of equal parts of the time from 0 to 1, and the position in it, 0–1.
struct Segment {
    index: u32,
    part: f32,
}

fn segment(time: f32, count: u32) -> Segment {
    let along = time * f32(count);
    let index = min(u32(along), count - 1u);
    return Segment(index, along - f32(index));
}

/// The transform at a time of a motion of so many segments, whose keys begin at a place; `Motion::at`.
fn motion_at(place: u32, segments: u32, time: f32) -> Transform {
    let now = segment(time, segments);
    let at = params.motions + place + now.index * KEY_WORDS;
    let first = bitcast<vec4<f32>>(tables[at]);
    let across = bitcast<vec4<f32>>(tables[at + 1u]);
    let moved = bitcast<vec4<f32>>(tables[at + 2u]);
    let next_moved = bitcast<vec4<f32>>(tables[at + KEY_WORDS + 2u]);
    let translation = mix(moved.xyz, next_moved.xyz, now.part);
    let turn = sin_cos_turn(moved.w * now.part);
    return pose(first * turn.y + across * turn.x, translation, stretch_between(at, now.part));
}

/// A stretch, which is symmetric: its rows, and those of its inverse.
struct Stretch {
    x: vec3<f32>,
    y: vec3<f32>,
    z: vec3<f32>,
    x_inverse: vec3<f32>,
    y_inverse: vec3<f32>,
    z_inverse: vec3<f32>,
}

/// The stretch after a part of the way from a key to the next.
fn stretch_between(at: u32, part: f32) -> Stretch {
    let next = at + KEY_WORDS;
    let diagonal = mix(bitcast<vec3<f32>>(tables[at + 3u].xyz), bitcast<vec3<f32>>(tables[next + 3u].xyz), part);
    let rest = mix(bitcast<vec3<f32>>(tables[at + 4u].xyz), bitcast<vec3<f32>>(tables[next + 4u].xyz), part);
    // Of sizes about 1 products of three are numbers, too.
    let size = max(abs(diagonal.x), max(abs(diagonal.y), abs(diagonal.z)));
    let x = vec3<f32>(diagonal.x, rest.z, rest.y) / size;
    let y = vec3<f32>(rest.z, diagonal.y, rest.x) / size;
    let z = vec3<f32>(rest.y, rest.x, diagonal.z) / size;
    let yz = cross(y, z);
    let scale = size * dot(x, yz);
    return Stretch(x * size, y * size, z * size, yz / scale, cross(z, x) / scale, cross(x, y) / scale);
}

/// The transform R·S and a translation, with R of a quaternion that is a unit one but for rounding.
fn pose(q: vec4<f32>, translation: vec3<f32>, s: Stretch) -> Transform {
    let twice = q * (2.0 / dot(q, q));
    let xx = q.x * twice.x;
    let yy = q.y * twice.y;
    let zz = q.z * twice.z;
    let xy = q.x * twice.y;
    let xz = q.x * twice.z;
    let yz = q.y * twice.z;
    let wx = q.w * twice.x;
    let wy = q.w * twice.y;
    let wz = q.w * twice.z;
    let x = vec3<f32>(1.0 - (yy + zz), xy - wz, xz + wy);
    let y = vec3<f32>(xy + wz, 1.0 - (xx + zz), yz - wx);
    let z = vec3<f32>(xz - wy, yz + wx, 1.0 - (xx + yy));
    return Transform(
        vec4<f32>(s.x * x.x + s.y * x.y + s.z * x.z, translation.x),
        vec4<f32>(s.x * y.x + s.y * y.y + s.z * y.z, translation.y),
        vec4<f32>(s.x * z.x + s.y * z.y + s.z * z.z, translation.z),
        inverse_row(s.x_inverse, x, y, z, translation),
        inverse_row(s.y_inverse, x, y, z, translation),
        inverse_row(s.z_inverse, x, y, z, translation),
    );
}

/// A row of S⁻¹·R⁻¹ and of what it makes of the translation, from a row of S⁻¹ and the rows of R.
fn inverse_row(row: vec3<f32>, x: vec3<f32>, y: vec3<f32>, z: vec3<f32>, translation: vec3<f32>) -> vec4<f32> {
    let turned = vec3<f32>(dot(row, x), dot(row, y), dot(row, z));
    return vec4<f32>(turned, -dot(turned, translation));
}

/// Takes a point of the world, whose fourth number is 1, or a direction, whose is 0, into the space of the object.
fn into_object(transform: Transform, p: vec4<f32>) -> vec3<f32> {
    return vec3<f32>(dot(transform.x_object, p), dot(transform.y_object, p), dot(transform.z_object, p));
}

/// Takes a point of the space of the object, or a direction, into the world.
fn into_world(transform: Transform, p: vec4<f32>) -> vec3<f32> {
    return vec3<f32>(dot(transform.x, p), dot(transform.y, p), dot(transform.z, p));
}

/// The transform at a time of the instance whose words begin there, which is not in world space;
/// `InstanceTransform::at`.
fn transform_at(instance: u32, time: f32) -> Transform {
    if (tables[instance + 6u].y == PLACE_MOVING) {
        return motion_at(tables[instance].x, tables[instance].y, time);
    }
    return Transform(
        bitcast<vec4<f32>>(tables[instance]),
        bitcast<vec4<f32>>(tables[instance + 1u]),
        bitcast<vec4<f32>>(tables[instance + 2u]),
        bitcast<vec4<f32>>(tables[instance + 3u]),
        bitcast<vec4<f32>>(tables[instance + 4u]),
        bitcast<vec4<f32>>(tables[instance + 5u]),
    );
}
