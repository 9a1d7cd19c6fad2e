//! `photosite project`: pixels of points in the image, and lines of sight of pixels.

use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;

use super::log::warning;
use super::print::println_out;
use super::scene_args::SceneArgs;
use photosite_capture::Capture;
use photosite_core::{Error, Invalid, Result, Sandbox};
use photosite_core::{input, text};
use photosite_pipeline::camera_projection::{CameraProjection, Space};

const EXAMPLES: &str = "\
Example:
  photosite project capture.toml --points points.csv";

/// Project points to pixels, or pixels to lines of sight.
///
/// Input and output are lines of numbers separated by commas. Pixels are column and row as in OpenCV, integers at the
/// centres. They are those of image.png, or of the raw image with output.image = false or where image.png is freed of
/// the distortion of the lens, which develop.distortion = false prevents (for hexagonal cells that stay so, those of
/// the rows that are not shifted: the cells of the others are at columns and a half). Points that the lens does not
/// show become `nan,nan`. A camera that moves sees each point, and each pixel, in the middle of the exposure of its row
/// of the first image, as in ground truth.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct ProjectArgs {
    /// A capture file (.toml) or a scene (.gltf, .glb, .obj, .ply, .stl).
    input: PathBuf,
    /// A file with one point x, y, z per line; - for standard input.
    #[arg(long, value_name = "FILE")]
    points: PathBuf,
    /// The points are in OpenCV's camera coordinates (x right, y down, z forward), m, not in those of the world.
    #[arg(long)]
    camera_space: bool,
    /// The other way round: from one pixel per line to the unit vector of its line of sight, in OpenCV's camera
    /// coordinates with --camera-space, else in those of the world.
    #[arg(long)]
    inverse: bool,
    /// With --inverse: a point of the line of sight before its direction, x, y, z, dx, dy, dz, m. Lines of a lens from
    /// a prescription do not all go through the camera's place.
    #[arg(long, requires = "inverse")]
    origin: bool,
    /// Change a key of the capture file, for example --set lens.max_angle_deg=80.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    #[command(flatten)]
    scene: SceneArgs,
}

pub(super) fn run(args: &ProjectArgs, sandbox: &Sandbox) -> Result<()> {
    let capture = Capture::load_within(sandbox, &args.input, &args.scene.after(&args.overrides, &args.input))?;
    let space = if args.camera_space { Space::Camera } else { Space::World };
    let sight = CameraProjection::new(&capture, space)?;
    let text = read(&args.points)?;
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.split('#').next().unwrap_or("").trim()));
    let mut out = String::new();
    for (number, line) in lines.filter(|(_, line)| !line.is_empty()) {
        let in_line = |invalid: Invalid| invalid.at_line(&args.points, number);
        let answer = if args.inverse {
            let line = sight.line(numbers(line, "100.5, 42").map_err(in_line)?);
            let shown = if args.origin { line.as_slice() } else { &line[1..] };
            shown.as_flattened().iter().map(f64::to_string).collect::<Vec<_>>().join(",")
        } else {
            let point = numbers(line, "0.1, -0.2, 3").map_err(in_line)?;
            sight.pixel(point).map(|x| x.to_string()).join(",")
        };
        out += &answer.to_lowercase();
        out.push('\n');
    }
    sight.warning().iter().for_each(|words| warning!("{words}"));
    println_out(out.trim_end())
}

fn read(path: &Path) -> Result<String> {
    if path == Path::new("-") {
        let mut bytes = Vec::new();
        let read = std::io::stdin().lock().read_to_end(&mut bytes).and_then(|_| text::decode(bytes));
        return read.map_err(|reason| Error::io("standard input".as_ref(), "read", reason));
    }
    input::read_text(path, input::TABLE_BYTES).map_err(|reason| Error::io(path, "read", reason))
}

fn numbers<const N: usize>(line: &str, example: &str) -> Result<[f64; N], Invalid> {
    let parts: Option<Vec<f64>> = line
        .split(|c: char| c == ',' || c.is_whitespace())
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().ok().filter(|number: &f64| number.is_finite()))
        .collect();
    parts.and_then(|parts| parts.try_into().ok()).ok_or_else(|| {
        Invalid::new("", format!("\"{line}\" is not {N} numbers")).help(format!("write a line such as {example}"))
    })
}
