// From a surface point to the layers of glTF's material and their frame; `Scene::layers` of photosite-transport's
// scene/shading.rs.

/// A number times a channel of a texture, of the words of a layer.
fn layer_factor(words: vec4<u32>, point: SurfacePoint) -> f32 {
    return factor_at(bitcast<f32>(words.x), words.y, words.z, point);
}

/// Roughness along x and y, both none where the surface is smooth; `Ggx::new`.
fn roughness_of(alpha_x: f32, alpha_y: f32) -> vec2<f32> {
    let alpha = max(vec2<f32>(alpha_x, alpha_y), vec2<f32>(SMALLEST_ALPHA));
    return select(vec2<f32>(0.0), alpha, max(alpha_x, alpha_y) >= SMALLEST_ALPHA);
}

/// Roughness α of a perceptual roughness that a texture may scale.
fn layer_alpha(words: vec4<u32>, point: SurfacePoint) -> f32 {
    let roughness = layer_factor(words, point);
    return roughness * roughness;
}

fn film_at(at: u32, point: SurfacePoint, lambda_nm: vec4<f32>) {
    let factor = tables[at];
    let film = tables[at + 1u];
    var part = 1.0;
    if (film.z != NONE) {
        part = linear_texture_at(film.z, point).y;
    }
    let range = bitcast<vec2<f32>>(film.xy);
    let thickness_nm = range.x + (range.y - range.x) * part;
    let weight = layer_factor(factor, point);
    layers.film_index = bitcast<f32>(factor.w);
    layers.film_waves = 2.0 * layers.film_index * thickness_nm / lambda_nm;
    // No thickness, no film.
    layers.film_weight = select(0.0, weight, thickness_nm > 0.0);
}

/// Strength and direction of grooves; `grooves`.
fn grooves_at(words: vec4<u32>, point: SurfacePoint) -> vec3<f32> {
    let numbers = bitcast<vec4<f32>>(words);
    if (words.w == NONE) {
        return numbers.xyz;
    }
    let texel = linear_texture_at(words.w, point).xyz;
    let along = 2.0 * texel.xy - 1.0;
    let size = length(along);
    let direction = select(vec2<f32>(1.0, 0.0), along / size, size > 0.0);
    let turned = vec2<f32>(numbers.y * direction.x - numbers.z * direction.y, numbers.z * direction.x + numbers.y * direction.y);
    return vec3<f32>(numbers.x * texel.z, turned);
}

/// The material whose words begin at a place, seen from `wo`.
fn layered_shading(at: u32, point: SurfacePoint, wo: vec3<f32>, lambda_nm: vec4<f32>) -> Shading {
    let head = tables[at];
    let specular_source = tables[at + 3u];
    let metallic = tables[at + 5u];
    let roughness = tables[at + 6u];
    var bsdf = Bsdf(head.x, vec2<f32>(0.0), vec4<f32>(0.0), vec4<f32>(0.0), false, false, false, vec2<f32>(0.0));
    layers = plain_layers();
    bsdf.first = base_colour_at(tables[at + 1u], bitcast<vec3<f32>>(tables[at + 2u].xyz), point, lambda_nm);
    var specular_colour = vec4<f32>(1.0);
    if (specular_source.x != COLOUR_SPECTRUM || specular_source.y != NONE) {
        specular_colour = colour_at(specular_source, bitcast<vec3<f32>>(tables[at + 4u].xyz), point, lambda_nm);
    }
    bsdf.second = min(specular_colour * bitcast<f32>(head.y), vec4<f32>(1.0));
    layers.specular = factor_at(bitcast<f32>(head.z), head.w, metallic.w, point);
    layers.metallic = layer_factor(metallic, point);
    let alpha = layer_alpha(roughness, point);
    bsdf.roughness = roughness_of(alpha, alpha);
    let map = normal_map_of(point);
    let more = roughness.w;
    if (more == NONE) {
        return Shading(mapped_frame(map, point, wo, true), bsdf);
    }

    // What light passes
    let first = params.layers + more * LAYER_WORDS;
    let flags = tables[first + 1u].y;
    if (HAS_TRANSMISSION) {
        layers.transmission = layer_factor(tables[first], point);
        layers.has_volume = (flags & LAYERS_VOLUME) != 0u;
        layers.eta = spectrum(tables[first + 1u].x, lambda_nm);
        bsdf.is_dispersive = layers.has_volume && (flags & LAYERS_DISPERSIVE) != 0u;
    }
    if (HAS_DIFFUSE_TRANSMISSION && (flags & LAYERS_DIFFUSE_TRANSMISSION) != 0u) {
        layers.diffuse_transmission = layer_factor(tables[first + 2u], point);
        let factor = bitcast<vec3<f32>>(tables[first + 4u].xyz);
        layers.diffuse_transmission_colour = colour_at(tables[first + 3u], factor, point, lambda_nm);
    }

    // Film and fibres
    if (HAS_FILM && (flags & LAYERS_FILM) != 0u) {
        film_at(first + 6u, point, lambda_nm);
    }
    if (HAS_SHEEN && (flags & LAYERS_SHEEN) != 0u) {
        let colour = colour_at(tables[first + 8u], bitcast<vec3<f32>>(tables[first + 9u].xyz), point, lambda_nm);
        layers.sheen_colour = colour;
        layers.sheen_alpha = layer_alpha(tables[first + 10u], point);
        layers.has_sheen = any(colour != vec4<f32>(0.0));
    }

    // The frame, turned to the grooves
    let is_two_sided = !refracts_layered();
    var frame = mapped_frame(map, point, wo, is_two_sided);
    if (HAS_GROOVES && (flags & LAYERS_GROOVES) != 0u) {
        let grooves = grooves_at(tables[first + 5u], point);
        bsdf.roughness = roughness_of(alpha + (1.0 - alpha) * grooves.x * grooves.x, alpha);
        // The file's bitangent, whichever side is looked at.
        let side = with_sign(1.0, dot(frame.y, cross(point.shading_normal, point.tangent)));
        let bitangent = frame.y * (side * point.handedness);
        frame = frame_from_normal_tangent(frame.z, frame.x * grooves.y + bitangent * grooves.z);
    }

    // Clear coat, whose normal is its own
    if (HAS_COAT && (flags & LAYERS_COAT) != 0u) {
        let coat_map = tables[first + 13u];
        layers.coat_weight = layer_factor(tables[first + 11u], point);
        let coat_alpha = layer_alpha(tables[first + 12u], point);
        layers.coat_alpha = roughness_of(coat_alpha, coat_alpha).x;
        layers.has_coat = layers.coat_weight > 0.0;
        if (coat_map.x != NONE || map.x != NONE) {
            layers.coat_normal = to_local(frame, mapped_frame(coat_map, point, wo, is_two_sided).z);
        }
    }
    return Shading(frame, bsdf);
}
