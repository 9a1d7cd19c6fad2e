//! Ground truth of data sets: flow leads to the next frame and disparity to the partner, by closed forms from what
//! `capture.json` says of both cameras.

use photosite::image::Planes;
use rstest::rstest;
use serde_json::Value;

use crate::dataset::folder;
use crate::folder::Folder;

/// Positions are single precision, of a metre or so, seen by at most 60 px per radian from 0.4 m on.
const ROUNDING_PX: f64 = 60.0 / 0.4 * 16.0 * f32::EPSILON as f64;

fn truth(folder: &Folder, image: &str) -> Planes {
    let bytes = std::fs::read(folder.path(image).join("truth.exr")).expect("truth.exr");
    photosite::io::exr::read_exr(std::io::Cursor::new(bytes)).expect("EXR").planes
}

fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|i| value[i].as_f64().expect("a number"))
}

/// A point of the world in the image of a perspective camera: (R·p + t) by OpenCV's axes, then fx·x/z + cx. With its
/// depth.
fn project(report: &Value, p: [f64; 3]) -> ([f64; 2], f64) {
    let camera = &report["camera"];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let t = vector(&camera["translation_m"]);
    let q = [0, 1, 2].map(|i| dot(vector(&camera["rotation"][i]), p) + t[i]);
    let k = |i: usize, j: usize| camera["camera_matrix"][i][j].as_f64().expect("a number");
    ([k(0, 0) * q[0] / q[2] + k(0, 2), k(1, 1) * q[1] / q[2] + k(1, 2)], q[2])
}

/// Compares flow in all pixels that see something with where their surface is in the next image, and returns how many
/// of them are visible there and the longest way, px.
fn check_flow(folder: &Folder, now: &str, next: &str, moved_m: [f64; 3]) -> (usize, f64) {
    let planes = truth(folder, now);
    let report = folder.report(next);
    let value = |name: &str, i: usize| f64::from(planes.plane(name).unwrap_or_else(|| panic!("no {name}"))[i]);
    let width = planes.width();
    let [next_width, next_height] = [0, 1].map(|i| report["camera"]["resolution_px"][i].as_f64().expect("a number"));
    let (mut seen, mut visible, mut longest) = (0, 0, 0f64);
    for i in (0..width * planes.height()).filter(|&i| value("depth", i).is_finite()) {
        let p = ["X", "Y", "Z"].map(|axis| value(&format!("position.{axis}"), i));
        let (to, depth) = project(&report, [0, 1, 2].map(|axis| p[axis] + moved_m[axis]));
        seen += 1;
        if depth <= 0.0 {
            assert_eq!(value("flow.visible", i), 0.0, "behind the camera");
            continue;
        }
        let expected = [to[0] - (i % width) as f64, to[1] - (i / width) as f64];
        let flow = [value("flow.X", i), value("flow.Y", i)];
        let error = (flow[0] - expected[0]).hypot(flow[1] - expected[1]);
        assert!(error < ROUNDING_PX * (1.0 + expected[0].hypot(expected[1])), "{now} {i}: {flow:?}, not {expected:?}");
        longest = longest.max(expected[0].hypot(expected[1]));
        // Nothing stands before anything. Pixels reach half a pixel around their centres.
        let inside = to[0] > -0.5 && to[1] > -0.5 && to[0] < next_width - 0.5 && to[1] < next_height - 0.5;
        assert_eq!(value("flow.visible", i) == 1.0, inside, "{now} {i}: {to:?}");
        visible += usize::from(inside);
    }
    assert!(seen > 0, "the board is seen");
    (visible, longest)
}

const SIDE_BY_SIDE: &str = "[[cameras]]\nname = 'left'\n[[cameras]]\nname = 'right'\nposition_m = [0.1, 0, 0]\n";
const LIST: &str = "[poses]\nlist = [\n{ position_m = [0, 0, 0.6], look_at_m = [0, 0, 0] },\n\
    { position_m = [0.1, 0.05, 0.7], look_at_m = [0, 0, 0] },\n\
    { position_m = [-0.2, 0, 0.5], look_at_m = [0.05, 0, 0], up = [0.2, 1, 0] } ]\n";
const GRID: &str = "[poses.grid]\ntarget = 'board'\nazimuth_deg = [-20, 0, 25]\ndistance_m = [0.6]\n";
const RANDOM: &str = "frames = 3\n[poses.random]\ntarget = 'board'\ndistance_m = [0.6, 0.9]\nmargin_px = 1\n";
const WAY: &str = "frames = 3\n[poses.trajectory]\nframe_rate_hz = 10\nmoving = false\nposes = [\n\
    { time_s = 0, position_m = [0, 0, 0.6], look_at_m = [0, 0, 0] },\n\
    { time_s = 1, position_m = [0.5, 0.2, 0.8], look_at_m = [0, 0, 0] } ]\n";

#[rstest]
#[case::list(LIST)]
#[case::grid(GRID)]
#[case::random(RANDOM)]
#[case::trajectory(WAY)]
#[case::zoom("frames = 3\n[[vary]]\nkey = 'lens.focal_length_mm'\nsweep = [5, 7]\n")]
#[case::focus("frames = 3\nset = ['lens.type=thin']\n[[vary]]\nkey = 'lens.focus_distance_m'\nsweep = [0.1, 0.4]\n")]
#[case::size("frames = 3\n[[vary]]\nkey = 'sensor.resolution_px'\nchoice = [[32, 24], [40, 20]]\n")]
fn flow_leads_to_the_next_frame(#[case] set: &str, #[values("", SIDE_BY_SIDE)] rig: &str) {
    // Keys of the file come before its tables.
    let (keys, tables) = set.split_at(set.find("[[vary").or_else(|| set.find("[poses")).unwrap_or(0));
    let folder = folder(&format!("{keys}{rig}{tables}"));
    // One frame of the middle leads to the one that is not made.
    folder.succeed("dataset set.toml -o part --frames 1..2 --quiet --set output.truth=['flow','depth','position']");
    folder.succeed("dataset set.toml -o out --quiet --set output.truth=['flow','depth','position']");
    for camera in if rig.is_empty() { &["camera"][..] } else { &["left", "right"] } {
        let image = |frame: u32| format!("out/{camera}/{frame:06}");
        let mut longest = 0f64;
        for frame in 0..2 {
            let (visible, way) = check_flow(&folder, &image(frame), &image(frame + 1), [0.0; 3]);
            assert!(visible > 0, "{camera} {frame}");
            longest = longest.max(way);
            assert_eq!(folder.report(&image(frame))["truth"]["has_next"], true);
        }
        assert!(longest > 0.3, "things move: {longest} px");
        // The last one leads nowhere.
        let last = truth(&folder, &image(2));
        for name in ["flow.X", "flow.Y", "flow.visible"] {
            assert!(last.plane(name).expect("a plane").iter().all(|&value| value == 0.0), "{name}");
        }
        assert_eq!(folder.report(&image(2))["truth"]["has_next"], false);
        assert!(folder.results(&image(1)) == folder.results(&format!("part/{camera}/000001")));
        // The image can be made again from its own report, flow included.
        folder.succeed(&format!("render {}/capture.json -o again --force --quiet", image(0)));
        assert!(folder.results("again")["truth.exr"] == folder.results(&image(0))["truth.exr"]);
    }
}

#[test]
fn flow_follows_a_target_that_is_moved() {
    let vary = "frames = 2\n[[vary]]\nkey = 'targets.0.position_m'\nchoice = [[0, 0, 0], [0.05, -0.02, 0.1]]\nper_camera = true\n";
    // A seed for which the two frames differ.
    let (mut moved, mut folder) = ([0.0; 3], folder(vary));
    for seed in 0.. {
        folder = self::folder(&format!("seed = {seed}\n{vary}"));
        folder.succeed("dataset set.toml -o out --quiet --set output.truth=['flow','depth','position']");
        let place =
            |frame: u32| vector(&folder.report(&format!("out/camera/{frame:06}"))["targets"][0]["translation_m"]);
        let (now, next) = (place(0), place(1));
        moved = [0, 1, 2].map(|axis| next[axis] - now[axis]);
        if moved != [0.0; 3] {
            break;
        }
    }
    let (visible, way) = check_flow(&folder, "out/camera/000000", "out/camera/000001", moved);
    // 0.05 m at 0.6 m with fx = 30 px.
    assert!(visible > 100 && way > 2.0, "{visible} {way}");
}

#[test]
fn flow_to_other_surfaces_is_refused() {
    let folder = folder("frames = 8\n[[vary]]\nkey = 'targets.0.squares'\nchoice = [[9, 6], [7, 6]]\n");
    let outcome = folder.run("dataset set.toml -o out --quiet --set output.truth=['flow']");
    assert_eq!(outcome.status, Some(1), "{}", outcome.stderr);
    assert!(outcome.text().contains("\"flow\" follows surfaces, and the next image has others"), "{}", outcome.stderr);
    folder.succeed("dataset set.toml -o other --quiet --set output.truth=['depth']");
}

#[test]
fn a_set_whose_flow_ends_is_not_lengthened() {
    let folder = folder("frames = 2\n");
    folder.succeed("dataset set.toml -o out --quiet --set output.truth=['flow']");
    folder.add("set.toml", "capture = 'board.toml'\nframes = 3\n");
    folder.fail("dataset set.toml -o out --set output.truth=['flow']", 2, &["the data set file says something else"]);
}

/// 0.2 m to the right in the next image, said in the capture itself.
#[test]
fn a_capture_names_the_next_image() {
    let folder = folder("");
    let set = "--set output.truth=['flow','depth'] --quiet";
    folder.succeed(&format!("render board.toml -o out {set} --set output.truth_next=['camera.position_m=[0.2,0,0.6]','camera.look_at_m=[0.2,0,0]']"));
    let planes = truth(&folder, "out");
    let plane = |name: &str| planes.plane(name).expect("a plane");
    for (flow, depth) in plane("flow.X").iter().zip(plane("depth")).filter(|(_, depth)| depth.is_finite()) {
        assert!((f64::from(*flow) + 30.0 * 0.2 / f64::from(*depth)).abs() < ROUNDING_PX * 10.0, "{flow} at {depth} m");
    }
    folder.succeed(&format!("render board.toml -o none {set} --set output.truth_next=false"));
    assert!(truth(&folder, "none").plane("flow.visible").expect("a plane").iter().all(|&v| v == 0.0));
    folder.fail(
        &format!("render board.toml -o no {set} --set output.truth_next=true"),
        1,
        &["output.truth_next: does not say"],
    );
    folder.fail(
        &format!("render board.toml -o no {set} --set output.truth_next=false --frames 2"),
        1,
        &["output.truth_next: cannot be combined with exposure.frames"],
    );
    folder.fail(
        &format!("render board.toml -o no {set} --set output.truth_next=['lens.f=1']"),
        1,
        &["unknown key `f`"],
    );
}

/// 16-bit PNG files as KITTI has them: value/256.
fn disparity_png(folder: &Folder, image: &str) -> Vec<f64> {
    let bytes = std::fs::read(folder.path(image).join("truth-disparity.png")).expect("truth-disparity.png");
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut pixels).expect("an image");
    pixels.as_chunks::<2>().0.iter().map(|&pair| f64::from(u16::from_be_bytes(pair)) / 256.0).collect()
}

fn pair(first: &str, second: &str) -> String {
    format!(
        "[[cameras]]\nname = 'left'\n{first}\n[[cameras]]\nname = 'right'\nposition_m = [0.1, 0, 0]\n{second}\n{RANDOM}"
    )
    .replace("frames = 3\n", "")
}

const DISPARITY: &str = "--quiet --set output.truth=['disparity','depth'] --set output.truth_formats=['exr','png']";

/// d = fx·b/z in both images of a pair, in floats and in PNG files.
#[rstest]
#[case::each_other("disparity_to = 'right'", "disparity_to = 'left'", &["left", "right"])]
#[case::left_alone("disparity_to = 'right'", "", &["left"])]
#[case::right_alone("", "disparity_to = 'left'", &["right"])]
#[case::crossed("position_m = [0.2, 0, 0]\ndisparity_to = 'right'", "disparity_to = 'left'", &["left", "right"])]
fn disparity_is_positive_for_both_cameras(#[case] first: &str, #[case] second: &str, #[case] cameras: &[&str]) {
    let folder = folder(&format!("frames = 2\n{}", pair(first, second)));
    folder.succeed(&format!("dataset set.toml -o out {DISPARITY}"));
    for camera in ["left", "right"] {
        for frame in 0..2 {
            let image = format!("out/{camera}/{frame:06}");
            let planes = truth(&folder, &image);
            if !cameras.contains(&camera) {
                assert!(planes.plane("disparity.X").is_none() && planes.plane("depth").is_some());
                assert_eq!(folder.report(&image)["truth"]["layers"], serde_json::json!(["depth"]));
                continue;
            }
            let (codes, plane) = (disparity_png(&folder, &image), |name: &str| planes.plane(name).expect("a plane"));
            let mut visible = 0;
            for (i, &code) in codes.iter().enumerate() {
                let d = 30.0 * 0.1 / f64::from(plane("depth")[i]);
                assert!((f64::from(plane("disparity.X")[i]) - d).abs() < ROUNDING_PX * 10.0, "{image} {i}: {d}");
                if plane("disparity.visible")[i] == 1.0 {
                    visible += 1;
                    assert!((code - d).abs() <= 0.5 / 256.0 + 1e-4, "{image} {i}: {code}, not {d}");
                } else {
                    assert_eq!(code, 0.0, "{image} {i}");
                }
            }
            assert!(visible > 60, "{image}: {visible}");
        }
    }
}

#[rstest]
#[case::above("position_m = [0, 0.1, 0]", &["output.truth_formats: a disparity of", "px cannot be stored in PNG files", "\"exr\""])]
#[case::towed_in("position_m = [0.1, 0, 0]\nlook_at_m = [0.05, 0, -0.1]", &["px cannot be stored in PNG files", "\"exr\""])]
fn what_png_files_cannot_hold_of_disparity_is_refused(#[case] place: &str, #[case] wanted: &[&str]) {
    let set = pair("", "").replace("position_m = [0.1, 0, 0]", &format!("{place}\ndisparity_to = 'left'"));
    let folder = folder(&format!("frames = 1\n{}", set.replace("[0.6, 0.9]", "[0.9, 1.2]")));
    let outcome = folder.run(&format!("dataset set.toml -o out {DISPARITY}"));
    assert_eq!(outcome.status, Some(1), "{}", outcome.stderr);
    wanted.iter().for_each(|words| assert!(outcome.text().contains(words), "{words}: {}", outcome.stderr));
    folder.succeed("dataset set.toml -o exr --quiet --set output.truth=['disparity']");
}

#[test]
fn a_pair_that_is_none_is_refused() {
    let both = pair("disparity_to = 'right'", "disparity_to = 'left'\nset = ['sensor.pixel_pitch_um=[100,100]']");
    let folder = folder(&format!("frames = 1\n{both}"));
    folder.fail(
        "dataset set.toml -o out",
        1,
        &["set.toml:5: cameras[0].disparity_to: disparity needs two cameras of one kind"],
    );
    let vary = "[[vary]]\nkey = 'lens.focal_length_mm'\nuniform = [5, 6]\nper_camera = true\n";
    let both = pair("disparity_to = 'right'", "disparity_to = 'left'");
    folder.add("set.toml", format!("capture = 'board.toml'\nframes = 1\n{both}{vary}"));
    folder.fail("dataset set.toml -o out", 1, &["vary[0].per_camera: lens.focal_length_mm: disparity needs two"]);
}

/// Where nothing leads to a partner, disparity cannot be asked for.
#[test]
fn disparity_needs_a_pair() {
    let folder = folder("frames = 1\n[[cameras]]\nname = 'a'\n[[cameras]]\nname = 'b'\nposition_m = [0.1, 0, 0]\n");
    folder.fail("dataset set.toml -o out --set output.truth=['disparity']", 1, &["is that of a pair", "disparity_to"]);
    folder.succeed("dataset set.toml -o out --set output.truth=['disparity'] --set output.truth_partner=false --quiet");
    assert!(!folder.path("out/a/000000/truth.exr").exists(), "there is nothing left to tell");
}

/// A square of 0.6 m that an animation moves to the right by 1 m/s, and 0.1 s from image to image: by fx·0.1 m/z.
/// The camera stands still.
#[test]
fn flow_follows_an_animation() {
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let corners = floats(&[-0.3, -0.3, 0.0, 0.3, -0.3, 0.0, 0.3, 0.3, 0.0, -0.3, 0.3, 0.0]);
    let indices: Vec<u8> = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let way = floats(&[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let gltf = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "square" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "animations": [{ "name": "move", "samplers": [{ "input": 2, "output": 3 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }] }],
        "buffers": [{ "uri": "square.bin", "byteLength": 92 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
            { "buffer": 0, "byteOffset": 60, "byteLength": 8 }, { "buffer": 0, "byteOffset": 68, "byteLength": 24 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-0.3, -0.3, 0], "max": [0.3, 0.3, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
            { "bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1] },
            { "bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3" }] }"#;
    let (scene, rest) = crate::dataset::BOARD.split_once("[[targets]]").expect("a target");
    let rest = rest.split_once("[camera]").expect("a camera").1.replace("0.6]", "1.5]");
    let exposure = "[exposure]\nframes = 2\nframe_interval_s = 0.1";
    let capture = format!("{scene}[camera]{rest}")
        .replace("[scene]\n", "[scene]\ngeometry = ['square.gltf']\nanimation = 'move'\n")
        .replace("[exposure]", exposure);
    let folder = Folder::new([
        ("square.gltf", gltf.into()),
        ("square.bin", [corners, indices, way].concat()),
        ("capture.toml", capture.into()),
    ]);
    folder.succeed("render capture.toml -o out --quiet --set output.truth=['flow','instance']");
    for number in 0..2 {
        let bytes = folder.bytes(&format!("out/truth-000{number}.exr"));
        let planes = photosite::io::exr::read_exr(std::io::Cursor::new(bytes)).expect("EXR").planes;
        let plane = |name: &str| planes.plane(name).expect("a plane");
        let seen: Vec<usize> = (0..32 * 24).filter(|&i| plane("instance")[i] == 1.0).collect();
        // 0.6 m at 1.5 m are 12 px.
        assert!((11 * 11..=13 * 13).contains(&seen.len()), "{}", seen.len());
        for i in seen {
            let (x, y, visible) = (plane("flow.X")[i], plane("flow.Y")[i], plane("flow.visible")[i]);
            assert!((x - 2.0).abs() < 1e-3 && y.abs() < 1e-3 && visible == 1.0, "{number} {i}: {x}, {y}, {visible}");
        }
    }
}
