//! Layout of COCO's annotations of instances and key points ([Coco](photosite_core::references#coco)):
//!
//! ```text
//! images/CAMERA/000000.png
//! annotations/instances.json
//! ```
//!
//! A category for each name of an object. Regions are exact: the pixels of the instance layer as uncompressed run
//! lengths, column by column, with their count as the area; `iscrowd` is 0, as each is one object. Boxes are x, y,
//! width, height, where 0, 0, 1, 1 encloses the first pixel.
//!
//! The points of a target, and the key points of an object, are key points of its category, x, y, v each, with integer
//! coordinates at pixel centres, as in COCO's annotations: v is 2 for a visible point, 1 for a hidden one, and all
//! three are 0 for a point beyond the image. Objects that no pixel sees are not annotated.

use serde_json::{Value, json};

use super::image_set::{ImageSet, LayoutFiles, SeenPoint, SeenTarget, Shot};
use super::objects::{SceneObject, object_of_pixel};
use crate::truth::TruthLayer;
use photosite_core::Result;

pub(super) fn write(set: &ImageSet, files: &mut dyn LayoutFiles) -> Result<()> {
    let mut categories: Vec<Category> = Vec::new();
    let (mut images, mut annotations) = (Vec::new(), Vec::new());
    for (image, shot) in (1..).zip(&set.shots) {
        let name = format!("{}/{:06}.png", set.cameras[shot.camera], shot.frame);
        files.copy_image(&format!("images/{name}"), shot)?;
        let [width, height] = shot.calibrated.resolution;
        images.push(json!({ "id": image, "width": width, "height": height, "file_name": name }));
        let truth = files.truth(shot, &[TruthLayer::Instance])?;
        let of_objects = files.object_points(shot)?;
        let regions = regions(&object_of_pixel(&truth, &shot.objects), shot);
        for (object, region) in shot.objects.iter().zip(regions).filter(|(_, region)| region.area > 0) {
            let target = shot.targets.iter().find(|target| is_of(target, object));
            let own = of_objects.iter().find(|(number, _)| object.numbers.contains(number));
            let points = target.map(|target| &target.points).or(own.map(|(_, points)| points));
            let category = Category::new(object, target.is_some(), points.map(Vec::as_slice));
            let known = categories.iter().position(|other| *other == category).unwrap_or_else(|| {
                categories.push(category);
                categories.len() - 1
            });
            let mut annotation = json!({
                "id": annotations.len() + 1,
                "image_id": image,
                "category_id": known + 1,
                "iscrowd": 0,
                "area": region.area,
                "bbox": region.bounds(),
                "segmentation": { "size": [height, width], "counts": region.counts(width * height) },
            });
            if let Some(points) = points {
                let points: Vec<[f64; 3]> = points.iter().map(|point| key_point(point, shot)).collect();
                annotation["num_keypoints"] = points.iter().filter(|point| point[2] > 0.0).count().into();
                annotation["keypoints"] = points.as_flattened().iter().map(|x| short(*x)).collect();
            }
            annotations.push(annotation);
        }
    }
    let categories: Vec<Value> = (1..).zip(&categories).map(|(id, category)| category.json(id)).collect();
    let description = format!("Synthetic images, made by photosite {}", env!("CARGO_PKG_VERSION"));
    let whole = json!({
        "info": { "description": description },
        "licenses": [],
        "images": images,
        "annotations": annotations,
        "categories": categories,
    });
    files.write_text("annotations/instances.json", &format!("{whole}\n"))
}

/// Number as JSON, without a decimal point where it is an integer.
fn short(x: f64) -> Value {
    if x.fract() == 0.0 { json!(x as i64) } else { json!(x) }
}

/// Whether an object is a target.
fn is_of(target: &SeenTarget, object: &SceneObject) -> bool {
    target.name == object.name && target.to_world.abs_diff_eq(object.to_world, 1e-9)
}

fn key_point(point: &SeenPoint, shot: &Shot) -> [f64; 3] {
    let [width, height] = shot.calibrated.resolution.map(f64::from);
    let within = |x: f64, size: f64| (-0.5..size - 0.5).contains(&x);
    match point.pixel {
        Some(pixel) if within(pixel.x, width) && within(pixel.y, height) => {
            [pixel.x, pixel.y, if point.is_visible { 2.0 } else { 1.0 }]
        }
        Some(_) | None => [0.0; 3],
    }
}

/// Category: objects of one category, or else of one name.
#[derive(PartialEq)]
struct Category {
    name: String,
    is_target: bool,
    /// Names of the points of a target, or of an object.
    points: Option<Vec<String>>,
}

impl Category {
    fn new(object: &SceneObject, is_target: bool, points: Option<&[SeenPoint]>) -> Self {
        let points = points.map(|points| points.iter().map(|point| point.name.clone()).collect());
        Self { name: object.category.clone().unwrap_or_else(|| object.name.clone()), is_target, points }
    }

    fn json(&self, id: usize) -> Value {
        let kind = if self.is_target { "target" } else { "object" };
        let mut value = json!({ "id": id, "name": self.name, "supercategory": kind });
        if let Some(points) = &self.points {
            value["keypoints"] = json!(points);
            value["skeleton"] = json!([]);
        }
        value
    }
}

/// Region: the pixels of an object.
#[derive(Clone, Default)]
struct Region {
    /// Run lengths, outside and inside by turns, column by column.
    runs: Vec<u32>,
    /// Index behind the last run.
    end: u32,
    area: u32,
    /// Left, top, right and bottom pixel, inclusive.
    bounds: Option<[u32; 4]>,
}

impl Region {
    fn add(&mut self, [x, y]: [u32; 2], place: u32) {
        match self.runs.last_mut() {
            Some(last) if self.end == place => *last += 1,
            Some(_) | None => self.runs.extend([place - self.end, 1]),
        }
        self.end = place + 1;
        self.area += 1;
        let [left, top, right, bottom] = self.bounds.unwrap_or([x, y, x, y]);
        self.bounds = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
    }

    fn counts(&self, pixels: u32) -> Vec<u32> {
        let rest = pixels - self.end;
        self.runs.iter().copied().chain((rest > 0).then_some(rest)).collect()
    }

    fn bounds(&self) -> [u32; 4] {
        self.bounds.map_or([0; 4], |[left, top, right, bottom]| [left, top, right - left + 1, bottom - top + 1])
    }
}

fn regions(objects: &[Option<usize>], shot: &Shot) -> Vec<Region> {
    let [width, height] = shot.calibrated.resolution;
    let mut regions = vec![Region::default(); shot.objects.len()];
    for x in 0..width {
        for y in 0..height {
            let Some(Some(object)) = objects.get((y * width + x) as usize) else { continue };
            regions[*object].add([x, y], x * height + y);
        }
    }
    regions
}
