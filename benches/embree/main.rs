//! Rays per second against Embree 3 on one thread, in turn with it over the same triangles and rays: single rays, and
//! beside them ours as renders trace them, several together.
//!
//!     apt install g++ libembree-dev
//!     cargo bench --bench embree
//!
//! Ours never let a ray through between two triangles, so that Embree's robust mode is the like; its default mode,
//! which may, is shown beside it. Prints a table in Markdown: millions of rays per second, medians, and the medians of
//! the ratios of neighbouring runs with the smallest and the largest. At the end, how much longer a ray takes in a mesh
//! of ten times as many triangles, for each of the programs.

#[path = "../parts/kitchen.rs"]
mod kitchen;
#[path = "../parts/rays.rs"]
#[allow(dead_code, reason = "some is for other benches")]
mod rays;
#[path = "../parts/scenes.rs"]
#[allow(dead_code, reason = "some is for other benches")]
mod scenes;

use std::error::Error;
use std::fmt;
use std::hint::black_box;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitCode, Stdio};
use std::time::Instant;

use photosite::geometry::Ray;
use rays::{Kind, Stage};
use scenes::LARGE_SPHERE;

const RUNS: usize = 61;
/// Bands and sectors of a sphere of ten times as many triangles as [`LARGE_SPHERE`].
const TEN_TIMES_LARGER: (u32, u32) = (2024, 3241);
/// Part of the robust mode's rate.
const GOAL: f64 = 0.95;

fn main() -> ExitCode {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let program = folder.join("traverse");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/embree/traverse.cpp");
    let mut compiler = Command::new("g++");
    compiler.args(["-O3", "-march=native", "-std=c++17", "-o"]).arg(&program).arg(source).arg("-lembree3");
    if !compiler.status().is_ok_and(|status| status.success()) {
        println!("Embree is not measured: it takes apt install g++ libembree-dev");
        return ExitCode::SUCCESS;
    }
    match compare_all(&program) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            println!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn compare_all(program: &Path) -> Result<(), Box<dyn Error>> {
    compare("kitchen", Stage::kitchen(), program)?;
    let sphere = |(bands, sectors)| compare("sphere from inside", Stage::sphere_from_inside(bands, sectors), program);
    let (small, large) = (sphere(LARGE_SPHERE)?, sphere(TEN_TIMES_LARGER)?);
    println!("\nTen times the triangles, times the time a ray:\n");
    println!("| rays | ours | together | Embree robust | Embree default |");
    println!("|---|---|---|---|---|");
    for (kind, (small, large)) in Kind::ALL.into_iter().zip(small.iter().zip(&large)) {
        let [ours, turns, robust, default] = std::array::from_fn(|i| large[i] / small[i]);
        println!("| {kind} | {ours:.2} | {turns:.2} | {robust:.2} | {default:.2} |");
    }
    Ok(())
}

/// Prints a table; returns for each kind of rays the seconds a ray takes here alone, here together with others, and in
/// Embree's robust and its default mode.
fn compare(name: &str, stage: Stage, program: &Path) -> Result<Vec<[f64; 4]>, Box<dyn Error>> {
    let file = program.with_file_name("rays.bin");
    write(&stage, &file)?;
    let mut embree = Embree::start(program, &file)?;
    let triangles = stage.scene.geometry().triangles.len();
    println!("\n{name}, {triangles} triangles\n");
    println!("| rays | ours, Mray/s | Embree robust | ratio | | together | ratio | Embree default | ratio |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut medians = Vec::new();
    for (set, kind) in Kind::ALL.into_iter().enumerate() {
        let count = stage.rays(kind).len() as f64;
        let distance = distance(&stage, kind);
        let mut seconds = [const { Vec::new() }; 4];
        for _ in 0..RUNS {
            let timed = |trace: fn(&Stage, Kind) -> usize, seconds: &mut Vec<f64>| {
                let start = Instant::now();
                let hits = trace(black_box(&stage), kind);
                seconds.push(start.elapsed().as_secs_f64());
                hits
            };
            let hits = timed(Stage::trace_one_by_one, &mut seconds[0]);
            if timed(Stage::trace, &mut seconds[1]) != hits {
                return Err(format!("{kind}: rays that are asked for together hit something else").into());
            }
            for mode in [1, 0] {
                let answer = embree.trace(set, mode)?;
                seconds[3 - mode].push(answer.seconds);
                // Rays that graze an edge may differ.
                if answer.hits.abs_diff(hits) as f64 > 1e-3 * count {
                    return Err(format!("{kind}: {hits} hits here and {} in Embree", answer.hits).into());
                }
                if !kind.is_shadow() && (answer.distance - distance).abs() > 1e-3 * distance {
                    return Err(format!("{kind}: {distance} to all hits here and {} in Embree", answer.distance).into());
                }
            }
        }
        let [ours, turns, robust, default] = &seconds;
        let against_robust = Ratio::of(robust, ours);
        let rate = |seconds: &[f64]| count / median(seconds) / 1e6;
        println!(
            "| {kind} | {:.2} | {:.2} | {against_robust} | {} | {:.2} | {} | {:.2} | {} |",
            rate(ours),
            rate(robust),
            if against_robust.median >= GOAL { "reached" } else { "**not reached**" },
            rate(turns),
            Ratio::of(robust, turns),
            rate(default),
            Ratio::of(default, ours)
        );
        medians.push(seconds.each_ref().map(|seconds| median(seconds) / count));
    }
    Ok(medians)
}

/// The sum of how far rays of a kind get, over those that hit something.
fn distance(stage: &Stage, kind: Kind) -> f64 {
    stage.rays(kind).iter().filter_map(|ray| stage.scene.closest(ray)).map(|hit| f64::from(hit.t)).sum()
}

/// Result of the C++ program in one pass; the sum of distances is 0 for shadow rays.
struct Answer {
    seconds: f64,
    hits: usize,
    distance: f64,
}

/// The C++ program with its scene.
struct Embree {
    process: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Embree {
    fn start(program: &Path, file: &Path) -> Result<Self, Box<dyn Error>> {
        let mut process = Command::new(program).arg(file).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let (Some(to), Some(from)) = (process.stdin.take(), process.stdout.take()) else {
            return Err("no pipes".into());
        };
        let mut embree = Self { process, to, from: BufReader::new(from) };
        embree.line()?;
        Ok(embree)
    }

    /// One pass over a set of rays; mode 0 is the default traversal, 1 the robust one.
    fn trace(&mut self, set: usize, mode: usize) -> Result<Answer, Box<dyn Error>> {
        writeln!(self.to, "{set} {mode}")?;
        self.to.flush()?;
        let line = self.line()?;
        let mut words = line.split_whitespace();
        let mut word = || words.next().ok_or("Embree gave no answer");
        Ok(Answer { seconds: word()?.parse()?, hits: word()?.parse()?, distance: word()?.parse()? })
    }

    fn line(&mut self) -> Result<String, Box<dyn Error>> {
        let mut line = String::new();
        self.from.read_line(&mut line)?;
        Ok(line)
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // A command that names no set ends it.
        let _ = writeln!(self.to, "end");
        let _ = self.process.wait();
    }
}

/// Writes triangles and rays, little-endian: counts of corners, triangles and sets; corners; triangles; for each set
/// whether any hit will do, its number of rays, and origin, direction and end of each.
fn write(stage: &Stage, path: &Path) -> std::io::Result<()> {
    let geometry = stage.scene.geometry();
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    let mut count = |n: usize| file.write_all(&(n as u32).to_le_bytes());
    count(geometry.positions.len())?;
    count(geometry.triangles.len())?;
    count(Kind::ALL.len())?;
    let mut numbers = |numbers: &[f32]| numbers.iter().try_for_each(|x| file.write_all(&x.to_le_bytes()));
    geometry.positions.iter().try_for_each(|p| numbers(&p.to_array()))?;
    for corner in geometry.triangles.iter().flat_map(|triangle| triangle.corners) {
        file.write_all(&corner.to_le_bytes())?;
    }
    for kind in Kind::ALL {
        let rays = stage.rays(kind);
        file.write_all(&u32::from(kind.is_shadow()).to_le_bytes())?;
        file.write_all(&(rays.len() as u32).to_le_bytes())?;
        for Ray { origin, direction, t_max, .. } in rays {
            for x in origin.to_array().into_iter().chain(direction.to_array()).chain([*t_max]) {
                file.write_all(&x.to_le_bytes())?;
            }
        }
    }
    file.flush()
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// How many times as fast one is as the other: median, smallest and largest of neighbouring runs.
struct Ratio {
    median: f64,
    low: f64,
    high: f64,
}

impl Ratio {
    fn of(theirs: &[f64], ours: &[f64]) -> Self {
        let ratios: Vec<_> = theirs.iter().zip(ours).map(|(theirs, ours)| theirs / ours).collect();
        let low = ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let high = ratios.iter().copied().fold(0.0, f64::max);
        Self { median: median(&ratios), low, high }
    }
}

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} ({:.2}–{:.2})", self.median, self.low, self.high)
    }
}
