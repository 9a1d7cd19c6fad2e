//! One exposure of 24 megapixels, all threads: from mean electrons to digital numbers.

use divan::{Bencher, black_box};
use photosite::image::Planes;
use photosite::sensor::{Exposure, NoiseKey, Stages, expose, presets};
use photosite::units::Seconds;

/// Light from none to a little above what the pixels hold, in all channels.
fn mean_electrons(channels: &[String], full_well_e: f32) -> Planes {
    let (width, height) = (6000, 4000);
    let mut planes = Planes::zeros(width, height, channels.iter().map(String::as_str));
    for channel in planes.channels_mut() {
        for (i, electrons) in channel.data.iter_mut().enumerate() {
            *electrons = full_well_e * 1.05 * (i % width) as f32 / width as f32;
        }
    }
    planes
}

#[divan::bench(args = ["generic-cmos-color", "sony-imx249-mono", "textbook-ccd", "andor-zyla-55"], sample_count = 3)]
fn expose_24_megapixels(bencher: Bencher<'_, '_>, preset: &str) {
    let sensor = presets::model(preset).expect("a preset");
    let mean_electrons = mean_electrons(sensor.cfa.channels(), sensor.full_well.0 as f32);
    let exposure = Exposure::of(Seconds(0.01));
    bencher.bench_local(|| black_box(expose(&mean_electrons, &sensor, &exposure, Stages::ALL, NoiseKey::default())));
}
