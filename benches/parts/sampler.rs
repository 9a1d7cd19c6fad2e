//! Random numbers of light transport.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use photosite::sampler::{Sampler, SamplerKind};

/// Samples a call, each asked for as many numbers as a path with six vertices, vertex by vertex of as many paths as a
/// render traces together.
const SAMPLES: u32 = 1024;
const TOGETHER: u32 = 256;
const VERTICES: u32 = 6;

#[divan::bench(args = [SamplerKind::Sobol, SamplerKind::Independent])]
fn numbers_of_a_path(bencher: Bencher, kind: SamplerKind) {
    bencher.counter(ItemsCount::new(SAMPLES * VERTICES * 6)).bench(|| {
        let mut sum = 0.0;
        let mut sampler = Sampler::new(kind, 1);
        let mut places = Vec::with_capacity(TOGETHER as usize);
        for first in (0..black_box(SAMPLES)).step_by(TOGETHER as usize) {
            for index in first..first + TOGETHER {
                sampler.start(2, index);
                places.push(sampler.position());
            }
            for _ in 0..VERTICES {
                for place in &mut places {
                    sampler.resume(*place);
                    for _ in 0..2 {
                        let [u, v] = sampler.next_2d();
                        sum += u + v + sampler.next_1d();
                    }
                    *place = sampler.position();
                }
            }
            places.clear();
        }
        sum
    });
}
