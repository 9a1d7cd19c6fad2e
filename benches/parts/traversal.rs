//! Rays per second of every kind that a path has.

use std::sync::LazyLock;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

use crate::rays::{Kind, Stage};
use crate::scenes::LARGE_SPHERE;

#[divan::bench(args = Kind::ALL, sample_count = 10, sample_size = 1)]
fn cornell_box(bencher: Bencher, kind: &Kind) {
    static STAGE: LazyLock<Stage> = LazyLock::new(Stage::cornell_box);
    trace(bencher, &STAGE, *kind);
}

#[divan::bench(args = Kind::ALL, sample_count = 10, sample_size = 1)]
fn kitchen(bencher: Bencher, kind: &Kind) {
    static STAGE: LazyLock<Stage> = LazyLock::new(Stage::kitchen);
    trace(bencher, &STAGE, *kind);
}

#[divan::bench(args = Kind::ALL, sample_count = 10, sample_size = 1)]
fn sphere_from_inside(bencher: Bencher, kind: &Kind) {
    trace(bencher, &SPHERE, *kind);
}

/// The same rays, none of which waits for another.
#[divan::bench(args = Kind::ALL, sample_count = 10, sample_size = 1)]
fn sphere_from_inside_one_by_one(bencher: Bencher, kind: &Kind) {
    let stage = &*SPHERE;
    bencher.counter(ItemsCount::new(stage.rays(*kind).len())).bench(|| black_box(stage).trace_one_by_one(*kind));
}

static SPHERE: LazyLock<Stage> = LazyLock::new(|| {
    let (bands, sectors) = LARGE_SPHERE;
    Stage::sphere_from_inside(bands, sectors)
});

fn trace(bencher: Bencher, stage: &Stage, kind: Kind) {
    bencher.counter(ItemsCount::new(stage.rays(kind).len())).bench(|| black_box(stage).trace(kind));
}
