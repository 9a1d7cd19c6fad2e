// Laser beams; photosite-transport's light/gaussian_beam.rs.

/// Radii beyond this multiple of the beam's radius get no light.
const BEAM_CUT = 3.0f;

fn sample_gaussian_beam(at: u32, level: u32, ctx: LightContext, lambda_nm: vec4<f32>) -> LightSample {
    let pose = light_pose(at);
    let numbers = bitcast<vec4<f32>>(tables[at + 2u]);
    let waist = numbers.xy;
    let tan_divergence = numbers.zw;
    let local = rotated(pose.world_to_light, ctx.point - pose.position);
    let across = local.xy;
    let z = -local.z;
    if (!(z > 0.0)) {
        return no_light();
    }

    // Irradiance on the plane across the beam, for a flux of 1
    let spread = tan_divergence * z;
    let radius_squared = waist * waist + spread * spread;
    if (!(min(radius_squared.x, radius_squared.y) > 0.0)) {
        return no_light();
    }
    let parts = across * across / radius_squared;
    let exponent = 2.0 * (parts.x + parts.y);
    if (!(exponent <= 2.0 * BEAM_CUT * BEAM_CUT)) {
        return no_light();
    }
    let irradiance = FRAC_2_PI / sqrt(radius_squared.x * radius_squared.y) * exp(-exponent);

    // The ray through the point, back to the plane that it leaves
    let slope = across * spread * tan_divergence / radius_squared;
    let leaves = rotated(pose.light_to_world, vec3<f32>(across - slope * z, 0.0));
    let to_light = rotated(pose.light_to_world, vec3<f32>(-slope, 1.0));
    let per_cosine = length(to_light);
    var sample = sample_without_surface();
    sample.radiance = spectrum(level, lambda_nm) * (irradiance * per_cosine);
    sample.wi = to_light / per_cosine;
    sample.position = pose.position + leaves;
    return sample;
}
