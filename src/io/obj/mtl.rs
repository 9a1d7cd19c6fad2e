//! The statements of an MTL file, as lists of parameters.

use std::path::Path;

use glam::Vec2;

use super::lines::{Statement, number, statements};
use crate::io::warnings::Warnings;
use crate::scene::description::Channel;
use crate::texture::{SamplerSettings, UvTransform, Wrap};
use crate::{Invalid, Result};

/// A material as the file has it. Colours are taken as linear sRGB: the format does not say.
#[derive(Clone, Debug, Default)]
pub(super) struct MtlMaterial {
    pub(super) name: String,
    /// `Kd`.
    pub(super) diffuse: Option<[f32; 3]>,
    /// `Ks`.
    pub(super) specular: Option<[f32; 3]>,
    /// `Ke`.
    pub(super) emission: Option<[f32; 3]>,
    /// `Ns`, exponent of a Blinn–Phong lobe.
    pub(super) shininess: Option<f32>,
    /// `Ni`.
    pub(super) index: Option<f32>,
    /// `d`, or 1 − `Tr`.
    pub(super) opacity: Option<f32>,
    /// `illum`.
    pub(super) illumination_model: Option<u32>,
    /// `Pr`, perceptual roughness 0–1.
    pub(super) roughness: Option<f32>,
    /// `Pm`, 0–1.
    pub(super) metallic: Option<f32>,
    /// `Tf`, the colour of light that passes.
    pub(super) transmission_filter: Option<[f32; 3]>,
    /// `Pc`, weight of a clear coat 0–1.
    pub(super) coat: Option<f32>,
    /// `Pcr`, its perceptual roughness.
    pub(super) coat_roughness: Option<f32>,
    /// `Ps`, weight of sheen 0–1.
    pub(super) sheen: Option<f32>,
    /// `aniso`, 0–1.
    pub(super) anisotropy: Option<f32>,
    /// `anisor`, in turns.
    pub(super) anisotropy_rotation: Option<f32>,
    pub(super) diffuse_map: Option<Map>,
    pub(super) emission_map: Option<Map>,
    pub(super) opacity_map: Option<Map>,
    pub(super) roughness_map: Option<Map>,
    pub(super) metallic_map: Option<Map>,
    /// `norm`: a tangent-space normal map.
    pub(super) normal_map: Option<Map>,
}

/// A reference to a picture.
#[derive(Clone, Debug)]
pub(super) struct Map {
    pub(super) file: String,
    pub(super) sampler: SamplerSettings,
    pub(super) transform: UvTransform,
    /// `-imfchan`: which channel counts where one does.
    pub(super) channel: Channel,
    /// `-bm`: factor of bumps.
    pub(super) bumps: f32,
    /// Line and keyword, for messages.
    pub(super) line: usize,
    pub(super) key: String,
}

/// Reads the text of an MTL file.
pub(super) fn parse(text: &str, path: &Path, warnings: &mut Warnings) -> Result<Vec<MtlMaterial>> {
    let mut materials: Vec<MtlMaterial> = Vec::new();
    for statement in statements(text) {
        if statement.keyword() == "newmtl" {
            materials.push(MtlMaterial { name: statement.rest().to_owned(), ..MtlMaterial::default() });
            continue;
        }
        let Some(material) = materials.last_mut() else {
            let message = "comes before any material";
            return Err(statement.at(Invalid::new("", message).help("begin the file with newmtl and a name"), path));
        };
        material.add(&statement, warnings).map_err(|invalid| statement.at(invalid, path))?;
    }
    Ok(materials)
}

impl MtlMaterial {
    fn add(&mut self, statement: &Statement<'_>, warnings: &mut Warnings) -> Result<(), Invalid> {
        let key = statement.keyword();
        let name = self.name.clone();
        let mut left_out =
            |what: &str| warnings.once(format!("material {name:?}: {key} ({what}) is not supported and is left out"));
        match key {
            "Kd" => self.diffuse = colour(statement, warnings)?,
            "Ks" => self.specular = colour(statement, warnings)?,
            "Ke" => self.emission = colour(statement, warnings)?,
            "Ns" => self.shininess = Some(statement.numbers::<1>(1)?.0[0]),
            "Ni" => self.index = Some(statement.numbers::<1>(1)?.0[0]),
            "d" => {
                let mut words = statement.words().peekable();
                if words.next_if_eq(&"-halo").is_some() {
                    left_out("opacity by angle");
                }
                self.opacity = Some(number(words.next().unwrap_or_default())?);
            }
            // Its meaning varies between programs, d's does not.
            "Tr" => {
                let transparency = statement.numbers::<1>(1)?.0[0];
                self.opacity.get_or_insert(1.0 - transparency);
            }
            "illum" => {
                let word = statement.words().next().unwrap_or_default();
                let model = word.parse().map_err(|_| Invalid::new("", format!("{word:?} is no illumination model")));
                self.illumination_model = Some(model?);
            }
            "Pr" => self.roughness = Some(statement.numbers::<1>(1)?.0[0]),
            "Pm" => self.metallic = Some(statement.numbers::<1>(1)?.0[0]),
            "Tf" => self.transmission_filter = colour(statement, warnings)?,
            "Pc" => self.coat = Some(statement.numbers::<1>(1)?.0[0]),
            "Pcr" => self.coat_roughness = Some(statement.numbers::<1>(1)?.0[0]),
            "Ps" => self.sheen = Some(statement.numbers::<1>(1)?.0[0]),
            "aniso" => self.anisotropy = Some(statement.numbers::<1>(1)?.0[0]),
            "anisor" => self.anisotropy_rotation = Some(statement.numbers::<1>(1)?.0[0]),
            "map_Kd" => self.diffuse_map = Some(map(statement, warnings)?),
            "map_Ke" => self.emission_map = Some(map(statement, warnings)?),
            "map_d" => self.opacity_map = Some(map(statement, warnings)?),
            "map_Pr" => self.roughness_map = Some(map(statement, warnings)?),
            "map_Pm" => self.metallic_map = Some(map(statement, warnings)?),
            "norm" | "map_Kn" => self.normal_map = Some(map(statement, warnings)?),
            "map_Bump" | "map_bump" | "bump" => left_out("a height map; give a normal map as norm"),
            "map_Ks" | "map_Ns" | "map_Ps" | "map_Pc" | "map_Pcr" | "map_RMA" | "map_ORM" => left_out("a texture"),
            "disp" | "decal" | "refl" => left_out("a texture"),
            // Of pictures that stand for surroundings, of light that comes from nowhere, of rasterisers.
            "sharpness" | "Ka" | "map_Ka" | "map_aat" => {}
            _ => left_out("an unknown statement"),
        }
        Ok(())
    }
}

/// `r g b`, or `r` for grey. Spectral files and CIE coordinates are left out with a warning.
fn colour(statement: &Statement<'_>, warnings: &mut Warnings) -> Result<Option<[f32; 3]>, Invalid> {
    if matches!(statement.words().next(), Some("spectral" | "xyz")) {
        let (line, key) = (statement.line, statement.keyword());
        warnings.once(format!("line {line}: {key} as a spectrum or as XYZ is not supported and is left out"));
        return Ok(None);
    }
    let (colour, count) = statement.numbers::<3>(1)?;
    match count {
        1 => Ok(Some([colour[0]; 3])),
        3 => Ok(Some(colour)),
        _ => Err(Invalid::new("", format!("needs 1 or 3 numbers, found {count}"))),
    }
}

/// A file name after its options.
fn map(statement: &Statement<'_>, warnings: &mut Warnings) -> Result<Map, Invalid> {
    let mut left_out = |option: &str| {
        let (line, key) = (statement.line, statement.keyword());
        warnings.once(format!("line {line}: {key}: the option -{option} is not supported and is left out"));
    };
    let mut rest = statement.rest();
    let mut sampler = SamplerSettings::default();
    let (mut scale, mut offset) = (Vec2::ONE, Vec2::ZERO);
    let (mut channel, mut bumps) = (Channel::R, 1.0);
    while let Some(option) = rest.strip_prefix('-') {
        let (option, mut after) = split_word(option);
        match option {
            "s" => (scale, after) = vector(after, 1.0),
            "o" => (offset, after) = vector(after, 0.0),
            "t" => {
                let turbulence;
                (turbulence, after) = vector(after, 0.0);
                if turbulence != Vec2::ZERO {
                    left_out(option);
                }
            }
            "mm" => {
                let (base, next) = split_word(after);
                let (gain, next) = split_word(next);
                if (number(base)?, number(gain)?) != (0.0, 1.0) {
                    left_out(option);
                }
                after = next;
            }
            "bm" => {
                let (word, next) = split_word(after);
                (bumps, after) = (number(word)?, next);
            }
            "imfchan" => {
                let (word, next) = split_word(after);
                channel = match word {
                    // Luminance: of a grey picture every channel is.
                    "r" | "l" => Channel::R,
                    "g" => Channel::G,
                    "b" => Channel::B,
                    "m" => Channel::A,
                    _ => {
                        left_out(option);
                        Channel::R
                    }
                };
                after = next;
            }
            "clamp" => {
                let (word, next) = split_word(after);
                if word == "on" {
                    sampler.wrap = [Wrap::ClampToEdge; 2];
                }
                after = next;
            }
            "blendu" | "blendv" | "boost" | "cc" | "texres" | "type" | "colorspace" => {
                after = split_word(after).1;
            }
            // A file may be called anything, even this.
            _ => break,
        }
        rest = after;
    }
    if rest.is_empty() {
        return Err(Invalid::new("", "names no file"));
    }
    // OBJ scales and moves from the bottom of the picture, glTF (v' = 1 − v) from its top:
    // 1 − (s·(1 − v') + o) = s·v' + (1 − s − o).
    let transform = UvTransform { offset: Vec2::new(offset.x, 1.0 - scale.y - offset.y), rotation_rad: 0.0, scale };
    let (line, key) = (statement.line, statement.keyword().to_owned());
    Ok(Map { file: rest.to_owned(), sampler, transform, channel, bumps, line, key })
}

/// The first word and what follows it.
fn split_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

/// One to three numbers, of which the third (for solid textures) does not count, and what follows them.
fn vector(text: &str, default: f32) -> (Vec2, &str) {
    let mut values = [default; 3];
    let mut rest = text;
    for value in &mut values {
        let (word, after) = split_word(rest);
        let Ok(parsed) = number(word) else { break };
        (*value, rest) = (parsed, after);
    }
    (Vec2::new(values[0], values[1]), rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(lines: &str) -> Result<MtlMaterial> {
        let found = parse(&format!("newmtl m\n{lines}"), Path::new("a.mtl"), &mut Warnings::default())?;
        Ok(found.into_iter().next().expect("one material"))
    }

    #[test]
    fn parameters_are_read() {
        let m =
            material("Kd .1 .2 .3\nKs 0.5\nKe 1 2 3\nNs 100\nNi 1.5\nillum 7\nPr 0.4\nPm 1\nTr 0.25").expect("valid");
        assert_eq!((m.diffuse, m.specular, m.emission), (Some([0.1, 0.2, 0.3]), Some([0.5; 3]), Some([1.0, 2.0, 3.0])));
        assert_eq!(
            (m.shininess, m.index, m.illumination_model, m.opacity),
            (Some(100.0), Some(1.5), Some(7), Some(0.75))
        );
        assert_eq!((m.roughness, m.metallic), (Some(0.4), Some(1.0)));
        let m = material("Tf 1 0.5 0\nPc 0.3\nPcr 0.1\nPs 0.2\naniso 0.7\nanisor 0.25").expect("valid");
        assert_eq!((m.transmission_filter, m.coat, m.coat_roughness), (Some([1.0, 0.5, 0.0]), Some(0.3), Some(0.1)));
        assert_eq!((m.sheen, m.anisotropy, m.anisotropy_rotation), (Some(0.2), Some(0.7), Some(0.25)));
        assert_eq!(material("Tr 1\nd -halo 0.5").expect("valid").opacity, Some(0.5));
        assert_eq!(material("Kd spectral gold.rfl 1.0\nKs xyz 1 1 1").expect("left out").diffuse, None);
    }

    #[test]
    fn options_of_maps_are_followed_and_names_may_have_blanks() {
        let map =
            material("map_Kd -clamp on -s 2 4 -o 0.5 0.25 -bm 0.3 -mm 0 1 my wood.png").expect("valid").diffuse_map;
        let map = map.expect("a map");
        assert_eq!((map.bumps, map.channel), (0.3, Channel::R));
        let rough = material("map_Pr -imfchan g -mm 0.5 2 r.png").expect("valid").roughness_map.expect("a map");
        assert_eq!((rough.channel, rough.file.as_str()), (Channel::G, "r.png"));
        assert_eq!((map.file.as_str(), map.sampler.wrap), ("my wood.png", [Wrap::ClampToEdge; 2]));
        // At OBJ's (u, v) = (0, 0), which is (0, 1) here, OBJ looks up (0.5, 0.25), which is (0.5, 0.75) here.
        assert_eq!(Vec2::new(0.0, 1.0) * map.transform.scale + map.transform.offset, Vec2::new(0.5, 0.75));
        assert_eq!(material("norm -odd name.png").expect("valid").normal_map.expect("a map").file, "-odd name.png");
    }

    #[test]
    fn errors_name_the_line() {
        for (lines, message) in [
            ("Kd 1 2", "a.mtl:2: Kd: needs 1 or 3"),
            ("Kd", "a.mtl:2: Kd: "),
            ("Ns x", "a.mtl:2: Ns: \"x\""),
            ("Ka 1\nd", "a.mtl:3: d: "),
            ("map_Kd -s 1", "a.mtl:2: map_Kd: names no file"),
            ("illum two", "a.mtl:2: illum: \"two\""),
        ] {
            let error = material(lines).expect_err(lines).to_string();
            assert!(error.starts_with(message), "{error}");
        }
        let error = parse("Kd 1 1 1", Path::new("a.mtl"), &mut Warnings::default()).expect_err("no name").to_string();
        assert!(error.contains("before any material"), "{error}");
    }
}
