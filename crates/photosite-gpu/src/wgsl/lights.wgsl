// Samples of lights; photosite-transport's light/lights.rs, light/area_light.rs, light/kind.rs, light/spot_light.rs and
// its neighbours.

/// Radiance of an emission, whose words are those of a light or a material, at a place on a primitive of a mesh.
fn emitted_at(words: vec4<u32>, factor: vec3<f32>, primitive: u32, mesh: u32, parameters: vec2<f32>, lambda_nm: vec4<f32>) -> vec4<f32> {
    let radiance = spectrum(words.x, lambda_nm);
    if ((words.y & 255u) == COLOUR_SPECTRUM) {
        return radiance;
    }
    return radiance * tint_spectrum(factor * texture_at(words.z, primitive, mesh, parameters), lambda_nm);
}

/// Radiance that a surface point emits towards wo.
fn emitted(point: SurfacePoint, wo: vec3<f32>, lambda_nm: vec4<f32>) -> vec4<f32> {
    let at = params.materials + point.material * MATERIAL_WORDS + MATERIAL_WORDS - 3u;
    let words = tables[at];
    let is_two_sided = (words.y & TWO_SIDED) != 0u;
    if (words.x == NONE || (!is_two_sided && dot(wo, point.geometric_normal) <= 0.0)) {
        return vec4<f32>(0.0);
    }
    return emitted_at(words, bitcast<vec3<f32>>(tables[at + 1u].xyz), point.primitive, point.mesh, point.parameters, lambda_nm);
}

/// Direction to a light that shines within a cone.
fn sample_spot_light(at: u32, level: u32, ctx: LightContext, lambda_nm: vec4<f32>) -> LightSample {
    let place = bitcast<vec4<f32>>(tables[at + 3u]);
    let axis = bitcast<vec4<f32>>(tables[at + 4u]);
    let cosine = dot(normalized_or(ctx.point - place.xyz, vec3<f32>(0.0)), axis.xyz);
    let ramp = clamp((cosine - axis.w) / max(place.w - axis.w, 1e-4), 0.0, 1.0);
    if (ramp == 0.0) {
        return no_light();
    }
    return sample_from_point(ctx.point, place.xyz, spectrum(level, lambda_nm) * (ramp * ramp));
}

/// Direction to a light without a surface.
fn sample_delta_light(kind: u32, at: u32, u: vec2<f32>, ctx: LightContext, lambda_nm: vec4<f32>) -> LightSample {
    let level = tables[at + 1u].x;
    switch kind {
        case LIGHT_DIRECTIONAL: {
            var sample = sample_without_surface();
            sample.radiance = spectrum(level, lambda_nm);
            sample.wi = -bitcast<vec3<f32>>(tables[at + 4u].xyz);
            sample.is_distant = true;
            return sample;
        }
        case LIGHT_SPOT: { return sample_spot_light(at, level, ctx, lambda_nm); }
        case LIGHT_PROFILE: { return sample_profile(at, level, ctx, lambda_nm); }
        case LIGHT_PROJECTOR: { return sample_projector(at, level, u, ctx, lambda_nm); }
        case LIGHT_GAUSSIAN_BEAM: { return sample_gaussian_beam(at, level, ctx, lambda_nm); }
        default: { return sample_from_point(ctx.point, light_pose(at).position, spectrum(level, lambda_nm)); }
    }
}

/// Direction to a light without a surface at a time: one that moves is sampled in its own space.
fn sample_delta_light_at(head: vec4<u32>, at: u32, u: vec2<f32>, ctx: LightContext, time: f32, lambda_nm: vec4<f32>) -> LightSample {
    let motion = head.yz;
    var transform: Transform;
    var own = ctx;
    if (motion.y != 0u) {
        transform = motion_at(motion.x, motion.y, time);
        own.point = into_object(transform, vec4<f32>(ctx.point, 1.0));
    }
    var sample = sample_delta_light(head.x, at, u, own, lambda_nm);
    if (motion.y != 0u) {
        sample.wi = normalized_or(into_world(transform, vec4<f32>(sample.wi, 0.0)), vec3<f32>(0.0));
        sample.position = into_world(transform, vec4<f32>(sample.position, 1.0));
    }
    return sample;
}

/// A direction to the light that was chosen, at a time.
fn sample_chosen(choice: Choice, v: f32, ctx: LightContext, time: f32, lambda_nm: vec4<f32>) -> LightSample {
    let at = params.lights + choice.light * LIGHT_WORDS;
    let head = tables[at];
    let emission = tables[at + 1u];
    let u = vec2<f32>(choice.rest, v);
    var sample = no_light();
    switch head.x {
        case LIGHT_TRIANGLE, LIGHT_QUADRIC, LIGHT_DEFORMING: {
            var seen: SeenPoint;
            if (head.x == LIGHT_TRIANGLE) {
                seen = sample_emissive_triangle(emissive_triangle(choice.light), ctx.point, u);
            } else if (head.x == LIGHT_DEFORMING) {
                seen = sample_emissive_triangle(emissive_triangle_at(choice.light, time), ctx.point, u);
            } else {
                seen = sample_quadric(load_quadric(head.y), ctx.point, u);
            }
            let is_two_sided = (emission.y & TWO_SIDED) != 0u;
            if (!(seen.cosine > 0.0 || (is_two_sided && seen.cosine < 0.0))) {
                return sample;
            }
            let primitive = select(head.y, IS_QUADRIC | head.y, head.x == LIGHT_QUADRIC);
            sample.radiance = emitted_at(emission, bitcast<vec3<f32>>(tables[at + 2u].xyz), primitive, emission.w, seen.parameters, lambda_nm);
            // Where there are holes, rays that look for the light end in front of them.
            if (params.has_holes != 0u) {
                sample.radiance *= presence(primitive, emission.w, seen.parameters);
            }
            sample.wi = seen.wi;
            sample.position = seen.position;
            sample.normal = seen.normal;
            sample.pdf = seen.pdf;
            sample.target_primitive = head.z;
        }
        case LIGHT_POINT, LIGHT_SPOT, LIGHT_DIRECTIONAL, LIGHT_PROFILE, LIGHT_PROJECTOR, LIGHT_GAUSSIAN_BEAM: {
            sample = sample_delta_light_at(head, at, u, ctx, time, lambda_nm);
        }
        case LIGHT_ENVIRONMENT: {
            let drawn = sample_environment(u);
            sample.wi = drawn.xyz;
            sample.pdf = drawn.w;
            sample.is_distant = true;
            if (drawn.w > 0.0) {
                sample.radiance = environment_radiance(drawn.xyz, lambda_nm);
            }
        }
        default: {}
    }
    sample.light = choice.light;
    sample.pdf *= choice.probability;
    return sample;
}

/// Density with which light sampling finds a point of an area light at a time.
fn area_light_pdf(light: u32, ctx: LightContext, time: f32, distance: f32, cosine: f32) -> f32 {
    let head = tables[params.lights + light * LIGHT_WORDS];
    let density = emitter_pdf(head.x, head.y, light, ctx.point, time, distance, cosine);
    if (density == 0.0) {
        return 0.0;
    }
    return density * (probability_in_tree(ctx, light, head.w) * (1.0 - part_of_distant(ctx)));
}
