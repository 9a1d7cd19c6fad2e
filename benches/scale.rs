//! Costs of large scenes: time to build, memory, and time a ray.
//!
//!     cargo bench --bench scale                   meshes of 1 and 10, instances of 1, 10 and 100 million triangles; 10⁵ lamps
//!     cargo bench --bench scale -- mesh:100       a mesh of 100 million: 17 GB
//!     cargo bench --bench scale -- lamps:1000000
//!
//! A mesh is the bumpy sphere in finer and finer triangles, seen from within; instances are 125 such spheres in a room,
//! with so many triangles together. Each scene has a process of its own. Memory is the most that was in use while the
//! scene was built, the description that it was built from included, by Linux's account, over the number of triangles
//! that are stored. Prints tables in Markdown; fails where a mesh takes more memory than it may.

#[path = "parts/kitchen.rs"]
#[allow(dead_code, reason = "for other benches")]
mod kitchen;
#[path = "parts/rays.rs"]
#[allow(dead_code, reason = "some is for other benches")]
mod rays;
#[path = "parts/scenes.rs"]
#[allow(dead_code, reason = "some is for other benches")]
mod scenes;

use std::env;
use std::fmt::Display;
use std::hint::black_box;
use std::process::{Command, ExitCode};
use std::time::Instant;

use glam::{BVec3, DAffine3, DVec3, Vec3};
use photosite::math::hash::{hash64, unit_f32};
use photosite::scene;
use photosite::scene::description::{
    Colour, EmissionDescription, InstanceDescription, MeshDescription, SceneDescription,
};
use rays::{Kind, Stage};

const LIMIT_BYTES: f64 = 150.0;
/// For ten times the triangles.
const LIMIT_RATIO: f64 = 1.5;
const CASES: [&str; 6] = ["mesh:1", "mesh:10", "instances:1", "instances:10", "instances:100", "lamps:100000"];
/// Asks for the figures of one case instead of tables.
const FIGURES: &str = "figures-of";
const RUNS: usize = 9;
/// Spheres along each side of the room.
const SIDE: u32 = 5;

fn main() -> ExitCode {
    let words: Vec<_> = env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    if let [FIGURES, case] = words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        return measure(case);
    }
    let cases = if words.is_empty() { CASES.map(str::to_owned).to_vec() } else { words };
    let measured: Option<Vec<_>> = cases.iter().map(|case| Some((case.as_str(), figures_of(case)?))).collect();
    let Some(measured) = measured else { return ExitCode::FAILURE };
    tables(&measured)
}

/// The figures of a case from a process of its own: stored triangles, seconds, bytes at most, bytes then, and
/// nanoseconds a ray of each kind.
fn figures_of(case: &str) -> Option<Vec<f64>> {
    let done = Command::new(env::current_exe().ok()?).args([FIGURES, case]).output().ok()?;
    let text = String::from_utf8_lossy(&done.stdout).into_owned();
    if !done.status.success() {
        println!("{case} cannot be measured: {text}");
        return None;
    }
    text.split_whitespace().map(|word| word.parse().ok()).collect()
}

fn measure(case: &str) -> ExitCode {
    let Some((kind, Ok(size))) = case.split_once(':').map(|(kind, size)| (kind, size.parse())) else {
        println!("say mesh:MILLIONS, instances:MILLIONS or lamps:COUNT");
        return ExitCode::FAILURE;
    };
    let watch = Watch::start();
    let (description, eye, forward) = match kind {
        "mesh" => (sphere(f64::from(size) * 1e6), Vec3::new(0.0, 0.0, 0.5), Vec3::NEG_Z),
        "instances" => (instances(size), Vec3::splat(1.1), Vec3::ONE.normalize()),
        "lamps" => (lamps(size), Vec3::new(50.0, 5.0, 50.0), Vec3::X),
        _ => {
            println!("there is no {kind}");
            return ExitCode::FAILURE;
        }
    };
    let triangles: usize = description.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let start = Instant::now();
    let scene = scene::build(description, &scenes::visible());
    let seconds = start.elapsed().as_secs_f64();
    println!("{triangles} {seconds} {} {}", watch.grown("VmHWM"), watch.grown("VmRSS"));
    let stage = Stage::new(scene, eye, forward, 0.6, eye + 0.3);
    for kind in Kind::ALL {
        println!("{}", nanoseconds(&stage, kind));
    }
    ExitCode::SUCCESS
}

/// Prints the figures, and says by the exit status whether meshes keep to their memory.
fn tables(measured: &[(&str, Vec<f64>)]) -> ExitCode {
    println!("Memory: at most {LIMIT_BYTES} bytes a triangle of a mesh.\n");
    println!("| scene | stored triangles | build, s | bytes a triangle, at most | then | |");
    println!("|---|---|---|---|---|---|");
    let mut passed = true;
    for (case, figures) in measured {
        let [triangles, seconds, most, then, ..] = figures[..] else { return ExitCode::FAILURE };
        let most = most / triangles;
        let is_mesh = case.starts_with("mesh");
        passed &= !is_mesh || most <= LIMIT_BYTES;
        let verdict = if is_mesh { verdict(most <= LIMIT_BYTES) } else { "" };
        println!("| {} | {triangles} | {seconds:.2} | {most:.0} | {:.0} | {verdict} |", name(case), then / triangles);
    }
    println!("\nNanoseconds a ray on one thread. Ten times the triangles: at most {LIMIT_RATIO} times the time.\n");
    println!("| scene | {} | |", join(Kind::ALL));
    println!("|---|{}---|", "---|".repeat(Kind::ALL.len()));
    let mut before: Option<(&str, &[f64])> = None;
    for (case, figures) in measured {
        let (kind, times) = (case.split(':').next().unwrap_or(case), &figures[4..]);
        println!("| {} | {} | |", name(case), join(times.iter().map(|time| format!("{time:.0}"))));
        if let Some((_, smaller)) = before.filter(|(smaller, _)| *smaller == kind) {
            let ratios: Vec<_> = times.iter().zip(smaller).map(|(larger, smaller)| larger / smaller).collect();
            let reached = ratios.iter().all(|ratio| *ratio <= LIMIT_RATIO);
            println!("| – ratio | {} | {} |", join(ratios.iter().map(|ratio| format!("{ratio:.2}"))), verdict(reached));
        }
        before = Some((kind, times));
    }
    if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn name(case: &str) -> String {
    match case.split_once(':') {
        Some(("mesh", millions)) => format!("mesh of {millions} M"),
        Some(("instances", millions)) => format!("{} instances, {millions} M", SIDE.pow(3)),
        Some((kind, count)) => format!("{count} {kind}"),
        None => case.to_owned(),
    }
}

fn verdict(reached: bool) -> &'static str {
    if reached { "reached" } else { "**not reached**" }
}

fn join(cells: impl IntoIterator<Item = impl Display>) -> String {
    cells.into_iter().map(|cell| cell.to_string()).collect::<Vec<_>>().join(" | ")
}

/// A sphere of about so many triangles.
fn sphere(triangles: f64) -> SceneDescription {
    let bands = (triangles / 3.2).sqrt();
    scenes::sphere(bands.round() as u32, (1.6 * bands).round() as u32)
}

/// Spheres in a room that they fill, of so many million triangles together. The camera stands in a gap between them.
fn instances(millions: u32) -> SceneDescription {
    const SPACING: f64 = 2.2;
    let mut scene = sphere(f64::from(millions) * 1e6 / f64::from(SIDE.pow(3)));
    let place = |i: u32| {
        let cell = DVec3::new(f64::from(i % SIDE), f64::from(i / SIDE % SIDE), f64::from(i / SIDE / SIDE));
        InstanceDescription::of_mesh(
            "",
            0,
            DAffine3::from_translation(SPACING * cell) * DAffine3::from_rotation_y(f64::from(i)),
        )
    };
    scene.instances = (0..SIDE.pow(3)).map(place).collect();
    let low = -0.5 * SPACING as f32;
    add_room(&mut scene, low, low + SPACING as f32 * SIDE as f32);
    scene
}

/// Triangles of some 2 cm that shine, all over a hall, of 16 luminances within two decades.
fn lamps(count: u32) -> SceneDescription {
    const LEVELS: u32 = 16;
    let mut scene = SceneDescription::default();
    for level in 0..LEVELS {
        let mut material = scenes::diffuse("lamp", Colour::Rgb([0.5; 3]));
        material.emission = Some(EmissionDescription {
            colour: Colour::Rgb([1.0; 3]),
            level: Some(1e3 * 100_f64.powf(f64::from(level) / f64::from(LEVELS))),
            texture: None,
        });
        scene.materials.push(material);
        let mut mesh = MeshDescription { material: level as usize, ..MeshDescription::default() };
        for i in (level..count).step_by(LEVELS as usize) {
            let random = |dimension| unit_f32(hash64(dimension, u64::from(i)) as u32);
            let vector = |first| Vec3::new(random(first), random(first + 1), random(first + 2));
            let corner = vector(0) * Vec3::new(100.0, 10.0, 100.0);
            let [u, v] = [3, 6].map(|first| 0.04 * (vector(first) - 0.5));
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([corner, corner + u, corner + v]);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        scene.instances.push(InstanceDescription::of_mesh("", scene.meshes.len(), DAffine3::IDENTITY));
        scene.meshes.push(mesh.into());
    }
    add_room(&mut scene, -1.0, 101.0);
    scene
}

/// Adds a cube around everything.
fn add_room(scene: &mut SceneDescription, low: f32, high: f32) {
    const SIDES: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let corner =
        |i: u32| Vec3::select(BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), Vec3::splat(high), Vec3::splat(low));
    let material = scene.materials.len();
    scene.materials.push(scenes::diffuse("room", Colour::Rgb([0.5; 3])));
    scene.instances.push(InstanceDescription::of_mesh("", scene.meshes.len(), DAffine3::IDENTITY));
    let mesh = MeshDescription {
        material,
        positions: (0..8).map(corner).collect(),
        triangles: SIDES.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
        ..MeshDescription::default()
    };
    scene.meshes.push(mesh.into());
}

/// Time a ray, the fastest of several passes.
fn nanoseconds(stage: &Stage, kind: Kind) -> f64 {
    let pass = || {
        let start = Instant::now();
        black_box(black_box(stage).trace(kind));
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(|_| pass()).fold(f64::INFINITY, f64::min) * 1e9 / stage.rays(kind).len() as f64
}

/// Memory from before there was a scene.
struct Watch {
    before: f64,
}

impl Watch {
    fn start() -> Self {
        Self { before: resident("VmRSS") }
    }

    /// Bytes more than at the start.
    fn grown(&self, key: &str) -> f64 {
        resident(key) - self.before
    }
}

/// An entry of `/proc/self/status` in bytes: `VmRSS` is the memory in use now, `VmHWM` the most there ever was. Not a
/// number where there is no such file.
fn resident(key: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with(key));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok()).map_or(f64::NAN, |kib| kib * 1024.0)
}
