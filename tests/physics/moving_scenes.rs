//! Scenes drawn at random of all that moves in the time of an image: objects, their parts and their size, the camera; seen
//! through several lenses and shutters, in whole or in part.

use std::fs;
use std::path::Path;

use photosite::Capture;
use photosite::math::philox::Philox;
use rand::RngExt;
use serde_json::json;
use tempfile::TempDir;

/// The sensor, and the part of it that is read out: first column and row, columns, rows.
pub(crate) const SENSOR_PX: [u32; 2] = [64, 48];
pub(crate) const REGION_PX: [u32; 4] = [16, 12, 32, 24];
/// Distance of the camera from the middle of the scene.
pub(crate) const DISTANCE_M: f64 = 2.6;
/// Focal length in pixels: 4 mm over 80 µm.
pub(crate) const FOCAL_PX: f64 = 50.0;

/// A scene in a folder of its own.
pub(crate) struct MovingScene {
    folder: TempDir,
    objects: Vec<Object>,
    /// The tables after the scene.
    rest: String,
    /// When the image is taken, s of what moves.
    time_s: f64,
    /// Whether straight lines are straight in the image, all of which is taken at once.
    pub(crate) is_perspective_at_once: bool,
}

impl MovingScene {
    pub(crate) fn draw(seed: u64) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut draw = Draw(Philox::new(seed, 0x5cee5));
        let count = 2 + draw.index(2);
        let objects = (0..count).map(|i| object(folder.path(), i, &mut draw)).collect();
        let camera = match draw.index(3) {
            0 => format!(
                "motion.velocity_m_per_s = {:?}\nmotion.angular_velocity_deg_per_s = {:?}\n",
                draw.vector(0.6),
                draw.vector(15.0)
            ),
            _ => String::new(),
        };
        let lenses: [(&str, bool); 6] = [
            ("type = 'pinhole'\nfocal_length_mm = 4\n", true),
            ("focal_length_mm = 4\nf_number = 2\nfocus_distance_m = 3\n", true),
            (
                "focal_length_mm = 4\nf_number = 4\nfocus_distance_m = 3\ndistortion = { model = 'brown-conrady', k = [-0.25, 0.05], p = [0.01, -0.02] }\n",
                false,
            ),
            (
                "focal_length_mm = 4\nf_number = 4\nfocus_distance_m = 3\ndistortion = { model = 'brown-conrady', k = [0.3] }\n",
                false,
            ),
            ("type = 'pinhole'\nfocal_length_mm = 3\nprojection = 'fisheye'\n", false),
            ("prescription = 'double-gauss'\nfocus_distance_m = 3\n", false),
        ];
        let lens = draw.index(lenses.len());
        let row_time_us = [None, None, None, Some(50), Some(2000), Some(10_000)][draw.index(6)];
        let shutter =
            row_time_us.map_or(String::new(), |us| format!("shutter = {{ kind = 'rolling', row_time_us = {us} }}\n"));
        let pitch_um = if lens == 5 { 1000.0 } else { 4e3 / FOCAL_PX };
        let time_s = [1e-4, 0.02, 0.2][draw.index(3)];
        let rest = format!(
            "[camera]\nposition_m = [0, 0, {DISTANCE_M}]\nlook_at_m = {look:?}\n{camera}[lens]\n{lens}[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = {SENSOR_PX:?}\n\
             pixel_pitch_um = [{pitch_um}, {pitch_um}]\n{shutter}[exposure]\ntime_s = {time_s}\nframe_interval_s = 0.6\nframes = 2\n",
            look = draw.vector(0.4),
            lens = lenses[lens].0,
        );
        let is_perspective_at_once = lenses[lens].1 && row_time_us.is_none();
        Self { folder, objects, rest, time_s: draw.between(0.0, 0.3), is_perspective_at_once }
    }

    /// How many objects there are.
    pub(crate) fn count(&self) -> usize {
        self.objects.len()
    }

    /// The capture of these objects, with more keys of `[exposure]`.
    pub(crate) fn capture(&self, objects: &[usize], exposure: &str) -> Capture {
        let objects = objects.iter().map(|&i| &self.objects[i]);
        let moves = objects.clone().any(|object| object.moves);
        let time = if moves { format!("time_s = {}\n", self.time_s) } else { String::new() };
        let tables: String = objects.map(|object| object.table.as_str()).collect();
        let light = "environment = { illuminant = 'D65', illuminance_lux = 500 }\n";
        let text = format!("[scene]\n{light}{time}{tables}{}{exposure}\n", self.rest);
        let path = self.folder.path().join("capture.toml");
        fs::write(&path, &text).expect("written");
        Capture::load(&path).unwrap_or_else(|error| panic!("{error}\n{text}"))
    }
}

/// The table of an object, and whether anything of it moves.
struct Object {
    table: String,
    moves: bool,
}

/// Numbers at random.
struct Draw(Philox);

impl Draw {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    fn index(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// Each coordinate up to so much to both sides.
    fn vector(&mut self, most: f64) -> [f64; 3] {
        [0; 3].map(|_| self.between(-most, most))
    }
}

/// A file of a cube with an arm, of which nothing, the arm, or the size moves, and the table that places it.
fn object(folder: &Path, number: usize, draw: &mut Draw) -> Object {
    let name = format!("object-{number}");
    let half = f64::sqrt(0.5);
    let channels: Vec<(usize, &str, [Vec<f64>; 2])> = match draw.index(5) {
        0 => Vec::new(),
        1 => vec![(
            1,
            "translation",
            [vec![0.6, 0.0, 0.0], vec![0.6 + draw.between(0.5, 4.0), draw.between(-2.0, 2.0), 0.5]],
        )],
        2 => vec![(1, "rotation", [vec![0.0, 0.0, 0.0, 1.0], vec![0.0, half, 0.0, half]])],
        3 => vec![(0, "scale", [vec![0.4; 3], vec![draw.between(0.1, 1.0); 3]])],
        _ => vec![
            (0, "scale", [vec![0.4; 3], vec![0.3, draw.between(0.3, 1.0), 0.5]]),
            (1, "translation", [vec![0.6, 0.0, 0.0], vec![2.0, 0.0, 0.0]]),
        ],
    };
    write_gltf(&folder.join(&name), &channels);
    let animation = if channels.is_empty() { "" } else { "animation = 'animation-0'\n" };
    let motion = match draw.index(3) {
        0 => String::new(),
        _ => format!(
            "motion.velocity_m_per_s = {:?}\nmotion.angular_velocity_deg_per_s = {:?}\n",
            draw.vector(0.8),
            draw.vector(120.0)
        ),
    };
    let scale = match draw.index(3) {
        0 => format!("scale = [{}, 1, {}]\n", draw.between(0.5, 1.5), draw.between(0.5, 1.5)),
        _ => String::new(),
    };
    let moves = !(animation.is_empty() && motion.is_empty());
    let table = format!(
        "[[scene.objects]]\nfile = '{name}.gltf'\nname = '{name}'\nposition_m = {:?}\nrotation_deg = {:?}\n{scale}{animation}{motion}\
         keypoints = {{ middle = [0, 0, 0], corner = [0.2, 0.2, 0.2], face = [0, 0, 0.2] }}\n",
        draw.vector(0.6),
        draw.vector(180.0),
    );
    Object { table, moves }
}

/// A cube of 0.4 m with a smaller one as its arm, 0.24 m away, and an animation from 0 to 1 s.
fn write_gltf(path: &Path, channels: &[(usize, &str, [Vec<f64>; 2])]) {
    let mut bytes = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    let mut add = |data: Vec<u8>, component: u32, kind: &str, count: usize, bounds: Option<[Vec<f64>; 2]>| {
        let mut accessor =
            json!({ "bufferView": views.len(), "componentType": component, "type": kind, "count": count });
        if let Some([low, high]) = bounds {
            accessor["min"] = json!(low);
            accessor["max"] = json!(high);
        }
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len() }));
        bytes.extend(data);
        accessors.push(accessor);
        accessors.len() - 1
    };
    let floats = |values: &[f64]| values.iter().flat_map(|v| (*v as f32).to_le_bytes()).collect::<Vec<u8>>();
    let corners: Vec<f64> =
        (0..8).flat_map(|i| [i >> 2 & 1, i >> 1 & 1, i & 1].map(|bit| f64::from(bit) - 0.5)).collect();
    let positions = add(floats(&corners), 5126, "VEC3", 8, Some([vec![-0.5; 3], vec![0.5; 3]]));
    let faces: [u32; 36] =
        [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3];
    let indices = add(faces.iter().flat_map(|i| i.to_le_bytes()).collect(), 5125, "SCALAR", 36, None);
    let times = add(floats(&[0.0, 1.0]), 5126, "SCALAR", 2, Some([vec![0.0], vec![1.0]]));
    let (mut samplers, mut targets) = (Vec::new(), Vec::new());
    for (node, path, keys) in channels {
        let kind = if *path == "rotation" { "VEC4" } else { "VEC3" };
        let output = add(floats(&keys.concat()), 5126, kind, 2, None);
        targets.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
        samplers.push(json!({ "input": times, "output": output, "interpolation": "LINEAR" }));
    }
    let name = path.file_name().expect("a name").to_string_lossy().into_owned();
    let mut file = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [
            { "mesh": 0, "scale": [0.4, 0.4, 0.4], "children": [1] },
            { "mesh": 0, "scale": [0.5, 0.5, 0.5], "translation": [0.6, 0, 0] },
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": positions }, "indices": indices }] }],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("{name}.bin") }],
    });
    if !channels.is_empty() {
        file["animations"] = json!([{ "samplers": samplers, "channels": targets }]);
    }
    fs::write(path.with_extension("bin"), bytes).expect("written");
    fs::write(path.with_extension("gltf"), file.to_string()).expect("written");
}
