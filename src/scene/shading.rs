//! From a surface point to the frame and the BSDF that light scatters by.

use glam::Vec3;

use super::{ColourSource, Material, ScatteringModel, Scene};
use crate::bsdf::{Bsdf, Ggx};
use crate::geometry::SurfacePoint;
use crate::math::Frame;
use crate::spectrum::upsampling::reflectance_polynomial;
use crate::spectrum::{SampledSpectrum, Wavelengths};

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
        let distribution = |roughness: f32| Ggx::from_roughness(roughness, 0.0);
        let (bsdf, two_sided) = match material.model {
            ScatteringModel::Diffuse { reflectance } => {
                (Bsdf::Diffuse { reflectance: self.colour(reflectance, point, wavelengths) }, true)
            }
            ScatteringModel::Conductor { eta, k, distribution } => {
                let (eta, k) = (self.spectra.sample(eta, wavelengths), self.spectra.sample(k, wavelengths));
                (Bsdf::Conductor { eta, k, distribution }, true)
            }
            ScatteringModel::Dielectric { eta, dispersive, distribution } => {
                (Bsdf::Dielectric { eta: self.spectra.sample(eta, wavelengths), dispersive, distribution }, false)
            }
            ScatteringModel::MetallicRoughness { base_colour, mut metallic, mut roughness, texture } => {
                if let Some(texture) = texture {
                    let [_, g, b, _] = self.rgba_linear(texture, point.triangle, point.barycentric);
                    metallic *= b;
                    roughness *= g;
                }
                let base_colour = self.colour(base_colour, point, wavelengths);
                (Bsdf::MetallicRoughness { base_colour, metallic, distribution: distribution(roughness) }, true)
            }
        };
        Shading { frame: self.frame(material, point, wo, two_sided), bsdf }
    }

    #[inline]
    fn colour(&self, source: ColourSource, point: &SurfacePoint, wavelengths: &Wavelengths) -> SampledSpectrum {
        match source {
            ColourSource::Spectrum(id) => self.spectra.sample(id, wavelengths),
            ColourSource::Texture { factor, texture } => {
                let texel = self.texel(texture, point.triangle, point.barycentric);
                let rgb = [0, 1, 2].map(|i| (factor[i] * texel[i]).clamp(0.0, 1.0));
                reflectance_polynomial(rgb).sample(wavelengths)
            }
            ColourSource::SpectrumTexture { spectrum, texture } => {
                let texel = self.texel(texture, point.triangle, point.barycentric);
                self.spectra.sample(spectrum, wavelengths) * reflectance_polynomial(texel).sample(wavelengths)
            }
        }
    }

    /// The shading frame: interpolated normal, bumps, tangent.
    #[inline]
    fn frame(&self, material: &Material, point: &SurfacePoint, wo: Vec3, two_sided: bool) -> Frame {
        let mut normal = point.shading_normal;
        let mut geometric = point.geometric_normal;
        if let Some(map) = material.normal_map {
            let [x, y, z, _] = self.rgba_linear(map.texture, point.triangle, point.barycentric).map(|c| 2.0 * c - 1.0);
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
            const EDGE_ON: f32 = 1e-3;
            if cos < EDGE_ON {
                normal = (normal + wo * (EDGE_ON - cos)).try_normalize().unwrap_or(geometric);
            }
        }
        if point.tangent == Vec3::ZERO {
            Frame::from_normal(normal)
        } else {
            Frame::from_normal_tangent(normal, point.tangent)
        }
    }
}
