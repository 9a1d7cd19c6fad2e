//! Random numbers of the sensor: words bit for bit, normal numbers, counts of electrons.

use photosite_core::image::Planes;
use photosite_core::math::philox::Philox;
use photosite_core::units::Seconds;
use photosite_gpu::probe::exposure_answers;
use photosite_sensor::packed::{PackedExposure, PackedLight};
use photosite_sensor::{Exposure, NoiseKey, Stages, presets};
use rand::{Rng, RngExt};
use rand_distr::{Exp1, Poisson, StandardNormal};

const KEY: u64 = 0x0123_4567_89ab_cdef;

/// Answers for a pixel each: its column and row, and two words more.
fn answers(text: &str, inputs: &[[[u32; 4]; 1]]) -> Option<Vec<[[u32; 4]; 1]>> {
    let card = crate::card()?;
    let sensor = presets::model(presets::DEFAULT).expect("a preset");
    let exposure = Exposure::of(Seconds(0.01));
    let packed = PackedExposure::new([2, 2], &sensor, &exposure, Stages::NONE, NoiseKey::default());
    let light = PackedLight::new(&Planes::zeros(2, 2, sensor.cfa.channels()), &sensor).expect("light");
    let text = format!(
        "const STREAMS = StreamWords(1u, {}u, {}u, 0xffffffffu);
        fn stream_at(at: vec4<u32>) -> Philox {{
            let place = vec2<u32>(at.x / 2u, at.y);
            return stream_of(STREAMS, place, first_block(STREAMS, place), at.x % 2u);
        }}
        {text}",
        KEY as u32,
        KEY >> 32
    );
    Some(exposure_answers(card, &packed.expect("an exposure"), &light, &text, inputs).expect("a kernel that runs"))
}

/// Stream of the pixel of an input.
fn stream(&[[x, y, _, _]]: &[[u32; 4]; 1]) -> Philox {
    let [even, odd] = Philox::pair(KEY, u64::from(y) << 32 | u64::from(x / 2));
    if x % 2 == 0 { even } else { odd }
}

fn pixels(count: u32) -> Vec<[[u32; 4]; 1]> {
    (0..count).map(|i| [[i % 1000, i / 1000, 0, 0]]).collect()
}

#[test]
fn words_of_streams_are_those_of_the_processor() {
    let text = "fn answer(words: array<vec4<u32>, 1>) -> array<vec4<u32>, 1> {
        var random = stream_at(words[0]);
        for (var i = 0u; i < words[0].z; i += 1u) { _ = next_bits(&random); }
        let first = next_bits(&random);
        return array<vec4<u32>, 1>(vec4<u32>(first, next_bits(&random)));
    }";
    let inputs: Vec<_> = (0..2000u32).map(|i| [[i.wrapping_mul(40_503), u32::MAX - i, i % 9, 0]]).collect();
    let Some(found) = answers(text, &inputs) else { return };
    for (input, found) in inputs.iter().zip(found) {
        let mut random = stream(input);
        (0..input[0][2]).for_each(|_| _ = random.next_u64());
        let [a, b] = [(); 2].map(|()| random.next_u64());
        assert_eq!(found, [[a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32]], "{input:?}");
    }
}

#[test]
fn normal_and_exponential_numbers_are_those_of_the_processor() {
    let text = "fn answer(words: array<vec4<u32>, 1>) -> array<vec4<u32>, 1> {
        var random = stream_at(words[0]);
        let normal = signed_f32(next_normal(&random));
        let exponential = signed_f32(Signed(next_exponential(&random), false));
        let after = next_bits(&random);
        return array<vec4<u32>, 1>(vec4<u32>(bitcast<u32>(normal), bitcast<u32>(exponential), after));
    }";
    let inputs = pixels(200_000);
    let Some(found) = answers(text, &inputs) else { return };
    let mut tails = 0;
    for (input, [[normal, exponential, low, high]]) in inputs.iter().zip(found) {
        let mut random = stream(input);
        let expected: [f32; 2] = [random.sample(StandardNormal), random.sample(Exp1)];
        for (found, expected) in [normal, exponential].into_iter().zip(expected) {
            // 56 bits behind the point round as 53 do, but for the last place of one in millions
            let apart = (found as i32).abs_diff(expected.to_bits() as i32);
            assert!(apart <= 1, "{input:?}: {} for {expected}", f32::from_bits(found));
        }
        tails += u32::from(expected[0].abs() > 3.66);
        assert_eq!(u64::from(high) << 32 | u64::from(low), random.next_u64(), "{input:?}: the stream goes on alike");
    }
    // 2.5e-4 of all lie beyond the base of the ziggurat
    assert!(tails > 20, "{tails} of the tail");
}

#[test]
fn counts_of_electrons_are_those_of_the_processor() {
    let text = "fn answer(words: array<vec4<u32>, 1>) -> array<vec4<u32>, 1> {
        var random = stream_at(words[0]);
        let mean = wide_of_f32(bitcast<f32>(words[0].z));
        let count = counted(mean, e_to_minus(mean), &random);
        return array<vec4<u32>, 1>(vec4<u32>(bitcast<u32>(count), next_bits(&random), 0u));
    }";
    let near = [11.0f32, 11.9, 11.99, 12f32.next_down(), 12.0, 12.01, 12.3, 13.0, 14.0, 16.0, 20.0, 25.0, 40.0];
    let others = (0..40).map(|i| 10f32.powf(-3.0 + 0.25 * i as f32));
    let means: Vec<f32> = near.into_iter().chain(others).collect();
    const EACH: usize = 8000;
    let input = |i: usize| [[(i % EACH) as u32, (i / EACH) as u32, means[i / EACH].to_bits(), 0]];
    let inputs: Vec<_> = (0..EACH * means.len()).map(input).collect();
    let Some(found) = answers(text, &inputs) else { return };
    let mut different = Vec::new();
    for (input, [[count, low, high, _]]) in inputs.iter().zip(found) {
        let mean = f32::from_bits(input[0][2]);
        let mut random = stream(input);
        let expected = random.sample(Poisson::new(f64::from(mean)).expect("above 0")) as f32;
        let next = random.next_u64();
        if f32::from_bits(count) != expected || [low, high] != [next as u32, (next >> 32) as u32] {
            different.push((mean, expected, f32::from_bits(count)));
        }
    }
    // Where a count is cut off, errors of 2⁻³² and 2⁻⁴⁵ of √μ·z; where a candidate is taken, single precision with an
    // error of some 1e-6 of a probability of at most 0.1: together 1e-7 for a count, 0.04 for these.
    assert!(
        different.len() <= 1,
        "{} of {}: {:?}",
        different.len(),
        inputs.len(),
        &different[..different.len().min(40)]
    );
}
