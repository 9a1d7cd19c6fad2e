//! `[[scene.objects]]`: files of geometry in poses of their own. Objects of one file share its meshes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::models::ModelFile;
use super::scene::{ReadScene, check_name, extents, is_within_reach, missing_normals, unit_length};
use super::source::CaptureSource;
use super::tables::{MaterialChoice, MaterialTable, ObjectTable, ScaleSource, UpAxis};
use crate::io::gltf::Moment;
use crate::scene::description::{
    CameraDescription, InstanceDescription, LightDescription, ObjectDescription, SceneDescription, look_at, vector,
};
use crate::{Invalid, Result};
use photosite_core::suggest::{did_you_mean, list};

/// What a file of geometry holds, to be placed as often as one likes.
struct Template {
    file: ModelFile,
    /// In the axes and units of the file.
    instances: Vec<InstanceDescription>,
    /// The largest coordinates of the meshes of each.
    extents: Vec<DVec3>,
    lights: Vec<LightDescription>,
    cameras: Vec<CameraDescription>,
    variants: Vec<String>,
    animations: Vec<String>,
}

/// Where an object is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pose {
    position: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

impl ReadScene {
    /// Reads the files of objects and places them; `moments` are those of their animations. Materials are those of the
    /// files, and those of `described` names.
    pub(super) fn add_objects(
        &mut self,
        source: &CaptureSource,
        objects: &[ObjectTable],
        moments: &[Option<Moment>],
        folder: &Path,
        described: &BTreeMap<String, MaterialTable>,
    ) -> Result<()> {
        let mut templates: Vec<Template> = Vec::new();
        let mut of_objects = Vec::with_capacity(objects.len());
        for (i, (table, moment)) in objects.iter().zip(moments).enumerate() {
            let file = ModelFile {
                path: folder.join(&table.file),
                variant: table.variant.clone(),
                moment: moment.clone(),
                missing_normals: missing_normals(table.generate_normals),
            };
            let known = templates.iter().position(|template| template.file == file);
            of_objects.push(match known {
                Some(known) => known,
                None => {
                    let key = format!("scene.objects[{i}].file");
                    let model = self.read(source, &key, &file)?;
                    templates.push(self.template(file, model));
                    templates.len() - 1
                }
            });
        }
        let names = names(objects).map_err(|invalid| source.error(invalid))?;
        let mut repainted = BTreeMap::new();
        for (i, ((table, template), name)) in objects.iter().zip(of_objects).zip(names).enumerate() {
            let place = || self.place(table, (template, &templates[template]), name, described, &mut repainted);
            place().map_err(|invalid| source.error(invalid.within(&format!("scene.objects[{i}]"))))?;
        }
        Ok(())
    }

    /// Adds the meshes and materials of a file without placing anything.
    fn template(&mut self, file: ModelFile, mut model: super::models::Model) -> Template {
        let (variants, animations) = (std::mem::take(&mut model.variants), std::mem::take(&mut model.animations));
        let merged = self.merge(model);
        let instances = together(self.scene.instances.split_off(merged.instances.start), &self.scene);
        Template {
            file,
            extents: extents(&self.scene, &instances),
            instances,
            lights: self.scene.lights.split_off(merged.lights.start),
            cameras: self.scene.cameras.split_off(merged.cameras.start),
            variants,
            animations,
        }
    }

    /// Places an object. `repainted` are the meshes of templates that got other materials.
    fn place(
        &mut self,
        table: &ObjectTable,
        (number, template): (usize, &Template),
        name: String,
        described: &BTreeMap<String, MaterialTable>,
        repainted: &mut BTreeMap<(usize, Vec<Option<usize>>), usize>,
    ) -> Result<(), Invalid> {
        check_name("variant", "material variant", table.variant.as_deref(), &template.variants)?;
        check_name("animation", "animation", table.animation.as_deref(), &template.animations)?;
        let pose = pose(table)?;
        let unit = unit_length(table.meters_per_unit)?;
        let turn = match table.up {
            None | Some(UpAxis::Y) => DQuat::IDENTITY,
            Some(UpAxis::Z) => DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
        };
        let to_world = DAffine3::from_scale_rotation_translation(pose.scale, pose.rotation, pose.position);
        let of_file = to_world * DAffine3::from_scale_rotation_translation(DVec3::splat(unit), turn, DVec3::ZERO);
        if let Some(choice) = &table.material {
            self.check_materials(choice, template)?;
        }
        let materials = self.materials_of(table.material.as_ref(), template, described)?;
        if table.visible == Some(false) {
            return Ok(());
        }
        let shift = match materials.iter().any(Option::is_some) {
            true => self.repaint(number, template, materials, repainted),
            false => 0,
        };
        let first = self.scene.instances.len();
        for (instance, extent) in template.instances.iter().zip(&template.extents) {
            let placed = InstanceDescription {
                name: name.clone(),
                meshes: instance.meshes.start + shift..instance.meshes.end + shift,
                to_world: of_file * instance.to_world,
                later: instance.later.iter().map(|later| of_file * *later).collect(),
                is_movable: table.has_pose(),
            };
            if ![placed.to_world].iter().chain(&placed.later).all(|to_world| is_within_reach(to_world, *extent)) {
                let message = "lies farther out than 1e18 m, too far to compute with".to_owned();
                return Err(Invalid::new("position_m", message).help("correct position_m, scale or meters_per_unit"));
            }
            self.scene.instances.push(placed);
        }
        // Lamps and cameras are moved and turned, and not made larger.
        let rigid = |of: &DAffine3| {
            let place = of_file.transform_point3(of.translation);
            DAffine3 { matrix3: DMat3::from_quat(pose.rotation * turn) * of.matrix3, translation: place }
        };
        let all = |later: &[DAffine3]| later.iter().map(rigid).collect::<Vec<_>>();
        self.scene.lights.extend(template.lights.iter().map(|light| LightDescription {
            to_world: rigid(&light.to_world),
            later: all(&light.later),
            ..light.clone()
        }));
        self.scene.cameras.extend(template.cameras.iter().map(|camera| CameraDescription {
            to_world: rigid(&camera.to_world),
            later: all(&camera.later),
            ..camera.clone()
        }));
        let instances = first..self.scene.instances.len();
        if !instances.is_empty() {
            let category = Some(table.category.clone().unwrap_or_else(|| stem(&table.file)));
            self.scene.objects.push(ObjectDescription { name, category, to_world, later: Vec::new(), instances });
        }
        Ok(())
    }

    /// Refuses names of materials that the file of an object does not use.
    fn check_materials(&self, choice: &MaterialChoice, template: &Template) -> Result<(), Invalid> {
        let MaterialChoice::ByName(choices) = choice else { return Ok(()) };
        let meshes = template.instances.iter().flat_map(|instance| instance.meshes.clone());
        let used: BTreeSet<&str> =
            meshes.map(|mesh| &*self.scene.materials[self.scene.meshes[mesh].material].name).collect();
        match choices.keys().find(|name| *name != "*" && !used.contains(&***name)) {
            None => Ok(()),
            Some(name) => {
                let hint = did_you_mean(name, used.iter().copied());
                let message = format!("the file has no material {name:?}{hint}");
                Err(Invalid::new(format!("material.{name}"), message)
                    .help(format!("its materials are {}; \"*\" is all others", list(name, used))))
            }
        }
    }

    /// The material that each mesh of a template gets in place of its own.
    fn materials_of(
        &mut self,
        choice: Option<&MaterialChoice>,
        template: &Template,
        described: &BTreeMap<String, MaterialTable>,
    ) -> Result<Vec<Option<usize>>, Invalid> {
        let Some(choice) = choice else { return Ok(Vec::new()) };
        let meshes: Vec<usize> = template.meshes().collect();
        let of_mesh = |mesh: usize| {
            let name = match choice {
                MaterialChoice::All(name) => Some(("material".to_owned(), name)),
                MaterialChoice::ByName(choices) => {
                    let own = &self.scene.materials[self.scene.meshes[mesh].material].name;
                    let key = if choices.contains_key(own) { own } else { "*" };
                    choices.get(key).map(|name| (format!("material.{key}"), name))
                }
            };
            let Some((key, name)) = name else { return Ok(None) };
            let invalid = |_: &str, message: String| Invalid::new(&*key, message);
            self.material_of(name, described, &invalid).map(Some)
        };
        meshes.into_iter().map(of_mesh).collect()
    }

    /// Adds the meshes of a template with other materials, unless they are there. Returns how far their indices are from
    /// those of the template.
    fn repaint(
        &mut self,
        number: usize,
        template: &Template,
        materials: Vec<Option<usize>>,
        repainted: &mut BTreeMap<(usize, Vec<Option<usize>>), usize>,
    ) -> usize {
        let Some(start) = template.meshes().min() else { return 0 };
        let first = *repainted.entry((number, materials.clone())).or_insert_with(|| {
            let first = self.scene.meshes.len();
            for (mesh, material) in template.meshes().zip(materials) {
                self.add_mesh_again(mesh, material);
            }
            first
        });
        first - start
    }
}

impl Template {
    /// Indices of all meshes, without gaps.
    fn meshes(&self) -> std::ops::Range<usize> {
        let start = self.instances.iter().map(|instance| instance.meshes.start).min().unwrap_or(0);
        start..self.instances.iter().map(|instance| instance.meshes.end).max().unwrap_or(0)
    }
}

impl ObjectTable {
    /// Whether anything places it, so that it may be elsewhere in another picture.
    fn has_pose(&self) -> bool {
        let is_turned = self.rotation_deg.is_some() || self.quaternion_wxyz.is_some() || self.look_at_m.is_some();
        self.position_m.is_some() || is_turned || self.scale.is_some()
    }
}

/// Instances that stand in one place, each with a mesh of its own, as a single one.
fn together(instances: Vec<InstanceDescription>, scene: &SceneDescription) -> Vec<InstanceDescription> {
    let mut uses = vec![0usize; scene.meshes.len()];
    instances.iter().flat_map(|instance| instance.meshes.clone()).for_each(|mesh| uses[mesh] += 1);
    let mut all: Vec<InstanceDescription> = Vec::new();
    for instance in instances {
        let is_single = |of: &InstanceDescription| of.later.is_empty() && of.meshes.clone().all(|mesh| uses[mesh] == 1);
        let joins = |last: &&mut InstanceDescription| {
            last.to_world == instance.to_world
                && last.meshes.end == instance.meshes.start
                && is_single(last)
                && is_single(&instance)
        };
        match all.last_mut().filter(joins) {
            Some(last) => last.meshes.end = instance.meshes.end,
            None => all.push(instance),
        }
    }
    all
}

fn pose(table: &ObjectTable) -> Result<Pose, Invalid> {
    let position = vector("position_m", table.position_m.unwrap_or_default())?;
    let turns = [
        ("rotation_deg", table.rotation_deg.is_some()),
        ("quaternion_wxyz", table.quaternion_wxyz.is_some()),
        ("look_at_m", table.look_at_m.is_some()),
    ];
    let mut given = turns.iter().filter(|(_, is_given)| *is_given);
    if let (Some((first, _)), Some((second, _))) = (given.next(), given.next()) {
        return Err(Invalid::new(*second, format!("cannot go with {first}")).help("keep one of them"));
    }
    let rotation = if let Some(angles) = table.rotation_deg {
        let [x, y, z] = vector("rotation_deg", angles)?.to_array().map(f64::to_radians);
        DQuat::from_rotation_z(z) * DQuat::from_rotation_y(y) * DQuat::from_rotation_x(x)
    } else if let Some([w, x, y, z]) = table.quaternion_wxyz {
        let quaternion = DQuat::from_xyzw(x, y, z, w);
        let length = quaternion.length();
        if !(length.is_finite() && length > 0.0) {
            let message = format!("must not be 0 and must be finite, got {:?}", [w, x, y, z]);
            return Err(Invalid::new("quaternion_wxyz", message).help("[1, 0, 0, 0] is no turn"));
        }
        quaternion / length
    } else if let Some(target) = table.look_at_m {
        let target = vector("look_at_m", target)?;
        // Turned about: a camera looks along −z, and the front of an object is +z.
        let away = position * 2.0 - target;
        let looking = look_at(position, away, DVec3::Y).ok_or_else(|| {
            let message =
                "is straight above, below or where the object stands, so that it is not known which way is up";
            Invalid::new("look_at_m", message).help("write rotation_deg or quaternion_wxyz instead")
        })?;
        DQuat::from_mat3(&looking.matrix3)
    } else {
        DQuat::IDENTITY
    };
    let scale = match table.scale {
        None => DVec3::ONE,
        Some(ScaleSource::All(scale)) => DVec3::splat(scale),
        Some(ScaleSource::Each(scale)) => DVec3::from_array(scale),
    };
    if !(scale.is_finite() && scale.min_element() > 0.0) {
        let message = format!("must be above 0, got {:?}", scale.to_array());
        return Err(Invalid::new("scale", message).help("1 leaves the size as it is"));
    }
    Ok(Pose { position, rotation, scale })
}

/// The names of objects, all different.
fn names(objects: &[ObjectTable]) -> Result<Vec<String>, Invalid> {
    let mut taken: BTreeSet<String> = BTreeSet::new();
    for (i, name) in objects.iter().enumerate().filter_map(|(i, table)| Some((i, table.name.as_ref()?))) {
        if !taken.insert(name.clone()) {
            let message = format!("there is an object {name:?} already");
            return Err(Invalid::new(format!("scene.objects[{i}].name"), message).help("give each a name of its own"));
        }
    }
    let mut next: BTreeMap<String, usize> = BTreeMap::new();
    let name = |table: &ObjectTable| {
        if let Some(name) = &table.name {
            return name.clone();
        }
        let stem = stem(&table.file);
        let next = next.entry(stem.clone()).or_default();
        loop {
            let name = if *next == 0 { stem.clone() } else { format!("{stem}-{next}") };
            *next += 1;
            if taken.insert(name.clone()) {
                return name;
            }
        }
    };
    Ok(objects.iter().map(name).collect())
}

/// The name of a file without its extension.
fn stem(file: &str) -> String {
    Path::new(file).file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}
