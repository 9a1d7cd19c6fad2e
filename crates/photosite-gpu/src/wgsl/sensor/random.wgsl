// Random numbers of the sensor, bit for bit those of the processor: photosite-core's math/philox.rs and
// photosite-sensor's signal/noise_key.rs; normal and exponential numbers are those of rand_distr's ziggurats, with 56
// bits behind the point.

/// Stream of numbers: its key, what is counted, and the half of a block that is left.
struct Philox {
    key: vec2<u32>,
    counter: vec4<u32>,
    rest: vec2<u32>,
    has_rest: bool,
}

fn philox4x32_10(start: vec4<u32>, start_key: vec2<u32>) -> vec4<u32> {
    var counter = start;
    var key = start_key;
    for (var round = 0u; round < 10u; round += 1u) {
        let p0 = wide_product(0xd2511f53u, counter.x);
        let p1 = wide_product(0xcd9e8d57u, counter.z);
        counter = vec4<u32>(p1.y ^ counter.y ^ key.x, p1.x, p0.y ^ counter.w ^ key.y, p0.x);
        key += vec2<u32>(0x9e3779b9u, 0xbb67ae85u);
    }
    return counter;
}

/// First block of two neighbours, whose place is the number of their pair in its row, and the row.
fn first_block(streams: StreamWords, place: vec2<u32>) -> vec4<u32> {
    let key = vec2<u32>(streams.key_low, streams.key_high);
    return philox4x32_10(vec4<u32>(0u, 0u, place.x, place.y & streams.row_mask), key);
}

/// The stream of the first or the second of two neighbours, which share their first block.
fn stream_of(streams: StreamWords, place: vec2<u32>, block: vec4<u32>, index: u32) -> Philox {
    let key = vec2<u32>(streams.key_low, streams.key_high);
    let counter = vec4<u32>(0u, 1u + index, place.x, place.y & streams.row_mask);
    return Philox(key, counter, select(block.zw, block.xy, index == 0u), true);
}

/// The next 64 bits.
fn next_bits(random: ptr<function, Philox>) -> vec2<u32> {
    if ((*random).has_rest) {
        (*random).has_rest = false;
        return (*random).rest;
    }
    let block = philox4x32_10((*random).counter, (*random).key);
    (*random).counter.x += 1u;
    (*random).rest = block.zw;
    (*random).has_rest = true;
    return block.xy;
}

/// A uniform number from 0 to below 1, with 64 bits behind the point of which the first 53 count.
fn next_uniform(random: ptr<function, Philox>) -> vec2<u32> {
    let bits = next_bits(random);
    return vec2<u32>(bits.x & 0xfffff800u, bits.y);
}

/// A uniform number above 0 and below 1, likewise: odd multiples of 2⁻⁵³.
fn next_open_uniform(random: ptr<function, Philox>) -> vec2<u32> {
    let bits = next_bits(random);
    return vec2<u32>((bits.x & 0xfffff000u) | 0x800u, bits.y);
}

/// A number below 1 of 64 bits behind the point.
fn part_f32(x: vec2<u32>) -> f32 {
    return f32(x.y) * (1.0 / 4294967296.0) + f32(x.x >> 8u) * (1.0 / 72057594037927936.0);
}

/// Error of a density in single precision, of which drivers promise (3 + 2·x)·2⁻²³·e^(−x), at most 4e-7, and of what is
/// compared with it, with room for drivers that promise less.
const DENSITY_ERROR = 4e-6f;

/// Whether a point of a layer lies under the density e^(−x) of a fixed-point x. What single precision cannot tell is
/// found with all bits.
fn is_under(densities: u32, layer: u32, u: vec2<u32>, x: vec2<u32>) -> bool {
    let bottom = table_number(densities, layer);
    let top = table_number(densities, layer + 1u);
    // 63 bits behind the point
    let height = sum64(bottom, high_product(difference64(top, bottom), vec2<u32>(~u.x, ~u.y)));
    let over = f32(height.y) * (1.0 / 2147483648.0) - exp(-f32(x.y) * (1.0 / 16777216.0));
    if (abs(over) > DENSITY_ERROR) {
        return over < 0.0;
    }
    return is_less64(height, fixed_of(exponential_of(Signed(x, true)), 63));
}

/// End of the base of the ziggurat, R, and 1/R with 64 bits behind the point.
const NORMAL_END = vec2<u32>(0x4135a660u, 0x03a77690u);
const ONE_OVER_NORMAL_END = vec2<u32>(0x83a30395u, 0x460ea9b0u);
const EXPONENTIAL_END = vec2<u32>(0x5faee0c0u, 0x07b2764au);

/// A standard normal number.
fn next_normal(random: ptr<function, Philox>) -> Signed {
    var found = Signed(vec2<u32>(0u), false);
    loop {
        // u of −1 to 1 from 52 bits, x in a layer
        let bits = next_bits(random);
        let layer = bits.x & 0xffu;
        let is_negative = bits.y < 0x80000000u;
        let above = vec2<u32>(bits.x & 0xfffff000u, bits.y ^ 0x80000000u);
        let half = select(above, difference64(vec2<u32>(0u, 0x80000000u), vec2<u32>(above.x, bits.y)), is_negative);
        let u = select(raised64(half, 1u), vec2<u32>(0xffffffffu), half.y >= 0x80000000u);
        let x = high_product(u, table_number(NORMAL_EDGES, layer));
        found = Signed(x, is_negative);
        if (is_less64(x, table_number(NORMAL_EDGES, layer + 1u))) {
            break;
        }
        if (layer == 0u) {
            found.magnitude = next_of_tail(random);
            break;
        }
        let uniform = next_uniform(random);
        if (is_under(NORMAL_DENSITIES, layer, uniform, shifted64(fixed_product(x, x), 1u))) {
            break;
        }
    }
    return found;
}

/// A normal number beyond the base.
fn next_of_tail(random: ptr<function, Philox>) -> vec2<u32> {
    var x = vec2<u32>(0u);
    loop {
        x = high_product(minus_logarithm(next_open_uniform(random)), ONE_OVER_NORMAL_END);
        let y = minus_logarithm(next_open_uniform(random));
        if (!is_less64(raised64(y, 1u), fixed_product(x, x))) {
            break;
        }
    }
    return sum64(NORMAL_END, x);
}

/// An exponential number of mean 1.
fn next_exponential(random: ptr<function, Philox>) -> vec2<u32> {
    var x = vec2<u32>(0u);
    loop {
        let bits = next_bits(random);
        let layer = bits.x & 0xffu;
        let u = vec2<u32>((bits.x & 0xfffff000u) | 0x800u, bits.y);
        x = high_product(u, table_number(EXPONENTIAL_EDGES, layer));
        if (is_less64(x, table_number(EXPONENTIAL_EDGES, layer + 1u))) {
            break;
        }
        if (layer == 0u) {
            x = sum64(EXPONENTIAL_END, minus_logarithm(next_uniform(random)));
            break;
        }
        let uniform = next_uniform(random);
        if (is_under(EXPONENTIAL_DENSITIES, layer, uniform, x)) {
            break;
        }
    }
    return x;
}
