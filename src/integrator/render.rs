//! The loop over the pixels: passes over the whole picture, rows side by side on all threads.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use glam::DVec2;
use rayon::prelude::*;

use super::RenderSettings;
use super::path::{PathLimits, radiance};
use crate::film::{Film, FilmResponses, FilmRow};
use crate::optics::Camera;
use crate::sampler::Sampler;
use crate::scene::Scene;
use crate::spectrum::{Spectrum, SpectrumTable, WavelengthSampler};

/// Everything that a render reads.
pub struct RenderJob<'a> {
    /// What is in front of the camera.
    pub scene: &'a Scene,
    /// The lens.
    pub camera: &'a Camera,
    /// The lens's spectral transmittance τ.
    pub transmittance: &'a Spectrum,
    /// How much each wavelength matters to the sensor.
    pub importance: &'a Spectrum,
    /// Columns and rows.
    pub resolution: [u32; 2],
    /// Depth, seed, sampler, limits.
    pub settings: &'a RenderSettings,
}

/// What a render tells while it runs.
pub enum Step<'a> {
    /// A row has got its samples of this pass. Called from any thread.
    Row {
        /// Camera paths of that row.
        paths: u64,
    },
    /// A pass is over; `film` holds the same number of samples in every pixel.
    Pass {
        /// The film so far.
        film: &'a Film,
        /// Time since the start.
        elapsed: Duration,
    },
}

/// Largest number of samples a pixel in one pass: passes double up to it, so that there is soon something to see, and a
/// limit of time is kept well.
const LARGEST_PASS: u32 = 16;

/// Renders until the settings' samples are reached or `step` breaks off after a pass.
pub fn render(
    job: &RenderJob<'_>,
    responses: FilmResponses,
    step: &(dyn Fn(Step<'_>) -> ControlFlow<()> + Sync),
) -> Film {
    let start = Instant::now();
    let [width, height] = job.resolution.map(|n| n as usize);
    let mut film = Film::new(width, height, responses);
    // Where a wavelength of the sensor meets no light, a sample would be wasted; where all is dark, any will do.
    let useful = job.importance.product(job.scene.light_spectrum()).product(job.transmittance);
    let wavelengths = WavelengthSampler::new(&useful);
    let mut spectra = SpectrumTable::default();
    let transmittance = spectra.add(job.transmittance);
    let settings = job.settings;
    let limits = PathLimits { max_depth: settings.max_depth, roulette_depth: settings.roulette_depth };

    while film.samples() < settings.samples_per_pixel {
        let done = film.samples();
        let count = done.clamp(1, LARGEST_PASS).min(settings.samples_per_pixel - done);
        let first = settings.first_sample + done;
        let fill = |(y, mut row): (usize, FilmRow<'_>)| {
            for x in 0..width {
                let pixel = (y * width + x) as u64;
                for index in first..first + count {
                    let mut sampler = Sampler::new(settings.sampler, settings.seed, pixel, index);
                    let [dx, dy] = sampler.next_2d();
                    let aperture = sampler.next_2d();
                    let mut lambda = wavelengths.sample(sampler.next_1d());
                    let position = DVec2::new(x as f64 + f64::from(dx), y as f64 + f64::from(dy));
                    // A camera that stands still needs no time, and its samples stay what they are.
                    let time = if job.camera.moves() { sampler.next_1d() } else { 0.0 };
                    let spread = if job.camera.spreads_points() { sampler.next_2d() } else { [0.0; 2] };
                    let ray = job.camera.generate_spectral(position, aperture, time, spread, &mut lambda);
                    let Some((camera_ray, weights)) = ray else { continue };
                    let through = spectra.sample(transmittance, &lambda) * weights * camera_ray.weight;
                    let arriving = radiance(job.scene, camera_ray.ray, &mut lambda, &mut sampler, limits);
                    row.add(x, arriving * through, &lambda);
                }
            }
            // The callback can only end a render between passes, so its answer to a row does not matter.
            let _ = step(Step::Row { paths: width as u64 * u64::from(count) });
        };
        film.rows_for(count).into_par_iter().enumerate().for_each(fill);
        if step(Step::Pass { film: &film, elapsed: start.elapsed() }).is_break() {
            break;
        }
    }
    film
}
