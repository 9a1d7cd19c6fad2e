// Random numbers; photosite-transport's sampler/mod.rs, sampler/sobol.rs. Bit for bit those of the processor.

struct Sampler {
    /// Half of the key of the sequence.
    key: vec2<u32>,
    index: u32,
    /// Requests so far.
    dimension: u32,
}

fn permute(number: u32, key: u32) -> u32 {
    var x = number;
    x ^= x * 0x3d20adeau;
    x = x + key;
    x = x * ((key >> 16u) | 1u);
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

fn reversed_second_dimension(number: u32) -> u32 {
    var index = number;
    index ^= index >> 16u;
    index ^= (index >> 8u) & 0x00ff00ffu;
    index ^= (index >> 4u) & 0x0f0f0f0fu;
    index ^= (index >> 2u) & 0x33333333u;
    return index ^ ((index >> 1u) & 0x55555555u);
}

fn request_key(sampler: Sampler) -> vec2<u32> {
    return mix64(sampler.key ^ second_half(vec2<u32>(sampler.dimension, 0u)));
}

/// Both numbers of the current request.
fn numbers(sampler: Sampler) -> vec2<f32> {
    let key = request_key(sampler);
    if (params.sampler_kind == SAMPLER_INDEPENDENT) {
        let bits = mix64(first_half(key) ^ second_half(vec2<u32>(sampler.index, 0u)));
        return vec2<f32>(unit_f32(bits.x), unit_f32(bits.y));
    }
    let shuffled = reverseBits(permute(reverseBits(sampler.index), key.x));
    let first = reverseBits(permute(shuffled, key.y));
    let turned = (key.y << 16u) | (key.y >> 16u);
    let second = reverseBits(permute(reversed_second_dimension(shuffled), turned ^ 0x9e3779b9u));
    return vec2<f32>(unit_f32(first), unit_f32(second));
}

fn next_1d(sampler: ptr<function, Sampler>) -> f32 {
    (*sampler).dimension += 1u;
    return numbers(*sampler).x;
}

fn next_2d(sampler: ptr<function, Sampler>) -> vec2<f32> {
    (*sampler).dimension += 1u;
    return numbers(*sampler);
}

fn skip(sampler: ptr<function, Sampler>) {
    (*sampler).dimension += 1u;
}
