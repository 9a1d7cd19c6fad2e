//! Images without distortion and with square pixels: what the report says they are images of, that the raw file
//! develops to the same, and what is said where they cannot be had.

use glam::{DMat3, DVec3};
use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;
use crate::report::vector;

/// A lamp of a few pixels in the dark, before a camera that looks along −z from 3 m.
fn lamp(place: [f64; 2], capture: &str) -> Folder {
    let corner = |x: f64, y: f64| format!("v {} {} 0\n", place[0] + x, place[1] + y);
    let corners = [corner(-0.05, -0.05), corner(0.05, -0.05), corner(0.05, 0.05), corner(-0.05, 0.05)].concat();
    Folder::new([
        ("lamp.obj", format!("mtllib lamp.mtl\n{corners}usemtl lamp\nf 1 2 3 4\n").into()),
        ("lamp.mtl", b"newmtl lamp\nKe 2 2 2\n".to_vec()),
        (
            "capture.toml",
            format!(
                "[scene]\ngeometry = ['lamp.obj']\n[camera]\nposition_m = [0, 0, 3]\nlook_at_m = [0, 0, 0]\n[render]\n\
                 samples_per_pixel = 64\n[develop]\ntone_curve = 'linear'\nbits = 16\n{capture}"
            )
            .into(),
        ),
    ])
}

/// The centre of what is bright in an image.
fn centroid(folder: &Folder, image: &str) -> [f64; 2] {
    let image = image::open(folder.path(image)).expect("an image").to_luma16();
    let brightest = image.pixels().map(|code| code.0[0]).max().expect("pixels");
    let (mut sum, mut at) = (0.0, [0.0; 2]);
    // Noise of the dark has no place.
    for (x, y, code) in image.enumerate_pixels().filter(|(_, _, code)| code.0[0] > brightest / 20) {
        let code = f64::from(code.0[0]);
        sum += code;
        at = [at[0] + code * f64::from(x), at[1] + code * f64::from(y)];
    }
    at.map(|at| at / sum)
}

fn image_size(folder: &Folder, image: &str) -> [u32; 2] {
    let image = image::open(folder.path(image)).expect("an image");
    [image.width(), image.height()]
}

#[rstest]
#[case::square_pixels("", "pixel_pitch_um = [100, 100]", [64, 48])]
#[case::wide_pixels("", "pixel_pitch_um = [150, 100]", [96, 48])]
#[case::high_pixels("distortion = { model = 'division', k = [-0.4] }", "pixel_pitch_um = [100, 150]", [64, 72])]
#[case::polynomial("distortion = { model = 'polynomial', k = [0.3, 0.1] }", "pixel_pitch_um = [100, 100]", [64, 48])]
#[case::fisheye("distortion = { model = 'kannala-brandt', k = [0.1] }", "pixel_pitch_um = [100, 100]", [64, 48])]
#[case::rational(
    "distortion = { model = 'brown-conrady', k = [-0.2, 0.1, 0, 0.2], s = [0.01] }",
    "pixel_pitch_um = [100, 100]",
    [64, 48]
)]
fn a_lamp_is_where_the_camera_of_the_image_shows_it(
    #[case] lens: &str,
    #[case] pitch: &str,
    #[case] size: [u32; 2],
    #[values([0.7, 0.5], [-0.8, -0.3])] place: [f64; 2],
) {
    let capture = format!(
        "[lens]\ntype = 'pinhole'\nfocal_length_mm = 8\nf_number = 8\nfocus_distance_m = 'infinity'\n{lens}\n[sensor]\n\
         preset = 'sony-imx249-mono'\nresolution_px = [64, 48]\n{pitch}\n[exposure]\ntime_s = 0.01\n"
    );
    let folder = lamp(place, &capture);
    folder.succeed("render capture.toml -o out");
    assert_eq!(image_size(&folder, "out/image.png"), size);
    let report = folder.report("out");
    let image = &report["image"];
    assert_eq!(image["resolution_px"], serde_json::json!(size));
    let rows: [[f64; 3]; 3] = serde_json::from_value(image["camera_matrix"].clone()).expect("nine numbers");
    let rotation: [[f64; 3]; 3] = serde_json::from_value(report["camera"]["rotation"].clone()).expect("nine numbers");
    let matrix = |rows: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&rows).transpose();
    let in_camera = matrix(rotation) * DVec3::new(place[0], place[1], 0.0) + vector(&report["camera"]["translation_m"]);
    let seen = matrix(rows) * (in_camera / in_camera.z);
    let found = centroid(&folder, "out/image.png");
    // The lamp is about 2.7 px wide; noise below its half and the bend over its width leave less than a tenth of a
    // pixel.
    let off = (found[0] - seen.x).abs().max((found[1] - seen.y).abs());
    assert!(off < 0.15, "at {found:?}, not {seen}");
    // Its model is in the raw file.
    folder.succeed("develop out/raw.dng -o again.png --capture capture.toml");
    assert!(folder.bytes("again.png") == folder.bytes("out/image.png"));
    // As it was taken, it is where the sensor saw it.
    folder.succeed("develop out/raw.dng -o taken.png --capture capture.toml --set develop.distortion=false --set develop.square_pixels=false");
    assert_eq!(image_size(&folder, "taken.png"), [64, 48]);
}

const WIDE: &str = "[lens]\nfocal_length_mm = 8\nf_number = 8\nfocus_distance_m = 'infinity'\n[sensor]\npreset = 'textbook-ccd'\n\
                    resolution_px = [64, 48]\npixel_pitch_um = [150, 100]\n[exposure]\ntime_s = 0.01\n";

#[test]
fn the_grid_of_the_sensor_is_kept_where_it_is_asked_for_and_told_of() {
    let folder = lamp([0.2, 0.1], WIDE);
    folder.succeed("render capture.toml -o out --set develop.square_pixels=false");
    assert_eq!(image_size(&folder, "out/image.png"), [64, 48]);
    let png = |name: &str| {
        let file = std::io::BufReader::new(std::fs::File::open(folder.path(name)).expect("a file"));
        png::Decoder::new(file).read_info().expect("an image").info().pixel_dims
    };
    let told = png("out/image.png").expect("the shape of its pixels");
    // Width over height is the inverse of how many there are along equal lengths.
    assert!((f64::from(told.yppu) / f64::from(told.xppu) - 1.5).abs() < 1e-5, "{told:?}");
    assert_eq!(folder.report("out")["image"]["pixel_aspect"], 1.5);
    let keep = "--set develop.square_pixels=false";
    folder.succeed(&format!("develop out/raw.dng -o kept.exr {keep}"));
    let header = exr::meta::MetaData::read_from_file(folder.path("kept.exr"), false).expect("an EXR file");
    assert_eq!(header.headers[0].shared_attributes.pixel_aspect, 1.5);
    folder.succeed(&format!("develop out/raw.dng -o kept.tiff {keep} --set develop.bits=8"));
    let mut tiff = tiff::decoder::Decoder::new(std::fs::File::open(folder.path("kept.tiff")).expect("a file"))
        .expect("a TIFF file");
    let mut resolution = |tag| {
        let found = tiff.get_tag(tag).expect("a resolution");
        let tiff::decoder::ifd::Value::Rational(n, d) = found else { panic!("{found:?}") };
        f64::from(n) / f64::from(d)
    };
    let [x, y] = [tiff::tags::Tag::XResolution, tiff::tags::Tag::YResolution].map(&mut resolution);
    assert!((y / x - 1.5).abs() < 1e-5, "{x} {y}");
    folder.succeed("develop out/raw.dng -o square.png");
    assert_eq!((image_size(&folder, "square.png"), png("square.png").is_none()), ([96, 48], true));
}

#[rstest]
#[case::truth("--set output.truth=['depth']", &["brought to square pixels, and ground truth is in its pixels", "develop.square_pixels = false"])]
#[case::both(
    "--set output.truth=['depth'] --set lens.distortion={model='division',k=[-0.1]}",
    &["freed of the distortion of the lens and brought to square pixels", "develop.distortion = false and develop.square_pixels = false"]
)]
#[case::no_dng("--set output.raw=['tiff']", &["which photosite develop cannot do with these raw files"])]
#[case::fisheye(
    "--set lens.projection='fisheye' --set lens.focal_length_mm=2",
    &["image.png keeps the distortion of the kannala-brandt lens", "reaches 90°"]
)]
#[case::skew(
    "--set lens.intrinsics={fx=90,fy=135,cx=32,cy=24,skew=30} --set lens.distortion={model='brown-conrady',k=[-0.3]}",
    &["of the brown-conrady lens, raw.dng tells photosite alone"]
)]
fn what_is_not_as_expected_is_said_once(#[case] arguments: &str, #[case] wanted: &[&str]) {
    let folder = lamp([0.2, 0.1], &WIDE.replace("[sensor]", "max_angle_deg = 100\n[sensor]"));
    let folder_without = lamp([0.2, 0.1], WIDE);
    let folder = if arguments.contains("fisheye") { folder } else { folder_without };
    let outcome = folder.succeed(&format!("render capture.toml -o out --set render.samples_per_pixel=1 {arguments}"));
    let text = outcome.text();
    for words in wanted {
        assert_eq!(text.matches(words).count(), 1, "{words:?} in: {}", outcome.stderr);
    }
    let report = folder.report("out");
    let warnings: Vec<&str> = report["warnings"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert!(warnings.iter().any(|warning| warning.contains(wanted[0])), "{warnings:?}");
}

#[test]
fn cameras_of_the_raw_image_are_told_from_those_of_the_developed_one() {
    let folder = lamp([0.2, 0.1], WIDE);
    let barrel = "--set lens.distortion={model='brown-conrady',k=[-0.3]}";
    let outcome = folder.succeed(&format!("camera capture.toml --format colmap {barrel}"));
    assert!(outcome.text().contains("image.png is freed of the distortion"), "{}", outcome.stderr);
    for keeps in ["--set develop.distortion=false", "--set output.image=false"] {
        let outcome = folder.succeed(&format!("camera capture.toml --format colmap {barrel} {keeps}"));
        assert_eq!(outcome.stderr, "");
    }
}

/// The image of a lamp is the second route: `project`, the camera file, ground truth and the report lead to where image.png
/// shows it, whatever changes its pixels.
#[rstest]
#[case::whole("", [64, 48])]
#[case::region("--set exposure.region_px=[20,4,40,32]", [40, 32])]
#[case::binning("--set exposure.binning=[2,2]", [32, 24])]
#[case::binned_region("--set exposure.region_px=[20,4,40,32] --set exposure.binning=[2,1]", [40, 32])]
#[case::frame_grabber("--set sensor.frame_grabber={size_px=[90,40]}", [90, 67])]
#[case::resized("--set develop.resize_px=[96,96]", [96, 96])]
#[case::zoomed("--set develop.digital_zoom=1.5", [64, 48])]
#[case::zoomed_region("--set exposure.region_px=[20,4,40,32] --set develop.digital_zoom=1.25 --set develop.resize_px=[50,50]", [50, 50])]
#[case::wide_pixels("--set sensor.pixel_pitch_um=[150,100]", [96, 48])]
#[case::masked_pixels("--set sensor.masked_columns=[8,4] --set sensor.masked_rows=[2,6]", [64, 48])]
#[case::video_line("--set sensor.video={bandwidth_mhz=8,pixel_clock_mhz=40}", [64, 48])]
fn truth_has_the_pixels_of_the_image(#[case] options: &str, #[case] size: [u32; 2]) {
    let capture = "[lens]\ntype = 'pinhole'\nfocal_length_mm = 8\nf_number = 8\nfocus_distance_m = 'infinity'\n[sensor]\n\
                   preset = 'sony-imx249-mono'\nresolution_px = [64, 48]\npixel_pitch_um = [100, 100]\n[exposure]\n\
                   time_s = 0.003\n";
    let place = [0.3, 0.2];
    let folder = lamp(place, capture);
    folder.add("point.csv", format!("{},{},0\n", place[0], place[1]));
    let truth = "--set output.truth=['depth'] --set output.objects=true";
    folder.succeed(&format!("render capture.toml -o out {truth} {options}"));
    let [width, height] = size;
    assert_eq!(image_size(&folder, "out/image.png"), size);
    let seen = centroid(&folder, "out/image.png");
    let is_near = |what: &str, at: [f64; 2]| {
        let off = (at[0] - seen[0]).abs().max((at[1] - seen[1]).abs());
        // Noise of some 2 % of the lamp's signal in some 8 × 8 pixels about it moves its centroid by less than 0.1 px; a
        // sharp edge moves the mean of pixel centres by less than 0.2.
        assert!(off < 0.3, "{what} at {at:?}, image.png at {seen:?}");
    };
    let projected = folder.succeed(&format!("project capture.toml --points point.csv {options}")).stdout;
    let numbers: Vec<f64> = projected.trim().split(',').map(|n| n.parse().expect("a number")).collect();
    is_near("project", [numbers[0], numbers[1]]);
    let file = folder.succeed(&format!("camera capture.toml --format colmap {options}")).stdout;
    let line = file.lines().find(|line| line.contains("PINHOLE")).expect("a camera");
    let words: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [_, columns, rows, fx, fy, cx, cy] = words[..] else { panic!("{line}") };
    assert_eq!([columns, rows], size.map(f64::from));
    // COLMAP counts from the corner. The camera stands 3 m away and looks along −z.
    is_near("camera", [fx * place[0] / 3.0 + cx - 0.5, cy - 0.5 - fy * place[1] / 3.0]);
    let bytes = folder.bytes("out/truth.exr");
    let planes = photosite::io::exr::read_exr(std::io::Cursor::new(bytes)).expect("EXR").planes;
    assert_eq!([planes.width(), planes.height()], size.map(|n| n as usize));
    let depth = planes.plane("depth").expect("a layer");
    let on_it: Vec<usize> = (0..depth.len()).filter(|&i| depth[i].is_finite() && depth[i] > 0.0).collect();
    let mean = |of: &dyn Fn(usize) -> usize| on_it.iter().map(|&i| of(i) as f64).sum::<f64>() / on_it.len() as f64;
    let (columns, rows) = (width as usize, height);
    // Half the pitch of the coarser grid is as far as the mean of few pixels may lie beside.
    let at = [mean(&|i| i % columns), mean(&|i| i / columns)];
    assert!((at[0] - seen[0]).abs() < 0.6 && (at[1] - seen[1]).abs() < 0.6, "depth at {at:?}, image.png at {seen:?}");
    let objects = folder.json("out/objects.json");
    assert_eq!(objects["resolution_px"], serde_json::json!([width, rows]));
    let corners = objects["objects"][0]["box_corners_px"].as_array().expect("eight corners").clone();
    is_near("box", [0, 1].map(|axis| corners.iter().map(|c| c[axis].as_f64().expect("seen")).sum::<f64>() / 8.0));
}
