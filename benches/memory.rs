//! Memory that a large mesh takes: the most that was in use while its scene was built, by Linux's account of this
//! process, and what remains. Fails where it is more than 250 bytes a triangle.
//!
//!     cargo bench --bench memory

#[path = "parts/scenes.rs"]
#[allow(dead_code, reason = "the box is for other benches")]
mod scenes;

use std::process::ExitCode;
use std::time::Instant;

use photosite::scene;

const LIMIT_BYTES: f64 = 250.0;

fn main() -> ExitCode {
    let (bands, sectors) = scenes::LARGE_SPHERE;
    let importance = scenes::visible();
    let Some(before) = resident("VmRSS") else {
        println!("no /proc/self/status: memory is not measured here");
        return ExitCode::SUCCESS;
    };
    let description = scenes::sphere(bands, sectors);
    let triangles = description.meshes[0].triangles.len() as f64;
    let described = resident("VmRSS").unwrap_or(before);

    let start = Instant::now();
    let scene = scene::build(description, &importance);
    let seconds = start.elapsed().as_secs_f64();

    let per_triangle = |bytes: f64| (bytes - before) / triangles;
    let most = per_triangle(resident("VmHWM").unwrap_or(f64::INFINITY));
    println!("{triangles} triangles built in {seconds:.2} s; bytes a triangle:");
    println!("  description  {:6.1}", per_triangle(described));
    println!("  scene        {:6.1}", per_triangle(resident("VmRSS").unwrap_or(f64::NAN)));
    println!("  at most      {most:6.1} (limit {LIMIT_BYTES})");
    drop(scene);
    if most > LIMIT_BYTES { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// An entry of `/proc/self/status` in bytes: `VmRSS` is the memory in use now, `VmHWM` the most there ever was.
fn resident(key: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with(key))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? * 1024.0)
}
