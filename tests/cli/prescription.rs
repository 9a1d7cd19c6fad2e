//! Captures whose lens is a prescription: what is told of it, where points are, what models other tools get, data sets.

use photosite::optics::{BrownConrady, Intrinsics, Projection};
use rstest::rstest;
use serde_json::Value;

use crate::dataset::BOARD;
use crate::folder::Folder;

/// A chessboard of 8 × 5 inner corners before a sensor of 24 × 16 mm.
fn board(lens: &str) -> String {
    let parts = BOARD.split("type = 'pinhole'\nf_number = 4\nfocal_length_mm = 6\nfocus_distance_m = 'infinity'\n");
    let whole = parts.collect::<Vec<_>>().join(lens);
    let whole = whole.replace(
        "resolution_px = [32, 24]\npixel_pitch_um = [200, 200]",
        "resolution_px = [60, 40]\npixel_pitch_um = [400, 400]",
    );
    whole.replace("position_m = [0, 0, 0.6]", "position_m = [0, 0, 1]")
}

fn numbers(text: &str) -> Vec<Vec<f64>> {
    text.lines().map(|line| line.split(',').map(|x| x.parse().expect("a number")).collect()).collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// Optiland's figures of a lens.
fn reference() -> Value {
    let text = include_str!("../../crates/photosite-lens/tests/reference/cooke-triplet.json");
    serde_json::from_str(text).expect("JSON")
}

/// The lens as its designer left it, which is how Optiland has it.
const TRIPLET: &str = "prescription = 'cooke-triplet'\nimage_distance_mm = 42.20778\n";

#[test]
fn a_report_tells_pupils_and_working_f_number_as_optiland_has_them() {
    let reference = reference();
    let of_d = |key: &str| number(&reference["figures"]["first_order"]["optiland"][key][1]);
    let folder = Folder::new([("board.toml", board(TRIPLET).into())]);
    folder.succeed("render board.toml -o out --quiet");
    let report = folder.report("out");
    let traced = &report["lens"]["traced"];
    let surfaces = reference["surfaces"].as_array().expect("surfaces");
    let length: f64 = surfaces.iter().map(|surface| number(&surface["thickness"])).sum();
    for (key, wanted) in [
        ("focal_length_mm", of_d("efl_mm")),
        ("entrance_pupil_mm", of_d("entrance_pupil_diameter_mm")),
        ("entrance_pupil_to_sensor_mm", length - of_d("entrance_pupil_mm")),
        ("exit_pupil_mm", of_d("exit_pupil_diameter_mm")),
        ("exit_pupil_to_sensor_mm", 42.20778 - of_d("exit_pupil_mm")),
        ("length_mm", length),
    ] {
        assert!((number(&traced[key]) - wanted).abs() < 1e-5, "{key}: {traced} {wanted}");
    }
    // |S| on the axis at F and at d; ours is at 555 nm, between them.
    let [f, d] = [0, 1]
        .map(|line| number(&reference["figures"]["illumination"]["optiland"]["projected_solid_angle_sr"][line][0]));
    let n = number(&traced["working_f_number"]);
    let sr = std::f64::consts::PI * (0.5 / n).powi(2);
    assert!(d < sr && sr < f, "{sr} {d} {f}");
}

/// Chief rays of Optiland, of objects at infinity; places are those at 555 nm, between F and d.
#[test]
fn far_points_appear_where_chief_rays_land() {
    let reference = reference();
    let chief = &reference["figures"]["chief_rays"];
    let folder = Folder::new([("board.toml", board(TRIPLET).into())]);
    let fields = chief["field_deg"].as_array().expect("fields");
    // The image ends 14.4 mm from the axis.
    let angles: Vec<f64> = fields.iter().take(6).map(|angle| number(angle).to_radians()).collect();
    let points: String =
        angles.iter().map(|angle| format!("{}, 0, {}\n", 1e7 * angle.sin(), 1e7 * angle.cos())).collect();
    folder.add("points.csv", points);
    let found = numbers(&folder.succeed("project board.toml --points points.csv --camera-space").stdout);
    for (i, place) in found.iter().enumerate() {
        let [f, d] = [0, 1].map(|line| number(&chief["optiland"]["image_height_mm"][line][i]));
        let height = (place[0] - 29.5) * 0.4;
        // Below 1 nm where F and d land on the same place.
        assert!((height - d).abs() < (f - d).abs() + 1e-6, "{height} {f} {d}");
        assert!((place[1] - 19.5).abs() < 1e-9);
    }
}

/// A line of sight is that of all of its points, near and far.
#[rstest]
#[case::triplet("prescription = 'cooke-triplet'\nfocus_distance_m = 1.05\n")]
#[case::wide("prescription = 'canon-rf24'\nfocus_distance_m = 1.05\n")]
#[case::fisheye("prescription = 'fisheye-170'\nfocus_distance_m = 1.05\n")]
fn pixels_look_along_lines_all_of_whose_points_they_show(#[case] lens: &str) {
    let folder = Folder::new([("board.toml", board(lens).into())]);
    let size = if lens.contains("fisheye") { " --set sensor.pixel_pitch_um=[80,80]" } else { "" };
    folder.add("pixels.csv", "29.5, 19.5\n5, 8\n40, 33\n50.25, 2.5\n");
    for space in ["", " --camera-space"] {
        let command = |file: &str, more: &str| format!("project board.toml --points {file}{space}{size}{more}");
        let lines = numbers(&folder.succeed(&command("pixels.csv", " --inverse --origin")).stdout);
        let directions = numbers(&folder.succeed(&command("pixels.csv", " --inverse")).stdout);
        for t in [0.1, 1.0, 30.0] {
            let point = |line: &Vec<f64>| [0, 1, 2].map(|i| (line[i] + t * line[3 + i]).to_string()).join(",");
            folder.add("points.csv", lines.iter().map(point).collect::<Vec<_>>().join("\n"));
            let places = numbers(&folder.succeed(&command("points.csv", "")).stdout);
            let pixels = [[29.5, 19.5], [5.0, 8.0], [40.0, 33.0], [50.25, 2.5]];
            for (place, pixel) in places.iter().zip(pixels) {
                assert!((place[0] - pixel[0]).hypot(place[1] - pixel[1]) < 1e-4, "{t} m: {place:?} {pixel:?}");
            }
        }
        assert!(lines.iter().zip(&directions).all(|(line, direction)| line[3..] == direction[..]));
    }
}

/// The number after a word.
fn after(text: &str, word: &str) -> f64 {
    let rest = text.split(word).nth(1).unwrap_or_else(|| panic!("{word}: {text}")).trim_start();
    rest.split([' ', ',', '\n']).next().and_then(|x| x.parse().ok()).unwrap_or_else(|| panic!("{word}: {text}"))
}

/// What files say of the camera is a model that says of itself how far it is from the lens, which is checked point by point.
#[rstest]
#[case::triplet("cooke-triplet", "", "opencv", 0.02)]
#[case::of_two_coefficients("cooke-triplet", "", "kalibr", 0.2)]
#[case::wide("canon-rf24", "", "opencv", 0.06)]
// Pixels of 0.8 µm.
#[case::fisheye("fisheye-170", " --set sensor.pixel_pitch_um=[80,80]", "opencv", 0.6)]
fn files_of_cameras_hold_the_nearest_model_and_tell_how_near(
    #[case] lens: &str,
    #[case] more: &str,
    #[case] format: &str,
    #[case] bound_px: f64,
) {
    let lens = format!("prescription = '{lens}'\nfocus_distance_m = 1.05\n");
    // Pixels as small as cameras have them.
    let text = board(&lens).replace("[60, 40]", "[6000, 4000]").replace("[400, 400]", "[4, 4]");
    let more = more.replace("80,80", "0.8,0.8");
    let folder = Folder::new([("board.toml", text.into())]);
    let outcome = folder.succeed(&format!("camera board.toml --format {format}{more}"));
    let (rms, largest) = (after(&outcome.stderr, "rms"), after(&outcome.stderr, "largest"));
    assert!(rms <= largest && largest < bound_px, "{}", outcome.stderr);
    if format != "opencv" {
        return;
    }
    let list = |key: &str| -> Vec<f64> {
        let data = outcome.stdout.split(key).nth(1).and_then(|rest| rest.split("data: [").nth(1)).expect(key);
        data.split(']').next().expect("a list").split(',').map(|x| x.trim().parse().expect("a number")).collect()
    };
    let (k, c) = (list("camera_matrix:"), list("distortion_coefficients:"));
    let projection = match &c[..] {
        &[k1, k2, k3, k4] if outcome.stdout.contains("distortion_model: fisheye") => {
            Projection::KannalaBrandt { k: [k1, k2, k3, k4] }
        }
        c => {
            let at = |i: usize| c.get(i).copied().unwrap_or(0.0);
            let k = [0, 1, 4, 5, 6, 7].map(at);
            Projection::BrownConrady(BrownConrady { k, p: [at(2), at(3)], ..BrownConrady::default() })
        }
    };
    let intrinsics = Intrinsics { fx: k[0], fy: k[4], cx: k[2], cy: k[5], skew: 0.0 };
    // The light of the fisheye does not come to the corners.
    let part = if c.len() == 4 { 0.7 } else { 1.0 };
    let pixels = [[0.1, -0.2], [-0.9, -0.8], [1.0, 1.0], [0.5, -0.6], [-1.0, 0.0]]
        .map(|[x, y]: [f64; 2]| [2999.5 + 3000.0 * part * x, 1999.5 + 2000.0 * part * y]);
    folder.add("pixels.csv", pixels.map(|[x, y]| format!("{x}, {y}")).join("\n"));
    let command = format!("project board.toml --points pixels.csv --camera-space --inverse --origin{more}");
    let distance = after(&outcome.stderr, "of the lens at");
    for (line, pixel) in numbers(&folder.succeed(&command).stdout).iter().zip(pixels) {
        let [origin, direction] = [0, 3].map(|i| glam::DVec3::new(line[i], line[i + 1], line[i + 2]));
        let is_fisheye = matches!(projection, Projection::KannalaBrandt { .. });
        let t = if is_fisheye { distance } else { (distance - origin.z) / direction.z };
        let place = projection.project(origin + direction * t, &projection.reach(None)).expect("seen");
        let off = (intrinsics.pixel(place) - glam::DVec2::from_array(pixel)).length();
        assert!(off <= largest + 1e-3, "{pixel:?}: {off} {largest}");
    }
}

#[test]
fn reports_of_all_lenses_that_ship_can_be_read_again() {
    for lens in photosite_lens::files::names() {
        let folder = Folder::new([("board.toml", board(&format!("prescription = '{lens}'\n")).into())]);
        folder.succeed("render board.toml -o out --quiet --spp 1");
        folder.succeed("info out/capture.json");
        let radius_px = &folder.report("out")["camera"]["field_of_view"]["radius_px"];
        assert!(number(&radius_px[0]) > 0.0 && number(&radius_px[1]) >= number(&radius_px[0]), "{lens}: {radius_px}");
    }
}

/// A set of images through a lens from a prescription: the model that is fitted stands in its files.
#[test]
fn data_sets_tell_the_fitted_model() {
    let lens = "prescription = 'cooke-triplet'\nf_number = 8\nfocus_distance_m = 1.3\n";
    let capture = board(lens).replace("electrons = false", "electrons = false\ntruth = ['depth', 'instance', 'flow']");
    let set = "capture = 'board.toml'\nframes = 2\n[poses.random]\ntarget = 'board'\ndistance_m = [1.2, 1.4]\nmargin_px = 1\n";
    let folder = Folder::new([("board.toml", capture.into()), ("set.toml", set.into())]);
    folder.succeed("dataset set.toml -o set --set develop.distortion=false --quiet");
    let report = folder.report("set/camera/000000");
    let fitted = &report["camera"]["fitted"];
    assert_eq!(
        (&report["camera"]["projection"], &fitted["projection"]),
        (&"prescription".into(), &"brown-conrady".into())
    );
    assert!(number(&fitted["largest_px"]) < 0.02, "{fitted}");
    let yaml = folder.text("set/calibration/opencv/camera.yaml");
    let fx = number(&fitted["camera_matrix"][0][0]);
    assert!(yaml.contains(&format!("{fx}")) && yaml.contains("distortion_model: calib3d"), "{yaml}");
    folder.succeed("layout set --format colmap -o colmap");
}

/// At f/8 the iris of a fast lens is clear of its other apertures; the farthest chief rays meet these first. By the reference
/// rays the chief ray of canon-ef85 passes up to some 24 mm from the axis.
#[test]
fn points_whose_chief_ray_is_blocked_are_flagged() {
    let lens = "prescription = 'canon-ef85'\nf_number = 8\nfocus_distance_m = 3.5\n";
    let folder = Folder::new([("board.toml", board(lens).replace("square_mm = 30", "square_mm = 150").into())]);
    let far = " --set camera.position_m=[0,0,1.5]";
    folder.succeed(&format!("render board.toml -o small --quiet{far} --set sensor.pixel_pitch_um=[400,400]"));
    folder.succeed(&format!("render board.toml -o large --quiet{far} --set sensor.pixel_pitch_um=[1000,1000]"));
    let [small, large] = ["small", "large"].map(|name| folder.report(name));
    assert!(small["lens"]["traced"]["clear_radius_mm"].is_null() && small["targets"][0]["points_vignetted"].is_null());
    let clear_px = number(&large["lens"]["traced"]["clear_radius_mm"]);
    assert!((20.0..28.0).contains(&clear_px), "{clear_px}");
    let target = &large["targets"][0];
    let flags = target["points_vignetted"].as_array().expect("flags");
    for (flag, place) in flags.iter().zip(target["points_px"].as_array().expect("places")) {
        // Beyond all chief rays that reach the sensor a point has no place.
        if place.is_null() {
            assert_eq!(flag, false);
            continue;
        }
        let from_axis = (number(&place[0]) - 29.5).hypot(number(&place[1]) - 19.5);
        assert_eq!(flag.as_bool(), Some(from_axis > clear_px), "{place} {clear_px}");
    }
    assert!(flags.iter().any(|flag| flag == true) && flags.iter().any(|flag| flag == false), "{flags:?}");
}

/// Images of points come from the disk as they were worked out, and are worked out anew where what lies there is broken.
#[test]
fn images_of_points_from_the_disk_give_the_same_bytes() {
    let lens = "prescription = 'cooke-triplet'\nf_number = 8\nfocus_distance_m = 1.05\npsf = { kind = 'wave' }\n";
    let folder = Folder::new([("board.toml", board(lens).into())]);
    let render_with = |more: &str, out: &str, cache: &str| {
        let small = format!("--set sensor.resolution_px=[8,6] --set render.samples_per_pixel=1 {more}");
        let mut command = folder.command(&format!("render board.toml -o {out} --quiet {small}"));
        assert!(command.env("PHOTOSITE_CACHE", cache).status().expect("the binary runs").success());
        std::fs::read(folder.path(out).join("image.png")).expect("an image")
    };
    let render = |out: &str, cache: &str| render_with("", out, cache);
    let kept = || -> Vec<std::path::PathBuf> {
        let lenses = std::fs::read_dir(folder.path("cache/point-spreads")).expect("a folder");
        let files = |lens: std::fs::DirEntry| std::fs::read_dir(lens.path()).expect("a folder of a lens");
        lenses.flat_map(|lens| files(lens.expect("an entry"))).map(|file| file.expect("an entry").path()).collect()
    };
    let without = render("off", "off");
    assert_eq!(render("cold", "cache"), without);
    let files = kept();
    let last_written =
        |file: &std::path::PathBuf| std::fs::metadata(file).and_then(|data| data.modified()).expect("a time");
    let times: Vec<_> = files.iter().map(last_written).collect();
    assert_eq!(render("warm", "cache"), without);
    // As a camera that stands elsewhere does, of other settings of what is behind the lens.
    render_with("--set camera.position_m=[0.02,0,0.9]", "moved", "cache");
    render_with("--set exposure.time_s=0.001 --set render.seed=3", "exposed", "cache");
    assert_eq!(files.iter().map(last_written).collect::<Vec<_>>(), times);
    let lenses = || std::fs::read_dir(folder.path("cache/point-spreads")).expect("a folder").count();
    assert_eq!(lenses(), 1);
    let files = kept();
    for (i, file) in files.iter().enumerate() {
        let bytes = std::fs::read(file).expect("a file");
        std::fs::write(file, if i % 2 == 0 { &bytes[..bytes.len() / 2] } else { &b"words"[..] }).expect("writes");
    }
    assert_eq!(render("broken", "cache"), without);
    assert_eq!(kept().len(), files.len());
}

/// A frame of white before a lens whose image does not fill the sensor: what reaches into a dark corner is cut off, as the
/// image itself says.
#[test]
fn objects_that_reach_into_the_dark_corners_of_a_lens_are_cut_off() {
    let quad = "v -0.02 -0.02 0\nv 0.02 -0.02 0\nv 0.02 0.02 0\nv -0.02 0.02 0\nf 1 2 3 4\n";
    const PLACES: usize = 24;
    let objects: String = (0..PLACES)
        .map(|i| {
            let out = 0.8 * (i as f64 + 0.5) / PLACES as f64;
            format!("[[scene.objects]]\nfile = 'quad.obj'\nposition_m = [{out}, {out}, 0]\n")
        })
        .collect();
    let capture = format!(
        "{objects}[scene]\nenvironment = {{ illuminant = 'D65', illuminance_lux = 2000 }}\n[camera]\n\
         position_m = [0, 0, 1]\nlook_at_m = [0, 0, 0]\n[lens]\n{TRIPLET}[sensor]\npreset = 'sony-imx249-mono'\n\
         resolution_px = [81, 81]\npixel_pitch_um = [1000, 1000]\n[exposure]\ntime_s = 0.0001\n[render]\n\
         samples_per_pixel = 16\nmax_depth = 2\n[output]\ntruth = ['instance']\nobjects = true\n[develop]\n\
         distortion = false\n"
    );
    let folder = Folder::new([("quad.obj", quad.into()), ("capture.toml", capture.into())]);
    folder.succeed("render capture.toml -o out --quiet");
    let objects = folder.json("out/objects.json");
    let light = image::open(folder.path("out/image.png")).expect("an image").into_luma8();
    let (mut cut, mut whole) = (0, 0);
    for object in objects["objects"].as_array().expect("objects") {
        let corners = object["box_corners_px"].as_array().expect("corners");
        // Darkest and brightest pixel around the corners; beyond the image it is dark.
        let around = corners.iter().flat_map(|corner| {
            let place = corner.as_array().map_or([-9.0; 2], |place| [number(&place[0]), number(&place[1])]);
            [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|[x, y]| [place[0] + x, place[1] + y])
        });
        let values: Vec<u8> = around
            .map(|[x, y]| {
                let is_on = x > -0.5 && y > -0.5;
                let pixel = light.get_pixel_checked(x.round() as u32, y.round() as u32).filter(|_| is_on);
                pixel.map_or(0, |pixel| pixel.0[0])
            })
            .collect();
        let of_corners: Vec<bool> = values.chunks(4).map(|four| four.iter().all(|value| *value > 8)).collect();
        let is_dark = values.chunks(4).any(|four| four.iter().all(|value| *value <= 8));
        // At the rim itself pixels are lit in part.
        if !is_dark && !of_corners.iter().all(|is_lit| *is_lit) {
            continue;
        }
        assert_eq!(object["is_cut_off"], is_dark, "{object} {values:?}");
        if is_dark { cut += 1 } else { whole += 1 }
    }
    assert!(cut >= 4 && whole >= 4, "{cut} cut off and {whole} whole");
}
