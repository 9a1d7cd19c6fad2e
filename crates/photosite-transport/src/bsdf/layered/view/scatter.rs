//! The lobes: their choice, their sampling and their values.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec3, Vec4};

use super::reflectance::{coat_fresnel, coat_reflectance};
use super::state::{EnergySplit, Lobes, ONE, View, ZERO, at_least_zero};
use crate::bsdf::directions::{GRAZING, is_above, mirrored};
use crate::bsdf::fresnel;
use crate::bsdf::refraction::{self, Refraction};
use crate::bsdf::sample::{BsdfEval, BsdfSample};
use crate::bsdf::sheen;
use photosite_core::math::{Frame, Pdf, warp};
use photosite_core::spectrum::SampledSpectrum;

impl View<'_> {
    /// Probabilities in proportion to what each lobe gives back of light from `wo`.
    #[inline]
    pub(super) fn choose(&self) -> Option<Lobes> {
        let (layers, seen) = (self.layers, &self.seen);
        let [metal, coloured, clear] = layers.parts();
        let layered = self.layered_part();
        let mut lobes = Lobes {
            coat: layered * seen.coat,
            sheen: layered * seen.sheen.mean() * (1.0 - seen.coat),
            facets: coloured * seen.dielectric.mean(),
            through: 0.0,
            base: self.base_albedo(false).mean(),
            base_behind: self.base_albedo(true).mean(),
        };
        if metal > 0.0 {
            lobes.facets += metal * (seen.white * self.reflectance(layers.base_colour, self.wo.z)).mean();
        }
        if let Some(volume) = self.refracting {
            let mut reflected = self.clear_reflectance(volume, self.wo.z.min(1.0));
            if !self.passes_undisturbed() {
                // Where the surface as a whole reflects all or nothing, some of its facets do not.
                reflected = SampledSpectrum(reflected.0.clamp(Vec4::splat(0.1), Vec4::splat(0.9)));
            }
            lobes.facets += clear * reflected.mean();
            lobes.through = clear * ((ONE - reflected) * layers.base_colour).mean();
        } else if clear > 0.0 {
            lobes.facets += clear * seen.dielectric.mean();
            lobes.through = clear * (at_least_zero(seen.white - seen.dielectric) * layers.base_colour).mean();
        }
        lobes.normalised()
    }

    /// Part of the remaining light that is sampled evenly over the hemisphere rather than by the cosine: light that
    /// facets leave comes mostly from near the surface, where the cosine seldom looks.
    #[inline]
    pub(super) fn even_part(&self) -> f32 {
        let [_, coloured, _] = self.layers.parts();
        if coloured < 1.0 { 0.5 } else { 0.0 }
    }

    /// Density of what [`Self::sample_base`] draws, at the cosine `z`.
    #[inline]
    pub(super) fn base_density(&self, z: f32) -> f32 {
        let even = self.even_part();
        FRAC_1_PI * ((1.0 - even) * z + even * 0.5)
    }

    #[inline]
    pub(super) fn sample_base(&self, u_part: f32, u: [f32; 2]) -> Vec3 {
        if u_part < self.even_part() { warp::uniform_cone(u, 0.0) } else { warp::cosine_hemisphere(u).into() }
    }

    /// Whether light passes the layers in one direction only.
    #[inline]
    pub(super) fn passes_undisturbed(&self) -> bool {
        let distribution = self.layers.distribution;
        self.refracting.map_or(distribution.is_smooth(), |v| refraction::is_delta(v.eta, distribution))
    }

    /// The part of the surface that layers lie on: all but the refracting one.
    #[inline]
    pub(super) fn layered_part(&self) -> f32 {
        let [_, _, clear] = self.layers.parts();
        if self.refracting.is_some() { 1.0 - clear } else { 1.0 }
    }

    /// The facets' reflectance, all parts of the base together, under the layers between `wo` and what sees `other`.
    #[inline]
    pub(super) fn facets(&self, cos: f32, other: &EnergySplit) -> SampledSpectrum {
        let layers = self.layers;
        let [metal, coloured, clear] = layers.parts();
        let mut sum = ZERO;
        if metal > 0.0 {
            sum += self.reflectance(layers.base_colour, cos) * metal;
        }
        let schlick = if self.refracting.is_some() { coloured } else { coloured + clear };
        if schlick > 0.0 {
            sum += self.reflectance(layers.f0, cos) * (layers.specular * schlick);
        }
        sum *= self.cover(other);
        if let Some(volume) = self.refracting {
            sum += self.clear_reflectance(volume, cos) * clear;
        }
        sum
    }

    /// Value and density of all lobes of some width.
    #[inline]
    pub(in crate::bsdf::layered) fn eval(&self, wi: Vec3) -> BsdfEval {
        if wi.z > 0.0 { self.eval_reflection(wi) } else { self.eval_transmission(wi) }
    }

    #[inline]
    pub(super) fn eval_reflection(&self, wi: Vec3) -> BsdfEval {
        let layers = self.layers;
        let other = self.energy_split(&self.under(wi));
        let mut f = self.base(&other, false);
        let mut pdf = self.lobes.base * self.base_density(wi.z);
        if !layers.distribution.is_smooth() && self.lobes.facets > 0.0 {
            let kernel = layers.distribution.reflection(self.wo, wi);
            f += self.facets(kernel.cos_facet, &other) * kernel.value;
            pdf += self.lobes.facets * kernel.pdf;
        }
        if let Some(sheen) = layers.sheen {
            let below_coat = 1.0 - self.seen.coat.max(other.coat);
            let excess = self.seen.sheen_excess.max(other.sheen_excess);
            let value = sheen::published(sheen.alpha, self.wo, wi) / excess;
            f += sheen.colour * (value * below_coat * self.layered_part());
            pdf += self.lobes.sheen / TAU;
        }
        if let Some(coat) = layers.coat.filter(|coat| !coat.distribution.is_smooth()) {
            let frame = Frame::from_normal(coat.normal);
            let (wo, wi_coat) = (frame.to_local(self.wo), frame.to_local(wi));
            if is_above(wo) && is_above(wi_coat) {
                let kernel = coat.distribution.reflection(wo, wi_coat);
                let value = self.layered_part() * coat_reflectance(coat.weight, &kernel);
                f += SampledSpectrum::splat(value * wi_coat.z / wi.z);
                pdf += self.lobes.coat * kernel.pdf;
            }
        }
        BsdfEval { f, pdf: Pdf::new(pdf) }
    }

    #[inline]
    pub(super) fn eval_transmission(&self, wi: Vec3) -> BsdfEval {
        let layers = self.layers;
        let [_, _, clear] = layers.parts();
        let mirror = mirrored(wi);
        let other = self.energy_split(&self.under(mirror));
        let mut f = self.base(&other, true);
        let mut pdf = self.lobes.base_behind * self.base_density(mirror.z);
        if clear > 0.0 && !self.passes_undisturbed() {
            let tint = layers.base_colour * clear;
            match self.refracting {
                None => {
                    let kernel = layers.distribution.reflection(self.wo, mirror);
                    let let_in = ONE - self.reflectance(layers.f0, kernel.cos_facet) * layers.specular;
                    f += let_in * tint * self.cover(&other) * kernel.value;
                    pdf += self.lobes.through * kernel.pdf;
                }
                Some(volume) => {
                    if let Some(facet) = Refraction::between(volume.eta[0], self.wo, wi) {
                        let (cos_o, cos_i) = (facet.cos_o.min(1.0), facet.cos_i.min(1.0));
                        let exact = fresnel::between(cos_o, cos_i, facet.eta).reflectance.min(1.0);
                        let cos_outside = if self.is_inside { cos_i } else { cos_o };
                        let reflected =
                            self.refracting_reflectance(SampledSpectrum::splat(exact), volume.eta, cos_outside);
                        let (value, density) = refraction::refraction(layers.distribution, self.wo, wi, &facet);
                        f += at_least_zero(ONE - reflected) * tint * value;
                        pdf += self.lobes.through * density;
                    }
                }
            }
        }
        BsdfEval { f, pdf: Pdf::new(pdf) }
    }

    #[inline]
    pub(in crate::bsdf::layered) fn sample(&self, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let layers = self.layers;
        let Lobes { coat, sheen, facets, through, base, base_behind } = self.lobes;
        // Where u_lobe lies among the probabilities laid end to end.
        let [to_coat, to_sheen] = [coat, coat + sheen];
        let to_facets = to_sheen + facets;
        let to_through = to_facets + through;
        let to_base = to_through + base;
        let wi = if u_lobe < to_coat {
            let layer = layers.coat?;
            let frame = Frame::from_normal(layer.normal);
            let wo = frame.to_local(self.wo);
            if !is_above(wo) {
                return None;
            }
            if layer.distribution.is_smooth() {
                let wi = frame.to_world(Vec3::new(-wo.x, -wo.y, wo.z));
                let part = self.layered_part() * layer.weight * coat_fresnel(wo.z.min(1.0));
                return is_above(wi).then(|| BsdfSample::mirrored(SampledSpectrum::splat(part), wi, coat));
            }
            frame.to_world(layer.distribution.sample_reflection(wo, u)?.0)
        } else if u_lobe < to_sheen {
            warp::uniform_cone(u, 0.0)
        } else if u_lobe < to_facets {
            if layers.distribution.is_smooth() {
                let wi = Vec3::new(-self.wo.x, -self.wo.y, self.wo.z);
                let other = self.energy_split(&self.under(wi));
                return Some(BsdfSample::mirrored(self.facets(self.wo.z.min(1.0), &other), wi, facets));
            }
            layers.distribution.sample_reflection(self.wo, u)?.0
        } else if u_lobe < to_through {
            if self.passes_undisturbed() {
                return self.pass_undisturbed();
            }
            self.sample_through(u)?
        } else if u_lobe < to_base {
            self.sample_base((u_lobe - to_through) / base, u)
        } else if base_behind > 0.0 {
            mirrored(self.sample_base((u_lobe - to_base) / base_behind, u))
        } else {
            // Rounding of the sum.
            return None;
        };
        if wi.z.abs() <= GRAZING {
            return None;
        }
        let BsdfEval { f, pdf } = self.eval(wi);
        let sample = BsdfSample::reflected(f, wi, pdf);
        (pdf.0 > 0.0).then(|| {
            if wi.z > 0.0 {
                sample
            } else {
                BsdfSample { is_transmission: true, eta: self.refracting.map_or(1.0, |v| v.eta[0]), ..sample }
            }
        })
    }

    /// Passes light straight on, or refracted by a polished surface.
    #[inline]
    pub(in crate::bsdf::layered) fn pass_undisturbed(&self) -> Option<BsdfSample> {
        let layers = self.layers;
        let [_, _, clear] = layers.parts();
        let cos = self.wo.z.min(1.0);
        let (eta, cos_through, let_in, dispersive) = match self.refracting {
            None => (1.0, cos, ONE - self.reflectance(layers.f0, cos) * layers.specular, false),
            Some(volume) => {
                let through = fresnel::dielectric(cos, volume.eta[0]).cos_transmitted;
                (volume.eta[0], through, ONE - self.clear_reflectance(volume, self.wo.z.min(1.0)), volume.dispersive)
            }
        };
        if cos_through <= GRAZING {
            return None;
        }
        let wi = Vec3::new(-self.wo.x / eta, -self.wo.y / eta, -cos_through);
        let cover = match self.refracting {
            None => self.cover(&self.energy_split(&self.under(mirrored(wi)))),
            Some(_) => ONE,
        };
        let part = at_least_zero(let_in) * layers.base_colour * cover * clear;
        Some(BsdfSample {
            f: part * refraction::lanes(1.0 / (eta * eta * cos_through), dispersive),
            is_transmission: true,
            terminates_secondary: dispersive,
            eta,
            ..BsdfSample::mirrored(ONE, wi, self.lobes.through)
        })
    }

    /// Samples a direction through a facet.
    #[inline]
    pub(super) fn sample_through(&self, u: [f32; 2]) -> Option<Vec3> {
        let distribution = self.layers.distribution;
        match self.refracting {
            None => distribution.sample_reflection(self.wo, u).map(|(wi, _)| mirrored(wi)),
            Some(volume) => {
                let m = distribution.sample_visible(self.wo, u);
                let cos_o = self.wo.dot(m).clamp(0.0, 1.0);
                let eta = volume.eta[0];
                let cos_transmitted = fresnel::dielectric(cos_o, eta).cos_transmitted;
                Refraction::by(eta, self.wo, m, cos_o, cos_transmitted).map(|(_, wi)| wi)
            }
        }
    }
}

impl Lobes {
    #[inline]
    pub(super) fn normalised(self) -> Option<Self> {
        let Self { coat, sheen, facets, through, base, base_behind } = self;
        let sum = coat + sheen + facets + through + base + base_behind;
        (sum > 0.0).then(|| Self {
            coat: coat / sum,
            sheen: sheen / sum,
            facets: facets / sum,
            through: through / sum,
            base: base / sum,
            base_behind: base_behind / sum,
        })
    }
}
