//! Fits the table of spectra that RGB textures are looked up in and writes it to
//! `crates/photosite-core/assets/spectra/jakob-hanika-srgb.bin`. To be run from the root of the crate, after a change to the observer, to D65
//! or to the fit: `cargo run --release --example fit_upsampling`.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let (bytes, error) = photosite::spectrum::upsampling::fit_table();
    let path = Path::new("crates/photosite-core/assets/spectra/jakob-hanika-srgb.bin");
    println!("{}: {} bytes, relative error at the nodes at most {error:.1e}", path.display(), bytes.len());
    std::fs::write(path, bytes)
}
