//! From a description to a scene: mostly the acceleration structure.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use photosite::scene;

use crate::scenes::{self, LARGE_SPHERE};

/// Triangles per second, and the seconds for all of them. The aim for 1.31 million is below 2 s.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn large_sphere(bencher: Bencher) {
    let (bands, sectors) = LARGE_SPHERE;
    let importance = scenes::visible();
    bencher
        .counter(ItemsCount::new(2 * sectors * (bands - 1)))
        .with_inputs(|| scenes::sphere(bands, sectors))
        .bench_values(|description| scene::build(black_box(description), &importance));
}
