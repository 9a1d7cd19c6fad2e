//! Light transport: how much radiance arrives along a ray ([`radiance`]), and the loop over the pixels ([`render`]),
//! which may give each pixel the samples that it needs ([`pilot`]). Paths go from the camera, in waves; others start at lights,
//! for the sake of caustics or of all indirect light.
//!
//! In: a [`Scene`](crate::scene::Scene), a camera, responses. Out: a [`Film`](crate::film::Film).

mod interaction;
mod job;
mod light_paths;
mod mis_ratio;
mod packed_film;
mod path;
mod path_tracer;
pub mod pilot;
mod progress;
mod ray_counts;
mod render;
mod settings;
mod wavefront;
mod wavelengths;

pub use job::{FilterTile, RenderJob};
pub use packed_film::{PIECES, PackedFilm};
pub use path::PathLimits;
pub use path_tracer::{Arrival, Device, LoadedDevice, PathStart, PathTracer, PixelRun, PixelTracer};
pub use pilot::Pilot;
pub use progress::{Listener, Step};
pub use render::{
    COARSE_STEP, Plan, SensorNoise, bytes_of_landings, may_plan_light_paths, plan, render, render_coarse, render_on,
    render_with_pilot,
};
pub use settings::{LightPathKind, RenderKeys, RenderSettings, StrategyChoice, WavelengthChoice};
pub use wavefront::radiance;
