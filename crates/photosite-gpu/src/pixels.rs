//! Samples of pixels whose paths start and end on a card.

use glam::Vec4;
use photosite_transport::integrator::{PackedFilm, PixelRun, PixelTracer};
use wgpu::util::DeviceExt;

use crate::buffers::{bind, in_room, largest_table};
use crate::film;
use crate::tracer::{Ends, Tracer};

/// Tracer of a film's pixels through a scene on a card.
pub(crate) struct FilmTracer<'a> {
    tracer: &'a Tracer,
    film: wgpu::BindGroup,
    groups: u32,
}

impl<'a> FilmTracer<'a> {
    /// Loads a film onto the card of a scene; `None` where the card has no room for it.
    pub(crate) fn new(tracer: &'a Tracer, film: &PackedFilm<'_>) -> Option<Self> {
        let device = &tracer.device;
        let ((numbers, table), groups) = (film::packed(film), film.groups);
        if (table.len() * 16) as u64 > largest_table(&device.limits()) {
            return None;
        }
        let buffer = |label, contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let bound = in_room(device, || {
            let numbers = buffer("film", bytemuck::cast_slice(&numbers), wgpu::BufferUsages::UNIFORM);
            let table = buffer("tables of the film", bytemuck::cast_slice(&table), wgpu::BufferUsages::STORAGE);
            bind(device, &tracer.kernels.layouts.film, &[&numbers, &table])
        });
        bound.ok().map(|film| Self { tracer, film, groups })
    }

    /// Traces runs of `slots` samples at most, which fit into one batch.
    fn trace_batch(&self, runs: &[PixelRun], slots: u32, values: &mut Vec<Vec4>) -> Result<(), String> {
        let mut batch = self.tracer.take();
        batch.words.clear();
        batch.words.extend(runs.iter().map(|run| [run.pixel[0], run.pixel[1], run.first, run.count]));
        let paths = runs.len() as u32 * slots;
        let ends = Ends {
            first: &self.tracer.kernels.generate_camera_rays,
            last: &self.tracer.kernels.update_film,
            film: Some(&self.film),
            threads: [paths, paths * self.groups],
            results: paths * self.groups,
        };
        let traced = self.tracer.trace_words(&batch, [paths, 0, 0, 0, 0, 0, 0, 0, slots], &ends, |bytes| {
            // Runs may be shorter than their slots.
            let of_runs = bytes.chunks_exact((slots * self.groups) as usize * size_of::<Vec4>());
            for (run, bytes) in runs.iter().zip(of_runs) {
                let count = (run.count * self.groups) as usize;
                let numbers: &[[f32; 4]] = bytemuck::cast_slice(&bytes[..count * size_of::<Vec4>()]);
                values.extend(numbers.iter().map(|&four| Vec4::from_array(four)));
            }
        });
        self.tracer.give_back(batch);
        traced
    }
}

impl PixelTracer for FilmTracer<'_> {
    fn trace(&self, runs: &[PixelRun], longest: u32, values: &mut Vec<Vec4>) -> Result<(), String> {
        values.clear();
        runs.chunks(self.batch_size(longest)).try_for_each(|runs| self.trace_batch(runs, longest, values))
    }

    fn batch_size(&self, longest: u32) -> usize {
        // Values take the place that the light of paths would.
        (self.tracer.capacity / (longest * self.groups)).max(1) as usize
    }
}
