//! Layout of the BOP data sets ([Bop](photosite_core::references#bop)):
//!
//! ```text
//! models/{models_info.json, obj_000001.ply}
//! train/000000/{scene_camera.json, scene_gt.json, scene_gt_info.json}
//! train/000000/{rgb or gray, depth}/000000.png
//! train/000000/{mask, mask_visib}/000000_000000.png
//! ```
//!
//! Each camera of the rig has a scene folder. Lengths are millimetres. A model is an object without its scale, in its
//! own frame: that of the node of a glTF file, the world's for OBJ files, that of a target for a target; objects of the
//! same shape share a model. `cam_R_m2c` and `cam_t_m2c` lead from there to the camera, `cam_R_w2c` and `cam_t_w2c`
//! from the world, whose y points up.
//!
//! Depth is along the axis, in steps of `depth_scale` of 0.1 mm or the smallest power of ten times that which 16 bits
//! can hold; 0 is no surface. A mask is the object without its occluders, `mask_visib` its visible part. As in the
//! toolkit's `calc_gt_info.py`, `px_count_all` and `bbox_obj` count what lies beyond the image as well, on a canvas of
//! three times its width and height, and the width of a box is the difference of its last and its first column.
//! Visibility is taken from the instance layer, exactly, and not from depths.
//!
//! Ground and backdrop are no objects here.
//!
//! The format has no distortion, and one pose per image: lenses with distortion, and rolling shutters while something
//! moves, are refused.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use serde_json::{Map, Value, json};

use super::image_set::{ImageSet, LayoutFiles, Shot};
use super::models::Model;
use super::objects::{SceneObject, object_of_pixel};
use super::silhouette::Silhouette;
use crate::truth::TruthLayer;
use photosite_core::image::Planes;
use photosite_core::projection::CalibrationModel;
use photosite_core::spectrum::Spectrum;
use photosite_core::{Invalid, Result};
use photosite_transport::scene::description::{InstanceDescription, SceneDescription, rigid};
use photosite_transport::scene::{self, Scene};

pub(super) fn write(set: &ImageSet, files: &mut dyn LayoutFiles) -> Result<()> {
    set.shots.iter().try_for_each(check).map_err(|invalid| set.error(invalid))?;
    let mut models: Vec<Model> = Vec::new();
    let mut built: Option<Built> = None;
    for camera in 0..set.cameras.len() {
        let mut scene = SceneFiles::default();
        for shot in set.of_camera(camera) {
            let description = files.scene(shot)?;
            let current = match built.take() {
                Some(built) if Arc::ptr_eq(&built.description, &description) => built,
                Some(_) | None => {
                    Built::new(description, &shot.objects, &mut models).map_err(|invalid| set.error(invalid))?
                }
            };
            let truth = files.truth(shot, &[TruthLayer::Depth, TruthLayer::Instance])?;
            scene.add(&format!("train/{camera:06}"), shot, &current, &truth, files)?;
            built = Some(current);
        }
        for (name, entries) in [("camera", scene.cameras), ("gt", scene.poses), ("gt_info", scene.info)] {
            files.write_text(&format!("train/{camera:06}/scene_{name}.json"), &by_line(&entries))?;
        }
    }
    let mut info = Map::new();
    for (id, model) in (1..).zip(&models) {
        files.write_text(&format!("models/obj_{id:06}.ply"), &model.ply())?;
        info.insert(id.to_string(), model.info());
    }
    files.write_text("models/models_info.json", &by_line(&info))
}

/// Refuses lenses and exposures that the format cannot express.
fn check(shot: &Shot) -> Result<(), Invalid> {
    match shot.calibrated.projection.calibration_model() {
        Some(CalibrationModel::Pinhole) => {}
        Some(CalibrationModel::BrownConrady(distortion)) if distortion.is_none() => {}
        Some(
            CalibrationModel::BrownConrady(_)
            | CalibrationModel::KannalaBrandt { .. }
            | CalibrationModel::Omnidirectional { .. },
        )
        | None => {
            return Err(shot
                .calibrated
                .no_model("BOP", "make a data set without lens.distortion and lens.prescription"));
        }
    }
    if shot.is_skewed {
        let message = format!("the rows of {} are exposed one after another while something moves", shot.folder);
        let help = "BOP files have one pose for each image: make a data set with sensor.shutter = \"global\"";
        return Err(Invalid::new("sensor.shutter", message).help(help));
    }
    Ok(())
}

/// JSON object with a line for each key.
fn by_line(entries: &Map<String, Value>) -> String {
    let lines: Vec<String> = entries.iter().map(|(key, value)| format!("  {}: {value}", json!(key))).collect();
    format!("{{\n{}\n}}\n", lines.join(",\n"))
}

/// Geometry of the objects, each in a scene of its own.
struct Built {
    description: Arc<SceneDescription>,
    objects: Vec<BuiltObject>,
}

struct BuiltObject {
    /// Index among the objects of the images.
    index: usize,
    scene: Scene,
    /// Points in the world that enclose the object, m.
    corners: Vec<DVec3>,
    /// Number of the object's model.
    model: usize,
    /// Pose: model → world, m.
    to_world: DAffine3,
}

impl Built {
    fn new(
        description: Arc<SceneDescription>,
        objects: &[SceneObject],
        models: &mut Vec<Model>,
    ) -> Result<Self, Invalid> {
        let moves = |i: &InstanceDescription| {
            !i.later.is_empty() || description.meshes[i.meshes.clone()].iter().any(|mesh| !mesh.later_shapes.is_empty())
        };
        if let Some(instance) = description.instances.iter().find(|instance| moves(instance)) {
            let message =
                format!("{} moves while the image is taken, and BOP files have one pose for it", instance.name);
            return Err(Invalid::new("scene", message).help("make a data set without animation, or motion of objects"));
        }
        let found = SceneObject::of_scene(&description);
        let is_same = |(a, b): (&SceneObject, &SceneObject)| {
            a.name == b.name && a.numbers == b.numbers && a.to_world.abs_diff_eq(b.to_world, 1e-9)
        };
        if found.len() != objects.len() || !found.iter().zip(objects).all(is_same) {
            let message = "the geometry files have changed since the images were made";
            return Err(Invalid::new("", message).help("put the files back, or make the data set again"));
        }
        let quadric = |i: &InstanceDescription| {
            let kind = description.meshes[i.meshes.clone()].iter().find_map(|mesh| mesh.quadric)?;
            Some((kind, i.name.clone()))
        };
        if let Some((kind, name)) = description.instances.iter().find_map(quadric) {
            let message = format!("{name:?} is a {}, and BOP files have models of triangles", kind.name());
            return Err(Invalid::new(format!("scene.{}s", kind.name()), message).help("put a mesh in its place"));
        }
        let build = |(index, object): (usize, &SceneObject)| {
            let model = Model::new(object, &description);
            let to_world = rigid(&object.to_world);
            let corners = model.box_corners().map(|corner| to_world.transform_point3(corner)).to_vec();
            let known = models.iter().position(|other| other.is_same(&model)).unwrap_or_else(|| {
                models.push(model);
                models.len() - 1
            });
            BuiltObject { index, scene: alone(object, &description), corners, model: known + 1, to_world }
        };
        // Ground and backdrop have no pose that anyone looks for.
        let surroundings: Vec<&InstanceDescription> =
            description.surroundings.iter().map(|&index| &description.instances[index]).collect();
        let is_subject = |(_, object): &(usize, &SceneObject)| {
            let instances = object.instances(&description);
            !instances.iter().any(|instance| surroundings.iter().any(|other| std::ptr::eq(*instance, *other)))
        };
        let objects = objects.iter().enumerate().filter(is_subject).map(build).collect();
        Ok(Self { description, objects })
    }
}

/// Scene that holds an object alone.
fn alone(object: &SceneObject, description: &SceneDescription) -> Scene {
    let mut part = SceneDescription {
        images: description.images.clone(),
        materials: description.materials.clone(),
        ..SceneDescription::default()
    };
    for instance in object.instances(description) {
        let first = part.meshes.len();
        part.meshes.extend_from_slice(&description.meshes[instance.meshes.clone()]);
        part.instances.push(InstanceDescription { meshes: first..part.meshes.len(), ..instance.clone() });
    }
    scene::build(part, &Spectrum::constant(1.0))
}

/// Files of a scene folder, as far as they have been gathered.
#[derive(Default)]
struct SceneFiles {
    cameras: Map<String, Value>,
    poses: Map<String, Value>,
    info: Map<String, Value>,
}

impl SceneFiles {
    fn add(
        &mut self,
        folder: &str,
        shot: &Shot,
        built: &Built,
        truth: &Planes,
        files: &mut dyn LayoutFiles,
    ) -> Result<()> {
        let image = format!("{:06}", shot.frame);
        let key = shot.frame.to_string();
        let colours = if files.is_grey(shot)? { "gray" } else { "rgb" };
        files.copy_image(&format!("{folder}/{colours}/{image}.png"), shot)?;
        let size = shot.calibrated.resolution;
        let depth = truth.plane("depth").unwrap_or_default();
        let scale_mm = depth_scale_mm(depth);
        let codes: Vec<u16> = depth.iter().map(|&metres| depth_code(metres, scale_mm)).collect();
        files.write_grey16(&format!("{folder}/depth/{image}.png"), size, &codes)?;

        let from_world = shot.calibrated.from_world();
        let [rotation, translation] = rotation_and_mm(&from_world);
        self.cameras.insert(
            key.clone(),
            json!({ "cam_K": shot.calibrated.matrix(), "depth_scale": scale_mm, "cam_R_w2c": rotation, "cam_t_w2c": translation }),
        );
        let (mut poses, mut info) = (Vec::new(), Vec::new());
        let seen = object_of_pixel(truth, &shot.objects);
        for object in &built.objects {
            let silhouette = Silhouette::new(&object.scene, &object.corners, &shot.calibrated);
            let Some(found) = Found::new(&silhouette, &seen, object.index, size, &codes) else { continue };
            let name = format!("{image}_{:06}.png", poses.len());
            files.write_mask(&format!("{folder}/mask/{name}"), size, &found.mask)?;
            files.write_mask(&format!("{folder}/mask_visib/{name}"), size, &found.visible)?;
            let [rotation, translation] = rotation_and_mm(&(from_world * object.to_world));
            poses.push(json!({ "cam_R_m2c": rotation, "cam_t_m2c": translation, "obj_id": object.model }));
            info.push(found.info);
        }
        self.poses.insert(key.clone(), poses.into());
        self.info.insert(key, info.into());
        Ok(())
    }
}

/// Rotation row by row, and translation in mm.
fn rotation_and_mm(pose: &DAffine3) -> [Value; 2] {
    let rotation: DMat3 = pose.matrix3.transpose();
    // Adding zero makes zeros of negative ones.
    [json!(rotation.to_cols_array().map(|x| x + 0.0)), json!((pose.translation * 1e3).to_array().map(|x| x + 0.0))]
}

/// Depth step: 0.1 mm, or the smallest power of ten times that with which 16 bits hold all depths.
fn depth_scale_mm(depth: &[f32]) -> f64 {
    let largest_mm = f64::from(depth.iter().copied().filter(|metres| metres.is_finite()).fold(0.0, f32::max)) * 1e3;
    [0.1, 1.0, 10.0, 100.0].into_iter().find(|scale| largest_mm / scale <= f64::from(u16::MAX)).unwrap_or(1000.0)
}

/// Code of a depth; 0 means no surface, so that a surface has 1 at least.
fn depth_code(metres: f32, scale_mm: f64) -> u16 {
    if metres.is_finite() && metres > 0.0 { (f64::from(metres) * 1e3 / scale_mm).round().max(1.0) as u16 } else { 0 }
}

/// Masks of an object in an image, and its entry in `scene_gt_info.json`.
struct Found {
    mask: Vec<bool>,
    visible: Vec<bool>,
    info: Value,
}

impl Found {
    /// Masks of an object in an image; `None` where the object would not be seen even by a larger sensor. `seen` names
    /// the object that each pixel sees.
    fn new(
        silhouette: &Silhouette,
        seen: &[Option<usize>],
        index: usize,
        size: [u32; 2],
        depth: &[u16],
    ) -> Option<Self> {
        let [width, height] = size.map(i64::from);
        let visible: Vec<bool> = seen.iter().map(|object| *object == Some(index)).collect();
        // The middles of pixels on the edge may fall to either side by the last bits of a ray.
        let mut mask = visible.clone();
        let mut all = Extent::default();
        for [x, y] in silhouette.pixels() {
            if (0..width).contains(&x) && (0..height).contains(&y) {
                mask[(y * width + x) as usize] = true;
            } else {
                all.add([x, y]);
            }
        }
        let place = |i: usize| [i as i64 % width, i as i64 / width];
        let pixels = |mask: &[bool]| -> Vec<usize> { (0..mask.len()).filter(|&i| mask[i]).collect() };
        pixels(&mask).into_iter().for_each(|i| all.add(place(i)));
        if all.count == 0 {
            return None;
        }
        let mut part = Extent::default();
        pixels(&visible).into_iter().for_each(|i| part.add(place(i)));
        let valid = pixels(&mask).into_iter().filter(|&i| depth[i] > 0).count();
        let info = json!({
            "bbox_obj": if part.count > 0 { all.bounds() } else { [-1; 4] },
            "bbox_visib": if part.count > 0 { part.bounds() } else { [-1; 4] },
            "px_count_all": all.count,
            "px_count_valid": valid,
            "px_count_visib": part.count,
            "visib_fract": part.count as f64 / all.count as f64,
        });
        Some(Self { mask, visible, info })
    }
}

/// Number of pixels, and the columns and rows that enclose them.
#[derive(Default)]
struct Extent {
    count: usize,
    ends: Option<[i64; 4]>,
}

impl Extent {
    fn add(&mut self, [x, y]: [i64; 2]) {
        let [left, top, right, bottom] = self.ends.unwrap_or([x, y, x, y]);
        self.ends = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
        self.count += 1;
    }

    fn bounds(&self) -> [i64; 4] {
        self.ends.map_or([-1; 4], |[left, top, right, bottom]| [left, top, right - left, bottom - top])
    }
}
