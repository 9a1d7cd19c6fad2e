"""BSDFs for Mitsuba that it does not have itself: GGX microfacets with height-correlated shadowing, and glTF's material.

Mitsuba's own multiply the shadowing of the two directions, G = G1(wi)·G1(wo), as if they had nothing to do with each other.
Correlated with the height of the facets it is

    G = 1 / (1 + Λ(wi) + Λ(wo)),    Λ(w) = 1/G1(w) − 1

(E. Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 2014, eq. 99), which is brighter
towards grazing angles. In refraction there is no such simple form, and the product stays. Written from the equations of B. Walter et al., "Microfacet Models for Refraction through Rough
Surfaces", EGSR 2007: eq. 20 and 21 for the BSDF, 13 to 17 for its half vectors and their Jacobians. Mitsuba gives the
distribution, its sampling and G1; directions follow its convention, wi towards the camera.

glTF's metallic-roughness material (glTF 2.0 specification, appendix B) has such facets with α = roughness² and Schlick's
F = F0 + (1 − F0)·(1 − w·m)⁵, F0 that of the index for the coat of what is no metal and the base colour for a metal, mixed by the
metallic factor. Under the coat lies Lambert's law for what the coat as a whole lets in and out (C. Kelemen and
L. Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model", Eurographics 2001): base/π·(1 − E(wi))·
(1 − E(wo))/(1 − mean E), which is photosite's choice where the appendix would give back more than arrives. E, what the
coat reflects of light from one direction, is integrated here. Light that bounces on between the facets of a metal is what
C. Kulla and A. Conty ("Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017) add: with E of white facets and
the mean F of Schlick's factor, metallic·F²·(mean E)/(1 − F·(1 − mean E))·(1 − E(wi))·(1 − E(wo))/(π·(1 − mean E)).
"""

import re

import drjit as dr
import mitsuba as mi
import numpy as np


def correlated(distribution, wi, wo, m):
    """G of two directions and a facet normal, zero where either sees the facet from behind."""
    g1_i, g1_o = distribution.smith_g1(wi, m), distribution.smith_g1(wo, m)
    seen = (g1_i > 0) & (g1_o > 0)
    return dr.select(seen, dr.rcp(dr.rcp(g1_i) + dr.rcp(g1_o) - 1), 0)


def fresnel_conductor(cos, eta, k):
    """Reflectance of unpolarised light at a metal of index eta + ik (Born & Wolf, Principles of Optics, 14.2)."""
    cos2, sin2 = cos * cos, 1 - cos * cos
    t0 = eta * eta - k * k - sin2
    a2_b2 = dr.sqrt(dr.maximum(t0 * t0 + 4 * eta * eta * k * k, 0))
    a = dr.sqrt(dr.maximum(0.5 * (a2_b2 + t0), 0))
    s = (a2_b2 + cos2 - 2 * cos * a) / (a2_b2 + cos2 + 2 * cos * a)
    p = s * (cos2 * a2_b2 + sin2 * sin2 - 2 * cos * sin2 * a) / (cos2 * a2_b2 + sin2 * sin2 + 2 * cos * sin2 * a)
    return 0.5 * (s + p)


class Microfacets(mi.BSDF):
    """What both have: a subclass computes value and density together, in eval_pdf."""

    def eval(self, ctx, si, wo, active):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active):
        return self.eval_pdf(ctx, si, wo, active)[1]


class CorrelatedRoughConductor(Microfacets):
    """Mitsuba's roughconductor with correlated shadowing."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.eta, self.k = props["eta"], props["k"]
        self.alpha_u, self.alpha_v = props["alpha_u"], props["alpha_v"]
        props.mark_queried("distribution"), props.mark_queried("sample_visible")
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.Anisotropic
        self.m_components, self.m_flags = [flags], flags

    def distribution(self):
        return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha_u, self.alpha_v, True)

    def fresnel(self, si, cos, active):
        return fresnel_conductor(cos, self.eta.eval(si, active), self.k.eval(si, active))

    def sample(self, ctx, si, sample1, sample2, active):
        distribution = self.distribution()
        m, pdf = distribution.sample(si.wi, sample2)
        bs = mi.BSDFSample3f()
        bs.wo = mi.reflect(si.wi, m)
        bs.pdf = pdf / (4 * dr.dot(bs.wo, m))
        bs.eta, bs.sampled_component, bs.sampled_type = 1.0, mi.UInt32(0), mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        active &= (mi.Frame3f.cos_theta(si.wi) > 0) & (mi.Frame3f.cos_theta(bs.wo) > 0) & (pdf > 0)
        weight = self.fresnel(si, dr.dot(si.wi, m), active) * correlated(distribution, si.wi, bs.wo, m)
        return bs, dr.select(active, weight / distribution.smith_g1(si.wi, m), 0)

    def eval_pdf(self, ctx, si, wo, active):
        distribution = self.distribution()
        cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active &= (cos_i > 0) & (cos_o > 0)
        m = dr.normalize(si.wi + wo)
        value = distribution.eval(m) * correlated(distribution, si.wi, wo, m) / (4 * cos_i)
        pdf = distribution.pdf(si.wi, m) / (4 * dr.dot(wo, m))
        return dr.select(active, value * self.fresnel(si, dr.dot(si.wi, m), active), 0), dr.select(active, pdf, 0)


class CorrelatedRoughDielectric(Microfacets):
    """Mitsuba's roughdielectric with correlated shadowing. Radiance is scaled by the squared index as it is carried over."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.index = props["int_ior"] / props["ext_ior"]
        self.alpha = props["alpha"]
        props.mark_queried("distribution"), props.mark_queried("sample_visible")
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide | mi.BSDFFlags.NonSymmetric
        self.m_components = [mi.BSDFFlags.GlossyReflection | sides, mi.BSDFFlags.GlossyTransmission | sides]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def distribution(self):
        return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, self.alpha, True)

    def sample(self, ctx, si, sample1, sample2, active):
        distribution = self.distribution()
        cos_i = mi.Frame3f.cos_theta(si.wi)
        m, _ = distribution.sample(dr.mulsign(si.wi, cos_i), sample2)
        reflectance, cos_t, eta_it, eta_ti = mi.fresnel(dr.dot(si.wi, m), mi.Float(self.index))
        reflects = sample1 <= reflectance
        bs = mi.BSDFSample3f()
        bs.wo = dr.select(reflects, mi.reflect(si.wi, m), mi.refract(si.wi, m, cos_t, eta_ti))
        bs.eta = dr.select(reflects, 1.0, eta_it)
        bs.sampled_component = dr.select(reflects, mi.UInt32(0), mi.UInt32(1))
        bs.sampled_type = dr.select(
            reflects, mi.UInt32(+mi.BSDFFlags.GlossyReflection), mi.UInt32(+mi.BSDFFlags.GlossyTransmission)
        )
        value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
        active &= (bs.pdf > 0) & ((mi.Frame3f.cos_theta(bs.wo) * cos_i > 0) == reflects)
        return bs, dr.select(active, value / bs.pdf, 0)

    def eval_pdf(self, ctx, si, wo, active):
        distribution = self.distribution()
        cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        reflects = cos_i * cos_o > 0
        eta = dr.select(cos_i > 0, self.index, 1 / self.index)
        m = dr.normalize(si.wi + wo * dr.select(reflects, 1, eta))
        m = dr.mulsign(m, mi.Frame3f.cos_theta(m))
        i_m, o_m = dr.dot(si.wi, m), dr.dot(wo, m)
        active &= (cos_i != 0) & (cos_o != 0) & (i_m * cos_i > 0) & (o_m * cos_o > 0)
        reflectance = mi.fresnel(i_m, mi.Float(self.index))[0]
        share = dr.select(reflects, reflectance, 1 - reflectance)
        # Jacobian of the half vector; radiance, unlike importance, changes by the squared index.
        refraction = dr.square(eta) * dr.abs(o_m) / dr.square(i_m + eta * o_m)
        jacobian = dr.select(reflects, 1 / (4 * dr.abs(o_m)), refraction)
        scale = dr.select(reflects, 1, 1 / dr.square(eta))
        uncorrelated = distribution.smith_g1(si.wi, m) * distribution.smith_g1(wo, m)
        g = dr.select(reflects, correlated(distribution, si.wi, wo, m), uncorrelated)
        value = share * distribution.eval(m) * g * dr.abs(i_m / cos_i) * jacobian * scale
        pdf = share * distribution.pdf(dr.mulsign(si.wi, cos_i), m) * jacobian
        return mi.UnpolarizedSpectrum(dr.select(active, value, 0)), dr.select(active, pdf, 0)


# Directions for which the coat's albedo is tabulated, even in the root of the cosine.
NODES = 128


def schlick(f0, cos):
    return f0 + (1 - f0) * (1 - cos) ** 5


def facet_albedo(alpha, f0):
    """E of Schlick's F0 at the nodes: ∫ F·D·G·(wo·m)/cos θo dm, the facets m drawn from D·cos θm by the midpoint rule."""
    u, v = np.meshgrid((np.arange(512) + 0.5) / 512, (np.arange(256) + 0.5) / 256)
    cos_m = 1 / np.sqrt(1 + alpha**2 * u / (1 - u))
    sin_m, turn = np.sqrt(1 - cos_m**2), np.pi * v
    albedo = []
    for node in np.arange(NODES) / (NODES - 1):
        cos_o = max(node * node, 1e-4)
        sin_o = np.sqrt(1 - cos_o**2)
        o_m = sin_o * sin_m * np.cos(turn) + cos_o * cos_m
        cos_i = 2 * o_m * cos_m - cos_o
        seen = (o_m > 0) & (cos_i > 0)

        def smith(cos):
            return (np.sqrt(1 + alpha**2 * (1 / np.maximum(cos, 1e-9) ** 2 - 1)) - 1) / 2

        g = 1 / (1 + smith(cos_o) + smith(cos_i))
        albedo.append(np.mean(np.where(seen, schlick(f0, o_m) * g * o_m / (cos_o * cos_m), 0)))
    return np.array(albedo)


class MetallicRoughness(Microfacets):
    """glTF's material of one roughness and metallic factor. Properties are named as those of "principled"."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.base_color, self.metallic = props["base_color"], props["metallic"]
        self.alpha = props["roughness"] ** 2
        self.f0 = ((props["eta"] - 1) / (props["eta"] + 1)) ** 2
        nodes = np.arange(NODES) / (NODES - 1)
        coat, white = facet_albedo(self.alpha, self.f0), facet_albedo(self.alpha, 1)
        # ∫ 2·E·cos dcos, the node being the root of the cosine.
        self.mean_coat, self.mean_white = (float(np.trapezoid(4 * e * nodes**3, nodes)) for e in (coat, white))
        self.coat, self.white = (mi.Float(e.astype(np.float32)) for e in (coat, white))
        lobes = [mi.BSDFFlags.GlossyReflection, mi.BSDFFlags.DiffuseReflection]
        self.m_components = [lobe | mi.BSDFFlags.FrontSide for lobe in lobes]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def distribution(self):
        return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, self.alpha, True)

    def let_through(self, albedo, cos, active):
        """1 − E."""
        place = dr.sqrt(dr.clip(cos, 0, 1)) * (NODES - 1)
        node = dr.minimum(mi.UInt32(place), NODES - 2)
        low, high = dr.gather(mi.Float, albedo, node, active), dr.gather(mi.Float, albedo, node + 1, active)
        return 1 - dr.lerp(low, high, place - node)

    def sample(self, ctx, si, sample1, sample2, active):
        facets = sample1 < 0.5
        m, _ = self.distribution().sample(si.wi, sample2)
        bs = mi.BSDFSample3f()
        bs.wo = dr.select(facets, mi.reflect(si.wi, m), mi.warp.square_to_cosine_hemisphere(sample2))
        bs.eta = 1.0
        bs.sampled_component = dr.select(facets, mi.UInt32(0), mi.UInt32(1))
        bs.sampled_type = dr.select(
            facets, mi.UInt32(+mi.BSDFFlags.GlossyReflection), mi.UInt32(+mi.BSDFFlags.DiffuseReflection)
        )
        value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
        active &= bs.pdf > 0
        return bs, dr.select(active, value / bs.pdf, 0)

    def eval_pdf(self, ctx, si, wo, active):
        distribution = self.distribution()
        cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
        active &= (cos_i > 0) & (cos_o > 0)
        base = self.base_color.eval(si, active)
        m = dr.normalize(si.wi + wo)
        i_m = dr.dot(si.wi, m)
        f0 = self.f0 * (1 - self.metallic) + base * self.metallic
        facets = schlick(f0, i_m) * distribution.eval(m) * correlated(distribution, si.wi, wo, m) / (4 * cos_i)
        def left(albedo, mean):
            return self.let_through(albedo, cos_i, active) * self.let_through(albedo, cos_o, active) / (1 - mean)

        f = base + (1 - base) / 21
        bounced = self.metallic * f * f * self.mean_white / (1 - f * (1 - self.mean_white))
        matt = (1 - self.metallic) * base * left(self.coat, self.mean_coat)
        matt = (matt + bounced * left(self.white, self.mean_white)) * cos_o * dr.inv_pi
        pdf = 0.5 * distribution.pdf(si.wi, m) / (4 * dr.dot(wo, m)) + 0.5 * cos_o * dr.inv_pi
        return dr.select(active, facets + matt, 0), dr.select(active, pdf, 0)


mi.register_bsdf("gltf_principled", MetallicRoughness)
mi.register_bsdf("correlated_roughconductor", CorrelatedRoughConductor)
mi.register_bsdf("correlated_roughdielectric", CorrelatedRoughDielectric)


def load(mitsuba, scene):
    """A scene file with correlated shadowing in place of Mitsuba's own, and glTF's material in place of its nearest."""
    text = scene.read_text(encoding="utf-8")
    text = re.sub(r'type="(roughconductor|roughdielectric)"', r'type="correlated_\1"', text)
    text = text.replace('type="principled"', 'type="gltf_principled"')
    changed = scene.with_name("correlated.xml")
    changed.write_text(text, encoding="utf-8")
    return mitsuba.load_file(str(changed))
