// What places of an image see, by a table; photosite-transport's optics/camera/lens_table.rs.

/// Weights of four nodes at 0, 1, 2 and 3 at a place between them.
fn node_weights(t: f32) -> vec4<f32> {
    let a = t - 1.0;
    let b = t - 2.0;
    let c = t - 3.0;
    return vec4<f32>(-a * b * c / 6.0, t * b * c / 2.0, -t * a * c / 2.0, t * a * b / 6.0);
}

/// What a place in a pixel sees: of a lens that is focused on a plane the point of the plane z = −1 and the solid angle
/// over cos³θ, of others the direction and the solid angle.
fn table_sees(pixel: vec2<u32>, within: vec2<f32>) -> vec4<f32> {
    let last = vec2<u32>(film.lens_columns, film.lens_rows) - NODES_ALONG;
    let start = min(max(pixel / film.lens_step, vec2<u32>(1u)) - 1u, last);
    // Whole pixels go first, and are few.
    let at = (vec2<f32>(vec2<i32>(pixel - start * film.lens_step)) + within) / f32(film.lens_step);
    let across = node_weights(at.x);
    let down = node_weights(at.y);
    var sum = vec4<f32>(0.0);
    for (var j = 0u; j < NODES_ALONG; j++) {
        let first = film.lens + (start.y + j) * film.lens_columns + start.x;
        let row = film_tables[first] * across.x + film_tables[first + 1u] * across.y + film_tables[first + 2u] * across.z
            + film_tables[first + 3u] * across.w;
        sum += row * down[j];
    }
    return sum;
}
