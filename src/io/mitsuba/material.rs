//! Materials as BSDFs of Mitsuba.

use super::element::Element;
use super::output::{Output, quoted};
use super::picture::{bitmap, planes};
use crate::scene::description::{
    AlphaMode, Colour, Conductor, Dielectric, Diffuse, LayeredDescription, MaterialDescription, MaterialModel,
    OrenNayar, Phong, Retroreflective, SceneDescription, TextureDescription, TexturedColour, ThinDielectric,
    Translucent,
};
use crate::spectrum::upsampling::reflectance_spectrum;
use crate::texture::{Bitmap, Filter, UvTransform};

/// Yellow line of sodium, nm: the index of a dispersive glass is taken here.
const SODIUM_NM: f64 = 589.3;

/// A material in the scene file.
pub(super) struct ExportedMaterial {
    pub(super) id: String,
    pub(super) bsdf: Element,
    /// The UVs that its textures want in the mesh: Mitsuba's textures have no choice and no exact transform of their
    /// own.
    pub(super) uv_set: usize,
    pub(super) uv_transform: UvTransform,
}

/// All materials, in the order of the scene.
pub(super) fn materials(scene: &SceneDescription, out: &mut Output) -> Vec<ExportedMaterial> {
    let material = |(index, material)| export(index, material, &Textures { scene, index }, out);
    scene.materials.iter().enumerate().map(material).collect()
}

fn export(index: usize, material: &MaterialDescription, textures: &Textures<'_>, out: &mut Output) -> ExportedMaterial {
    let name = quoted("material", &material.name);
    let textures_used = material.textures();
    let mut used = textures_used.iter();
    let (uv_set, uv_transform) = used.next().map_or((0, UvTransform::default()), |t| (t.uv_set, t.transform));
    if used.any(|t| (t.uv_set, t.transform) != (uv_set, uv_transform)) {
        out.approximate(format!("textures of {name} with UVs of their own: those of the first serve all"));
    }
    let (mut bsdf, sides) = scattering(&material.model, &name, textures, out);
    if let Some((texture, scale)) = &material.normal_map {
        let image = textures.image(texture);
        let file = textures.file("normal", image, &["R", "G", "B"], out, |i| {
            // Only x and y are scaled; what is stored is (n + 1)/2.
            let [x, y, z, _] = image.linear_texel(i);
            let scaled = |c: f32| ((2.0 * c - 1.0) * scale + 1.0) / 2.0;
            [scaled(x), scaled(y), z]
        });
        bsdf = Element::object("bsdf", "normalmap")
            // Neither softens the terminator.
            .boolean("use_shadowing_function", false)
            .boolean("flip_invalid_normals", false)
            .child(bitmap("normalmap", &file, true, texture, out))
            .child(bsdf);
    }
    // A dielectric has two sides of its own; of everything else we look at both, and Mitsuba at the front alone.
    if sides == Sides::One {
        bsdf = Element::object("bsdf", "twosided").child(bsdf);
    }
    bsdf = masked(bsdf, material, &name, textures, out);
    let id = format!("material-{index}");
    ExportedMaterial { bsdf: bsdf.attribute("id", &id), id, uv_set, uv_transform }
}

/// Which sides Mitsuba's model is for: "twosided" refuses those that are for both.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sides {
    One,
    Both,
}

fn scattering(model: &MaterialModel, name: &str, textures: &Textures<'_>, out: &mut Output) -> (Element, Sides) {
    match model {
        MaterialModel::Diffuse(Diffuse { reflectance }) => (textures.diffuse(reflectance, name, out), Sides::One),
        MaterialModel::Conductor(Conductor { eta, k, distribution }) => {
            let microfacets = distribution.distribution();
            let bsdf = if microfacets.is_smooth() {
                Element::object("bsdf", "conductor")
            } else {
                out.approximate(shadowing(name));
                let [u, v] = microfacets.alpha().map(f64::from);
                ggx(Element::object("bsdf", "roughconductor")).float("alpha_u", u).float("alpha_v", v)
            };
            (bsdf.spectrum("eta", eta).spectrum("k", k), Sides::One)
        }
        MaterialModel::Dielectric(Dielectric { index, distribution }) => {
            if !index.is_constant() {
                out.approximate(format!("the dispersion of {name}: its index is that at {SODIUM_NM} nm"));
            }
            let microfacets = distribution.distribution();
            let bsdf = if microfacets.is_smooth() {
                Element::object("bsdf", "dielectric")
            } else {
                out.approximate(shadowing(name));
                ggx(Element::object("bsdf", "roughdielectric")).float("alpha", microfacets.alpha()[0].into())
            };
            (bsdf.float("int_ior", index.index(SODIUM_NM)).float("ext_ior", 1.0), Sides::Both)
        }
        MaterialModel::OrenNayar(OrenNayar { reflectance, roughness: _ }) => {
            out.approximate(format!("the relief of {name}: it becomes \"diffuse\""));
            (textures.diffuse(reflectance, name, out), Sides::One)
        }
        MaterialModel::Phong(Phong { diffuse, specular: _, exponent: _ }) => {
            out.approximate(format!("Phong's lobe of {name}: it is left out"));
            (textures.diffuse(diffuse, name, out), Sides::One)
        }
        MaterialModel::Translucent(Translucent { reflectance, transmittance: _ }) => {
            out.approximate(format!("the light that passes {name}: it is left out"));
            (textures.diffuse(reflectance, name, out), Sides::One)
        }
        MaterialModel::ThinDielectric(ThinDielectric { index, transmittance }) => {
            if !index.is_constant() {
                out.approximate(format!("the dispersion of {name}: its index is that at {SODIUM_NM} nm"));
            }
            if transmittance.min() < 1.0 {
                out.approximate(format!("the absorption of {name}: it is left out"));
            }
            let bsdf = Element::object("bsdf", "thindielectric");
            (bsdf.float("int_ior", index.index(SODIUM_NM)).float("ext_ior", 1.0), Sides::Both)
        }
        MaterialModel::Retroreflective(Retroreflective { reflectance, .. }) => {
            out.approximate(format!("the retroreflection of {name}, for which it has no plugin: it is left out"));
            (textures.diffuse(reflectance, name, out), Sides::One)
        }
        MaterialModel::Mix(mix) => {
            let [first, second] = mix.models.each_ref().map(|model| scattering(model, name, textures, out));
            let blend = Element::object("bsdf", "blendbsdf").float("weight", f64::from(mix.weight));
            let sides = if [first.1, second.1].contains(&Sides::Both) { Sides::Both } else { Sides::One };
            (blend.child(first.0).child(second.0), sides)
        }
        MaterialModel::Layered(layers) => (principled(layers, name, textures, out), Sides::One),
    }
}

/// glTF's material. Mitsuba's "principled" is another model with nearly the same keys.
fn principled(layers: &LayeredDescription, name: &str, textures: &Textures<'_>, out: &mut Output) -> Element {
    out.approximate(format!("glTF's material model of {name}: it becomes \"principled\""));
    let extensions = [
        ("transmission", layers.transmission.value > 0.0),
        ("volume", layers.absorption_per_m.is_some()),
        ("diffuse transmission", layers.diffuse_transmission.is_some()),
        ("iridescence", layers.film.is_some()),
        ("anisotropy", layers.anisotropy.is_some()),
        ("sheen", layers.sheen.is_some()),
        ("clearcoat", layers.coat.is_some()),
        (
            "specular colour",
            !matches!(layers.specular_colour.colour, Colour::Rgb([1.0, 1.0, 1.0]))
                || layers.specular_colour.texture.is_some(),
        ),
        ("specular factor", layers.specular.value != 1.0 || layers.specular.texture.is_some()),
        ("specular-glossiness", layers.normal_reflectance.is_some()),
    ];
    for (extension, _) in extensions.into_iter().filter(|(_, used)| *used) {
        out.approximate(format!("the {extension} of {name}: it is left out"));
    }
    let bsdf = Element::object("bsdf", "principled").float("eta", layers.index.index(SODIUM_NM));
    let bsdf = textures.colour(bsdf, "base_color", &layers.base_colour, name, out);
    [("roughness", &layers.roughness), ("metallic", &layers.metallic)].into_iter().fold(bsdf, |bsdf, (key, factor)| {
        let Some((texture, channel)) = &factor.texture else { return bsdf.float(key, f64::from(factor.value)) };
        let image = textures.image(texture);
        let value = |i| [image.linear_texel(i)[*channel as usize] * factor.value; 3];
        let file = textures.file(key, image, &["Y"], out, value);
        bsdf.child(bitmap(key, &file, true, texture, out))
    })
}

/// Mitsuba's microfacets hide each other from the two directions independently, G = G₁(wo)·G₁(wi); ours know that what
/// is hidden from one is deep and hidden from the other too.
fn shadowing(name: &str) -> String {
    format!("the correlated shadowing of the microfacets of {name}: Mitsuba's is uncorrelated")
}

fn ggx(bsdf: Element) -> Element {
    bsdf.string("distribution", "ggx").boolean("sample_visible", true)
}

/// A BSDF with the holes of the material.
fn masked(
    bsdf: Element,
    material: &MaterialDescription,
    name: &str,
    textures: &Textures<'_>,
    out: &mut Output,
) -> Element {
    let factor = material.alpha_factor;
    let opacity: &dyn Fn(f32) -> f32 = match &material.alpha {
        AlphaMode::Opaque => return bsdf,
        AlphaMode::Mask { cutoff } => &|alpha| f32::from(u8::from(alpha * factor >= *cutoff)),
        AlphaMode::Blend => &|alpha| alpha * factor,
    };
    let masked = Element::object("bsdf", "mask");
    let Some(texture) = &material.alpha_texture else {
        return masked.float("opacity", opacity(1.0).into()).child(bsdf);
    };
    if matches!(material.alpha, AlphaMode::Mask { .. }) && texture.sampler.filter != Filter::Nearest {
        out.approximate(format!("the mask of {name}: texels are cut before they are interpolated, not after"));
    }
    let image = textures.image(texture);
    let file = textures.file("opacity", image, &["Y"], out, |i| [opacity(image.linear_texel(i)[3]); 3]);
    masked.child(bitmap("opacity", &file, true, texture, out)).child(bsdf)
}

/// Textures of one material.
struct Textures<'a> {
    scene: &'a SceneDescription,
    index: usize,
}

impl<'a> Textures<'a> {
    fn image(&self, texture: &TextureDescription) -> &'a Bitmap {
        &self.scene.images[texture.image]
    }

    fn file(
        &self,
        what: &str,
        image: &Bitmap,
        channels: &[&str],
        out: &mut Output,
        texel: impl Fn(usize) -> [f32; 3],
    ) -> String {
        out.exr(format!("textures/material-{}-{what}.exr", self.index), &planes(image, channels, texel))
    }

    /// Lambert's law.
    fn diffuse(&self, reflectance: &TexturedColour, name: &str, out: &mut Output) -> Element {
        self.colour(Element::object("bsdf", "diffuse"), "reflectance", reflectance, name, out)
    }

    /// A BSDF with a reflectance: a spectrum, or a texture of colours.
    fn colour(
        &self,
        bsdf: Element,
        key: &str,
        TexturedColour { colour, texture }: &TexturedColour,
        name: &str,
        out: &mut Output,
    ) -> Element {
        let Some(texture) = texture else {
            return match colour {
                Colour::Rgb(rgb) => bsdf.spectrum(key, &reflectance_spectrum(*rgb)),
                Colour::Spectrum(spectrum) => bsdf.spectrum(key, spectrum),
            };
        };
        let factor = match colour {
            Colour::Rgb(rgb) => *rgb,
            Colour::Spectrum(_) => {
                out.approximate(format!("the spectrum that scales the texture of {name}: it is left out"));
                [1.0; 3]
            }
        };
        if out.sees_beyond_cie {
            out.approximate(format!("the texture of {name} beyond 360 to 830 nm, where it is black"));
        }
        let image = self.image(texture);
        if texture.sampler.filter == Filter::Linear && (image.width, image.height) != (1, 1) {
            out.approximate(format!("colours between the texels of {name}: spectra are interpolated, not RGB"));
        }
        let file = self.file(key, image, &["R", "G", "B"], out, |i| {
            let texel = image.srgb_texel(i);
            [0, 1, 2].map(|c| texel[c] * factor[c])
        });
        bsdf.child(bitmap(key, &file, false, texture, out))
    }
}
