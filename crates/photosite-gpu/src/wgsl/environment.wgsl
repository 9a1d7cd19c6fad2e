// Light from infinitely far; photosite-transport's light/environment.rs.

fn environment_uv(towards: vec3<f32>) -> vec2<f32> {
    let cosine = params.environment_cos;
    let sine = params.environment_sin;
    let x = cosine * towards.x - sine * towards.z;
    let z = sine * towards.x + cosine * towards.z;
    let uv = vec2<f32>(0.5 + arc_tangent(x, -z) / TAU, arc_cosine(clamp(towards.y, -1.0, 1.0)) * FRAC_1_PI);
    return clamp(uv, vec2<f32>(0.0), vec2<f32>(0.99999988));
}

/// Radiance from a direction.
fn environment_radiance(towards: vec3<f32>, lambda_nm: vec4<f32>) -> vec4<f32> {
    switch params.environment {
        case ENVIRONMENT_CONSTANT: { return spectrum(params.environment_spectrum, lambda_nm); }
        case ENVIRONMENT_IMAGE: {
            let rgb = texture_srgb(params.environment_texture, environment_uv(towards));
            return spectrum(params.environment_spectrum, lambda_nm) * tint_spectrum(rgb, lambda_nm);
        }
        case ENVIRONMENT_SKY: { return sky_radiance(towards, lambda_nm); }
        default: { return vec4<f32>(0.0); }
    }
}

/// A direction from where an image is bright, with its density; 0 for none.
fn sample_environment_image(u: vec2<f32>) -> vec4<f32> {
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

/// A direction from where it is bright, with its density; 0 for none.
fn sample_environment(u: vec2<f32>) -> vec4<f32> {
    switch params.environment {
        case ENVIRONMENT_IMAGE: { return sample_environment_image(u); }
        case ENVIRONMENT_SKY: { return sample_sky(u); }
        default: { return vec4<f32>(0.0); }
    }
}

fn density_of_environment_image(towards: vec3<f32>) -> f32 {
    let sine = length(towards.xz);
    if (sine == 0.0) {
        return 0.0;
    }
    return density_in_square(environment_uv(towards)) / (TAU * PI * sine);
}

/// Density with which light sampling chooses a direction among those of the environment.
fn density_of_environment(towards: vec3<f32>) -> f32 {
    switch params.environment {
        case ENVIRONMENT_IMAGE: { return density_of_environment_image(towards); }
        case ENVIRONMENT_SKY: { return density_of_sky(towards); }
        default: { return 0.0; }
    }
}

/// Density with which light sampling finds the environment in a direction.
fn environment_pdf(ctx: LightContext, towards: vec3<f32>) -> f32 {
    if (params.environment_number == NONE) {
        return 0.0;
    }
    let probability = bitcast<f32>(tables[params.distant + params.environment_number].w);
    return density_of_environment(towards) * probability * part_of_distant(ctx);
}
