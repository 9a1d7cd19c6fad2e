//! The loop over the pixels: passes over the whole image, bands of rows side by side on all threads.

mod band_worker;
mod landings;
mod passes;
mod pixel_worker;
mod planner;
mod tracer;

use std::ops::ControlFlow;

pub use self::landings::bytes_of_landings;
use self::passes::MAX_PASS_SAMPLES;
pub use self::planner::{Plan, SensorNoise, may_plan_light_paths, plan};
use self::tracer::Tracer;
use super::RenderSettings;
use super::job::RenderJob;
use super::light_paths::Splats;
use super::pilot::{Pilot, START, find_counts};
use super::progress::{Listener, Step};
use crate::film::{Film, FilmResponses};
use photosite_core::math::hash::hash64;
use photosite_core::spectrum::LANES;

/// Largest number of samples a pixel in one pass, where few pixels are left.
const LARGEST_STEP: u32 = 1024;
/// Tells the random numbers of the pilot from those of the image.
const PILOT_SEED: u64 = 0x70_696c_6f74;

/// Renders until the settings' samples are reached or `step` breaks off.
pub fn render(job: &RenderJob<'_>, responses: FilmResponses, step: &Listener<'_>) -> Film {
    let mut film = job.empty_film(responses);
    render_on(job, &mut film, step);
    film
}

/// Continues [`render`] from a film that holds the first samples of each pixel, of the whole image or of some rows: the
/// film becomes what it would be if all had been rendered in one go.
pub fn render_on(job: &RenderJob<'_>, film: &mut Film, step: &Listener<'_>) {
    let tracer = Tracer::new(job, job.settings.seed, step);
    let samples = job.settings.samples().len() as u32;
    let planned = Some(film.counts().len() as u64 * u64::from(samples));
    // A render that is broken off is one of fewer samples.
    let _ = tracer.fill(film, samples, |film| tracer.tell(film, None, planned));
}

/// Number of columns, and of rows, from one pixel of a coarse image to the next.
pub const COARSE_STEP: usize = 8;

/// Renders a coarse image of every eighth pixel in every eighth row, so that there is something to see at once: of one
/// sample, or of four where paths carry one wavelength in place of four. Uses the memory of a film without samples, and
/// leaves it without: nothing of this is part of what follows.
pub fn render_coarse(job: &RenderJob<'_>, film: &mut Film, step: &Listener<'_>) {
    if film.total() > 0 || job.settings.samples().is_empty() {
        return;
    }
    let (width, first_row) = (film.width(), film.image_rows().start);
    let is_seen = |pixel: usize| [pixel % width, first_row + pixel / width].iter().all(|at| at % COARSE_STEP == 0);
    // Each of these pixels stands alone: paths from lights would bring light to all.
    let settings = RenderSettings { light_paths: None, ..job.settings.clone() };
    let job = RenderJob { settings: &settings, ..*job };
    // What is not kept is no progress.
    let only_stops = |told: Step<'_>| {
        if matches!(told, Step::Band { .. }) { step(Step::Band { paths: 0 }) } else { step(told) }
    };
    let tracer = Tracer::new(&job, settings.seed, &only_stops);
    let is_hero_alone = tracer.has_single_wavelengths || tracer.lands_wavelengths();
    let samples = if is_hero_alone { LANES.min(settings.samples().len()) as u32 } else { 1 };
    tracer.add_samples(film, &|pixel| if is_seen(pixel) { samples } else { 0 }, &Splats::default());
    if tracer.go_on().is_continue() {
        // One that is broken off is one of fewer samples.
        let _ = step(Step::Coarse { film });
    }
    film.clear();
}

/// Renders until each pixel has the samples that it needs, at most those of the settings, or `step` breaks off. Film
/// and pilot are empty, or those that `step` was told of when another such render was broken off: the image becomes
/// what that would have given. `needed` says how many samples each pixel needs, row by row, as far as a film of the
/// pilot tells; `None` where that cannot be told, and all pixels get as many as they may.
pub fn render_with_pilot(
    job: &RenderJob<'_>,
    film: &mut Film,
    pilot: &mut Pilot,
    needed: &dyn Fn(&Film) -> Option<Vec<f32>>,
    step: &Listener<'_>,
) {
    // A render that is broken off is one of fewer samples: their numbers are those of the clock and the pilot.
    let _ = trace(job, film, pilot, needed, step);
}

/// [`render_with_pilot`], broken off where `step` says so.
fn trace(
    job: &RenderJob<'_>,
    film: &mut Film,
    pilot: &mut Pilot,
    needed: &dyn Fn(&Film) -> Option<Vec<f32>>,
    step: &Listener<'_>,
) -> ControlFlow<()> {
    let (seed, most) = (job.settings.seed, job.settings.samples_per_pixel);
    let least = START.min(most);
    let tracer = Tracer::new(job, seed, step);
    tracer.fill(film, least, |film| tracer.tell(film, Some(pilot), None))?;
    if least == most {
        return ControlFlow::Continue(());
    }
    let scout = Tracer::new(job, hash64(seed, PILOT_SEED), step);
    let counts = find_counts(pilot, [least, most], needed, |pilot| {
        let Pilot { film: known, wanted } = &mut *pilot;
        let passed = scout.pass(known, &|pixel| wanted[pixel], 0);
        tracer.tell(film, Some(pilot), None)?;
        passed
    })?;
    let planned = pilot.film.total() + counts.iter().map(|&count| u64::from(count)).sum::<u64>();
    let mut level = least;
    while counts.iter().any(|&count| count > level) {
        let unfinished = counts.iter().filter(|&&count| count > level).count() as u64;
        let step = u64::from(MAX_PASS_SAMPLES) * job.pixels() / unfinished;
        level = level.saturating_add((step as u32).min(LARGEST_STEP)).min(most);
        let passed = tracer.pass(film, &|pixel| counts[pixel].min(level), 0);
        tracer.tell(film, Some(pilot), Some(planned))?;
        passed?;
    }
    ControlFlow::Continue(())
}
