//! A capture file becomes a raw file and an image.
//!
//! `cargo run --release --example render_cornell_box`

fn main() -> photosite::Result<()> {
    let capture = photosite::Capture::load("scenes/cornell-box/capture.toml")?;
    let shot = photosite::render(&capture, photosite::Options::default())?;
    photosite::save_raw(&shot.raw, "raw.dng")?;
    shot.develop(capture.develop())?.save("image.png")?;
    Ok(())
}
