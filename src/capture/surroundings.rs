//! `scene.ground` and `scene.backdrop`: what surrounds the subject of a picture.
//!
//! In: the scene with all else that is in it. Out: an instance more, which [`SceneDescription::surroundings`] lists, so
//! that the size of the scene stays that of its subject. Lengths that nobody states are in proportion to that.

use std::path::Path;

use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::colour::Finder;
use super::environment::DEFAULT_GROUND_ALBEDO;
use super::framing::{Sphere, bounding_sphere, to_power};
use super::quadrics::SMALLEST_SIZE_M;
use super::scene::{FARTHEST_M, ReadScene};
use super::tables::{
    BackdropTable, CaptureFile, EnvironmentSource, GroundSource, GroundTable, ReflectanceSource, SceneTable,
};
use super::{backdrop, ground};
use crate::Invalid;
use crate::scene::description::{
    Diffuse, InstanceDescription, MaterialDescription, MaterialModel, MeshDescription, SceneDescription,
};
use photosite_core::Sandbox;

/// Name of the ground among the objects.
pub(crate) const GROUND: &str = "ground";

/// Reflectance of a backdrop of grey card.
const DEFAULT_BACKDROP_REFLECTANCE: f64 = 0.5;

/// The geometry that is surrounded.
pub(super) struct Subject {
    pub(super) sphere: Sphere,
    /// Height of its lowest point, m.
    pub(super) lowest_m: f64,
}

/// Corners and triangles in the space of a mesh, whose origin lies under the middle of the subject, at the height of
/// the floor.
pub(super) struct Surface {
    pub(super) positions: Vec<DVec3>,
    /// One for each corner, or none.
    pub(super) normals: Vec<Vec3>,
    /// Metres along the surface.
    pub(super) uvs: Vec<Vec2>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// Adds ground or backdrop to a scene of which all else is there.
pub(super) fn add(read: &mut ReadScene, file: &CaptureFile, folder: &Path, sandbox: &Sandbox) -> Result<(), Invalid> {
    let default_ground = GroundTable::default();
    let ground = match &file.scene.ground {
        None | Some(GroundSource::Flag(false)) => None,
        Some(GroundSource::Flag(true)) => Some(&default_ground),
        Some(GroundSource::Table(table)) => Some(&**table),
    };
    let subject = Subject::of(&read.scene);
    let (floor, surface) = match (ground, &file.scene.backdrop) {
        (None, None) => return Ok(()),
        (Some(_), Some(_)) => {
            let invalid = Invalid::new("scene.backdrop", "cannot go with a ground, as it has a floor of its own");
            return Err(invalid.help("remove one of them, or write ground = false"));
        }
        (Some(GroundTable { height_m, reflectance, material, size_m }), None) => {
            let grey = ground_albedo(&file.scene);
            let floor = Floor { name: GROUND, height_m: *height_m, turn_deg: 0.0, reflectance, material, grey };
            (floor, ground::surface(&subject, *size_m))
        }
        (None, Some(table)) => {
            let BackdropTable { height_m, reflectance, material, rotation_deg, .. } = table;
            let (turn_deg, grey) = (rotation_deg.unwrap_or(0.0), DEFAULT_BACKDROP_REFLECTANCE);
            let floor = Floor { name: "backdrop", height_m: *height_m, turn_deg, reflectance, material, grey };
            (floor, backdrop::surface(&subject, table))
        }
    };
    let in_table = |invalid: Invalid| invalid.within(floor.name).within("scene");
    let surface = surface.map_err(in_table)?;
    let to_world = floor.place(&subject).map_err(in_table)?;
    let material = match (floor.material, floor.reflectance) {
        (Some(_), Some(_)) => {
            let invalid = Invalid::new("reflectance", "cannot go with material, which says what the surface reflects");
            return Err(in_table(invalid.help("keep one of them")));
        }
        (Some(name), None) => {
            let invalid = |key: &str, message: String| in_table(Invalid::new(key, message));
            read.material_of(name, &file.materials, &invalid)?
        }
        (None, stated) => {
            let grey = ReflectanceSource::Number(floor.grey);
            let mut finder = Finder::new(folder, sandbox, std::mem::take(&mut read.scene.images));
            let reflectance = finder.reflectance(stated.as_ref().unwrap_or(&grey));
            read.scene.images = finder.into_images();
            let reflectance = reflectance.map_err(|invalid| in_table(invalid.within("reflectance")))?;
            let model = MaterialModel::Diffuse(Diffuse { reflectance });
            read.scene.materials.push(MaterialDescription::new(floor.name, model));
            read.scene.materials.len() - 1
        }
    };
    let scene = &mut read.scene;
    let (mesh, name) = (scene.meshes.len(), floor.name.to_owned());
    scene.surroundings.push(scene.instances.len());
    scene.meshes.push(surface.into_mesh(name.clone(), material).into());
    scene.instances.push(InstanceDescription::of_mesh(name, mesh, to_world));
    Ok(())
}

/// Reflectance of the ground that the sky sees.
fn ground_albedo(scene: &SceneTable) -> f64 {
    let sky = match &scene.environment {
        Some(EnvironmentSource::Table(table)) => table.sky.as_ref(),
        Some(EnvironmentSource::Name(_)) | None => None,
    };
    sky.and_then(|sky| sky.ground_albedo).unwrap_or(DEFAULT_GROUND_ALBEDO)
}

impl Subject {
    /// All that is in a scene; a ball of 1 m on the origin where there is nothing.
    pub(super) fn of(scene: &SceneDescription) -> Self {
        let Some(sphere) = bounding_sphere(scene) else {
            return Self { sphere: Sphere { centre: DVec3::Y, radius: 1.0 }, lowest_m: 0.0 };
        };
        let lowest_m = scene.subject_points().fold(f64::INFINITY, |lowest, point| lowest.min(point.y));
        // Below that nothing is left of a triangle in single precision.
        Self { sphere: Sphere { radius: sphere.radius.max(1e-9), ..sphere }, lowest_m }
    }

    /// The height of a floor that no face of the subject lies in: from 1/10000 to 2/10000 of the radius below it, with
    /// as few digits as that takes.
    pub(super) fn floor_m(&self) -> f64 {
        let power = (self.sphere.radius * 1e-4).log10().floor() as i32;
        // Half a step lower, so that rounding leaves it below.
        to_power(self.lowest_m - self.sphere.radius * 1e-4 - 0.5 * 10f64.powi(power), power)
    }
}

/// What ground and backdrop have in common.
struct Floor<'a> {
    name: &'static str,
    height_m: Option<f64>,
    /// About the vertical axis.
    turn_deg: f64,
    reflectance: &'a Option<ReflectanceSource>,
    material: &'a Option<String>,
    /// Reflectance where neither says another.
    grey: f64,
}

impl Floor<'_> {
    /// From the space of its surface to the world.
    fn place(&self, subject: &Subject) -> Result<DAffine3, Invalid> {
        let height = self.height_m.unwrap_or_else(|| subject.floor_m());
        if !(height.is_finite() && height.abs() <= FARTHEST_M) {
            let message = format!("must lie within {FARTHEST_M:e} m, got {height}");
            return Err(Invalid::new("height_m", message));
        }
        if !self.turn_deg.is_finite() {
            return Err(Invalid::new("rotation_deg", format!("must be finite, got {}", self.turn_deg)));
        }
        let centre = DVec3 { y: height, ..subject.sphere.centre };
        Ok(DAffine3::from_translation(centre) * DAffine3::from_rotation_y(self.turn_deg.to_radians()))
    }
}

/// A stated length, which must be above 0, or its default.
pub(super) fn length(key: &str, stated: Option<f64>, default: f64) -> Result<f64, Invalid> {
    match stated {
        None => Ok(default.min(FARTHEST_M)),
        Some(length) if (SMALLEST_SIZE_M..=FARTHEST_M).contains(&length) => Ok(length),
        Some(length) => {
            let message = format!("must lie between {SMALLEST_SIZE_M:e} and {FARTHEST_M:e} m, got {length}");
            Err(Invalid::new(key, message).help(format!("for example {key} = 10.0")))
        }
    }
}

impl Surface {
    fn into_mesh(self, name: String, material: usize) -> MeshDescription {
        let Self { positions, normals, uvs, triangles } = self;
        let positions: Vec<Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
        // Of what is much smaller than the rest, rounding may leave nothing.
        let has_area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| positions[corner as usize]);
            (b - a).cross(c - a).length_squared() > 0.0
        };
        let triangles = triangles.into_iter().filter(has_area).collect();
        MeshDescription { name, material, positions, normals, uvs: vec![uvs], triangles, ..MeshDescription::default() }
    }
}
