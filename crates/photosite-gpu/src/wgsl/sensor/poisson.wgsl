// Counts of electrons; photosite-sensor's stages/shot_noise.rs, and the algorithm of Ahrens and Dieter 1982 (ACM Trans.
// Math. Softw. 8, 163) as rand_distr has it. Where a count is cut off, numbers have 32 bits behind the point; where
// a candidate is taken or not, the difference of two densities is written without what cancels, so that single
// precision decides otherwise for one electron in some ten millions.

/// A count at a distance from the mean.
struct Candidate {
    count: f32,
    /// Mean less the count.
    rest: f32,
    is_negative: bool,
}

/// Root of a number with 63 bits behind the point times 2^power, to 2⁻⁴⁵ of it.
struct Root {
    significand: vec2<u32>,
    power: i32,
}

fn root_of(a: Wide) -> Root {
    // A fraction of 1/4 and more, below 1, of an even exponent
    let odd = u32(a.exponent & 1);
    let m = lowered64(vec2<u32>(a.low, a.high), odd);
    // What single precision finds, and what its square misses over twice itself
    let first = u32(min(sqrt(f32(m.y) * (1.0 / 4294967296.0)), 0.99999994f) * 4294967296.0);
    let square = wide_product(first, first);
    let is_above = is_less64(m, square);
    let missed = select(difference64(m, square), difference64(square, m), is_above);
    let correction = (f32(missed.y) * 4294967296.0 + f32(missed.x)) / (2.0 * f32(first));
    // Half of it in the last place of 63 bits: first has 32, the correction 16 more
    let more = raised64(vec2<u32>(u32(correction * 65536.0), 0u), 15u);
    let root = raised64(vec2<u32>(first, 0u), 31u);
    return Root(select(sum64(root, more), difference64(root, more), is_above), (a.exponent + i32(odd)) / 2);
}

/// The whole part of mean + root·t.
fn candidate(mean: Wide, root: Root, t: Signed) -> Candidate {
    if (mean.exponent > 31) {
        // More than 2³¹ electrons, of which an f32 holds hundreds
        let most = nearest_f32(mean);
        let moved = sqrt(most) * signed_f32(t);
        return Candidate(floor(most + moved), -moved, false);
    }
    // 55 bits behind the point in the product, 32 in what is left of it
    let distance = lowered64(high_product(root.significand, t.magnitude), u32(23 - root.power));
    let m = fixed_of(mean, 32);
    if (t.is_negative && is_less64(m, distance)) {
        return Candidate(0.0, 0.0, true);
    }
    let count = select(sum64(m, distance), difference64(m, distance), t.is_negative).y;
    let above = m.y >= count;
    let rest = select(difference64(vec2<u32>(0u, count), m), difference64(m, vec2<u32>(0u, count)), above);
    let size = nearest_f32(wide_of(rest, 32));
    return Candidate(f32(count), select(-size, size, above), false);
}

/// Density of the count against that of the normal distribution.
struct Densities {
    /// Their ratio less 1.
    surplus: f32,
    /// Density of the normal distribution over that of its middle, and its logarithm without the polynomial.
    polynomial: f32,
    exponent: f32,
}

const FACTORIALS = array<f32, 10>(1.0, 1.0, 2.0, 6.0, 24.0, 120.0, 720.0, 5040.0, 40320.0, 362880.0);

/// e^x − 1.
fn exponential_less_1(x: f32) -> f32 {
    if (abs(x) > 0.3) {
        return exp(x) - 1.0;
    }
    let beyond_cubic = x * (1.0 / 24.0 + x * (1.0 / 120.0 + x * (1.0 / 720.0 + x / 5040.0)));
    return x * (1.0 + x * (1.0 / 2.0 + x * (1.0 / 6.0 + beyond_cubic)));
}

fn densities_at(at: Candidate, mean: Wide) -> Densities {
    let lambda = nearest_f32(mean);
    let k = at.count;
    let w = at.rest;
    let b1 = 1.0 / (24.0 * lambda);
    let b2 = 0.3 * b1 * b1;
    let c3 = b1 * b2 / 7.0;
    let c2 = b2 - 15.0 * c3;
    let c1 = b1 - 6.0 * b2 + 45.0 * c3;
    let c0_less_1 = -b1 + 3.0 * b2 - 15.0 * c3;
    let x = (0.5 - w) / sqrt(lambda);
    let x2 = x * x;
    let polynomial_less_1 = ((c3 * x2 + c2) * x2 + c1) * x2 + c0_less_1;
    var densities = Densities(0.0, 1.0 + polynomial_less_1, -0.5 * x2);
    if (k < 10.0) {
        // λ^k·e^(−λ)/k!, over ω·(c₀ + c₁·x² + …)·e^(−x²/2)
        var poisson = nearest_f32(exponential_of(Signed(fixed_of(mean, 56), true))) / FACTORIALS[u32(k)];
        for (var i = 0.0; i < k; i += 1.0) {
            poisson *= lambda;
        }
        let normal = densities.polynomial * exp(densities.exponent) / sqrt(6.2831853f * lambda);
        densities.surplus = poisson / normal - 1.0;
        return densities;
    }
    let v = w / k;
    let twelfth = 1.0 / (12.0 * k);
    let delta = twelfth - 4.8 * twelfth * twelfth * twelfth;
    var logarithm: f32;
    if (abs(v) <= 0.25) {
        // k·v²·Σ aᵢ·vⁱ + x²/2, of which k·v²/2 and w²/(2λ) cancel
        let series = 0.3333333343 + v * (-0.2499998565 + v * (0.1999997049 + v * (-0.1666848753 + v * (0.1428833286
            + v * (-0.1241963125 + v * (0.1101687109 + v * (-0.1142650302 + v * 0.1055093006)))))));
        let cubic = w * v * v * series - w * v * w / (2.0 * lambda);
        logarithm = cubic - w / (2.0 * lambda) + 1.0 / (8.0 * lambda) - delta;
    } else {
        logarithm = k * log(1.0 + v) - w - delta + 0.5 * x2;
    }
    // √(λ/k)·e^logarithm over the polynomial
    let a = v / (1.0 + sqrt(1.0 + v));
    let b = exponential_less_1(logarithm);
    densities.surplus = (a + b + a * b - polynomial_less_1) / densities.polynomial;
    return densities;
}

/// The number of uniform factors until their product passes e^(−mean), with all bits.
fn few(e_to_minus_mean: vec2<u32>, random: ptr<function, Philox>) -> f32 {
    var count = 0.0;
    var product = next_uniform(random);
    while (is_less64(e_to_minus_mean, product)) {
        product = high_product(product, next_uniform(random));
        count += 1.0;
    }
    return count;
}

/// 1.8 with 56 bits behind the point.
const SHIFT = vec2<u32>(0xcccccccdu, 0x01ccccccu);

/// A count of a mean of 12 or more.
fn many(mean: Wide, random: ptr<function, Philox>) -> f32 {
    let root = root_of(mean);
    let lambda = nearest_f32(mean);
    // A normal number that is cut off: all counts above the mean less 1.1484 are taken, and those that the normal
    // distribution has not too many of
    let first = candidate(mean, root, next_normal(random));
    if (!first.is_negative) {
        if (first.rest < 2.1484) {
            return first.count;
        }
        let u = part_f32(next_uniform(random));
        let scaled = first.rest / sqrt(lambda);
        if (6.0 * sqrt(lambda) * u >= scaled * scaled * scaled) {
            return first.count;
        }
        if (u >= -densities_at(first, mean).surplus) {
            return first.count;
        }
    }
    // From what the normal distribution lacks
    var count = 0.0;
    loop {
        let e = next_exponential(random);
        let uniform = next_uniform(random);
        let is_below = uniform.y < 0x80000000u;
        let u = abs(2.0 * part_f32(uniform) - 1.0);
        let t = signed_sum(Signed(SHIFT, false), Signed(e, is_below));
        if (signed_f32(t) > -0.6744) {
            let second = candidate(mean, root, t);
            let densities = densities_at(second, mean);
            let power = exp(densities.exponent + signed_f32(Signed(e, false)));
            let size = densities.polynomial * power / sqrt(6.2831853f * lambda);
            if (0.1069 / lambda * u <= size * densities.surplus) {
                count = second.count;
                break;
            }
        }
    }
    return count;
}

fn is_few(mean: Wide) -> bool {
    return mean.exponent < 4 || (mean.exponent == 4 && mean.high < 0xc0000000u);
}

/// e^(−mean) of few electrons with 64 bits behind the point.
fn e_to_minus(mean: Wide) -> vec2<u32> {
    return fixed_of(exponential_of(Signed(fixed_of(mean, 56), true)), 64);
}

/// A Poisson-distributed number of a mean, with e^(−mean) where that is small.
fn counted(mean: Wide, e_to_minus_mean: vec2<u32>, random: ptr<function, Philox>) -> f32 {
    if (mean.high == 0u) {
        return 0.0;
    }
    if (is_few(mean)) {
        return few(e_to_minus_mean, random);
    }
    return many(mean, random);
}
