//! COLMAP's `cameras.txt`, and poses of `images.txt`. Pixels are counted as photosite does.

use glam::{DAffine3, DQuat, DVec3};

use super::calibration::{Calibration, StatedPose, to_frame};
use super::models::{at_corners, brown_conrady, kannala_brandt};
use super::tree::{Fault, Item, Node, Value};
use photosite_core::projection::Projection;
use photosite_core::suggest::{did_you_mean, list};

/// Models that photosite renders, with the names of their parameters.
const MODELS: [(&str, &str); 13] = [
    ("SIMPLE_PINHOLE", "f, cx, cy"),
    ("PINHOLE", "fx, fy, cx, cy"),
    ("SIMPLE_RADIAL", "f, cx, cy, k"),
    ("RADIAL", "f, cx, cy, k1, k2"),
    ("OPENCV", "fx, fy, cx, cy, k1, k2, p1, p2"),
    ("FULL_OPENCV", "fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6"),
    ("SIMPLE_FISHEYE", "f, cx, cy"),
    ("FISHEYE", "fx, fy, cx, cy"),
    ("SIMPLE_RADIAL_FISHEYE", "f, cx, cy, k"),
    ("RADIAL_FISHEYE", "f, cx, cy, k1, k2"),
    ("OPENCV_FISHEYE", "fx, fy, cx, cy, k1, k2, k3, k4"),
    ("SIMPLE_DIVISION", "f, cx, cy, k"),
    ("DIVISION", "fx, fy, cx, cy, k"),
];

/// Words of a line.
struct Words<'a> {
    line: usize,
    words: Vec<&'a str>,
}

impl Words<'_> {
    fn node(&self, words: &[&str]) -> Node {
        Node { line: self.line, value: Value::Scalar(words.join(" ")) }
    }

    /// Numbers of some of the words, which are called `key` in messages.
    fn numbers(&self, range: std::ops::Range<usize>, key: &str) -> Result<Vec<f64>, Fault> {
        let node = self.node(&self.words[range]);
        Item { key: key.to_owned(), node: &node }.numbers()
    }
}

pub(super) fn cameras(text: &str) -> Result<Vec<Calibration>, Fault> {
    let lines = text.lines().zip(1..).map(|(text, line)| (line, text.trim()));
    let lines = lines.filter(|(_, text)| !text.is_empty() && !text.starts_with('#'));
    let words = lines.map(|(line, text)| Words { line, words: text.split_whitespace().collect() });
    let mut cameras: Vec<Calibration> = Vec::new();
    for words in words {
        let camera = camera(&words)?;
        if cameras.iter().any(|other| other.name == camera.name) {
            return Err(Fault::new(words.line, camera.name, "two cameras have this number"));
        }
        cameras.push(camera);
    }
    if cameras.is_empty() {
        let help = "a line is CAMERA_ID, MODEL, WIDTH, HEIGHT and the parameters, divided by spaces";
        return Err(Fault::of_file("holds no camera").help(help));
    }
    Ok(cameras)
}

fn camera(words: &Words<'_>) -> Result<Calibration, Fault> {
    const LINE: &str = "1 PINHOLE 640 480 500.0 500.0 320.0 240.0";
    let [name, model, width, height, ..] = words.words[..] else {
        let message =
            format!("expected CAMERA_ID, MODEL, WIDTH, HEIGHT and parameters, found {} words", words.words.len());
        return Err(Fault::new(words.line, "", message).help(format!("for example {LINE}")));
    };
    if name.parse::<u32>().is_err() {
        return Err(Fault::new(words.line, "CAMERA_ID", format!("expected a whole number, found {name:?}"))
            .help(format!("for example {LINE}")));
    }
    let Some((_, names)) = MODELS.iter().find(|(known, _)| *known == model) else {
        let known = || MODELS.iter().map(|(name, _)| *name);
        let message = format!("photosite has no camera model {model:?}{}", did_you_mean(model, known()));
        return Err(Fault::new(words.line, name, message).help(format!("it renders {}", list(model, known()))));
    };
    let size = |word: &str, key: &str| {
        let node = words.node(&[word]);
        Item { key: key.to_owned(), node: &node }.count()
    };
    let resolution = [size(width, "WIDTH")?, size(height, "HEIGHT")?];
    let parameters = words.numbers(4..words.words.len(), model)?;
    let wanted = names.split(", ").count();
    if parameters.len() != wanted {
        let message = format!("expected {wanted} parameters, {names}, found {}", parameters.len());
        return Err(Fault::new(words.line, model, message));
    }
    let is_simple = names.starts_with("f,");
    let (matrix, c) = match parameters.as_slice() {
        [f, cx, cy, rest @ ..] if is_simple => ([*f, *f, *cx, *cy], rest),
        [fx, fy, cx, cy, rest @ ..] => ([*fx, *fy, *cx, *cy], rest),
        _ => return Err(Fault::new(words.line, model, "has too few parameters")),
    };
    let node = words.node(&words.words[4..]);
    let item = Item { key: model.to_owned(), node: &node };
    let padded = |c: &[f64]| -> [f64; 4] { std::array::from_fn(|i| c.get(i).copied().unwrap_or(0.0)) };
    let projection = match model {
        // k₁ and k₂ alone, or OpenCV's order.
        "SIMPLE_RADIAL" | "RADIAL" => brown_conrady(&item, &padded(c))?,
        "OPENCV" | "FULL_OPENCV" => brown_conrady(&item, c)?,
        name if name.ends_with("FISHEYE") => {
            let k = padded(c).map(|k| k.to_string());
            let node = words.node(&k.each_ref().map(String::as_str));
            kannala_brandt(&Item { key: model.to_owned(), node: &node })?
        }
        "SIMPLE_DIVISION" | "DIVISION" => match c[0] {
            0.0 => Projection::Perspective,
            lambda => Projection::Division { lambda },
        },
        _ => Projection::Perspective,
    };
    Ok(Calibration {
        name: name.to_owned(),
        intrinsics: at_corners(&item, matrix, 0.0)?,
        projection,
        resolution: Some(resolution),
        poses: Vec::new(),
        warnings: Vec::new(),
    })
}

/// Adds the poses of `images.txt` to the cameras that took them: two lines an image, of which the second, the points,
/// may be empty.
pub(super) fn add_poses(cameras: &mut [Calibration], text: &str) -> Result<(), Fault> {
    const KEYS: &str = "IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME";
    let mut lines = text.lines().zip(1..);
    while let Some((text, line)) = lines.next() {
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        lines.next();
        let words = Words { line, words: text.split_whitespace().collect() };
        if words.words.len() < 10 {
            let message = format!("expected {KEYS}, found {} words", words.words.len());
            return Err(Fault::new(line, "", message).help("each image has two lines, the second of its points"));
        }
        let numbers = words.numbers(1..8, "pose")?;
        let camera = words.words[8];
        // Names may have spaces.
        let name = text.splitn(10, char::is_whitespace).last().unwrap_or_default().trim().to_owned();
        let Some(camera) = cameras.iter_mut().find(|known| known.name == camera) else {
            return Err(Fault::new(line, "CAMERA_ID", format!("cameras.txt has no camera {camera:?}")));
        };
        let [w, x, y, z, tx, ty, tz] = <[f64; 7]>::try_from(numbers)
            .map_err(|_| Fault::new(line, "pose", "expected a quaternion and a translation"))?;
        let turn = DQuat::from_xyzw(x, y, z, w);
        if !(turn.length() - 1.0).abs().lt(&1e-3) {
            return Err(Fault::new(line, "pose", format!("the quaternion has the length {}, not 1", turn.length())));
        }
        let from_world = DAffine3::from_rotation_translation(turn.normalize(), DVec3::new(tx, ty, tz));
        camera.poses.push(StatedPose { name, to_frame: to_frame(&from_world) });
    }
    Ok(())
}
