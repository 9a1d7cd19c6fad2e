//! `scene.ground` and `scene.backdrop`: where they are, what they reflect, and what is said of wrong keys.

use photosite::image::Planes;
use rstest::rstest;
use serde_json::json;

use crate::folder::Folder;

/// A small sail far behind a camera that looks at the horizon, 1 m above the ground, under an even sky.
const CAPTURE: &str = "\
[scene]
geometry = ['sail.obj']
environment = 'even'
ground = { height_m = 0.0, reflectance = 0.4 }
[camera]
position_m = [0, 1, 100]
look_at_m = [0, 1, 200]
[lens]
type = 'pinhole'
focal_length_mm = 8
falloff = 'none'
[sensor]
preset = 'sony-imx249-mono'
resolution_px = [32, 24]
pixel_pitch_um = [200, 200]
[exposure]
time_s = 0.001
[render]
samples_per_pixel = 16
max_depth = 3
[output]
truth = ['depth', 'instance', 'normal']
";

fn folder(capture: &str) -> Folder {
    Folder::new([("sail.obj", b"v -1 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n".to_vec()), ("capture.toml", capture.into())])
}

fn truth(folder: &Folder, image: &str) -> Planes {
    let bytes = std::fs::read(folder.path(image).join("truth.exr")).expect("truth.exr");
    photosite::io::exr::read_exr(std::io::Cursor::new(bytes)).expect("EXR").planes
}

/// Under a sky of the radiance L, a plane of reflectance ρ has the radiance ρ·L everywhere, from the foot of the camera to
/// the horizon.
#[test]
fn the_ground_has_the_radiance_of_its_reflectance_up_to_the_horizon() {
    let folder = folder(CAPTURE);
    folder.succeed("render capture.toml -o out");
    let electrons = folder.electrons("out");
    let [mean, variance] = [&electrons.mean, &electrons.variance].map(|planes| planes.plane("Y").expect("one channel"));
    let sum = |plane: &[f32]| plane.iter().map(|&v| f64::from(v)).sum::<f64>();
    let part = |range: std::ops::Range<usize>| {
        let pixels = range.len() as f64;
        (sum(&mean[range.clone()]) / pixels, sum(&variance[range]).sqrt() / pixels)
    };
    let (sky, error) = part(0..mean.len() / 2);
    for row in 12..24 {
        let (ground, of_ground) = part(32 * row..32 * (row + 1));
        // Five deviations. The sail, 1.5 m² 100 m off, hides less than 1e-4 of the sky.
        let tolerance = 5.0 * (of_ground / ground).hypot(error / sky) + 1e-4;
        let ratio = ground / sky / 0.4;
        assert!(tolerance < 0.05 && (ratio - 1.0).abs() < tolerance, "{row}: {ratio} ± {tolerance}");
    }
    let planes = truth(&folder, "out");
    let (depth, up) = (planes.plane("depth").expect("depth"), planes.plane("normal.Y").expect("a normal"));
    for (row, z) in (0..24).map(|row| (row, f64::from(depth[row * 32 + 16]))) {
        // A pinhole of 8 mm and rows of 0.2 mm: the ground 1 m below is seen at 8/(0.2·(row − 11.5)) m.
        if row < 12 {
            assert!(!z.is_finite(), "{row}: the sky, not {z} m");
        } else {
            let expected = 40.0 / (row as f64 - 11.5);
            assert!((z / expected - 1.0).abs() < 1e-5 && up[row * 32 + 16] == 1.0, "{row}: {z} m, not {expected} m");
        }
    }
}

/// The size of a scene is that without its ground: so is where its camera stands, and what its light looks like.
#[test]
fn the_ground_changes_neither_camera_nor_white() {
    let lamp = "[[lights]]\ntype = 'point'\nposition_m = [1, 2, 3]\nilluminant = 'A'\nintensity_cd = 100\n";
    let capture = format!("[scene]\ngeometry = ['sail.obj']\nenvironment = 'even'\n{lamp}");
    let folder = folder(&capture);
    let small = "--size 24x18 --spp 1 --force";
    folder.succeed(&format!("render capture.toml -o without {small}"));
    for more in ["scene.ground=true", "scene.ground.height_m=-1", "scene.backdrop={}"] {
        folder.succeed(&format!("render capture.toml -o with {small} --set {more}"));
        let [with, without] = ["with", "without"].map(|name| folder.report(name));
        assert_eq!(with["camera"], without["camera"], "{more}");
        for channel in 0..3 {
            let neutral =
                |report: &serde_json::Value| report["sensor"]["as_shot_neutral"][channel].as_f64().expect("one");
            // Corners are rounded to single precision before or after they are placed.
            assert!((neutral(&with) / neutral(&without) - 1.0).abs() < 1e-5, "{more}");
        }
    }
}

/// A camera that looks at the wall sees it at its distance; where it looks at the curve, the normal leans as the quarter
/// of a circle has it.
#[test]
fn the_backdrop_is_where_its_keys_put_it() {
    let backdrop =
        "backdrop = { height_m = 0.0, distance_m = 6.0, curve_radius_m = 2.0, wall_height_m = 9.0, rotation_deg = 90 }";
    let capture = CAPTURE
        .replace("ground = { height_m = 0.0, reflectance = 0.4 }", backdrop)
        // The wall lies towards −X; the middle of the sail is the origin.
        .replace("position_m = [0, 1, 100]", "position_m = [4, 2.5, 0]")
        .replace("look_at_m = [0, 1, 200]", "look_at_m = [-6, 2.5, 0]");
    let folder = folder(&capture);
    folder.succeed("render capture.toml -o out");
    let (planes, report) = (truth(&folder, "out"), folder.report("out"));
    assert_eq!(report["truth"]["instances"].as_array().and_then(|all| all.last()), Some(&json!("backdrop")));
    let at = |name: &str, row: usize| f64::from(planes.plane(name).expect(name)[row * 32 + 4]);
    for row in 0..24 {
        let slope = (row as f64 - 11.5) / 40.0;
        // The wall at the depth of 10 m; the curve about (−4, 2); the floor 2.5 m below.
        let wall = 2.5 - 10.0 * slope;
        let [z, x_normal, y_normal] = [at("depth", row), at("normal.X", row), at("normal.Y", row)];
        let (height, x) = (2.5 - z * slope, 4.0 - z);
        if wall > 2.0 {
            assert!((z - 10.0).abs() < 1e-5 && x_normal > 0.999_999, "{row}: {z} m, {x_normal}");
        } else if height > 0.01 {
            // Within the 1/13 000 of the radius by which a chord lies inside.
            let to_axis = (x + 4.0).hypot(height - 2.0);
            assert!((to_axis - 2.0).abs() < 2.0 / 12_000.0, "{row}: {to_axis} m from the axis");
            // The normal of the truth is that of the chord: within half of its 90°/64.
            let lean = (y_normal.atan2(x_normal) - (2.0 - height).atan2(-4.0 - x)).abs();
            assert!(lean < std::f64::consts::FRAC_PI_2 / 128.0 + 1e-4, "{row}: {lean} rad");
        } else {
            assert!((z * slope - 2.5).abs() < 1e-4 && y_normal > 0.999, "{row}: {z} m");
        }
    }
}

#[test]
fn they_take_materials_by_name_and_the_reflectance_of_the_sky() {
    let folder = folder(
        &CAPTURE
            .replace("environment = 'even'", "environment = { sky = { sun_elevation_deg = 90, ground_albedo = 0.6 } }"),
    );
    // The image of the ground alone: the sun overhead, so that radiance is in proportion to reflectance.
    let ground = |more: &str| {
        folder.succeed(&format!("render capture.toml -o out --force --seed 1 {more}"));
        let electrons = folder.electrons("out");
        let plane = electrons.mean.plane("Y").expect("one channel");
        plane[plane.len() / 2..].iter().map(|&e| f64::from(e)).sum::<f64>()
    };
    let stated = ground("");
    folder.add(
        "capture.toml",
        CAPTURE
            .replace("environment = 'even'", "environment = { sky = { sun_elevation_deg = 90, ground_albedo = 0.6 } }")
            .replace(", reflectance = 0.4", ""),
    );
    // The same paths, scaled.
    assert!((ground("") / stated / 1.5 - 1.0).abs() < 1e-5);
    let dark = folder.text("capture.toml") + "[materials.dark]\ntype = 'diffuse'\nreflectance = 0.1\n";
    folder.add("capture.toml", dark);
    assert!((ground("--set scene.ground.material=dark") / stated / 0.25 - 1.0).abs() < 1e-5);
}

#[rstest]
#[case::both("scene.backdrop={}", "scene.backdrop: cannot be combined with a ground", "remove one of them")]
#[case::size("scene.ground.size_m=-1", "scene.ground.size_m: must lie between", "size_m = 10")]
#[case::height("scene.ground.height_m=nan", "scene.ground.height_m: must be finite, got NaN", "")]
#[case::material("scene.ground={material='grass'}", "scene.ground.material: there is no material", "[materials.grass]")]
#[case::two("scene.ground.material=x", "scene.ground.reflectance: cannot be combined with material", "keep one")]
#[case::bright("scene.ground.reflectance=1.5", "scene.ground.reflectance: must lie between 0 and 1", "fractions")]
#[case::key("scene.ground.hight_m=1", "unknown key `hight_m`", "did you mean `height_m`")]
#[case::kind("scene.ground=7", "scene.ground: ", "true, false or a table")]
fn wrong_keys_are_named(#[case] change: &str, #[case] message: &str, #[case] help: &str) {
    let capture = if change.contains("grass") { CAPTURE.replace("ground = {", "# {") } else { CAPTURE.to_owned() };
    folder(&capture).fail(&format!("render capture.toml -o out --set {change}"), 1, &[message, help]);
}

#[rstest]
#[case::curve(
    "distance_m = 1.0, curve_radius_m = 2.0",
    "backdrop.curve_radius_m: must be at most",
    "distance_m larger"
)]
#[case::wall("wall_height_m = 0.1, curve_radius_m = 1.0", "backdrop.wall_height_m: must be at least", "curve_radius_m")]
#[case::turn("rotation_deg = inf", "backdrop.rotation_deg: must be finite", "")]
fn backdrops_that_cannot_be_are_named(#[case] keys: &str, #[case] message: &str, #[case] help: &str) {
    let capture =
        CAPTURE.replace("ground = { height_m = 0.0, reflectance = 0.4 }", &format!("backdrop = {{ {keys} }}"));
    folder(&capture).fail("render capture.toml -o out", 1, &[message, help]);
}
