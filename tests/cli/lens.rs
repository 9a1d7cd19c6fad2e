//! Lenses on the command line: `photosite project`, what `info` says of them, and what is refused.

use photosite::image::Planes;
use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;

/// A capture with nothing but a lens, seen by 640 × 480 pixels of 4 µm.
pub(crate) fn capture(lens: &str) -> Folder {
    Folder::new([(
        "capture.toml",
        format!(
            "[camera]\nposition_m = [0, 0, 2]\nlook_at_m = [0, 0, 0]\n[lens]\nfocus_distance_m = 2\n{lens}\n\
             [sensor]\nresolution_px = [640, 480]\npixel_pitch_um = [4, 4]\n"
        )
        .into(),
    )])
}

const K: &str = "intrinsics = { fx = 400, fy = 400, cx = 319.5, cy = 239.5 }";

#[rstest]
// The world's x is the camera's; 1 m to the right and 2 m away. tan θ = 0.5.
#[case::perspective("", 319.5 + 400.0 * 0.5)]
#[case::rational(
    "distortion = { model = 'brown-conrady', k = [0.1, 0, 0, 0.2], s = [0.01] }",
    319.5 + 400.0 * (0.5 * 1.025 / 1.05 + 0.0025)
)]
#[case::polynomial("distortion = { model = 'polynomial', k = [1] }", 319.5 + 400.0 * 0.423_853_799_069_783_2)]
#[case::division("distortion = { model = 'division', k = [-0.5] }", 319.5 + 400.0 * (1.5_f64.sqrt() - 1.0) / 0.5)]
#[case::fisheye("projection = 'fisheye'", 319.5 + 400.0 * 0.463_647_609_000_806_1)]
#[case::equisolid("projection = 'equisolid'", 319.5 + 400.0 * (2.0 - 4.0 / 5.0_f64.sqrt()).sqrt())]
#[case::stereographic("projection = 'stereographic'", 319.5 + 800.0 * (5.0_f64.sqrt() - 2.0))]
#[case::orthographic("projection = 'orthographic'", 319.5 + 400.0 / 5.0_f64.sqrt())]
#[case::panorama("projection = 'equirectangular'", 319.5 + 400.0 * 0.463_647_609_000_806_1)]
#[case::mirror("projection = 'omnidirectional'\nxi = 1", 319.5 + 400.0 / (2.0 + 5.0_f64.sqrt()))]
fn points_appear_where_the_model_puts_them(#[case] lens: &str, #[case] column: f64) {
    let folder = capture(&format!("{K}\n{lens}"));
    folder.add("points.csv", "# x, y, z\n1, 0, 0\n");
    let answer = folder.succeed("project capture.toml --points points.csv").stdout;
    let found: Vec<f64> = answer.trim().split(',').map(|x| x.parse().expect("a number")).collect();
    assert!((found[0] - column).abs() < 1e-9 && (found[1] - 239.5).abs() < 1e-9, "{answer} {column}");
    folder.add("points.csv", &answer);
    let direction = folder.succeed("project capture.toml --points points.csv --inverse").stdout;
    let found: Vec<f64> = direction.trim().split(',').map(|x| x.parse().expect("a number")).collect();
    assert!((found[0] / -found[2] - 0.5).abs() < 1e-12, "{direction}");
}

#[rstest]
#[case::fold("distortion = { model = 'brown-conrady', k = [-0.6] }", &["folds back over its own image", "max_angle_deg"])]
#[case::model("distortion = { model = 'kannala-brandt', k = [1, 2, 3, 4, 5] }", &["lens.distortion.k", "4 of these"])]
#[case::prism("distortion = { model = 'division', k = [0.1], s = [1] }", &["lens.distortion.s", "no such coefficients"])]
#[case::misfit("projection = 'fisheye'\ndistortion = { model = 'brown-conrady', k = [0.1] }", &["kannala-brandt"])]
#[case::law("projection = 'equisolid'\ndistortion = { model = 'kannala-brandt', k = [0.1] }", &["equisolid", "\"fisheye\""])]
#[case::xi("xi = 1\nprojection = 'fisheye'", &["lens.xi", "omnidirectional"])]
#[case::no_xi("projection = 'omnidirectional'", &["lens.xi: is missing", "projection"])]
#[case::angle("max_angle_deg = -3", &["lens.max_angle_deg"])]
#[case::sigma("psf = { kind = 'gaussian', sigma_um = -1 }", &["lens.psf.sigma_um", "above 0"])]
#[case::psf("psf = { kind = 'gauss' }", &["lens.psf", "gaussian"])]
#[case::kernel("psf = { kind = 'kernel', pitch_um = 1, kernels = [{ file = 'none.csv' }] }", &["none.csv", "cannot be read"])]
#[case::no_kernel("psf = { kind = 'kernel', pitch_um = 1, kernels = [] }", &["lens.psf.kernels", "there is none"])]
#[case::lateral("lateral_colour = { wavelength_nm = [450, 650], magnification = [1] }", &["2 wavelengths have 1"])]
#[case::stop("stops = [{ distance_mm = 3, radius_mm = 0 }]", &["radius_mm", "above 0"])]
#[case::no_axis("projection = 'fisheye'\nstops = [{ distance_mm = 3, radius_mm = 2 }]", &["lens.stops", "perspective"])]
fn what_no_lens_can_be_is_refused(#[case] lens: &str, #[case] words: &[&str]) {
    let folder = capture(&format!("{K}\n{lens}"));
    folder.add("points.csv", "");
    folder.fail("project capture.toml --points points.csv", 1, words);
}

/// Column of the middle of the light of a lamp of 0.04 m that stands 70° off the axis, 1 m away, facing the camera.
#[rstest]
#[case::equisolid("equisolid", |theta: f64| 2.0 * (theta / 2.0).sin())]
#[case::stereographic("stereographic", |theta: f64| 2.0 * (theta / 2.0).tan())]
#[case::orthographic("orthographic", f64::sin)]
#[case::equidistant("fisheye", |theta: f64| theta)]
fn light_lands_where_the_law_of_a_fisheye_says(#[case] projection: &str, #[case] radius: fn(f64) -> f64) {
    const FX: f64 = 100.0;
    let (sin, cos) = 70.0_f64.to_radians().sin_cos();
    // A square about (sin 70°, 0, −cos 70°), across the way there: along (cos 70°, 0, sin 70°) and along y.
    let corner = |a: f64, b: f64| format!("v {} {} {}\n", sin + a * cos, b, -cos + a * sin);
    let h = 0.02;
    let lamp: String = [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(a, b)| corner(a, b)).concat();
    let capture = format!(
        "[scene]\ngeometry = ['lamp.obj']\n[materials.lamp]\ntype = 'diffuse'\nreflectance = 0.0\ndouble_sided = true\n\
         emission = {{ illuminant = 'D65', luminance_nit = 1000 }}\n[camera]\nposition_m = [0, 0, 0]\n\
         look_at_m = [0, 0, -1]\n[lens]\ntype = 'pinhole'\nprojection = '{projection}'\n\
         intrinsics = {{ fx = {FX}, fy = {FX}, cx = 15.5, cy = 7.5 }}\n[sensor]\npreset = 'sony-imx249-mono'\n\
         resolution_px = [192, 16]\n[exposure]\ntime_s = 0.01\n[render]\nsamples_per_pixel = 256\nmax_depth = 1\n"
    );
    let lamp = format!("{lamp}usemtl lamp\nf 1 2 3 4\n");
    let folder = Folder::new([("lamp.obj", lamp.into()), ("capture.toml", capture.into())]);
    folder.succeed("render capture.toml -o out --quiet");
    let mean = folder.electrons("out").mean;
    let electrons = &mean.channels()[0].data;
    let moment = |of: &dyn Fn(usize) -> f64| -> f64 {
        electrons.iter().enumerate().map(|(i, &e)| f64::from(e) * of(i)).sum::<f64>()
    };
    let total = moment(&|_| 1.0);
    let found = [moment(&|i| (i % 192) as f64) / total, moment(&|i| (i / 192) as f64) / total];
    // Electrons are L·dΩ of each piece of the square: its area over distance³, as it faces the camera at 1 m.
    let (mut column, mut weight) = (0.0, 0.0);
    for i in 0..100 * 100 {
        let [a, b] = [i % 100, i / 100].map(|n| h * ((f64::from(n) + 0.5) / 50.0 - 1.0));
        let (x, y, z) = (sin + a * cos, b, cos - a * sin);
        let across = x.hypot(y);
        let part = (1.0 + a * a + b * b).powf(-1.5);
        column += part * (15.5 + FX * radius(across.atan2(z)) * x / across);
        weight += part;
    }
    // 4 columns and rows of light with 256 stratified samples each. Only pixels on the edges are uncertain, each to
    // 1/√256 at worst, which are 16 of some 16 at an arm of 2 px: 2·√16/16/16 = 0.03; stratified points do far better.
    assert!((found[0] - column / weight).abs() < 0.03, "{found:?} {}", column / weight);
    assert!((found[1] - 7.5).abs() < 0.03, "{found:?}");
}

#[test]
fn info_says_how_far_the_lens_reaches() {
    let folder = capture(&format!("{K}\nprojection = 'fisheye'\nmax_angle_deg = 30"));
    let facts = folder.succeed("info capture.toml --json").json();
    assert_eq!(facts["projection"], "kannala-brandt");
    assert_eq!(facts["covers_sensor"], false);
    assert_eq!(facts["lens_reach_deg"], 30.0);
    // 400 px a radian.
    let reach = facts["lens_reach_px"][0].as_f64().expect("a number");
    assert!((reach - 400.0 * 30.0_f64.to_radians()).abs() < 1e-2, "{reach}");
}

#[test]
fn sweeps_change_focus_and_focal_length_on_the_command_line() {
    let folder = capture("focal_length_mm = 4");
    let focus = |options: &str| {
        let facts = folder.succeed(&format!("info capture.toml --json{options}")).json();
        facts["focus"].as_str().expect("text").to_owned()
    };
    assert_eq!(focus(""), "2 m");
    folder.add("points.csv", "1, 0, 0\n");
    let column = |options: &str| -> f64 {
        let answer = folder.succeed(&format!("project capture.toml --points points.csv {options}")).stdout;
        answer.split(',').next().expect("a column").parse().expect("a number")
    };
    // f/(1 − f/u) over the pixel pitch, times 1/2 of the distance.
    for (f, u) in [(4.0, 2.0), (4.0, 0.5), (8.0, 2.0)] {
        let found = column(&format!("--set lens.focal_length_mm={f} --set lens.focus_distance_m={u}"));
        let expected = 319.5 + 0.5 * f / (1.0 - f * 1e-3 / u) / 4e-3;
        assert!((found - expected).abs() < 1e-9, "{f} {u}: {found} {expected}");
    }
    // What the file says of focus gives way.
    column("--set lens.autofocus_px=centre");
}

/// Mean electrons of all pixels under an even sky.
fn under_even_sky(lens: &str) -> f64 {
    let folder = Folder::new([
        ("away.obj", b"v 0 0 9\nv 1 0 9\nv 0 1 9\nusemtl black\nf 1 2 3\n".to_vec()),
        (
            "capture.toml",
            format!(
                "[scene]\ngeometry = ['away.obj']\nenvironment = {{ illuminant = 'D65', illuminance_lux = 500 }}\n\
                 [camera]\nposition_m = [0, 0, 0]\nlook_at_m = [0, 0, -1]\n[lens]\nfocal_length_mm = 50\n\
                 focus_distance_m = 'infinity'\n{lens}\n[sensor]\npreset = 'sony-imx249-mono'\nresolution_px = [8, 8]\n\
                 [exposure]\ntime_s = 1e-5\n[render]\nsamples_per_pixel = 1024\n"
            )
            .into(),
        ),
    ]);
    folder.succeed("render capture.toml -o out --quiet");
    let electrons = folder.electrons("out").mean;
    electrons.channels()[0].data.iter().map(|&e| f64::from(e)).sum::<f64>() / 64.0
}

#[test]
fn lens_pinhole_and_no_falloff_count_the_same_electrons() {
    let of = |f_number: f64| {
        ["", "falloff = 'none'", "type = 'pinhole'", "type = 'pinhole'\nfalloff = 'none'"]
            .map(|kind| under_even_sky(&format!("f_number = {f_number}\n{kind}")))
    };
    let [fast, slow] = [1.4, 8.0].map(of);
    // 65 536 samples, 262 144 wavelengths of a response that varies by its own size: 2e-3/√… with Sobol's points far
    // below 5e-4. The field of 8 pixels of 6 µm at 50 mm is too small for any falloff.
    for (found, first) in
        [(fast, fast[0]), (slow, slow[0])].into_iter().flat_map(|(all, first)| all.map(|e| (e, first)))
    {
        assert!((found / first - 1.0).abs() < 2e-3, "{found} {first}");
    }
    // sin²θ' with tan θ' = 1/2N.
    let share = |f_number: f64| (0.5 / f_number).atan().sin().powi(2);
    let (found, expected) = (fast[0] / slow[0], share(1.4) / share(8.0));
    assert!((found / expected - 1.0).abs() < 2e-3, "{found} {expected}");
}

#[rstest]
#[case::distance("focus_distance_m = 2", "lens.focus_distance_m has no effect: a pinhole has no focus")]
#[case::autofocus("autofocus_px = 'centre'", "lens.autofocus_px has no effect: a pinhole has no focus")]
#[case::infinity("focus_distance_m = 'infinity'", "")]
#[case::nothing("", "")]
fn a_pinhole_has_no_focus(#[case] focus: &str, #[case] warning: &str) {
    let folder = Folder::new([
        ("wall.obj", b"v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nusemtl wall\nf 1 2 3 4\n".to_vec()),
        (
            "capture.toml",
            format!(
                "[scene]\ngeometry = ['wall.obj']\nenvironment = {{ illuminant = 'D65', illuminance_lux = 500 }}\n\
                 [materials.wall]\ntype = 'diffuse'\nreflectance = 0.5\n[camera]\nposition_m = [0, 0, 0.2]\n\
                 look_at_m = [0, 0, 0]\n[lens]\ntype = 'pinhole'\nfocal_length_mm = 16\n{focus}\n\
                 [sensor]\nresolution_px = [16, 12]\npixel_pitch_um = [4, 5]\n[exposure]\ntime_s = 0.01\n\
                 [render]\nsamples_per_pixel = 1\n"
            )
            .into(),
        ),
    ]);
    let outcome = folder.succeed("render capture.toml -o out");
    let report = folder.report("out");
    let warnings = report["warnings"].as_array().expect("a list");
    if warning.is_empty() {
        assert!(warnings.is_empty(), "{warnings:?}");
    } else {
        assert!(outcome.text().contains(warning) && warnings.len() == 1, "{}", outcome.stderr);
    }
    // f over the pixel's sides.
    let matrix = &report["camera"]["camera_matrix"];
    let [fx, fy] = [0, 1].map(|i| matrix[i][i].as_f64().expect("a number"));
    assert!((fx - 16e-3 / 4e-6).abs() < 1e-9 && (fy - 16e-3 / 5e-6).abs() < 1e-9, "{matrix}");
    assert_eq!(report["lens"]["image_distance_mm"], 16.0);
}

/// Where the light of an image is in the mean, px.
fn centroid(planes: &Planes) -> [f64; 2] {
    let (data, width) = (&planes.channels()[0].data, planes.width());
    let sum: f64 = data.iter().map(|&e| f64::from(e)).sum();
    let moment = |at: &dyn Fn(usize) -> usize| {
        data.iter().enumerate().map(|(i, &e)| f64::from(e) * at(i) as f64).sum::<f64>() / sum
    };
    [moment(&|i| i % width), moment(&|i| i / width)]
}

#[rstest]
// Cells of 4 µm on pixels of 4 µm, and where their light is from the middle: to the right and down.
#[case::odd("0, 0, 0, 0, 1\n0, 0, 1, 0, 0\n0, 0, 0, 0, 0\n", [1.0, -0.5])]
#[case::even("1, 3\n", [0.25, 0.0])]
#[case::symmetric("1, 2, 1\n2, 4, 2\n1, 2, 1\n", [0.0, 0.0])]
fn a_kernel_shifts_a_point_of_light_as_it_stands_in_its_file(#[case] kernel: &str, #[case] shift: [f64; 2]) {
    // A lamp of some 4 × 4 pixels, which Sobol's points hit in 4096 · 16 samples.
    let lamp = "v -0.002 -0.0021 0\nv 0.0021 -0.0021 0\nv 0.0021 0.002 0\nv -0.002 0.002 0\nusemtl lamp\nf 1 2 3 4\n";
    let capture = "[scene]\ngeometry = ['lamp.obj']\n[materials.lamp]\ntype = 'diffuse'\nreflectance = 0.0\n\
        emission = { illuminant = 'D65', luminance_nit = 1000 }\n[camera]\nposition_m = [0, 0, 1]\nlook_at_m = [0, 0, 0]\n\
        [lens]\ntype = 'pinhole'\nfocal_length_mm = 4\n[sensor]\npreset = 'sony-imx249-mono'\n\
        resolution_px = [16, 16]\npixel_pitch_um = [4, 4]\n[exposure]\ntime_s = 0.01\n\
        [render]\nsamples_per_pixel = 1024\nmax_depth = 1\n";
    let folder = Folder::new([("lamp.obj", lamp.into()), ("capture.toml", capture.into()), ("psf.csv", kernel.into())]);
    let found = |out: &str, more: &str| {
        let outcome = folder.succeed(&format!("render capture.toml -o {out} {more}"));
        (centroid(&folder.electrons(out).mean), outcome)
    };
    let psf =
        |origin: &str| format!("--set lens.psf={{kind='kernel',pitch_um=4,kernels=[{{file='psf.csv'}}]{origin}}}");
    let (sharp, _) = found("sharp", "");
    let shifted = shift != [0.0, 0.0];
    for (out, origin, expected) in
        [("given", "", shift), ("centre", ",origin='centre'", shift), ("centroid", ",origin='centroid'", [0.0; 2])]
    {
        let (seen, outcome) = found(out, &psf(origin));
        for axis in 0..2 {
            // Each edge of the lamp, 5 px long with the kernel, is known to 1/√1024 of a pixel at each of its pixels at
            // worst: 0.03·√5 of 16 px of light at an arm of 3 px, 0.013 px; stratified points do better.
            let moved = seen[axis] - sharp[axis];
            assert!((moved - expected[axis]).abs() < 0.03, "{out}, axis {axis}: {moved}, not {}", expected[axis]);
        }
        let says = outcome.text().contains("lens.psf: the light of kernels[0] is") && outcome.text().contains("origin");
        assert_eq!(says, shifted && origin.is_empty(), "{out}: {}", outcome.stderr);
    }
}

/// A hole and a bare sensor: what is known of them, exposed again, and what needs a lens.
#[test]
fn a_bare_sensor_has_no_camera_and_a_hole_no_focus() {
    let folder = Folder::new([("capture.toml", lit("type = 'none'").into())]);
    folder.add("points.csv", "0, 0, 0\n");
    folder.add("set.toml", "capture = 'capture.toml'\nframes = 1\n");
    folder.succeed("render capture.toml -o bare");
    let report = folder.report("bare");
    assert_eq!((report["lens"]["kind"].as_str(), &report["lens"]["f_number"]), (Some("none"), &Value::Null));
    assert_eq!((&report["image"], &report["exposure"]["exposure_value"]), (&Value::Null, &Value::Null));
    folder.succeed("expose bare -o again --set exposure.gain_db=3");
    folder.succeed("info capture.toml");
    for command in ["camera capture.toml --format opencv", "project capture.toml --points points.csv"] {
        folder.fail(command, 1, &["lens.type", "each of its pixels sees everything"]);
    }
    folder.fail("export-mitsuba capture.toml -o mitsuba", 1, &["lens.type", "Mitsuba has no camera without a lens"]);
    folder.fail("dataset set.toml -o set", 1, &["lens.type", "a bare sensor has none"]);

    folder.add("capture.toml", lit("type = 'hole'\ndiameter_mm = 0.4\nimage_distance_mm = 20"));
    folder.succeed("render capture.toml -o hole");
    let report = folder.report("hole");
    assert_eq!((report["lens"]["kind"].as_str(), report["lens"]["f_number"].as_f64()), (Some("hole"), Some(50.0)));
    assert_eq!(report["lens"]["figures"]["depth_of_field_m"], Value::Null);
    folder.succeed("expose hole -o hole-again --set exposure.gain_db=3");
    folder.fail("export-mitsuba capture.toml -o mitsuba", 1, &["the hole of [lens]: it becomes a pinhole"]);
}

/// A lit scene of nothing, seen by a few pixels through a lens.
fn lit(lens: &str) -> String {
    format!(
        "[scene]\nenvironment = {{ illuminant = 'D65', illuminance_lux = 500 }}\n[camera]\nposition_m = [0, 0, 2]\n\
         look_at_m = [0, 0, 0]\n[lens]\n{lens}\n[sensor]\nresolution_px = [16, 12]\n[exposure]\ntime_s = 0.01\n\
         [render]\nsamples_per_pixel = 4\n"
    )
}

/// The share of black pixels that the warning states is that of the image, in even light from all sides.
#[rstest]
#[case::larger_than_the_image_circle(0.7, true)]
#[case::within_the_image_circle(0.3, false)]
fn an_image_beyond_the_image_circle_is_black_and_that_is_said(#[case] pitch_mm: f64, #[case] is_said: bool) {
    let pitch_um = 1e3 * pitch_mm;
    let folder = Folder::new([(
        "capture.toml",
        format!(
            "[scene]\nenvironment = {{ illuminant = 'D65', illuminance_lux = 500 }}\n[camera]\nposition_m = [0, 0, 2]\n\
             look_at_m = [0, 0, 0]\n[lens]\nprescription = 'phone-us7535658'\nfocus_distance_m = 2\n\
             [sensor]\nresolution_px = [16, 12]\npixel_pitch_um = [{pitch_um}, {pitch_um}]\n[exposure]\ntime_s = 1e-5\n\
             [render]\nsamples_per_pixel = 32\n"
        )
        .into(),
    )]);
    let outcome = folder.succeed("render capture.toml -o out");
    let report = folder.report("out");
    let said = report["warnings"].as_array().expect("a list").iter().filter_map(Value::as_str);
    let said: Vec<&str> = said.filter(|warning| warning.contains("image circle")).collect();
    let electrons = folder.electrons("out");
    let light = &electrons.mean.channels()[0].data;
    let dark = light.iter().filter(|light| **light == 0.0).count();
    if is_said {
        let [stated] = said[..] else { panic!("{said:?}") };
        let number_after = |words: &str| -> f64 {
            let rest = stated.split(words).nth(1).and_then(|rest| rest.split(' ').find(|word| !word.is_empty()));
            rest.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{words}: {stated}"))
        };
        let lit_mm = number_after("light comes as far as");
        let mut beyond = 0;
        for (i, light) in light.iter().enumerate() {
            let from_axis = |place: usize, pixels: f64| (place as f64 + 0.5 - pixels / 2.0).abs();
            let (x, y) = (from_axis(i % 16, 16.0), from_axis(i / 16, 12.0));
            let away_mm = |moved: f64| f64::hypot(x + moved, y + moved) * pitch_mm;
            beyond += u32::from(away_mm(0.0) > lit_mm);
            // Its nearest corner, and its farthest.
            assert!(if *light > 0.0 { away_mm(-0.5) < lit_mm } else { away_mm(0.5) > lit_mm }, "{i}: {light} {stated}");
        }
        let percent = 100.0 * f64::from(beyond) / 192.0;
        assert!((number_after("lens.prescription:") - percent).abs() <= 0.5, "{stated} {percent}");
        assert!(outcome.text().contains("from corner to corner, or another lens"), "{}", outcome.stderr);
    } else {
        assert!(said.is_empty() && dark == 0, "{said:?} {dark}");
    }
}
