//! Matt surfaces, eight at a time: where paths come to surfaces that scatter by Lambert's law, they all do the same, and each
//! lane of a register does it for one of them.
//!
//! What depends on tables, the numbers, the choice of a light and all that is spectral, is done for one after the other. Formulas
//! are those of single paths ([`Real`](photosite_core::math::Real)), so that a path brings the same bits alone and in a lane.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::{Path, PathLimits, Postponed, Vertex, towards_light};
use crate::bsdf::{Bsdf, GRAZING};
use crate::geometry::{Geometry, Hit, Primitive, Ray, SurfacePoint, interpolate, offset, on_triangle};
use crate::light::{Choice, Facets, Facing, Receiver};
use crate::sampler::Sampler;
use crate::scene::{ColourSource, EDGE_ON, Scene, Shading};
use photosite_core::math::pdf::power_heuristic;
use photosite_core::math::{Frame, Pdf, Vector, frame, warp};
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};
use photosite_simd::{LaneMask, Lanes, Real, Simd, Vectors, WithSimd, dispatch};

/// Lanes.
const WIDTH: usize = 8;

/// Paths that have come to matt surfaces, up to [`WIDTH`] of them.
pub(in super::super) struct MattSurfaces {
    // Each is made where it stays: copying what was just written in parts would wait for that to reach the memory.
    arrivals: [Arrival; WIDTH],
    /// Number of paths that have come, which are the first of the arrivals.
    count: usize,
    meetings: Meetings,
    looks: Looks,
}

/// A path that has come to a matt surface.
#[derive(Clone, Copy)]
struct Arrival {
    /// Of the path.
    number: u32,
    ray: Ray,
    hit: Hit,
    reflectance: ColourSource,
}

/// Where paths meet triangles.
#[derive(Default)]
struct Meetings {
    corners: [Vectors; 3],
    /// Shading normals at the corners, zero where a mesh has none.
    normals: [Vectors; 3],
    /// Bit i is set where they are not zero in lane i.
    has_normals: u32,
    barycentric: [[f32; WIDTH]; 2],
    /// Back along the paths, unit vectors.
    wo: Vectors,
}

/// Points of surfaces.
struct Points {
    position: Vectors,
    error: Vectors,
    geometric_normal: Vectors,
    /// That by which light scatters, on the side that the paths have come from.
    normal: Vectors,
    /// Bit i is set where the surface of lane i is not seen edge-on.
    is_seen: u32,
}

/// What surfaces look at, and numbers for where they scatter to.
#[derive(Default)]
struct Looks {
    /// Bit i is set where lane i looks at a light.
    has_light: u32,
    /// Handles of the lights.
    lights: [u32; WIDTH],
    /// Those that are triangles which stay where they are.
    facets: Facets,
    /// Bit i is set where lane i looks at a facet.
    is_facet: u32,
    /// Bit i is set where the facet of lane i shines on both sides.
    two_sided: u32,
    /// Of the choice of the light.
    probability: [f32; WIDTH],
    u_light: [[f32; WIDTH]; 2],
    u_scatter: [[f32; WIDTH]; 2],
}

/// Light from facets.
struct Lit {
    /// Bit i is set where light may come to lane i.
    is_lit: u32,
    /// Where on the facet.
    barycentric: [[f32; WIDTH]; 2],
    /// Cosine at the surface over the density of the look.
    cos_over_pdf: [f32; WIDTH],
    weight: [f32; WIDTH],
    shadow_origin: Vectors,
    shadow_direction: Vectors,
}

/// Where paths go on.
struct Scattered {
    /// Bit i is set where the path of lane i goes on.
    goes_on: u32,
    origin: Vectors,
    wi: Vectors,
    pdf: [f32; WIDTH],
    /// Cosine over density.
    cos_over_pdf: [f32; WIDTH],
}

impl MattSurfaces {
    /// None yet.
    pub(in super::super) fn new() -> Self {
        Self { arrivals: [Arrival::NONE; WIDTH], count: 0, meetings: Meetings::default(), looks: Looks::default() }
    }

    /// Whether there is no room for another.
    #[inline]
    pub(in super::super) fn is_full(&self) -> bool {
        self.count == WIDTH
    }

    /// Takes the path with this number in, if it has come to such a surface.
    #[inline]
    pub(in super::super) fn take(
        &mut self,
        number: u32,
        path: &Path,
        (ray, hit): (&Ray, Option<&Hit>),
        scene: &Scene,
        limits: &PathLimits,
    ) -> bool {
        let Some(hit) = hit.filter(|_| path.is_plain(limits)) else { return false };
        let Some(reflectance) = scene.matt_surface(hit) else { return false };
        let lane = self.count % WIDTH;
        self.meetings.set(lane, ray, hit, scene.geometry());
        self.arrivals[lane] = Arrival { number, ray: *ray, hit: *hit, reflectance };
        self.count += 1;
        true
    }

    /// Does for all that were taken in what [`Path::advance`] does for one, and lets go of them. `go_on` gets the rays along
    /// which paths go on.
    pub(in super::super) fn advance(
        &mut self,
        paths: &mut [Path],
        scene: &Scene,
        limits: &PathLimits,
        sampler: &mut Sampler,
        postponed: &mut Postponed,
        mut go_on: impl FnMut(u32, Ray),
    ) {
        /// Fewer are faster one by one.
        const FEWEST: usize = 3;
        let is_worth_it = self.count >= FEWEST;
        let points = is_worth_it.then(|| points(&self.meetings));
        let seen = points.as_ref().map_or(0, |points| points.is_seen);
        for (_, arrival) in (0..).zip(self.arrivals()).filter(|(lane, _)| seen >> lane & 1 == 0) {
            let (number, way) = (arrival.number, (&arrival.ray, Some(arrival.hit)));
            let path = &mut paths[number as usize];
            if let Some(ray) = path.advance(number, way, scene, limits, sampler, postponed) {
                go_on(number, ray);
            }
        }
        if let Some(points) = points {
            self.look(&points, paths, scene, sampler);
            let lit = lit(&points, &self.meetings.wo, &self.looks);
            let scattered = scattered(&points, &self.meetings.wo, &self.looks.u_scatter);
            for (lane, arrival) in self.arrivals().iter().enumerate().filter(|(lane, _)| seen >> lane & 1 != 0) {
                let path = &mut paths[arrival.number as usize];
                path.depth += 1;
                let reflectance = arrival.reflectance(scene, &path.wavelengths);
                self.light(lane, reflectance, path, (&points, &lit), scene, postponed);
                if scattered.goes_on >> lane & 1 == 0 {
                    continue;
                }
                path.throughput *= reflectance * FRAC_1_PI * scattered.cos_over_pdf[lane];
                if path.throughput.is_black() {
                    continue;
                }
                path.scattered = Some((Pdf::new(scattered.pdf[lane]), points.receiver(lane)));
                sampler.resume(path.place);
                if path.survives(limits, sampler) {
                    let ray = Ray::new(scattered.origin.get(lane), scattered.wi.get(lane));
                    go_on(arrival.number, ray.at_time(arrival.ray.time));
                }
            }
        }
        self.count = 0;
    }

    /// Those that have come.
    #[inline]
    fn arrivals(&self) -> &[Arrival] {
        &self.arrivals[..self.count]
    }

    /// Chooses what those that are seen look at, and takes their numbers.
    fn look(&mut self, points: &Points, paths: &mut [Path], scene: &Scene, sampler: &mut Sampler) {
        let Self { arrivals, count, looks, .. } = self;
        (looks.has_light, looks.is_facet, looks.two_sided) = (0, 0, 0);
        let seen = || (0..*count).filter(|lane| points.is_seen >> lane & 1 != 0);
        // First the numbers of all: what depends on one of them would wait for it.
        for lane in seen() {
            let place = &mut paths[arrivals[lane].number as usize].place;
            sampler.resume(*place);
            [looks.u_light[0][lane], looks.u_light[1][lane]] = sampler.next_2d();
            sampler.skip();
            [looks.u_scatter[0][lane], looks.u_scatter[1][lane]] = sampler.next_2d();
            sampler.leave(place);
        }
        for lane in seen() {
            let choice = scene.choose_light(&points.receiver(lane), looks.u_light[0][lane]);
            let Some(Choice { light, probability, rest }) = choice else { continue };
            looks.has_light |= 1 << lane;
            looks.lights[lane] = light;
            looks.probability[lane] = probability;
            looks.u_light[0][lane] = rest;
            let Some((emitter, facet)) = scene.lights().still_triangle(light) else { continue };
            looks.facets.set(lane, facet);
            looks.is_facet |= 1 << lane;
            looks.two_sided |= u32::from(emitter.emission.two_sided) << lane;
        }
    }

    /// Postpones the light that the surface of a lane receives straight from the one it looks at, unless something is in the way
    /// of the ray.
    #[inline]
    fn light(
        &self,
        lane: usize,
        reflectance: SampledSpectrum,
        path: &Path,
        (points, lit): (&Points, &Lit),
        scene: &Scene,
        postponed: &mut Postponed,
    ) {
        let arrival = &self.arrivals[lane];
        if self.looks.has_light >> lane & 1 == 0 {
            return;
        }
        let light = self.looks.lights[lane];
        let Some((emitter, _)) = scene.lights().still_triangle(light) else {
            let [rest, v] = self.looks.u_light.map(|numbers| numbers[lane]);
            let choice = Choice { light, probability: self.looks.probability[lane], rest };
            let (receiver, time) = (points.receiver(lane), arrival.ray.time);
            let Some(light) = scene.sample_chosen_light(&choice, &receiver, time, v, &path.wavelengths) else { return };
            let point = arrival.point(lane, points, scene);
            let frame = Frame::from_normal(points.normal.get(lane));
            let shading = Shading { frame, bsdf: Bsdf::Diffuse { reflectance } };
            let vertex = Vertex::new(arrival.hit.t, &point, &shading, self.meetings.wo.get(lane));
            if let Some((ray, light)) = path.light_from(scene, &vertex, &light) {
                postponed.shadow_rays.push(ray);
                postponed.lights.push((arrival.number, path.throughput * light));
            }
            return;
        };
        if lit.is_lit >> lane & 1 == 0 {
            return;
        }
        let barycentric = lit.barycentric.map(|weights| weights[lane]);
        let radiance = scene.shining(emitter, barycentric, &path.wavelengths);
        let contribution = radiance * (reflectance * FRAC_1_PI) * lit.cos_over_pdf[lane];
        if contribution.is_black() {
            return;
        }
        let (origin, direction) = (lit.shadow_origin.get(lane), lit.shadow_direction.get(lane));
        postponed.shadow_rays.push(Ray { origin, direction, t_max: 1.0, time: arrival.ray.time });
        postponed.lights.push((arrival.number, path.throughput * (contribution * lit.weight[lane])));
    }
}

impl Arrival {
    /// That of no path.
    const NONE: Self = Self {
        number: 0,
        ray: Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, t_max: 0.0, time: 0.0 },
        hit: Hit { t: 0.0, uv: [0.0; 2], primitive: Primitive::Triangle(0), placement: 0 },
        reflectance: ColourSource::Texture { factor: [0.0; 3], texture: 0 },
    };

    #[inline]
    fn reflectance(&self, scene: &Scene, wavelengths: &Wavelengths) -> SampledSpectrum {
        scene.colour_at(self.reflectance, self.hit.primitive, self.hit.uv, wavelengths)
    }

    /// Its surface point, that of a lane.
    fn point(&self, lane: usize, points: &Points, scene: &Scene) -> SurfacePoint {
        let Hit { primitive, uv, .. } = self.hit;
        let mesh = scene.geometry().mesh_of(primitive);
        let geometric_normal = points.geometric_normal.get(lane);
        SurfacePoint {
            position: points.position.get(lane),
            error: points.error.get(lane),
            geometric_normal,
            shading_normal: points.normal.get(lane),
            tangent: Vec3::ZERO,
            handedness: 1.0,
            primitive,
            mesh,
            material: scene.geometry().meshes[mesh as usize].material,
            parameters: uv,
            time: self.ray.time,
        }
    }
}

impl Meetings {
    #[inline]
    fn set(&mut self, lane: usize, ray: &Ray, hit: &Hit, geometry: &Geometry) {
        let triangle = hit.primitive.triangle().expect("matt surfaces of triangles");
        let triangle = &geometry.triangles[triangle as usize];
        let mesh = &geometry.meshes[triangle.mesh as usize];
        for (corners, corner) in self.corners.iter_mut().zip(geometry.corners_of(triangle, mesh, ray.time)) {
            corners.set(lane, corner);
        }
        let normals = geometry.corner_normals(triangle, mesh, ray.time);
        if normals.is_some() || self.has_normals >> lane & 1 != 0 {
            self.has_normals = self.has_normals & !(1 << lane) | u32::from(normals.is_some()) << lane;
            for (normals, normal) in self.normals.iter_mut().zip(normals.unwrap_or_default()) {
                normals.set(lane, normal);
            }
        }
        [self.barycentric[0][lane], self.barycentric[1][lane]] = hit.uv;
        self.wo.set(lane, -ray.direction);
    }
}

impl Points {
    /// Who looks for light in a lane.
    #[inline]
    fn receiver(&self, lane: usize) -> Receiver {
        Receiver { point: self.position.get(lane), facing: Facing::Front(self.normal.get(lane)) }
    }
}

fn points(meetings: &Meetings) -> Points {
    dispatch(ToPoints { meetings })
}

/// The arguments of [`points_in`].
struct ToPoints<'a> {
    meetings: &'a Meetings,
}

impl WithSimd for ToPoints<'_> {
    type Output = Points;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Points {
        points_in(simd, self.meetings)
    }
}

#[inline(always)]
fn points_in<S: Simd>(simd: S, meetings: &Meetings) -> Points {
    let [a, b, c] = &meetings.corners;
    let barycentric = [simd.load(&meetings.barycentric[0]), simd.load(&meetings.barycentric[1])];
    let (position, error, across) = on_triangle([a.load(simd), b.load(simd), c.load(simd)], barycentric);
    let geometric_normal = across.normalize_or(across.broadcast(Vec3::ZERO));
    let mut normal = geometric_normal;
    if meetings.has_normals != 0 {
        let [a, b, c] = &meetings.normals;
        normal = interpolate([a.load(simd), b.load(simd), c.load(simd)], barycentric).normalize_or(geometric_normal);
    }
    let wo = meetings.wo.load(simd);
    normal = Vector::select(wo.dot(geometric_normal).lt(simd.broadcast(0.0)), -normal, normal);
    Points {
        position: Vectors::store(position),
        error: Vectors::store(error),
        geometric_normal: Vectors::store(geometric_normal),
        normal: Vectors::store(normal),
        is_seen: simd.broadcast(EDGE_ON).le(wo.dot(normal)).bits(),
    }
}

fn lit(points: &Points, wo: &Vectors, looks: &Looks) -> Lit {
    dispatch(ToLit { points, wo, looks })
}

/// The arguments of [`lit_in`].
struct ToLit<'a> {
    points: &'a Points,
    wo: &'a Vectors,
    looks: &'a Looks,
}

impl WithSimd for ToLit<'_> {
    type Output = Lit;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Lit {
        lit_in(simd, self.points, self.wo, self.looks)
    }
}

#[inline(always)]
fn lit_in<S: Simd>(simd: S, points: &Points, wo: &Vectors, looks: &Looks) -> Lit {
    let zero = simd.broadcast(0.0);
    let (position, geometric_normal) = (points.position.load(simd), points.geometric_normal.load(simd));
    let facet = looks.facets.load(simd);
    let barycentric = warp::uniform_triangle([simd.load(&looks.u_light[0]), simd.load(&looks.u_light[1])]);
    let sight = facet.sight(barycentric, position);
    let pdf = sight.density * simd.load(&looks.probability);
    let cos = points.normal.load(simd).dot(sight.wi);
    let is_above = simd.broadcast(GRAZING).lt(cos) & !crosses(wo.load(simd), sight.wi, geometric_normal);
    let is_lit = (zero.lt(pdf) & is_above).bits();
    let (front, back) = (zero.lt(sight.cos).bits(), sight.cos.lt(zero).bits());
    let scattered_pdf = cos * simd.broadcast(FRAC_1_PI);
    let weighted_cos = cos.abs();
    let origin = offset(position, points.error.load(simd), geometric_normal, sight.wi);
    let target = towards_light(sight.position, facet.normal, sight.wi);
    Lit {
        is_lit: is_lit & looks.is_facet & (front | back & looks.two_sided),
        barycentric: barycentric.map(store),
        cos_over_pdf: (weighted_cos / pdf).store(),
        weight: power_heuristic(pdf, scattered_pdf).store(),
        shadow_origin: Vectors::store(origin),
        shadow_direction: Vectors::store(target - origin),
    }
}

fn scattered(points: &Points, wo: &Vectors, u: &[[f32; WIDTH]; 2]) -> Scattered {
    dispatch(ToScattered { points, wo, u })
}

/// The arguments of [`scattered_in`].
struct ToScattered<'a> {
    points: &'a Points,
    wo: &'a Vectors,
    u: &'a [[f32; WIDTH]; 2],
}

impl WithSimd for ToScattered<'_> {
    type Output = Scattered;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Scattered {
        scattered_in(simd, self.points, self.wo, self.u)
    }
}

#[inline(always)]
fn scattered_in<S: Simd>(simd: S, points: &Points, wo: &Vectors, [u, v]: &[[f32; WIDTH]; 2]) -> Scattered {
    let local = warp::cosine_hemisphere([simd.load(u), simd.load(v)]);
    let (normal, geometric_normal) = (points.normal.load(simd), points.geometric_normal.load(simd));
    let [x, y] = frame::tangents(normal);
    let wi = x * local.x + y * local.y + normal * local.z;
    let pdf = local.z * simd.broadcast(FRAC_1_PI);
    let origin = offset(points.position.load(simd), points.error.load(simd), geometric_normal, wi);
    Scattered {
        goes_on: (simd.broadcast(GRAZING).lt(local.z) & !crosses(wo.load(simd), wi, geometric_normal)).bits(),
        origin: Vectors::store(origin),
        wi: Vectors::store(wi),
        pdf: pdf.store(),
        cos_over_pdf: (local.z.abs() / pdf).store(),
    }
}

/// Where light on its way from one direction to the other would come through the surface, as [`leaks`](super::leaks) has it.
#[inline(always)]
fn crosses<L: Lanes>(wo: Vector<L>, wi: Vector<L>, normal: Vector<L>) -> L::Mask {
    let product = wo.dot(normal) * wi.dot(normal);
    product.lt(product.broadcast(0.0))
}

/// A function rather than a path to the trait's, which would not be inlined into a function for wide registers.
#[inline(always)]
fn store<L: Lanes>(numbers: L) -> [f32; WIDTH] {
    numbers.store()
}
