//! Materials as BSDFs of Mitsuba.

use super::bitmaps::{bitmap, planes};
use super::difference::Difference;
use super::element::Element;
use super::output::{Output, quoted};
use photosite_core::spectrum::upsampling::reflectance_spectrum;
use photosite_transport::scene::description::{
    AlphaMode, Colour, Conductor, Dielectric, Diffuse, LayeredDescription, MaterialDescription, MaterialModel,
    OrenNayar, Phong, Retroreflective, Roughness, SceneDescription, TextureDescription, TexturedColour, ThinDielectric,
    Translucent,
};
use photosite_transport::texture::{Bitmap, Filter, UvTransform};

/// Wavelength of the yellow line of sodium, nm, at which the index of a dispersive glass is taken.
const SODIUM_NM: f64 = 589.3;

/// Material in the scene file.
pub(super) struct ExportedMaterial {
    pub(super) id: String,
    pub(super) bsdf: Element,
    /// Id and BSDF for triangles whose bitangent is −n × t, where a normal map makes a difference: Mitsuba's is n × t
    /// everywhere.
    pub(super) left_handed: Option<(String, Element)>,
    /// UV set that the material's textures use in the mesh: Mitsuba's textures have no choice and no exact transform of
    /// their own.
    pub(super) uv_set: usize,
    pub(super) uv_transform: UvTransform,
}

impl ExportedMaterial {
    /// Elements of the material in the scene file.
    pub(super) fn into_elements(self) -> impl Iterator<Item = Element> {
        [self.bsdf].into_iter().chain(self.left_handed.map(|(_, bsdf)| bsdf))
    }
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
        out.approximate(Difference::UvsOfTheirOwn { material: name.clone() });
    }
    let complete = |id: &str, bumps: Option<&Bumps<'_>>, out: &mut Output| {
        let bsdf = surface(&material.model, bumps, &name, textures, out);
        masked(bsdf, material, &name, textures, out).attribute("id", id)
    };
    let id = format!("material-{index}");
    let bumps = material.normal_map.as_ref().map(|(texture, scale)| Bumps { texture, scale: *scale, is_left: false });
    if bumps.is_some() {
        out.approximate(Difference::NormalsFromBehind { material: name.clone() });
    }
    let bsdf = complete(&id, bumps.as_ref(), out);
    let left_handed = bumps.map(|bumps| {
        let id = format!("{id}-left");
        let bsdf = complete(&id, Some(&Bumps { is_left: true, ..bumps }), out);
        (id, bsdf)
    });
    ExportedMaterial { id, bsdf, left_handed, uv_set, uv_transform }
}

/// Normal map on triangles of one handedness.
struct Bumps<'a> {
    texture: &'a TextureDescription,
    scale: f32,
    is_left: bool,
}

impl Bumps<'_> {
    /// BSDF with bumps. Seen from behind, the whole normal is turned over, where "twosided" turns z alone.
    fn on(&self, bsdf: Element, behind: bool, textures: &Textures<'_>, out: &mut Output) -> Element {
        let turn = if behind { -1.0 } else { 1.0 };
        let [along, across] = [turn * self.scale, if self.is_left { -turn } else { turn } * self.scale];
        let what = match (behind, self.is_left) {
            (false, false) => "normal",
            (true, false) => "normal-behind",
            (false, true) => "normal-left",
            (true, true) => "normal-left-behind",
        };
        let image = textures.image(self.texture);
        let file = textures.file(what, image, &["R", "G", "B"], out, |i| {
            // Only x and y are scaled; what is stored is (n + 1)/2.
            let [x, y, z, _] = image.linear_texel(i);
            let scaled = |c: f32, scale: f32| ((2.0 * c - 1.0) * scale + 1.0) / 2.0;
            [scaled(x, along), scaled(y, across), z]
        });
        Element::object("bsdf", "normalmap")
            // Neither softens the terminator.
            .boolean("use_shadowing_function", false)
            .boolean("flip_invalid_normals", false)
            .child(bitmap("normalmap", &file, true, self.texture, out))
            .child(bsdf)
    }
}

/// BSDF of a model seen from both sides, with its bumps. A mix is one of such surfaces: "twosided" takes no halves that
/// have two sides of their own.
fn surface(
    model: &MaterialModel,
    bumps: Option<&Bumps<'_>>,
    name: &str,
    textures: &Textures<'_>,
    out: &mut Output,
) -> Element {
    if let MaterialModel::Mix(mix) = model {
        if mix.models.iter().any(|half| lobes(half).is_polished) {
            out.approximate(Difference::PolishedHalf { material: name.to_owned() });
        }
        let halves = mix.models.each_ref().map(|model| surface(model, bumps, name, textures, out));
        return Element::object("bsdf", "blendbsdf").float("weight", f64::from(mix.weight)).with(halves);
    }
    let (bsdf, sides) = scattering(model, name, textures, out);
    match (sides, bumps) {
        (Sides::Both, None) => bsdf,
        (Sides::Both, Some(bumps)) => bumps.on(bsdf, false, textures, out),
        // Of everything but glass we look at both sides, and Mitsuba at the front alone.
        (Sides::One, None) => Element::object("bsdf", "twosided").child(bsdf),
        (Sides::One, Some(bumps)) => {
            let [front, behind] = [false, true].map(|behind| bumps.on(bsdf.clone(), behind, textures, out));
            Element::object("bsdf", "twosided").child(front).child(behind)
        }
    }
}

/// Delta lobes, which Mitsuba treats differently from others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Lobes {
    /// Whether the written plugin has a delta lobe, so that "blendbsdf" weights it wrongly.
    is_polished: bool,
    /// Whether light goes straight on, as through a pane, so that emitters are visible through it.
    is_pane: bool,
}

fn lobes(model: &MaterialModel) -> Lobes {
    match model {
        MaterialModel::Conductor(Conductor { distribution, .. })
        | MaterialModel::Dielectric(Dielectric { distribution, .. }) => {
            Lobes { is_polished: distribution.distribution().is_smooth(), is_pane: false }
        }
        MaterialModel::ThinDielectric(_) => Lobes { is_polished: true, is_pane: true },
        // "principled" has no such lobe, however small its roughness.
        MaterialModel::Layered(layers) => {
            let LayeredDescription { transmission, absorption_per_m, roughness, .. } = &**layers;
            // A texture may make any part of it smooth.
            let may_be_smooth =
                roughness.texture.is_some() || Roughness::isotropic(roughness.value).distribution().is_smooth();
            Lobes {
                is_polished: false,
                is_pane: transmission.value > 0.0 && absorption_per_m.is_none() && may_be_smooth,
            }
        }
        MaterialModel::Mix(mix) => {
            let [first, second] = mix.models.each_ref().map(lobes);
            Lobes { is_polished: first.is_polished || second.is_polished, is_pane: first.is_pane || second.is_pane }
        }
        MaterialModel::Diffuse(_)
        | MaterialModel::OrenNayar(_)
        | MaterialModel::Phong(_)
        | MaterialModel::Translucent(_)
        | MaterialModel::Retroreflective(_) => Lobes::default(),
    }
}

/// Whether rays pass some surface as if it were not there.
pub(super) fn has_holes(scene: &SceneDescription) -> bool {
    used(scene).any(|material| material.alpha != AlphaMode::Opaque)
}

/// Notes how Mitsuba treats panes otherwise: their shadows, and panes in scenes with holes.
pub(super) fn panes(scene: &SceneDescription, out: &mut Output) {
    for pane in used(scene).filter(|material| lobes(&material.model).is_pane) {
        let material = || quoted("material", &pane.name);
        if !scene.lights.is_empty() {
            out.approximate(Difference::ShadowOfPane { material: material() });
        }
        if has_holes(scene) {
            out.approximate(Difference::PaneAmongHoles { material: material() });
        }
    }
}

/// Materials of meshes.
fn used(scene: &SceneDescription) -> impl Iterator<Item = &MaterialDescription> {
    scene
        .materials
        .iter()
        .enumerate()
        .filter_map(|(index, material)| scene.meshes.iter().any(|mesh| mesh.material == index).then_some(material))
}

/// Sides that Mitsuba's model is for: "twosided" refuses models for both.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sides {
    One,
    Both,
}

fn scattering(model: &MaterialModel, name: &str, textures: &Textures<'_>, out: &mut Output) -> (Element, Sides) {
    match model {
        MaterialModel::Diffuse(Diffuse { reflectance }) => (textures.diffuse(reflectance, name, out), Sides::One),
        MaterialModel::Conductor(Conductor { eta, k, distribution, energy_compensation }) => {
            let microfacets = distribution.distribution();
            let bsdf = if microfacets.is_smooth() {
                Element::object("bsdf", "conductor")
            } else {
                out.approximate(Difference::Shadowing { material: name.to_owned() });
                if *energy_compensation {
                    out.approximate(Difference::FurtherBounces { material: name.to_owned() });
                }
                let [u, v] = microfacets.alpha().map(f64::from);
                ggx(Element::object("bsdf", "roughconductor")).float("alpha_u", u).float("alpha_v", v)
            };
            (bsdf.spectrum("eta", eta).spectrum("k", k), Sides::One)
        }
        MaterialModel::Dielectric(Dielectric { index, distribution, energy_compensation }) => {
            if !index.is_constant() {
                out.approximate(Difference::Dispersion { material: name.to_owned() });
            }
            let microfacets = distribution.distribution();
            let bsdf = if microfacets.is_smooth() {
                Element::object("bsdf", "dielectric")
            } else {
                out.approximate(Difference::Shadowing { material: name.to_owned() });
                if *energy_compensation {
                    out.approximate(Difference::FurtherBounces { material: name.to_owned() });
                }
                ggx(Element::object("bsdf", "roughdielectric")).float("alpha", microfacets.alpha()[0].into())
            };
            (bsdf.float("int_ior", index.index(SODIUM_NM)).float("ext_ior", 1.0), Sides::Both)
        }
        MaterialModel::OrenNayar(OrenNayar { reflectance, roughness: _ }) => {
            out.approximate(Difference::Relief { material: name.to_owned() });
            (textures.diffuse(reflectance, name, out), Sides::One)
        }
        MaterialModel::Phong(Phong { diffuse, specular: _, exponent: _ }) => {
            out.approximate(Difference::PhongLobe { material: name.to_owned() });
            (textures.diffuse(diffuse, name, out), Sides::One)
        }
        MaterialModel::Translucent(Translucent { reflectance, transmittance: _ }) => {
            out.approximate(Difference::Translucence { material: name.to_owned() });
            (textures.diffuse(reflectance, name, out), Sides::One)
        }
        MaterialModel::ThinDielectric(ThinDielectric { index, transmittance }) => {
            if !index.is_constant() {
                out.approximate(Difference::Dispersion { material: name.to_owned() });
            }
            if transmittance.min() < 1.0 {
                out.approximate(Difference::Absorption { material: name.to_owned() });
            }
            let bsdf = Element::object("bsdf", "thindielectric");
            (bsdf.float("int_ior", index.index(SODIUM_NM)).float("ext_ior", 1.0), Sides::Both)
        }
        MaterialModel::Retroreflective(Retroreflective {
            reflectance,
            retroreflectance: _,
            corners: _,
            distribution: _,
        }) => {
            out.approximate(Difference::Retroreflection { material: name.to_owned() });
            (textures.diffuse(reflectance, name, out), Sides::One)
        }
        MaterialModel::Mix(_) => unreachable!("mixes are taken apart above"),
        MaterialModel::Layered(layers) => (principled(layers, name, textures, out), Sides::One),
    }
}

/// BSDF of glTF's material. Mitsuba's "principled" is another model with nearly the same keys.
fn principled(layers: &LayeredDescription, name: &str, textures: &Textures<'_>, out: &mut Output) -> Element {
    let LayeredDescription {
        kind,
        base_colour,
        metallic,
        roughness,
        index,
        normal_reflectance,
        specular,
        specular_colour,
        transmission,
        absorption_per_m,
        diffuse_transmission,
        anisotropy,
        film,
        sheen,
        coat,
    } = layers;
    out.approximate(Difference::Model { kind, material: name.to_owned() });
    let is_white = matches!(specular_colour.colour, Colour::Rgb([1.0, 1.0, 1.0])) && specular_colour.texture.is_none();
    for (extension, is_used) in [
        ("transmission", transmission.value > 0.0),
        ("volume", absorption_per_m.is_some()),
        ("diffuse transmission", diffuse_transmission.is_some()),
        ("iridescence", film.is_some()),
        ("anisotropy", anisotropy.is_some()),
        ("sheen", sheen.is_some()),
        ("clearcoat", coat.is_some()),
        ("specular colour", !is_white),
        ("specular factor", specular.value != 1.0 || specular.texture.is_some()),
        ("reflectance of 1 before the specular colour (ior 0, specular-glossiness)", normal_reflectance.is_some()),
    ] {
        if is_used {
            out.approximate(Difference::Extension { extension, material: name.to_owned() });
        }
    }
    if !index.is_constant() {
        out.approximate(Difference::Dispersion { material: name.to_owned() });
    }
    let bsdf = Element::object("bsdf", "principled").float("eta", index.index(SODIUM_NM));
    let bsdf = textures.colour(bsdf, "base_color", base_colour, name, out);
    [("roughness", roughness), ("metallic", metallic)].into_iter().fold(bsdf, |bsdf, (key, factor)| {
        let Some((texture, channel)) = &factor.texture else { return bsdf.float(key, f64::from(factor.value)) };
        let image = textures.image(texture);
        let value = |i| [image.linear_texel(i)[*channel as usize] * factor.value; 3];
        let file = textures.file(key, image, &["Y"], out, value);
        bsdf.child(bitmap(key, &file, true, texture, out))
    })
}

/// GGX distribution for a BSDF. Mitsuba's masking and shadowing are independent for the two directions, G =
/// G₁(wo)·G₁(wi); photosite's are height-correlated.
fn ggx(bsdf: Element) -> Element {
    bsdf.string("distribution", "ggx").boolean("sample_visible", true)
}

/// BSDF with the holes of the material.
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
        out.approximate(Difference::MaskBetweenTexels { material: name.to_owned() });
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

    /// Lambertian reflection.
    fn diffuse(&self, reflectance: &TexturedColour, name: &str, out: &mut Output) -> Element {
        self.colour(Element::object("bsdf", "diffuse"), "reflectance", reflectance, name, out)
    }

    /// BSDF with a reflectance: a spectrum, or a texture of colours.
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
                out.approximate(Difference::SpectrumTimesTexture { material: name.to_owned() });
                [1.0; 3]
            }
        };
        if out.sees_beyond_cie {
            out.approximate(Difference::TextureBeyondCie { material: name.to_owned() });
        }
        let image = self.image(texture);
        if texture.sampler.filter == Filter::Linear && (image.width, image.height) != (1, 1) {
            out.approximate(Difference::ColoursBetweenTexels { material: name.to_owned() });
        }
        let file = self.file(key, image, &["R", "G", "B"], out, |i| {
            let texel = image.srgb_texel(i);
            [0, 1, 2].map(|c| texel[c] * factor[c])
        });
        bsdf.child(bitmap(key, &file, false, texture, out))
    }
}
