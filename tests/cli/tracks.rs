//! Objects that move along trajectories of their own.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec3};
use photosite::io::exr::read_exr;
use rstest::rstest;
use serde_json::Value;

use crate::folder::Folder;
use crate::kept_scenes::assert_same_however_made;

/// A tile of 0.4 m that rises to the middle, so that every pixel of it tells its pose and none is in its shadow.
const TILE: &str = "v -0.2 -0.2 0\nv 0.2 -0.2 0\nv 0.2 0.2 0\nv -0.2 0.2 0\nv 0 0 0.05\nusemtl paint\n\
    f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
const EXPOSURE_S: f64 = 0.002;
const ROW_TIME_S: f64 = 0.0005;
const SIZE: [usize; 2] = [48, 36];

fn folder(object: &str, camera: &str, more: &str) -> Folder {
    let capture = format!(
        "[scene]\nenvironment = {{ illuminant = 'D65', luminance_nit = 200 }}\n[[scene.objects]]\nfile = 'tile.obj'\n\
         name = 'tile'\n{object}\n[materials.paint]\ntype = 'diffuse'\nreflectance = [0.8, 0.2, 0.1]\n\
         [camera]\n{camera}\n[lens]\nfocal_length_mm = 4\nfocus_distance_m = 1\n[sensor]\npreset = 'sony-imx249-mono'\n\
         resolution_px = [{}, {}]\npixel_pitch_um = [60, 60]\nshutter = {{ kind = 'rolling', row_time_us = {} }}\n\
         [exposure]\ntime_s = {EXPOSURE_S}\n{more}",
        SIZE[0],
        SIZE[1],
        ROW_TIME_S * 1e6,
    );
    Folder::new([("tile.obj", TILE.into()), ("capture.toml", capture.into())])
}

const STILL_CAMERA: &str = "position_m = [0.1, 0.2, 1]\nlook_at_m = [0.05, 0, 0]";
const START: &str = "position_m = [0.05, -0.02, 0]\nrotation_deg = [0, 30, 0]\n";

fn start() -> DAffine3 {
    let rotation = DQuat::from_rotation_y(TAU / 12.0);
    DAffine3::from_rotation_translation(rotation, DVec3::new(0.05, -0.02, 0.0))
}

/// Test of each trajectory, in figures of its own.
#[derive(Clone, Copy)]
enum Way {
    Steady,
    Turntable,
    AboutItself,
    Linear,
    Spline,
}

impl Way {
    fn keys(self) -> String {
        match self {
            Self::Steady => format!(
                "{START}scale = [1.2, 1, 1]\n\
                 motion = {{ velocity_m_per_s = [3, 1, -2], angular_velocity_deg_per_s = [0, 900, 1500] }}"
            ),
            Self::Turntable => format!(
                "{START}motion.turntable = {{ centre_m = [0.1, 0, -0.1], axis = [0, 2, 1], speed_deg_per_s = 2000 }}"
            ),
            Self::AboutItself => format!("{START}motion.turntable.speed_deg_per_s = -3000"),
            Self::Linear => {
                "motion.poses = [{ time_s = -1, position_m = [-20, 0, 0] }, { time_s = 1, position_m = [20, 2, 0] }]"
                    .into()
            }
            // Points of a parabola, and of an even turn, at uneven times.
            Self::Spline => {
                let pose = |t: f64| {
                    let p = Self::parabola(t);
                    let angle_deg = 2000.0 * t;
                    format!(
                        "{{ time_s = {t}, position_m = [{}, {}, {}], rotation_deg = [0, {angle_deg}, 0] }}",
                        p.x, p.y, p.z
                    )
                };
                let poses: Vec<String> = [-0.02, 0.003, 0.01, 0.021, 0.06].map(pose).into();
                format!("motion = {{ interpolation = 'spline', poses = [{}] }}", poses.join(", "))
            }
        }
    }

    fn parabola(t: f64) -> DVec3 {
        DVec3::new(2.0 * t, 1.0 * t - 200.0 * t * t, 50.0 * t * t)
    }

    /// Own axes → world, without the scale.
    fn pose(self, t: f64) -> DAffine3 {
        let about = |centre: DVec3, axis: DVec3, deg_per_s: f64| {
            let turn = DAffine3::from_axis_angle(axis.normalize(), (deg_per_s * t).to_radians());
            DAffine3::from_translation(centre) * turn * DAffine3::from_translation(-centre) * start()
        };
        match self {
            Self::Steady => {
                let spin = DVec3::new(0.0, 900.0, 1500.0);
                let turn = DQuat::from_axis_angle(spin.normalize(), (spin.length() * t).to_radians());
                DAffine3::from_translation(DVec3::new(3.0, 1.0, -2.0) * t) * start() * DAffine3::from_quat(turn)
            }
            Self::Turntable => about(DVec3::new(0.1, 0.0, -0.1), DVec3::new(0.0, 2.0, 1.0), 2000.0),
            Self::AboutItself => about(DVec3::new(0.05, -0.02, 0.0), DVec3::Y, -3000.0),
            Self::Linear => DAffine3::from_translation(DVec3::new(20.0 * t, 1.0 + t, 0.0)),
            Self::Spline => {
                let turn = DQuat::from_rotation_y((2000.0 * t).to_radians());
                DAffine3::from_rotation_translation(turn, Self::parabola(t))
            }
        }
    }
}

/// Ground truth of each row is that of the middle of its exposure: the object's coordinates, moved as the formulas have
/// it, are those of the world.
#[rstest]
fn rows_see_an_object_where_its_trajectory_has_it(
    #[values(Way::Steady, Way::Turntable, Way::AboutItself, Way::Linear, Way::Spline)] way: Way,
    #[values(0.0, 0.0125)] time_s: f64,
) {
    let more = "frames = 2\nframe_interval_s = 0.025\n[render]\nsamples_per_pixel = 1\nmax_depth = 1\n[output]\nobjects = true\n\
         truth = ['position', 'object-position', 'instance']\n";
    let camera = match way {
        Way::Linear => "position_m = [0, 1, 4]\nlook_at_m = [0, 1, 0]",
        Way::Steady | Way::Turntable | Way::AboutItself | Way::Spline => STILL_CAMERA,
    };
    let folder = folder(&way.keys(), camera, more);
    folder.succeed(&format!("render capture.toml -o out --quiet --set scene.time_s={time_s}"));
    let mut told = 0;
    for frame in 0..2 {
        let start_s = time_s + 0.025 * f64::from(frame);
        let file = std::fs::File::open(folder.path(&format!("out/truth-000{frame}.exr"))).expect("truth");
        let truth = read_exr(std::io::BufReader::new(file)).expect("an image").planes;
        let plane = |name: &str| truth.plane(name).unwrap_or_else(|| panic!("no {name}"));
        let point = |layer: &str, i: usize| {
            let [x, y, z] = ["X", "Y", "Z"].map(|axis| f64::from(plane(&format!("{layer}.{axis}"))[i]));
            DVec3::new(x, y, z)
        };
        for i in (0..SIZE[0] * SIZE[1]).filter(|&i| plane("instance")[i] > 0.0) {
            let at = start_s + ROW_TIME_S * (i / SIZE[0]) as f64 + 0.5 * EXPOSURE_S;
            let world = way.pose(at).transform_point3(point("object-position", i));
            // A curve is cut into straight parts to a ten thousandth of its way, which is at most 0.3 m.
            let error = world.distance(point("position", i));
            assert!(error < 3e-5, "frame {frame}, pixel {i}: {error} m");
            told += 1;
        }
        let objects = folder.json(&format!("out/objects-000{frame}.json"));
        let middle = start_s + 0.5 * (ROW_TIME_S * (SIZE[1] - 1) as f64 + EXPOSURE_S);
        let translation = &objects["objects"][0]["position_m"];
        let found: Vec<f64> =
            translation.as_array().expect("a place").iter().map(|x| x.as_f64().expect("a number")).collect();
        let wanted = way.pose(middle).translation;
        assert!(DVec3::from_slice(&found).distance(wanted) < 3e-5, "{found:?} instead of {wanted}");
    }
    assert!(told > 80, "the tile fills {told} pixels of two images");
}

/// Before light that is the same everywhere it is all the same whether the object moves, or the camera the other way.
#[rstest]
#[case::velocity("motion.velocity_m_per_s = [4, 2, 0]", "motion.velocity_m_per_s = [-4, -2, 0]")]
#[case::turntable(
    "motion.turntable = { centre_m = [0.2, 0, 0], speed_deg_per_s = 600 }",
    "motion.turntable = { centre_m = [0.2, 0, 0], speed_deg_per_s = -600 }"
)]
fn motion_is_relative(#[case] of_object: &str, #[case] of_camera: &str) {
    let more = "[render]\nsamples_per_pixel = 16\nseed = 3\n";
    let object = folder(&format!("{START}{of_object}"), STILL_CAMERA, more);
    let camera = folder(START, &format!("{STILL_CAMERA}\n{of_camera}"), more);
    let still = folder(START, STILL_CAMERA, more);
    let electrons = |folder: &Folder| -> Vec<f32> {
        folder.succeed("render capture.toml -o out --quiet");
        let file = std::fs::File::open(folder.path("out/electrons.exr")).expect("electrons");
        read_exr(std::io::BufReader::new(file)).expect("an image").planes.plane("Y").expect("a channel").to_vec()
    };
    let [object, camera, still] = [object, camera, still].map(|folder| electrons(&folder));
    let differing = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 1e-3 * a.abs()).count();
    // A path at an edge may fall on either side.
    assert!(differing(&object, &camera) <= 3, "{} pixels differ", differing(&object, &camera));
    assert!(differing(&object, &still) > 50, "the object moves");
}

#[test]
fn a_data_set_along_a_trajectory_takes_what_moves_along() {
    let folder = folder(
        "motion.turntable.speed_deg_per_s = 90",
        STILL_CAMERA,
        "[render]\nsamples_per_pixel = 1\n[output]\nobjects = true\ntruth = ['flow', 'depth']\nraw = []\n",
    );
    let poses = "poses = [{ time_s = 0, position_m = [0, 0, 1], look_at_m = [0, 0, 0] }, \
                 { time_s = 0.2, position_m = [0.1, 0, 1.1], look_at_m = [0, 0, 0] }, \
                 { time_s = 0.3, position_m = [0.3, 0.1, 1], look_at_m = [0, 0, 0] }]";
    folder.add(
        "set.toml",
        format!(
            "capture = 'capture.toml'\n[poses.trajectory]\nframe_rate_hz = 10\ninterpolation = 'spline'\n{poses}\n"
        ),
    );
    assert_same_however_made(&folder, 4);
    let turned = |set: &str, frame: u32| {
        let path = folder.path(&format!("{set}/camera/{frame:06}/objects.json"));
        let objects: Value = serde_json::from_slice(&std::fs::read(path).expect("objects")).expect("JSON");
        let rotation = &objects["objects"][0]["rotation_to_world"];
        let number = |row: usize, column: usize| rotation[row][column].as_f64().expect("a number");
        number(0, 2).atan2(number(0, 0)).to_degrees()
    };
    let middle = 0.5 * (ROW_TIME_S * (SIZE[1] - 1) as f64 + EXPOSURE_S);
    for frame in 0..4 {
        let wanted = 90.0 * (0.1 * f64::from(frame) + middle);
        assert!((turned("together", frame) - wanted).abs() < 1e-6, "{}: {wanted}", turned("together", frame));
    }
    // What the description says of the time goes before that.
    folder.add(
        "set.toml",
        format!(
            "capture = 'capture.toml'\n[poses.trajectory]\nframe_rate_hz = 10\n{poses}\n\
             [[vary]]\nkey = 'scene.time_s'\nsweep = [1, 1.3]\n"
        ),
    );
    folder.succeed("dataset set.toml -o swept");
    for frame in 0..4 {
        let wanted = 90.0 * (1.0 + 0.1 * f64::from(frame) + middle);
        assert!((turned("swept", frame) - wanted).abs() < 1e-6, "{}: {wanted}", turned("swept", frame));
    }
}

#[rstest]
#[case::both(
    "motion = { velocity_m_per_s = [1, 0, 0], turntable = { speed_deg_per_s = 1 } }",
    "scene.objects[0].motion.velocity_m_per_s: cannot be combined with turntable",
    "keep one"
)]
#[case::pose_and_poses(
    "position_m = [0, 0, 0]\nmotion.poses = [{ time_s = 0, position_m = [0, 0, 0] }, { time_s = 1, position_m = [1, 0, 0] }]",
    "scene.objects[0].motion.poses: cannot be combined with position_m of the object",
    "remove position_m"
)]
#[case::interpolation(
    "motion.interpolation = 'spline'",
    "motion.interpolation: only applies with poses",
    "write poses"
)]
#[case::unknown_interpolation(
    "motion = { interpolation = 'cubic', poses = [] }",
    "interpolation: unknown value \"cubic\"",
    "linear"
)]
#[case::one_pose(
    "motion.poses = [{ time_s = 0, position_m = [0, 0, 0] }]",
    "scene.objects[0].motion.poses: a motion needs at least two",
    "leave motion out"
)]
#[case::two_rotations(
    "motion.poses = [{ time_s = 0, position_m = [0, 0, 0], rotation_deg = [0, 0, 0], look_at_m = [1, 0, 0] }]",
    "scene.objects[0].motion.poses[0].look_at_m: cannot be combined with rotation_deg",
    "keep one"
)]
#[case::no_axis(
    "motion.turntable = { axis = [0, 0, 0], speed_deg_per_s = 1 }",
    "scene.objects[0].motion.turntable.axis: has no length",
    "[0, 1, 0]"
)]
#[case::too_fast(
    "motion.angular_velocity_deg_per_s = [0, 1e9, 0]",
    "scene.objects[0].motion: turns more than a hundred times",
    "slowly"
)]
#[case::automatic_exposure("motion.velocity_m_per_s = [1, 0, 0]\n[exposure]\ntime_s = 'automatic'", "exposure", "")]
fn impossible_tracks_are_refused(#[case] keys: &str, #[case] message: &str, #[case] help: &str) {
    let folder = folder(keys, STILL_CAMERA, "");
    folder.fail("render capture.toml", 1, &["capture.toml", message, help]);
}

#[test]
fn a_time_without_motion_is_refused() {
    let folder = folder("", STILL_CAMERA, "");
    folder.fail("render capture.toml --set scene.time_s=1", 1, &["scene.time_s: only applies with", "motion"]);
}
