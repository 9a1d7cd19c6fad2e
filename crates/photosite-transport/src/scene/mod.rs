//! Scene in front of the camera: the [`description`] that files give, and the immutable [`Scene`] that light transport
//! reads.
//!
//! A scene is flat tables with `u32` handles: geometry, materials, textures, spectra, lights. [`build`] makes it from a
//! description and never looks at a file.

mod alone;
mod build;
pub mod description;
mod layout;
mod material;
pub mod packed;
mod panes;
mod shading;
pub mod spectral_coverage;

pub use alone::ObjectAlone;
pub use build::{build, build_after};
pub use build::{emission_spectrum, nit_per_unit};
pub use material::{
    Alpha, AnisotropySource, CoatSource, ColourSource, FactorSource, FilmSource, LayeredMaterial, Material, NormalMap,
    ScatteringModel, Tabled,
};
pub use shading::Shading;

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::bsdf::{Mix, Model, SceneTraits};
use crate::geometry::{
    self, Accel, AcceptAll, Geometry, Hit, HitFilter, InstanceTransform, Primitive, Ray, SurfacePoint,
};
use crate::light::{
    AreaLight, Choice, LiContext, LightRay, LightSample, LightSampleContext, Lights, SurfaceEmission, Tint,
};
use crate::texture::Texture;
use layout::{InstanceTable, Kept, Part};
use photosite_core::math::hash::{hash64, unit_f32};
use photosite_core::spectrum::{SampledSpectrum, Spectrum, SpectrumId, SpectrumTable, Wavelengths};

/// Scene as light transport reads it: immutable tables of geometry, materials, textures, spectra and lights.
#[derive(Clone, Debug)]
pub struct Scene {
    geometry: Arc<Geometry>,
    accel: Accel,
    instances: InstanceTable,
    /// Index of the object of each instance.
    objects: Vec<u32>,
    /// Record of the layout that the next scene may have in common.
    kept: Kept,
    /// Places of another scene's surfaces in this one, filled on demand.
    places: OnceLock<HashMap<Part, [u32; 2]>>,
    materials: Vec<Material>,
    /// Reflectance of each mesh that is diffuse and nothing else.
    diffuse: Vec<Option<ColourSource>>,
    layered: Vec<LayeredMaterial>,
    mixes: Vec<Mix<Tabled>>,
    textures: Vec<Texture>,
    spectra: SpectrumTable,
    lights: Lights,
    light_spectrum: Spectrum,
    /// Whether any material has holes.
    has_alpha: bool,
    /// Whether any material bounds a volume that absorbs.
    has_media: bool,
    /// Whether some light may go straight on through any material.
    has_panes: bool,
}

impl Scene {
    /// Geometry of the scene.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Lights of the scene.
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// Whether the scene was built of the very meshes of a description, so that a scene of that description may share
    /// much with it.
    pub fn has_meshes_of(&self, description: &description::SceneDescription) -> bool {
        self.kept.has_meshes(&description.meshes)
    }

    /// Lower and upper corner of the geometry, m.
    pub fn bounds(&self) -> (glam::Vec3, glam::Vec3) {
        self.accel.bounds()
    }

    /// Spectrum of the light of all sources together, in relative units, which tells the wavelengths that are worth
    /// sampling.
    pub fn light_spectrum(&self) -> &Spectrum {
        &self.light_spectrum
    }

    /// Whether any material leaves paths with one wavelength.
    pub fn disperses(&self) -> bool {
        self.scene_traits().any(SceneTraits::disperses)
    }

    /// Whether shadow rays may pass panes ([`Self::through_panes`]).
    #[inline]
    pub(crate) fn has_panes(&self) -> bool {
        self.has_panes
    }

    /// Whether any material may cast caustics ([`Bsdf::casts_caustics`](crate::bsdf::Bsdf::casts_caustics)).
    pub fn may_cast_caustics(&self) -> bool {
        self.scene_traits().any(SceneTraits::may_cast_caustics)
    }

    /// Traits of the materials' scattering models.
    fn scene_traits(&self) -> impl Iterator<Item = &dyn SceneTraits> {
        let layered = self.layered.iter().map(|layers| layers as &dyn SceneTraits);
        self.models().filter_map(Model::scene_traits).chain(layered)
    }

    /// The models of all materials, and those that mixes are made of, which tell all that there is to tell of these.
    fn models(&self) -> impl Iterator<Item = &ScatteringModel> {
        let of_materials = self.materials.iter().map(|material| &material.model);
        of_materials.chain(self.mixes.iter().flat_map(|mix| &mix.models))
    }

    /// Finds the nearest surface along a ray.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        if self.has_alpha { self.accel.closest(ray, &Holes(self)) } else { self.accel.closest(ray, &AcceptAll) }
    }

    /// Whether a surface is in the way of a ray.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        if self.has_alpha { self.accel.occluded(ray, &Holes(self)) } else { self.accel.occluded(ray, &AcceptAll) }
    }

    /// Finds the nearest surface along each of several rays, in their order.
    #[inline]
    pub fn closest_each(&self, rays: &[Ray], hits: &mut Vec<Option<Hit>>) {
        if self.has_alpha {
            self.accel.closest_each(rays, &Holes(self), hits);
        } else {
            self.accel.closest_each(rays, &AcceptAll, hits);
        }
    }

    /// Whether a surface is in the way of each of several rays, in their order.
    #[inline]
    pub fn occluded_each(&self, rays: &[Ray], occluded: &mut Vec<bool>) {
        if self.has_alpha {
            self.accel.occluded_each(rays, &Holes(self), occluded);
        } else {
            self.accel.occluded_each(rays, &AcceptAll, occluded);
        }
    }

    /// The surface point of a hit by a ray of that time.
    #[inline]
    pub fn point(&self, hit: &Hit, time: f32) -> SurfacePoint {
        SurfacePoint::new(&self.geometry, &self.accel, hit, time)
    }

    /// Position of the surface point of a hit at a time, in double precision, m.
    pub fn position(&self, hit: &Hit, time: f64) -> DVec3 {
        SurfacePoint::position_at(&self.geometry, &self.accel, hit, time)
    }

    /// Index of the object that was hit, among [all](description::SceneDescription::all_objects) of the description
    /// that the scene was built from.
    pub fn object(&self, hit: &Hit) -> u32 {
        self.objects[self.part(hit).instance as usize]
    }

    /// Places of each mesh of each instance: its index in the geometry, and that of its instance there.
    fn places(&self) -> &HashMap<Part, [u32; 2]> {
        self.places.get_or_init(|| {
            let InstanceTable { of_mesh, of_placed, numbers } = &self.instances;
            let in_world = of_placed.iter().take_while(|instance| instance.is_none()).count();
            let deforms = |mesh: u32| self.geometry.meshes[mesh as usize].deformation.is_some();
            let deforming = (0..of_mesh.len() as u32).filter(|&mesh| deforms(mesh)).count();
            // Those that deform come last, each with an instance of its own.
            let rigid = of_mesh.len() - deforming;
            let first = in_world - deforming;
            let placed = |mesh: usize| mesh.checked_sub(rigid).map_or(0, |number| first + number);
            let of_world = of_mesh.iter().enumerate().map(|(mesh, part)| (*part, [mesh as u32, placed(mesh) as u32]));
            let first_meshes =
                self.kept.group_sizes().scan(0, |next, size| Some(std::mem::replace(next, *next + size)));
            let groups: Vec<(usize, usize)> = first_meshes.zip(self.kept.group_sizes()).collect();
            let of_groups = of_placed.iter().enumerate().skip(in_world).flat_map(|(placed, instance)| {
                let (first, size) = groups[self.accel.instances()[placed].blas as usize - in_world];
                let instance = instance.unwrap_or_default();
                let meshes = first..first + size;
                meshes.map(move |mesh| {
                    let part = Part { instance, number: numbers[mesh] };
                    (part, [(of_mesh.len() + mesh) as u32, placed as u32])
                })
            });
            of_world.chain(of_groups).collect()
        })
    }

    /// The mesh that was hit.
    fn part(&self, hit: &Hit) -> Part {
        let mesh = self.geometry.mesh_of(hit.primitive) as usize;
        match self.instances.of_placed[hit.instance as usize] {
            None => self.instances.of_mesh[mesh],
            Some(instance) => Part { instance, number: self.instances.numbers[mesh - self.instances.of_mesh.len()] },
        }
    }

    /// Hit of the same point of the same surface in another scene, whose description has the same
    /// [surfaces](description::SceneDescription::surfaces): it may stand elsewhere there and have another shape. `None`
    /// where there is none.
    pub fn hit_in(&self, hit: &Hit, other: &Self) -> Option<Hit> {
        if std::ptr::eq(self, other) {
            return Some(*hit);
        }
        let &[mesh, instance] = other.places().get(&self.part(hit))?;
        let range = other.geometry.meshes.get(mesh as usize)?;
        let Primitive::Triangle(triangle) = hit.primitive else {
            return Some(Hit { primitive: Primitive::Quadric(range.quadric?), instance, ..*hit });
        };
        let own = self.geometry.triangles[triangle as usize];
        let number = triangle - self.geometry.meshes[own.mesh as usize].first_triangle;
        let triangle = Some(range.first_triangle + number).filter(|_| number < range.triangle_count)?;
        // Corners of meshes that a mirror put into the world are in the other order.
        let second = |triangle: geometry::Triangle| triangle.corners[1].wrapping_sub(triangle.corners[0]);
        let is_turned = second(own) != second(other.geometry.triangles[triangle as usize]);
        let [b1, b2] = hit.uv;
        let uv = if is_turned { [b2, b1] } else { [b1, b2] };
        Some(Hit { t: hit.t, uv, primitive: Primitive::Triangle(triangle), instance })
    }

    /// Radiance that a surface point emits towards the unit direction `wo`.
    #[inline]
    pub fn emitted(&self, point: &SurfacePoint, wo: glam::Vec3, wavelengths: &Wavelengths) -> SampledSpectrum {
        let Some(emission) = &self.materials[point.material as usize].emission else { return SampledSpectrum::ZERO };
        if !emission.two_sided && wo.dot(point.geometric_normal) <= 0.0 {
            return SampledSpectrum::ZERO;
        }
        self.emitted_at(emission, point.primitive, point.parameters, wavelengths)
    }

    /// Medium that light from `point` to the unit direction `wo` has come through, where `point` is seen from within a
    /// volume: its absorption, m⁻¹.
    #[inline]
    pub fn absorption_behind(&self, point: &SurfacePoint, wo: glam::Vec3) -> Option<SpectrumId> {
        if !self.has_media {
            return None;
        }
        self.materials[point.material as usize].absorption.filter(|_| wo.dot(point.geometric_normal) < 0.0)
    }

    /// Medium beyond `point` for light that passes it in the direction `wi` and was in `medium` before.
    #[inline]
    pub fn medium_across(
        &self,
        point: &SurfacePoint,
        wi: glam::Vec3,
        medium: Option<SpectrumId>,
    ) -> Option<SpectrumId> {
        if !self.has_media {
            return None;
        }
        match self.materials[point.material as usize].absorption {
            Some(absorption) => (wi.dot(point.geometric_normal) < 0.0).then_some(absorption),
            None => medium,
        }
    }

    /// Transmittance: the part of the light that is left after `distance` (m) in a medium: exp(−σ·d).
    #[inline]
    pub fn transmittance(&self, absorption: SpectrumId, distance: f32, wavelengths: &Wavelengths) -> SampledSpectrum {
        self.spectra.sample(absorption, wavelengths).map(|per_m| (-per_m * distance).exp())
    }

    /// The reflectance of a diffuse surface that was hit where its file puts it: in world space, without light of its
    /// own, and with nothing that absorbs around it.
    #[inline]
    pub(crate) fn diffuse_surface(&self, hit: &Hit) -> Option<ColourSource> {
        let mesh = self.geometry.mesh_of(hit.primitive);
        let stands_in_world =
            matches!(self.accel.instances()[hit.instance as usize].transform, InstanceTransform::World);
        self.diffuse[mesh as usize].filter(|_| stands_in_world)
    }

    /// Handle of the light that a surface point belongs to.
    #[inline]
    pub fn light_of(&self, point: &SurfacePoint) -> Option<u32> {
        let mesh = &self.geometry.meshes[point.mesh as usize];
        Some(mesh.first_light? + point.primitive.triangle().map_or(0, |triangle| triangle - mesh.first_triangle))
    }

    /// Samples a light and a direction to it, at a time, by two random numbers.
    #[inline]
    pub fn sample_light(
        &self,
        ctx: &LightSampleContext,
        time: f32,
        [u_light, v]: [f32; 2],
        wavelengths: &Wavelengths,
    ) -> Option<LightSample> {
        let choice = self.choose_light(ctx, u_light)?;
        self.sample_chosen_light(&choice, ctx, time, v, wavelengths)
    }

    /// The light of [`Self::sample_light`], by the first of its random numbers.
    #[inline]
    pub(crate) fn choose_light(&self, ctx: &LightSampleContext, u_light: f32) -> Option<Choice> {
        self.lights.choose(ctx, u_light)
    }

    /// The direction of [`Self::sample_light`] to the light that was chosen.
    #[inline]
    pub(crate) fn sample_chosen_light(
        &self,
        choice: &Choice,
        ctx: &LightSampleContext,
        time: f32,
        v: f32,
        wavelengths: &Wavelengths,
    ) -> Option<LightSample> {
        let emitted_at = |light: &AreaLight, parameters| self.emitted_radiance(light, parameters, wavelengths);
        let li = LiContext { point: ctx.point, time, wavelengths, spectra: &self.spectra, geometry: &self.geometry };
        self.lights.sample_chosen(choice, v, &li, emitted_at)
    }

    /// Samples a ray that leaves an area light at a time, by five random numbers: for the light, the point and the
    /// direction; `SampleLe` in [pbrt4](photosite_core::references#pbrt4) §12.1.
    pub fn sample_le(&self, time: f32, u: (f32, [f32; 2], [f32; 2]), wavelengths: &Wavelengths) -> Option<LightRay> {
        let emitted_at = |light: &AreaLight, parameters| self.emitted_radiance(light, parameters, wavelengths);
        self.lights.sample_le(&self.geometry, emitted_at, time, u)
    }

    /// [`LightRay::density`] of [`Self::sample_le`] on a light at a time.
    #[inline]
    pub fn emission_density(&self, light: u32, time: f32) -> f32 {
        self.lights.emission_density(light, &self.geometry, time)
    }

    /// Radiance of a point of an area light.
    #[inline]
    pub(crate) fn emitted_radiance(
        &self,
        light: &AreaLight,
        parameters: [f32; 2],
        wavelengths: &Wavelengths,
    ) -> SampledSpectrum {
        let emitted = self.emitted_at(&light.emission, light.primitive, parameters, wavelengths);
        // Where there are holes, rays that look for the light end in front of them.
        if self.has_alpha { emitted * self.presence(light.primitive, parameters) } else { emitted }
    }

    /// Radiance from infinitely far in the unit direction `towards`.
    #[inline]
    pub fn environment_radiance(&self, towards: glam::Vec3, wavelengths: &Wavelengths) -> SampledSpectrum {
        self.lights.environment().map_or(SampledSpectrum::ZERO, |e| e.radiance(&self.spectra, towards, wavelengths))
    }

    /// Radiance of a point of a primitive on the side that shines.
    #[inline]
    fn emitted_at(
        &self,
        emission: &SurfaceEmission,
        primitive: Primitive,
        uv: [f32; 2],
        wavelengths: &Wavelengths,
    ) -> SampledSpectrum {
        let tint = match emission.tint {
            Tint::None => None,
            Tint::Textured { texture, .. } => Some(emission.tinted(self.texel(texture, primitive, uv))),
        };
        emission.radiance(&self.spectra, tint, wavelengths)
    }

    /// Probability with which a material's alpha says that there is a surface at a point of a primitive.
    #[inline]
    fn presence(&self, primitive: Primitive, uv: [f32; 2]) -> f32 {
        let mesh = &self.geometry.meshes[self.geometry.mesh_of(primitive) as usize];
        let coverage = |factor: f32, texture: Option<u32>| {
            let factor = factor * self.geometry.colour(primitive, uv).map_or(1.0, |colour| colour.w);
            factor * texture.map_or(1.0, |texture| self.rgba_linear(texture, primitive, uv)[3])
        };
        match self.materials[mesh.material as usize].alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask { factor, texture, cutoff } => f32::from(u8::from(coverage(factor, texture) >= cutoff)),
            Alpha::Blend { factor, texture } => coverage(factor, texture),
        }
    }

    /// Linear RGB of an sRGB-encoded texture at a point of a primitive.
    #[inline]
    fn texel(&self, texture: u32, primitive: Primitive, uv: [f32; 2]) -> [f32; 3] {
        let [r, g, b, _] = self.rgba_srgb(texture, primitive, uv);
        [r, g, b]
    }

    #[inline]
    fn rgba_srgb(&self, texture: u32, primitive: Primitive, uv: [f32; 2]) -> [f32; 4] {
        let texture = &self.textures[texture as usize];
        texture.sample_rgba_srgb(self.geometry.uv(primitive, uv, texture.uv_set as usize))
    }

    #[inline]
    fn rgba_linear(&self, texture: u32, primitive: Primitive, uv: [f32; 2]) -> [f32; 4] {
        let texture = &self.textures[texture as usize];
        texture.sample_rgba_linear(self.geometry.uv(primitive, uv, texture.uv_set as usize))
    }
}

/// Lets rays through where a material's alpha says that there is nothing.
struct Holes<'a>(&'a Scene);

impl HitFilter for Holes<'_> {
    #[inline]
    fn accept(&self, primitive: Primitive, uv: [f32; 2], ray: &Ray) -> bool {
        let presence = self.0.presence(primitive, uv);
        if presence <= 0.0 || presence >= 1.0 {
            return presence > 0.0;
        }
        // There with probability alpha: the expected radiance is that of blending. The decision is a function of ray
        // and primitive, so that it does not depend on the order of traversal.
        let [x, y, z] = ray.direction.to_array().map(|c| u64::from(c.to_bits()));
        let origin = u64::from(ray.origin.x.to_bits()) << 32 | u64::from(ray.origin.z.to_bits());
        let key = hash64(hash64(x << 32 | y, z << 32 | u64::from(self.0.geometry.number(primitive))), origin);
        unit_f32(key as u32) < presence
    }
}
