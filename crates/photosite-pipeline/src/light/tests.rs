//! Tests of frames: one that is asked for alone is the frame of that number of a folder, whatever frames hand on to
//! each other.

use std::path::Path;

use photosite_core::Sandbox;
use rstest::rstest;

use super::Light;
use crate::write::file_names::named;
use crate::{FilmMemory, LightSource, Options, OutputFolder, Prepared, Rendered, Request, Silent, render_into};
use photosite_capture::Capture;
use photosite_capture::report::{Report, Timings};
use photosite_files::developable::{Developable, read_developable};

const CAPTURE: &str = "\
scene = { environment = { illuminant = 'D65', illuminance_lux = 500 } }
camera = { position_m = [0, 0, 1], look_at_m = [0, 0, 0] }
lens = { type = 'pinhole', focal_length_mm = 6 }
render = { samples_per_pixel = 2 }
sensor = { preset = 'sony-imx249-color', resolution_px = [8, 6] }
output = { image = false }
";

const LAG: &str = "sensor.charge.image_lag={ percent = 10, decay = 0.5 }";
const GAIN_CONTROL: &str = "exposure.gain_control={ target = 0.5 }";
const BRACKET: &str = "exposure.bracket_ev=[0, -2, 1]";
const MOTION: &str = "camera.motion.velocity_m_per_s=[0, 0, 0.001]";

/// Renders into a folder.
fn rendered(folder: &Path, keys: &[&str]) -> (Capture, Report) {
    let keys: Vec<String> = keys.iter().map(|&key| key.to_owned()).collect();
    let capture = Capture::parse(CAPTURE, folder, &keys).expect("a capture");
    let request = Request {
        input: Path::new("capture.toml"),
        named: "capture.toml".to_owned(),
        light: LightSource::Traced,
        film_memory: FilmMemory::default(),
        monitor: &Silent,
        is_timed: false,
    };
    let mut into = OutputFolder::own(folder);
    let rendered = render_into(capture.clone(), &request, &mut into, Timings::default()).expect("rendered");
    let Rendered::Image { report, .. } = rendered else { panic!("a part") };
    (capture, *report)
}

fn raw(folder: &Path, number: Option<u32>) -> Vec<u16> {
    let path = folder.join(named("raw", number, "dng"));
    let Developable::Raw(raw) = read_developable(&path).expect("a raw file") else { panic!("no raw file") };
    raw.data.clone()
}

/// Cases: the images of a bracket see the same light at the same gain, so that no other keys go with it.
#[rstest]
fn a_frame_alone_is_that_of_a_folder(
    #[values(&[], &[LAG])] lag: &[&str],
    #[values(&[], &[GAIN_CONTROL], &[MOTION], &[GAIN_CONTROL, MOTION], &[BRACKET])] chosen: &[&str],
) {
    let [has_bracket, moves] = [BRACKET, MOTION].map(|key| chosen.contains(&key));
    let series = if has_bracket { "exposure.frames=1" } else { "exposure.frames=3" };
    let keys = [&["exposure.time_s=0.0005", series], lag, chosen].concat();
    let folder = tempfile::tempdir().expect("a folder");
    let (capture, report) = rendered(folder.path(), &keys);
    let files = [0, 1, 2].map(|number| raw(folder.path(), Some(number)));
    assert!(files[0] != files[1] && files[1] != files[2], "{keys:?}");

    let traced = Prepared::new(capture).expect("ready").trace(Options::default()).expect("traced");
    let stored = Light::read(&Sandbox::default(), folder.path(), &[]).expect("light");
    for (light, what) in [(&traced, "traced"), (&stored, "stored")] {
        let of_first = what == "traced" && moves;
        for number in [2, 0, 1].into_iter().filter(|number| !of_first || *number == 0) {
            let shot = light.frame(number, &[]).expect("a frame");
            assert!(shot.raw.data == files[number as usize], "{what} frame {number} of {keys:?}");
            assert_eq!(shot.frame, number);
            if let Some(gains) = &report.exposure.frame_gains_db {
                assert_eq!(shot.exposure.gain.0, gains[number as usize], "{what} frame {number} of {keys:?}");
            }
            // Written alone, it stays what it is; of a bracket all times are written.
            let again = tempfile::tempdir().expect("a folder");
            light.write_shot_into(&shot, &mut OutputFolder::own(again.path()), &Silent).expect("written");
            let number = has_bracket.then_some(number);
            assert!(raw(again.path(), number) == shot.raw.data, "{what} frame {number:?} of {keys:?} is written");
        }
        if of_first {
            assert_eq!(light.only_frame(), Some(0));
            continue;
        }
        let shots = light.shots(&[]).take(files.len());
        let shots: Vec<_> = shots.map(|shot| shot.expect("a shot").raw.data).collect();
        assert!(shots == files, "{what}: {keys:?}");
        let fourth = light.frame(3, &[]);
        let is_there = !has_bracket && !moves;
        assert_eq!(fourth.is_ok(), is_there, "{what}: {keys:?}");
        if let Err(error) = fourth {
            assert!(error.to_string().contains("there is no frame 3"), "{error}");
        }
    }
}

/// Case: light of one frame alone leaves out what others hand on to it, and says so.
#[test]
fn what_is_left_out_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let keys = [LAG, MOTION, "exposure.frames=3", "exposure.time_s=0.0005"].map(str::to_owned);
    let capture = Capture::parse(CAPTURE, folder.path(), &keys).expect("a capture");
    let second = Prepared::new(capture).and_then(|first| first.at_frame(1)).expect("ready");
    let light = second.trace(Options::default()).expect("traced");
    assert_eq!(light.only_frame(), Some(1));
    let shot = light.frame(1, &[]).expect("a frame");
    assert!(shot.warnings.iter().any(|warning| warning.contains("image lag")), "{:?}", shot.warnings);
}
