//! Samples of pixels whose paths start and end on a card.

use photosite_transport::film::ShiftedSums;
use photosite_transport::integrator::{PackedFilm, PixelRun, PixelTracer};
use wgpu::util::DeviceExt;

use crate::buffers::bind;
use crate::film;
use crate::tracer::{Ends, Tracer};

/// Results of a run and a group of four channels, in words of 16 bytes.
const RESULTS: u32 = 3;

/// Tracer of a film's pixels through a scene on a card.
pub(crate) struct FilmTracer<'a> {
    tracer: &'a Tracer,
    film: wgpu::BindGroup,
    groups: u32,
}

impl<'a> FilmTracer<'a> {
    /// Loads a film onto the card of a scene.
    ///
    /// # Errors
    ///
    /// Words on why the card has no room for it.
    pub(crate) fn new(tracer: &'a Tracer, film: &PackedFilm<'_>) -> Result<Self, String> {
        let device = &tracer.device;
        let (numbers, table) = film::packed(film);
        let scope = device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let buffer = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let numbers = buffer("film", bytemuck::cast_slice(&numbers), wgpu::BufferUsages::UNIFORM);
        let table = buffer("tables of the film", bytemuck::cast_slice(&table), wgpu::BufferUsages::STORAGE);
        let bound = bind(device, &tracer.kernels.layouts.film, &[&numbers, &table]);
        match pollster::block_on(scope.pop()) {
            Some(error) => Err(error.to_string()),
            None => Ok(Self { tracer, film: bound, groups: film.groups }),
        }
    }

    /// Traces runs of `slots` samples at most, which fit into one batch.
    fn trace_batch(&self, runs: &[PixelRun], slots: u32, sums: &mut Vec<ShiftedSums>) -> Result<(), String> {
        let mut batch = self.tracer.take();
        batch.words.clear();
        batch.words.extend(runs.iter().map(|run| [run.pixel[0], run.pixel[1], run.first, run.count]));
        let (paths, summed) = (runs.len() as u32 * slots, runs.len() as u32 * self.groups);
        let ends = Ends {
            first: &self.tracer.kernels.generate_camera_rays,
            last: &self.tracer.kernels.update_film,
            film: Some(&self.film),
            threads: [paths, summed],
            results: summed * RESULTS,
        };
        let traced = self.tracer.trace_words(&batch, [paths, 0, 0, 0, 0, 0, 0, 0, slots], &ends, |bytes| {
            let numbers: Vec<[[f32; 4]; RESULTS as usize]> = bytemuck::pod_collect_to_vec(bytes);
            let of_group = |[first, differences, squares]: [[f32; 4]; 3]| ShiftedSums { first, differences, squares };
            sums.extend(numbers.into_iter().map(of_group));
        });
        self.tracer.give_back(batch);
        traced
    }
}

impl PixelTracer for FilmTracer<'_> {
    fn trace(&self, runs: &[PixelRun], longest: u32, sums: &mut Vec<ShiftedSums>) -> Result<(), String> {
        sums.clear();
        runs.chunks(self.batch_size(longest)).try_for_each(|runs| self.trace_batch(runs, longest, sums))
    }

    fn batch_size(&self, longest: u32) -> usize {
        // Results take the place that the light of paths would.
        (self.tracer.capacity / longest.max(RESULTS * self.groups)).max(1) as usize
    }
}
