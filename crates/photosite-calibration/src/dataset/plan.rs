//! Plan of a data set: the changes to the capture in each frame.

use std::collections::BTreeSet;

use glam::{DAffine3, DVec3};

use super::poses::{CameraPath, Poses};
use super::rig::{RigCamera, RigPlace};
use super::toml_value::{self, list, number, toml};
use super::variation::{Found, Variation};
use super::{DatasetDescription, Subject};
use photosite_core::Invalid;
use photosite_core::math::hash::hash64;
use photosite_transport::scene::description::looking;

/// Folder of the calibration files of all cameras, beside those of the cameras; no camera may have this name.
pub const CALIBRATION_FOLDER: &str = "calibration";

/// Changes of all frames, made before all others: images keep the distortion of the lens and the grid of the sensor, so
/// that points are where ground truth has them.
const AS_TAKEN: [&str; 2] = ["develop.distortion=false", "develop.square_pixels=false"];

/// Plan: everything that frames are made from.
#[derive(Clone, Debug)]
pub struct Plan {
    seed: u64,
    cameras: Vec<RigCamera>,
    poses: Poses,
    /// Whether the capture's own camera pose is kept.
    keeps_pose: bool,
    variations: Vec<Variation>,
    /// Whether the variations set the time at which the scene is seen.
    varies_time: bool,
    frames: u32,
}

/// Purpose of a seed.
#[derive(Clone, Copy)]
enum Purpose {
    Light,
    Poses,
    Variation,
    Places,
}

impl Plan {
    /// Checks a description against the rig and its subjects, and plans it. `start` is camera → world of the capture,
    /// `found` the matches of each variation's patterns.
    pub fn new(
        description: &DatasetDescription,
        cameras: Vec<RigCamera>,
        subjects: &[Subject],
        start: DAffine3,
        found: &[Found],
    ) -> Result<Self, Invalid> {
        let poses = match &description.poses {
            None => Poses::Fixed(start),
            Some(poses) => Poses::new(poses, subjects, start).map_err(|invalid| invalid.within("poses"))?,
        };
        let variation = |(i, (d, found))| {
            Variation::new(d, found, description.sampling).map_err(|invalid| invalid.within(&format!("vary[{i}]")))
        };
        let variations = description.vary.iter().zip(found).enumerate().map(variation);
        let variations: Vec<Variation> = variations.collect::<Result<_, _>>()?;
        check_variations(&variations, &cameras)?;
        let zooming = variations.iter().position(|variation| variation.keys().any(|key| key == FOCAL_LENGTH));
        if let (Some(i), Some(_)) = (zooming, poses.focal_length_mm(0)) {
            let message = format!("{FOCAL_LENGTH}: poses.trajectory says what it is in each frame");
            return Err(Invalid::new(format!("vary[{i}].key"), message).help("remove one of them"));
        }
        let is_time = |key: &str| key == TIME || key.ends_with(ANIMATION_TIME);
        let varies_time = variations.iter().any(|variation| variation.keys().any(is_time));
        let frames = match (description.frames, poses.count()) {
            (Some(0), _) => return Err(Invalid::new("frames", "must be at least 1, got 0")),
            (Some(frames), _) => frames,
            (None, count) => u32::try_from(count.unwrap_or(1)).unwrap_or(u32::MAX),
        };
        Ok(Self {
            seed: u64::from(description.seed.unwrap_or(0)),
            keeps_pose: matches!(poses, Poses::Fixed(_))
                && cameras.iter().all(|c| c.place.in_rig == DAffine3::IDENTITY),
            cameras,
            poses,
            variations,
            varies_time,
            frames,
        })
    }

    /// Number of frames.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// Cameras of the rig.
    pub fn cameras(&self) -> &[RigCamera] {
        &self.cameras
    }

    /// Varied keys, each once.
    pub fn varied_keys(&self) -> BTreeSet<&str> {
        self.variations.iter().flat_map(Variation::keys).collect()
    }

    /// Time of a frame from the start of the first, s; along a trajectory alone.
    pub fn time_s(&self, number: u32) -> Option<f64> {
        self.poses.time_s(number)
    }

    /// Plans a frame: for each camera of the rig, all overrides of the capture. Those of `arguments` come after those
    /// of the description, and before those that make the image unique: serial number, seed, the next frame.
    pub fn frame(&self, number: u32, arguments: &[String]) -> Result<Vec<Vec<String>>, Invalid> {
        let now = self.described(number)?;
        let flows = self.cameras.iter().any(|camera| camera.flows);
        let next = if flows && number + 1 < self.frames { Some(self.described(number + 1)?) } else { None };
        let of_camera = |(index, described): (usize, Vec<String>)| {
            let camera = &self.cameras[index];
            let after = next.as_ref().map(|next| changes(&described, &next[index], arguments));
            let mut set: Vec<String> = described.into_iter().chain(arguments.iter().cloned()).collect();
            if camera.flows {
                set.push(format!(
                    "output.truth_next={}",
                    after.map_or("false".to_owned(), |changes| toml(&changes.into()))
                ));
            }
            // A camera alone has the serial number that its capture says.
            let is_alone = self.cameras.len() == 1;
            let varies = self.variations.iter().any(|variation| variation.keys().any(|key| key == SERIAL));
            if !is_alone && (!varies || arguments.iter().any(|argument| names_serial(argument))) {
                set.push(format!("{SERIAL}={}", camera.serial));
            }
            set.push(format!("{SEED}={}", self.seed_of(index, number)));
            set
        };
        Ok(now.into_iter().enumerate().map(of_camera).collect())
    }

    /// Seed of an image's light and temporal noise, in as many bits as a JSON number holds. Another seed in the capture
    /// makes other ones.
    fn seed_of(&self, camera: usize, number: u32) -> u64 {
        let seed = hash64(self.seed_for(Purpose::Light, camera), u64::from(number));
        let stated = self.cameras[camera].seed;
        (if stated == 0 { seed } else { hash64(seed, stated) }) >> 11
    }

    /// Seed of the places that a `[[place]]` table gives in a frame.
    pub fn places_seed(&self, table: usize, number: u32) -> u64 {
        hash64(self.seed_for(Purpose::Places, table), u64::from(number))
    }

    /// Overrides of a frame by the description: the same keys in the same order in each frame.
    fn described(&self, number: u32) -> Result<Vec<Vec<String>>, Invalid> {
        let poses_seed = self.seed_for(Purpose::Poses, 0);
        let rig = self.poses.pose(poses_seed, number, &self.cameras).map_err(|e| e.within("poses"))?;
        let of_camera = |(index, camera): (usize, &RigCamera)| {
            let mut set: Vec<String> = camera.place.set.clone();
            match &self.poses {
                _ if self.keeps_pose => {}
                Poses::Trajectory(way) if way.moving => set.extend(on_the_way(way, number, camera)),
                Poses::Fixed(_) | Poses::List(_) | Poses::Random(_) | Poses::Trajectory(_) => {
                    set.extend(
                        pose_keys(&(rig * camera.place.in_rig)).map(|(key, value)| format!("camera.{key}={value}")),
                    );
                }
            }
            // What moves by itself goes on from frame to frame, unless the description says when each begins.
            if let Some(time_s) = self.poses.time_s(number).filter(|_| camera.scene_moves && !self.varies_time) {
                set.push(format!("{TIME}={}", toml_value::number(time_s)));
            }
            set.extend(
                self.poses.focal_length_mm(number).map(|mm| format!("{FOCAL_LENGTH}={}", toml_value::number(mm))),
            );
            for (i, variation) in self.variations.iter().enumerate() {
                set.extend(variation.set(self.seed_for(Purpose::Variation, i), number, self.frames, index));
            }
            set
        };
        Ok(self.cameras.iter().enumerate().map(of_camera).collect())
    }

    fn seed_for(&self, purpose: Purpose, which: usize) -> u64 {
        hash64(hash64(self.seed, purpose as u64), which as u64)
    }
}

/// Key of the time at which the scene is seen.
const TIME: &str = "scene.time_s";
/// End of the keys that set the time of an animation.
const ANIMATION_TIME: &str = "animation_time_s";
/// Key that zoom changes.
const FOCAL_LENGTH: &str = "lens.focal_length_mm";
/// Key of the serial number, which the fixed pattern follows from.
const SERIAL: &str = "sensor.serial";
/// Key of the seed of light and temporal noise.
const SEED: &str = "render.seed";

/// Refuses variations of keys that cannot be varied so.
fn check_variations(variations: &[Variation], cameras: &[RigCamera]) -> Result<(), Invalid> {
    let is_pair = cameras.iter().any(|camera| camera.place.partner.is_some());
    let keys = |(i, variation)| Variation::keys(variation).map(move |key| (i, variation, key));
    for (i, variation, key) in variations.iter().enumerate().flat_map(keys) {
        let refuse = |of_table: &str, message: &str, help: &str| {
            Err(Invalid::new(format!("vary[{i}].{of_table}"), format!("{key}: {message}")).help(help))
        };
        if key == SEED {
            let message = "every image has a seed of its own, made from the data set's";
            return refuse("key", message, "remove it; for other noise write seed = 1, without a table");
        }
        if key == SERIAL && cameras.len() > 1 && !variation.is_per_camera() {
            return refuse(
                "per_camera",
                "all cameras of the rig would have the same serial number",
                "add per_camera = true",
            );
        }
        let decides_geometry =
            ["lens.", "sensor.resolution_px", "sensor.pixel_pitch_um", "sensor.format", "sensor.preset"];
        let parts_pair = decides_geometry.iter().any(|start| key.starts_with(start));
        if is_pair && variation.is_per_camera() && parts_pair {
            let message = "disparity needs two cameras of one kind, and these would differ";
            return refuse("per_camera", message, "remove per_camera, or disparity_to of the cameras");
        }
    }
    Ok(())
}

/// Changes that turn a capture into that of the next frame, as far as flow is concerned: the changes in `next` that
/// differ from `now`, and those of the arguments, which come after, to the same tables.
fn changes(now: &[String], next: &[String], arguments: &[String]) -> Vec<String> {
    let table = |argument: &String| argument.split(['.', '=']).next().unwrap_or_default().trim().to_owned();
    let is_in_view = |argument: &&String| {
        let aside = ["lights.", "render.", "develop.", "output.", "scene.environment"];
        !aside.iter().any(|key| argument.trim_start().starts_with(key))
    };
    let differing = now.iter().zip(next).filter(|(now, next)| now != next).map(|(_, next)| next);
    let differing: Vec<&String> = differing.filter(is_in_view).collect();
    let tables: BTreeSet<String> = differing.iter().map(|change| table(change)).collect();
    let after = arguments.iter().filter(is_in_view).filter(|argument| tables.contains(&table(argument)));
    differing.into_iter().chain(after).cloned().collect()
}

/// Whether a `key=value` names the serial number, by itself or in the table of the sensor.
fn names_serial(argument: &str) -> bool {
    let Some((key, value)) = argument.split_once('=') else { return false };
    match key.trim() {
        SERIAL => true,
        "sensor" => {
            format!("sensor = {value}").parse::<toml::Table>().is_ok_and(|t| t["sensor"].get("serial").is_some())
        }
        _ => false,
    }
}

impl DatasetDescription {
    /// Cameras of the rig with their places; names are checked.
    pub fn rig(&self) -> Result<Vec<RigPlace>, Invalid> {
        let set_in_all = || AS_TAKEN.into_iter().map(str::to_owned).chain(self.set.iter().cloned());
        if self.cameras.is_empty() {
            let (name, set) = ("camera".to_owned(), set_in_all().collect());
            let place = RigPlace { name, in_rig: DAffine3::IDENTITY, partner: None, set, is_numbered: true };
            return Ok(vec![place]);
        }
        let mut names = BTreeSet::new();
        let mut rig = Vec::new();
        for (i, d) in self.cameras.iter().enumerate() {
            let at = |invalid: Invalid| invalid.within(&format!("cameras[{i}]"));
            let is_folder = !d.name.is_empty()
                && d.name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c))
                && d.name != CALIBRATION_FOLDER;
            if !is_folder {
                let help = "letters, digits, - and _ make folders everywhere";
                return Err(at(Invalid::new("name", format!("{:?} is not a name for a folder", d.name)).help(help)));
            }
            if !names.insert(d.name.to_ascii_lowercase()) {
                return Err(at(Invalid::new("name", format!("two cameras are called {:?}", d.name))));
            }
            let position = d.position_m.unwrap_or_default();
            let [x, y, z] = position;
            let in_rig = looking(position, d.look_at_m.unwrap_or([x, y, z - 1.0]), d.up).map_err(at)?;
            let partner = d.disparity_to.as_ref().map(|name| {
                self.cameras
                    .iter()
                    .position(|other| other.name == *name && *name != d.name)
                    .ok_or_else(|| at(Invalid::new("disparity_to", format!("the rig has no other camera {name:?}"))))
            });
            let set = set_in_all().chain(d.set.iter().cloned()).collect();
            rig.push(RigPlace {
                name: d.name.clone(),
                in_rig,
                partner: partner.transpose()?,
                set,
                is_numbered: d.set.iter().any(|argument| names_serial(argument)),
            });
        }
        let places: Vec<DAffine3> = rig.iter().map(|place| place.in_rig).collect();
        let has_pair = rig.iter().any(|place| place.partner.is_some());
        for place in &mut rig {
            let Some(partner) = place.partner else {
                // Of those that the others are asked for, disparity is not.
                place.set.extend(has_pair.then(|| "output.truth_partner=false".to_owned()));
                continue;
            };
            place.set_partner(&places[partner]);
        }
        Ok(rig)
    }
}

impl RigPlace {
    /// Changes the capture so that disparity leads to a camera at that place in the rig.
    pub fn set_partner(&mut self, partner_in_rig: &DAffine3) {
        const KEY: &str = "output.truth_partner=";
        let keys = pose_keys(&(self.in_rig.inverse() * *partner_in_rig)).map(|(key, value)| format!("{key} = {value}"));
        self.set.retain(|change| !change.starts_with(KEY));
        self.set.push(format!("{KEY}{{ {} }}", keys.join(", ")));
    }
}

/// Keys of a pose, with their values in TOML.
fn pose_keys(to_world: &DAffine3) -> [(&'static str, String); 3] {
    let DAffine3 { matrix3, translation } = *to_world;
    [
        ("position_m", vector(translation)),
        ("look_at_m", vector(translation - matrix3.z_axis)),
        ("up", vector(matrix3.y_axis)),
    ]
}

/// Trajectory keys of a camera from the start of a frame to the end of the next.
fn on_the_way(way: &CameraPath, frame: u32, camera: &RigCamera) -> [String; 2] {
    // Between two of these the camera goes straight. On its turns it is off its way by (angle)²/8 of the distance to
    // the middle of the rig: a millionth where it turns by a twentieth of a radian.
    const STEPS: u32 = 32;
    let interval = 1.0 / way.frame_rate_hz;
    let pose = |step: u32| {
        let time = 2.0 * interval * f64::from(step) / f64::from(STEPS);
        let rig = way.motion.pose(&DAffine3::IDENTITY, f64::from(frame) * interval + time);
        let keys = pose_keys(&(rig * camera.place.in_rig)).map(|(key, value)| format!("{key} = {value}"));
        format!("{{ time_s = {}, {} }}", number(time), keys.join(", "))
    };
    let poses: Vec<String> = (0..=STEPS).map(pose).collect();
    [
        format!("camera.motion={{ poses = [{}] }}", poses.join(", ")),
        format!("exposure.frame_interval_s={}", number(interval)),
    ]
}

fn vector(v: DVec3) -> String {
    list(v.to_array())
}
