//! Tracing of ground truth: one ray a pixel, and the values of the surface that it meets.

use glam::{DAffine3, DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::albedo::albedo;
use super::{NotFound, TruthLayer, TruthObject, View};
use photosite_core::image::Planes;
use photosite_transport::geometry::{Hit, SurfacePoint};
use photosite_transport::optics::Camera;

/// Job of ground truth: the image and those that it leads to.
#[derive(Clone, Copy)]
pub struct TruthJob<'a> {
    /// The image itself.
    pub view: View<'a>,
    /// The objects of its scene, for layers in their frames.
    pub objects: &'a [TruthObject],
    /// The next image, for [`TruthLayer::Flow`]. Its scene may be another, of the [same
    /// surfaces](photosite_transport::scene::Scene::hit_in).
    pub next: Option<View<'a>>,
    /// The image of the partner, for [`TruthLayer::Disparity`].
    pub partner: Option<View<'a>>,
}

impl<'a> TruthJob<'a> {
    /// The job, counting the points that its views do not find.
    #[must_use]
    pub fn counting(self, not_found: &'a NotFound) -> Self {
        let counting = |view: View<'a>| view.counting(not_found);
        Self { view: counting(self.view), next: self.next.map(counting), partner: self.partner.map(counting), ..self }
    }
}

/// The planes of the layers that are asked for, in their order. A camera that moves is taken as it stands in the middle
/// of the exposure of each row.
pub fn truth(job: &TruthJob<'_>, layers: &[TruthLayer]) -> Planes {
    let [width, height] = job.view.grid.resolution.map(|n| n as usize);
    let names = || layers.iter().flat_map(|layer| layer.channels().iter().copied());
    let mut planes = Planes::zeros(width, height, names());
    // The planes side by side, in rows.
    let mut rows: Vec<Vec<&mut [f32]>> = (0..height).map(|_| Vec::with_capacity(names().count())).collect();
    for channel in planes.channels_mut() {
        rows.iter_mut().zip(channel.data.chunks_mut(width)).for_each(|(row, part)| row.push(part));
    }
    rows.into_par_iter().enumerate().for_each(|(y, mut row)| {
        let grid = &job.view.grid;
        let camera = job.view.camera.at_row(grid.on_sensor(grid.centre([0, y])).y - 0.5);
        let mut values = vec![0.0; row.len()];
        for x in 0..width {
            let seen = Seen::through(job, &camera, grid.centre([x, y]), (y * width + x) as u64);
            let mut rest = &mut values[..];
            for &layer in layers {
                let (own, after) = rest.split_at_mut(layer.channels().len());
                match &seen {
                    Some(seen) => seen.write(layer, own),
                    None => own.fill(layer.nothing()),
                }
                rest = after;
            }
            row.iter_mut().zip(&values).for_each(|(part, &value)| part[x] = value);
        }
    });
    planes
}

/// Surface that a pixel sees.
struct Seen<'a> {
    job: &'a TruthJob<'a>,
    camera: &'a Camera,
    pixel: DVec2,
    key: u64,
    hit: Hit,
    point: SurfacePoint,
    /// Unit direction to the camera.
    wo: Vec3,
}

impl<'a> Seen<'a> {
    fn through(job: &'a TruthJob<'a>, camera: &'a Camera, pixel: DVec2, key: u64) -> Option<Self> {
        let ray = camera.chief_ray(job.view.grid.on_sensor(pixel))?;
        let hit = job.view.scene.closest(&ray)?;
        let wo = -ray.direction.normalize();
        Some(Self { job, camera, pixel, key, hit, point: job.view.scene.point(&hit, ray.time), wo })
    }

    fn write(&self, layer: TruthLayer, to: &mut [f32]) {
        let towards_camera = |n: Vec3| if self.point.geometric_normal.dot(self.wo) < 0.0 { -n } else { n };
        let vector = |to: &mut [f32], v: Vec3| to.copy_from_slice(&v.to_array());
        let scene = self.job.view.scene;
        match layer {
            TruthLayer::Depth => to[0] = -self.in_camera().z as f32,
            TruthLayer::Distance => to[0] = self.in_camera().length() as f32,
            TruthLayer::Position => vector(to, self.point.position),
            TruthLayer::Normal => vector(to, towards_camera(self.point.geometric_normal)),
            TruthLayer::ShadingNormal => vector(to, towards_camera(self.point.shading_normal)),
            TruthLayer::Uv => {
                let uv = self.point.uv(scene.geometry(), 0);
                to.copy_from_slice(&uv.to_array());
            }
            TruthLayer::Albedo => {
                vector(to, albedo(scene, &self.point, self.wo, self.key).as_vec3());
            }
            TruthLayer::ObjectPosition => vector(to, self.in_object().1.as_vec3()),
            TruthLayer::Nocs => {
                let (object, position) = self.in_object();
                vector(to, object.nocs(position).as_vec3());
            }
            TruthLayer::Instance => to[0] = number(scene.object(&self.hit)),
            TruthLayer::Material => to[0] = number(self.point.material),
            TruthLayer::Flow => self.write_way(self.job.next.as_ref(), 1.0, to),
            TruthLayer::Disparity => {
                let partner = self.job.partner.as_ref();
                self.write_way(partner, partner.map_or(1.0, |partner| disparity_sign(&partner.place)), to);
            }
        }
    }

    /// Writes `sign` times the way from the pixel to where another view has the point, and whether it is visible there.
    /// Nothing is visible in a view that there is not.
    fn write_way(&self, other: Option<&View<'_>>, sign: f64, to: &mut [f32]) {
        let found = other.and_then(|view| view.correspondence(&self.job.view.scene.hit_in(&self.hit, view.scene)?));
        let way = found.map_or(DVec2::ZERO, |found| (found.pixel - self.pixel) * sign).as_vec2();
        let visible = found.is_some_and(|found| found.visible);
        to.copy_from_slice(&[way.x, way.y, f32::from(u8::from(visible))]);
    }

    /// The object that the point is of, and the point in its frame, m.
    fn in_object(&self) -> (&'a TruthObject, DVec3) {
        let object = &self.job.objects[self.job.view.scene.object(&self.hit) as usize];
        let to_frame = object.to_world(self.point.time.into()).inverse();
        (object, to_frame.transform_point3(self.point.position.as_dvec3()))
    }

    /// The point in camera space, m.
    fn in_camera(&self) -> DVec3 {
        self.camera.to_world().inverse().transform_point3(self.point.position.as_dvec3())
    }
}

/// The sign that makes disparity positive: −1 for the way to a partner that stands to the right, in whose image
/// things lie farther to the left, or below; 1 for one to the left or above. `place` is partner → camera (x right, y
/// up).
fn disparity_sign(place: &DAffine3) -> f64 {
    let DVec3 { x, y, .. } = place.translation;
    let towards = if x.abs() >= y.abs() { x } else { -y };
    if towards < 0.0 { 1.0 } else { -1.0 }
}

/// Number of an index in a plane: from 1 on, as 0 is for nothing.
fn number(index: u32) -> f32 {
    (index + 1) as f32
}
