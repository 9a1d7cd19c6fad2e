//! Random numbers of light transport.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use photosite::sampler::{Sampler, SamplerKind};

/// Samples a call, each asked for as many numbers as a path with six vertices.
const SAMPLES: u32 = 1000;
const VERTICES: u32 = 6;

#[divan::bench(args = [SamplerKind::Sobol, SamplerKind::Independent])]
fn numbers_of_a_path(bencher: Bencher, kind: SamplerKind) {
    bencher.counter(ItemsCount::new(SAMPLES * VERTICES * 6)).bench(|| {
        let mut sum = 0.0;
        for index in 0..black_box(SAMPLES) {
            let mut sampler = Sampler::new(kind, 1, 2, index);
            for _ in 0..2 * VERTICES {
                let [u, v] = sampler.next_2d();
                sum += u + v + sampler.next_1d();
            }
        }
        sum
    });
}
