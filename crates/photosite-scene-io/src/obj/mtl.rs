//! Statements of an MTL file, as lists of parameters.

use std::path::Path;

use glam::DVec3;

use super::lines::{Statement, number, statements};
use super::map::{Map, MapChannel, map};
use photosite_core::spectrum::rgb;
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result};

/// A material of the file. Colours are taken as linear sRGB, since the format does not define their space.
#[derive(Clone, Debug, Default)]
pub(super) struct MtlMaterial {
    pub(super) name: String,
    /// Diffuse colour `Kd`.
    pub(super) diffuse: Option<[f32; 3]>,
    /// Specular colour `Ks`.
    pub(super) specular: Option<[f32; 3]>,
    /// Emission `Ke`, nit.
    pub(super) emission: Option<[f32; 3]>,
    /// Exponent `Ns` of a Blinn–Phong lobe.
    pub(super) shininess: Option<f32>,
    /// Index of refraction `Ni`.
    pub(super) index: Option<f32>,
    /// Opacity `d`, or derived from `Tr`.
    pub(super) opacity: Option<f32>,
    /// Transparency `Tr`.
    pub(super) transparency: Option<f32>,
    /// Illumination model `illum`.
    pub(super) illumination_model: Option<u32>,
    /// Perceptual roughness `Pr`, 0–1.
    pub(super) roughness: Option<f32>,
    /// Metallic weight `Pm`, 0–1.
    pub(super) metallic: Option<f32>,
    /// Transmission filter `Tf`, the colour of transmitted light.
    pub(super) transmission_filter: Option<[f32; 3]>,
    /// Weight `Pc` of a clear coat, 0–1.
    pub(super) coat: Option<f32>,
    /// Perceptual roughness `Pcr` of the clear coat.
    pub(super) coat_roughness: Option<f32>,
    /// Weight `Ps` of sheen, 0–1.
    pub(super) sheen: Option<f32>,
    /// Strength `aniso` of anisotropy, 0–1.
    pub(super) anisotropy: Option<f32>,
    /// Rotation `anisor` of anisotropy, turns.
    pub(super) anisotropy_rotation: Option<f32>,
    pub(super) diffuse_map: Option<Map>,
    pub(super) specular_map: Option<Map>,
    pub(super) emission_map: Option<Map>,
    /// Map that multiplies the exponent.
    pub(super) shininess_map: Option<Map>,
    pub(super) opacity_map: Option<Map>,
    pub(super) roughness_map: Option<Map>,
    pub(super) metallic_map: Option<Map>,
    pub(super) sheen_map: Option<Map>,
    pub(super) coat_map: Option<Map>,
    pub(super) coat_roughness_map: Option<Map>,
    /// Tangent-space normal map `norm`.
    pub(super) normal_map: Option<Map>,
    /// Height map `bump`.
    pub(super) bump_map: Option<Map>,
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
    materials.iter_mut().for_each(|material| material.settle(warnings));
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
            "Tr" => self.transparency = Some(statement.numbers::<1>(1)?.0[0]),
            "illum" => {
                let word = statement.words().next().unwrap_or_default();
                let model =
                    word.parse().map_err(|_| Invalid::new("", format!("{word:?} is not an illumination model")));
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
            "map_Ks" => self.specular_map = Some(map(statement, warnings)?),
            "map_Ke" => self.emission_map = Some(map(statement, warnings)?),
            "map_Ns" => self.shininess_map = Some(map(statement, warnings)?),
            "map_d" => self.opacity_map = Some(map(statement, warnings)?),
            "map_Pr" => self.roughness_map = Some(map(statement, warnings)?),
            "map_Pm" => self.metallic_map = Some(map(statement, warnings)?),
            "map_Ps" => self.sheen_map = Some(map(statement, warnings)?),
            "map_Pc" => self.coat_map = Some(map(statement, warnings)?),
            "map_Pcr" => self.coat_roughness_map = Some(map(statement, warnings)?),
            // Roughness, metalness and occlusion in one image, in the order that the letters say.
            "map_RMA" | "map_ORM" => {
                let [roughness, metallic] = match key {
                    "map_RMA" => [MapChannel::R, MapChannel::G],
                    _ => [MapChannel::G, MapChannel::B],
                };
                let packed = map(statement, warnings)?;
                self.roughness_map = Some(Map { channel: Some(roughness), ..packed.clone() });
                self.metallic_map = Some(Map { channel: Some(metallic), ..packed });
            }
            "norm" | "map_Kn" => self.normal_map = Some(map(statement, warnings)?),
            "map_Bump" | "map_bump" | "bump" => self.bump_map = Some(map(statement, warnings)?),
            "disp" | "decal" | "refl" => left_out("a texture"),
            // Of images that stand for surroundings, of light that comes from nowhere, of rasterisers.
            "sharpness" | "Ka" | "map_Ka" | "map_aat" => {}
            _ => left_out("an unknown statement"),
        }
        Ok(())
    }
}

impl MtlMaterial {
    /// Resolves statements of a material that contradict each other, or mean different things to different programs, as
    /// most programs do.
    fn settle(&mut self, warnings: &mut Warnings) {
        let name = &self.name;
        let mut say = |what: String| warnings.once(format!("material {name:?}: {what}"));
        // Its meaning varies between programs, that of d does not.
        if let (None, Some(transparency)) = (self.opacity, self.transparency) {
            if transparency >= 1.0 {
                say(format!(
                    "Tr {transparency} without d is taken for an opaque surface, as MeshLab, OpenMVS and others mean it; \
                     write d 0 for one that is not there"
                ));
            } else if transparency > 0.0 {
                let opacity = 1.0 - transparency;
                say(format!(
                    "Tr {transparency} without d is taken for the part of the light that passes, as d {opacity}; programs \
                     disagree about it, so write d"
                ));
                self.opacity = Some(opacity);
            }
        }
        if let Some(opacity) = self.opacity.filter(|opacity| !(0.0..=1.0).contains(opacity)) {
            say(format!("d {opacity} is outside 0–1 and is cut off there"));
        }
        // Programs write what they do not use as 0 beside an image of it, and read the image alone.
        let mut alone = |key: &str, map: &Option<Map>, is_zero: bool| {
            let Some(map) = map.as_ref().filter(|_| is_zero) else { return false };
            say(format!("{key} 0 beside {} would leave nothing of the image {:?} and is left out", map.key, map.file));
            true
        };
        for (key, colour, map) in [
            ("Kd", &mut self.diffuse, &self.diffuse_map),
            ("Ks", &mut self.specular, &self.specular_map),
            ("Ke", &mut self.emission, &self.emission_map),
        ] {
            if alone(key, map, *colour == Some([0.0; 3])) {
                *colour = None;
            }
        }
        for (key, number, map) in [
            ("Ns", &mut self.shininess, &self.shininess_map),
            ("d", &mut self.opacity, &self.opacity_map),
            ("Pr", &mut self.roughness, &self.roughness_map),
            ("Pm", &mut self.metallic, &self.metallic_map),
            ("Ps", &mut self.sheen, &self.sheen_map),
            ("Pc", &mut self.coat, &self.coat_map),
            ("Pcr", &mut self.coat_roughness, &self.coat_roughness_map),
        ] {
            if alone(key, map, *number == Some(0.0)) {
                *number = None;
            }
        }
    }
}

/// Colour of `r g b`, or of `r` for grey; after `xyz`, tristimulus values, where white has the XYZ of D65 at Y = 1.
/// Files of spectra are left out with a warning.
fn colour(statement: &Statement<'_>, warnings: &mut Warnings) -> Result<Option<[f32; 3]>, Invalid> {
    let mut words = statement.words();
    let form = words.next().filter(|word| matches!(*word, "spectral" | "xyz"));
    if form == Some("spectral") {
        let (line, key) = (statement.line, statement.keyword());
        warnings.once(format!("line {line}: {key} as a spectral curve is not supported and is left out"));
        return Ok(None);
    }
    let words = if form.is_some() { words } else { statement.words() };
    let numbers: Vec<f32> = words.take(4).map(number).collect::<Result<_, _>>()?;
    let colour = match numbers[..] {
        [grey] => [grey; 3],
        [x, y, z] => [x, y, z],
        _ => return Err(Invalid::new("", format!("needs 1 or 3 numbers, found {}", numbers.len()))),
    };
    Ok(Some(if form.is_some() {
        (*rgb::xyz_to_rgb() * DVec3::from_array(colour.map(f64::from))).as_vec3().to_array()
    } else {
        colour
    }))
}

/// Perceptual roughness of a Blinn–Phong exponent.
pub(super) fn roughness_of_exponent(exponent: f32) -> f32 {
    (2.0 / (exponent.max(0.0) + 2.0)).powf(0.25)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;
    use rstest::rstest;

    use super::*;
    use crate::obj::map::Range;
    use photosite_transport::texture::Wrap;

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
        assert_eq!(material("Kd spectral gold.rfl 1.0").expect("left out").diffuse, None);
        // The red of sRGB has (x, y) = (0.64, 0.33) and Y = 0.2126, rounded.
        let [r, g, b] = material("Ks xyz 0.4124 0.2126 0.0193").expect("valid").specular.expect("a colour");
        assert!((r - 1.0).abs() < 1e-3 && g.abs() < 1e-3 && b.abs() < 1e-3, "{r} {g} {b}");
    }

    #[test]
    fn options_of_maps_are_followed_and_names_may_have_blanks() {
        let text = "map_Kd -clamp on -s 2 4 -o 0.5 0.25 -bm 0.3 -mm 0 1 my wood.png";
        let map = material(text).expect("valid").diffuse_map.expect("a map");
        assert_eq!((map.bumps, map.channel, map.range), (0.3, None, Range::WHOLE));
        assert_eq!((map.file.as_str(), map.sampler.wrap), ("my wood.png", [Wrap::ClampToEdge; 2]));
        // At OBJ's (u, v) = (0, 0), which is (0, 1) here, OBJ looks up (0.5, 0.25), which is (0.5, 0.75) here.
        assert_eq!(Vec2::new(0.0, 1.0) * map.transform.scale + map.transform.offset, Vec2::new(0.5, 0.75));
        let rough = material("map_Pr -imfchan g -mm 0.5 2 r.png").expect("valid").roughness_map.expect("a map");
        assert_eq!((rough.channel, rough.file.as_str()), (Some(MapChannel::G), "r.png"));
        assert_eq!(rough.range, Range { base: 0.5, gain: 2.0 });
        assert_eq!(material("norm -odd name.png").expect("valid").normal_map.expect("a map").file, "-odd name.png");
    }

    /// A material, and its warnings.
    fn told(lines: &str) -> (MtlMaterial, Vec<String>) {
        let mut warnings = Warnings::default();
        let found = parse(&format!("newmtl m\n{lines}"), Path::new("a.mtl"), &mut warnings).expect("valid");
        (found.into_iter().next().expect("one material"), warnings.into_messages())
    }

    /// Transparency of opaque surfaces as MeshLab, OpenMVS, mvs-texturing and 3ds Max write it, and as the format
    /// defines it.
    #[test]
    fn transparency_without_d_is_opaque_where_it_is_0_or_1() {
        for (lines, opacity, words) in [
            ("Tr 1.000000", None, "Tr 1 without d is taken for an opaque surface"),
            ("Tr 0", None, ""),
            ("Tr 0.25", Some(0.75), "as d 0.75"),
            ("Tr 1.0\nd 1.0", Some(1.0), ""),
            ("d 1.0\nTr 0.0", Some(1.0), ""),
            ("Tr 1\nd 0", Some(0.0), ""),
            ("Tr 0\nd 0.25", Some(0.25), ""),
            ("d 1.5", Some(1.5), "d 1.5 is outside 0–1"),
        ] {
            let (material, warnings) = told(lines);
            assert_eq!(material.opacity, opacity, "{lines}");
            assert_eq!(warnings.len(), usize::from(!words.is_empty()), "{lines}: {warnings:?}");
            assert!(warnings.iter().all(|w| w.starts_with("material \"m\": ") && w.contains(words)), "{warnings:?}");
        }
    }

    #[rstest]
    #[case("Kd 0 0 0", "map_Kd")]
    #[case("Kd 0", "map_Kd")]
    #[case("Ks 0 0 0", "map_Ks")]
    #[case("Ke 0 0 0", "map_Ke")]
    #[case("Ns 0", "map_Ns")]
    #[case("d 0", "map_d")]
    #[case("Pr 0", "map_Pr")]
    #[case("Pm 0.0", "map_Pm")]
    #[case("Pm 0", "map_ORM")]
    #[case("Ps 0", "map_Ps")]
    #[case("Pc 0", "map_Pc")]
    #[case("Pcr 0", "map_Pcr")]
    fn nothing_beside_an_image_leaves_the_image(#[case] zero: &str, #[case] map: &str) {
        for lines in [format!("{zero}\n{map} a.png"), format!("{map} a.png\n{zero}")] {
            let (found, warnings) = told(&lines);
            let bare = format!("{:?}", told(&format!("{map} a.png")).0);
            // But for the line of the map
            assert_eq!(format!("{found:?}").replace("line: 3", "line: 2"), bare);
            let key = zero.split(' ').next().unwrap_or_default();
            let [warning] = &warnings[..] else { panic!("{warnings:?}") };
            assert!(warning.contains(&format!("{key} 0 beside {map} ")) && warning.contains("a.png"), "{warning}");
        }
        assert_eq!(told(zero).1, Vec::<String>::new());
    }

    #[test]
    fn every_map_has_its_place() {
        let text = "map_Ks a\nmap_Ke b\nmap_Ns c\nmap_Ps d\nmap_Pc e\nmap_Pcr f\nbump -bm 0.5 g\nmap_d h";
        let m = material(text).expect("valid");
        let all = [m.specular_map, m.emission_map, m.shininess_map, m.sheen_map, m.coat_map, m.coat_roughness_map];
        let files: Vec<_> =
            all.into_iter().chain([m.bump_map, m.opacity_map]).map(|m| m.expect("a map").file).collect();
        assert_eq!(files, ["a", "b", "c", "d", "e", "f", "g", "h"]);
        for (key, channels) in
            [("map_RMA", [MapChannel::R, MapChannel::G]), ("map_ORM", [MapChannel::G, MapChannel::B])]
        {
            let m = material(&format!("{key} all.png")).expect("valid");
            assert_eq!([m.roughness_map, m.metallic_map].map(|m| m.expect("a map").channel), channels.map(Some));
        }
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
