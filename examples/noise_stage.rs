//! One noise stage at a time: how much of the noise of an even grey image comes from each.
//!
//! `cargo run --release --example noise_stage`

use photosite::capture::read_named_sensor;
use photosite::image::{Channel, Planes};
use photosite::keys::SensorKeys;
use photosite::math::statistics::Moments;
use photosite::sensor::{Exposure, NoiseKey, RegionOfInterest, Stage, Stages, expose};
use photosite::units::{Celsius, Decibels, Seconds};
use photosite::{Invalid, Sandbox};

const SIZE: usize = 200;
/// Mean electrons of every pixel.
const ELECTRONS: f32 = 500.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let size = SensorKeys::new().resolution_px([SIZE as u32; 2]);
    let sensor = read_named_sensor(&Sandbox::default(), "sony-imx249-mono", &size)?.model;
    let exposure = Exposure {
        time: Seconds(0.1),
        gain: Decibels(0.0),
        digital_gain: Decibels(0.0),
        temperature: Celsius(40.0),
        frame_interval: None,
        region: RegionOfInterest::WHOLE,
    };
    let channel = Channel { name: sensor.cfa.channels()[0].clone(), data: vec![ELECTRONS; SIZE * SIZE] };
    let light = Planes::new(SIZE, SIZE, vec![channel])?;

    let deviation_dn = |stages: Stages| -> photosite::Result<f64, Invalid> {
        let raw = expose(&light, &sensor, &exposure, stages, NoiseKey { seed: 1, frame: 0 })?;
        let mut numbers = Moments::default();
        raw.data.iter().for_each(|&dn| numbers.add(f64::from(dn)));
        Ok(numbers.variance().sqrt())
    };
    println!("all stages: σ = {:.2} DN", deviation_dn(Stages::ALL)?);
    for stage in Stage::ALL {
        // Gain and converter are there in any case. What this sensor lacks leaves an even image.
        let deviation = deviation_dn(Stages::only(&[stage]))?;
        if deviation > 0.0 {
            println!("{stage:?} alone: σ = {deviation:.2} DN");
        }
    }
    Ok(())
}
