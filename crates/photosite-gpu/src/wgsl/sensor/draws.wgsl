// Normal numbers that the stages of an exposure take, all drawn in one place: a driver copies a function to wherever it
// is called, and this one is long.

// Stages that take one
const OF_PHOTO_RESPONSE = 0u;
const OF_DARK_CURRENT = 1u;
const OF_RESET_NOISE = 2u;
const OF_DARK_OFFSET = 3u;
const OF_READ_NOISE_SPREAD = 4u;
const OF_READ_NOISE = 5u;
const OF_LOW_GAIN_READ_NOISE = 6u;
const DRAWS = 7u;

/// Numbers of both neighbours for each stage.
var<private> drawn: array<Signed, 14>;

fn streams_of(stage: u32) -> StreamWords {
    let has_two_gains = exposure.dual_gain.is_there == 1u;
    switch stage {
        case OF_PHOTO_RESPONSE: { return exposure.photo_response.streams; }
        case OF_DARK_CURRENT: { return exposure.dark_current.factors.streams; }
        case OF_RESET_NOISE: { return exposure.reset_noise.streams; }
        case OF_DARK_OFFSET: { return exposure.dark_offset.streams; }
        case OF_READ_NOISE_SPREAD: {
            // It is the same in both branches of two gains
            if (has_two_gains) { return exposure.dual_gain.high.factors.streams; }
            return exposure.read_noise.factors.streams;
        }
        case OF_READ_NOISE: {
            if (has_two_gains) { return exposure.dual_gain.high.streams; }
            return exposure.read_noise.streams;
        }
        default: { return exposure.dual_gain.low.streams; }
    }
}

/// Draws the numbers of two neighbours.
fn draw_normals(place: vec2<u32>) {
    for (var stage = 0u; stage < DRAWS; stage += 1u) {
        let streams = streams_of(stage);
        if (streams.is_there == 0u) {
            continue;
        }
        let block = first_block(streams, place);
        for (var i = 0u; i < 2u; i += 1u) {
            var random = stream_of(streams, place, block, i);
            drawn[2u * stage + i] = next_normal(&random);
        }
    }
}

/// Numbers of both neighbours for a stage.
fn normals(stage: u32) -> vec2<f32> {
    return vec2<f32>(signed_f32(drawn[2u * stage]), signed_f32(drawn[2u * stage + 1u]));
}

/// Log-normal factor of the first or the second neighbour, exp(scale·n − shift).
fn factor(factors: LogNormalWords, stage: u32, index: u32) -> Wide {
    let normal = drawn[2u * stage + index];
    let scaled = fixed_product(fixed_of(factors.scale, 56), normal.magnitude);
    let shift = fixed_of(factors.shift, 56);
    return exponential_of(signed_sum(Signed(scaled, normal.is_negative), Signed(shift, true)));
}
