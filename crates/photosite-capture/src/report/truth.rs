//! Report of ground truth and of calibration targets.

use glam::{DAffine3, DVec2, DVec3};
use photosite_core::image_grid::ImageGrid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::matrix::{affine, from_rows, placement, rows};
use photosite_calibration::targets::PlacedTarget;
use photosite_calibration::truth::{Correspondence, Needs, TruthLayer, View};
use photosite_files::target_file::TargetFacts;
use photosite_transport::optics::Recording;
use photosite_transport::scene::description::SceneDescription;

/// Meaning of the values of ground truth.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct TruthReport {
    /// Names of the ground truth layers.
    pub layers: Vec<String>,
    /// Depth of one step in a PNG file, mm.
    pub depth_unit_mm: f64,
    /// Names of the objects, from number 1 on.
    pub instances: Vec<String>,
    /// Categories of the objects, from number 1 on; `null` for those that were not placed as objects.
    #[serde(default)]
    pub categories: Vec<Option<String>>,
    /// Transforms of the objects' frames to the world, row by row without the last row; of those that move at the
    /// `pose_time_s` of the camera.
    pub instances_to_world: Vec<[[f64; 4]; 3]>,
    /// Names of the materials, from number 1 on.
    pub materials: Vec<String>,
    /// Whether there is a next image, which flow leads to; without, no flow is valid. Left out without flow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub has_next: Option<bool>,
}

impl TruthReport {
    /// Report of ground truth; `None` where no layer was requested.
    pub fn new(
        layers: &[TruthLayer],
        depth_unit_m: f64,
        has_next: bool,
        scene: &SceneDescription,
        recording: Option<&Recording>,
    ) -> Option<Self> {
        let part = recording.map_or(0.0, |recording| recording.part(recording.middle_s()));
        let objects = scene.all_objects();
        (!layers.is_empty()).then(|| Self {
            layers: layers.iter().map(|layer| layer.name().to_owned()).collect(),
            depth_unit_mm: depth_unit_m * 1e3,
            instances: objects.iter().map(|object| object.name.clone()).collect(),
            categories: objects.iter().map(|object| object.category.clone()).collect(),
            instances_to_world: objects.iter().map(|object| placement(&object.at(part))).collect(),
            materials: scene.materials.iter().map(|material| material.name.clone()).collect(),
            has_next: TruthLayer::any_needs(layers, Needs::NextImage).then_some(has_next),
        })
    }

    /// Objects, numbered from 1: names, categories and transforms to the world.
    pub fn objects(&self) -> impl Iterator<Item = (String, Option<String>, DAffine3)> {
        let categories = self.categories.iter().cloned().chain(std::iter::repeat(None));
        let named = self.instances.iter().cloned().zip(categories);
        named
            .zip(self.instances_to_world.iter().map(affine))
            .map(|((name, category), to_world)| (name, category, to_world))
    }
}

/// Calibration target: its facts, and its pose.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct TargetReport {
    /// Name of the target in the capture.
    pub name: String,
    /// Keys, points and markers of the target in its own frame (x right, y down, z into the sheet).
    #[serde(flatten)]
    pub facts: TargetFacts,
    /// Rotation target → world, row by row: x_world = R·x_target + t.
    pub rotation: [[f64; 3]; 3],
    /// Translation t of x_world = R·x_target + t, m.
    pub translation_m: [f64; 3],
    /// Positions of the points in the world (glTF axes, metres), in the same order.
    pub points_world_m: Vec<[f64; 3]>,
    /// Pixels at which the points appear, through the whole lens: integer coordinates at pixel centres. `null` for
    /// those behind the camera. Where something moves: in the middle of the exposure of their rows of the first image.
    pub points_px: Vec<Option<[f64; 2]>>,
    /// Whether the points are within the image, with nothing before them.
    pub points_visible: Vec<bool>,
    /// Whether an aperture of a lens from a prescription blocks the chief ray of the points' places, so that what the
    /// image shows of them lies beside these. Left out where none is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points_vignetted: Vec<bool>,
}

impl TargetReport {
    /// Report of a target in the world, as a view shows it.
    pub fn new(placed: &PlacedTarget, view: &View<'_>) -> Self {
        let found: Vec<_> = placed.points().map(|(_, point)| view.landmark(point)).collect();
        let is_vignetted =
            |place: &Option<Correspondence>| place.is_some_and(|at| view.camera.is_vignetted(at.on_sensor));
        let vignetted: Vec<bool> = found.iter().map(is_vignetted).collect();
        let px = |place: &Correspondence| (place.pixel - DVec2::splat(0.5)).to_array();
        Self {
            points_px: found.iter().map(|place| place.as_ref().map(px)).collect(),
            points_visible: found.iter().map(|place| place.is_some_and(|place| place.visible)).collect(),
            points_vignetted: if vignetted.contains(&true) { vignetted } else { Vec::new() },
            name: placed.name.clone(),
            facts: TargetFacts::new(&placed.description, &placed.target),
            rotation: rows(placed.to_world.matrix3),
            translation_m: placed.to_world.translation.to_array(),
            points_world_m: placed.points().map(|(_, point)| point.to_array()).collect(),
        }
    }

    /// Moves the points from the pixels of one image to those of another. Points that the first one does not show stay
    /// hidden, since nothing is known of their occluders.
    pub fn move_points(&mut self, from: &ImageGrid, to: &ImageGrid) {
        for (place, visible) in self.points_px.iter_mut().zip(&mut self.points_visible) {
            let Some(px) = place else { continue };
            let moved = to.in_image(from.on_sensor(DVec2::from_array(*px) + 0.5));
            *visible = *visible && to.contains(moved);
            *px = (moved - 0.5).to_array();
        }
    }

    /// Transform target → world.
    pub fn to_world(&self) -> DAffine3 {
        DAffine3::from_mat3_translation(from_rows(&self.rotation), DVec3::from_array(self.translation_m))
    }
}
