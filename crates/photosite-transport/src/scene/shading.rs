//! Shading: from a surface point to the frame and the BSDF that light scatters by.

use glam::{Vec2, Vec3};

use super::{
    AnisotropySource, ColourSource, FactorSource, LayeredMaterial, Material, NormalMap, ScatteringModel, Scene, Tabled,
};
use crate::bsdf::{
    Bsdf, Coat, Ggx, Layered, MIN_SHADING_COSINE, Map, Mix, Model, RelativeIndex, Sampled, Sheen, ThinFilm, Volume,
};
use crate::geometry::{Primitive, SurfacePoint};
use photosite_core::math::Frame;
use photosite_core::math::hash::{hash64, unit_f32};
use photosite_core::spectrum::upsampling::reflectance_polynomial;
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, Wavelengths};

/// A BSDF in its frame.
#[derive(Clone, Copy, Debug)]
pub struct Shading {
    /// Local axes; z is the shading normal.
    pub frame: Frame,
    /// Scattering in the local frame.
    pub bsdf: Bsdf,
}

impl Scene {
    /// The BSDF at a point seen from the unit direction `wo`.
    ///
    /// Surfaces that light does not pass scatter from both sides: the frame is turned to the side of `wo`. A material's
    /// `double_sided` speaks of emission only, since a physical surface does not vanish when it is seen from behind;
    /// culling is an economy of rasterisers.
    #[inline]
    pub fn shading(&self, point: &SurfacePoint, wo: Vec3, wavelengths: &Wavelengths) -> Shading {
        let material = &self.materials[point.material as usize];
        let mut model = &material.model;
        while let Model::Mix(mix) = model {
            model = self.chosen(&self.mixes[*mix as usize], point);
        }
        if let Model::Layered(layers) = *model {
            return self.layers(material, &self.layered[layers as usize], point, wo, wavelengths);
        }
        let shading = |refracts: bool, bsdf| Shading { frame: self.frame(material, point, wo, !refracts), bsdf };
        let mut look_up = LookUp { scene: self, point, wavelengths };
        model
            .look_up(&mut look_up, shading)
            .unwrap_or_else(|| unreachable!("models made of others are taken apart above"))
    }

    /// Chooses one of two models, the second with the probability of its weight: the expected radiance is that of both.
    /// The choice is a function of the point, so that it is the same from wherever a path comes.
    #[inline(never)]
    fn chosen<'a>(&self, mix: &'a Mix<Tabled>, point: &SurfacePoint) -> &'a ScatteringModel {
        let [u, v] = point.parameters.map(|c| u64::from(c.to_bits()));
        let key = hash64(u << 32 | v, u64::from(self.geometry.number(point.primitive)));
        // Mixes within mixes choose by their own bits.
        let own = hash64(key, u64::from(mix.weight.to_bits()));
        &mix.models[usize::from(unit_f32(own as u32) < mix.weight)]
    }

    /// glTF's material.
    #[inline(never)]
    fn layers(
        &self,
        material: &Material,
        m: &LayeredMaterial,
        point: &SurfacePoint,
        wo: Vec3,
        wavelengths: &Wavelengths,
    ) -> Shading {
        let factor = |source: FactorSource| self.factor(source, point);
        let colour = |source| self.colour(source, point, wavelengths);
        let specular_colour = m.specular_colour.map_or(SampledSpectrum::ONE, colour);
        let alpha = factor(m.roughness) * factor(m.roughness);
        let mut layers = Layered {
            base_colour: self.base_colour(m.base_colour, point, wavelengths),
            metallic: factor(m.metallic),
            distribution: Ggx::new(alpha, alpha),
            specular: factor(m.specular),
            f0: (specular_colour * (m.f0 * m.specular_scale)).map(|f0| f0.min(1.0)),
            transmission: factor(m.transmission),
            volume: m
                .has_volume
                .then(|| Volume { eta: self.spectra.sample(m.eta, wavelengths), dispersive: m.dispersive }),
            ..Layered::default()
        };
        if let Some((part, tint)) = m.diffuse_transmission {
            (layers.diffuse_transmission, layers.diffuse_transmission_colour) = (factor(part), colour(tint));
        }
        layers.film = m.film.and_then(|film| {
            let [low, high] = film.thickness_nm;
            let t = film.texture.map_or(1.0, |t| self.rgba_linear(t, point.primitive, point.parameters)[1]);
            let thickness = low + (high - low) * t;
            let waves = SampledSpectrum::from_lanes(|i| 2.0 * film.index * thickness / wavelengths.lambda_nm(i));
            let weight = factor(film.weight);
            // No thickness, no film (`iridescence`, "Properties").
            (weight > 0.0 && thickness > 0.0).then_some(ThinFilm { weight, index: film.index, waves })
        });
        layers.sheen = m.sheen.and_then(|(tint, roughness)| {
            let (colour, roughness) = (colour(tint), factor(roughness));
            (!colour.is_black()).then_some(Sheen { colour, alpha: roughness * roughness })
        });
        let mut frame = self.frame(material, point, wo, layers.is_two_sided());
        if let Some(anisotropy) = m.anisotropy {
            let (strength, [x, y]) = self.grooves(anisotropy, point);
            layers.distribution = Ggx::new(alpha + (1.0 - alpha) * strength * strength, alpha);
            // The file's bitangent, whichever side is looked at.
            let bitangent =
                frame.y * frame.y.dot(point.shading_normal.cross(point.tangent)).signum() * point.handedness;
            frame = Frame::from_normal_tangent(frame.z, frame.x * x + bitangent * y);
        }
        layers.coat = m.coat.and_then(|coat| {
            let (weight, roughness) = (factor(coat.weight), factor(coat.roughness));
            let alpha = roughness * roughness;
            let normal = if coat.normal_map.is_some() || material.normal_map.is_some() {
                let own = self.mapped_frame(coat.normal_map, point, wo, layers.is_two_sided());
                frame.to_local(own.z)
            } else {
                Vec3::Z
            };
            (weight > 0.0).then_some(Coat { weight, distribution: Ggx::new(alpha, alpha), normal })
        });
        Shading { frame, bsdf: Bsdf::Layered(layers) }
    }

    /// Strength and direction of anisotropy (`anisotropy`, "Anisotropy").
    #[inline]
    fn grooves(&self, source: AnisotropySource, point: &SurfacePoint) -> (f32, [f32; 2]) {
        let [cos, sin] = source.rotation;
        let Some(texture) = source.texture else { return (source.strength, source.rotation) };
        let [r, g, b, _] = self.rgba_linear(texture, point.primitive, point.parameters);
        let direction = Vec2::new(2.0 * r - 1.0, 2.0 * g - 1.0).try_normalize().unwrap_or(Vec2::X);
        (source.strength * b, [cos * direction.x - sin * direction.y, sin * direction.x + cos * direction.y])
    }

    #[inline]
    fn factor(&self, source: FactorSource, point: &SurfacePoint) -> f32 {
        match source.texture {
            Some((texture, channel)) => {
                source.value * self.rgba_linear(texture, point.primitive, point.parameters)[channel]
            }
            None => source.value,
        }
    }

    /// A colour times that of the vertices (§3.7.2.1, `COLOR_0`). An RGB colour is upsampled after the product.
    #[inline]
    fn base_colour(&self, source: ColourSource, point: &SurfacePoint, wavelengths: &Wavelengths) -> SampledSpectrum {
        let Some(vertex) = self.geometry.colour(point.primitive, point.parameters) else {
            return self.colour(source, point, wavelengths);
        };
        let vertex = [vertex.x, vertex.y, vertex.z];
        match source {
            ColourSource::Texture { factor, texture } => {
                let factor = [0, 1, 2].map(|i| factor[i] * vertex[i]);
                self.colour(ColourSource::Texture { factor, texture }, point, wavelengths)
            }
            ColourSource::Spectrum(_) | ColourSource::SpectrumTexture { .. } => {
                self.colour(source, point, wavelengths) * reflectance_polynomial(vertex).sample(wavelengths)
            }
        }
    }

    #[inline]
    fn colour(&self, source: ColourSource, point: &SurfacePoint, wavelengths: &Wavelengths) -> SampledSpectrum {
        self.colour_at(source, point.primitive, point.parameters, wavelengths)
    }

    /// A colour at a point of a primitive.
    #[inline]
    pub(crate) fn colour_at(
        &self,
        source: ColourSource,
        primitive: Primitive,
        uv: [f32; 2],
        wavelengths: &Wavelengths,
    ) -> SampledSpectrum {
        match source {
            ColourSource::Spectrum(id) => self.spectra.sample(id, wavelengths),
            ColourSource::Texture { factor, texture } => {
                let texel = self.texel(texture, primitive, uv);
                let rgb = [0, 1, 2].map(|i| (factor[i] * texel[i]).clamp(0.0, 1.0));
                reflectance_polynomial(rgb).sample(wavelengths)
            }
            ColourSource::SpectrumTexture { spectrum, texture } => {
                let texel = self.texel(texture, primitive, uv);
                self.spectra.sample(spectrum, wavelengths) * reflectance_polynomial(texel).sample(wavelengths)
            }
        }
    }

    /// The shading frame: interpolated normal, bumps, tangent.
    #[inline]
    fn frame(&self, material: &Material, point: &SurfacePoint, wo: Vec3, two_sided: bool) -> Frame {
        self.mapped_frame(material.normal_map, point, wo, two_sided)
    }

    /// Shading frame with the normal map applied, if there is one.
    #[inline]
    fn mapped_frame(&self, map: Option<NormalMap>, point: &SurfacePoint, wo: Vec3, two_sided: bool) -> Frame {
        let mut normal = point.shading_normal;
        let mut geometric = point.geometric_normal;
        if let Some(map) = map {
            let [x, y, z, _] = self.rgba_linear(map.texture, point.primitive, point.parameters).map(|c| 2.0 * c - 1.0);
            let base = Frame::from_normal_tangent(normal, point.tangent);
            let bitangent = base.y * point.handedness;
            let bumped = base.x * (x * map.scale) + bitangent * (y * map.scale) + normal * z;
            normal = bumped.try_normalize().unwrap_or(normal);
        }
        if two_sided && wo.dot(geometric) < 0.0 {
            normal = -normal;
            geometric = -geometric;
        }
        // A shading normal that the viewer sees from behind has no meaning for opaque surfaces; the nearest one that is
        // seen edge-on at least is made of it.
        if two_sided {
            let cos = wo.dot(normal);
            if cos < MIN_SHADING_COSINE {
                normal = (normal + wo * (MIN_SHADING_COSINE - cos)).try_normalize().unwrap_or(geometric);
            }
        }
        if point.tangent == Vec3::ZERO {
            Frame::from_normal(normal)
        } else {
            Frame::from_normal_tangent(normal, point.tangent)
        }
    }
}

/// The values of parameters at a point.
struct LookUp<'a> {
    scene: &'a Scene,
    point: &'a SurfacePoint,
    wavelengths: &'a Wavelengths,
}

impl Map<Tabled, Sampled> for LookUp<'_> {
    #[inline]
    fn colour(&mut self, colour: &ColourSource) -> SampledSpectrum {
        self.scene.colour(*colour, self.point, self.wavelengths)
    }

    #[inline]
    fn spectrum(&mut self, spectrum: &SpectrumId) -> SampledSpectrum {
        self.scene.spectra.sample(*spectrum, self.wavelengths)
    }

    #[inline]
    fn index(&mut self, index: &RelativeIndex<SpectrumId>) -> RelativeIndex {
        RelativeIndex { eta: self.spectrum(&index.eta), dispersive: index.dispersive, is_one: index.is_one }
    }

    #[inline]
    fn distribution(&mut self, distribution: &Ggx) -> Ggx {
        *distribution
    }
}
