// A wavefront of paths: generate, extend, shade, shadow, arrive; photosite-transport's integrator/path.rs is what each
// path does. A kernel runs for all paths that go on, whose indices stand in one of two lists; those that go on after it
// are added to the other. State k of path i is state[k · capacity + i].

/// Numbers that kernels and the host share: see the places below.
@group(1) @binding(0) var<storage, read_write> state: array<vec4<u32>>;
@group(1) @binding(1) var<storage, read_write> lists: array<u32>;
@group(1) @binding(2) var<storage, read_write> control: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read> starts: array<vec4<u32>>;
@group(1) @binding(4) var<storage, read_write> arrivals: array<vec4<u32>>;
/// Workgroups of the kernels that follow.
@group(2) @binding(0) var<storage, read_write> workgroups: array<u32>;

// Places in `control`
const STARTED = 0u;
const ACTIVE = 1u;
const NEXT = 2u;
const SHADOWS = 3u;
const ACTIVE_SHADOWS = 4u;
const DEPTH = 5u;
const SURFACE_RAYS = 6u;
const LIGHT_RAYS = 7u;
/// Paths that each run has room for, where paths start and end on the card.
const SLOTS = 8u;

// States of a path
const ORIGIN_LEAVES = 0u;
const DIRECTION_INSTANCE = 1u;
const THROUGHPUT = 2u;
const LIGHT = 3u;
const LAMBDA = 4u;
const HIT = 5u;
/// Point of the last vertex, and the density of its BSDF sample; −1 where light sampling could not have found it.
const LAST_POINT = 6u;
/// Normal of the last vertex, and whether both of its sides count.
const LAST_NORMAL = 7u;
const RANDOM = 8u;
/// Square of the indices that were passed, whether the hero is alone with the medium (`medium_of`), instance of the hit
/// and after it the medium in which a shadow ray through panes sets out, time.
const REST = 9u;
const SHADOW_ORIGIN_TARGET = 10u;
const SHADOW_DIRECTION_END = 11u;
const SHADOW_LIGHT = 12u;
/// Weights of the wavelengths times those of the camera and the transmittance of the lens, of paths that start on the
/// card.
const SENSOR_WEIGHT = 13u;

fn place_of(kind: u32, path: u32) -> u32 {
    return kind * params.capacity + path;
}

fn load(kind: u32, path: u32) -> vec4<u32> {
    return state[place_of(kind, path)];
}

fn load_f32(kind: u32, path: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(state[place_of(kind, path)]);
}

fn store(kind: u32, path: u32, value: vec4<u32>) {
    state[place_of(kind, path)] = value;
}

fn store_f32(kind: u32, path: u32, value: vec4<f32>) {
    state[place_of(kind, path)] = bitcast<vec4<u32>>(value);
}

/// Time of a path, which nobody asks for where nothing moves.
fn time_of(path: u32) -> f32 {
    if (params.motions == NONE) {
        return 0.0;
    }
    return bitcast<f32>(state[place_of(REST, path)].w);
}

/// List of the paths that go on at this depth, and of those that go on after it.
fn list_in(depth: u32) -> u32 {
    return (depth & 1u) * params.capacity;
}

fn list_out(depth: u32) -> u32 {
    return (1u - (depth & 1u)) * params.capacity;
}

fn shadow_list() -> u32 {
    return 2u * params.capacity;
}

/// Whether a component makes any light.
fn is_black(s: vec4<f32>) -> bool {
    return all(s == vec4<f32>(0.0));
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn generate(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= atomicLoad(&control[STARTED])) {
        return;
    }
    let origin = starts[4u * i];
    let direction = starts[4u * i + 1u];
    store(ORIGIN_LEAVES, i, vec4<u32>(origin.xyz, NONE));
    store(DIRECTION_INSTANCE, i, vec4<u32>(direction.xyz, 0u));
    store_f32(THROUGHPUT, i, vec4<f32>(1.0));
    store_f32(LIGHT, i, vec4<f32>(0.0));
    store(LAMBDA, i, starts[4u * i + 2u]);
    store_f32(LAST_POINT, i, vec4<f32>(0.0, 0.0, 0.0, -1.0));
    store(RANDOM, i, starts[4u * i + 3u]);
    store(REST, i, vec4<u32>(bitcast<u32>(1.0f), direction.w, 0u, origin.w));
    lists[i] = i;
}

/// Finds the nearest surface along the ray of each path.
@compute @workgroup_size(WORKGROUP_SIZE)
fn extend(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= atomicLoad(&control[ACTIVE])) {
        return;
    }
    let i = lists[list_in(atomicLoad(&control[DEPTH])) + id.x];
    let origin = load(ORIGIN_LEAVES, i);
    let direction = load(DIRECTION_INSTANCE, i);
    let ray = Ray(bitcast<vec3<f32>>(origin.xyz), FAR, bitcast<vec3<f32>>(direction.xyz), origin.w, direction.w, NONE, time_of(i));
    let hit = trace(ray, false);
    store(HIT, i, vec4<u32>(bitcast<u32>(hit.t), bitcast<u32>(hit.uv.x), bitcast<u32>(hit.uv.y), hit.slot));
    state[place_of(REST, i)].z = hit.instance;
}

/// MIS weight of emission that BSDF sampling has found on a light at a distance from the last vertex.
fn emission_weight(i: u32, point: SurfacePoint, wo: vec3<f32>, distance: f32) -> f32 {
    let light = light_of(point);
    let last = load_f32(LAST_POINT, i);
    if (light == NONE || last.w < 0.0) {
        return 1.0;
    }
    let normal = load(LAST_NORMAL, i);
    let ctx = LightContext(last.xyz, bitcast<vec3<f32>>(normal.xyz), normal.w != 0u);
    return power_heuristic(last.w, area_light_pdf(light, ctx, point.time, distance, dot(wo, point.geometric_normal)));
}

/// Samples a light, and queues its shadow ray with what the path gathers if nothing is in the way. Returns the medium
/// in which a ray sets out that is followed through panes.
fn sample_direct_light(i: u32, point: SurfacePoint, shading: Shading, wo: vec3<f32>, ctx: LightContext, u: vec2<f32>, throughput: vec4<f32>, medium: u32, lambda_nm: vec4<f32>) -> u32 {
    let choice = choose_light(ctx, u.x);
    if (choice.light == NONE) {
        return NONE;
    }
    let light = sample_chosen(choice, u.y, ctx, point.time, lambda_nm);
    if (!(light.pdf > 0.0)) {
        return NONE;
    }
    let wo_local = to_local(shading.frame, wo);
    let wi_local = to_local(shading.frame, light.wi);
    let is_transmission = wi_local.z * wo_local.z < 0.0;
    if (leaks(point, shading.bsdf, wo, light.wi, is_transmission)) {
        return NONE;
    }
    let scattering = eval_bsdf(shading.bsdf, wo_local, wi_local);
    var contribution = light.radiance * scattering.f * (abs(wi_local.z) / light.pdf);
    // Where shadow rays end at the boundary, light comes from within; those that are followed absorb on their way.
    var crossed = NONE;
    let is_followed = HAS_PANES && light.is_delta;
    if (HAS_MEDIA) {
        crossed = select(medium, medium_across(point, light.wi, medium), is_transmission);
    }
    if (HAS_MEDIA && !light.is_distant && !is_followed) {
        contribution *= transmittance(crossed, distance(point.position, light.position), lambda_nm);
    }
    let weight = select(power_heuristic(light.pdf, scattering.pdf), 1.0, light.is_delta);
    let brought = throughput * (contribution * weight);
    if (is_black(brought)) {
        return NONE;
    }
    let ray = spawn_ray(point, light.wi);
    var direction = ray.direction;
    var end = FAR;
    if (!light.is_distant) {
        var target_point = light.position;
        if (!light.is_delta) {
            // A few roundings lie between the light's corners and its sampled point.
            target_point = offset_origin(light.position, abs(light.position) * gamma(8.0), light.normal, -light.wi);
        }
        direction = target_point - ray.origin;
        end = 1.0;
    }
    store(SHADOW_ORIGIN_TARGET, i, vec4<u32>(bitcast<vec3<u32>>(ray.origin), light.target_primitive));
    store(SHADOW_DIRECTION_END, i, vec4<u32>(bitcast<vec3<u32>>(direction), bitcast<u32>(end)));
    store_f32(SHADOW_LIGHT, i, brought);
    let place = atomicAdd(&control[SHADOWS], 1u);
    lists[shadow_list() + place] = i;
    return select(NONE, crossed, is_followed);
}

/// Gathers light where rays have led, samples lights and BSDFs, and plays Russian roulette; `Path::advance`.
@compute @workgroup_size(WORKGROUP_SIZE)
fn shade(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= atomicLoad(&control[ACTIVE])) {
        return;
    }
    let depth = atomicLoad(&control[DEPTH]) + 1u;
    let i = lists[list_in(depth - 1u) + id.x];
    let hit_words = load(HIT, i);
    let rest = load(REST, i);
    var is_hero_alone = rest.y & 1u;
    var throughput = load_f32(THROUGHPUT, i);
    let lambda_nm = load_f32(LAMBDA, i);
    let direction = bitcast<vec3<f32>>(load(DIRECTION_INSTANCE, i).xyz);

    // Add the light of the environment where the ray leaves the scene
    if (hit_words.w == NONE) {
        let radiance = environment_radiance(direction, lambda_nm);
        if (!is_black(radiance)) {
            let last = load_f32(LAST_POINT, i);
            var weight = 1.0;
            if (last.w >= 0.0) {
                let normal = load(LAST_NORMAL, i);
                let ctx = LightContext(last.xyz, bitcast<vec3<f32>>(normal.xyz), normal.w != 0u);
                weight = power_heuristic(last.w, environment_pdf(ctx, direction));
            }
            store_f32(LIGHT, i, load_f32(LIGHT, i) + throughput * radiance * weight);
        }
        return;
    }

    // Add the surface's emission, weighted against light sampling
    let hit = Hit(bitcast<f32>(hit_words.x), bitcast<vec2<f32>>(hit_words.yz), hit_words.w, rest.z);
    let point = surface_point(hit, bitcast<f32>(rest.w));
    let wo = -direction;
    var medium = NONE;
    if (HAS_MEDIA) {
        // Absorb along the segment: a volume seen from behind has been crossed, whether or not its front was met
        // before.
        let behind = absorption_behind(point, wo);
        medium = select(behind, medium_of(rest.y), behind == NONE);
        throughput *= transmittance(medium, hit.t, lambda_nm);
    }
    let emission = emitted(point, wo, lambda_nm);
    if (!is_black(emission)) {
        store_f32(LIGHT, i, load_f32(LIGHT, i) + throughput * emission * emission_weight(i, point, wo, hit.t));
    }

    // End the path at its largest depth
    if (depth >= params.max_depth) {
        return;
    }

    // Look up the BSDF, and drop the secondary wavelengths if it cannot serve them
    let shading = shading_at(point, wo, lambda_nm);
    let bsdf_is_delta = is_delta(shading.bsdf);
    if (needs_single_wavelength(shading.bsdf)) {
        is_hero_alone = 1u;
        throughput = vec4<f32>(throughput.x, 0.0, 0.0, 0.0);
    }
    let ctx = LightContext(point.position, shading.frame.z, transmits(shading.bsdf));
    let random_words = load(RANDOM, i);
    var random = Sampler(random_words.xy, random_words.z, random_words.w);

    // Prepare the BSDF for both that follow
    let wo_local = to_local(shading.frame, wo);
    view_bsdf(shading.bsdf, wo_local);

    // Sample direct illumination, and queue its shadow ray. It leaves the same triangle as the ray that goes on.
    let leaving = spawn_ray(point, wo);
    var followed = NONE;
    if (!bsdf_is_delta) {
        let u = next_2d(&random);
        followed = sample_direct_light(i, point, shading, wo, ctx, u, throughput, medium, lambda_nm);
    }

    // Sample the BSDF
    var u_lobe = 0.0;
    if (has_lobes(shading.bsdf)) {
        u_lobe = next_1d(&random);
    } else {
        skip(&random);
    }
    let u = next_2d(&random);
    let sample = sample_bsdf(shading.bsdf, wo_local, u_lobe, u);
    let wi = to_world(shading.frame, sample.wi);
    var goes_on = sample.pdf > 0.0 && !leaks(point, shading.bsdf, wo, wi, sample.is_transmission);
    throughput *= sample.f * (abs(sample.wi.z) / select(1.0, sample.pdf, sample.pdf > 0.0));
    goes_on = goes_on && !is_black(throughput);
    if (sample.terminates_secondary) {
        is_hero_alone = 1u;
        throughput = vec4<f32>(throughput.x, 0.0, 0.0, 0.0);
    }
    let eta_scale = bitcast<f32>(rest.x) * sample.eta * sample.eta;
    if (HAS_MEDIA && sample.is_transmission) {
        medium = medium_across(point, wi, medium);
    }

    // Play Russian roulette
    if (goes_on && depth >= params.roulette_depth) {
        let survival = max(max(throughput.x, throughput.y), max(throughput.z, throughput.w)) * eta_scale;
        if (survival < 1.0) {
            goes_on = next_1d(&random) < survival;
            throughput *= 1.0 / survival;
        }
    }

    // Spawn the ray. What the shadow ray leaves is kept with it.
    let ray = spawn_ray(point, wi);
    store(ORIGIN_LEAVES, i, vec4<u32>(bitcast<vec3<u32>>(ray.origin), leaving.leaves));
    store(DIRECTION_INSTANCE, i, vec4<u32>(bitcast<vec3<u32>>(wi), leaving.leaves_instance));
    store(REST, i, vec4<u32>(bitcast<u32>(eta_scale), is_hero_alone | medium_bits(medium), followed, rest.w));
    if (!goes_on) {
        return;
    }
    store_f32(THROUGHPUT, i, throughput);
    store_f32(LAST_POINT, i, vec4<f32>(point.position, select(sample.pdf, -1.0, sample.is_delta)));
    store(LAST_NORMAL, i, vec4<u32>(bitcast<vec3<u32>>(shading.frame.z), select(0u, 1u, ctx.is_both)));
    store(RANDOM, i, vec4<u32>(random.key, random.index, random.dimension));
    let place = atomicAdd(&control[NEXT], 1u);
    lists[list_out(depth - 1u) + place] = i;
}

/// The shadow ray of a path.
fn shadow_ray(i: u32) -> Ray {
    let origin = load(SHADOW_ORIGIN_TARGET, i);
    let direction = load(SHADOW_DIRECTION_END, i);
    let leaves = load(ORIGIN_LEAVES, i).w;
    let instance = load(DIRECTION_INSTANCE, i).w;
    return Ray(bitcast<vec3<f32>>(origin.xyz), bitcast<f32>(direction.w), bitcast<vec3<f32>>(direction.xyz), leaves, instance, origin.w, time_of(i));
}

/// Adds what shadow rays bring that meet nothing.
@compute @workgroup_size(WORKGROUP_SIZE)
fn shadow(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= atomicLoad(&control[ACTIVE_SHADOWS])) {
        return;
    }
    let i = lists[shadow_list() + id.x];
    let ray = shadow_ray(i);
    let is_free = trace(ray, true).slot == NONE;
    var passed = vec4<f32>(select(0.0, 1.0, is_free));
    if (HAS_PANES && ray.target_primitive == NO_SURFACE) {
        // Rays that set out in a medium absorb even where nothing is in the way.
        let medium = state[place_of(REST, i)].z;
        if (!is_free || medium != NONE) {
            passed = through_panes(ray, medium, load_f32(LAMBDA, i));
        }
    }
    if (!is_black(passed)) {
        store_f32(LIGHT, i, load_f32(LIGHT, i) + load_f32(SHADOW_LIGHT, i) * passed);
    }
}

/// Counts the paths that go on and the shadow rays, and makes room for the next ones.
@compute @workgroup_size(1)
fn count() {
    let going = atomicLoad(&control[NEXT]);
    let shadows = atomicLoad(&control[SHADOWS]);
    atomicAdd(&control[SURFACE_RAYS], going);
    atomicAdd(&control[LIGHT_RAYS], shadows);
    atomicStore(&control[ACTIVE], going);
    atomicStore(&control[ACTIVE_SHADOWS], shadows);
    atomicStore(&control[NEXT], 0u);
    atomicStore(&control[SHADOWS], 0u);
    atomicAdd(&control[DEPTH], 1u);
    workgroups[0] = (going + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    workgroups[1] = 1u;
    workgroups[2] = 1u;
    workgroups[3] = (shadows + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    workgroups[4] = 1u;
    workgroups[5] = 1u;
}

/// Bits of a number that is none, in the second place of light whose hero is alone.
const HERO_ALONE = 0x7fc00000u;

/// Hands over what has arrived along each path.
@compute @workgroup_size(WORKGROUP_SIZE)
fn arrive(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if (i >= atomicLoad(&control[STARTED])) {
        return;
    }
    var light = load(LIGHT, i);
    if ((load(REST, i).y & 1u) != 0u) {
        light.y = HERO_ALONE;
    }
    arrivals[i] = light;
}
