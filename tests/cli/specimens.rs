//! Cameras of images by serial numbers: fixed pattern belongs to its serial number, temporal noise to the image.

use photosite::image::Planes;
use rstest::rstest;

use crate::dataset::{BOARD, files, folder};
use crate::folder::Folder;

/// Numbers that 32 × 24 independent pairs correlate by have the standard deviation 1/√768; 5 of them.
const CHANCE: f64 = 5.0 / 27.7;

const MAPS: &str = "--quiet --set output.noise=['prnu_e','dsnu_e','read_noise_e','photon_shot_noise_e']";
const RIG: &str = "frames = 2\n[[cameras]]\nname = 'left'\n[[cameras]]\nname = 'right'\n";

fn noise(folder: &Folder, image: &str) -> Planes {
    let bytes = folder.bytes(image);
    photosite::io::exr::read_exr(std::io::Cursor::new(bytes)).expect("EXR").planes
}

/// How far two images have a map in common, −1 to 1.
fn correlation(a: &Planes, b: &Planes, map: &str) -> f64 {
    let [a, b] =
        [a, b].map(|planes| planes.plane(map).expect("a map").iter().map(|&v| f64::from(v)).collect::<Vec<_>>());
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(&a), mean(&b));
    let sum = |f: fn(f64, f64) -> f64| a.iter().zip(&b).map(|(a, b)| f(a - ma, b - mb)).sum::<f64>();
    sum(|a, b| a * b) / (sum(|a, _| a * a) * sum(|_, b| b * b)).sqrt()
}

#[track_caller]
fn assert_same_camera(a: &Planes, b: &Planes) {
    assert_eq!(a.plane("dsnu_e"), b.plane("dsnu_e"));
    // The pattern times light, whose own noise is another in each.
    assert!(correlation(a, b, "prnu_e") > 0.9, "{}", correlation(a, b, "prnu_e"));
}

#[track_caller]
fn assert_other_camera(a: &Planes, b: &Planes) {
    for map in ["prnu_e", "dsnu_e"] {
        assert!(correlation(a, b, map).abs() < CHANCE, "{map}: {}", correlation(a, b, map));
    }
}

#[track_caller]
fn assert_other_noise(a: &Planes, b: &Planes) {
    for map in ["read_noise_e", "photon_shot_noise_e"] {
        assert!(correlation(a, b, map).abs() < CHANCE, "{map}: {}", correlation(a, b, map));
    }
}

#[test]
fn cameras_of_a_rig_keep_their_fixed_pattern_from_frame_to_frame() {
    let folder = folder(RIG);
    folder.succeed(&format!("dataset set.toml -o out {MAPS}"));
    let map = |image: &str| noise(&folder, &format!("out/{image}/noise.exr"));
    let images = ["left/000000", "left/000001", "right/000000", "right/000001"];
    let [left, left_later, right, right_later] = images.map(map);
    assert_same_camera(&left, &left_later);
    assert_same_camera(&right, &right_later);
    assert_other_camera(&left, &right);
    for (a, b) in [(&left, &left_later), (&right, &right_later), (&left, &right), (&left, &right_later)] {
        assert_other_noise(a, b);
    }
    let serials = images.map(|image| folder.report(&format!("out/{image}"))["sensor"]["serial"].as_u64());
    assert_eq!(serials, [Some(0), Some(0), Some(1), Some(1)]);
    assert_eq!(folder.raw("out/right/000001/raw.dng").metadata.camera_serial, "1");
    // Each can be made again from its own report.
    folder.succeed("render out/right/000001/capture.json -o again --quiet");
    assert!(folder.raw("again/raw.dng") == folder.raw("out/right/000001/raw.dng"));
}

#[test]
fn serial_numbers_count_on_from_that_of_the_capture() {
    let own = format!("{RIG}set = ['sensor.serial=40']\n[[cameras]]\nname = 'third'\n");
    let folder = folder(&own);
    let serials = |out: &str| {
        ["left", "right", "third"].map(|c| folder.report(&format!("{out}/{c}/000000"))["sensor"]["serial"].as_u64())
    };
    folder.succeed("dataset set.toml -o out --quiet --frames 0..1");
    assert_eq!(serials("out"), [Some(0), Some(40), Some(2)]);
    folder.add("board.toml", BOARD.replace("[sensor]\n", "[sensor]\nserial = 7\n"));
    folder.succeed("dataset set.toml -o seven --quiet --frames 0..1");
    assert_eq!(serials("seven"), [Some(7), Some(40), Some(9)]);
    folder.fail(
        "dataset set.toml -o out --set sensor.serial=38",
        1,
        &["set.toml", "cameras[1]: has the serial number 38 of left", "sensor.serial"],
    );
    folder.add("set.toml", format!("capture = 'board.toml'\n{}", own.replace("40", "7")));
    folder.fail(
        "dataset set.toml -o out",
        1,
        &["cameras[1]: has the serial number 7 of left, and so the same fixed pattern"],
    );
    folder.add("set.toml", "capture = 'board.toml'\n");
    folder.succeed("dataset set.toml -o alone --quiet");
    assert_eq!(folder.report("alone/camera/000000")["sensor"]["serial"], 7, "a camera alone is that of the capture");
    folder.fail("render board.toml --set sensor.serial=-1", 1, &["sensor.serial"]);
    folder.fail("render board.toml --set sensor.serial=1.5", 1, &["sensor.serial"]);
}

#[test]
fn each_frame_may_be_of_another_specimen() {
    let vary = "[[vary]]\nkey = 'sensor.serial'\nchoice = [1, 2, 3, 4, 5, 6, 7, 8, 9]\n";
    let folder = folder(&format!("frames = 2\n{vary}"));
    folder.succeed(&format!("dataset set.toml -o out {MAPS}"));
    let [one, two] = ["000000", "000001"].map(|n| noise(&folder, &format!("out/camera/{n}/noise.exr")));
    let serials = ["000000", "000001"].map(|n| folder.report(&format!("out/camera/{n}"))["sensor"]["serial"].as_u64());
    assert!(serials[0] != serials[1] && serials[0] > Some(0), "{serials:?}");
    assert_other_camera(&one, &two);
    folder.add("set.toml", format!("capture = 'board.toml'\n{RIG}{vary}"));
    folder.fail("dataset set.toml -o rig", 1, &["vary[0].per_camera: sensor.serial: all cameras", "per_camera = true"]);
    folder.add("set.toml", format!("capture = 'board.toml'\n{RIG}{vary}per_camera = true\n"));
    folder.succeed("dataset set.toml -o rig --quiet");
}

/// `render.seed` gives other noise in the same frames by the same cameras, wherever it stands.
#[test]
fn the_seed_of_the_capture_gives_another_take() {
    let folder = folder("frames = 2\n");
    folder.succeed(&format!("dataset set.toml -o out {MAPS}"));
    folder.succeed(&format!("dataset set.toml -o argument {MAPS} --set render.seed=5"));
    folder.add("set.toml", "capture = 'board.toml'\nframes = 2\nset = ['render.seed=5']\n");
    folder.succeed(&format!("dataset set.toml -o set {MAPS}"));
    folder.add("board.toml", BOARD.replace("[render]\n", "[render]\nseed = 5\n"));
    folder.add("set.toml", "capture = 'board.toml'\nframes = 2\n");
    folder.succeed(&format!("dataset set.toml -o capture {MAPS}"));
    let map = |out: &str, n: &str| noise(&folder, &format!("{out}/camera/00000{n}/noise.exr"));
    for out in ["argument", "set", "capture"] {
        for n in ["0", "1"] {
            assert_same_camera(&map("out", n), &map(out, n));
            assert_other_noise(&map("out", n), &map(out, n));
            assert!(map(out, n) == map("argument", n), "the same wherever it stands");
        }
        assert_other_noise(&map(out, "0"), &map(out, "1"));
    }
    folder.add("set.toml", "capture = 'board.toml'\n[[vary]]\nkey = 'render.seed'\nchoice = [1, 2]\n");
    folder.fail(
        "dataset set.toml -o no",
        1,
        &["set.toml:3: vary[0].key: render.seed: every image has a seed", "seed = 1"],
    );
}

/// Series and brackets, with other seeds, of stored light and of an image set.
#[rstest]
#[case::series("--frames 2", "noise-0000.exr", "noise-0001.exr")]
#[case::bracket("--set exposure.bracket_ev=[0,1]", "noise-0000.exr", "noise-0001.exr")]
fn images_of_one_render_are_of_one_camera(#[case] arguments: &str, #[case] first: &str, #[case] second: &str) {
    let folder = folder("");
    folder.succeed(&format!("render board.toml -o out {MAPS} --set output.electrons=true {arguments}"));
    let [a, b] = [first, second].map(|name| noise(&folder, &format!("out/{name}")));
    assert_same_camera(&a, &b);
    assert_other_noise(&a, &b);
    folder.succeed(&format!("expose out -o again {MAPS} --seed 8"));
    let again = noise(&folder, &format!("again/{first}"));
    assert_same_camera(&a, &again);
    assert_other_noise(&a, &again);
    folder.succeed(&format!("expose out -o other {MAPS} --set sensor.serial=8"));
    let other = noise(&folder, &format!("other/{first}"));
    assert_other_camera(&a, &other);
    for map in ["read_noise_e", "photon_shot_noise_e"] {
        assert!(correlation(&a, &other, map) > 0.9, "the seed is the same");
    }
}

#[test]
fn image_sets_show_the_fixed_pattern_of_a_serial_number() {
    let folder = Folder::new([]);
    let take = |out: &str, arguments: &str| {
        folder.succeed(&format!(
            "emva1288 sony-imx249-mono --size 48x32 --steps 5 --spatial 32 --format tiff -q -o {out} {arguments}"
        ));
        // The mean of 32 images of even light: PRNU, and a little of the noise.
        let mut names: Vec<_> = std::fs::read_dir(folder.path(out).join("Y/images"))
            .expect("images")
            .map(|e| e.expect("an entry").path())
            .collect();
        names.retain(|path| path.to_string_lossy().contains("stack-bright"));
        names.sort();
        assert_eq!(names.len(), 32, "{:?}", folder.contents().keys());
        let mut sum = vec![0f32; 48 * 32];
        for path in names {
            let raw = photosite::raw::read_tiff(std::fs::File::open(path).expect("an image")).expect("TIFF");
            sum.iter_mut().zip(&raw.data).for_each(|(sum, &dn)| *sum += f32::from(dn));
        }
        let channel = photosite::image::Channel { name: "mean".to_owned(), data: sum };
        Planes::new(48, 32, vec![channel]).expect("a plane")
    };
    let (one, seed, other) = (take("one", ""), take("seed", "--seed 9"), take("other", "--set serial=9"));
    // Were it nothing but noise, 48·32 pairs would correlate by 5/√1536 = 0.13 at most.
    assert!(correlation(&one, &seed, "mean") > 0.5, "{}", correlation(&one, &seed, "mean"));
    assert!(correlation(&one, &other, "mean").abs() < 0.13, "{}", correlation(&one, &other, "mean"));
}

/// Every file of a data set, wherever it is made from and however its path is typed.
#[test]
fn how_a_path_is_typed_makes_no_difference() {
    let set = "capture = '../captures/board.toml'\nframes = 2\n[[cameras]]\nname = 'left'\ndisparity_to = 'right'\n[[cameras]]\n\
        name = 'right'\nposition_m = [0.1, 0, 0]\n";
    let board = BOARD.replace("[scene]\n", "[scene]\ngeometry = ['parts/stand.obj']\n");
    // A material that nothing describes is worth a warning, as is a library that is not there.
    let stand = "mtllib none.mtl\no stand\nusemtl wood\nv 0 -1 -0.2\nv 1 -1 -0.2\nv 0 0 -0.2\nf 1 2 3\n";
    let folder = Folder::new([
        ("in/sets/set.toml", set.into()),
        ("in/captures/board.toml", board.into()),
        ("in/captures/parts/stand.obj", stand.into()),
        ("elsewhere/notes.txt", "mine".into()),
    ]);
    let run = |from: &str, input: &str, out: &str| {
        let mut command = folder.command(&format!("dataset {input} -o {out} --quiet"));
        let output = command.current_dir(folder.path(from)).output().expect("the binary runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run(".", "in/sets/set.toml", "a");
    run("in/sets", "set.toml", "../../b");
    run("elsewhere", "../in/captures/../sets/./set.toml", "../c");
    run("elsewhere", &folder.path("in/sets/set.toml").display().to_string(), &folder.path("d").display().to_string());
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path("in"), folder.path("linked")).expect("a link");
        run(".", "linked/sets/set.toml", "e");
        assert!(files(&folder, "a") == files(&folder, "e"));
    }
    for out in ["b", "c", "d"] {
        let (a, other) = (files(&folder, "a"), files(&folder, out));
        assert!(a.keys().eq(other.keys()));
        for (name, bytes) in &a {
            assert!(*bytes == other[name], "{} of {out}", name.display());
        }
    }
    let report = folder.report("a/left/000000");
    assert_eq!(report["input"], "../captures/board.toml", "as the data set file has it");
    let warnings = report["warnings"].to_string();
    assert!(warnings.contains("parts/stand.obj: ") && !warnings.contains("captures"), "{warnings}");
    // A render's own report names what was rendered as all else: from its own folder.
    let render = |from: &str, input: &str, out: &str| {
        let mut command = folder.command(&format!("render {input} -o {out} --quiet"));
        assert!(command.current_dir(folder.path(from)).status().expect("it runs").success());
    };
    render(".", "in/captures/board.toml", "r/one");
    render("in", "captures/board.toml", "../r/two");
    let [one, two] = ["r/one", "r/two"].map(|out| crate::same_bytes::timeless(folder.report(out)));
    assert_eq!(one, two);
    assert_eq!(one["input"], "../../in/captures/board.toml");
    render(".", "in/captures/board.toml --set output.electrons=true", "r/light");
    folder.succeed("expose r/light -o r/three --quiet");
    assert_eq!(folder.report("r/three")["input"], "../light");
}
