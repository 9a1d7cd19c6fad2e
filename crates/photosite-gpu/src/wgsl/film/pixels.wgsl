// Starts and ends of paths of whole pixels; photosite-transport's integrator/render/tracer.rs (`Tracer::draw`),
// sampler/pixel_order.rs and film.rs. A run is of samples of one pixel that follow each other; paths of run r have the
// numbers from r · slots on.

/// Run as the host sends it.
struct Run {
    pixel: vec2<u32>,
    first_sample: u32,
    count: u32,
}

fn run_of(number: u32) -> Run {
    let words = starts[number];
    return Run(words.xy, words.z, words.w);
}

/// Bits below 2⁶ moved to every other place.
fn spread_bits(number: u32) -> u32 {
    var bits = number;
    bits = (bits | (bits << 4u)) & 0x0f0fu;
    bits = (bits | (bits << 2u)) & 0x3333u;
    return (bits | (bits << 1u)) & 0x5555u;
}

/// Random numbers of a sample of a pixel, from the first on.
fn sampler_of(pixel: vec2<u32>, sample_number: u32) -> Sampler {
    let square = (pixel.y >> film.log2_side) * film.squares + (pixel.x >> film.log2_side);
    let within = (1u << film.log2_side) - 1u;
    let in_square = spread_bits(pixel.x & within) | (spread_bits(pixel.y & within) << 1u);
    // Shifts by the whole width are none in WGSL.
    let first_index = select(in_square << (film.log2_samples & 31u), 0u, film.log2_samples > 31u);
    let key = first_half(hash64(vec2<u32>(film.seed_low, film.seed_high), vec2<u32>(square, 0u)));
    return Sampler(key, first_index + sample_number, 0u);
}

/// Starts the paths of some runs.
@compute @workgroup_size(WORKGROUP_SIZE)
fn generate_camera_rays(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    let slots = atomicLoad(&control[SLOTS]);
    if (i >= atomicLoad(&control[STARTED])) {
        return;
    }
    let run = run_of(i / slots);
    let place = i % slots;
    if (place >= run.count) {
        return;
    }

    // Sample the pixel and the aperture
    var random = sampler_of(run.pixel, run.first_sample + place);
    let within = next_2d(&random);
    var u_aperture = vec2<f32>(0.0);
    if (film.has_aperture != 0u) {
        u_aperture = next_2d(&random);
    } else {
        skip(&random);
    }

    // Sample the wavelengths
    let drawn = sample_wavelengths(run.pixel, next_1d(&random));

    // Sample the time, of cameras that have one only
    var u_time = 0.0;
    if (film.has_times != 0u) {
        u_time = next_1d(&random);
    }
    let time = time_of_row(run.pixel.y, u_time);

    // Generate the camera ray. Where the lens sees nothing, the sample is dark.
    let ray = camera_ray(run.pixel, within, u_aperture, time);
    store_f32(LIGHT, i, vec4<f32>(0.0));
    store_f32(LAMBDA, i, drawn.lambda_nm);
    store_f32(SENSOR_WEIGHT, i, drawn.weights * lens_transmittance(drawn.lambda_nm) * ray.weight);
    store(REST, i, vec4<u32>(bitcast<u32>(1.0f), film.has_single_wavelengths, 0u, bitcast<u32>(clamp(time, 0.0, 1.0))));
    if (ray.weight == 0.0) {
        return;
    }
    store(ORIGIN_LEAVES, i, vec4<u32>(bitcast<vec3<u32>>(ray.origin), NONE));
    store(DIRECTION_INSTANCE, i, vec4<u32>(bitcast<vec3<u32>>(ray.direction), 0u));
    store_f32(THROUGHPUT, i, vec4<f32>(1.0));
    store_f32(LAST_POINT, i, vec4<f32>(0.0, 0.0, 0.0, -1.0));
    store(RANDOM, i, vec4<u32>(random.key, random.index, random.dimension));
    atomicAdd(&control[SURFACE_RAYS], 1u);
    lists[atomicAdd(&control[ACTIVE], 1u)] = i;
}

/// Values that a path gives to four channels.
fn channel_values(path: u32, group: u32) -> vec4<f32> {
    let lambda_nm = load_f32(LAMBDA, path);
    var weighted = load_f32(LIGHT, path) * load_f32(SENSOR_WEIGHT, path);
    var lanes = 4u;
    if ((load(REST, path).y & 1u) != 0u) {
        // The hero stands for all four.
        weighted.x *= 4.0;
        lanes = 1u;
    }
    var values = vec4<f32>(0.0);
    for (var lane = 0u; lane < lanes; lane++) {
        let x = lambda_nm[lane] - LAMBDA_MIN_NM;
        let entry = min(u32(x), SPECTRUM_ENTRIES - 2u);
        let place = film.responses + entry * film.groups + group;
        let low = film_tables[place];
        let high = film_tables[place + film.groups];
        values += weighted[lane] * (low + (high - low) * (x - f32(entry)));
    }
    return values;
}

/// Responds to what arrives along each path, for four channels at a time.
@compute @workgroup_size(WORKGROUP_SIZE)
fn update_film(@builtin(global_invocation_id) id: vec3<u32>) {
    let path = id.x / film.groups;
    let slots = atomicLoad(&control[SLOTS]);
    if (path >= atomicLoad(&control[STARTED]) || path % slots >= run_of(path / slots).count) {
        return;
    }
    arrivals[id.x] = bitcast<vec4<u32>>(channel_values(path, id.x % film.groups));
}
