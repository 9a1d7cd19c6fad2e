// Distribution of the environment's samples over the unit square; photosite-core's math/distribution.rs.

/// A cumulative sum of the environment: of its rows, or of the columns of one.
fn cdf(start: u32, index: u32) -> f32 {
    return bitcast<f32>(attributes[params.environment_sums + start + index]);
}

fn start_of_row(row: u32) -> u32 {
    return params.environment_rows + 1u + row * (params.environment_columns + 1u);
}

struct Piece {
    x: f32,
    density: f32,
    index: u32,
}

/// A sample of a function that is constant on n pieces, by the inverse of its cumulative sums.
fn sample_pieces(start: u32, n: u32, u: f32) -> Piece {
    // The last piece whose sum of those before it is at most u
    var low = 0u;
    var high = n - 1u;
    while (low < high) {
        let middle = (low + high + 1u) / 2u;
        if (cdf(start, middle) <= u) {
            low = middle;
        } else {
            high = middle - 1u;
        }
    }
    while (low > 0u && cdf(start, low + 1u) == cdf(start, low)) {
        low -= 1u;
    }
    let before = cdf(start, low);
    let width = cdf(start, low + 1u) - before;
    let within = select(0.5, clamp((u - before) / width, 0.0, 0.99999988), width > 0.0);
    return Piece(min((f32(low) + within) / f32(n), BELOW_ONE), width * f32(n), low);
}

/// Density at x, of a function that is constant on n pieces.
fn density_at(start: u32, n: u32, x: f32) -> f32 {
    let piece = min(u32(x * f32(n)), n - 1u);
    return (cdf(start, piece + 1u) - cdf(start, piece)) * f32(n);
}

/// A point of the square.
fn sample_square(u: vec2<f32>) -> vec2<f32> {
    let row = sample_pieces(0u, params.environment_rows, u.y);
    return vec2<f32>(sample_pieces(start_of_row(row.index), params.environment_columns, u.x).x, row.x);
}

fn density_in_square(uv: vec2<f32>) -> f32 {
    let row = min(u32(uv.y * f32(params.environment_rows)), params.environment_rows - 1u);
    return density_at(0u, params.environment_rows, uv.y) * density_at(start_of_row(row), params.environment_columns, uv.x);
}
