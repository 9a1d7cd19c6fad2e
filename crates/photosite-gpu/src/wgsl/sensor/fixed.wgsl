// Integers of 64 bits as pairs, the lower half first, and what numbers of more bits than an f32 are made of:
// fixed-point numbers with 56 bits behind the point, and `Wide` ones (photosite-sensor's signal/words.rs). Nothing here
// is left to how a driver rounds.

/// A number of less than 128 with 56 bits behind the point, and its sign.
struct Signed {
    magnitude: vec2<u32>,
    is_negative: bool,
}

fn difference64(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return vec2<u32>(a.x - b.x, a.y - b.y - select(0u, 1u, a.x < b.x));
}

fn is_less64(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

/// a·2^bits, of 0 bits or more; what does not fit is lost.
fn raised64(a: vec2<u32>, bits: u32) -> vec2<u32> {
    if (bits >= 64u) {
        return vec2<u32>(0u);
    }
    if (bits >= 32u) {
        return vec2<u32>(0u, a.x << (bits - 32u));
    }
    if (bits == 0u) {
        return a;
    }
    return vec2<u32>(a.x << bits, (a.y << bits) | (a.x >> (32u - bits)));
}

/// The whole part of a/2^bits, of 0 bits or more.
fn lowered64(a: vec2<u32>, bits: u32) -> vec2<u32> {
    if (bits >= 64u) {
        return vec2<u32>(0u);
    }
    if (bits >= 32u) {
        return vec2<u32>(a.y >> (bits - 32u), 0u);
    }
    if (bits == 0u) {
        return a;
    }
    return shifted64(a, bits);
}

/// The upper 64 of the 128 bits of a product, to 2 in the last place.
fn high_product(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let first = wide_product(a.x, b.y);
    let second = wide_product(a.y, b.x);
    let low = first.x + second.x;
    let carry = select(0u, 1u, low < first.x);
    let middle = sum64(vec2<u32>(first.y, 0u), vec2<u32>(second.y + carry, 0u));
    return sum64(wide_product(a.y, b.y), middle);
}

/// m·2^(exponent − 64) with its highest bit set.
fn wide_of(m: vec2<u32>, exponent: i32) -> Wide {
    if ((m.x | m.y) == 0u) {
        return Wide(0u, 0u, 0);
    }
    let zeros = select(countLeadingZeros(m.y), 32u + countLeadingZeros(m.x), m.y == 0u);
    let raised = raised64(m, zeros);
    return Wide(raised.y, raised.x, exponent - i32(zeros));
}

/// The magnitude of an f32; one below its normal range is 0.
fn wide_of_f32(x: f32) -> Wide {
    let bits = bitcast<u32>(x);
    let exponent = (bits >> 23u) & 0xffu;
    if (exponent == 0u) {
        return Wide(0u, 0u, 0);
    }
    return Wide((bits << 8u) | 0x80000000u, 0u, i32(exponent) - 126);
}

/// The nearest f32, the even one of two.
fn nearest_f32(a: Wide) -> f32 {
    if (a.high == 0u || a.exponent < -125) {
        return 0.0;
    }
    if (a.exponent > 128) {
        return 3.4028235e38f;
    }
    // 24 bits stay, the first of which is that of the exponent
    var kept = a.high >> 8u;
    let rest = a.high & 0xffu;
    let is_above = rest > 0x80u || (rest == 0x80u && (a.low != 0u || (kept & 1u) == 1u));
    kept += select(0u, 1u, is_above);
    return bitcast<f32>((u32(a.exponent + 125) << 23u) + kept);
}

fn wide_product_of(a: Wide, b: Wide) -> Wide {
    return wide_of(high_product(vec2<u32>(a.low, a.high), vec2<u32>(b.low, b.high)), a.exponent + b.exponent);
}

/// The number with so many bits behind the point; the largest of 64 bits where it does not fit.
fn fixed_of(a: Wide, bits: i32) -> vec2<u32> {
    let lowered = 64 - a.exponent - bits;
    if (lowered < 0 && a.high != 0u) {
        return vec2<u32>(0xffffffffu);
    }
    return lowered64(vec2<u32>(a.low, a.high), u32(max(lowered, 0)));
}

fn fixed_product(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    return raised64(high_product(a, b), 8u);
}

/// Sum of a and b where they have one sign, else their difference.
fn signed_sum(a: Signed, b: Signed) -> Signed {
    if (a.is_negative == b.is_negative) {
        return Signed(sum64(a.magnitude, b.magnitude), a.is_negative);
    }
    if (is_less64(a.magnitude, b.magnitude)) {
        return Signed(difference64(b.magnitude, a.magnitude), b.is_negative);
    }
    return Signed(difference64(a.magnitude, b.magnitude), a.is_negative);
}

fn signed_f32(a: Signed) -> f32 {
    let magnitude = nearest_f32(wide_of(a.magnitude, 8));
    return select(magnitude, -magnitude, a.is_negative);
}

/// A number of a table of random.wgsl.
fn table_number(place: u32, index: u32) -> vec2<u32> {
    let at = place + 2u * index;
    return vec2<u32>(random_tables[at], random_tables[at + 1u]);
}

const LN_2 = vec2<u32>(0xf7d1cf79u, 0x00b17217u);

/// e^x, to 2⁻⁵⁰ of it: 2^k·e^r with r from 0 to ln 2, and e^r from two tables and a series.
fn exponential_of(x: Signed) -> Wide {
    let magnitude = f32(x.magnitude.y) * (1.0 / 16777216.0);
    var power = i32(floor(select(magnitude, -magnitude, x.is_negative) * 1.442695f));
    let whole = product64(vec2<u32>(u32(abs(power)), 0u), LN_2);
    var rest = signed_sum(x, Signed(whole, power >= 0));
    if (rest.is_negative) {
        power -= 1;
        rest = signed_sum(rest, Signed(LN_2, false));
    }
    let r = rest.magnitude;
    let coarse = table_number(COARSE_POWERS, r.y >> 19u);
    let fine = table_number(FINE_POWERS, (r.y >> 14u) & 31u);
    // e^b − 1 of the rest b, which is less than 2⁻¹⁰, with all 64 bits behind the point
    let b = raised64(vec2<u32>(r.x, r.y & 0x3fffu), 8u);
    let b_f32 = f32(b.y) * (1.0 / 4294967296.0);
    let cubic = b_f32 * b_f32 * b_f32 * (1.0 / 6.0 + b_f32 * (1.0 / 24.0));
    let tail = vec2<u32>(u32(cubic * 4294967296.0 * 4294967296.0), 0u);
    let more = sum64(sum64(b, shifted64(high_product(b, b), 1u)), tail);
    // 62 bits behind the point in both tables, 60 in their product
    let product = high_product(coarse, fine);
    return wide_of(sum64(product, high_product(product, more)), 4 + power);
}

/// −ln u for 0 < u < 1 with 64 bits behind the point, to 2⁻⁴⁰: a driver's logarithm, and what is left of u·e^(−ln u).
fn minus_logarithm(u: vec2<u32>) -> vec2<u32> {
    let wide = wide_of(u, 0);
    let first = fixed_of(wide_of_f32(max(-log(nearest_f32(wide)), 1e-30)), 56);
    let one = wide_product_of(wide, exponential_of(Signed(first, false)));
    // 63 bits behind the point
    let found = fixed_of(one, 63);
    let unit = vec2<u32>(0u, 0x80000000u);
    let is_below = is_less64(found, unit);
    let left = shifted64(select(difference64(found, unit), difference64(unit, found), is_below), 7u);
    return signed_sum(Signed(first, false), Signed(left, !is_below)).magnitude;
}
