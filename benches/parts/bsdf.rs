//! Evaluating and sampling of every scattering model.

use std::fmt;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::Vec3;
use photosite::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, Ggx, Layered, RelativeIndex};
use photosite::math::hash::{hash64, unit_f32};
use photosite::math::warp;
use photosite::spectrum::SampledSpectrum;

/// Pairs of directions a call.
const DIRECTIONS: u64 = 1000;

struct Model {
    name: &'static str,
    bsdf: Bsdf,
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

fn models() -> [Model; 6] {
    let spectrum = SampledSpectrum::splat;
    let (smooth, rough) = (Ggx::from_roughness(0.0, 0.0), Ggx::from_roughness(0.4, 0.0));
    let model = |name, bsdf| Model { name, bsdf };
    let conductor = |distribution| {
        Bsdf::Conductor(Conductor { eta: spectrum(0.2), k: spectrum(3.0), distribution, energy_compensation: false })
    };
    let dielectric = |distribution| {
        let index = RelativeIndex { eta: spectrum(1.5), dispersive: false, is_one: false };
        Bsdf::Dielectric(Dielectric { index, distribution, energy_compensation: false })
    };
    let coated = Bsdf::Layered(Layered { base_colour: spectrum(0.5), distribution: rough, ..Layered::default() });
    [
        model("diffuse", Bsdf::Diffuse(Diffuse { reflectance: spectrum(0.5) })),
        model("smooth conductor", conductor(smooth)),
        model("rough conductor", conductor(rough)),
        model("smooth dielectric", dielectric(smooth)),
        model("rough dielectric", dielectric(rough)),
        model("metallic-roughness", coated),
    ]
}

/// Mirrors are left out: there is nothing to evaluate.
#[divan::bench(args = models().into_iter().filter(|model| !model.bsdf.is_delta()))]
fn eval(bencher: Bencher, model: &Model) {
    let pairs: Vec<[Vec3; 2]> = (0..DIRECTIONS).map(|i| [0, 1].map(|k| upward(2 * i + k))).collect();
    bencher
        .counter(ItemsCount::new(DIRECTIONS))
        .bench(|| black_box(&pairs).iter().map(|&[wo, wi]| model.bsdf.eval(wo, wi).pdf.0).sum::<f32>());
}

#[divan::bench(args = models())]
fn sample(bencher: Bencher, model: &Model) {
    let draws: Vec<_> =
        (0..DIRECTIONS).map(|i| (upward(i), number(4 * i), [number(4 * i + 1), number(4 * i + 2)])).collect();
    bencher.counter(ItemsCount::new(DIRECTIONS)).bench(|| {
        let drawn = |&(wo, u_lobe, u)| model.bsdf.sample(wo, u_lobe, u).map_or(0.0, |s| s.pdf.0);
        black_box(&draws).iter().map(drawn).sum::<f32>()
    });
}

fn upward(i: u64) -> Vec3 {
    warp::cosine_hemisphere([number(2 * i), number(2 * i + 1)]).into()
}

fn number(i: u64) -> f32 {
    unit_f32(hash64(7, i) as u32)
}
