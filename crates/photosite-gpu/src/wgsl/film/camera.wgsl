// Rays of a lens; photosite-transport's optics/camera/ray.rs, with aperture.rs and stop.rs.

struct CameraRay {
    origin: vec3<f32>,
    direction: vec3<f32>,
    /// Weight of the radiance, sr; 0 where the place sees nothing.
    weight: f32,
}

/// Corner of the opening.
fn aperture_corner(number: u32) -> vec2<f32> {
    return film_tables[film.corners + number].xy;
}

/// Point of the opening, m.
fn aperture_point(u: vec2<f32>) -> vec2<f32> {
    if (film.blades == 0u) {
        return concentric_disk(u) * film.aperture_radius;
    }
    let scaled = u.x * f32(film.blades);
    let blade = min(floor(scaled), f32(film.blades) - 1.0);
    let b = uniform_triangle(vec2<f32>(scaled - blade, u.y));
    return aperture_corner(u32(blade)) * b.x + aperture_corner(u32(blade) + 1u) * b.y;
}

/// Whether all stops let light through that comes along a direction through a point of the opening.
fn passes_stops(chief: vec3<f32>, opening: vec2<f32>, towards: vec3<f32>) -> bool {
    // The image lies upside down behind the lens.
    let sensor = chief.xy * -film.image_distance;
    for (var i = 0u; i < film.stop_count; i++) {
        let stop = film_tables[film.stops + i];
        var at = opening + towards.xy * (stop.x / -towards.z);
        if (stop.x < 0.0) {
            at = mix(opening, sensor, -stop.x / film.image_distance);
        }
        if (dot(at, at) > stop.y * stop.y) {
            return false;
        }
    }
    return true;
}

/// Direction that a place sees, and the solid angle there.
struct SeenPlace {
    /// Unit direction.
    direction: vec3<f32>,
    /// Vector to the point in focus, in units of the focus distance.
    chief: vec3<f32>,
    /// Solid angle over area in normalised coordinates; of a lens that is focused on a plane, over cos³θ, too.
    solid_angle: f32,
}

/// What a place in a pixel sees.
fn seen_place(pixel: vec2<u32>, within: vec2<f32>) -> SeenPlace {
    if (film.lens_step == 0u) {
        // The whole part goes first, so that large images lose as little as can be of the place within a pixel.
        let about_centre = (vec2<f32>(pixel) - vec2<f32>(film.cx, film.cy)) + within;
        let y = about_centre.y / film.fy;
        let chief = vec3<f32>((about_centre.x - film.skew * y) / film.fx, -y, -1.0);
        return SeenPlace(normalize(chief), chief, 1.0);
    }
    let seen = table_sees(pixel, within);
    if (film.is_flat != 0u) {
        let chief = vec3<f32>(seen.xy, -1.0);
        return SeenPlace(normalize(chief), chief, seen.z);
    }
    let direction = normalize(seen.xyz);
    return SeenPlace(direction, direction, seen.w);
}

/// A point of the entrance pupil: across the axis, or turned about the centre on the shortest way to face a direction.
fn in_pupil(opening: vec2<f32>, direction: vec3<f32>) -> vec3<f32> {
    let point = vec3<f32>(opening, 0.0);
    if (film.is_flat != 0u) {
        return point * film.pupil_scale;
    }
    let ahead = vec3<f32>(0.0, 0.0, -1.0);
    let cosine = -direction.z;
    let axis = cross(ahead, direction);
    if (cosine < -0.9999995) {
        // Half a turn, about an axis of one's choice.
        return vec3<f32>(opening.x, -opening.y, 0.0);
    }
    return point * cosine + cross(axis, point) + axis * (dot(axis, point) / (1.0 + cosine));
}

/// Irradiance through a point of the opening over that through the centre on the axis.
fn lens_falloff(seen: SeenPlace, opening: vec2<f32>) -> f32 {
    if (film.falls_off == 0u) {
        return 1.0;
    }
    let across = opening + select(vec2<f32>(0.0), seen.chief.xy * film.perspective_distance, film.is_flat != 0u);
    let v2 = film.image_distance * film.image_distance;
    let cos2 = v2 / (v2 + dot(across, across));
    return cos2 * cos2 * seen.solid_angle;
}

/// Whether a pixel lies in the image circle.
fn sees_light(pixel: vec2<u32>) -> bool {
    if (film.has_circle == 0u) {
        return true;
    }
    let at = (vec2<f32>(pixel) + 0.5 - vec2<f32>(film.circle_x, film.circle_y))
        / vec2<f32>(film.circle_width, film.circle_height);
    return dot(at, at) <= 1.0;
}

/// Part of the image's time that has gone by when a row sees light. Of an odd number of rows from the middle on, the
/// middle one begins half a row before it.
fn time_of_row(row: u32, u: f32) -> f32 {
    if (film.has_times == 0u) {
        return film.time;
    }
    let below_first = f32(row) + 0.5 - film.first_row;
    let before = select(below_first, abs(below_first), film.first_row > 0.0) - 0.5;
    return before * film.row_time + u * film.exposure;
}

/// Axes of the camera in the world, and its origin.
struct Pose {
    axes: mat3x3<f32>,
    origin: vec3<f32>,
}

/// Pose at a part of the image's time; photosite-transport's optics/camera/pose_table.rs.
fn pose_at(time: f32) -> Pose {
    let steps = film.pose_count - 1u;
    let at = time * f32(steps);
    let step = min(u32(at), max(steps, 1u) - 1u);
    let first = film.poses + 4u * step;
    let x = film_tables[first].xyz;
    let y = film_tables[first + 1u].xyz;
    let z = film_tables[first + 2u].xyz;
    let origin = film_tables[first + 3u].xyz;
    if (steps == 0u) {
        return Pose(mat3x3<f32>(x, y, z), origin);
    }
    let t = at - f32(step);
    let axes = mat3x3<f32>(
        mix(x, film_tables[first + 4u].xyz, t), mix(y, film_tables[first + 5u].xyz, t),
        mix(z, film_tables[first + 6u].xyz, t),
    );
    return Pose(axes, mix(origin, film_tables[first + 7u].xyz, t));
}

/// Ray of a place in a pixel through the opening, at a part of the image's time.
fn camera_ray(pixel: vec2<u32>, within: vec2<f32>, u: vec2<f32>, time: f32) -> CameraRay {
    var ray: CameraRay;
    if (!sees_light(pixel)) {
        return ray;
    }
    let seen = seen_place(pixel, within);
    if (-seen.direction.z < film.reach_cos || length(seen.direction.xy) > film.reach_sin) {
        return ray;
    }
    var opening = vec2<f32>(0.0);
    if (film.aperture_radius > 0.0) {
        opening = aperture_point(u);
    }
    let origin = in_pupil(opening, seen.direction);
    let towards = seen.chief - origin * film.vergence;
    if (!passes_stops(seen.chief, opening, towards)) {
        return ray;
    }
    let pose = pose_at(time);
    ray.origin = pose.axes * origin + pose.origin;
    ray.direction = normalize(pose.axes * towards);
    ray.weight = film.sample_sr * lens_falloff(seen, opening);
    return ray;
}
