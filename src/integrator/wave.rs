//! Paths that are traced together, from surface to surface: first the rays of all, then what each does where it has come to,
//! then their shadow rays. While the memory brings what one ray needs, others go on, and each part of the code runs for all
//! paths before the next one takes its place.

use super::path::{Left, Path, PathLimits};
use crate::geometry::{Geometry, Hit, Ray};
use crate::sampler::{SamplePlace, Sampler};
use crate::scene::Scene;
use crate::spectrum::{SampledSpectrum, Wavelengths};

/// An estimate of the radiance that arrives against the ray's unit direction, W·m⁻²·sr⁻¹·nm⁻¹ at each wavelength, by one path
/// with the numbers from where the sampler is. A refraction that disperses leaves only the hero of `wavelengths`.
pub fn radiance(
    scene: &Scene,
    ray: Ray,
    wavelengths: &mut Wavelengths,
    sampler: &mut Sampler,
    limits: PathLimits,
) -> SampledSpectrum {
    let mut wave = Wave::new(limits);
    wave.start(ray, *wavelengths, sampler.place());
    wave.trace(scene, sampler);
    let (light, left) = wave.arrived(0);
    *wavelengths = left;
    light
}

/// Paths that are traced together.
pub(super) struct Wave {
    limits: PathLimits,
    /// Those that were started, and then the branches of those that have split.
    paths: Vec<Path>,
    /// Sums over the branches of each path that was started.
    branched: Vec<SampledSpectrum>,
    front: Front,
    /// What becomes the front.
    next: Front,
    hits: Vec<Option<Hit>>,
    left: Left,
    occluded: Vec<bool>,
}

/// Paths that have not come to their ends, by their numbers, and where they go.
#[derive(Default)]
struct Front {
    numbers: Vec<u32>,
    rays: Vec<Ray>,
}

impl Front {
    fn clear(&mut self) {
        self.numbers.clear();
        self.rays.clear();
    }

    #[inline]
    fn push(&mut self, number: u32, ray: Ray) {
        self.numbers.push(number);
        self.rays.push(ray);
    }
}

/// Asks the memory for the corners of triangles that paths soon come to, and before that for where those are.
#[inline]
fn ask_for_corners(geometry: &Geometry, hits: &[Option<Hit>]) {
    const SOON: usize = 4;
    if let Some(Some(hit)) = hits.get(2 * SOON) {
        geometry.prefetch_triangle(hit.triangle);
    }
    if let Some(Some(hit)) = hits.get(SOON) {
        geometry.prefetch_corners(hit.triangle);
    }
}

impl Wave {
    /// Without paths.
    pub(super) fn new(limits: PathLimits) -> Self {
        Self {
            limits,
            paths: Vec::new(),
            branched: Vec::new(),
            front: Front::default(),
            next: Front::default(),
            hits: Vec::new(),
            left: Left::default(),
            occluded: Vec::new(),
        }
    }

    /// Adds a path from the camera, with the numbers from a place on.
    #[inline]
    pub(super) fn start(&mut self, ray: Ray, wavelengths: Wavelengths, place: SamplePlace) {
        self.front.push(self.paths.len() as u32, ray);
        self.paths.push(Path::new(wavelengths, place, self.limits.splitting > 1));
    }

    /// Number of paths that were started, before they are traced.
    pub(super) fn len(&self) -> usize {
        self.paths.len()
    }

    /// Traces all that were started to their ends.
    pub(super) fn trace(&mut self, scene: &Scene, sampler: &mut Sampler) {
        let started = self.paths.len();
        if self.limits.max_depth == 0 {
            self.front.clear();
        }
        while !self.front.numbers.is_empty() {
            self.advance(scene, sampler);
        }
        self.branched.clear();
        self.branched.resize(started, SampledSpectrum::ZERO);
        let (started, branches) = self.paths.split_at(started);
        for (branch, &origin) in branches.iter().zip(&self.left.origins) {
            let densities = branch.wavelengths.densities_over(&started[origin as usize].wavelengths);
            self.branched[origin as usize] += branch.light * densities;
        }
    }

    /// All paths that go on, from one surface to the next.
    fn advance(&mut self, scene: &Scene, sampler: &mut Sampler) {
        let Self { limits, paths, front, next, hits, left, .. } = self;
        scene.closest_of_each(&front.rays, hits);
        let looks_ahead = scene.geometry().exceeds_caches();
        for (i, ((&number, ray), &hit)) in front.numbers.iter().zip(&front.rays).zip(&*hits).enumerate() {
            if looks_ahead {
                ask_for_corners(scene.geometry(), &hits[i..]);
            }
            let path = &mut paths[number as usize];
            if let Some(ray) = path.advance(number, (ray, hit), scene, limits, sampler, left) {
                next.push(number, ray);
            }
        }
        for (path, ray) in left.branches.drain(..).zip(left.branch_rays.drain(..)) {
            next.push(paths.len() as u32, ray);
            paths.push(path);
        }
        front.clear();
        std::mem::swap(front, next);
        self.light_up(scene);
    }

    /// Gives light that nothing is in the way of to its paths.
    fn light_up(&mut self, scene: &Scene) {
        let Self { paths, left: Left { shadow_rays, lights, .. }, occluded, .. } = self;
        scene.occluded_each(shadow_rays, occluded);
        for ((number, light), occluded) in lights.drain(..).zip(&*occluded) {
            if !occluded {
                paths[number as usize].light += light;
            }
        }
        shadow_rays.clear();
    }

    /// What has arrived along a path that was started, and with which wavelengths.
    pub(super) fn arrived(&self, number: usize) -> (SampledSpectrum, Wavelengths) {
        let Path { light, wavelengths, .. } = self.paths[number];
        (light + self.branched[number] * (1.0 / self.limits.splitting as f32), wavelengths)
    }

    /// Makes room for other paths.
    pub(super) fn clear(&mut self) {
        self.paths.clear();
        self.left.origins.clear();
    }
}
