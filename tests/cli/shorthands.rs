//! `--spp`, `--size`, `--env`, and the field of view in place of a focal length.

use rstest::rstest;
use serde_json::{Value, json};

use crate::folder::Folder;
use crate::room::room;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The same view at another size: what the image shows, how bright it is and how sharp stay.
#[rstest]
#[case::as_it_is("", [96, 64], 1.0)]
#[case::half("--size 48x32", [48, 32], 2.0)]
#[case::finer("--size 192x128", [192, 128], 0.5)]
// Wider: as high as before, and more at the sides.
#[case::wider("--size 96x32", [96, 32], 2.0)]
fn size_keeps_the_view(#[case] option: &str, #[case] size: [usize; 2], #[case] growth: f64) {
    let folder = room("[render]\nsamples_per_pixel = 4");
    let base = "--set sensor.resolution_px=[96,64]";
    folder.succeed(&format!("render capture.toml -o before {base}"));
    folder.succeed(&format!("render capture.toml -o after {base} {option} --spp 2"));
    let [before, after] = ["before", "after"].map(|name| folder.report(name));
    assert_eq!(after["sensor"]["resolution_px"], json!(size));
    assert_eq!(after["render"]["samples_per_pixel"], 2);
    let focal = |report: &Value| number(&report["camera"]["camera_matrix"][0][0]);
    assert!((focal(&before) / focal(&after) / growth - 1.0).abs() < 1e-12);
    // Pixels of an area larger by a factor hold as much more, in numbers that are worth as much more.
    let sensor = |key: &str| number(&after["sensor"][key]) / number(&before["sensor"][key]);
    assert!((sensor("saturation_capacity_e") / growth.powi(2) - 1.0).abs() < 1e-9);
    assert!((sensor("system_gain_dn_per_e") * growth.powi(2) - 1.0).abs() < 1e-9);
    assert_eq!(
        (&after["exposure"]["time_s"], &after["lens"]["f_number"]),
        (&before["exposure"]["time_s"], &before["lens"]["f_number"])
    );
    // And the image is as bright, but for what is seen beside it.
    if size[0] * 64 == size[1] * 96 {
        let brightness = |name: &str| {
            let estimate = folder.electrons(name);
            let sum = |planes: &photosite::image::Planes| {
                planes.plane("G").expect("G").iter().map(|&v| f64::from(v)).sum::<f64>()
            };
            let area: f64 =
                folder.report(name)["sensor"]["resolution_px"].as_array().expect("two").iter().map(number).product();
            (sum(&estimate.mean) / area, sum(&estimate.variance).sqrt() / area)
        };
        let ((a, error_a), (b, error_b)) = (brightness("before"), brightness("after"));
        let (b, error_b) = (b / growth.powi(2), error_b / growth.powi(2));
        // Five deviations; the edges of things fall on other pixels, which the means of whole images share.
        assert!((a - b).abs() < 5.0 * error_a.hypot(error_b) + 0.01 * a, "{a} ± {error_a}, {b} ± {error_b}");
    }
}

#[rstest]
#[case::words("--size small", "write columns and rows, for example 800x600")]
#[case::none("--size 0x10", "write columns and rows")]
fn sizes_that_are_none_are_refused(#[case] option: &str, #[case] message: &str) {
    room("").fail(&format!("render capture.toml -o out {option}"), 2, &[message]);
}

#[rstest]
#[case::matrix("lens.intrinsics={fx=85,fy=80,cx=33,cy=20}", "lens.intrinsics")]
#[case::region("exposure.region_px=[0,0,8,8]", "exposure.region_px")]
fn places_in_pixels_do_not_go_with_another_size(#[case] change: &str, #[case] key: &str) {
    let options = format!("render capture.toml -o out --size 48x32 --set {change}");
    room("").fail(&options, 1, &["sensor.scaled_to_px: cannot be combined with ", key]);
}

/// A panorama takes the place of whatever lit the scene, wherever it lies.
#[test]
fn an_image_of_the_surroundings_lights_the_scene() {
    let folder = Folder::new([
        ("models/sail.obj", b"v -1 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n".to_vec()),
        (
            "skies/even.hdr",
            [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec(), [128, 128, 128, 129].repeat(8)].concat(),
        ),
        (
            "capture.toml",
            b"[scene]\ngeometry = ['models/sail.obj']\nenvironment = { sky = { sun_elevation_deg = 20 } }\n".to_vec(),
        ),
    ]);
    let small = "--size 12x9 --spp 2 --force --env skies/even.hdr";
    for (input, path) in [("models/sail.obj", "../skies/even.hdr"), ("capture.toml", "skies/even.hdr")] {
        folder.succeed(&format!("render {input} -o out {small}"));
        let scene = folder.report("out")["capture"]["scene"].clone();
        assert_eq!(scene["environment"], json!({ "image": "../skies/even.hdr", "illuminance_lux": 10000.0 }), "{path}");
        assert_eq!(scene.get("ground"), None);
    }
    // What --set says of it holds.
    folder.succeed(&format!("render capture.toml -o out {small} --set scene.environment.illuminance_lux=20"));
    assert_eq!(folder.report("out")["capture"]["scene"]["environment"]["illuminance_lux"], 20);
    folder.fail("render capture.toml -o new --env none.hdr", 1, &["none.hdr: cannot read"]);
}

/// Half the width of the image is seen under half the angle, through whatever projection.
#[rstest]
#[case::rectilinear("", 40.0, |half: f64| half.tan())]
#[case::fisheye("projection = 'fisheye'", 170.0, |half: f64| half)]
#[case::stereographic("projection = 'stereographic'", 200.0, |half: f64| 2.0 * (half / 2.0).tan())]
fn the_field_of_view_is_that_of_the_width(#[case] lens: &str, #[case] degrees: f64, #[case] radius: fn(f64) -> f64) {
    let capture = format!(
        "[scene]\ngeometry = ['sail.obj']\nenvironment = 'even'\n[lens]\nhorizontal_fov_deg = {degrees}\n{lens}\n"
    );
    let folder = Folder::new([
        ("sail.obj", b"v -1 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n".to_vec()),
        ("capture.toml", capture.into()),
    ]);
    let small = "--set sensor.resolution_px=[24,16] --spp 1 --force";
    folder.succeed(&format!("render capture.toml -o out {small}"));
    let report = folder.report("out");
    let fx = number(&report["camera"]["camera_matrix"][0][0]);
    let expected = radius(degrees.to_radians() / 2.0);
    assert!((12.0 / fx / expected - 1.0).abs() < 1e-9, "{fx}: {} instead of {expected}", 12.0 / fx);
    // A focal length on the command line takes its place, and it takes that of one.
    folder.succeed(&format!("render capture.toml -o out {small} --set lens.focal_length_mm=8"));
    assert_eq!(folder.report("out")["lens"]["focal_length_mm"], 8.0);
    folder.succeed(&format!(
        "render capture.toml -o out {small} --set lens.focal_length_mm=8 --set lens.horizontal_fov_deg=30"
    ));
    assert_eq!(folder.report("out")["capture"]["lens"].get("focal_length_mm"), None);
}

/// A prescription on the command line takes the place of all that describes another lens, and says so; a zoom's focal
/// length is asked for again.
#[test]
fn a_prescription_takes_the_place_of_a_lens_and_gives_it_up() {
    let folder = room("[render]\nsamples_per_pixel = 1\n");
    let small = "--set sensor.resolution_px=[24,16] --force";
    let lens_of = |more: &str| {
        let told = folder.succeed(&format!("render capture.toml -o out {small} {more}")).text();
        (folder.report("out")["capture"]["lens"].clone(), folder.report("out")["lens"].clone(), told)
    };
    let (capture, lens, told) = lens_of("--set lens.prescription=double-gauss --set lens.f_number=4");
    assert!(
        told.contains("lens.prescription=double-gauss replaces lens.focal_length_mm, lens.distortion, which"),
        "{told}"
    );
    assert_eq!(capture, serde_json::json!({ "prescription": "double-gauss", "f_number": 4, "blades": 6 }));
    assert!((number(&lens["focal_length_mm"]) - 99.5).abs() < 1.0, "{lens}");
    // What an argument says of a zoom stays, in any order.
    let sets = ["--set lens.prescription=zoom-laikin", "--set lens.focal_length_mm=50", "--set lens.f_number=8"];
    for order in [[0, 1, 2], [1, 0, 2]] {
        let (capture, lens, _) = lens_of(&order.map(|i| sets[i]).join(" "));
        assert_eq!((number(&lens["focal_length_mm"]), number(&capture["focal_length_mm"])), (50.0, 50.0));
    }
    let glass = folder.text("capture.toml");
    let start = glass.find("focal_length_mm").expect("a key");
    let end = glass.find("[sensor]").expect("a table");
    folder.add("capture.toml", [&glass[..start], "prescription = 'double-gauss'\n", &glass[end..]].concat());
    let (capture, lens, told) = lens_of("--set lens.type=thin --set lens.focal_length_mm=35");
    assert!(told.contains("lens.type=thin replaces lens.prescription"), "{told}");
    assert_eq!((number(&lens["focal_length_mm"]), capture.get("prescription")), (35.0, None));
    let (capture, ..) = lens_of("--set lens.horizontal_fov_deg=30");
    assert_eq!(capture.get("prescription"), None);
}

#[rstest]
#[case::both(
    "focal_length_mm = 8\nhorizontal_fov_deg = 40",
    "horizontal_fov_deg: cannot be combined with focal_length_mm",
    "keep one"
)]
#[case::wide("horizontal_fov_deg = 180", "must be an angle above 0 that the projection can show, got 180", "40.0")]
#[case::none("horizontal_fov_deg = 0", "must be an angle above 0", "")]
#[case::short_name("fov_deg = 40", "unknown key `fov_deg`", "did you mean `horizontal_fov_deg`")]
fn fields_of_view_that_cannot_be_are_named(#[case] lens: &str, #[case] message: &str, #[case] help: &str) {
    let capture = format!("[scene]\ngeometry = ['sail.obj']\n[lens]\n{lens}\n");
    let folder = Folder::new([
        ("sail.obj", b"v -1 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n".to_vec()),
        ("capture.toml", capture.into()),
    ]);
    folder.fail("render capture.toml -o out", 1, &[message, help]);
}

/// The summary tells the noise of rendering against the sensor's as capture.json has it.
#[test]
fn the_summary_tells_noise_in_words() {
    let folder = room("[render]\nsamples_per_pixel = 4");
    let said = folder.succeed("render capture.toml -o out").text();
    let ratio = number(&folder.report("out")["render"]["noise_ratio"]);
    let times = if ratio < 1.0 { "" } else { " times" };
    let digits = 1 - ratio.log10().floor() as i32;
    let scale = 10f64.powi(digits);
    let words = format!("Monte Carlo noise is {}{times} that of the sensor", (ratio * scale).round() / scale);
    assert!(said.contains(&words) && said.contains("; --spp 16 would halve it"), "{words}: {said}");
    let said = folder.succeed("render capture.toml -o target --set render.noise_target=0.5 --spp 64").text();
    assert!(said.contains("Monte Carlo noise is ") && !said.contains("would halve it"), "{said}");
    assert!(!folder.succeed("render capture.toml -o quiet --quiet").text().contains("Monte Carlo"));
}

#[test]
fn the_summary_tells_of_how_many_pixels_the_noise_is() {
    let folder = room("[render]\nsamples_per_pixel = 4");
    folder.succeed("render capture.toml -o out");
    let suits = number(&folder.report("out")["exposure"]["time_s"]);
    for (times, least) in [(3.0, 0.2), (1e4, 0.99)] {
        let longer = format!("render capture.toml -o longer --force --set exposure.time_s={}", times * suits);
        let said = folder.succeed(&longer).text();
        let saturated = number(&folder.report("longer")["render"]["saturated_part"]);
        assert!((least..1.0).contains(&saturated), "{saturated}");
        assert!(said.contains(" % of pixels that are not saturated: "), "{said}");
    }
}
