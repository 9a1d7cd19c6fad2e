// Thin films, with all interference; photosite-transport's bsdf/layered/thin_film.rs.

const FILM_LARGEST_F0 = 0.9999f;

/// Airy's sum for one polarisation, of the amplitude reflectances above and below the film.
fn airy(r1: f32, r2: vec4<f32>, cos_delta: vec4<f32>) -> vec4<f32> {
    let crossed = 2.0 * r1 * r2 * cos_delta;
    let a = r1 * r1;
    let b = r2 * r2;
    return (a + b + crossed) / (1.0 + a * b + crossed);
}

/// Cosine of so many turns.
fn cos_turns(turns: vec4<f32>) -> vec4<f32> {
    let u = fract(turns);
    return vec4<f32>(sin_cos_turn(u.x).y, sin_cos_turn(u.y).y, sin_cos_turn(u.z).y, sin_cos_turn(u.w).y);
}

/// Reflectance of the film on a base that reflects `f0` at normal incidence; `ThinFilm::reflectance`.
fn film_reflectance(cosine: f32, f0: vec4<f32>) -> vec4<f32> {
    let root = sqrt(clamp(f0, vec4<f32>(0.0), vec4<f32>(FILM_LARGEST_F0)));
    let base = (1.0 + root) / (1.0 - root);
    let n = layers.film_index;
    let sin_squared = max(1.0 - cosine * cosine, 0.0);
    let cos_film = sqrt(max(1.0 - sin_squared / (n * n), 0.0));
    let cos_base = sqrt(max(1.0 - sin_squared / (base * base), vec4<f32>(0.0)));
    let cos_delta = cos_turns(layers.film_waves * cos_film);
    // Along the surface itself the first amplitudes are 0/0 for a film of index 1.
    let c = max(cosine, 1e-6);
    let cf = max(cos_film, 1e-6);
    let s = airy((c - n * cf) / (c + n * cf), (n * cf - base * cos_base) / (n * cf + base * cos_base), cos_delta);
    let p = airy((n * c - cf) / (n * c + cf), (base * cf - n * cos_base) / (base * cf + n * cos_base), cos_delta);
    return clamp(0.5 * (s + p), vec4<f32>(0.0), vec4<f32>(1.0));
}
