//! Diffuse surfaces, eight at a time: paths that have come to surfaces which scatter by Lambert's law all do the same
//! there, each in a lane of registers. [`DiffuseBatch::advance`] does for them what [`Path::advance`] does for one:
//!
//! 1. gather: interpolate the points and normals of all lanes (`interpolate_points`);
//! 2. advance one by one the lanes that are seen edge-on, and all of small batches;
//! 3. sample lights (`sample_lights`) and evaluate their direct light (`evaluate_direct_light`);
//! 4. sample the cosine-weighted hemisphere (`sample_directions`);
//! 5. lane by lane: queue the shadow ray, update the throughput, play Russian roulette, and spawn the ray.
//!
//! Whatever depends on tables, as random numbers, the choice of a light and all that is spectral, is done lane by lane.
//! The formulas are those of single paths ([`Real`](photosite_core::math::Real)), so that a path brings the same bits
//! alone and in a lane.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::{Contribution, Path, Tracing, Vertex};
use crate::bsdf::{Bsdf, Diffuse, GRAZING, MIN_SHADING_COSINE};
use crate::geometry::{Geometry, Hit, Primitive, Ray, SurfacePoint, interpolate, offset, on_triangle};
use crate::integrator::interaction::towards_light;
use crate::light::{Choice, EmissiveTriangles, Facing, LightSampleContext};
use crate::sampler::Sampler;
use crate::scene::{ColourSource, Scene, Shading};
use photosite_core::math::pdf::power_heuristic;
use photosite_core::math::{Frame, Pdf, Vector, frame, warp};
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};
use photosite_simd::{LaneMask, Lanes, Real, Simd, Vectors, WithSimd, dispatch};

/// Number of lanes.
const WIDTH: usize = 8;

/// Batch of up to [`WIDTH`] paths that have come to diffuse surfaces.
pub(in super::super) struct DiffuseBatch {
    // Each is made where it stays: copying what was just written in parts would wait for that to reach the memory.
    arrivals: [Arrival; WIDTH],
    /// Number of the paths, which are the first of the arrivals.
    count: usize,
    hits: Hits,
    samples: LightSamples,
}

/// A path that has come to a diffuse surface.
#[derive(Clone, Copy)]
struct Arrival {
    /// Index of the path.
    index: u32,
    ray: Ray,
    hit: Hit,
    reflectance: ColourSource,
}

/// The triangles that were hit.
#[derive(Default)]
struct Hits {
    corners: [Vectors; 3],
    /// Shading normals at the corners, zero where a mesh has none.
    normals: [Vectors; 3],
    /// Bit i is set where they are not zero in lane i.
    has_normals: u32,
    barycentric: [[f32; WIDTH]; 2],
    /// Directions back along the paths, unit vectors.
    wo: Vectors,
}

/// SurfacePoints of surfaces.
struct SurfacePoints {
    position: Vectors,
    error: Vectors,
    geometric_normal: Vectors,
    /// Shading normal on the side that the path has come from.
    normal: Vectors,
    /// Mask of the lanes whose surfaces are not seen edge-on.
    seen: u32,
}

/// The chosen lights, and random numbers for points on them and for scattering.
#[derive(Default)]
struct LightSamples {
    /// Bit i is set where lane i samples at a light.
    has_light: u32,
    /// Handles of the lights.
    lights: [u32; WIDTH],
    /// The lights that are triangles at rest.
    triangles: EmissiveTriangles,
    /// Bit i is set where lane i samples at a triangle.
    is_static_triangle: u32,
    /// Mask of the lanes whose triangle shines on both sides.
    two_sided: u32,
    /// Probability of the choice of the light.
    probability: [f32; WIDTH],
    u_light: [[f32; WIDTH]; 2],
    u_scatter: [[f32; WIDTH]; 2],
}

/// Direct light from triangles.
struct DirectLight {
    /// Mask of the lanes that light may reach.
    is_lit: u32,
    /// Point on the triangle.
    barycentric: [[f32; WIDTH]; 2],
    /// Cosine at the surface over the density of the light sample.
    cos_over_pdf: [f32; WIDTH],
    weight: [f32; WIDTH],
    shadow_origin: Vectors,
    shadow_direction: Vectors,
}

/// Sampled directions.
struct ScatteredRays {
    /// Mask of the lanes whose paths go on.
    continues: u32,
    origin: Vectors,
    wi: Vectors,
    pdf: [f32; WIDTH],
    /// Cosine over density.
    cos_over_pdf: [f32; WIDTH],
}

impl DiffuseBatch {
    /// An empty batch.
    pub(in super::super) fn new() -> Self {
        Self { arrivals: [Arrival::NONE; WIDTH], count: 0, hits: Hits::default(), samples: LightSamples::default() }
    }

    /// Whether there is no room for another path.
    #[inline]
    pub(in super::super) fn is_full(&self) -> bool {
        self.count == WIDTH
    }

    /// Adds a path if it has come to a surface that the batch can serve.
    #[inline]
    pub(in super::super) fn push(
        &mut self,
        index: u32,
        path: &Path,
        ray: &Ray,
        hit: Option<&Hit>,
        tracing: &Tracing<'_>,
    ) -> bool {
        let Some(hit) = hit.filter(|_| path.is_plain(tracing.limits)) else { return false };
        let Some(reflectance) = tracing.scene.diffuse_surface(hit) else { return false };
        let lane = self.count % WIDTH;
        self.hits.set(lane, ray, hit, tracing.scene.geometry());
        self.arrivals[lane] = Arrival { index, ray: *ray, hit: *hit, reflectance };
        self.count += 1;
        true
    }

    /// Advances all paths of the batch as [`Path::advance`] does, and empties it. `go_on` gets the rays along which
    /// paths go on.
    pub(in super::super) fn advance(
        &mut self,
        paths: &mut [Path],
        tracing: &mut Tracing<'_>,
        mut go_on: impl FnMut(u32, Ray),
    ) {
        /// Number of paths below which paths are faster one by one.
        const MIN_PATHS: usize = 3;

        // Interpolate points and normals of all lanes
        let points = (self.count >= MIN_PATHS).then(|| interpolate_points(&self.hits));
        let seen = points.as_ref().map_or(0, |points| points.seen);

        // Advance paths one by one that are not worth a lane: their surfaces are seen edge-on, or the batch is too
        // small
        for (_, arrival) in (0..).zip(self.arrivals()).filter(|(lane, _)| !has_lane(seen, *lane)) {
            let path = &mut paths[arrival.index as usize];
            if let Some(ray) = path.advance(arrival.index, &arrival.ray, Some(arrival.hit), tracing) {
                go_on(arrival.index, ray);
            }
        }
        if let Some(points) = points {
            // Sample lights and directions of all lanes
            self.sample_lights(&points, paths, tracing.scene, tracing.sampler);
            let direct = evaluate_direct_light(&points, &self.hits.wo, &self.samples);
            let scattered = sample_directions(&points, &self.hits.wo, &self.samples.u_scatter);
            for (lane, arrival) in self.arrivals().iter().enumerate().filter(|(lane, _)| has_lane(seen, *lane)) {
                let path = &mut paths[arrival.index as usize];
                path.depth += 1;
                let reflectance = arrival.reflectance(tracing.scene, &path.wavelengths);

                // Queue the shadow ray of the light sample
                self.queue_shadow_ray(lane, reflectance, path, &points, &direct, tracing);

                // Update the throughput with f·cos/pdf
                if !has_lane(scattered.continues, lane) {
                    continue;
                }
                path.throughput *= reflectance * FRAC_1_PI * scattered.cos_over_pdf[lane];
                if path.throughput.is_black() {
                    continue;
                }
                path.last_bsdf = Some((Pdf::new(scattered.pdf[lane]), points.light_sample_context(lane)));

                // Play Russian roulette, and spawn the ray
                tracing.sampler.resume(path.position);
                if path.survives(tracing.limits, tracing.sampler) {
                    let ray = Ray::new(scattered.origin.get(lane), scattered.wi.get(lane));
                    go_on(arrival.index, ray.at_time(arrival.ray.time).leaving(arrival.hit.facet()));
                }
            }
        }
        self.count = 0;
    }

    /// The paths of the batch.
    #[inline]
    fn arrivals(&self) -> &[Arrival] {
        &self.arrivals[..self.count]
    }

    /// Draws the random numbers of each visible lane and chooses its light.
    fn sample_lights(&mut self, points: &SurfacePoints, paths: &mut [Path], scene: &Scene, sampler: &mut Sampler) {
        let Self { arrivals, count, samples, .. } = self;
        (samples.has_light, samples.is_static_triangle, samples.two_sided) = (0, 0, 0);
        let seen = || (0..*count).filter(|lane| has_lane(points.seen, *lane));
        // Draw the numbers of all lanes first: what depends on one of them would wait for it
        for lane in seen() {
            let position = &mut paths[arrivals[lane].index as usize].position;
            sampler.resume(*position);
            [samples.u_light[0][lane], samples.u_light[1][lane]] = sampler.next_2d();
            sampler.skip();
            [samples.u_scatter[0][lane], samples.u_scatter[1][lane]] = sampler.next_2d();
            sampler.save(position);
        }
        for lane in seen() {
            let choice = scene.choose_light(&points.light_sample_context(lane), samples.u_light[0][lane]);
            let Some(Choice { light, probability, rest }) = choice else { continue };
            samples.has_light |= 1 << lane;
            samples.lights[lane] = light;
            samples.probability[lane] = probability;
            samples.u_light[0][lane] = rest;
            let Some((emitter, triangle)) = scene.lights().static_triangle_light(light) else { continue };
            samples.triangles.set(lane, triangle);
            samples.is_static_triangle |= 1 << lane;
            samples.two_sided |= u32::from(emitter.emission.two_sided) << lane;
        }
    }

    /// Queues the shadow ray of a lane's light sample with what the path gathers if nothing occludes it. Into the queue
    /// at once: copying a ray that was just written in parts would wait for that to reach the memory.
    #[inline]
    fn queue_shadow_ray(
        &self,
        lane: usize,
        reflectance: SampledSpectrum,
        path: &Path,
        points: &SurfacePoints,
        direct: &DirectLight,
        tracing: &mut Tracing<'_>,
    ) {
        let &mut Tracing { scene, ref mut queues, .. } = tracing;
        let arrival = &self.arrivals[lane];
        if !has_lane(self.samples.has_light, lane) {
            return;
        }
        let light = self.samples.lights[lane];
        let Some((emitter, _)) = scene.lights().static_triangle_light(light) else {
            // Lights of other kinds have no lanes
            let [rest, v] = self.samples.u_light.map(|u| u[lane]);
            let choice = Choice { light, probability: self.samples.probability[lane], rest };
            let (ctx, time) = (points.light_sample_context(lane), arrival.ray.time);
            let Some(light) = scene.sample_chosen_light(&choice, &ctx, time, v, &path.wavelengths) else { return };
            let point = arrival.point(lane, points, scene);
            let frame = Frame::from_normal(points.normal.get(lane));
            let shading = Shading { frame, bsdf: Bsdf::Diffuse(Diffuse { reflectance }) };
            let vertex = Vertex::new(arrival.hit.t, &point, &shading, self.hits.wo.get(lane));
            path.queue_direct_light(arrival.index, &vertex, &light, scene, queues);
            return;
        };
        if !has_lane(direct.is_lit, lane) {
            return;
        }
        let barycentric = direct.barycentric.map(|weights| weights[lane]);
        let radiance = scene.emitted_radiance(emitter, barycentric, &path.wavelengths);
        let contribution = radiance * (reflectance * FRAC_1_PI) * direct.cos_over_pdf[lane];
        if contribution.is_black() {
            return;
        }
        let (origin, direction) = (direct.shadow_origin.get(lane), direct.shadow_direction.get(lane));
        let (time, from, to) = (arrival.ray.time, arrival.hit.facet(), emitter.primitive.target());
        queues.shadow_rays.push(Ray { origin, direction, t_max: 1.0, time, from, to });
        let light = path.throughput * (contribution * direct.weight[lane]);
        queues.contributions.push(Contribution { path: arrival.index, light, is_delta: false, medium: None });
    }
}

/// Whether a mask has the bit of a lane.
#[inline(always)]
fn has_lane(mask: u32, lane: usize) -> bool {
    mask >> lane & 1 != 0
}

impl Arrival {
    /// Placeholder.
    const NONE: Self = Self {
        index: 0,
        ray: Ray::NONE,
        hit: Hit { t: 0.0, uv: [0.0; 2], primitive: Primitive::Triangle(0), instance: 0 },
        reflectance: ColourSource::Texture { factor: [0.0; 3], texture: 0 },
    };

    #[inline]
    fn reflectance(&self, scene: &Scene, wavelengths: &Wavelengths) -> SampledSpectrum {
        scene.colour_at(self.reflectance, self.hit.primitive, self.hit.uv, wavelengths)
    }

    /// The surface point of a lane.
    fn point(&self, lane: usize, points: &SurfacePoints, scene: &Scene) -> SurfacePoint {
        let Hit { primitive, uv, instance, .. } = self.hit;
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
            instance,
            mesh,
            material: scene.geometry().meshes[mesh as usize].material,
            parameters: uv,
            time: self.ray.time,
        }
    }
}

impl Hits {
    #[inline]
    fn set(&mut self, lane: usize, ray: &Ray, hit: &Hit, geometry: &Geometry) {
        let triangle = hit.primitive.triangle().expect("diffuse surfaces of triangles");
        let triangle = &geometry.triangles[triangle as usize];
        let mesh = &geometry.meshes[triangle.mesh as usize];
        for (corners, corner) in self.corners.iter_mut().zip(geometry.corners_of(triangle, mesh, ray.time)) {
            corners.set(lane, corner);
        }
        let normals = geometry.corner_normals(triangle, mesh, ray.time);
        if normals.is_some() || has_lane(self.has_normals, lane) {
            self.has_normals = self.has_normals & !(1 << lane) | u32::from(normals.is_some()) << lane;
            for (normals, normal) in self.normals.iter_mut().zip(normals.unwrap_or_default()) {
                normals.set(lane, normal);
            }
        }
        [self.barycentric[0][lane], self.barycentric[1][lane]] = hit.uv;
        self.wo.set(lane, -ray.direction);
    }
}

impl SurfacePoints {
    /// Context of light sampling at the surface in a lane.
    #[inline]
    fn light_sample_context(&self, lane: usize) -> LightSampleContext {
        LightSampleContext { point: self.position.get(lane), facing: Facing::Front(self.normal.get(lane)) }
    }
}

fn interpolate_points(hits: &Hits) -> SurfacePoints {
    dispatch(InterpolatePoints { hits })
}

/// The arguments of [`interpolate_points_in`].
struct InterpolatePoints<'a> {
    hits: &'a Hits,
}

impl WithSimd for InterpolatePoints<'_> {
    type Output = SurfacePoints;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> SurfacePoints {
        interpolate_points_in(simd, self.hits)
    }
}

#[inline(always)]
fn interpolate_points_in<S: Simd>(simd: S, hits: &Hits) -> SurfacePoints {
    let [a, b, c] = &hits.corners;
    let barycentric = [simd.load(&hits.barycentric[0]), simd.load(&hits.barycentric[1])];
    let (position, error, across) = on_triangle([a.load(simd), b.load(simd), c.load(simd)], barycentric);
    let geometric_normal = across.normalize_or(across.broadcast(Vec3::ZERO));
    let mut normal = geometric_normal;
    if hits.has_normals != 0 {
        let [a, b, c] = &hits.normals;
        normal = interpolate([a.load(simd), b.load(simd), c.load(simd)], barycentric).normalize_or(geometric_normal);
    }
    let wo = hits.wo.load(simd);
    normal = Vector::select(wo.dot(geometric_normal).lt(simd.broadcast(0.0)), -normal, normal);
    SurfacePoints {
        position: Vectors::store(position),
        error: Vectors::store(error),
        geometric_normal: Vectors::store(geometric_normal),
        normal: Vectors::store(normal),
        seen: simd.broadcast(MIN_SHADING_COSINE).le(wo.dot(normal)).bits(),
    }
}

fn evaluate_direct_light(points: &SurfacePoints, wo: &Vectors, samples: &LightSamples) -> DirectLight {
    dispatch(EvaluateDirectLight { points, wo, samples })
}

/// The arguments of [`evaluate_direct_light_in`].
struct EvaluateDirectLight<'a> {
    points: &'a SurfacePoints,
    wo: &'a Vectors,
    samples: &'a LightSamples,
}

impl WithSimd for EvaluateDirectLight<'_> {
    type Output = DirectLight;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> DirectLight {
        evaluate_direct_light_in(simd, self.points, self.wo, self.samples)
    }
}

#[inline(always)]
fn evaluate_direct_light_in<S: Simd>(
    simd: S,
    points: &SurfacePoints,
    wo: &Vectors,
    samples: &LightSamples,
) -> DirectLight {
    let zero = simd.broadcast(0.0);
    let (position, geometric_normal) = (points.position.load(simd), points.geometric_normal.load(simd));
    let triangle = samples.triangles.load(simd);
    let barycentric = warp::uniform_triangle([simd.load(&samples.u_light[0]), simd.load(&samples.u_light[1])]);
    let light_point = triangle.seen_from(barycentric, position);
    let pdf = light_point.density * simd.load(&samples.probability);
    let cos = points.normal.load(simd).dot(light_point.wi);
    let is_above = simd.broadcast(GRAZING).lt(cos) & !crosses(wo.load(simd), light_point.wi, geometric_normal);
    let is_lit = (zero.lt(pdf) & is_above).bits();
    let (active, back) = (zero.lt(light_point.cos).bits(), light_point.cos.lt(zero).bits());
    let scattered_pdf = cos * simd.broadcast(FRAC_1_PI);
    let weighted_cos = cos.abs();
    let origin = offset(position, points.error.load(simd), geometric_normal, light_point.wi);
    let target = towards_light(light_point.position, triangle.normal, light_point.wi);
    DirectLight {
        is_lit: is_lit & samples.is_static_triangle & (active | back & samples.two_sided),
        barycentric: barycentric.map(store),
        cos_over_pdf: (weighted_cos / pdf).store(),
        weight: power_heuristic(pdf, scattered_pdf).store(),
        shadow_origin: Vectors::store(origin),
        shadow_direction: Vectors::store(target - origin),
    }
}

fn sample_directions(points: &SurfacePoints, wo: &Vectors, u: &[[f32; WIDTH]; 2]) -> ScatteredRays {
    dispatch(SampleDirections { points, wo, u })
}

/// The arguments of [`sample_directions_in`].
struct SampleDirections<'a> {
    points: &'a SurfacePoints,
    wo: &'a Vectors,
    u: &'a [[f32; WIDTH]; 2],
}

impl WithSimd for SampleDirections<'_> {
    type Output = ScatteredRays;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> ScatteredRays {
        sample_directions_in(simd, self.points, self.wo, self.u)
    }
}

#[inline(always)]
fn sample_directions_in<S: Simd>(
    simd: S,
    points: &SurfacePoints,
    wo: &Vectors,
    [u, v]: &[[f32; WIDTH]; 2],
) -> ScatteredRays {
    let local = warp::cosine_hemisphere([simd.load(u), simd.load(v)]);
    let (normal, geometric_normal) = (points.normal.load(simd), points.geometric_normal.load(simd));
    let [x, y] = frame::tangents(normal);
    let wi = x * local.x + y * local.y + normal * local.z;
    let pdf = local.z * simd.broadcast(FRAC_1_PI);
    let origin = offset(points.position.load(simd), points.error.load(simd), geometric_normal, wi);
    ScatteredRays {
        continues: (simd.broadcast(GRAZING).lt(local.z) & !crosses(wo.load(simd), wi, geometric_normal)).bits(),
        origin: Vectors::store(origin),
        wi: Vectors::store(wi),
        pdf: pdf.store(),
        cos_over_pdf: (local.z.abs() / pdf).store(),
    }
}

/// Mask of the lanes in which light would pass from one side of the surface to the other, as in
/// [`leaks`](crate::integrator::interaction::leaks).
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
