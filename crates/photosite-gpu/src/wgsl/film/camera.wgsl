// Rays of a rectilinear lens; photosite-transport's optics/camera/ray.rs, with aperture.rs and stop.rs.

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

/// Irradiance through a point of the opening over that through the centre on the axis.
fn lens_falloff(chief: vec3<f32>, opening: vec2<f32>) -> f32 {
    if (film.falls_off == 0u) {
        return 1.0;
    }
    let across = opening + chief.xy * film.perspective_distance;
    let v2 = film.image_distance * film.image_distance;
    let cos2 = v2 / (v2 + dot(across, across));
    return cos2 * cos2;
}

/// Ray of a place in a pixel through the opening.
fn camera_ray(pixel: vec2<u32>, within: vec2<f32>, u: vec2<f32>) -> CameraRay {
    // The whole part goes first, so that the place within a pixel keeps its bits.
    let about_centre = (vec2<f32>(pixel) - vec2<f32>(film.cx, film.cy)) + within;
    let y = about_centre.y / film.fy;
    let x = (about_centre.x - film.skew * y) / film.fx;
    let chief = vec3<f32>(x, -y, -1.0);
    var ray: CameraRay;
    if (inverseSqrt(dot(chief, chief)) < film.reach_cos) {
        return ray;
    }
    var opening = vec2<f32>(0.0);
    if (film.aperture_radius > 0.0) {
        opening = aperture_point(u);
    }
    let origin = vec3<f32>(opening * film.pupil_scale, 0.0);
    let towards = chief - origin * film.vergence;
    if (!passes_stops(chief, opening, towards)) {
        return ray;
    }
    let to_world = mat3x3<f32>(
        film.x_axis_x, film.x_axis_y, film.x_axis_z,
        film.y_axis_x, film.y_axis_y, film.y_axis_z,
        film.z_axis_x, film.z_axis_y, film.z_axis_z,
    );
    ray.origin = to_world * origin + vec3<f32>(film.origin_x, film.origin_y, film.origin_z);
    ray.direction = normalize(to_world * towards);
    ray.weight = film.sample_sr * lens_falloff(chief, opening);
    return ray;
}
