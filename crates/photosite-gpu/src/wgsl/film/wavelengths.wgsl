// Wavelengths of a path, drawn in proportion to their importance; photosite-core's spectrum/wavelength_sampler.rs.

struct DrawnWavelengths {
    lambda_nm: vec4<f32>,
    /// Monte Carlo weights, a quarter of the reciprocal of each density, nm.
    weights: vec4<f32>,
}

/// Piece of a density, whose pieces begin at a place, that a cumulative probability in [0, 1) falls into.
fn wavelength_piece(first: u32, u: f32) -> u32 {
    var low = 0u;
    var high = DENSITY_PIECES - 1u;
    while (low + 1u < high) {
        let middle = (low + high) / 2u;
        if (film_tables[first + middle].x <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

/// Four wavelengths from one number, for a pixel of the image.
fn sample_wavelengths(pixel: vec2<u32>, u: f32) -> DrawnWavelengths {
    let at = vec2<u32>(pixel.x % film.tile_width, pixel.y % film.tile_height);
    let density = u32(film_tables[film.tile + at.y * film.tile_width + at.x].x);
    let first = film.densities + density * DENSITY_PIECES;
    var drawn: DrawnWavelengths;
    for (var lane = 0u; lane < 4u; lane++) {
        let shifted = u + f32(lane) * 0.25;
        let own = select(shifted, shifted - 1.0, shifted >= 1.0);
        let number = wavelength_piece(first, own);
        let piece = film_tables[first + number];
        drawn.lambda_nm[lane] = LAMBDA_MIN_NM + f32(number) + min((own - piece.x) * piece.z, 1.0);
        drawn.weights[lane] = 0.25 * piece.z;
    }
    return drawn;
}

/// Transmittance of the lens.
fn lens_transmittance(lambda_nm: vec4<f32>) -> vec4<f32> {
    var values: vec4<f32>;
    for (var lane = 0u; lane < 4u; lane++) {
        let x = lambda_nm[lane] - LAMBDA_MIN_NM;
        let entry = min(u32(x), SPECTRUM_ENTRIES - 2u);
        let low = film_tables[film.transmittance + entry].x;
        let high = film_tables[film.transmittance + entry + 1u].x;
        values[lane] = low + (high - low) * (x - f32(entry));
    }
    return values;
}
