//! `photosite compare --noise-profile`: whether noise explains how two photographs differ.

use rstest::rstest;

use crate::folder::Folder;

const CHART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/colour-checker/capture-d50.toml");
/// Response that differs by 5 % from pixel to pixel.
const UNEVEN: &str = "--set sensor.noise.prnu_percent=5";

/// A folder with photographs of the wall beside a chart, each with its options, by a sensor without fixed pattern.
fn photographs(options: [&str; 2]) -> Folder {
    let folder = Folder::new([]);
    let sensor = "--set sensor.noise.prnu_percent=0 --set sensor.noise.dsnu_e=0 --spp 64 \
                  --set sensor.resolution_px=[120,90] --set lens.focal_length_mm=1.8 \
                  --set camera.position_m=[0.8,0,0.92] --set camera.look_at_m=[0.8,0,0]";
    for (name, options) in ["a", "b"].into_iter().zip(options) {
        folder.succeed(&format!("render {CHART} {sensor} {options} -q -o {name}"));
    }
    folder
}

/// Cases: images of one camera differ by noise; another amount of light or pattern is no noise, unless the pattern is
/// stated. Of 10,800 pixels, z-scores spread as N(0, 1) within 4/√(2n) = 2.7 % and the light's own noise, which is below a
/// percent of the sensor's.
#[rstest]
#[case::seeds(["--set render.seed=1", "--set render.seed=2"], "", true)]
#[case::light(["--set render.seed=1", "--set render.seed=2 --set exposure.time_s=0.0202"], "", false)]
#[case::pattern([UNEVEN, "--set sensor.noise.prnu_percent=5 --set sensor.serial=2 --set render.seed=2"], "", false)]
#[case::pattern_that_is_stated([UNEVEN, "--set sensor.noise.prnu_percent=5 --set sensor.serial=2 --set render.seed=2"], " --prnu 5", true)]
fn noise_of_the_profile_explains_noise_alone(
    #[case] options: [&str; 2],
    #[case] pattern: &str,
    #[case] is_noise: bool,
) {
    let folder = photographs(options);
    let command = format!("compare a/raw.dng b/raw.dng --noise-profile{pattern} --json");
    let outcome = folder.run(&command);
    assert_eq!(outcome.status, Some(i32::from(!is_noise)), "{}", outcome.stdout);
    let report = outcome.json();
    if is_noise {
        let spread = report["channels"][0]["z_scores"]["spread"].as_f64().expect("a spread");
        assert!((spread - 1.0).abs() < 0.035, "{spread}");
    }
}

#[test]
fn files_without_a_profile_are_named() {
    let folder = Folder::new([]);
    folder.add("a.pgm", "P2 1 1 255 7");
    folder.fail("compare a.pgm a.pgm --noise-profile", 2, &["a.pgm", "states no noise profile", "another way"]);
    folder.fail("compare a.pgm a.pgm --prnu 1", 2, &["--noise-profile"]);
    let stated = "--noise-profile --variance-a 1 --variance-b 1";
    folder.fail(&format!("compare a.pgm a.pgm {stated}"), 2, &["no effect", "leave out one"]);
}
