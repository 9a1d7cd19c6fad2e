// The point of a surface that a ray meets; photosite-transport's geometry/point.rs.

struct SurfacePoint {
    position: vec3<f32>,
    /// Bound on the rounding error of the position.
    error: vec3<f32>,
    geometric_normal: vec3<f32>,
    shading_normal: vec3<f32>,
    /// Zero where the mesh has none.
    tangent: vec3<f32>,
    /// ±1: bitangent = handedness · normal × tangent.
    handedness: f32,
    /// Place on the primitive.
    parameters: vec2<f32>,
    /// Index of the triangle, or [`IS_QUADRIC`] and that of the quadric.
    primitive: u32,
    instance: u32,
    mesh: u32,
    material: u32,
    /// Time from 0 to 1.
    time: f32,
}

/// Roundings of a transform, and of its inverse; of one that is found in single precision on the way, too.
const ROUNDINGS = 4.0f;
const ROUNDINGS_OF_MOTION = 32.0f;

fn weighted(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, uv: vec2<f32>) -> vec3<f32> {
    return a * (1.0 - uv.x - uv.y) + b * uv.x + c * uv.y;
}

fn attribute2(section: u32, index: u32) -> vec2<f32> {
    let at = section + 2u * index;
    return bitcast<vec2<f32>>(vec2<u32>(attributes[at], attributes[at + 1u]));
}

fn attribute3(section: u32, index: u32, stride: u32) -> vec3<f32> {
    let at = section + stride * index;
    return bitcast<vec3<f32>>(vec3<u32>(attributes[at], attributes[at + 1u], attributes[at + 2u]));
}

/// Indices of the corners of a triangle.
fn corners_of(triangle: u32) -> vec3<u32> {
    let at = params.corners + 3u * triangle;
    return vec3<u32>(attributes[at], attributes[at + 1u], attributes[at + 2u]);
}

/// Shading normal of three vertices, not of unit length.
fn normal_of(vertices: vec3<u32>, uv: vec2<f32>) -> vec3<f32> {
    return weighted(attribute3(params.normals, vertices.x, 3u), attribute3(params.normals, vertices.y, 3u), attribute3(params.normals, vertices.z, 3u), uv);
}

/// Shading normal, not of unit length, of corners of a mesh that changes its shape.
fn changing_normal(corners: vec3<u32>, mesh: u32, uv: vec2<f32>, time: f32) -> vec3<f32> {
    let words = tables[params.meshes + mesh * MESH_WORDS + 2u];
    let now = segment(time, words.w);
    let vertices = corners - vec3<u32>(words.y) + vec3<u32>(now.index * words.z);
    return normal_of(vertices, uv) * (1.0 - now.part) + normal_of(vertices + vec3<u32>(words.z), uv) * now.part;
}

fn surface_point(hit: Hit, time: f32) -> SurfacePoint {
    if ((hit.slot & IS_QUADRIC) != 0u) {
        return point_of_quadric(hit, time);
    }
    let at = hit.slot * TRIANGLE_WORDS;
    let a_word = triangles[at];
    let c_word = triangles[at + 2u];
    let b_word = triangles[at + 1u];
    let is_deforming = b_word.w > 1u;
    var corners = Corners(bitcast<vec3<f32>>(a_word.xyz), bitcast<vec3<f32>>(b_word.xyz), bitcast<vec3<f32>>(c_word.xyz));
    if (is_deforming) {
        corners = corners_at(hit.slot, b_word.w >> 1u, time);
    }
    let a = corners.a;
    let b = corners.b;
    let c = corners.c;
    let triangle = a_word.w;
    let mesh = c_word.w;
    let mesh_words = tables[params.meshes + mesh * MESH_WORDS];
    let attribute_words = tables[params.meshes + mesh * MESH_WORDS + 1u];
    let uv = hit.uv;
    var position = weighted(a, b, c, uv);
    var error = (abs(a) * abs(1.0 - uv.x - uv.y) + abs(b) * uv.x + abs(c) * uv.y) * gamma(select(7.0, 10.0, is_deforming));
    var normal = cross(b - a, c - a);
    var shading = vec3<f32>(0.0);
    var tangent = vec3<f32>(0.0);
    var handedness = 1.0;
    if (attribute_words.x != NONE) {
        if (is_deforming) {
            shading = changing_normal(corners_of(triangle), mesh, uv, time);
        } else {
            shading = normal_of(corners_of(triangle) - vec3<u32>(attribute_words.x), uv);
        }
    }
    if (attribute_words.y != NONE) {
        let corners = corners_of(triangle) - vec3<u32>(attribute_words.y);
        tangent = weighted(attribute3(params.tangents, corners.x, 4u), attribute3(params.tangents, corners.y, 4u), attribute3(params.tangents, corners.z, 4u), uv);
        let hands = bitcast<vec3<f32>>(vec3<u32>(attributes[params.tangents + 4u * corners.x + 3u], attributes[params.tangents + 4u * corners.y + 3u], attributes[params.tangents + 4u * corners.z + 3u]));
        handedness = with_sign(1.0, hands.x * (1.0 - uv.x - uv.y) + hands.y * uv.x + hands.z * uv.y);
    }

    let instance = params.instances + hit.instance * INSTANCE_WORDS;
    let place = tables[instance + 6u].y;
    if (place != PLACE_WORLD && place != PLACE_DEFORMING) {
        let transform = transform_at(instance, time);
        let x = transform.x;
        let y = transform.y;
        let z = transform.z;
        let x_object = transform.x_object;
        let y_object = transform.y_object;
        let z_object = transform.z_object;
        let roundings = gamma(select(ROUNDINGS, ROUNDINGS_OF_MOTION, place == PLACE_MOVING));
        let local = position;
        position = into_world(transform, vec4<f32>(local, 1.0));
        // The error of the local point carried over, that of this transform, and that of taking the origin of the next ray
        // back into object space.
        let size = vec4<f32>(abs(local), 1.0);
        let forward = vec3<f32>(dot(abs(x), size), dot(abs(y), size), dot(abs(z), size)) * roundings;
        let world_size = vec4<f32>(abs(position), 1.0);
        let back = vec3<f32>(dot(abs(x_object), world_size), dot(abs(y_object), world_size), dot(abs(z_object), world_size)) * roundings;
        let carried = error + back;
        error = vec3<f32>(dot(abs(x.xyz), carried), dot(abs(y.xyz), carried), dot(abs(z.xyz), carried)) + forward;
        normal = x_object.xyz * normal.x + y_object.xyz * normal.y + z_object.xyz * normal.z;
        shading = x_object.xyz * shading.x + y_object.xyz * shading.y + z_object.xyz * shading.z;
        tangent = vec3<f32>(dot(x.xyz, tangent), dot(y.xyz, tangent), dot(z.xyz, tangent));
        handedness *= with_sign(1.0, dot(x.xyz, cross(y.xyz, z.xyz)));
    }
    let geometric = normalized_or(normal, vec3<f32>(0.0));
    let shading_normal = normalized_or(shading, geometric);
    return SurfacePoint(position, error, geometric, shading_normal, tangent, handedness, uv, triangle, hit.instance, mesh, mesh_words.x, time);
}

fn point_of_quadric(hit: Hit, time: f32) -> SurfacePoint {
    let quadric = load_quadric(hit.slot & ~IS_QUADRIC);
    let point = quadric_point(quadric, hit.uv);
    let material = tables[params.meshes + quadric.mesh * MESH_WORDS].x;
    let has_tangent = tables[params.meshes + quadric.mesh * MESH_WORDS + 1u].y != NONE;
    let tangent = select(vec3<f32>(0.0), point.tangent, has_tangent);
    return SurfacePoint(point.position, point.error, point.normal, point.normal, tangent, 1.0, hit.uv, hit.slot, hit.instance, quadric.mesh, material, time);
}

/// Texture coordinates of a set at a place on a primitive of a mesh.
fn uv_of(primitive: u32, mesh: u32, parameters: vec2<f32>, uv_set: u32) -> vec2<f32> {
    if ((primitive & IS_QUADRIC) != 0u) {
        return quadric_uv(load_quadric(primitive & ~IS_QUADRIC), parameters);
    }
    let start = tables[params.meshes + mesh * MESH_WORDS + 1u][2u + uv_set];
    if (start == NONE) {
        return vec2<f32>(0.0);
    }
    let section = select(params.uvs_of_second, params.uvs_of_first, uv_set == 0u);
    let corners = corners_of(primitive) - vec3<u32>(start);
    let a = attribute2(section, corners.x);
    let b = attribute2(section, corners.y);
    let c = attribute2(section, corners.z);
    return a * (1.0 - parameters.x - parameters.y) + b * parameters.x + c * parameters.y;
}

/// The number of a primitive in the order in which meshes were added.
fn number_in_order(primitive: u32, mesh: u32) -> u32 {
    let words = tables[params.meshes + mesh * MESH_WORDS];
    return words.w + select(primitive - words.z, 0u, (primitive & IS_QUADRIC) != 0u);
}

/// Handle of the light that a surface point belongs to; [`NONE`] for none.
fn light_of(point: SurfacePoint) -> u32 {
    let mesh = tables[params.meshes + point.mesh * MESH_WORDS];
    let of_mesh = select(point.primitive - mesh.z, 0u, (point.primitive & IS_QUADRIC) != 0u);
    return select(mesh.y + of_mesh, NONE, mesh.y == NONE);
}

/// Linear RGB of a texture at a surface point.
fn texture_at(texture: u32, primitive: u32, mesh: u32, parameters: vec2<f32>) -> vec3<f32> {
    return texture_srgb(texture, uv_of(primitive, mesh, parameters, texture_set(texture)));
}

/// RGBA of a texture at a surface point, as it is stored.
fn linear_texture_at(texture: u32, point: SurfacePoint) -> vec4<f32> {
    return texture_linear(texture, uv_of(point.primitive, point.mesh, point.parameters, texture_set(texture)));
}

/// The ray that leaves a point in a direction.
fn spawn_ray(point: SurfacePoint, direction: vec3<f32>) -> Ray {
    let origin = offset_origin(point.position, point.error, point.geometric_normal, direction);
    // Quadrics are curved: a ray that leaves one may meet it again.
    let leaves = select(point.primitive, NONE, (point.primitive & IS_QUADRIC) != 0u);
    return Ray(origin, FAR, direction, leaves, point.instance, NONE, point.time);
}
