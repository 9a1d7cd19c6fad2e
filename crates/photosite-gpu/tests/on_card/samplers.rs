//! Random numbers, bit for bit.

use photosite_gpu::probe;
use photosite_transport::sampler::{Sampler, SamplerKind};
use photosite_transport::scene::packed::PackedScene;

const TEXT: &str = "
fn answer(words: array<vec4<u32>, 1>) -> array<vec4<u32>, 2> {
    var random = Sampler(words[0].xy, words[0].z, words[0].w);
    let both = next_2d(&random);
    let one = next_1d(&random);
    skip(&random);
    let more = next_2d(&random);
    return array<vec4<u32>, 2>(bitcast<vec4<u32>>(vec4<f32>(both, more)), vec4<u32>(bitcast<u32>(one), random.dimension, 0u, 0u));
}";

#[test]
fn cards_draw_the_numbers_of_the_processor() {
    let Some(card) = crate::card() else { return };
    for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
        let starts: Vec<(u64, u32, u32)> = (0..4096u32)
            .map(|i| (u64::from(i) * 0x9e37_79b9_7f4a_7c15, i.wrapping_mul(2_654_435_761), i % 100))
            .chain([(0, 0, 0), (u64::MAX, u32::MAX, 70)])
            .collect();
        let mut inputs = Vec::new();
        let mut expected = Vec::new();
        for &(sequence, index, skipped) in &starts {
            let mut sampler = Sampler::new(kind, 5);
            sampler.start(sequence, index);
            (0..skipped).for_each(|_| sampler.skip());
            inputs.push([sampler.position().words()]);
            let (both, one) = (sampler.next_2d(), sampler.next_1d());
            sampler.skip();
            let more = sampler.next_2d();
            let numbers = [both[0], both[1], more[0], more[1]].map(f32::to_bits);
            expected.push([numbers, [one.to_bits(), sampler.position().words()[3], 0, 0]]);
        }
        let scene = PackedScene::default();
        let found = probe::answers::<1, 2>(card, &scene, kind, TEXT, &inputs).expect("a kernel that runs");
        assert!(
            found == expected,
            "{kind:?}: first difference at {:?}",
            found.iter().zip(&expected).position(|(a, b)| a != b)
        );
    }
}
