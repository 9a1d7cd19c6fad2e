//! Poses of the rig in each frame.

use glam::{DAffine3, DQuat, DVec2, DVec3};
use rand::RngExt;

use super::description::TimedPoseDescription;
use super::{GridPoses, PosesDescription, RandomPoses, RigCamera, TrajectoryPoses};
use photosite_core::Invalid;
use photosite_core::math::hash::hash64;
use photosite_core::math::philox::Philox;
use photosite_transport::geometry::{TimedPose, Trajectory};
use photosite_transport::scene::description::{look_at, looking};

/// Subject that poses are taken around.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Name of the subject in the capture.
    pub name: String,
    /// Pose of the subject: its own frame (x right, y down, z into the sheet, metres) → world.
    pub to_world: DAffine3,
    /// Points that must stay in the image, in the world, m.
    pub points: Vec<DVec3>,
}

impl Subject {
    /// Subject that is a point, looked at along the world's −z.
    fn point(position: DVec3) -> Self {
        let to_world = DAffine3::from_translation(position) * DAffine3::from_scale(DVec3::new(1.0, -1.0, -1.0));
        Self { name: String::new(), to_world, points: vec![position] }
    }

    /// Middle of the box around the subject's points, along its own axes; in the world, m.
    fn middle(&self) -> DVec3 {
        let inverse = self.to_world.inverse();
        let own = self.points.iter().map(|p| inverse.transform_point3(*p));
        let bounds = own
            .fold(None, |b: Option<(DVec3, DVec3)>, p| Some(b.map_or((p, p), |(low, high)| (low.min(p), high.max(p)))));
        let (low, high) = bounds.unwrap_or_default();
        self.to_world.transform_point3((low + high) / 2.0)
    }

    /// Unit direction in the world from the subject towards viewers of its front.
    fn front(&self) -> DVec3 {
        -self.to_world.matrix3.z_axis.normalize()
    }
}

/// Rig → world in each frame.
#[derive(Clone, Debug)]
pub(super) enum Poses {
    /// One pose for all frames.
    Fixed(DAffine3),
    /// Poses one after the other, repeated from the first.
    List(Vec<DAffine3>),
    /// Random views.
    Random(Around),
    /// Poses along a trajectory.
    Trajectory(CameraPath),
}

/// Ranges of views of a subject.
#[derive(Clone, Debug)]
pub(super) struct Around {
    subject: Subject,
    distance_m: [f64; 2],
    tilt_rad: [f64; 2],
    roll_rad: [f64; 2],
    margin_px: f64,
}

/// Trajectory in time.
#[derive(Clone, Debug)]
pub(super) struct CameraPath {
    pub(super) motion: Trajectory,
    pub(super) frame_rate_hz: f64,
    /// Duration from the first pose to the last, s.
    length_s: f64,
    pub(super) moving: bool,
    /// Zoom: focal length in mm by time in s; empty where it is constant.
    zoom: Vec<(f64, f64)>,
}

impl Poses {
    /// Checks a description. `start` is the pose of the capture's own camera.
    pub(super) fn new(d: &PosesDescription, subjects: &[Subject], start: DAffine3) -> Result<Self, Invalid> {
        let given = [
            ("list", d.list.is_some()),
            ("grid", d.grid.is_some()),
            ("random", d.random.is_some()),
            ("trajectory", d.trajectory.is_some()),
        ];
        let mut names = given.iter().filter(|(_, is_given)| *is_given).map(|(name, _)| *name);
        if let (Some(first), Some(second)) = (names.next(), names.next()) {
            return Err(Invalid::new(second, format!("cannot be combined with {first}")).help("keep one of them"));
        }
        if let Some(list) = &d.list {
            let pose = |(i, p): (usize, &super::PoseDescription)| {
                looking(p.position_m, p.look_at_m, p.up).map_err(|invalid| invalid.within(&format!("list[{i}]")))
            };
            if list.is_empty() {
                return Err(Invalid::new("list", "has no poses").help("write at least one"));
            }
            return Ok(Self::List(list.iter().enumerate().map(pose).collect::<Result<_, _>>()?));
        }
        if let Some(grid) = &d.grid {
            return grid_poses(grid, subjects).map(Self::List).map_err(|invalid| invalid.within("grid"));
        }
        if let Some(random) = &d.random {
            return Around::new(random, subjects).map(Self::Random).map_err(|invalid| invalid.within("random"));
        }
        if let Some(trajectory) = &d.trajectory {
            return CameraPath::new(trajectory).map(Self::Trajectory).map_err(|invalid| invalid.within("trajectory"));
        }
        Ok(Self::Fixed(start))
    }

    /// Number of frames that the poses determine by themselves.
    pub(super) fn count(&self) -> Option<usize> {
        match self {
            Self::List(poses) => Some(poses.len()),
            Self::Trajectory(way) => Some((way.length_s * way.frame_rate_hz).floor() as usize + 1),
            Self::Fixed(_) | Self::Random(_) => None,
        }
    }

    /// Time of a frame from the start of the first, s; `None` where frames have no times.
    pub(super) fn time_s(&self, frame: u32) -> Option<f64> {
        match self {
            Self::Trajectory(way) => Some(f64::from(frame) / way.frame_rate_hz),
            Self::Fixed(_) | Self::List(_) | Self::Random(_) => None,
        }
    }

    /// Focal length in a frame, mm; `None` where the poses do not zoom.
    pub(super) fn focal_length_mm(&self, frame: u32) -> Option<f64> {
        match self {
            Self::Trajectory(way) => way.focal_length_mm(frame),
            Self::Fixed(_) | Self::List(_) | Self::Random(_) => None,
        }
    }

    /// Rig → world in a frame. `seed` is used for poses alone.
    pub(super) fn pose(&self, seed: u64, frame: u32, cameras: &[RigCamera]) -> Result<DAffine3, Invalid> {
        match self {
            Self::Fixed(pose) => Ok(*pose),
            Self::List(poses) => Ok(poses[frame as usize % poses.len()]),
            Self::Random(around) => around.pose(seed, frame, cameras).map_err(|invalid| invalid.within("random")),
            Self::Trajectory(way) => Ok(way.motion.pose(&DAffine3::IDENTITY, f64::from(frame) / way.frame_rate_hz)),
        }
    }
}

/// Subject by the name of a target, or a point.
fn subject(target: Option<&String>, look_at_m: Option<[f64; 3]>, subjects: &[Subject]) -> Result<Subject, Invalid> {
    match (target, look_at_m) {
        (Some(_), Some(_)) => Err(Invalid::new("look_at_m", "cannot be combined with target").help("keep one of them")),
        (None, None) => {
            Err(Invalid::new("", "does not say what to look at")
                .help("write target = \"board\" or look_at_m = [0, 0, 0]"))
        }
        (None, Some(point)) => Ok(Subject::point(DVec3::from_array(point))),
        (Some(name), None) => subjects.iter().find(|s| s.name == *name).cloned().ok_or_else(|| {
            let names: Vec<_> = subjects.iter().map(|s| s.name.as_str()).collect();
            let help = if names.is_empty() {
                "the capture has no targets; write look_at_m instead".to_owned()
            } else {
                format!("its targets are {}", names.join(", "))
            };
            Invalid::new("target", format!("the capture has no target {name:?}")).help(help)
        }),
    }
}

fn grid_poses(grid: &GridPoses, subjects: &[Subject]) -> Result<Vec<DAffine3>, Invalid> {
    let subject = subject(grid.target.as_ref(), grid.look_at_m, subjects)?;
    let axes =
        [("azimuth_deg", &grid.azimuth_deg), ("elevation_deg", &grid.elevation_deg), ("distance_m", &grid.distance_m)];
    if let Some((key, _)) = axes.iter().find(|(_, values)| values.is_empty()) {
        return Err(Invalid::new(*key, "has no values").help("write at least one"));
    }
    if let Some(distance) = grid.distance_m.iter().find(|m| !(m.is_finite() && **m > 0.0)) {
        return Err(Invalid::new("distance_m", format!("must be above 0, got {distance}")));
    }
    let (middle, axes) = (subject.middle(), subject.to_world.matrix3);
    let [right, up, front] = [axes.x_axis.normalize(), -axes.y_axis.normalize(), subject.front()];
    let mut poses = Vec::new();
    for azimuth in grid.azimuth_deg.iter().map(|deg| deg.to_radians()) {
        for elevation in grid.elevation_deg.iter().map(|deg| deg.to_radians()) {
            for distance in &grid.distance_m {
                let level = front * azimuth.cos() + right * azimuth.sin();
                let towards = level * elevation.cos() + up * elevation.sin();
                // Straight from above there is no telling what is up but by going on over the top.
                let upright = up * elevation.cos() - level * elevation.sin();
                let pose = look_at(middle + towards * *distance, middle, upright);
                poses.push(pose.ok_or_else(|| Invalid::new("", "there is no such view"))?);
            }
        }
    }
    Ok(poses)
}

impl Around {
    fn new(d: &RandomPoses, subjects: &[Subject]) -> Result<Self, Invalid> {
        let ordered = |key: &str, [low, high]: [f64; 2], lowest: f64, highest: f64| {
            if low.is_finite() && high.is_finite() && lowest <= low && low <= high && high <= highest {
                return Ok([low, high]);
            }
            let message = format!("must be two numbers from {lowest} to {highest} in order, got {low} and {high}");
            Err(Invalid::new(key, message))
        };
        let margin_px = d.margin_px.unwrap_or(5.0);
        if !(margin_px.is_finite() && margin_px >= 0.0) {
            return Err(Invalid::new("margin_px", format!("must be 0 or above, got {margin_px}")));
        }
        let radians = |range: [f64; 2]| range.map(f64::to_radians);
        Ok(Self {
            subject: subject(d.target.as_ref(), d.look_at_m, subjects)?,
            distance_m: ordered("distance_m", d.distance_m, f64::MIN_POSITIVE, f64::MAX)?,
            tilt_rad: radians(ordered("tilt_deg", d.tilt_deg.unwrap_or([0.0, 45.0]), 0.0, 89.0)?),
            roll_rad: radians(ordered("roll_deg", d.roll_deg.unwrap_or([-10.0, 10.0]), -360.0, 360.0)?),
            margin_px,
        })
    }

    /// Draws a view at random. The middle of the subject is sent to a point of the first camera's image, moved towards
    /// its middle until all points are in all images; points of successive frames are spread evenly
    /// ([Roberts18](photosite_core::references#roberts18)).
    fn pose(&self, seed: u64, frame: u32, cameras: &[RigCamera]) -> Result<DAffine3, Invalid> {
        const VIEWS: usize = 1000;
        let Some(first) = cameras.first() else { return Err(Invalid::new("", "there is no camera")) };
        let mut random = Philox::new(seed, u64::from(frame));
        let start = Philox::new(hash64(seed, 1), 0).random::<[f64; 2]>();
        // Powers of the plastic number's inverse.
        let step = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
        let place = DVec2::from_array([0, 1].map(|axis| (start[axis] + f64::from(frame) * step[axis]).fract()));
        let [width, height] = first.camera.resolution().map(f64::from);
        let centre = DVec2::new(width, height) / 2.0;
        let aim = DVec2::new(place.x * width, place.y * height);
        let (middle, axes) = (self.subject.middle(), self.subject.to_world.matrix3);
        let [right, up, front] = [axes.x_axis.normalize(), -axes.y_axis.normalize(), self.subject.front()];
        for _ in 0..VIEWS {
            let mut within = |[low, high]: [f64; 2]| low + (high - low) * random.random::<f64>();
            let (distance, tilt, roll) = (within(self.distance_m), within(self.tilt_rad), within(self.roll_rad));
            let (sin, cos) = within([0.0, std::f64::consts::TAU]).sin_cos();
            let towards = front * tilt.cos() + (right * cos + up * sin) * tilt.sin();
            let Some(straight) = look_at(middle + towards * distance, middle, up) else { continue };
            let rolled = straight * DAffine3::from_rotation_z(roll);
            for shrink in 0..24 {
                let pixel = centre + (aim - centre) * 0.85f64.powi(shrink);
                let Some(seen) = first.camera.seen(pixel) else { continue };
                // Turned so that this direction goes where the axis went.
                let turn = DQuat::from_rotation_arc(seen.direction.normalize(), DVec3::NEG_Z);
                let rig = rolled * DAffine3::from_quat(turn) * first.place.in_rig.inverse();
                if cameras.iter().all(|camera| self.is_within(&rig, camera)) {
                    return Ok(rig);
                }
            }
        }
        let message = format!("in none of {VIEWS} views do all cameras see all points");
        Err(Invalid::new("distance_m", message).help("write larger distances, or a smaller margin_px"))
    }

    fn is_within(&self, rig: &DAffine3, camera: &RigCamera) -> bool {
        let [width, height] = camera.camera.resolution().map(f64::from);
        let inverse = (*rig * camera.place.in_rig).inverse();
        let range = |size: f64| self.margin_px..=size - self.margin_px;
        self.subject.points.iter().all(|point| {
            let pixel = camera.camera.project_camera(inverse.transform_point3(*point));
            pixel.is_some_and(|p| range(width).contains(&p.x) && range(height).contains(&p.y))
        })
    }
}

impl CameraPath {
    fn new(d: &TrajectoryPoses) -> Result<Self, Invalid> {
        if !(d.frame_rate_hz.is_finite() && d.frame_rate_hz > 0.0) {
            return Err(Invalid::new("frame_rate_hz", format!("must be above 0, got {}", d.frame_rate_hz)));
        }
        let pose = |(i, p): (usize, &TimedPoseDescription)| {
            let to_world = looking(p.position_m, p.look_at_m, p.up).map_err(|e| e.within(&format!("poses[{i}]")))?;
            Ok(TimedPose::new(p.time_s, &to_world))
        };
        let poses = d.poses.iter().enumerate().map(pose).collect::<Result<Vec<_>, Invalid>>()?;
        let length_s = poses.last().map_or(0.0, |last| last.time_s - poses[0].time_s);
        let interpolation = d.interpolation.unwrap_or_default().into();
        Ok(Self {
            motion: Trajectory::through(poses, interpolation, "for a rig that stands still, write list")?,
            length_s,
            frame_rate_hz: d.frame_rate_hz,
            moving: d.moving.unwrap_or(true),
            zoom: zoom(&d.poses)?,
        })
    }

    /// Focal length at the start of a frame, mm; `None` where the trajectory does not zoom.
    pub(super) fn focal_length_mm(&self, frame: u32) -> Option<f64> {
        let time_s = f64::from(frame) / self.frame_rate_hz;
        let next = self.zoom.partition_point(|(time, _)| *time <= time_s);
        let (before, after) = (self.zoom.get(next.saturating_sub(1))?, self.zoom.get(next).or(self.zoom.last())?);
        let span = after.0 - before.0;
        let part = if span > 0.0 { ((time_s - before.0) / span).max(0.0) } else { 0.0 };
        Some(before.1 + (after.1 - before.1) * part)
    }
}

/// Focal lengths of a trajectory's poses, which either all have one or none.
fn zoom(poses: &[TimedPoseDescription]) -> Result<Vec<(f64, f64)>, Invalid> {
    let Some(first) = poses.iter().position(|pose| pose.focal_length_mm.is_some()) else { return Ok(Vec::new()) };
    let at = |(i, pose): (usize, &TimedPoseDescription)| match pose.focal_length_mm {
        Some(mm) if mm.is_finite() && mm > 0.0 => Ok((pose.time_s, mm)),
        Some(mm) => Err(Invalid::new(format!("poses[{i}].focal_length_mm"), format!("must be above 0, got {mm}"))),
        None => {
            Err(Invalid::new(format!("poses[{i}].focal_length_mm"), format!("missing, where poses[{first}] has one"))
                .help("write the focal length of every pose, or of none"))
        }
    };
    poses.iter().enumerate().map(at).collect()
}
