// A sampled direction to a light, and the pose of a light without a surface; photosite-transport's light/sample.rs,
// light/delta_model.rs.

/// Target of shadow rays to lights without a surface, which no primitive has.
const NO_SURFACE = 0x7fffffffu;

struct LightSample {
    light: u32,
    radiance: vec4<f32>,
    wi: vec3<f32>,
    position: vec3<f32>,
    /// Normal of the light; zero of a light without a surface.
    normal: vec3<f32>,
    /// Density of the direction times the probability of the light; 0 where no light arrives.
    pdf: f32,
    is_delta: bool,
    is_distant: bool,
    target_primitive: u32,
}

fn no_light() -> LightSample {
    return LightSample(NONE, vec4<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0), 0.0, false, false, NONE);
}

/// A sample of a light without a surface, whose radiance and direction are yet to be told.
fn sample_without_surface() -> LightSample {
    var sample = no_light();
    sample.pdf = 1.0;
    sample.is_delta = true;
    sample.target_primitive = NO_SURFACE;
    return sample;
}

/// The direction from a point to another, from where light comes with that intensity; `LiSample::from_point`.
fn sample_from_point(point: vec3<f32>, position: vec3<f32>, intensity: vec4<f32>) -> LightSample {
    let to_light = position - point;
    let distance_squared = dot(to_light, to_light);
    if (!(distance_squared > 0.0)) {
        return no_light();
    }
    var sample = sample_without_surface();
    sample.radiance = intensity / distance_squared;
    sample.wi = to_light / sqrt(distance_squared);
    sample.position = position;
    return sample;
}

/// Pose of a light without a surface, which shines along −z of its own space.
struct LightPose {
    position: vec3<f32>,
    /// Rotation from the world to the space of the light, and the one back.
    world_to_light: vec4<f32>,
    light_to_world: vec4<f32>,
}

/// Pose of the light whose words begin at a place.
fn light_pose(at: u32) -> LightPose {
    let rotation = bitcast<vec4<f32>>(tables[at + 5u]);
    return LightPose(bitcast<vec3<f32>>(tables[at + 3u].xyz), rotation, conjugate(rotation));
}
