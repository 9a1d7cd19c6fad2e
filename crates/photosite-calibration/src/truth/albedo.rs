//! The part of the light that a surface point scatters.

use std::sync::LazyLock;

use glam::{DMat3, DVec3, Vec3};

use photosite_core::colour::ColourSpace;
use photosite_core::spectrum::{Wavelengths, cie, illuminant};
use photosite_transport::geometry::SurfacePoint;
use photosite_transport::sampler::{Sampler, SamplerKind};
use photosite_transport::scene::Scene;

/// Bundles of four wavelengths, and scattered directions.
const BUNDLES: u16 = 16;
const FIRST_NM: f32 = 380.0;
/// Distance of neighbouring wavelengths: 64 from 380 to 780 nm, beyond which eyes see next to nothing.
const STEP_NM: f32 = 6.25;

/// Quadrature from a reflectance to linear sRGB: wavelengths, with the weight of each in X, Y and Z under D65, and XYZ
/// → RGB.
struct Quadrature {
    bundles: Vec<(Wavelengths, [DVec3; 4])>,
    to_rgb: DMat3,
}

static QUADRATURE: LazyLock<Quadrature> = LazyLock::new(|| {
    let weight = |lambda: f32| {
        let light = f64::from(illuminant::d65().eval(lambda));
        DVec3::from_array(cie::observer().each_ref().map(|bar| f64::from(bar.eval(lambda)) * light))
    };
    let bundle = |b: u16| {
        let lambdas = [0, 1, 2, 3].map(|lane| FIRST_NM + STEP_NM * (f32::from(b + BUNDLES * lane) + 0.5));
        (Wavelengths::new(lambdas, [1.0; 4]), lambdas.map(weight))
    };
    let bundles: Vec<_> = (0..BUNDLES).map(bundle).collect();
    let white: DVec3 = bundles.iter().flat_map(|(_, weights)| weights).sum();
    let space = ColourSpace::Srgb;
    // White is scaled to the space's own, so that what reflects everything is (1, 1, 1) exactly.
    let to_rgb = space.to_xyz().inverse() * DMat3::from_diagonal(space.white() / white);
    Quadrature { bundles, to_rgb }
});

/// Directional-hemispherical reflectance plus transmittance ρ(ωo, λ) = ∫ f(ωo, ωi, λ)·|cos θi| dωi towards the viewer,
/// as linear sRGB under D65: ∫ ρ·D65·(x̄, ȳ, z̄) dλ, scaled so that white is 1. Colours beyond sRGB have negative
/// parts.
///
/// The integral over directions is estimated from one sample for each bundle of wavelengths; it is exact where
/// f·cos/pdf does not depend on the direction, as for diffuse surfaces and mirrors. `pixel` keys the samples.
pub(super) fn albedo(scene: &Scene, point: &SurfacePoint, wo: Vec3, pixel: u64) -> DVec3 {
    let Quadrature { bundles, to_rgb } = &*QUADRATURE;
    let mut xyz = DVec3::ZERO;
    let mut sampler = Sampler::new(SamplerKind::Sobol, 0);
    for (index, (wavelengths, weights)) in bundles.iter().enumerate() {
        sampler.start(pixel, index as u32);
        let shading = scene.shading(point, wo, wavelengths);
        let (u_lobe, u) = (sampler.next_1d(), sampler.next_2d());
        let Some(sample) = shading.bsdf.sample(shading.frame.to_local(wo), u_lobe, u) else { continue };
        let throughput = sample.throughput();
        // Where colours part, each of the four stands for itself, and the first is asked for all.
        let alone = sample.terminates_secondary || shading.bsdf.needs_single_wavelength();
        for (lane, weight) in weights.iter().enumerate() {
            xyz += *weight * f64::from(throughput[if alone { 0 } else { lane }]);
        }
    }
    *to_rgb * xyz
}
