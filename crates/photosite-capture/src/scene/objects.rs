//! Objects, `[[scene.objects]]`: files of geometry in poses of their own. Objects of one file share its meshes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::super::tables::geometry_kind::upright;
use super::super::tables::{MaterialChoice, MaterialTable, ObjectTable};
use super::super::tree::source::CaptureSource;
use super::geometry::{ReadScene, check_name, extents, is_within_reach, unit_length};
use super::models::ModelFile;
use super::moments::{Moments, Span};
use super::motion;
use super::object_pose::ObjectPose;
use super::object_track::ObjectTrack;
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::{Invalid, Result};
use photosite_transport::scene::description::{
    CameraDescription, InstanceDescription, LightDescription, ObjectDescription, SceneDescription, pose_at, vector,
};

/// Contents of a file of geometry, to be placed as often as one likes.
struct Template {
    file: ModelFile,
    /// Instances in the axes and units of the file.
    instances: Vec<InstanceDescription>,
    /// Largest coordinates of the meshes of each instance.
    extents: Vec<DVec3>,
    lights: Vec<LightDescription>,
    cameras: Vec<CameraDescription>,
    variants: Vec<String>,
    animations: Vec<String>,
}

impl ReadScene {
    /// Reads the files of objects and places them; `moments` are those of their animations. Materials are those of the
    /// files, and those of `described` names.
    pub(crate) fn add_objects(
        &mut self,
        source: &CaptureSource,
        objects: &[ObjectTable],
        moments: &Moments,
        folder: &Path,
        described: &BTreeMap<String, MaterialTable>,
    ) -> Result<()> {
        let mut templates: Vec<Template> = Vec::new();
        let mut of_objects = Vec::with_capacity(objects.len());
        for (i, (table, moment)) in objects.iter().zip(&moments.of_objects).enumerate() {
            let file = ModelFile {
                path: folder.join(&table.file),
                variant: table.variant.clone(),
                moment: moment.clone(),
                missing_normals: table.generate_normals.unwrap_or_default(),
                is_lenient: self.is_lenient,
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
            let template = (template, &templates[template]);
            let place = || self.place(table, template, name, moments.of_trajectories, described, &mut repainted);
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
        span: Option<Span>,
        described: &BTreeMap<String, MaterialTable>,
        repainted: &mut BTreeMap<(usize, Vec<Option<usize>>), usize>,
    ) -> Result<(), Invalid> {
        check_name("variant", "material variant", table.variant.as_deref(), &template.variants)?;
        check_name("animation", "animation", table.animation.as_deref(), &template.animations)?;
        let trajectory = motion::of_object(table).map_err(|invalid| invalid.within("motion"))?;
        let track = ObjectTrack::new(ObjectPose::of(table)?, trajectory.zip(span))?;
        let keypoint =
            |(name, point): (&String, &[f64; 3])| Ok((name.clone(), vector(&format!("keypoints.{name}"), *point)?));
        let keypoints = table.keypoints.iter().map(keypoint).collect::<Result<_, Invalid>>()?;
        let unit = unit_length(table.meters_per_unit)?;
        let turn = upright(&template.file.path, table.up, "up", &mut self.scene.warnings);
        let upright = DAffine3::from_scale_rotation_translation(DVec3::splat(unit), turn, DVec3::ZERO);
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
            let at = |part: f64| track.to_world(part) * upright * instance.at(part);
            let (to_world, later) = track.places(instance.later.len(), at);
            let placed = InstanceDescription {
                name: name.clone(),
                meshes: instance.meshes.start + shift..instance.meshes.end + shift,
                to_world,
                later,
                is_movable: table.has_pose(),
            };
            if ![placed.to_world].iter().chain(&placed.later).all(|to_world| is_within_reach(to_world, *extent)) {
                let message = "lies farther out than 1e18 m, too far to compute with".to_owned();
                return Err(Invalid::new("position_m", message).help("correct position_m, scale or meters_per_unit"));
            }
            self.scene.instances.push(placed);
        }
        // Lamps and cameras are moved and turned, and not made larger.
        let rigid = |of: &DAffine3, later: &[DAffine3]| {
            track.places(later.len(), |part| {
                let of_file = pose_at(of, later, part);
                let translation = (track.to_world(part) * upright).transform_point3(of_file.translation);
                DAffine3 { matrix3: track.rigid(part).matrix3 * DMat3::from_quat(turn) * of_file.matrix3, translation }
            })
        };
        self.scene.lights.extend(template.lights.iter().map(|light| {
            let (to_world, later) = rigid(&light.to_world, &light.later);
            LightDescription { to_world, later, ..light.clone() }
        }));
        self.scene.cameras.extend(template.cameras.iter().map(|camera| {
            let (to_world, later) = rigid(&camera.to_world, &camera.later);
            CameraDescription { to_world, later, ..camera.clone() }
        }));
        let instances = first..self.scene.instances.len();
        if !instances.is_empty() {
            let category = Some(table.category.clone().unwrap_or_else(|| stem(&table.file)));
            let (to_world, later) = track.places(0, |part| track.to_world(part));
            self.scene.objects.push(ObjectDescription { name, category, to_world, later, keypoints, instances });
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

    /// Adds the meshes of a template with other materials, unless they are there. Returns how far their indices are
    /// from those of the template.
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
    /// Whether any key places the object, so that it may be elsewhere in another image.
    fn has_pose(&self) -> bool {
        let is_turned = self.rotation_deg.is_some() || self.quaternion_wxyz.is_some() || self.look_at_m.is_some();
        self.position_m.is_some() || is_turned || self.scale.is_some() || self.motion.is_some()
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

/// The names of objects, all different.
fn names(objects: &[ObjectTable]) -> Result<Vec<String>, Invalid> {
    let mut taken: BTreeSet<String> = BTreeSet::new();
    for (i, name) in objects.iter().enumerate().filter_map(|(i, table)| Some((i, table.name.as_ref()?))) {
        if !taken.insert(name.clone()) {
            let message = format!("there is already an object {name:?}");
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
