// From a surface point to the frame and the BSDF that light scatters by; photosite-transport's scene/shading.rs.

struct Shading {
    frame: Frame,
    bsdf: Bsdf,
}

const MIN_SHADING_COSINE = 1e-3f;

/// A colour at a surface point.
fn colour_at(source: vec4<u32>, factor: vec3<f32>, point: SurfacePoint, lambda_nm: vec4<f32>) -> vec4<f32> {
    if (source.x == COLOUR_SPECTRUM) {
        return spectrum(source.y, lambda_nm);
    }
    let texel = texture_at(source.z, point.primitive, point.mesh, point.parameters);
    if (source.x == COLOUR_TEXTURE) {
        return polynomial(reflectance_of(factor * texel), lambda_nm);
    }
    return spectrum(source.y, lambda_nm) * polynomial(reflectance_of(texel), lambda_nm);
}

/// The material of a point: of a mix one of both, by a number of the point's own.
fn chosen_material(point: SurfacePoint) -> u32 {
    var material = point.material;
    // Mixes within mixes are as deep as captures nest them.
    for (var depth = 0u; depth < 64u; depth += 1u) {
        let at = params.materials + material * MATERIAL_WORDS;
        if (tables[at].x != MODEL_MIX) {
            break;
        }
        let mix_words = tables[at + 1u];
        let uv = bitcast<vec2<u32>>(point.parameters);
        let key = hash64(vec2<u32>(uv.y, uv.x), vec2<u32>(number_in_order(point.primitive, point.mesh), 0u));
        let own = hash64(key, vec2<u32>(mix_words.z, 0u));
        material = select(mix_words.x, mix_words.y, unit_f32(own.x) < bitcast<f32>(mix_words.z));
    }
    return material;
}

/// A number times a channel of a linear texture.
fn factor_at(value: f32, texture: u32, channel: u32, point: SurfacePoint) -> f32 {
    if (texture == NONE) {
        return value;
    }
    return value * linear_texture_at(texture, point)[channel];
}

/// A colour times that of the vertices; `base_colour`.
fn base_colour_at(source: vec4<u32>, factor: vec3<f32>, point: SurfacePoint, lambda_nm: vec4<f32>) -> vec4<f32> {
    let start = tables[params.meshes + point.mesh * MESH_WORDS + 2u].x;
    if (start == NONE || (point.primitive & IS_QUADRIC) != 0u) {
        return colour_at(source, factor, point, lambda_nm);
    }
    let corners = corners_of(point.primitive) - vec3<u32>(start);
    let vertex = weighted(attribute3(params.vertex_colours, corners.x, 4u), attribute3(params.vertex_colours, corners.y, 4u), attribute3(params.vertex_colours, corners.z, 4u), point.parameters);
    if (source.x == COLOUR_TEXTURE) {
        return colour_at(source, factor * vertex, point, lambda_nm);
    }
    return colour_at(source, factor, point, lambda_nm) * polynomial(reflectance_of(vertex), lambda_nm);
}

/// Words of a material's normal map and of what absorbs behind it.
fn normal_map_of(point: SurfacePoint) -> vec4<u32> {
    return tables[params.materials + point.material * MATERIAL_WORDS + MATERIAL_WORDS - 1u];
}

/// The shading frame with a normal map applied, if there is one; `mapped_frame`.
fn mapped_frame(map: vec4<u32>, point: SurfacePoint, wo: vec3<f32>, is_two_sided: bool) -> Frame {
    var normal = point.shading_normal;
    var geometric = point.geometric_normal;
    if (map.x != NONE) {
        let bump = 2.0 * linear_texture_at(map.x, point).xyz - 1.0;
        let scale = bitcast<f32>(map.y);
        let base = frame_from_normal_tangent(normal, point.tangent);
        let bumped = base.x * (bump.x * scale) + base.y * point.handedness * (bump.y * scale) + normal * bump.z;
        normal = normalized_or(bumped, normal);
    }
    if (is_two_sided) {
        if (dot(wo, geometric) < 0.0) {
            normal = -normal;
            geometric = -geometric;
        }
        let cosine = dot(wo, normal);
        if (cosine < MIN_SHADING_COSINE) {
            normal = normalized_or(normal + wo * (MIN_SHADING_COSINE - cosine), geometric);
        }
    }
    if (all(point.tangent == vec3<f32>(0.0))) {
        return frame_from_normal(normal);
    }
    return frame_from_normal_tangent(normal, point.tangent);
}

fn shading_at(point: SurfacePoint, wo: vec3<f32>, lambda_nm: vec4<f32>) -> Shading {
    let at = params.materials + chosen_material(point) * MATERIAL_WORDS;
    let head = tables[at];
    let source = tables[at + 1u];
    let factor = bitcast<vec3<f32>>(tables[at + 2u].xyz);
    let second_source = tables[at + 3u];
    let second_factor = bitcast<vec3<f32>>(tables[at + 4u].xyz);
    var bsdf = Bsdf(head.x, bitcast<vec2<f32>>(head.yz), vec4<f32>(0.0), vec4<f32>(0.0), false, head.w != 0u, false, vec2<f32>(0.0));
    switch head.x {
        case MODEL_CONDUCTOR: {
            bsdf.first = spectrum(source.y, lambda_nm);
            bsdf.second = spectrum(second_source.y, lambda_nm);
        }
        case MODEL_DIELECTRIC: {
            bsdf.first = spectrum(source.x, lambda_nm);
            bsdf.is_dispersive = source.y != 0u;
            bsdf.has_index_one = source.z != 0u;
        }
        case MODEL_THIN_DIELECTRIC: {
            bsdf.first = spectrum(source.x, lambda_nm);
            bsdf.second = spectrum(second_source.y, lambda_nm);
        }
        case MODEL_OREN_NAYAR: {
            bsdf.first = colour_at(source, factor, point, lambda_nm);
            bsdf.roughness.x = bitcast<f32>(second_source.x);
        }
        case MODEL_RETROREFLECTIVE: {
            bsdf.first = colour_at(source, factor, point, lambda_nm);
            bsdf.second = colour_at(second_source, second_factor, point, lambda_nm);
            bsdf.corners = bitcast<vec2<f32>>(tables[at + 5u].xy);
        }
        case MODEL_PHONG, MODEL_TRANSLUCENT: {
            bsdf.first = colour_at(source, factor, point, lambda_nm);
            bsdf.second = colour_at(second_source, second_factor, point, lambda_nm);
        }
        case MODEL_LAYERED: {
            if (HAS_LAYERED) {
                return layered_shading(at, point, wo, lambda_nm);
            }
        }
        default: {
            bsdf.first = colour_at(source, factor, point, lambda_nm);
        }
    }
    return Shading(mapped_frame(normal_map_of(point), point, wo, !refracts(bsdf)), bsdf);
}

/// Whether light would leak through an opaque surface whose shading normal disagrees with the geometric one.
fn leaks(point: SurfacePoint, bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>, is_transmission: bool) -> bool {
    let crosses = dot(wo, point.geometric_normal) * dot(wi, point.geometric_normal) < 0.0;
    return crosses != is_transmission && !transmits(bsdf);
}
