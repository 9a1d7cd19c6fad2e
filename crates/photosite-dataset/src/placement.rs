//! `[[place]]`: objects that get other places in each frame, drawn when an image of it is made.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Arc, Mutex};

use glam::DVec3;
use rand::RngExt;
use serde_json::{Map, Value, json};

use super::file_pattern::files_of;
use super::shapes::{shape, shapes};
use photosite_calibration::dataset::{PlaceDescription, PlaceMethod, PlaceRotation, Plan, RegionDescription, toml};
use photosite_capture::{Capture, DatasetFile};
use photosite_core::locked::locked;
use photosite_core::math::hash::hash64;
use photosite_core::math::philox::Philox;
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::{Invalid, Result, Sandbox};
use photosite_placement::{Bin, Contact, Fixed, Item, Method, Pose, Region, Request, Shape, Support, Turn, place};
use photosite_transport::scene::description::{ObjectDescription, SceneDescription};

/// Shapes with the names of their objects.
type NamedShapes = Vec<(String, Arc<Shape>)>;

/// Number of frames whose places are kept for the other cameras of a rig.
const MOST_KEPT: usize = 16;

/// All `[[place]]` tables of a data set.
#[derive(Debug, Default)]
pub(super) struct Places {
    tables: Vec<Table>,
    /// Capture of all files that the tables name.
    probe: Option<Capture>,
    /// Last draw, by frame.
    drawn: Mutex<BTreeMap<u32, String>>,
    /// Obstacles of the scene that was asked for last.
    obstacles: Mutex<Option<Obstacles>>,
}

/// Scene with its obstacles.
type Obstacles = (Arc<SceneDescription>, Arc<NamedShapes>);

/// One `[[place]]` table.
#[derive(Debug)]
struct Table {
    description: PlaceDescription,
    files: Vec<Template>,
}

/// File of objects, with its shape.
#[derive(Debug)]
struct Template {
    /// Path relative to the capture.
    file: String,
    /// Shape in its own frame, at the size that it has there.
    shape: Arc<Shape>,
}

/// Object in its place.
struct Placed {
    table: usize,
    file: usize,
    scale: f64,
    material: Option<String>,
    pose: Pose,
}

impl Places {
    /// Reads the files that are placed.
    pub(super) fn read(file: &DatasetFile, sandbox: &Sandbox, capture: &Capture) -> Result<Self> {
        let tables = &file.description.place;
        if tables.is_empty() {
            return Ok(Self::default());
        }
        // All files as objects of one capture, beside its own.
        let mut objects = own_objects(capture)?;
        let own = objects.len();
        let folder = capture.source().path().parent().unwrap_or(Path::new(""));
        let mut names = Vec::new();
        for (i, description) in tables.iter().enumerate() {
            let at = |invalid: Invalid| file.error(invalid.within(&format!("place[{i}]")));
            check(description).map_err(at)?;
            for (number, pattern) in description.objects.iter().enumerate() {
                let within = |invalid: Invalid| at(invalid.within(&format!("objects[{number}]")));
                for name in files_of(pattern, file.path(), folder, sandbox).map_err(within)? {
                    let mut object = of_file(description, &name);
                    object.insert("name".to_owned(), probe_name(objects.len() - own).into());
                    objects.push(object.into());
                    names.push((i, number, name));
                }
            }
        }
        let change = format!("scene.objects={}", toml(&objects.into()));
        let probe = capture.with_all(&[capture.overrides(), std::slice::from_ref(&change)].concat());
        let probe = probe.map_err(|error| file.error_of_change(error, "", None, &[change]))?;
        let of_scene: BTreeMap<&str, &ObjectDescription> =
            probe.scene().objects.iter().map(|object| (object.name.as_str(), object)).collect();
        let mut read: Vec<Table> = tables.iter().map(|d| Table { description: d.clone(), files: Vec::new() }).collect();
        for (number, (table, pattern, name)) in names.into_iter().enumerate() {
            let object = of_scene.get(&*probe_name(number));
            let own = object.map_or(Ok(None), |object| shape(probe.scene(), object));
            let own =
                own.and_then(|own| own.ok_or_else(|| Invalid::new("", "it has no triangles"))).map_err(|invalid| {
                    let key = format!("place[{table}].objects[{pattern}]");
                    file.error(Invalid { key, message: format!("{name}: {}", invalid.message), ..invalid })
                })?;
            read[table].files.push(Template { file: name, shape: Arc::new(own) });
        }
        Ok(Self { tables: read, probe: Some(probe), ..Self::default() })
    }

    /// Capture of all files that are placed; `None` where there are none.
    pub(super) fn all(&self) -> Option<&Capture> {
        self.probe.as_ref()
    }

    /// Change to the capture that places all objects of a frame. `before` makes the capture without them.
    pub(super) fn change(
        &self,
        plan: &Plan,
        number: u32,
        file: &DatasetFile,
        before: impl FnOnce() -> Result<Capture>,
    ) -> Result<Option<String>> {
        if self.tables.is_empty() {
            return Ok(None);
        }
        if let Some(drawn) = locked(&self.drawn).get(&number) {
            return Ok(Some(drawn.clone()));
        }
        let capture = before()?;
        let objects = own_objects(&capture)?;
        let ground = capture.value("scene.ground.height_m")?.and_then(|value| value.as_f64());
        let change = self.draw(plan, number, (capture.scene(), objects, ground)).map_err(|e| file.error(e))?;
        let mut drawn = locked(&self.drawn);
        drawn.insert(number, change.clone());
        while drawn.len() > MOST_KEPT {
            drawn.pop_first();
        }
        Ok(Some(change))
    }

    /// Adds the objects that are drawn in a frame to those of a scene.
    fn draw(
        &self,
        plan: &Plan,
        number: u32,
        (scene, mut objects, ground): (&Arc<SceneDescription>, Vec<Value>, Option<f64>),
    ) -> Result<String, Invalid> {
        let obstacles = self.obstacles(scene)?;
        let mut fixed: Vec<(String, Fixed)> = obstacles
            .iter()
            .map(|(name, shape)| (name.clone(), Fixed { shape: shape.clone(), scale: 1.0, pose: Pose::IDENTITY }))
            .collect();
        let mut placed: Vec<Placed> = Vec::new();
        for (i, table) in self.tables.iter().enumerate() {
            let repeats = table.description.frames.unwrap_or(1);
            let seed = plan.places_seed(i, number / repeats);
            let new = table.draw(i, seed, &fixed, ground).map_err(|invalid| {
                let message = format!("in frame {number}: {}", invalid.message);
                Invalid { message, ..invalid }.within(&format!("place[{i}]"))
            })?;
            fixed.extend(new.iter().map(|object| {
                let shape = table.files[object.file].shape.clone();
                (String::new(), Fixed { shape, scale: object.scale, pose: object.pose })
            }));
            placed.extend(new);
        }
        let mut taken: BTreeSet<String> = scene.all_objects().into_iter().map(|object| object.name).collect();
        let mut next: BTreeMap<String, usize> = BTreeMap::new();
        for object in &placed {
            let description = &self.tables[object.table].description;
            let file = &self.tables[object.table].files[object.file].file;
            let stem = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let next = next.entry(stem.clone()).or_default();
            let name = loop {
                let name = format!("{stem}-{next}");
                *next += 1;
                if taken.insert(name.clone()) {
                    break name;
                }
            };
            let (q, p) = (object.pose.rotation, object.pose.position);
            let mut table = of_file(description, file);
            let category = description.category.clone().unwrap_or(stem);
            let keys = [
                ("name", json!(name)),
                ("category", json!(category)),
                ("position_m", json!(p.to_array().map(|x| x + 0.0))),
                ("quaternion_wxyz", json!([q.w, q.x, q.y, q.z].map(|x| x + 0.0))),
                ("scale", json!(object.scale)),
            ];
            let material = object.material.as_ref().map(|material| ("material", json!(material)));
            table.extend(keys.into_iter().chain(material).map(|(key, value)| (key.to_owned(), value)));
            objects.push(table.into());
        }
        Ok(format!("scene.objects={}", toml(&objects.into())))
    }

    /// Obstacles of a scene.
    fn obstacles(&self, scene: &Arc<SceneDescription>) -> Result<Arc<NamedShapes>, Invalid> {
        let mut known = locked(&self.obstacles);
        if let Some((of, obstacles)) = known.as_ref()
            && Arc::ptr_eq(of, scene)
        {
            return Ok(obstacles.clone());
        }
        let obstacles = Arc::new(shapes(scene)?);
        *known = Some((scene.clone(), obstacles.clone()));
        Ok(obstacles)
    }
}

impl Table {
    /// Draws which objects there are, with their sizes, materials and poses.
    fn draw(
        &self,
        table: usize,
        seed: u64,
        obstacles: &[(String, Fixed)],
        ground: Option<f64>,
    ) -> Result<Vec<Placed>, Invalid> {
        let d = &self.description;
        let mut random = Philox::new(seed, 0);
        let [least, most] = d.count.map_or([1, 1], |count| count.range());
        let count = random.random_range(least..=most);
        // Factors of the files' own sizes, or the sizes themselves
        let [small, large] = d.size_m.map_or(d.scale.unwrap_or([1.0, 1.0]), |size| size.range());
        let mut placed: Vec<Placed> = Vec::new();
        for _ in 0..count {
            let file = random.random_range(0..self.files.len());
            let drawn = small + (large - small) * random.random::<f64>();
            let scale = if d.size_m.is_some() { drawn / self.files[file].shape.longest_side() } else { drawn };
            let material =
                (!d.materials.is_empty()).then(|| d.materials[random.random_range(0..d.materials.len())].clone());
            placed.push(Placed { table, file, scale, material, pose: Pose::IDENTITY });
        }
        let items =
            placed.iter().map(|o| Item { scale: o.scale, ..Item::new(self.files[o.file].shape.clone()) }).collect();
        let mut fixed: Vec<Fixed> = obstacles.iter().map(|(_, fixed)| fixed.clone()).collect();
        let how = self.method(obstacles, &mut fixed)?;
        let contact = Contact::default();
        let request = Request {
            items,
            how,
            fixed,
            ground_height_m: d.ground_height_m.or(ground),
            min_distance_m: d.min_distance_m.unwrap_or(0.0),
            contact: Contact {
                friction: d.friction.unwrap_or(contact.friction),
                restitution: d.restitution.unwrap_or(contact.restitution),
            },
            seed: hash64(seed, 1),
        };
        let poses = place(&request)?;
        placed.iter_mut().zip(poses).for_each(|(object, pose)| object.pose = pose);
        Ok(placed)
    }

    /// Placement method of the table. A bin adds its walls to the fixed obstacles.
    fn method(&self, obstacles: &[(String, Fixed)], fixed: &mut Vec<Fixed>) -> Result<Method, Invalid> {
        let d = &self.description;
        let surface = d.surface.as_ref().map(|name| named(name, obstacles)).transpose()?;
        let region = d.region.as_ref().map(region);
        let above = |on: usize| {
            let bounds = obstacles[on].1.bounds();
            let inside = Region { min: bounds.min, max: DVec3 { y: f64::INFINITY, ..bounds.max } };
            (Region { min: DVec3 { y: bounds.max.y, ..bounds.min }, ..bounds }, inside)
        };
        let turn = |default: Turn| match d.rotation {
            None => default,
            Some(PlaceRotation::Any) => Turn::Any,
            Some(PlaceRotation::Vertical) => Turn::Vertical,
            Some(PlaceRotation::None) => Turn::None,
        };
        let missing = |key: &str, example: &str| Invalid::new(key, "missing").help(format!("for example {example}"));
        let region_needed = || missing("region", "region = { min_m = [-0.2, 0, -0.2], max_m = [0.2, 0.3, 0.2] }");
        Ok(match d.method {
            PlaceMethod::Box => Method::Box { region: region.ok_or_else(region_needed)?, turn: turn(Turn::Any) },
            PlaceMethod::Surface => {
                let on = surface.ok_or_else(|| missing("surface", "surface = \"table\""))?;
                Method::Surface { on, turn: turn(Turn::Vertical) }
            }
            PlaceMethod::Rest => Method::Rest {
                on: match surface {
                    Some(on) => Support::Fixed(on),
                    None => Support::Ground(region.ok_or_else(region_needed)?),
                },
            },
            PlaceMethod::Drop => {
                if let Some(bin) = &d.bin {
                    let bin = Bin {
                        size: bin.size_m.into(),
                        position: bin.position_m.unwrap_or_default().into(),
                        wall: bin.wall_m.unwrap_or(0.01),
                    };
                    fixed.extend(bin.fixed().map_err(|invalid| invalid.within("bin"))?);
                    Method::Drop { region: region.unwrap_or(bin.region()), keep_in: Some(bin.inside()) }
                } else if let Some(on) = surface {
                    let (start, keep_in) = above(on);
                    Method::Drop { region: region.unwrap_or(start), keep_in: Some(keep_in) }
                } else {
                    Method::Drop { region: region.ok_or_else(region_needed)?, keep_in: None }
                }
            }
            PlaceMethod::Stack => {
                let (start, _) = match (region, surface) {
                    (Some(region), _) => (region, region),
                    (None, Some(on)) => above(on),
                    (None, None) => return Err(region_needed()),
                };
                let middle = (start.min + start.max) / 2.0;
                Method::Stack { position: DVec3 { y: start.min.y, ..middle } }
            }
        })
    }
}

fn region(d: &RegionDescription) -> Region {
    Region { min: d.min_m.into(), max: d.max_m.into() }
}

/// Index of the object with this name.
fn named(name: &str, obstacles: &[(String, Fixed)]) -> Result<usize, Invalid> {
    obstacles.iter().position(|(other, _)| other == name).ok_or_else(|| {
        let names: Vec<&str> =
            obstacles.iter().map(|(name, _)| name.as_str()).filter(|name| !name.is_empty()).collect();
        let message = format!("the capture has no object {name:?}{}", did_you_mean(name, names.iter().copied()));
        let help = match names[..] {
            [] => "the capture has no objects".to_owned(),
            _ => format!("its objects are {}", list(name, names)),
        };
        Invalid::new("surface", message).help(help)
    })
}

/// Checks a table as far as that is possible without the capture.
fn check(d: &PlaceDescription) -> Result<(), Invalid> {
    if d.objects.is_empty() {
        return Err(Invalid::new("objects", "has no files").help("for example objects = [\"models/*.glb\"]"));
    }
    if let Some([least, most]) = d.count.map(|count| count.range())
        && least > most
    {
        return Err(Invalid::new("count", format!("{least} is above {most}")).help("write the smaller number first"));
    }
    for (key, range, what, example) in [
        ("scale", d.scale, "two factors", "[0.8, 1.2]"),
        ("size_m", d.size_m.map(|size| size.range()), "a length, or two,", "0.1, or [0.08, 0.12]"),
    ] {
        if let Some([small, large]) =
            range.filter(|[small, large]| !(*small > 0.0 && small <= large && large.is_finite()))
        {
            let message = format!("must be {what} above 0 in order, got {small} and {large}");
            return Err(Invalid::new(key, message).help(format!("for example {example}")));
        }
    }
    if d.frames == Some(0) {
        return Err(Invalid::new("frames", "must be at least 1, got 0"));
    }
    let is_dropped = matches!(d.method, PlaceMethod::Drop | PlaceMethod::Stack);
    let unused = [
        ("scale", d.scale.is_some() && d.size_m.is_some(), "cannot be combined with size_m"),
        ("bin", d.bin.is_some() && d.method != PlaceMethod::Drop, "is for method = \"drop\""),
        ("bin", d.bin.is_some() && d.surface.is_some(), "cannot be combined with surface"),
        ("surface", d.surface.is_some() && d.method == PlaceMethod::Box, "is not for method = \"box\""),
        (
            "rotation",
            d.rotation.is_some() && !matches!(d.method, PlaceMethod::Box | PlaceMethod::Surface),
            "is for method = \"box\" and \"surface\"; objects that lie or fall are turned as they come to rest",
        ),
        ("min_distance_m", d.min_distance_m.is_some() && is_dropped, "is not for objects that fall, which touch"),
        ("friction", d.friction.is_some() && !is_dropped, "is for method = \"drop\" and \"stack\""),
        ("restitution", d.restitution.is_some() && !is_dropped, "is for method = \"drop\" and \"stack\""),
    ];
    match unused.into_iter().find(|(_, is_wrong, _)| *is_wrong) {
        Some((key, _, message)) => Err(Invalid::new(key, message).help("remove it")),
        None => Ok(()),
    }
}

/// Object of a file as the capture states it, without a pose.
fn of_file(d: &PlaceDescription, file: &str) -> Map<String, Value> {
    let up = d.z_up.map(|z_up| ("up".to_owned(), if z_up { "z" } else { "y" }.into()));
    let unit = d.meters_per_unit.map(|unit| ("meters_per_unit".to_owned(), unit.into()));
    [("file".to_owned(), file.into())].into_iter().chain(up).chain(unit).collect()
}

/// Objects of a capture, as it states them.
fn own_objects(capture: &Capture) -> Result<Vec<Value>> {
    let objects = capture.value("scene.objects")?;
    Ok(objects.and_then(|objects| objects.as_array().cloned()).unwrap_or_default())
}

/// Name of an object in the capture of all files.
fn probe_name(number: usize) -> String {
    format!("placed-{number}")
}
