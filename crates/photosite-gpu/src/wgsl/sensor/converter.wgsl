// From signals to digital numbers; photosite-sensor's stages/converter.rs, dual_gain.rs, defective_numbers.rs,
// digital_gain.rs, companding.rs.

/// A signal as a whole number below it and the rest, 0 to 1.
struct Level {
    whole: i32,
    part: f32,
}

/// Beyond this, in DN, a signal is at an end of any converter.
const FAR_DN = 1048576.0;

fn level_of(signal_dn: f32) -> Level {
    let within = clamp(signal_dn, -FAR_DN, FAR_DN);
    let whole = floor(within);
    return Level(i32(whole), within - whole);
}

/// gain·charge with all bits.
fn product_level(gain: Wide, charge_e: f32) -> Level {
    let size = wide_product_of(gain, wide_of_f32(charge_e));
    // 32 bits behind the point; beyond the range of any converter the largest number
    let fixed = fixed_of(size, 32);
    let whole = i32(min(fixed.y, u32(FAR_DN)));
    let part = f32(fixed.x) * (1.0 / 4294967296.0);
    if (charge_e >= 0.0) {
        return Level(whole, part);
    }
    return Level(-whole - 1, 1.0 - part);
}

/// Displacement of the threshold below a number, DN.
fn displacement(converter: DigitiserWords, x: u32, number: i32) -> f32 {
    let key = vec2<u32>(converter.key_low, converter.key_high);
    let own = hash64(key, vec2<u32>(select(0u, x + 1u, converter.per_column == 1u), 0u));
    let random = hash64(own, vec2<u32>(u32(number), select(0u, 0xffffffffu, number < 0)));
    return converter.displacement_dn * (2.0 * unit_f32(random.y) - 1.0);
}

/// Digital number of a signal.
fn digital_number(converter: DigitiserWords, signal: Level, x: u32) -> u32 {
    let whole = signal.whole + i32(converter.black_level_dn);
    var part = signal.part;
    var number = whole;
    if (converter.is_nonlinear == 1u) {
        let share = (f32(whole) + part) / f32(converter.max_dn);
        if (whole >= 0 && share < 1.0) {
            part += converter.inl_dn * 4.0 * share * (1.0 - share);
        }
        let nearest = floor(part + 0.5);
        number = whole + i32(nearest);
        let rest = part - nearest;
        if (rest < displacement(converter, x, number) - 0.5) {
            number -= 1;
        } else if (rest >= 0.5 + displacement(converter, x, number + 1)) {
            number += 1;
        }
    } else if (part >= 0.5) {
        number += 1;
    }
    return u32(clamp(number, 0, i32(converter.max_dn)));
}

/// Charge of the first or the second neighbour with the noise of a branch, whose normal numbers are those of a stage.
fn branch_charge(branch: BranchWords, stage: u32, charge_e: f32, index: u32) -> f32 {
    if (branch.streams.is_there == 0u) {
        return charge_e;
    }
    var spread = vec2<f32>(branch.read_noise_e);
    if (branch.factors.streams.is_there == 1u) {
        spread = rounded_product(spread, vec2<f32>(nearest_f32(factor(branch.factors, OF_READ_NOISE_SPREAD, index))));
    }
    return rounded_sum(vec2<f32>(charge_e), rounded_product(spread, normals(stage)))[index];
}

/// Merged number of both gains.
fn merged_number(charge_e: f32, x: u32) -> u32 {
    var branch = exposure.dual_gain.high;
    var number = 0u;
    for (var i = 0u; i < 2u; i += 1u) {
        let noisy_e = branch_charge(branch, OF_READ_NOISE + i, charge_e, x % 2u);
        number = digital_number(branch.digitiser, product_level(branch.system_gain, noisy_e), x);
        if (i == 0u && number >= exposure.dual_gain.threshold_dn) {
            branch = exposure.dual_gain.low;
        } else {
            break;
        }
    }
    return tables[branch.merged + number];
}

/// Digital number of a pixel as it leaves the sensor.
fn sent(converted: u32, x: u32, y: u32) -> u32 {
    var number = converted;
    let stuck = listed(exposure.stuck_pixels, x, y);
    if (stuck != NONE) {
        number = tables[stuck];
    }
    if (exposure.processed != NONE) {
        number = tables[exposure.processed + number];
    }
    let lost = listed(exposure.transmission_errors, x, y);
    if (lost != NONE) {
        number = tables[lost];
    }
    return number;
}
