//! What large scenes cost: time to build, memory, and time a ray.
//!
//!     cargo bench --bench scale                        1 and 10 million triangles, instanced and not, and 10⁵ lights
//!     cargo bench --bench scale -- mesh 100            a mesh of 100 million: 15 GB
//!     cargo bench --bench scale -- instances 100       100 million as instances of a mesh of one million
//!     cargo bench --bench scale -- lights 1000000
//!
//! Meshes are the bumpy sphere in finer and finer triangles, instances a grid of such spheres. Each scene has a process of
//! its own. Memory is the most that was in use while the scene was built, description included, by Linux's account, over
//! the number of triangles. Prints tables in Markdown; fails where a mesh takes more than 150 bytes a triangle.

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
use std::hint::black_box;
use std::process::{Command, ExitCode};
use std::time::Instant;

use glam::{DAffine3, DVec3, Vec3};
use photosite::math::hash::hash64;
use photosite::scene;
use photosite::scene::description::{
    Colour, EmissionDescription, InstanceDescription, MeshDescription, SceneDescription,
};
use photosite::spectrum::WavelengthSampler;
use rays::{Kind, Stage};

const LIMIT_BYTES: f64 = 150.0;
const RUNS: usize = 5;

fn main() -> ExitCode {
    let words: Vec<_> = env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let number = |word: &String| word.parse::<u32>().ok();
    match words.as_slice() {
        [] => all(),
        [kind, size] => match (kind.as_str(), number(size)) {
            ("mesh", Some(millions)) => mesh(millions),
            ("instances", Some(millions)) => instances(millions),
            ("lights", Some(count)) => lights(count),
            _ => usage(),
        },
        _ => usage(),
    }
}

fn usage() -> ExitCode {
    println!("what to measure: mesh MILLIONS, instances MILLIONS, lights COUNT, or nothing for all");
    ExitCode::FAILURE
}

/// Every case in a process of its own, one after the other.
fn all() -> ExitCode {
    let mut passed = true;
    for [kind, size] in [["mesh", "1"], ["mesh", "10"], ["instances", "10"], ["instances", "100"], ["lights", "100000"]]
    {
        let program = env::current_exe().expect("this program has a path");
        passed &= Command::new(program).args([kind, size]).status().is_ok_and(|status| status.success());
    }
    if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Bands and sectors of a sphere of so many triangles.
fn bands_and_sectors(triangles: f64) -> (u32, u32) {
    let bands = (triangles / 3.2).sqrt().round();
    (bands as u32, (1.6 * bands).round() as u32)
}

fn mesh(millions: u32) -> ExitCode {
    let (bands, sectors) = bands_and_sectors(f64::from(millions) * 1e6);
    let watch = Watch::start();
    let description = scenes::sphere(bands, sectors);
    let triangles = description.meshes[0].triangles.len();
    let (built, scene) = watch.build(description);
    let bytes = built.most_bytes / triangles as f64;
    println!("\n| mesh | build, s | bytes a triangle, at most | limit | then |\n|---|---|---|---|---|");
    let then = built.bytes_then / triangles as f64;
    println!("| {triangles} triangles | {:.2} | {bytes:.1} | {LIMIT_BYTES} | {then:.1} |", built.seconds);
    time_rays(&Stage::new(scene, Vec3::new(0.0, 0.0, 0.5), Vec3::NEG_Z, 0.6, Vec3::new(0.3, 0.5, 0.2)));
    if bytes > LIMIT_BYTES { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Spheres of a million triangles in a room that they fill.
fn instances(millions: u32) -> ExitCode {
    let (bands, sectors) = bands_and_sectors(1e6);
    let watch = Watch::start();
    let mut description = scenes::sphere(bands, sectors);
    let triangles = description.meshes[0].triangles.len();
    let side = f64::from(millions).cbrt().ceil() as u32;
    let place = |i: u32| {
        let cell = DVec3::new(f64::from(i % side), f64::from(i / side % side), f64::from(i / side / side));
        let turn = DAffine3::from_rotation_y(f64::from(i));
        InstanceDescription {
            name: String::new(),
            mesh: 0,
            to_world: DAffine3::from_translation(2.2 * cell) * turn,
            later: Vec::new(),
        }
    };
    description.instances = (0..millions).map(place).collect();
    let extent = Vec3::splat(2.2 * side as f32);
    add_room(&mut description, Vec3::splat(-1.1), extent - 1.1);
    let (built, scene) = watch.build(description);
    println!("\n| instances | build, s | bytes a triangle of the mesh, at most | then |\n|---|---|---|---|");
    println!(
        "| {millions} of {triangles} triangles | {:.2} | {:.1} | {:.1} |",
        built.seconds,
        built.most_bytes / triangles as f64,
        built.bytes_then / triangles as f64
    );
    // From a gap between the first eight.
    time_rays(&Stage::new(scene, Vec3::splat(1.1), Vec3::ONE.normalize(), 0.6, Vec3::splat(1.2)));
    ExitCode::SUCCESS
}

/// Small lamps all over a hall, their luminances two decades apart.
fn lights(count: u32) -> ExitCode {
    const LEVELS: u32 = 16;
    let watch = Watch::start();
    let random = |i: u32, what: u64| hash64(what, u64::from(i)) as u32 as f32 / u32::MAX as f32;
    let place = |i: u32| Vec3::new(100.0 * random(i, 0), 10.0 * random(i, 1), 100.0 * random(i, 2));
    let mut description = SceneDescription::default();
    for level in 0..LEVELS {
        let mut material = scenes::diffuse("lamp", Colour::Rgb([0.5; 3]));
        material.emission = Some(EmissionDescription {
            colour: Colour::Rgb([1.0; 3]),
            level: Some(1e3 * 100_f64.powf(f64::from(level) / f64::from(LEVELS))),
            texture: None,
        });
        let material_index = description.materials.len();
        description.materials.push(material);
        let mesh = scattered(
            material_index,
            (level..count).step_by(LEVELS as usize).map(|i| {
                let edge = |what| Vec3::new(random(i, what), random(i, what + 1), random(i, what + 2)) - 0.5;
                (place(i), 0.02 * edge(3), 0.02 * edge(6))
            }),
        );
        description.instances.push(InstanceDescription {
            name: String::new(),
            mesh: description.meshes.len(),
            to_world: DAffine3::IDENTITY,
            later: Vec::new(),
        });
        description.meshes.push(mesh);
    }
    let (built, scene) = watch.build(description);
    println!("\n| lights | build, s | bytes a light, at most | then | samples of a light, ns |\n|---|---|---|---|---|");
    let wavelengths = WavelengthSampler::new(&scenes::visible()).sample(0.3);
    let samples = 1_000_000;
    let start = Instant::now();
    for i in 0..samples {
        black_box(scene.sample_light(place(i), 0.0, random(i, 9), [random(i, 10), random(i, 11)], &wavelengths));
    }
    println!(
        "| {count} | {:.2} | {:.0} | {:.0} | {:.0} |",
        built.seconds,
        built.most_bytes / f64::from(count),
        built.bytes_then / f64::from(count),
        start.elapsed().as_secs_f64() * 1e9 / f64::from(samples)
    );
    ExitCode::SUCCESS
}

/// Nanoseconds a ray on one thread, the fastest of several passes.
fn time_rays(stage: &Stage) {
    println!("\n| rays | ns a ray |\n|---|---|");
    for kind in Kind::ALL {
        let pass = || {
            let start = Instant::now();
            black_box(black_box(stage).trace(kind));
            start.elapsed().as_secs_f64()
        };
        let seconds = (0..RUNS).map(|_| pass()).fold(f64::INFINITY, f64::min);
        println!("| {kind} | {:.0} |", seconds * 1e9 / stage.rays(kind).len() as f64);
    }
}

/// Memory from before there was a scene.
struct Watch {
    before: f64,
}

/// What building took.
struct Built {
    seconds: f64,
    most_bytes: f64,
    bytes_then: f64,
}

impl Watch {
    fn start() -> Self {
        Self { before: resident("VmRSS") }
    }

    fn build(&self, description: SceneDescription) -> (Built, scene::Scene) {
        let start = Instant::now();
        let scene = scene::build(description, &scenes::visible());
        let seconds = start.elapsed().as_secs_f64();
        let most_bytes = resident("VmHWM") - self.before;
        (Built { seconds, most_bytes, bytes_then: resident("VmRSS") - self.before }, scene)
    }
}

/// An entry of `/proc/self/status` in bytes: `VmRSS` is the memory in use now, `VmHWM` the most there ever was. Not a number
/// where there is no such file.
fn resident(key: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with(key));
    line.and_then(|line| line.split_whitespace().nth(1)?.parse::<f64>().ok()).map_or(f64::NAN, |kib| kib * 1024.0)
}

/// Adds a box around everything, in the material of the first mesh.
fn add_room(scene: &mut SceneDescription, low: Vec3, high: Vec3) {
    const SIDES: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let corner = |i: u32| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), high, low);
    scene.instances.push(InstanceDescription {
        name: String::new(),
        mesh: scene.meshes.len(),
        to_world: DAffine3::IDENTITY,
        later: Vec::new(),
    });
    scene.meshes.push(MeshDescription {
        positions: (0..8).map(corner).collect(),
        triangles: SIDES.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
        ..MeshDescription::default()
    });
}

/// A mesh of single triangles, each from a corner and two edges.
fn scattered(material: usize, triangles: impl Iterator<Item = (Vec3, Vec3, Vec3)>) -> MeshDescription {
    let positions: Vec<_> = triangles.flat_map(|(corner, u, v)| [corner, corner + u, corner + v]).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    MeshDescription { material, positions, triangles, ..MeshDescription::default() }
}
