//! `[render]`: from its table to settings.

use super::numbers::duration;
use super::tables::{RenderTable, SamplerName, WavelengthsName};
use crate::Invalid;
use crate::integrator::{RenderSettings, WavelengthChoice};
use crate::sampler::SamplerKind;

/// Reads `[render]`.
pub(super) fn render(table: &RenderTable) -> Result<RenderSettings, Invalid> {
    let default = RenderSettings::default();
    let settings = RenderSettings {
        part: None,
        samples_per_pixel: table.samples_per_pixel.unwrap_or(default.samples_per_pixel),
        time_limit: table.time_limit_s.map(|s| duration("time_limit_s", s)).transpose()?,
        noise_target: table.noise_target,
        max_depth: table.max_depth.unwrap_or(default.max_depth),
        roulette_depth: table.roulette_depth.unwrap_or(default.roulette_depth),
        splitting: table.splitting.unwrap_or(default.splitting),
        reuse: table.reuse.unwrap_or(default.reuse),
        light_paths: table.light_paths.unwrap_or(default.light_paths),
        wavelengths: match table.wavelengths {
            None => default.wavelengths,
            Some(WavelengthsName::AllFilters) => WavelengthChoice::AllFilters,
            Some(WavelengthsName::OwnFilter) => WavelengthChoice::OwnFilter,
        },
        sampler: match table.sampler {
            None => default.sampler,
            Some(SamplerName::Sobol) => SamplerKind::Sobol,
            Some(SamplerName::Independent) => SamplerKind::Independent,
        },
        seed: table.seed.unwrap_or(default.seed),
    };
    settings.validate()?;
    Ok(settings)
}
