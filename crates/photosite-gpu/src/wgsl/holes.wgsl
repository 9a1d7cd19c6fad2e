// Holes by alpha; `Scene::presence` and `Holes` of photosite-transport's scene/mod.rs.

/// Probability with which there is a surface at a place on a primitive of a mesh.
fn presence(primitive: u32, mesh: u32, parameters: vec2<f32>) -> f32 {
    let material = tables[params.meshes + mesh * MESH_WORDS].x;
    let alpha = tables[params.materials + material * MATERIAL_WORDS + MATERIAL_WORDS - 4u];
    if (alpha.x == ALPHA_OPAQUE) {
        return 1.0;
    }
    var coverage = bitcast<f32>(alpha.y);
    let start = tables[params.meshes + mesh * MESH_WORDS + 2u].x;
    if (start != NONE && (primitive & IS_QUADRIC) == 0u) {
        let at = vec3<u32>(params.vertex_colours) + 4u * (corners_of(primitive) - vec3<u32>(start)) + 3u;
        let of_corners = bitcast<vec3<f32>>(vec3<u32>(attributes[at.x], attributes[at.y], attributes[at.z]));
        coverage *= of_corners.x * (1.0 - parameters.x - parameters.y) + of_corners.y * parameters.x + of_corners.z * parameters.y;
    }
    if (alpha.z != NONE) {
        coverage *= texture_linear(alpha.z, uv_of(primitive, mesh, parameters, texture_set(alpha.z))).w;
    }
    return select(coverage, select(0.0, 1.0, coverage >= bitcast<f32>(alpha.w)), alpha.x == ALPHA_MASK);
}

/// Whether a primitive is there where a ray meets it. With probability alpha it is, by a number of the ray's own.
fn is_there(primitive: u32, mesh: u32, parameters: vec2<f32>, ray: Ray) -> bool {
    if (params.has_holes == 0u) {
        return true;
    }
    let probability = presence(primitive, mesh, parameters);
    if (probability <= 0.0 || probability >= 1.0) {
        return probability > 0.0;
    }
    let direction = bitcast<vec3<u32>>(ray.direction);
    let number = vec2<u32>(number_in_order(primitive, mesh), direction.z);
    let key = hash64(hash64(direction.yx, number), bitcast<vec2<u32>>(ray.origin.zx));
    return unit_f32(key.x) < probability;
}
