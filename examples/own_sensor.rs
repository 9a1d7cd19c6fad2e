//! A preset with other numbers, and a sensor that is described from scratch: what changes in the picture.
//!
//! `cargo run --release --example own_sensor`

use std::path::Path;

use photosite::{Capture, Options, render};

/// A small monochrome sensor, with a lens and an exposure time that suit it. Every key of `[sensor]` is described by
/// `photosite schema`.
const SENSOR: &str = r#"
sensor.preset = "none"
sensor.name = "My sensor"
sensor.resolution_px = [200, 200]
sensor.pixel_pitch_um = [9.0, 9.0]
sensor.cfa = "mono"
sensor.channels.Y = { quantum_efficiency = 0.6 }
sensor.charge = { full_well_e = 12000 }
sensor.adc = { bits = 10, black_level_dn = 16, conversion_gain_dn_per_e = 0.08 }
sensor.noise = { read_noise_e = 4.0 }
lens.focal_length_mm = 2.5
exposure.time_s = 0.001
"#;

fn main() -> photosite::Result<()> {
    let capture = Path::new("scenes/cornell-box/capture.toml");
    let quick = "render.samples_per_pixel=16".to_owned();

    // The sensor of the capture file, but cold and with a smaller well.
    let changes = [quick.clone(), "sensor.charge.full_well_e=4000".to_owned(), "exposure.temperature_c=-20".to_owned()];
    let preset = Capture::load_with(capture, &changes)?;
    let shot = render(&preset, Options::default())?;
    shot.raw.save("small-well.dng")?;

    // A sensor of one's own: each line changes one key.
    let lines = SENSOR.lines().filter(|line| !line.is_empty()).map(str::to_owned);
    let own = Capture::load_with(capture, &lines.chain([quick]).collect::<Vec<_>>())?;
    let shot = render(&own, Options::default())?;
    shot.raw.save("own-sensor.dng")?;
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
