//! Surroundings of the subject of an image: `scene.ground` and `scene.backdrop`.
//!
//! In: the scene with all else that is in it. Out: an instance more, which [`SceneDescription::surroundings`] lists, so
//! that the size of the scene stays that of its subject. Lengths that nobody states are in proportion to that.

use std::path::Path;

use glam::{DAffine3, DVec3};

use super::super::tables::spectra::Finder;
use super::super::tables::{
    BackdropTable, CaptureFile, EnvironmentSource, GroundSource, GroundTable, ReflectanceSource, SceneTable,
};
use super::backdrop;
use super::environment::DEFAULT_GROUND_ALBEDO;
use super::floor_surface::Subject;
use super::geometry::{FARTHEST_M, ReadScene};
use super::ground;
use photosite_core::Invalid;
use photosite_core::Sandbox;
use photosite_transport::scene::description::{Diffuse, InstanceDescription, MaterialDescription, MaterialModel};

/// Name of the ground among the objects.
pub const GROUND: &str = "ground";

/// Reflectance of a backdrop of grey card.
const DEFAULT_BACKDROP_REFLECTANCE: f64 = 0.5;

/// Adds ground or backdrop to a scene of which all else is there.
pub(crate) fn add(read: &mut ReadScene, file: &CaptureFile, folder: &Path, sandbox: &Sandbox) -> Result<(), Invalid> {
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
            let invalid =
                Invalid::new("scene.backdrop", "cannot be combined with a ground, as it has a floor of its own");
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
            let invalid =
                Invalid::new("reflectance", "cannot be combined with material, which says what the surface reflects");
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

/// Floor that ground and backdrop have in common.
struct Floor<'a> {
    name: &'static str,
    height_m: Option<f64>,
    /// Angle about the vertical axis, degrees.
    turn_deg: f64,
    reflectance: &'a Option<ReflectanceSource>,
    material: &'a Option<String>,
    /// Reflectance where neither says another.
    grey: f64,
}

impl Floor<'_> {
    /// Places the floor: from the space of its surface to the world.
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
