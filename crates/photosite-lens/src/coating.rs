//! Reflectance and transmittance of thin films on a surface, by transfer matrices.

use photosite_fft::Complex64;

use photosite_core::spectrum::{LAMBDA_MAX_NM, LAMBDA_MIN_NM};

use crate::prescription::{Coating, Layer, LayerIndex};
use crate::profile::Travel;
use crate::trace::{Hit, LensAt};

/// Coating of a surface between air and glass where the prescription gives none, as patents do: a quarter wave of
/// magnesium fluoride at 550 nm, index 1.38. It reflects 1.3 % where bare glass of index 1.5 reflects 4.2 %.
pub const DEFAULT_COATING: Layer =
    Layer { index: LayerIndex::Constant { n: 1.38, k: 0.0 }, thickness_nm: 550.0 / (4.0 * 1.38) };

/// Side of a surface that light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Side of the coating's first layer.
    Air,
    /// Side of the coating's last layer.
    Glass,
}

/// Fractions of light reflected and transmitted at a surface, for the polarisations s and p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Reflectance, 0–1.
    pub reflectance: [f64; 2],
    /// Transmittance, 0–1. The rest of 1 is absorbed.
    pub transmittance: [f64; 2],
}

impl Split {
    /// Reflectance for unpolarised light.
    pub fn mean_reflectance(&self) -> f64 {
        0.5 * (self.reflectance[0] + self.reflectance[1])
    }

    /// Transmittance for unpolarised light.
    pub fn mean_transmittance(&self) -> f64 {
        0.5 * (self.transmittance[0] + self.transmittance[1])
    }
}

impl LayerIndex {
    /// Complex index n − ik at a wavelength; beyond 300–1100 nm a table gives that at its nearer end.
    fn at(&self, wavelength_nm: f64) -> Complex64 {
        match self {
            Self::Constant { n, k } => Complex64::new(*n, -k),
            Self::Table { n, k } => {
                let nm = (wavelength_nm as f32).clamp(LAMBDA_MIN_NM, LAMBDA_MAX_NM);
                Complex64::new(f64::from(n.eval(nm)), -f64::from(k.eval(nm)))
            }
        }
    }
}

/// Reflectance and transmittance of a coating at a wavelength in nm for light from a medium of index `index` on one
/// side into the medium of index `index_behind` on the other; `cos_incidence` is in the first medium. Beyond the
/// critical angle all light that the films do not absorb is reflected.
///
/// With Snell's n·sin θ in all films, phases δ = 2π·n·d·cos θ/λ and admittances η = n·cos θ (s) or n/cos θ (p), the films'
/// matrices ((cos δ, i·sin δ/η), (i·η·sin δ, cos δ)) in their order turn (1, η′) of the last medium into (B, C); then
/// R = |(η₀B − C)/(η₀B + C)|² and T = 4η₀·Re η′/|η₀B + C|² ([Born99](photosite_core::references#born99) §1.6,
/// [Macleod10](photosite_core::references#macleod10) §2.6).
pub fn split(
    layers: &[Layer],
    from: Side,
    index: f64,
    index_behind: f64,
    cos_incidence: f64,
    wavelength_nm: f64,
) -> Split {
    let sine = index * (1.0 - cos_incidence * cos_incidence).max(0.0).sqrt();
    let cosine = |n: Complex64| {
        let cosine = (1.0 - (sine / n).powi(2)).sqrt();
        // Of the two roots, that of a wave which decays into the medium.
        if (n * cosine).im > 0.0 { -cosine } else { cosine }
    };
    let of_polarisation = |admittance: &dyn Fn(Complex64, Complex64) -> Complex64| {
        let behind = Complex64::from(index_behind);
        let last = admittance(behind, cosine(behind));
        let (mut b, mut c) = (Complex64::ONE, last);
        for i in 0..layers.len() {
            // From the film that the light meets last to the first.
            let layer = match from {
                Side::Air => &layers[layers.len() - 1 - i],
                Side::Glass => &layers[i],
            };
            let n = layer.index.at(wavelength_nm);
            let cosine = cosine(n);
            let eta = admittance(n, cosine);
            let phase = std::f64::consts::TAU * layer.thickness_nm / wavelength_nm * n * cosine;
            let (sin, cos) = (Complex64::I * phase.sin(), phase.cos());
            (b, c) = (cos * b + sin / eta * c, sin * eta * b + cos * c);
        }
        let first = admittance(Complex64::from(index), Complex64::from(cos_incidence));
        let sum = first * b + c;
        let reflectance = ((first * b - c) / sum).norm_sqr();
        [reflectance, 4.0 * first.re * last.re / sum.norm_sqr()]
    };
    let [s, p] = [of_polarisation(&|n, cosine| n * cosine), of_polarisation(&|n, cosine| n / cosine)];
    Split { reflectance: [s[0], p[0]], transmittance: [s[1], p[1]] }
}

impl LensAt<'_> {
    /// Reflectance and transmittance at a surface that a ray meets: those of its coating, of [`DEFAULT_COATING`] where
    /// none is known, of bare glass at cemented surfaces. A surface between air and air, such as a stop, transmits all
    /// light.
    pub fn split_at(&self, hit: &Hit) -> Split {
        let is_glass = |surface: usize| self.lens.surfaces()[surface].glass.is_some();
        let is_glass_before = hit.surface > 0 && is_glass(hit.surface - 1);
        let is_in_glass = if hit.travel == Travel::ToSensor { is_glass_before } else { is_glass(hit.surface) };
        let from = if is_in_glass { Side::Glass } else { Side::Air };
        let layers = self.layers(hit.surface);
        split(layers, from, hit.index, hit.index_behind, hit.cos_incidence, self.wavelength_nm)
    }

    /// Layers on a surface.
    fn layers(&self, surface: usize) -> &[Layer] {
        let surfaces = self.lens.surfaces();
        let is_glass_before = surface > 0 && surfaces[surface - 1].glass.is_some();
        match &surfaces[surface].coating {
            Coating::Unknown | Coating::Uncoated | Coating::Layers(_)
                if is_glass_before == surfaces[surface].glass.is_some() =>
            {
                &[]
            }
            Coating::Unknown => &[DEFAULT_COATING],
            Coating::Uncoated => &[],
            Coating::Layers(layers) => layers,
        }
    }
}

/// Transmittance of a surface for unpolarised light, by the cosine of the angle in the thinner of its two media. It is
/// the same from both sides.
pub(crate) fn transmittance_of(at: &LensAt<'_>, surface: usize, cosine: f64) -> f64 {
    let (before, behind) = (at.index_before(surface), at.index_before(surface + 1));
    let from_air =
        split(at.layers(surface), Side::Air, before.min(behind), before.max(behind), cosine, at.wavelength_nm);
    from_air.mean_transmittance()
}
