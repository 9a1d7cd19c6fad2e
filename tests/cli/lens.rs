//! Lenses on the command line: `photosite project`, what `info` says of them, and what is refused.

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
#[case::fold("distortion = { model = 'brown-conrady', k = [-0.6] }", &["folds back over its own picture", "max_angle_deg"])]
#[case::model("distortion = { model = 'kannala-brandt', k = [1, 2, 3, 4, 5] }", &["lens.distortion.k", "4 of these"])]
#[case::prism("distortion = { model = 'division', k = [0.1], s = [1] }", &["lens.distortion.s", "no such coefficients"])]
#[case::misfit("projection = 'fisheye'\ndistortion = { model = 'brown-conrady', k = [0.1] }", &["kannala-brandt"])]
#[case::xi("xi = 1\nprojection = 'fisheye'", &["lens.xi", "omnidirectional"])]
#[case::no_xi("projection = 'omnidirectional'", &["the key `xi` is missing"])]
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

#[test]
fn info_says_how_far_the_lens_reaches() {
    let folder = capture(&format!("{K}\nprojection = 'fisheye'\nmax_angle_deg = 30"));
    let facts: Value = serde_json::from_str(&folder.succeed("info capture.toml --json").stdout).expect("JSON");
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
        let facts: Value =
            serde_json::from_str(&folder.succeed(&format!("info capture.toml --json{options}")).stdout).expect("JSON");
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
