//! Materials in place of those of the geometry, `[materials.NAME]`.

use std::collections::BTreeMap;

use super::super::tables::spectra::{Finder, unit};
use super::super::tables::{
    CommonKeys, ConductorTable, DielectricTable, DiffuseTable, EmissionTable, IndexSource, KeptTable, MaterialTable,
    MetalSource, MetallicRoughnessTable, MixTable, OrenNayarTable, PhongTable, PlasticTable, RetroreflectiveTable,
    SurfaceKeys, SurfaceTable, ThinDielectricTable, TranslucentTable, TypedMaterialTable,
};
use super::kept_material::Changes;
use super::lights::emission;
use photosite_core::Invalid;
use photosite_core::spectrum::dispersion::lines;
use photosite_core::spectrum::upsampling::reflectance_spectrum;
use photosite_core::spectrum::{Dispersion, Outside, Spectrum, library};
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::warnings::Warnings;
use photosite_transport::bsdf::CubeCorners;
use photosite_transport::scene::description::{
    AlphaMode, Channel, Colour, Conductor, Dielectric, Diffuse, EmissionDescription, LayeredDescription,
    MaterialDescription, MaterialModel, Mix, OrenNayar, Phong, Retroreflective, Roughness, TextureDescription,
    TexturedColour, TexturedFactor, ThinDielectric, Translucent,
};

/// Applies every `[materials.NAME]` to the materials of that name. One that nothing has is an error, or with
/// `is_palette`, where objects may be given other materials, a warning.
pub(crate) fn override_materials(
    tables: &BTreeMap<String, MaterialTable>,
    is_palette: bool,
    finder: &mut Finder<'_>,
    materials: &mut [MaterialDescription],
    warnings: &mut Warnings,
) -> Result<(), Invalid> {
    for (name, table) in tables {
        let path = format!("materials.{name}");
        if !materials.iter().any(|place| place.name == *name) {
            match table {
                MaterialTable::Typed(_) if is_palette => {
                    warnings.once(format!("{path}: nothing has this material"));
                }
                MaterialTable::Typed(_) | MaterialTable::Kept(_) => {
                    return Err(unknown_material(path, name, materials));
                }
            }
        }
        let material = match table {
            MaterialTable::Kept(table) => kept(finder, table),
            MaterialTable::Typed(table) => typed(finder, table),
        };
        let material = material.map_err(|invalid| invalid.within(&path))?;
        for place in materials.iter_mut().filter(|place| place.name == *name) {
            material.clone().apply(place).map_err(|invalid| invalid.within(&path))?;
        }
    }
    Ok(())
}

fn unknown_material(path: String, name: &str, materials: &[MaterialDescription]) -> Invalid {
    let names = || materials.iter().map(|material| material.name.as_str());
    let message = format!("the geometry has no material {name:?}{}", did_you_mean(name, names()));
    let help = match materials {
        [] => "the capture has no geometry".to_owned(),
        _ => format!("its materials are {}", list(name, names())),
    };
    Invalid::new(path, message).help(help)
}

/// A material as a capture file describes it.
#[derive(Clone)]
struct Override {
    /// Model that takes the place of the material's; `None` keeps that and all that belongs to it but for `changes`.
    model: Option<(MaterialModel, Option<TextureDescription>)>,
    changes: Changes,
    emission: Option<EmissionDescription>,
    double_sided: Option<bool>,
}

impl Override {
    fn apply(self, place: &mut MaterialDescription) -> Result<(), Invalid> {
        let is_new = self.model.is_some();
        if let Some((model, normal_map)) = self.model {
            place.model = model;
            place.normal_map = normal_map.map(|texture| (texture, 1.0));
            place.alpha = AlphaMode::Opaque;
            place.alpha_factor = 1.0;
            place.alpha_texture = None;
        }
        if is_new || self.emission.is_some() {
            place.emission = self.emission;
        }
        place.double_sided = self.double_sided.unwrap_or(place.double_sided);
        self.changes.apply(&mut place.model)
    }
}

fn kept(finder: &mut Finder<'_>, table: &KeptTable) -> Result<Override, Invalid> {
    let changes = Changes::of(table, finder)?;
    let emission = shine(finder, table.emission.as_ref())?;
    Ok(Override { model: None, changes, emission, double_sided: table.double_sided })
}

fn typed(finder: &mut Finder<'_>, table: &TypedMaterialTable) -> Result<Override, Invalid> {
    match table.surface() {
        Ok(table) => {
            let model = table.model(finder)?;
            surface(finder, model, table.common())
        }
        Err(table) => mix(finder, table),
    }
}

/// A model with what any surface may have beside it.
fn surface(finder: &mut Finder<'_>, model: MaterialModel, keys: SurfaceKeys<'_>) -> Result<Override, Invalid> {
    let normal_map =
        keys.normal_map.map(|file| finder.texture(file)).transpose().map_err(|e| e.within("normal_map"))?;
    let emission = shine(finder, keys.emission)?;
    let model = Some((model, normal_map));
    Ok(Override { model, changes: Changes::default(), emission, double_sided: keys.double_sided })
}

impl SurfaceTable for DiffuseTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let reflectance = finder.reflectance(&self.reflectance).map_err(|e| e.within("reflectance"))?;
        Ok(MaterialModel::Diffuse(Diffuse { reflectance }))
    }
}

impl SurfaceTable for ConductorTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let (eta, k) = metal(finder, &self.metal).map_err(|e| e.within("metal"))?;
        for (key, spectrum) in [("eta", &eta), ("k", &k)] {
            if let Some((lambda, value)) = spectrum.iter().find(|(_, value)| *value < 0.0) {
                let message = format!("{key} must not be negative, but is {value} at {lambda} nm");
                return Err(Invalid::new("metal", message));
            }
        }
        let anisotropy = self.anisotropy.unwrap_or(0.0);
        if !(-1.0..=1.0).contains(&anisotropy) {
            return Err(Invalid::new("anisotropy", format!("must lie between -1 and 1, got {anisotropy}")));
        }
        let value = unit("roughness", self.roughness.unwrap_or(0.0))?;
        let distribution = Roughness { value, anisotropy: anisotropy as f32 };
        let energy_compensation = self.energy_compensation.unwrap_or(false);
        Ok(MaterialModel::Conductor(Conductor { eta, k, distribution, energy_compensation }))
    }
}

fn metal(finder: &Finder<'_>, source: &MetalSource) -> Result<(Spectrum, Spectrum), Invalid> {
    match source {
        MetalSource::Name(name) => match library::conductor(name) {
            Some(metal) => Ok((metal.eta, metal.k)),
            None => {
                let message = format!("photosite has no metal {name:?}{}", did_you_mean(name, library::conductors()));
                let help =
                    format!("known names are {}; or give {{ file = \"n-k.csv\" }}", list(name, library::conductors()));
                Err(Invalid::new("", message).help(help))
            }
        },
        MetalSource::File(curve) if curve.column.is_some() => {
            let message = "the file of a metal is read by its columns n and k";
            Err(Invalid::new("column", message).help("remove column; eta and k take a file with a column each"))
        }
        MetalSource::File(curve) => {
            let table = finder.table(&curve.file, Outside::Hold)?;
            let column = |name| table.column(name).map_err(|e| Invalid::new("", format!("{}: {e}", curve.file)));
            Ok((column("n")?, column("k")?))
        }
        MetalSource::Parts(parts) => Ok((
            finder.spectrum(&parts.eta, Outside::Hold).map_err(|e| e.within("eta"))?,
            finder.spectrum(&parts.k, Outside::Hold).map_err(|e| e.within("k"))?,
        )),
    }
}

impl SurfaceTable for DielectricTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let index = index(finder, self.glass.as_deref(), self.index.as_ref(), self.abbe_number)?;
        let distribution = Roughness::isotropic(unit("roughness", self.roughness.unwrap_or(0.0))?);
        let energy_compensation = self.energy_compensation.unwrap_or(false);
        Ok(MaterialModel::Dielectric(Dielectric { index, distribution, energy_compensation }))
    }
}

/// Refractive index, stated or that of a glass.
pub(crate) fn index(
    finder: &Finder<'_>,
    glass: Option<&str>,
    index: Option<&IndexSource>,
    abbe_number: Option<f64>,
) -> Result<Dispersion, Invalid> {
    if abbe_number.is_some() && !matches!(index, Some(IndexSource::Number(_))) {
        return Err(Invalid::new("abbe_number", "only applies with an index that is a number").help("remove it"));
    }
    if let Some(abbe) = abbe_number.filter(|abbe| abbe.is_nan() || *abbe <= 0.0) {
        let message = format!("must be above 0, got {abbe}");
        return Err(Invalid::new("abbe_number", message).help("glasses have Abbe numbers of 20 to 90"));
    }
    match (glass, index) {
        (Some(_), Some(_)) => Err(Invalid::new("index", "cannot be combined with glass").help("keep one of them")),
        (None, None) => {
            let help = "for example glass = \"BK7\" or index = 1.5";
            Err(Invalid::new("", "needs a glass or an index").help(help))
        }
        (Some(name), None) => library::glass(name).ok_or_else(|| {
            let message = format!("photosite has no glass {name:?}{}", did_you_mean(name, library::glasses()));
            Invalid::new("glass", message)
                .help(format!("known names are {}; or give an index", list(name, library::glasses())))
        }),
        (None, Some(index)) => dispersion(finder, index, abbe_number).map_err(|e| e.within("index")),
    }
}

fn dispersion(finder: &Finder<'_>, source: &IndexSource, abbe: Option<f64>) -> Result<Dispersion, Invalid> {
    let dispersion = match source {
        IndexSource::Number(n) => match abbe {
            Some(abbe) => Dispersion::from_abbe(*n, abbe)?,
            None => Dispersion::constant(*n),
        },
        IndexSource::Sellmeier(t) => {
            Dispersion::Sellmeier { b: t.sellmeier_b.clone(), c_um2: t.sellmeier_c_um2.clone() }
        }
        IndexSource::Cauchy(t) => Dispersion::Cauchy { a: t.cauchy_a, b_um2: t.cauchy_b_um2, c_um4: t.cauchy_c_um4 },
        IndexSource::File(curve) => {
            let source = photosite_sensor::SpectrumSource::File(curve.clone());
            Dispersion::Table(finder.spectrum(&source, Outside::Hold)?)
        }
    };
    dispersion.validated()
}

impl SurfaceTable for MetallicRoughnessTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let base_colour = finder.reflectance(&self.base_colour).map_err(|e| e.within("base_colour"))?;
        let map = self.metallic_roughness_map.as_ref().map(|map| finder.texture(map)).transpose();
        let map = map.map_err(|e| e.within("metallic_roughness_map"))?;
        let factor = |value, channel| TexturedFactor { value, texture: map.clone().map(|map| (map, channel)) };
        Ok(MaterialModel::Layered(Box::new(LayeredDescription {
            kind: "metallic-roughness",
            base_colour,
            metallic: factor(unit("metallic", self.metallic.unwrap_or(0.0))?, Channel::B),
            roughness: factor(unit("roughness", self.roughness)?, Channel::G),
            ..LayeredDescription::default()
        })))
    }
}

impl SurfaceTable for OrenNayarTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let reflectance = finder.reflectance(&self.reflectance).map_err(|e| e.within("reflectance"))?;
        Ok(MaterialModel::OrenNayar(OrenNayar { reflectance, roughness: unit("roughness", self.roughness)? }))
    }
}

impl SurfaceTable for PlasticTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let base_colour = finder.reflectance(&self.reflectance).map_err(|e| e.within("reflectance"))?;
        let index = match (&self.glass, &self.index) {
            (None, None) => Dispersion::constant(1.5),
            (glass, number) => index(finder, glass.as_deref(), number.as_ref(), None)?,
        };
        let n = index.index(lines::D);
        if n < 1.0 {
            return Err(
                Invalid::new("index", format!("must be at least 1, got {n}")).help("most plastics have 1.4 to 1.6")
            );
        }
        Ok(MaterialModel::Layered(Box::new(LayeredDescription {
            kind: "plastic",
            base_colour,
            roughness: TexturedFactor::plain(unit("roughness", self.roughness.unwrap_or(0.0))?),
            index,
            ..LayeredDescription::default()
        })))
    }
}

impl SurfaceTable for ThinDielectricTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let index = index(finder, self.glass.as_deref(), self.index.as_ref(), self.abbe_number)?;
        let transmittance = match &self.transmittance {
            Some(source) => finder.fraction(source).map_err(|e| e.within("transmittance"))?,
            None => Spectrum::constant(1.0),
        };
        Ok(MaterialModel::ThinDielectric(ThinDielectric { index, transmittance }))
    }
}

impl SurfaceTable for TranslucentTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let reflectance = finder.reflectance(&self.reflectance).map_err(|e| e.within("reflectance"))?;
        let transmittance = finder.transmittance(&self.transmittance).map_err(|e| e.within("transmittance"))?;
        at_most_one(("reflectance", &reflectance), ("transmittance", &transmittance))?;
        Ok(MaterialModel::Translucent(Translucent { reflectance, transmittance }))
    }
}

impl SurfaceTable for PhongTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        let diffuse = finder.reflectance(&self.diffuse).map_err(|e| e.within("diffuse"))?;
        let specular = finder.reflectance(&self.specular).map_err(|e| e.within("specular"))?;
        at_most_one(("diffuse", &diffuse), ("specular", &specular))?;
        if !(0.0..=1e5).contains(&self.exponent) {
            let message = format!("must lie between 0 and 100000, got {}", self.exponent);
            return Err(Invalid::new("exponent", message).help("the larger, the narrower the lobe; 50 is glossy"));
        }
        Ok(MaterialModel::Phong(Phong { diffuse, specular, exponent: self.exponent as f32 }))
    }
}

impl SurfaceTable for RetroreflectiveTable {
    fn model(&self, finder: &mut Finder<'_>) -> Result<MaterialModel, Invalid> {
        /// Refractive index of polycarbonate.
        const INDEX: f64 = 1.586;
        let retroreflectance = finder.reflectance(&self.retroreflectance).map_err(|e| e.within("retroreflectance"))?;
        let reflectance = finder.reflectance(&self.reflectance).map_err(|e| e.within("reflectance"))?;
        let index = self.index.unwrap_or(INDEX);
        if !(1.0..=4.0).contains(&index) {
            let message = format!("must lie between 1 and 4, got {index}");
            return Err(Invalid::new("index", message).help("most plastics have 1.4 to 1.6"));
        }
        Ok(MaterialModel::Retroreflective(Retroreflective {
            retroreflectance,
            reflectance,
            corners: CubeCorners::new(index as f32),
            distribution: Roughness::isotropic(unit("roughness", self.roughness.unwrap_or(0.1))?),
        }))
    }
}

/// Refuses two parts of the light that are more than all of it. Textures count as white.
fn at_most_one(first: (&str, &TexturedColour), second: (&str, &TexturedColour)) -> Result<(), Invalid> {
    let spectrum = |colour: &TexturedColour| match &colour.colour {
        Colour::Rgb(rgb) => reflectance_spectrum(*rgb),
        Colour::Spectrum(spectrum) => spectrum.clone(),
    };
    let sum =
        spectrum(first.1).values().iter().zip(spectrum(second.1).values()).map(|(a, b)| a + b).fold(0.0, f32::max);
    // What the upsampling of white lacks to 1.
    if sum <= 1.001 {
        return Ok(());
    }
    let message = format!("and {} are together {sum:.3} of the light at some wavelength", first.0);
    Err(Invalid::new(second.0, message).help("more than 1 cannot leave the surface; a texture counts as white"))
}

fn mix(finder: &mut Finder<'_>, table: &MixTable) -> Result<Override, Invalid> {
    let mut part = |key: &str, table: &TypedMaterialTable| {
        let part = typed(finder, table).map_err(|e| e.within(key))?;
        match (part.model, part.emission, part.double_sided) {
            (Some((model, None)), None, None) => Ok(model),
            (_, _, _) => Err(Invalid::new(key, "has an emission, a normal map or double_sided of its own")
                .help("write it in the table of the mix: it belongs to both")),
        }
    };
    let models = [part("first", &table.first)?, part("second", &table.second)?];
    let model = MaterialModel::Mix(Box::new(Mix { models, weight: unit("weight", table.rest.weight)? }));
    surface(finder, model, table.rest.common())
}

/// The emission of a surface.
fn shine(finder: &mut Finder<'_>, table: Option<&EmissionTable>) -> Result<Option<EmissionDescription>, Invalid> {
    let Some(table) = table else { return Ok(None) };
    let texture = table.texture.as_ref().map(|file| finder.texture(file)).transpose();
    let texture = texture.map_err(|e| e.within("texture").within("emission"))?;
    let level = table.luminance_nit.map(|level| ("luminance_nit", level));
    let emission = emission(finder, table.colour(), level, "luminance_nit").map_err(|e| e.within("emission"))?;
    Ok(Some(EmissionDescription { texture, ..emission }))
}
