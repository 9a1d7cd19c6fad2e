//! Pilot samples of the planner: what they tell of variance and cost.
//!
//! Camera paths: pixels of a coarse grid get two sets of n samples each with seeds of their own. Half the squared
//! difference of their means is the variance of the mean of n samples as the image has them, stratified: samples' own
//! variance would say little of how Sobol points spread direct light and colour.
//!
//! Light paths: what N of them bring to a pixel is a sum of rare, independent terms x, of variance N·E\[x²\]. A few of the
//! N paths suffice for that, and what they bring anywhere counts for the next pixel of the grid. A pilot has one light
//! path per sample, of the kind that brings most. Each term has been weighted by q/(1 + q) against the camera path that
//! finds the same, with q of [`mis_ratio`](crate::integrator::mis_ratio), whose second moment is therefore x²·(1 + q)²/q, and 1/(1 + λ·q) of that
//! with λ light paths and both kinds weighted: so the terms of one pilot tell of all λ. The variance of camera paths in the
//! pilot has 1/(1 + q)² of it already, which leaves
//!
//! x²·\[(1 + q)²/(1 + λ·q) − 1\]/q.
//!
//! What light paths of another kind would not bring has λ = 0 with that kind, however many there are.
//!
//! Plain paths, λ = 0, have x²·(2 + q): caustics that camera paths hardly ever find count there as what they are,
//! though none may have found them in the pilot.

use rayon::prelude::*;

use crate::film::{Film, FilmResponses};
use crate::integrator::job::RenderJob;
use crate::integrator::light_paths::Splats;
use crate::integrator::progress::Listener;
use crate::integrator::render::tracer::Tracer;
use crate::integrator::settings::{LightPathKind, RenderSettings};
use photosite_core::math::hash::hash64;

/// Tells the random numbers of pilots from those of the image.
const SEED: u64 = 0x0073_7472_6174_6567;
/// Sets of samples of a pilot.
pub(super) const SETS: u64 = 2;
/// Bounds of the MIS ratio of what light paths find.
const LEAST_RATIO: f64 = 1e-6;
const MOST_RATIO: f64 = 1e6;

/// Results of a pilot.
pub(super) struct Measured {
    /// Means of each set, cell by cell and channel by channel.
    pub(super) means: Vec<[f64; SETS as usize]>,
    /// Light that light paths bring to one sample, likewise.
    pub(super) brought: Vec<f64>,
    /// Variance of one sample with each of the light paths considered beside that of camera paths in the pilot, likewise.
    pub(super) beside: Vec<Vec<f64>>,
    /// Cost of the camera paths of one sample, and of the light paths considered.
    pub(super) camera_cost: f64,
    pub(super) light_costs: Vec<f64>,
    /// Cost of the pilot.
    pub(super) spent: f64,
}

/// Samples of pilots: where they are taken, and how many.
pub(super) struct PilotSamples<'a> {
    pub(super) job: &'a RenderJob<'a>,
    pub(super) responses: &'a FilmResponses,
    pub(super) step: &'a Listener<'a>,
    /// Samples of each pixel in a set.
    pub(super) set: u32,
    /// Number of light paths that a pilot traces, and those of its samples.
    pub(super) traced_light_paths: u64,
    pub(super) pilot_light_paths: LightPaths,
    /// Light paths that are considered.
    pub(super) light_paths: Vec<LightPaths>,
    /// Pixels from one cell to the next.
    pub(super) stride: usize,
    /// Numbers of columns and rows of the cells.
    pub(super) cells: [usize; 2],
}

/// Light paths that an image may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightPaths {
    /// Number per sample.
    pub(super) number: f64,
    pub(super) kind: LightPathKind,
}

impl PilotSamples<'_> {
    /// Traces a pilot.
    pub(super) fn measure(&self, splitting: u32) -> Option<Measured> {
        let settings = RenderSettings {
            splitting: Some(splitting),
            light_paths: Some(self.pilot_light_paths.number),
            light_path_kind: Some(self.pilot_light_paths.kind),
            part: None,
            ..self.job.settings.clone()
        };
        let job = RenderJob { settings: &settings, ..*self.job };
        let seed = |set: u64| hash64(hash64(settings.seed, SEED), set);
        let values = self.cells[0] * self.cells[1] * self.responses.len();
        let of_set = u64::from(self.set) * (self.cells[0] * self.cells[1]) as u64;
        let mut means = vec![[0.0; SETS as usize]; values];
        let mut spent = 0.0;
        for set in 0..SETS {
            let tracer = Tracer::new(&job, seed(set), self.step);
            for (means, mean) in means.iter_mut().zip(self.means(&tracer)) {
                means[set as usize] = mean;
            }
            tracer.go_on().is_continue().then_some(())?;
            spent += tracer.cost(of_set);
        }
        let mut measured = Measured {
            means,
            brought: vec![0.0; values],
            beside: vec![vec![0.0; values]; self.light_paths.len()],
            camera_cost: spent / (SETS * of_set) as f64,
            light_costs: vec![0.0; self.light_paths.len()],
            spent,
        };
        let tracer = Tracer::new(&job, seed(SETS), self.step);
        if let Some(light_tracer) = &tracer.light_tracer {
            let height = job.resolution[1] as usize;
            let traced = self.traced_light_paths;
            let splats = light_tracer.trace_paths(0..traced, 0..height, |_, _| true);
            let cost = |kind| light_tracer.cost(traced, kind);
            for (light_cost, light_paths) in measured.light_costs.iter_mut().zip(&self.light_paths) {
                *light_cost = light_paths.number * cost(light_paths.kind) / traced as f64;
            }
            measured.spent += cost(self.pilot_light_paths.kind);
            self.add_splats(&splats, f64::from(light_tracer.paths()) / traced as f64, &mut measured);
        }
        Some(measured)
    }

    /// Means of one set, cell by cell and channel by channel.
    fn means(&self, tracer: &Tracer<'_>) -> Vec<f64> {
        let width = self.job.resolution[0] as usize;
        let [columns, rows] = self.cells;
        let column = |cell: usize| (cell * self.stride + self.stride / 2).min(width - 1);
        let of_row = |cell: usize| {
            let row = (cell * self.stride + self.stride / 2).min(self.job.resolution[1] as usize - 1);
            let mut film = Film::of_rows(width, row..row + 1, self.responses.clone());
            let is_seen = |pixel: usize| pixel == column(pixel / self.stride);
            tracer.add_samples(&mut film, &|pixel| if is_seen(pixel) { self.set } else { 0 }, &Splats::default());
            let value =
                |channel: usize, pixel: usize| film.means(channel, pixel..pixel + 1).next().map_or(0.0, f64::from);
            let of_cell = |cell: usize| (0..self.responses.len()).map(move |channel| (channel, column(cell)));
            (0..columns).flat_map(of_cell).map(|(channel, pixel)| value(channel, pixel)).collect::<Vec<_>>()
        };
        (0..rows).into_par_iter().with_max_len(1).flat_map_iter(of_row).collect()
    }

    /// Adds what light paths bring, times `scale`, to the means over the pixels of each cell.
    fn add_splats(&self, splats: &Splats, scale: f64, measured: &mut Measured) {
        let [width, height] = self.job.resolution.map(|n| n as usize);
        let channels = self.responses.len();
        let extent = |cell: usize, length: usize| ((cell + 1) * self.stride).min(length) - cell * self.stride;
        for splat in splats.all() {
            let (pixel, _) = splat.key();
            let [column, row] = [pixel as usize % width, pixel as usize / width].map(|at| at / self.stride);
            let first = (row * self.cells[0] + column) * channels;
            let per_pixel = scale / (extent(column, width) * extent(row, height)) as f64;
            let (irradiance, wavelengths) = splat.light();
            for (i, value) in (first..).zip(self.responses.values(irradiance, wavelengths)) {
                let value = f64::from(value);
                measured.brought[i] += per_pixel * value;
                for (beside, light_paths) in measured.beside.iter_mut().zip(&self.light_paths) {
                    let is_brought = light_paths.kind.holds(splat.is_caustic());
                    let number = if is_brought { light_paths.number } else { 0.0 };
                    let part = second_moment(splat.mis_ratio(), number / self.pilot_light_paths.number);
                    beside[i] += per_pixel * value.powi(2) * part;
                }
            }
        }
    }
}

/// Second moment of both kinds of paths together beside that of camera paths in the pilot, over the square of what the
/// pilot's light paths bring, with `more` times as many of them, whose MIS ratio is q in the pilot.
fn second_moment(q: f64, more: f64) -> f64 {
    // Camera paths that hardly ever find the light are as good as none.
    let q = q.clamp(LEAST_RATIO, MOST_RATIO);
    ((1.0 + q).powi(2) / (1.0 + more * q) - 1.0) / q
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_terms_of_one_pilot_tell_of_all_numbers_of_light_paths() {
        // Camera paths find a light f with a density p in one sample, light paths with q·p: both with weights have the
        // second moment f²/(p·(1 + q)), and those from the camera among them f²/(p·(1 + q)²).
        for q in [1e-3, 0.3, 1.0, 20.0, 1e4f64] {
            let (f, p) = (2.0f64, 0.5);
            let both = |q: f64| f * f / (p * (1.0 + q));
            let of_camera = f * f / (p * (1.0 + q).powi(2));
            // E[x²] of what light paths bring: the weight times f/(q·p), with the density q·p.
            let x_squared = (q / (1.0 + q)).powi(2) * f * f / (q * p);
            for more in [0.0, 0.25, 1.0, 4.0] {
                let told = of_camera + x_squared * second_moment(q, more);
                assert!((told / both(more * q) - 1.0).abs() < 1e-9, "{q}, {more}: {told}");
            }
        }
    }
}
