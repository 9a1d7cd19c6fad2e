// Projectors; photosite-transport's light/projector.rs.

/// Intensity from a point of the opening towards a unit direction of the light's space, over the flux of a white slide.
fn projector_intensity(at: u32, opening: vec2<f32>, direction: vec3<f32>, lambda_nm: vec4<f32>) -> vec4<f32> {
    let emission = tables[at + 1u];
    let frame = bitcast<vec4<f32>>(tables[at + 2u]);
    let focus_distance = bitcast<f32>(tables[at + 4u].w);
    let cosine = -direction.z;
    if (cosine <= 0.0) {
        return vec4<f32>(0.0);
    }
    // Where the ray passes the plane of focus, seen from the middle of the lens
    let across = direction.xy / cosine + opening / focus_distance;
    let place = (across - frame.zw) / frame.xy;
    let uv = vec2<f32>(place.x + 0.5, 0.5 - place.y);
    if (!(all(uv >= vec2<f32>(0.0)) && all(uv < vec2<f32>(1.0)))) {
        return vec4<f32>(0.0);
    }
    let rgb = texture_srgb(emission.z, uv);
    let level = cosine * bitcast<f32>(emission.w);
    if (all(rgb == vec3<f32>(1.0))) {
        return vec4<f32>(level);
    }
    return tint_spectrum(rgb, lambda_nm) * level;
}

/// Direction to a point of the lens's opening.
fn sample_projector(at: u32, level: u32, u: vec2<f32>, ctx: LightContext, lambda_nm: vec4<f32>) -> LightSample {
    let pose = light_pose(at);
    let radius = bitcast<f32>(tables[at + 3u].w);
    let opening = concentric_disk(u) * radius;
    let leaves = pose.position + rotated(pose.light_to_world, vec3<f32>(opening, 0.0));
    let direction = rotated(pose.world_to_light, normalized_or(ctx.point - leaves, vec3<f32>(0.0)));
    let intensity = projector_intensity(at, opening, direction, lambda_nm);
    if (all(intensity == vec4<f32>(0.0))) {
        return no_light();
    }
    return sample_from_point(ctx.point, leaves, spectrum(level, lambda_nm) * intensity);
}
