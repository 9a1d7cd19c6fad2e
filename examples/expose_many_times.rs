//! Light is traced once and exposed many times: a series of exposure times, two frames each, for a photon transfer
//! curve. A monitor hears of the tracing.
//!
//! `cargo run --release --example expose_many_times`

use std::sync::atomic::{AtomicU64, Ordering};

use photosite::keys::{ExposureKeys, RenderKeys};
use photosite::pipeline::{Event, Monitor, Prepared};
use photosite::{Capture, Options};

/// Counts camera paths, and stops after a minute's worth of them.
#[derive(Default)]
struct Counter {
    paths: AtomicU64,
}

impl Monitor for Counter {
    fn report(&self, event: Event<'_>) {
        match event {
            Event::Warning(warning) => eprintln!("warning: {warning}"),
            Event::Traced(paths) => {
                self.paths.fetch_add(paths, Ordering::Relaxed);
            }
            Event::TraceBegins { .. }
            | Event::PassEnds { .. }
            | Event::TraceEnds
            | Event::SetBegins { .. }
            | Event::ImageFails { .. }
            | Event::ImageEnds(_)
            | Event::Waiting { .. }
            | Event::SetEnds => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        self.paths.load(Ordering::Relaxed) > 60_000_000
    }
}

fn main() -> photosite::Result<()> {
    let quick = Capture::builder().render(RenderKeys::new().samples_per_pixel(32));
    let capture = Capture::load_with("scenes/cornell-box/capture.toml".as_ref(), &quick)?;
    let monitor = Counter::default();
    let prepared = Prepared::new(capture)?;
    let light = prepared.trace(Options { monitor: &monitor, ..Options::default() })?;
    if let Some(traced) = light.traced() {
        println!("traced {} paths in {:.1} s", traced.paths, traced.trace_s);
    }

    println!("{:>9} {:>9} {:>11}", "time, ms", "mean, DN", "variance, DN²");
    for time_ms in [1.0, 2.0, 4.0, 8.0, 16.0] {
        let exposure = ExposureKeys::new().time_s(time_ms / 1e3);
        let exposed = light.with(&Capture::builder().exposure(exposure))?;
        // The difference of two frames has twice the temporal noise, and nothing of the scene.
        let [one, two] = [exposed.frame(0, &[])?.raw, exposed.frame(1, &[])?.raw];
        let count = one.data.len() as f64;
        let mean = one.data.iter().map(|&dn| f64::from(dn)).sum::<f64>() / count;
        let squares = one.data.iter().zip(&two.data).map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2));
        println!("{time_ms:>9} {mean:>9.1} {:>11.1}", squares.sum::<f64>() / count / 2.0);
    }
    Ok(())
}
