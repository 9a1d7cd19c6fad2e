// Light from infinitely far; photosite-transport's light/environment.rs and photosite-core's math/distribution.rs.

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

fn density_at(start: u32, n: u32, x: f32) -> f32 {
    let piece = min(u32(x * f32(n)), n - 1u);
    return (cdf(start, piece + 1u) - cdf(start, piece)) * f32(n);
}

fn environment_uv(towards: vec3<f32>) -> vec2<f32> {
    let cosine = params.environment_cos;
    let sine = params.environment_sin;
    let x = cosine * towards.x - sine * towards.z;
    let z = sine * towards.x + cosine * towards.z;
    let uv = vec2<f32>(0.5 + atan2(x, -z) / TAU, acos(clamp(towards.y, -1.0, 1.0)) * FRAC_1_PI);
    return clamp(uv, vec2<f32>(0.0), vec2<f32>(0.99999988));
}

/// Radiance from a direction.
fn environment_radiance(towards: vec3<f32>, lambda_nm: vec4<f32>) -> vec4<f32> {
    if (params.environment == ENVIRONMENT_NOTHING) {
        return vec4<f32>(0.0);
    }
    let white = spectrum(params.environment_spectrum, lambda_nm);
    if (params.environment == ENVIRONMENT_CONSTANT) {
        return white;
    }
    return white * tint_spectrum(texture_srgb(params.environment_texture, environment_uv(towards)), lambda_nm);
}

/// A direction from where it is bright, with its density; 0 for none.
fn sample_environment(u: vec2<f32>) -> vec4<f32> {
    if (params.environment != ENVIRONMENT_IMAGE) {
        return vec4<f32>(0.0);
    }
    let row = sample_pieces(0u, params.environment_rows, u.y);
    let column = sample_pieces(start_of_row(row.index), params.environment_columns, u.x);
    let density = column.density * row.density;
    let theta = PI * row.x;
    let sin_theta = sin(theta);
    let phi = TAU * (column.x - 0.5);
    let x = sin_theta * sin(phi);
    let z = -sin_theta * cos(phi);
    let cosine = params.environment_cos;
    let sine = params.environment_sin;
    let direction = vec3<f32>(cosine * x + sine * z, cos(theta), cosine * z - sine * x);
    return vec4<f32>(direction, select(0.0, density / (TAU * PI * sin_theta), sin_theta > 0.0 && density > 0.0));
}

/// Density with which light sampling chooses a direction among those of the environment.
fn density_of_environment(towards: vec3<f32>) -> f32 {
    if (params.environment != ENVIRONMENT_IMAGE) {
        return 0.0;
    }
    let sine = length(towards.xz);
    if (sine == 0.0) {
        return 0.0;
    }
    let uv = environment_uv(towards);
    let row = min(u32(uv.y * f32(params.environment_rows)), params.environment_rows - 1u);
    let density = density_at(0u, params.environment_rows, uv.y) * density_at(start_of_row(row), params.environment_columns, uv.x);
    return density / (TAU * PI * sine);
}

/// Density with which light sampling finds the environment in a direction.
fn environment_pdf(ctx: LightContext, towards: vec3<f32>) -> f32 {
    if (params.environment_number == NONE) {
        return 0.0;
    }
    let probability = bitcast<f32>(tables[params.distant + params.environment_number].w);
    return density_of_environment(towards) * probability * part_of_distant(ctx);
}
