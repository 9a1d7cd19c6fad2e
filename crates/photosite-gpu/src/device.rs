//! A card as a device of renders: it loads scenes, and traces paths whose starts the processor has made.

use std::sync::atomic::Ordering;

use photosite_core::Invalid;
use photosite_core::spectrum::SampledSpectrum;
use photosite_transport::integrator::{Arrival, Device, PackedFilm, PathLimits, PathStart, PathTracer, PixelTracer};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::Scene;

use crate::adapters::Card;
use crate::pixels::FilmTracer;
use crate::shaders::START_WORDS;
use crate::tracer::{Batch, Ends, Tracer, word};

/// Bits in the second place of light whose hero is alone.
const HERO_ALONE: u32 = 0x7fc0_0000;

impl Device for Card {
    fn name(&self) -> String {
        self.adapter().to_string()
    }

    fn load(&self, scene: &Scene, limits: PathLimits, sampler: SamplerKind) -> Result<Box<dyn PathTracer>, Invalid> {
        let packed = scene.packed().map_err(|error| error.help("render with --device cpu"))?;
        Ok(Box::new(Tracer::new(self, &packed, limits, sampler)?))
    }
}

impl PathTracer for Tracer {
    fn trace(&self, starts: &[PathStart], arrivals: &mut Vec<Arrival>) -> Result<(), String> {
        arrivals.clear();
        if self.max_depth == 0 {
            let dark = |start: &PathStart| Arrival {
                light: SampledSpectrum::ZERO,
                is_hero_alone: start.wavelengths.is_hero_alone(),
            };
            arrivals.extend(starts.iter().map(dark));
            return Ok(());
        }
        for starts in starts.chunks(self.capacity as usize) {
            let mut batch = self.take();
            let traced = trace_batch(self, &mut batch, starts, arrivals);
            self.give_back(batch);
            traced?;
        }
        Ok(())
    }

    fn batch_size(&self) -> usize {
        self.capacity as usize
    }

    fn pixels<'a>(&'a self, film: &PackedFilm<'_>) -> Result<Option<Box<dyn PixelTracer + 'a>>, String> {
        Ok(FilmTracer::new(self, film).map(|film| -> Box<dyn PixelTracer + 'a> { Box::new(film) }))
    }

    fn rays(&self) -> [u64; 2] {
        self.rays.each_ref().map(|rays| rays.load(Ordering::Relaxed))
    }
}

/// Traces a batch of paths whose starts the host has made.
fn trace_batch(
    tracer: &Tracer,
    batch: &mut Batch,
    starts: &[PathStart],
    arrivals: &mut Vec<Arrival>,
) -> Result<(), String> {
    batch.words.clear();
    batch.words.extend(starts.iter().flat_map(start_words));
    let count = starts.len() as u32;
    let ends = Ends {
        first: &tracer.kernels.generate,
        last: &tracer.kernels.arrive,
        film: None,
        threads: [count, count],
        results: count,
    };
    tracer.trace_words(batch, [count, count, 0, 0, 0, 0, count, 0, 1], &ends, |bytes| {
        arrivals.extend(bytes.chunks_exact(16).map(arrival));
    })
}

/// Start of a path as the kernels read it: origin, and the time; direction, and whether the hero is alone; wavelengths;
/// random numbers.
fn start_words(start: &PathStart) -> [[u32; 4]; START_WORDS as usize] {
    let PathStart { ray, wavelengths, position } = start;
    let [x, y, z] = ray.origin.to_array().map(f32::to_bits);
    let [dx, dy, dz] = ray.direction.to_array().map(f32::to_bits);
    let is_alone = u32::from(wavelengths.is_hero_alone());
    [
        [x, y, z, ray.time.to_bits()],
        [dx, dy, dz, is_alone],
        wavelengths.lambdas_nm().map(f32::to_bits),
        position.words(),
    ]
}

/// Light of a path as the kernels leave it.
fn arrival(bytes: &[u8]) -> Arrival {
    let bits = [0, 4, 8, 12].map(|at| word(&bytes[at..]));
    let is_hero_alone = bits[1] == HERO_ALONE;
    let lanes = bits.map(f32::from_bits);
    let light = if is_hero_alone { [lanes[0], 0.0, 0.0, 0.0] } else { lanes };
    Arrival { light: SampledSpectrum::from(light), is_hero_alone }
}
