//! Noise that `photosite noise add` is asked for, as keys with values.

use std::path::Path;

use super::super::tree::overrides;
use super::super::tree::source::CaptureSource;
use photosite_core::{Invalid, Result};
use photosite_measure::synthetic_noise::SyntheticNoise;

/// Reads the noise to be added from `key=value` of its table, such as `gaussian.sigma=4`. A file that they name is
/// relative to where the command is given.
pub fn read_synthetic_noise(arguments: &[String]) -> Result<SyntheticNoise> {
    let mut source = CaptureSource::parse(Path::new("noise"), "[noise]\n".to_owned())?;
    for argument in arguments {
        overrides::set_noise(&mut source, argument)?;
    }
    let noise: SyntheticNoise = source.read("noise")?.unwrap_or_default();
    let at = |invalid: Invalid| match invalid.key.as_str() {
        // The table as a whole has no place that a user wrote.
        "" => photosite_core::Error::Usage { message: invalid.message, help: invalid.help },
        _ => source.error(invalid.within("noise")),
    };
    noise.validate().map_err(at)?;
    Ok(noise)
}
