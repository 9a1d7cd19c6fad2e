//! Colours, spectra and textures of capture files.
//!
//! In: what the tables name. Out: [`Colour`]s, spectra, textures. Errors are [`Invalid`]s whose key is relative to the
//! table; a file that is named there is part of the message.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec2;

use super::super::tables::{LightColour, ReflectanceSource, TextureFile};
use photosite_core::Invalid;
use photosite_core::Sandbox;
use photosite_core::input;
use photosite_core::spectrum::csv::SpectralTable;
use photosite_core::spectrum::{Outside, Spectrum, illuminant, library, rgb};
use photosite_core::suggest::{did_you_mean, list};
use photosite_scene_io::read_bitmap;
use photosite_sensor::SpectrumSource;
use photosite_transport::scene::description::{Colour, TextureDescription, TexturedColour};
use photosite_transport::texture::{Bitmap, Filter, SamplerSettings, UvTransform, Wrap};

/// Finds what tables name, relative to the folder of their file.
#[derive(Debug)]
pub(crate) struct Finder<'a> {
    folder: &'a Path,
    sandbox: &'a Sandbox,
    /// Images of the scene; textures that are read are added.
    images: Vec<Arc<Bitmap>>,
    slots: HashMap<PathBuf, usize>,
}

/// The colour of a light, and whether its spectrum has a level of its own.
pub(crate) struct LightSpectrum {
    pub(crate) colour: Colour,
    /// In W·m⁻²·sr⁻¹·nm⁻¹ as it stands; otherwise only its shape means something.
    pub(crate) is_absolute: bool,
}

impl<'a> Finder<'a> {
    /// For files in `folder`; `images` are those that the scene has already.
    pub(crate) fn new(folder: &'a Path, sandbox: &'a Sandbox, images: Vec<Arc<Bitmap>>) -> Self {
        Self { folder, sandbox, images, slots: HashMap::new() }
    }

    /// The images of the scene.
    pub(crate) fn into_images(self) -> Vec<Arc<Bitmap>> {
        self.images
    }

    /// The path of a file that a table names.
    pub(crate) fn path(&self, file: &str) -> Result<PathBuf, Invalid> {
        let path = self.folder.join(file);
        self.sandbox.check(&path).map(|()| path)
    }

    /// The columns of a CSV file.
    pub(crate) fn table(&self, file: &str, outside: Outside) -> Result<SpectralTable, Invalid> {
        let path = self.path(file)?;
        let text = input::read_text(&path, input::TABLE_BYTES).map_err(|source| {
            Invalid::new("", format!("cannot read {}: {source}", path.display()))
                .help("paths are relative to the file that contains them")
        })?;
        SpectralTable::parse(&text, outside).map_err(|error| in_csv(&path, error.into()))
    }

    /// A function of wavelength.
    pub(crate) fn spectrum(&self, source: &SpectrumSource, outside: Outside) -> Result<Spectrum, Invalid> {
        match source {
            SpectrumSource::Number(value) if value.is_finite() => Ok(Spectrum::constant(*value as f32)),
            SpectrumSource::Number(value) => Err(Invalid::new("", format!("must be finite, got {value}"))),
            SpectrumSource::Name(name) => library::spectrum(name).ok_or_else(|| unknown_spectrum(name, library::names)),
            SpectrumSource::File(curve) => {
                let table = self.table(&curve.file, outside)?;
                let found = curve.column.as_ref().map_or_else(|| table.single(), |name| table.column(name));
                let names: Vec<&str> = table.names().collect();
                found.map_err(|error| {
                    let mut invalid = in_csv(&self.folder.join(&curve.file), error.into());
                    if let (None, [first, _, ..]) = (&curve.column, &names[..]) {
                        invalid = invalid.help(format!("write column = {first:?}, or another of {}", names.join(", ")));
                    }
                    invalid
                })
            }
        }
    }

    /// A spectrum whose values must lie within 0–1.
    pub(crate) fn fraction(&self, source: &SpectrumSource) -> Result<Spectrum, Invalid> {
        let spectrum = self.spectrum(source, Outside::Hold)?;
        let outside = spectrum.iter().find(|(_, value)| !(0.0..=1.0).contains(value));
        match outside {
            Some((lambda, value)) => {
                let message = format!("must lie between 0 and 1, but is {} at {lambda} nm", value as f32);
                Err(Invalid::new("", message).help("give fractions, not percentages"))
            }
            None => Ok(spectrum),
        }
    }

    /// Reflectance of a surface, and the texture that scales it.
    pub(crate) fn reflectance(&mut self, source: &ReflectanceSource) -> Result<TexturedColour, Invalid> {
        self.part_of_light(source, library::reflectances)
    }

    /// Transmittance of a surface, and the texture that scales it.
    pub(crate) fn transmittance(&mut self, source: &ReflectanceSource) -> Result<TexturedColour, Invalid> {
        self.part_of_light(source, library::transmittances)
    }

    /// A part of the light; names are those of the library that `known` gives.
    fn part_of_light<N: Iterator<Item = &'static str>>(
        &mut self,
        source: &ReflectanceSource,
        known: impl Fn() -> N,
    ) -> Result<TexturedColour, Invalid> {
        let colour = match source {
            ReflectanceSource::Number(value) => Colour::Spectrum(self.fraction(&SpectrumSource::Number(*value))?),
            ReflectanceSource::File(curve) => Colour::Spectrum(self.fraction(&SpectrumSource::File(curve.clone()))?),
            ReflectanceSource::Name(name) => {
                let found = known().find(|known| known.eq_ignore_ascii_case(name)).and_then(library::spectrum);
                Colour::Spectrum(found.ok_or_else(|| unknown_spectrum(name, known))?)
            }
            ReflectanceSource::Rgb(rgb) => Colour::Rgb(decoded(unit_rgb(*rgb)?)),
            ReflectanceSource::Linear(linear) => {
                Colour::Rgb(unit_rgb(linear.linear_rgb).map_err(|e| e.within("linear_rgb"))?.map(|c| c as f32))
            }
            ReflectanceSource::Texture(texture) => {
                return Ok(TexturedColour { texture: Some(self.texture(texture)?), ..TexturedColour::white() });
            }
        };
        Ok(TexturedColour::plain(colour))
    }

    /// The use of an image.
    pub(crate) fn texture(&mut self, file: &TextureFile) -> Result<TextureDescription, Invalid> {
        let path = self.path(&file.texture).map_err(|e| e.within("texture"))?;
        let image = match self.slots.get(&path) {
            Some(&slot) => slot,
            None => {
                self.images.push(Arc::new(read_bitmap(&path).map_err(|e| e.within("texture"))?));
                self.slots.insert(path, self.images.len() - 1);
                self.images.len() - 1
            }
        };
        let tiles = file.tiles.unwrap_or([1.0; 2]);
        if !tiles.iter().all(|t| t.is_finite() && *t != 0.0) {
            return Err(Invalid::new("tiles", format!("must be finite and not 0, got {tiles:?}"))
                .help("for example tiles = [4, 4]"));
        }
        let (wrap, filter) = (file.wrap.unwrap_or(Wrap::Repeat), file.filter.unwrap_or(Filter::Linear));
        let transform = UvTransform { scale: Vec2::new(tiles[0] as f32, tiles[1] as f32), ..UvTransform::default() };
        Ok(TextureDescription { image, uv_set: 0, sampler: SamplerSettings { wrap: [wrap; 2], filter }, transform })
    }

    /// The colour of a light: D65 unless stated otherwise.
    pub(crate) fn light(&self, keys: LightColour<'_>) -> Result<LightSpectrum, Invalid> {
        let given = [
            ("illuminant", keys.illuminant.is_some()),
            ("spectrum", keys.spectrum.is_some()),
            ("rgb", keys.rgb.is_some()),
            ("linear_rgb", keys.linear_rgb.is_some()),
        ];
        let given: Vec<&str> = given.iter().filter(|(_, is_given)| *is_given).map(|(key, _)| *key).collect();
        if let [first, second, ..] = given[..] {
            return Err(Invalid::new(second, format!("cannot be combined with {first}"))
                .help("a light has one colour: keep one of them"));
        }
        if let Some(spectrum) = keys.spectrum {
            let shape =
                self.spectrum(spectrum, Outside::Zero).and_then(not_negative).map_err(|e| e.within("spectrum"))?;
            let is_absolute = matches!(spectrum, SpectrumSource::File(_));
            return Ok(LightSpectrum { colour: Colour::Spectrum(shape), is_absolute });
        }
        let rgb = match (keys.rgb, keys.linear_rgb) {
            (Some(rgb), _) => Some(decoded(unit_rgb(rgb).map_err(|e| e.within("rgb"))?)),
            (None, Some(linear)) => Some(not_negative_rgb(linear).map_err(|e| e.within("linear_rgb"))?),
            (None, None) => None,
        };
        if let Some(rgb) = rgb {
            return Ok(LightSpectrum { colour: Colour::Rgb(rgb), is_absolute: false });
        }
        let name = keys.illuminant.unwrap_or("D65");
        let spectrum = illuminant::named(name)?;
        // Of the named lights, blackbodies alone are physical; all others are tables relative to 560 nm.
        let is_absolute = name.to_ascii_lowercase().ends_with('k');
        Ok(LightSpectrum { colour: Colour::Spectrum(spectrum), is_absolute })
    }
}

/// The error of the contents of a CSV file.
fn in_csv(path: &Path, invalid: Invalid) -> Invalid {
    Invalid { key: String::new(), message: format!("{}: {}", path.display(), invalid.message), help: invalid.help }
}

fn unknown_spectrum<N: Iterator<Item = &'static str>>(name: &str, names: impl Fn() -> N) -> Invalid {
    let message = format!("photosite has no spectrum called {name:?} of this kind{}", did_you_mean(name, names()));
    Invalid::new("", message)
        .help(format!("known names are {}; write a file as {{ file = \"{name}.csv\" }}", list(name, names())))
}

/// A number 0–1.
pub(crate) fn unit(key: &str, value: f64) -> Result<f32, Invalid> {
    if (0.0..=1.0).contains(&value) {
        return Ok(value as f32);
    }
    Err(Invalid::new(key, format!("must lie between 0 and 1, got {value}")))
}

/// Colours 0–1.
fn unit_rgb(rgb: [f64; 3]) -> Result<[f64; 3], Invalid> {
    if rgb.iter().all(|c| (0.0..=1.0).contains(c)) {
        return Ok(rgb);
    }
    Err(Invalid::new("", format!("must lie between 0 and 1, got {rgb:?}")).help("for example [0.8, 0.2, 0.1]"))
}

fn not_negative_rgb(rgb: [f64; 3]) -> Result<[f32; 3], Invalid> {
    if rgb.iter().all(|c| c.is_finite() && *c >= 0.0) {
        return Ok(rgb.map(|c| c as f32));
    }
    Err(Invalid::new("", format!("must not be negative, got {rgb:?}")))
}

fn not_negative(spectrum: Spectrum) -> Result<Spectrum, Invalid> {
    let negative = spectrum.iter().find(|(_, value)| *value < 0.0);
    match negative {
        Some((lambda, value)) => {
            Err(Invalid::new("", format!("must not be negative, but is {} at {lambda} nm", value as f32)))
        }
        None => Ok(spectrum),
    }
}

/// Display-encoded sRGB → linear.
fn decoded(encoded: [f64; 3]) -> [f32; 3] {
    encoded.map(|c| rgb::decode(c as f32))
}
