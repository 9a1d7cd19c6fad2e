//! Tests of regions, models and silhouettes against closed forms; the judges of the command line read the files.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_3;
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, Vec3};
use rstest::rstest;
use serde_json::Value;

use super::models::Model;
use super::silhouette::Silhouette;
use super::*;
use crate::camera_files::CalibratedCamera;
use crate::targets::Chessboard;
use crate::targets::TargetDescription;
use crate::truth::TruthLayer;
use photosite_core::image::Channel;
use photosite_core::image::Planes;
use photosite_core::spectrum::Spectrum;
use photosite_transport::optics::{Intrinsics, Projection};
use photosite_transport::scene;
use photosite_transport::scene::description::SceneDescription;
use photosite_transport::scene::description::{
    Colour, Diffuse, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription, TexturedColour, rigid,
};

/// Files in memory.
#[derive(Default)]
struct Memory {
    texts: BTreeMap<String, String>,
    masks: BTreeMap<String, Vec<bool>>,
    depths: BTreeMap<String, Vec<u16>>,
    arrays: BTreeMap<String, Vec<f32>>,
    warnings: Vec<String>,
    images: Vec<String>,
    truth: Option<Planes>,
    scene: Arc<SceneDescription>,
}

impl LayoutFiles for Memory {
    fn write_text(&mut self, path: &str, text: &str) -> Result<()> {
        self.texts.insert(path.to_owned(), text.to_owned());
        Ok(())
    }
    fn copy_image(&mut self, path: &str, _: &Shot) -> Result<()> {
        self.images.push(path.to_owned());
        Ok(())
    }
    fn write_grey_image(&mut self, path: &str, _: &Shot) -> Result<()> {
        self.images.push(path.to_owned());
        Ok(())
    }
    fn is_grey(&mut self, _: &Shot) -> Result<bool> {
        Ok(true)
    }
    fn write_mask(&mut self, path: &str, _: [u32; 2], inside: &[bool]) -> Result<()> {
        self.masks.insert(path.to_owned(), inside.to_vec());
        Ok(())
    }
    fn write_grey16(&mut self, path: &str, _: [u32; 2], values: &[u16]) -> Result<()> {
        self.depths.insert(path.to_owned(), values.to_vec());
        Ok(())
    }
    fn write_npy(&mut self, path: &str, _: [u32; 2], values: &[f32]) -> Result<()> {
        self.arrays.insert(path.to_owned(), values.to_vec());
        Ok(())
    }
    fn warn(&mut self, message: &str) {
        self.warnings.push(message.to_owned());
    }
    fn has_truth(&mut self, _: &Shot, _: &[TruthLayer]) -> Result<bool> {
        Ok(self.truth.is_some())
    }
    fn truth(&mut self, _: &Shot, _: &[TruthLayer]) -> Result<Planes> {
        Ok(self.truth.clone().expect("truth"))
    }
    fn scene(&mut self, _: &Shot) -> Result<Arc<SceneDescription>> {
        Ok(self.scene.clone())
    }
}

const SIZE: [u32; 2] = [20, 10];

/// Shot of a camera at the origin that looks along −z of glTF.
fn shot(frame: u32, camera: usize) -> Shot {
    Shot {
        folder: format!("camera/{frame:06}"),
        frame,
        camera,
        stamp_ns: EPOCH_NS + u64::from(frame) * 1_000_000_000,
        calibrated: CalibratedCamera {
            name: "camera".to_owned(),
            intrinsics: Intrinsics { fx: 20.0, fy: 20.0, cx: 10.0, cy: 5.0, skew: 0.0 },
            projection: Projection::Perspective,
            resolution: SIZE,
            to_world: DAffine3::IDENTITY,
        },
        start: DAffine3::IDENTITY,
        velocity_m_per_s: DVec3::ZERO,
        is_resampled: false,
        is_skewed: false,
        shutter: None,
        targets: Vec::new(),
        objects: Vec::new(),
    }
}

fn set(shots: Vec<Shot>) -> ImageSet {
    let cameras = shots.iter().map(|shot| shot.camera).max().map_or(0, |last| last + 1);
    ImageSet { folder: PathBuf::from("set"), cameras: (0..cameras).map(|i| format!("camera{i}")).collect(), shots }
}

/// Rectangle in the plane z = 0 of its own frame, from the origin on.
fn rectangle(width: f32, height: f32) -> MeshDescription {
    let corner = |x: f32, y: f32| Vec3::new(x * width, y * height, 0.0);
    MeshDescription {
        name: "rectangle".to_owned(),
        positions: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshDescription::default()
    }
}

fn scene_of(instances: &[(&str, usize, DAffine3)]) -> SceneDescription {
    let reflectance = TexturedColour::plain(Colour::Rgb([0.5; 3]));
    SceneDescription {
        materials: vec![MaterialDescription::new("matt", MaterialModel::Diffuse(Diffuse { reflectance }))],
        meshes: vec![rectangle(1.0, 0.5).into(), rectangle(2.0, 1.0).into()],
        instances: instances
            .iter()
            .map(|(name, mesh, to_world)| InstanceDescription::of_mesh(*name, *mesh, *to_world))
            .collect(),
        ..SceneDescription::default()
    }
}

fn objects_of(scene: &SceneDescription) -> Vec<SceneObject> {
    SceneObject::of_scene(scene)
}

#[test]
fn parts_of_one_name_in_one_place_are_one_object() {
    let there = DAffine3::from_translation(DVec3::X);
    let scene = scene_of(&[
        ("board", 0, DAffine3::IDENTITY),
        ("board", 1, DAffine3::IDENTITY),
        ("board", 0, there),
        ("wall", 0, there),
    ]);
    let numbers: Vec<Vec<u32>> = objects_of(&scene).into_iter().map(|object| object.numbers).collect();
    assert_eq!(numbers, [vec![1, 2], vec![3], vec![4]]);
}

#[test]
fn regions_are_counted_column_by_column() {
    let mut plane = vec![0.0; 200];
    // Rows 2 and 3 of column 0, and the last pixel.
    for (x, y) in [(0, 2), (0, 3), (19, 9)] {
        plane[y * 20 + x] = 2.0;
    }
    let truth = Planes::new(20, 10, vec![Channel { name: "instance".to_owned(), data: plane }]).expect("planes");
    let scene = scene_of(&[("hidden", 0, DAffine3::IDENTITY), ("seen", 1, DAffine3::IDENTITY)]);
    let shots = vec![Shot { objects: objects_of(&scene), ..shot(0, 0) }];
    let mut files = Memory { truth: Some(truth), ..Memory::default() };
    Layout::Coco.write(&set(shots), &mut files).expect("laid out");
    let found: Value = serde_json::from_str(&files.texts["annotations/instances.json"]).expect("JSON");
    let annotations = found["annotations"].as_array().expect("a list");
    assert_eq!(annotations.len(), 1, "what no pixel sees is not annotated");
    assert_eq!(annotations[0]["segmentation"]["counts"], serde_json::json!([2, 2, 195, 1]));
    assert_eq!(annotations[0]["segmentation"]["size"], serde_json::json!([10, 20]));
    assert_eq!(annotations[0]["area"], 3);
    assert_eq!(annotations[0]["bbox"], serde_json::json!([0, 2, 20, 8]));
    assert_eq!(found["categories"][0]["name"], "seen");
}

#[test]
fn frames_of_models_have_no_scale() {
    let rotation = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 2.0);
    let scaled = DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 0.1, 3.0), rotation, DVec3::Y);
    let frame = rigid(&scaled);
    assert!(frame.abs_diff_eq(DAffine3::from_rotation_translation(rotation, DVec3::Y), 1e-12), "{frame}");
    let mirrored = DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), DVec3::X);
    assert_eq!(rigid(&mirrored), DAffine3::from_translation(DVec3::X));
    // A rectangle of 2 m by 1 m, twice as wide: its diagonal is √17 m, whichever way it is turned.
    let to_world = DAffine3::from_scale_rotation_translation(DVec3::new(2.0, 1.0, 1.0), rotation, DVec3::Y);
    let scene = scene_of(&[("sheet", 1, to_world)]);
    let info = Model::new(&objects_of(&scene)[0], &scene).info();
    let number = |key: &str| info[key].as_f64().expect("a number");
    assert!((number("diameter") - 1e3 * 17f64.sqrt()).abs() < 1e-9, "{info}");
    assert!((number("size_x") - 4000.0).abs() < 1e-9 && (number("size_y") - 1000.0).abs() < 1e-9, "{info}");
    assert!(number("min_x").abs() < 1e-9 && number("size_z").abs() < 1e-9, "{info}");
}

#[rstest]
#[case::in_the_middle(DVec3::new(-0.5, -0.225, -2.0), 10 * 5)]
#[case::beyond_the_image(DVec3::new(1.2, -0.225, -2.0), 10 * 5)]
// From column 35 to 45, where the canvas ends at 40.
#[case::half_beyond_the_canvas(DVec3::new(2.5, -0.225, -2.0), 5 * 5)]
#[case::behind(DVec3::new(-0.5, -0.225, 2.0), 0)]
fn silhouettes_are_counted_on_a_canvas_of_three_images(#[case] place: DVec3, #[case] pixels: usize) {
    // 1 m by 0.5 m at 2 m with f = 20 px: 10 by 5 pixels.
    let scene = scene_of(&[("sheet", 0, DAffine3::from_translation(place))]);
    let object = &objects_of(&scene)[0];
    let model = Model::new(object, &scene);
    let corners = model.box_corners().map(|corner| rigid(&object.to_world).transform_point3(corner));
    let built = scene::build(scene.clone(), &Spectrum::constant(1.0));
    let silhouette = Silhouette::new(&built, &corners, &shot(0, 0).calibrated);
    assert_eq!(silhouette.pixels().count(), pixels);
}

#[test]
fn bop_tells_what_is_hidden_from_what_is_seen() {
    let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_z(FRAC_PI_3), DVec3::new(0.0, 0.0, -4.0));
    let scene = scene_of(&[
        ("near", 0, DAffine3::from_translation(DVec3::new(-0.5, -0.225, -2.0))),
        ("far", 0, DAffine3::from_translation(DVec3::new(-0.5, -0.225, -2.5))),
        ("turned", 0, turned),
    ]);
    // Nothing but the near one is seen, in columns 5 to 14 and rows 2 to 6 (2.25 to 7.25 from the top).
    let is_near = |i: usize| (5..15).contains(&(i % 20)) && (2..7).contains(&(i / 20));
    let plane = |name: &str, there: f32, nowhere: f32| Channel {
        name: name.to_owned(),
        data: (0..200).map(|i| if is_near(i) { there } else { nowhere }).collect(),
    };
    let truth = Planes::new(20, 10, vec![plane("instance", 1.0, 0.0), plane("depth", 2.0, f32::INFINITY)]);
    let shots = vec![Shot { objects: objects_of(&scene), ..shot(7, 0) }];
    let mut files = Memory { truth: Some(truth.expect("planes")), scene: Arc::new(scene), ..Memory::default() };
    Layout::Bop.write(&set(shots), &mut files).expect("laid out");
    let json = |name: &str| -> Value {
        serde_json::from_str(&files.texts[&format!("train/000000/scene_{name}.json")]).expect("JSON")
    };
    let (gt, info, camera) = (json("gt"), json("gt_info"), json("camera"));
    assert_eq!(camera["7"]["cam_K"], serde_json::json!([20.0, 0.0, 9.5, 0.0, 20.0, 4.5, 0.0, 0.0, 1.0]));
    assert_eq!(camera["7"]["depth_scale"], 0.1);
    assert_eq!(files.depths["train/000000/depth/000007.png"].iter().filter(|&&code| code == 20_000).count(), 50);
    let near = &info["7"][0];
    assert_eq!((near["px_count_all"].as_u64(), near["px_count_visib"].as_u64()), (Some(50), Some(50)));
    assert_eq!((&near["bbox_obj"], &near["visib_fract"]), (&serde_json::json!([5, 2, 9, 4]), &serde_json::json!(1.0)));
    // 8 by 4 pixels at 2.5 m, none of them seen.
    let far = &info["7"][1];
    assert_eq!((far["px_count_all"].as_u64(), far["px_count_visib"].as_u64()), (Some(32), Some(0)));
    assert_eq!(far["bbox_obj"], serde_json::json!([-1, -1, -1, -1]));
    assert_eq!(files.masks["train/000000/mask/000007_000001.png"].iter().filter(|inside| **inside).count(), 32);
    // All share a model; its x axis leads from the third's origin to the camera's upper right, which is −y of OpenCV.
    assert_eq!(files.texts.keys().filter(|name| name.ends_with(".ply")).count(), 1);
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
    };
    let rotation = numbers(&gt["7"][2]["cam_R_m2c"]);
    assert!((rotation[0] - 0.5).abs() < 1e-12 && (rotation[3] + 0.75f64.sqrt()).abs() < 1e-12, "{rotation:?}");
    assert_eq!(numbers(&gt["7"][2]["cam_t_m2c"]), [0.0, 0.0, 4000.0]);
}

#[test]
fn a_rig_keeps_its_lenses_and_places() {
    let beside = |shot: Shot, x: f64| Shot { start: DAffine3::from_translation(DVec3::X * x), ..shot };
    let steady = set(vec![shot(0, 0), beside(shot(0, 1), 0.1), beside(shot(1, 0), 2.0), beside(shot(1, 1), 2.1)]);
    let rig = steady.rig().expect("a rig");
    assert_eq!(rig[1].to_world.translation, DVec3::X * 0.1);
    let loose = set(vec![shot(0, 0), beside(shot(0, 1), 0.1), shot(1, 0), beside(shot(1, 1), 0.2)]);
    assert!(loose.rig().expect_err("a loose camera").message.contains("the place on the rig of camera1 in frame 1"));
    let mut zoomed = shot(1, 0);
    zoomed.calibrated.intrinsics.fx = 21.0;
    let zoomed = set(vec![shot(0, 0), zoomed]);
    assert!(zoomed.rig().expect_err("a zoom").message.contains("the lens of camera0 in frame 1"));
    // For COLMAP each is a camera.
    let mut files = Memory::default();
    Layout::Colmap.write(&zoomed, &mut files).expect("laid out");
    assert_eq!(files.texts["sparse/0/cameras.txt"].lines().filter(|line| !line.starts_with('#')).count(), 2);
}

#[test]
fn points_of_a_target_that_has_moved_are_others() {
    let seen = |x: f64, is_visible: bool| SeenPoint {
        name: String::new(),
        world: DVec3::new(x, 0.0, -1.0),
        pixel: Some(DVec2::new(x, 2.0)),
        is_visible,
    };
    let with = |frame: u32, points: Vec<SeenPoint>| {
        let description = TargetDescription::Chessboard(Chessboard::default());
        let target = SeenTarget { name: "board".to_owned(), description, to_world: DAffine3::IDENTITY, points };
        Shot { targets: vec![target], ..shot(frame, 0) }
    };
    let shots = vec![
        with(0, vec![seen(0.0, false), seen(1.0, true)]),
        with(1, vec![seen(0.0, true), seen(1.0, true)]),
        with(2, vec![seen(0.0, true), seen(1.5, true)]),
    ];
    let mut files = Memory::default();
    Layout::Colmap.write(&set(shots), &mut files).expect("laid out");
    let points: Vec<&str> = files.texts["sparse/0/points3D.txt"].lines().skip(1).collect();
    assert_eq!(
        points,
        ["1 1 0 -1 128 128 128 0 1 0 2 1", "2 0 0 -1 128 128 128 0 2 0 3 0", "3 1.5 0 -1 128 128 128 0 3 1"]
    );
    assert!(files.texts["sparse/0/images.txt"].contains("\n1.5 2.5 1\n"), "{}", files.texts["sparse/0/images.txt"]);
    assert_eq!(files.images.len(), 3);
}

fn transforms(files: &Memory) -> Value {
    serde_json::from_str(&files.texts["transforms.json"]).expect("JSON")
}

/// Test: the point in the camera's axes projects to x_pixel = fx·x/z + cx by the values in the file.
#[test]
fn nerfstudio_sees_points_where_the_camera_does() {
    let to_world = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.4), DVec3::new(0.3, 1.0, 2.0));
    let mut shots = vec![shot(0, 0), shot(1, 0)];
    shots[1].calibrated.to_world = to_world;
    let mut files = Memory::default();
    Layout::Nerfstudio.write(&set(shots), &mut files).expect("laid out");
    let file = transforms(&files);
    assert_eq!((&file["camera_model"], &file["cx"], &file["fl_x"]), (&"OPENCV".into(), &10.0.into(), &20.0.into()));
    assert_eq!(files.images, ["images/camera-000000.png", "images/camera-000001.png"]);
    assert!(file["frames"][0]["depth_file_path"].is_null() && file["frames"][0]["fl_x"].is_null());
    let rows = &file["frames"][1]["transform_matrix"];
    let row = |i: usize| DVec3::from_array([0, 1, 2].map(|j| rows[i][j].as_f64().expect("a number")));
    let centre = DVec3::from_array([0, 1, 2].map(|i| rows[i][3].as_f64().expect("a number")));
    // y up becomes z up: the camera stands 1 m up.
    assert!(centre.abs_diff_eq(DVec3::new(0.3, -2.0, 1.0), 1e-12), "{centre}");
    let ahead = DVec3::from_array([row(0).z, row(1).z, row(2).z]) * -1.0;
    let looks = to_world.transform_vector3(DVec3::NEG_Z);
    assert!(ahead.abs_diff_eq(DVec3::new(looks.x, -looks.z, looks.y), 1e-12), "{ahead}");
}

#[test]
fn nerfstudio_gets_the_poses_of_the_first_and_the_last_row() {
    let at = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
    let shutter = |is_downwards| RollingShutter { rows: [at(1.0), at(2.0)], exposure: 0.5, is_downwards };
    let of = |shutter: Option<RollingShutter>| Shot { is_skewed: true, shutter, ..shot(0, 0) };
    let mut files = Memory::default();
    Layout::Nerfstudio.write(&set(vec![of(Some(shutter(true)))]), &mut files).expect("laid out");
    let file = transforms(&files);
    let x = |key: &str| file["frames"][0][key][0][3].as_f64();
    assert_eq!([x("transform_matrix_start"), x("transform_matrix_end")], [Some(1.0), Some(2.0)]);
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| file["rolling_shutter"][i].as_f64().expect("a number"));
    // The middle of the exposure of the first row of 10, and of the last.
    let part = |row: f64| a + c * (row + 0.5) / 10.0 + d * 0.5;
    assert!(part(0.0).abs() < 1e-12 && (part(9.0) - 1.0).abs() < 1e-12 && (b, d) == (0.0, 0.5));
    assert!(files.warnings.is_empty());
    for other in [Some(shutter(false)), None] {
        let mut files = Memory::default();
        Layout::Nerfstudio.write(&set(vec![of(other)]), &mut files).expect("laid out");
        assert!(files.warnings.len() == 1 && transforms(&files)["rolling_shutter"].is_null(), "{:?}", files.warnings);
    }
}

#[test]
fn nerfstudio_has_one_model_and_depth_in_millimetres() {
    let mut fisheye = shot(0, 1);
    fisheye.calibrated.projection = Projection::KannalaBrandt { k: [0.1, 0.0, 0.0, 0.0] };
    let error = Layout::Nerfstudio.write(&set(vec![shot(0, 0), fisheye]), &mut Memory::default()).expect_err("refused");
    assert!(error.to_string().contains("one camera_model"), "{error}");
    let mut other = shot(0, 1);
    other.calibrated.intrinsics.fx = 30.0;
    let depth = Channel { name: "depth".to_owned(), data: vec![f32::INFINITY, 1.5] };
    let truth = Planes::new(2, 1, vec![depth]).expect("planes");
    let mut files = Memory { truth: Some(truth), ..Memory::default() };
    Layout::Nerfstudio.write(&set(vec![shot(0, 0), other]), &mut files).expect("laid out");
    assert_eq!(files.arrays["depths/camera-000000.npy"], [0.0, 1500.0]);
    let file = transforms(&files);
    assert!(file["fl_x"].is_null() && file["frames"][1]["fl_x"] == 30.0, "once or with each, not both");
}
