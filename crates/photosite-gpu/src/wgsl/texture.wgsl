// Images on surfaces; photosite-transport's texture/mod.rs, texture/sampler.rs, texture/bitmap.rs.

fn decode_srgb(encoded: f32) -> f32 {
    return select(pow((encoded + 0.055) / 1.055, 2.4), encoded / 12.92, encoded <= 0.04045);
}

/// A texel with R, G, B decoded from sRGB, unless it is of floats.
fn texel_srgb(first: u32, index: u32, form: u32) -> vec3<f32> {
    if (form == 2u) {
        let at = first + 3u * index;
        return bitcast<vec3<f32>>(vec3<u32>(texels[at], texels[at + 1u], texels[at + 2u]));
    }
    var encoded: vec3<f32>;
    if (form == 0u) {
        let bits = texels[first + index];
        encoded = vec3<f32>(f32(bits & 255u), f32((bits >> 8u) & 255u), f32((bits >> 16u) & 255u)) * (1.0 / 255.0);
    } else {
        let at = first + 2u * index;
        let low = texels[at];
        encoded = vec3<f32>(f32(low & 65535u), f32(low >> 16u), f32(texels[at + 1u] & 65535u)) * (1.0 / 65535.0);
    }
    return vec3<f32>(decode_srgb(encoded.x), decode_srgb(encoded.y), decode_srgb(encoded.z));
}

/// A coordinate in periods → one in texels, brought into the first period.
fn wrapped_position(wrap: u32, u: f32, size: u32) -> f32 {
    let n = f32(size);
    if (wrap == 0u) {
        return (u - floor(u)) * n;
    }
    if (wrap == 1u) {
        return (u - 2.0 * floor(0.5 * u)) * n;
    }
    return clamp(u, 0.0, 1.0) * n;
}

/// Index of a texel for a neighbour of the first period.
fn wrapped_index(wrap: u32, index: i32, size: u32) -> u32 {
    let n = i32(size);
    if (wrap == 0u) {
        return u32(select(select(index, index - n, index >= n), index + n, index < 0));
    }
    if (wrap == 1u) {
        let i = select(index, -1 - index, index < 0);
        return u32(select(max(2 * n - 1 - i, 0), i, i < n));
    }
    return u32(clamp(index, 0, n - 1));
}

/// Texels before and after a coordinate, and where between them it lies.
struct Tap {
    before: u32,
    after: u32,
    within: f32,
}

fn tap(wrap: u32, is_nearest: bool, u: f32, size: u32) -> Tap {
    let position = wrapped_position(wrap, u, size);
    if (is_nearest) {
        let index = wrapped_index(wrap, i32(floor(position)), size);
        return Tap(index, index, 0.0);
    }
    let x = position - 0.5;
    let i = floor(x);
    return Tap(wrapped_index(wrap, i32(i), size), wrapped_index(wrap, i32(i) + 1, size), x - i);
}

/// A texel as it is stored, 0–1 of integers.
fn texel_linear(first: u32, index: u32, form: u32) -> vec4<f32> {
    if (form == 2u) {
        return vec4<f32>(texel_srgb(first, index, form), 1.0);
    }
    if (form == 0u) {
        return vec4<f32>((vec4<u32>(texels[first + index]) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u)) * (1.0 / 255.0);
    }
    let at = first + 2u * index;
    let both = vec2<u32>(texels[at], texels[at + 1u]);
    return vec4<f32>(vec4<u32>(both.x & 65535u, both.x >> 16u, both.y & 65535u, both.y >> 16u)) * (1.0 / 65535.0);
}

/// The four texels around a point of a texture, and where between them it lies.
struct Taps {
    indices: vec4<u32>,
    within: vec2<f32>,
    first: u32,
    form: u32,
}

fn taps(texture: u32, surface_uv: vec2<f32>) -> Taps {
    let at = params.textures + texture * TEXTURE_WORDS;
    let image = tables[at];
    let matrix = bitcast<vec4<f32>>(tables[at + 1u]);
    let offset = bitcast<vec2<f32>>(tables[at + 2u].xy);
    let uv = matrix.xy * surface_uv.x + matrix.zw * surface_uv.y + offset;
    let is_nearest = ((image.w >> 2u) & 1u) == 1u;
    let x = tap((image.w >> 4u) & 3u, is_nearest, uv.x, image.y);
    let y = tap((image.w >> 6u) & 3u, is_nearest, uv.y, image.z);
    let rows = vec2<u32>(y.before, y.after) * image.y;
    let indices = vec4<u32>(rows.x + x.before, rows.x + x.after, rows.y + x.before, rows.y + x.after);
    return Taps(indices, vec2<f32>(x.within, y.within), image.x, image.w & 3u);
}

/// Linear RGB of a texture at texture coordinates of the surface.
fn texture_srgb(texture: u32, surface_uv: vec2<f32>) -> vec3<f32> {
    let found = taps(texture, surface_uv);
    let a = texel_srgb(found.first, found.indices.x, found.form);
    if (found.indices.x == found.indices.w) {
        return a;
    }
    let b = texel_srgb(found.first, found.indices.y, found.form);
    let c = texel_srgb(found.first, found.indices.z, found.form);
    let d = texel_srgb(found.first, found.indices.w, found.form);
    let upper = a + (b - a) * found.within.x;
    let lower = c + (d - c) * found.within.x;
    return upper + (lower - upper) * found.within.y;
}

/// RGBA of a texture at texture coordinates of the surface, as it is stored.
fn texture_linear(texture: u32, surface_uv: vec2<f32>) -> vec4<f32> {
    let found = taps(texture, surface_uv);
    let a = texel_linear(found.first, found.indices.x, found.form);
    let b = texel_linear(found.first, found.indices.y, found.form);
    let c = texel_linear(found.first, found.indices.z, found.form);
    let d = texel_linear(found.first, found.indices.w, found.form);
    let upper = a + (b - a) * found.within.x;
    let lower = c + (d - c) * found.within.x;
    return upper + (lower - upper) * found.within.y;
}

fn texture_set(texture: u32) -> u32 {
    return tables[params.textures + texture * TEXTURE_WORDS + 2u].z;
}
