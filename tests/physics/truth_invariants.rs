//! What holds of ground truth in every scene, in scenes drawn at random: an object by itself is the judge of its masks, its
//! own frame that of its box, and the other image that of flow.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use photosite::calibration::truth::{TruthJob, TruthLayer, TruthObject, View, truth};
use photosite::image::Planes;
use photosite::optics::Camera;
use photosite::pipeline::{Prepared, image_grid};
use photosite::report::{MaskReport, ObjectReport, ObjectsReport};
use photosite_core::image_grid::ImageGrid;

use crate::moving_scenes::{DISTANCE_M, FOCAL_PX, MovingScene, REGION_PX, SENSOR_PX};

const SCENES: u64 = 40;

/// An image that is ready for truth.
struct RenderedImage {
    prepared: Prepared,
    objects: Vec<TruthObject>,
    camera: Camera,
    grid: ImageGrid,
}

impl RenderedImage {
    fn of(scene: &MovingScene, objects: &[usize], exposure: &str, frame: u32) -> Self {
        let capture = scene.capture(objects, exposure);
        let found = TruthObject::of_scene(capture.scene());
        let first = Prepared::new(capture).unwrap_or_else(|error| panic!("{error}"));
        let prepared = if frame == 0 { first } else { first.at_frame(frame).expect("another frame") };
        let camera = prepared.camera();
        let grid = image_grid(prepared.capture(), &camera);
        Self { prepared, objects: found, camera, grid }
    }

    fn view(&self) -> View<'_> {
        View::of(self.prepared.scene(), &self.camera, self.grid)
    }

    fn layers(&self, layers: &[TruthLayer]) -> Planes {
        truth(&TruthJob { view: self.view(), objects: &self.objects, next: None, partner: None }, layers)
    }

    fn report(&self) -> ObjectsReport {
        ObjectsReport::new(&self.view(), &self.objects)
    }
}

fn plane<'a>(planes: &'a Planes, name: &str) -> &'a [f32] {
    planes.plane(name).unwrap_or_else(|| panic!("no plane {name}"))
}

fn vector(planes: &Planes, name: &str, i: usize) -> DVec3 {
    DVec3::from_array(["X", "Y", "Z"].map(|axis| f64::from(plane(planes, &format!("{name}.{axis}"))[i])))
}

/// The pixels of a mask, in rows.
fn pixels(mask: &MaskReport) -> Vec<bool> {
    let [height, width] = mask.mask.size.map(|n| n as usize);
    let mut inside = vec![false; width * height];
    let (mut at, mut is_in) = (0, false);
    for &length in &mask.mask.counts {
        (at..at + length as usize).for_each(|i| inside[i % height * width + i / height] = is_in);
        (at, is_in) = (at + length as usize, !is_in);
    }
    inside
}

const REGION: &str = "region_px = [16, 12, 32, 24]";
const BINNED: &str = "region_px = [16, 12, 32, 24]\nbinning = [2, 2]\nbinning_method = 'mean'";

fn exposures(seed: u64) -> &'static str {
    if seed.is_multiple_of(3) { BINNED } else { REGION }
}

#[test]
fn masks_are_those_of_the_object_by_itself() {
    let (mut hidden, mut shown) = (0, 0);
    for seed in 0..SCENES {
        let scene = MovingScene::draw(seed);
        let exposure = exposures(seed);
        let all: Vec<usize> = (0..scene.count()).collect();
        let image = RenderedImage::of(&scene, &all, exposure, 0);
        let instance = image.layers(&[TruthLayer::Instance]);
        for (i, object) in image.report().objects.iter().enumerate() {
            let case = format!("scene {seed}, {}", object.name);
            let [visible, alone] = [&object.visible, &object.alone].map(pixels);
            let by_itself = RenderedImage::of(&scene, &[i], exposure, 0).layers(&[TruthLayer::Instance]);
            let expected: Vec<bool> = plane(&by_itself, "instance").iter().map(|&n| n == 1.0).collect();
            let differ = alone.iter().zip(&expected).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{case}: pixels that see it alone");
            let expected: Vec<bool> = plane(&instance, "instance").iter().map(|&n| n == object.number as f32).collect();
            assert_eq!(visible, expected, "{case}: pixels that see it");
            assert!(visible.iter().zip(&alone).all(|(visible, alone)| !visible || *alone), "{case}");
            let [seen, of] = [&visible, &alone].map(|mask| mask.iter().filter(|inside| **inside).count());
            assert_eq!(object.visible_part, (of > 0).then(|| seen as f64 / of as f64), "{case}");
            assert!(object.visible_part.is_none_or(|part| (0.0..=1.0).contains(&part)), "{case}");
            hidden += of - seen;
            shown += seen;
        }
    }
    assert!(hidden > 50 && shown > 1000, "scenes that say something: {hidden} {shown}");
}

#[test]
fn points_lie_in_their_box_and_nocs_in_the_unit_cube() {
    for seed in 0..SCENES {
        let scene = MovingScene::draw(seed);
        let all: Vec<usize> = (0..scene.count()).collect();
        let image = RenderedImage::of(&scene, &all, exposures(seed), 0);
        let layers = [TruthLayer::Instance, TruthLayer::ObjectPosition, TruthLayer::Nocs, TruthLayer::Position];
        let planes = image.layers(&layers);
        let report = image.report();
        for (i, &number) in plane(&planes, "instance").iter().enumerate().filter(|(_, number)| **number > 0.0) {
            let object = &report.objects[number as usize - 1];
            let case = format!("scene {seed}, {}, pixel {i}", object.name);
            let [low, high] = [object.box_low_m, object.box_high_m].map(DVec3::from_array);
            let point = vector(&planes, "object-position", i);
            // Single precision of places some metres away: 8 roundings; and what the box leaves of an arc, 4e-6 of it.
            let room = 8.0 * f64::from(f32::EPSILON) * vector(&planes, "position", i).length().max(1.0) + 1e-5;
            assert!(
                point.cmpge(low - room).all() && point.cmple(high + room).all(),
                "{case}: {point} in {low} … {high}"
            );
            let expected = (point - (low + high) / 2.0) / (high - low).length() + 0.5;
            let nocs = vector(&planes, "nocs", i);
            assert!((nocs - expected).abs().max_element() < 1e-4, "{case}: {nocs}, not {expected}");
            assert!(nocs.cmpge(DVec3::ZERO).all() && nocs.cmple(DVec3::ONE).all(), "{case}: {nocs}");
        }
    }
}

/// Where all is seen at once by a lens that keeps lines straight, corners of the box surround what is seen of the object,
/// and the pose in the report is that at which it is seen.
#[test]
fn corners_and_poses_are_those_of_what_is_seen() {
    let mut checked = 0;
    for seed in 0..SCENES {
        let scene = MovingScene::draw(seed);
        if !scene.is_perspective_at_once {
            continue;
        }
        let all: Vec<usize> = (0..scene.count()).collect();
        let image = RenderedImage::of(&scene, &all, exposures(seed), 0);
        let planes = image.layers(&[TruthLayer::Instance, TruthLayer::ObjectPosition, TruthLayer::Position]);
        let width = planes.width();
        let report = image.report();
        for (i, &number) in plane(&planes, "instance").iter().enumerate().filter(|(_, number)| **number > 0.0) {
            let object = &report.objects[number as usize - 1];
            let case = format!("scene {seed}, {}, pixel {i}", object.name);
            let to_world = DAffine3 {
                matrix3: DMat3::from_cols_array_2d(&object.rotation_to_world).transpose(),
                translation: DVec3::from_array(object.position_m),
            };
            let [own, world] = ["object-position", "position"].map(|name| vector(&planes, name, i));
            let error = to_world.transform_point3(own).distance(world);
            assert!(error < 16.0 * f64::from(f32::EPSILON) * (1.0 + world.length()), "{case}: {error} m");
            let corners: Option<Vec<DVec2>> =
                object.box_corners_px.iter().map(|px| px.map(DVec2::from_array)).collect();
            let Some(corners) = corners else { continue };
            let [low, high] = [corners.iter().copied().reduce(DVec2::min), corners.iter().copied().reduce(DVec2::max)]
                .map(|corner| corner.expect("eight"));
            let pixel = DVec2::new((i % width) as f64, (i / width) as f64);
            assert!(pixel.cmpge(low - 1e-3).all() && pixel.cmple(high + 1e-3).all(), "{case}: {low} … {high}");
            checked += 1;
        }
    }
    assert!(checked > 200, "{checked}");
}

/// The region is a part of the whole sensor: what of an object lies beside it there is cut off here.
#[test]
fn what_is_seen_beside_the_image_is_cut_off() {
    let [left, top, columns, rows] = REGION_PX;
    let (mut cut, mut whole) = (0, 0);
    for seed in 0..SCENES {
        let scene = MovingScene::draw(seed);
        let all: Vec<usize> = (0..scene.count()).collect();
        let report = RenderedImage::of(&scene, &all, REGION, 0).report();
        let larger = RenderedImage::of(&scene, &all, "", 0).report();
        assert_eq!(larger.resolution_px, SENSOR_PX);
        for (object, larger) in report.objects.iter().zip(&larger.objects) {
            let case = format!("scene {seed}, {}", object.name);
            let (own, larger) = (pixels(&object.alone), pixels(&larger.alone));
            let mut beside = 0;
            for (i, &inside) in larger.iter().enumerate() {
                let [x, y] = [i as u32 % SENSOR_PX[0], i as u32 / SENSOR_PX[0]];
                let is_within = (left..left + columns).contains(&x) && (top..top + rows).contains(&y);
                if is_within {
                    assert_eq!(inside, own[((y - top) * columns + x - left) as usize], "{case}: {x}, {y}");
                } else {
                    beside += usize::from(inside);
                }
            }
            assert!(beside == 0 || object.is_cut_off, "{case}: {beside} pixels beside the image, and not cut off");
            assert_eq!(object.is_cut_off, !corners_within(object), "{case}");
            if object.is_cut_off { cut += 1 } else { whole += 1 }
        }
    }
    assert!(cut > 5 && whole > 5, "{cut} {whole}");
}

fn corners_within(object: &ObjectReport) -> bool {
    let [_, _, columns, rows] = REGION_PX.map(f64::from);
    let is_within = |[x, y]: [f64; 2]| (-0.5..=columns - 0.5).contains(&x) && (-0.5..=rows - 0.5).contains(&y);
    object.box_corners_px.iter().all(|corner| corner.is_some_and(is_within))
}

/// A surface that is seen in one image and found in the next is found again in the first where it was.
#[test]
fn flow_returns() {
    let mut returned = 0;
    for seed in 0..SCENES {
        let scene = MovingScene::draw(seed);
        let all: Vec<usize> = (0..scene.count()).collect();
        let [now, next] = [0, 1].map(|frame| RenderedImage::of(&scene, &all, exposures(seed), frame));
        let (view, next_view) = (now.view(), next.view());
        let hit = |image: &RenderedImage, pixel: DVec2| {
            let on_sensor = image.grid.on_sensor(pixel);
            let ray = image.camera.at_row(on_sensor.y - 0.5).chief_ray(on_sensor)?;
            let hit = image.prepared.scene().closest(&ray)?;
            let point = image.prepared.scene().point(&hit, ray.time);
            let cosine = f64::from(point.geometric_normal.dot(ray.direction.normalize()).abs());
            let reach = f64::from(point.position.distance(ray.origin));
            Some((hit, cosine, reach))
        };
        let [width, height] = now.grid.resolution.map(|n| n as usize);
        for i in 0..width * height {
            let pixel = now.grid.centre([i % width, i / width]);
            let Some((first, cosine, reach)) = hit(&now, pixel) else { continue };
            let there = now.prepared.scene().hit_in(&first, next.prepared.scene()).expect("the same surfaces");
            let Some(found) = next_view.correspondence(&there).filter(|found| found.visible) else { continue };
            let case = format!("scene {seed}, pixel {i}: {found:?}");
            let (second, other_cosine, _) = hit(&next, found.pixel).unwrap_or_else(|| panic!("{case}: nothing there"));
            let back = next.prepared.scene().hit_in(&second, now.prepared.scene()).expect("the same surfaces");
            let same = now.prepared.scene().object(&back) == now.prepared.scene().object(&first);
            let Some(back) = view.correspondence(&back) else { panic!("{case}: not found again") };
            assert!(same, "{case}: another object");
            let error = back.pixel.distance(pixel);
            // Hits are places of single precision, 8 roundings of places and ways, seen by 50 px per radian, obliquely by
            // more, from both sides; a lens that spreads and rows that follow magnify by less than 2.
            let rounding_m = 8.0 * f64::from(f32::EPSILON) * (reach + DISTANCE_M);
            let room = 2.0 * FOCAL_PX * rounding_m / reach * (1.0 / cosine + 1.0 / other_cosine);
            assert!(error < room, "{case}: {error} px away, not {room}");
            returned += 1;
        }
    }
    assert!(returned > 1000, "{returned}");
}
