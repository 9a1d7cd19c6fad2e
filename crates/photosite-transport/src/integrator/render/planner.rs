//! Planner: chooses for a whole image how many paths split off, how many set out from lights, and for which light.
//!
//! What is best depends on the scene: splitting pays where indirect light is the noisiest part, light paths where
//! something focuses light. The planner measures it with *pilot samples*, which have random numbers of their own and are
//! no part of the image: given the plan, the image is that of any render with its settings, its mean unbiased and its
//! variance that of independent samples. What is best is what has the highest efficiency
//! ([Veach97](photosite_core::references#veach97) §2.8)
//!
//! ε = 1/(V·C),   V = mean over pixels and channels of (σ²/m),
//!
//! with the variance σ² of one sample of the pixel, the metric m, and the cost C of one sample. Costs are constants
//! times rays, so that no clock is involved, and a plan is found again from the seed, whatever part of an image, with
//! whatever number of threads, from whatever checkpoint. The metric is the variance of the sensor's own noise where that
//! decides how many samples an image gets, and elsewhere r² + 0.01·r̄², with the light r that the pilot has found near the
//! pixel and its mean r̄ over the image: light then serves any exposure that it is exposed with later. V leaves out the
//! largest 0.1 % of the pixels ([GrittmannEtAl22](photosite_core::references#grittmannetal22)).
//!
//! A plan differs from the simplest, of as few paths as the settings leave, where it brings at least 1.4 times as much.
//!
//! With s branches V is A + B/s and C is a + b·s, so that pilots of one branch and of four tell of all numbers; of light
//! paths one number and one kind do ([`pilot_samples`]).

mod pilot_samples;

use self::pilot_samples::{LightPaths, Measured, PilotSamples, SETS};
use crate::film::FilmResponses;
use crate::integrator::job::RenderJob;
use crate::integrator::progress::{Listener, Step};
use crate::integrator::settings::{LightPathKind, RenderSettings, StrategyChoice, WavelengthChoice};
use crate::optics::Camera;
use crate::scene::Scene;
use photosite_core::image::{Channel, Planes};

/// Samples of an image below which all are spent on the image.
const FEWEST_SAMPLES: u64 = 1 << 20;
/// Samples of one pilot: a part of those of the image, within bounds.
const SHARE: u64 = 128;
const FEWEST_PILOT_SAMPLES: u64 = 1 << 13;
const MOST_PILOT_SAMPLES: u64 = 1 << 18;
/// Samples per pixel that count at most where an image may stop before it has them.
const MOST_EXPECTED: u32 = 64;
/// Samples of a pixel in each set, unless there are few pixels.
const LARGEST_SET: u32 = 16;
/// Part of the pixels that is left out, those of the largest variance.
const LEFT_OUT: f64 = 0.001;
/// Part of the mean that counts as noise in the dark, squared.
const DARK: f64 = 0.01;
/// Numbers of branches that are considered, and those that pilots have.
const BRANCHES: [u32; 5] = [1, 2, 4, 8, 16];
const PILOT_BRANCHES: u32 = 4;
/// Numbers of light paths per sample that are considered beside none, and the one that pilots have.
const LIGHT_PATHS: [f64; 3] = [0.25, 1.0, 4.0];
const PILOT_LIGHT_PATHS: f64 = 1.0;
/// Loss of efficiency that a choice of cheaper samples may bring: pilots are off by as much.
const TOLERANCE: f64 = 1.15;
/// Least gain for which paths split or set out from lights: in a Cornell box that of four branches was found as 1.0 to 1.3,
/// and the plan would change with the seed.
const LEAST_GAIN: f64 = 1.4;
/// Part of the variance of the pilot's branches that stays however many there are: strata of the first surface are no finer
/// for more of them. In a Cornell box and on a displaced ball 0.08 and 0.11 of the variance of 64 samples stayed.
const LEAST_STAYING: f64 = 0.07;

/// Cost of splitting itself, as a part of that of plain paths: 0.34 in a Cornell box, 0.11 on a displaced ball, less in
/// furnished rooms.
const SPLITTING_COST: f64 = 0.1;
/// Cost of camera paths that are weighted against light paths, over that of others.
const WEIGHTING_COST: f64 = 1.4;
/// Plan: numbers of paths for an image, and what they are expected to bring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Number of paths that continue from the first non-specular surface.
    pub splitting: u32,
    /// Number of light paths per sample.
    pub light_paths: f64,
    /// Light that light paths bring.
    pub light_path_kind: LightPathKind,
    /// Expected efficiency, as a multiple of that of plain paths.
    pub gain: f64,
    /// Cost of the pilots, as a part of that of the image.
    pub cost: f64,
}

impl Plan {
    /// Render settings with the plan's numbers of paths.
    pub fn settings(&self, settings: &RenderSettings) -> RenderSettings {
        RenderSettings {
            splitting: Some(self.splitting),
            light_paths: Some(self.light_paths),
            light_path_kind: Some(self.light_path_kind),
            ..settings.clone()
        }
    }
}

/// Variance of a sensor's noise in each channel of an image, from its light; `None` where that gives no exposure.
pub type SensorNoise<'a> = dyn Fn(&Planes) -> Option<Planes> + 'a;

/// Whether the planner may choose light paths for an image of that many pixels.
pub fn may_plan_light_paths(settings: &RenderSettings, scene: &Scene, camera: &Camera, pixels: u64) -> bool {
    is_planned(settings, pixels)
        && settings.light_paths.is_none()
        && !camera.moves()
        && !camera.scans()
        && camera.makes_image()
        && settings.max_depth > 2
        && scene.lights().has_emitters()
}

/// Whether settings leave something to be chosen, and an image of that many pixels has samples to spare.
fn is_planned(settings: &RenderSettings, pixels: u64) -> bool {
    let RenderSettings { strategy, wavelengths, max_depth, .. } = *settings;
    strategy == StrategyChoice::Auto
        && wavelengths == WavelengthChoice::AllFilters
        && max_depth > 1
        && expected_samples(settings, pixels) >= FEWEST_SAMPLES
}

/// Samples of an image, as far as they are known before it is begun.
fn expected_samples(settings: &RenderSettings, pixels: u64) -> u64 {
    let may_stop = settings.time_limit_s.is_some() || settings.noise_target.is_some();
    pixels * u64::from(settings.samples_per_pixel.min(if may_stop { MOST_EXPECTED } else { u32::MAX }))
}

/// Finds the plan of an image; `None` where there is nothing to choose, where the image has too few samples to spare any,
/// and where `step` breaks off. `responses` are those of the channels that count, and `noise` tells the variance of the
/// sensor's noise at some light, ∞ where none shows; without it, errors count relative to the light.
pub fn plan(
    job: &RenderJob<'_>,
    responses: &FilmResponses,
    noise: Option<&SensorNoise<'_>>,
    step: &Listener<'_>,
) -> Option<Plan> {
    if !is_planned(job.settings, job.pixels()) {
        return None;
    }
    // What is not kept is no progress.
    let only_stops = |told: Step<'_>| {
        if matches!(told, Step::Band { .. }) { step(Step::Band { paths: 0 }) } else { step(told) }
    };
    Planner::new(job, responses, &only_stops).plan(noise)
}

/// Variance and cost of one sample.
#[derive(Clone, Copy, Debug)]
struct Figures {
    variance: f64,
    cost: f64,
}

impl Figures {
    /// Product whose reciprocal is the efficiency.
    fn product(self) -> f64 {
        self.variance * self.cost
    }
}

struct Planner<'a> {
    pilots: PilotSamples<'a>,
    /// Samples of the image.
    samples: u64,
}

impl<'a> Planner<'a> {
    fn new(job: &'a RenderJob<'a>, responses: &'a FilmResponses, step: &'a Listener<'a>) -> Self {
        let samples = expected_samples(job.settings, job.pixels());
        let pilot = (samples / SHARE).clamp(FEWEST_PILOT_SAMPLES, MOST_PILOT_SAMPLES);
        // Of few pixels each can have more.
        let of_pixel = (pilot / (SETS * job.pixels().max(1))).min(u64::from(u32::MAX)) as u32;
        let set = of_pixel.max(LARGEST_SET).min(job.settings.samples_per_pixel / 2).max(1);
        let pixels = (pilot / (SETS * u64::from(set))).max(1);
        let stride = ((job.pixels() / pixels).isqrt() as usize).max(1);
        let cells = job.resolution.map(|n| (n as usize).div_ceil(stride));
        let is_open = may_plan_light_paths(job.settings, job.scene, job.camera, job.pixels());
        let set_to = job.settings.light_paths();
        let kinds = LightPathKind::of(job.scene);
        let of_each_kind = |number: f64| kinds.iter().map(move |&kind| LightPaths { number, kind });
        let none = LightPaths { number: 0.0, kind: kinds[0] };
        let light_paths = match (is_open, set_to > 0.0) {
            (true, _) => [none].into_iter().chain(LIGHT_PATHS.into_iter().flat_map(of_each_kind)).collect(),
            (false, true) => of_each_kind(set_to).collect(),
            (false, false) => vec![none],
        };
        // What is found of all indirect light tells of caustics, too.
        let pilot_light_paths = LightPaths {
            number: if is_open { PILOT_LIGHT_PATHS } else { set_to },
            kind: light_paths.last().map_or(none.kind, |light_paths| light_paths.kind),
        };
        let pilots = PilotSamples {
            job,
            responses,
            step,
            set,
            traced_light_paths: pilot,
            pilot_light_paths,
            light_paths,
            stride,
            cells,
        };
        Self { pilots, samples }
    }

    /// Finds the plan; `None` where there is nothing to choose, and where that is broken off.
    fn plan(&self, noise: Option<&SensorNoise<'_>>) -> Option<Plan> {
        let settings = self.pilots.job.settings;
        let splits = settings.splitting.is_none() && self.may_split();
        if !splits && self.pilots.light_paths.len() == 1 {
            return None;
        }
        let one = self.pilots.measure(settings.splitting())?;
        let light = self.light(&one);
        let metric = noise.and_then(|noise| self.sensor_metric(&light, noise)).unwrap_or_else(|| self.metric(&light));
        let more = if splits { Some(self.pilots.measure(PILOT_BRANCHES)?) } else { None };
        let branches = if splits { BRANCHES.to_vec() } else { vec![settings.splitting()] };

        // Compare all pairs of numbers
        let mut ways = Vec::new();
        for (index, &light_paths) in self.pilots.light_paths.iter().enumerate() {
            let of_one = self.figures(&one, &metric, index);
            let of_more = more.as_ref().map_or(of_one, |more| self.figures(more, &metric, index));
            ways.extend(branches.iter().map(|&branches| (between([of_one, of_more], branches), branches, light_paths)));
        }
        let simplest @ (plain, ..) = ways[0];
        let best = ways.iter().map(|(figures, ..)| figures.product()).fold(f64::INFINITY, f64::min);

        // Take the cheapest samples of those that are nearly the best
        ways.sort_by(|(a, ..), (b, ..)| a.cost.total_cmp(&b.cost));
        let is_near = |(figures, ..): &&(Figures, u32, LightPaths)| figures.product() <= TOLERANCE * best;
        let chosen = *ways.iter().find(is_near).unwrap_or(&simplest);
        let pays = chosen.0.product() * LEAST_GAIN <= plain.product();
        let (figures, splitting, light_paths) = if pays { chosen } else { simplest };
        let gain = if figures.product() > 0.0 { plain.product() / figures.product() } else { 1.0 };
        let spent = one.spent + more.map_or(0.0, |more| more.spent);
        let LightPaths { number: light_paths, kind: light_path_kind } = light_paths;
        let cost = spent / (figures.cost * self.samples as f64);
        Some(Plan { splitting, light_paths, light_path_kind, gain, cost })
    }

    /// Whether paths may split without losing their wavelengths.
    fn may_split(&self) -> bool {
        !(self.pilots.job.scene.disperses() && self.pilots.job.camera.lands_wavelengths())
    }

    /// Light of each cell and channel, from what a pilot has found in the cell and about it.
    fn light(&self, measured: &Measured) -> Vec<f64> {
        let channels = self.pilots.responses.len();
        let found = measured.means.iter().zip(&measured.brought);
        let found: Vec<f64> = found.map(|(sets, brought)| sets.iter().sum::<f64>() / SETS as f64 + brought).collect();
        let [columns, rows] = self.pilots.cells;
        let near = |i: usize, length: usize| i.saturating_sub(1)..length.min(i + 2);
        let smooth = |i: usize| {
            let (channel, cell) = (i % channels, i / channels);
            let (x, y) = (near(cell % columns, columns), near(cell / columns, rows));
            let about = (x.len() * y.len()) as f64;
            let sum: f64 = y
                .flat_map(|y| x.clone().map(move |x| y * columns + x))
                .map(|cell| found[cell * channels + channel])
                .sum();
            // As much of the pixel itself as of those about it.
            0.5 * (found[i] + sum / about)
        };
        (0..found.len()).map(smooth).collect()
    }

    /// Metric of each cell and channel where errors count relative to the light.
    fn metric(&self, light: &[f64]) -> Vec<f64> {
        let channels = self.pilots.responses.len();
        let mut all = vec![0.0; channels];
        light.iter().enumerate().for_each(|(i, light)| all[i % channels] += light);
        let mean = |i: usize| all[i % channels] * channels as f64 / light.len() as f64;
        light.iter().enumerate().map(|(i, light)| light.powi(2) + DARK * mean(i).powi(2)).collect()
    }

    /// Metric of each cell and channel where errors count relative to the noise of the sensor.
    fn sensor_metric(&self, light: &[f64], noise: &SensorNoise<'_>) -> Option<Vec<f64>> {
        let [columns, rows] = self.pilots.cells;
        let names = self.pilots.responses.names();
        let channel = |(channel, name): (usize, &String)| Channel {
            name: name.clone(),
            data: light.iter().skip(channel).step_by(names.len()).map(|&light| light as f32).collect(),
        };
        let light = Planes::new(columns, rows, names.iter().enumerate().map(channel).collect()).ok()?;
        let noise = noise(&light)?;
        let of_cell = |cell: usize| noise.channels().iter().map(move |channel| f64::from(channel.data[cell]));
        Some((0..columns * rows).flat_map(of_cell).collect())
    }

    /// Variance and cost of a sample as a pilot tells of them, with the light paths of that index.
    fn figures(&self, measured: &Measured, metric: &[f64], index: usize) -> Figures {
        let channels = self.pilots.responses.len();
        let of_sets = |sets: &[f64; 2]| 0.5 * f64::from(self.pilots.set) * (sets[0] - sets[1]).powi(2);
        let ratio = |i: usize| {
            let variance = (of_sets(&measured.means[i]) + measured.beside[index][i]).max(0.0);
            if metric[i] > 0.0 { variance / metric[i] } else { 0.0 }
        };
        let mut cells: Vec<f64> =
            (0..metric.len()).step_by(channels).map(|first| (first..first + channels).map(ratio).sum()).collect();
        cells.sort_by(f64::total_cmp);
        let kept = cells.len() - (LEFT_OUT * cells.len() as f64).ceil() as usize;
        let variance = cells[..kept].iter().sum::<f64>() / (kept.max(1) * channels) as f64;
        let light_cost = measured.light_costs[index];
        let cost =
            if light_cost > 0.0 { WEIGHTING_COST * measured.camera_cost + light_cost } else { measured.camera_cost };
        Figures { variance, cost }
    }
}

/// Figures for a number of branches, from those of one and of [`PILOT_BRANCHES`].
fn between([one, more]: [Figures; 2], branches: u32) -> Figures {
    let (pilot, s) = (f64::from(PILOT_BRANCHES), f64::from(branches));
    let cost_of_branch = ((more.cost - one.cost) / (pilot - 1.0)).max(0.0);
    let splitting = if branches > 1 { SPLITTING_COST * one.cost } else { 0.0 };
    let cost = one.cost + splitting + cost_of_branch * (s - 1.0);
    let variance = if s <= pilot {
        // Branches of Sobol points may bring more than as many independent ones.
        one.variance * (more.variance / one.variance.max(f64::MIN_POSITIVE)).min(1.0).powf(s.ln() / pilot.ln())
    } else {
        let stays = ((pilot * more.variance - one.variance) / (pilot - 1.0))
            .max(LEAST_STAYING * more.variance)
            .min(more.variance);
        stays + (more.variance - stays) * pilot / s
    };
    Figures { variance, cost }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_lessen_what_comes_from_beyond_the_first_surface() {
        let [one, more] = [1.0, 4.0].map(|s| Figures { variance: 2.0 + 6.0 / s, cost: 1.0 + 3.0 * s });
        for branches in [1, 4, 8, 16] {
            let s = f64::from(branches);
            let Figures { variance, cost } = between([one, more], branches);
            assert!((variance - (2.0 + 6.0 / s)).abs() < 1e-12, "{branches}: {variance}");
            let splitting = if branches > 1 { SPLITTING_COST * one.cost } else { 0.0 };
            assert!((cost - (1.0 + 3.0 * s + splitting)).abs() < 1e-12, "{branches}: {cost}");
        }
        // Nothing is split in the settings of one number.
        assert_eq!(between([one, one], 1).product(), one.product());
    }
}
