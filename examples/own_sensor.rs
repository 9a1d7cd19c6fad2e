//! A preset with other numbers, and a sensor that is described from scratch: what changes in the image.
//!
//! `cargo run --release --example own_sensor`

use photosite::keys::{
    AdcKeys, CaptureKeys, ChannelKeys, ChargeKeys, ExposureKeys, LensKeys, NoiseKeys, RenderKeys, SensorKeys,
    SensorTableKeys,
};
use photosite::{Capture, Options, render};

/// A small monochrome sensor, with a lens and an exposure time that suit it.
fn own_sensor() -> CaptureKeys {
    let sensor = SensorKeys::new()
        .preset("none")
        .name("My sensor")
        .resolution_px([200, 200])
        .pixel_pitch_um([9.0, 9.0])
        .cfa("mono")
        .channels("Y", ChannelKeys::new().quantum_efficiency(0.6))
        .charge(ChargeKeys::new().full_well_e(12000.0))
        .adc(AdcKeys::new().bits(10).black_level_dn(16).conversion_gain_dn_per_e(0.08))
        .noise(NoiseKeys::new().read_noise_e(4.0));
    Capture::builder()
        .sensor(sensor)
        .lens(LensKeys::new().focal_length_mm(2.5))
        .exposure(ExposureKeys::new().time_s(0.001))
}

fn main() -> photosite::Result<()> {
    let capture = Capture::load("scenes/cornell-box/capture.toml")?;
    let capture = capture.with(&Capture::builder().render(RenderKeys::new().samples_per_pixel(16)))?;

    // The sensor of the capture file, but cold and with a smaller well.
    let changes = Capture::builder()
        .sensor(SensorKeys::new().charge(ChargeKeys::new().full_well_e(4000.0)))
        .exposure(ExposureKeys::new().temperature_c(-20.0));
    let shot = render(&capture.with(&changes)?, Options::default())?;
    photosite::save_raw(&shot.raw, "small-well.dng")?;

    // A sensor of one's own.
    let own = capture.with(&own_sensor())?;
    let shot = render(&own, Options::default())?;
    photosite::save_raw(&shot.raw, "own-sensor.dng")?;
    shot.develop(own.develop())?.save("own-sensor.png")?;

    println!(
        "{}: {} × {} pixels, {} bits, K = {:.3} DN/e-, saturation {:.0} e-",
        own.sensor().name,
        shot.raw.width,
        shot.raw.height,
        shot.raw.bits,
        own.sensor().system_gain(&shot.exposure),
        own.sensor().saturation_capacity(&shot.exposure).0,
    );
    Ok(())
}
