// Integer hashing; photosite-core's math/hash.rs. Numbers of 64 bits are pairs, the lower half first.

/// Product of two numbers of 32 bits.
fn wide_product(a: u32, b: u32) -> vec2<u32> {
    let a0 = a & 0xffffu;
    let a1 = a >> 16u;
    let b0 = b & 0xffffu;
    let b1 = b >> 16u;
    let low = a0 * b0;
    let middle = a1 * b0 + (low >> 16u);
    let other = a0 * b1 + (middle & 0xffffu);
    return vec2<u32>((other << 16u) | (low & 0xffffu), a1 * b1 + (middle >> 16u) + (other >> 16u));
}

fn product64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = wide_product(a.x, b.x);
    return vec2<u32>(low.x, low.y + a.x * b.y + a.y * b.x);
}

fn sum64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let low = a.x + b.x;
    return vec2<u32>(low, a.y + b.y + select(0u, 1u, low < a.x));
}

/// A shift by 1 to 31 bits.
fn shifted64(a: vec2<u32>, bits: u32) -> vec2<u32> {
    return vec2<u32>((a.x >> bits) | (a.y << (32u - bits)), a.y >> bits);
}

const GOLDEN = vec2<u32>(0x7f4a7c15u, 0x9e3779b9u);

fn mix64(a: vec2<u32>) -> vec2<u32> {
    var x = product64(a ^ shifted64(a, 30u), vec2<u32>(0x1ce4e5b9u, 0xbf58476du));
    x = product64(x ^ shifted64(x, 27u), vec2<u32>(0x133111ebu, 0x94d049bbu));
    return x ^ shifted64(x, 31u);
}

fn first_half(a: vec2<u32>) -> vec2<u32> {
    return product64(sum64(a, GOLDEN), vec2<u32>(0x6659fd93u, 0xd6e8feb8u));
}

fn second_half(b: vec2<u32>) -> vec2<u32> {
    return mix64(sum64(b, GOLDEN));
}

fn hash64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return mix64(first_half(a) ^ second_half(b));
}

/// The top 24 bits as a number in [0, 1).
fn unit_f32(x: u32) -> f32 {
    return f32(x >> 8u) * (1.0 / 16777216.0);
}
