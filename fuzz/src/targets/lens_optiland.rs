//! Optiland files.

use std::path::Path;

use photosite_lens::files;

pub(crate) fn target(data: &[u8]) {
    // What tells Optiland's JSON from ours.
    let text = [b"{\"surface_group\": ", data, b"}"].concat();
    if let Ok(reading) = files::read(&text, Path::new("lens.json")) {
        // What was read is written, and read again.
        let toml = files::to_toml(&reading.prescription);
        let again = files::read(toml.as_bytes(), Path::new("again.toml"));
        assert!(again.is_ok(), "{again:?}\n{toml}");
    }
}
