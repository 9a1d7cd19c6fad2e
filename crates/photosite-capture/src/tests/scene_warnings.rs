//! Tests of the warnings about a scene as a whole.

use super::*;

const LAMP: &str = "[[lights]]\nname = \"bulb\"\ntype = \"point\"\nposition_m = [0, 0, 2]\nintensity_cd = 100";

/// Warnings of a capture that contain all of these words.
fn said(more: &str, words: &[&str]) -> usize {
    let warnings = capture(&room(more)).warnings();
    warnings.iter().filter(|warning| words.iter().all(|word| warning.contains(word))).count()
}

#[test]
fn what_microfacets_lose_is_said_where_it_is_a_tenth() {
    let metal = |roughness: f64, more: &str| {
        let keys = format!("[materials.wall]\ntype = \"conductor\"\nmetal = \"Ag\"\nroughness = {roughness}\n{more}");
        said(&keys, &["\"wall\"", "lose", "energy_compensation"])
    };
    let glass = |roughness: f64, more: &str| {
        let keys = format!("[materials.wall]\ntype = \"dielectric\"\nindex = 1.5\nroughness = {roughness}\n{more}");
        said(&keys, &["\"wall\"", "lose", "energy_compensation"])
    };
    for material in [&metal as &dyn Fn(f64, &str) -> usize, &glass] {
        assert_eq!([0.0, 0.3, 1.0].map(|roughness| material(roughness, "")), [0, 0, 1]);
        assert_eq!(material(1.0, "energy_compensation = true"), 0);
    }
    // Half of the surface, half of the loss; a metal that absorbs most of the light has little to lose.
    let mixed = "[materials.wall]\ntype = \"mix\"\nweight = 0.1\nfirst = { type = \"diffuse\", reflectance = 0.5 }\n\
                 second = { type = \"conductor\", metal = \"Ag\", roughness = 1.0 }";
    assert_eq!(said(mixed, &["lose"]), 0);
    let dark = "[materials.wall]\ntype = \"conductor\"\nmetal = { eta = 1.5, k = 0.5 }\nroughness = 1.0";
    assert_eq!(said(dark, &["lose"]), 0);
}

#[test]
fn solid_glass_is_named_where_a_lamp_without_a_surface_shines() {
    let glass = |more: &str| format!("[materials.\"ball.glass\"]\ntype = {more}\n");
    let words = ["caustics of lights without a surface are not found", "\"ball.glass\"", "\"bulb\"", "thin-dielectric"];
    for (material, lamp, expected) in [
        ("\"dielectric\"\nindex = 1.5", LAMP, 1),
        ("\"dielectric\"\nindex = 1.5", "", 0),
        ("\"dielectric\"\nindex = 1.5\nroughness = 0.5", LAMP, 0),
        ("\"thin-dielectric\"\nindex = 1.5", LAMP, 0),
        ("\"diffuse\"\nreflectance = 0.5", LAMP, 0),
        (
            "\"mix\"\nweight = 0.5\nfirst = { type = \"diffuse\", reflectance = 0.5 }\n\
             second = { type = \"dielectric\", index = 1.5 }",
            LAMP,
            1,
        ),
    ] {
        assert_eq!(said(&(glass(material) + lamp), &words), expected, "{material}, {lamp}");
    }
}

/// Case: the surfaces that no ray meets, or that change none, are named with what has them.
#[test]
fn what_is_wholly_transparent_is_named() {
    let words = ["is wholly transparent", "\"wall\""];
    for (material, expected) in [
        ("type = \"dielectric\"\nindex = 1.0", 1),
        ("type = \"dielectric\"\nindex = 1.001", 0),
        ("type = \"thin-dielectric\"\nindex = 1.0", 1),
        ("type = \"thin-dielectric\"\nindex = 1.0\ntransmittance = 0.9", 0),
        (
            "type = \"mix\"\nweight = 1\nfirst = { type = \"diffuse\", reflectance = 0.5 }\n\
             second = { type = \"thin-dielectric\", index = 1.0 }",
            1,
        ),
        (
            "type = \"mix\"\nweight = 0.9\nfirst = { type = \"diffuse\", reflectance = 0.5 }\n\
             second = { type = \"thin-dielectric\", index = 1.0 }",
            0,
        ),
    ] {
        assert_eq!(said(&format!("[materials.wall]\n{material}"), &words), expected, "{material}");
    }
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(2, 1, image::Rgba([255, 0, 0, 0]))
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("encoded");
    for (mtl, expected) in [
        ("d 0", 1),
        ("d 0.01", 0),
        ("d 1\nTr 1", 0),
        ("Tr 1", 0),
        ("d 0\nNi 1.5", 0),
        ("map_d clear.png", 1),
        ("map_d -mm 0.5 1 clear.png", 0),
    ] {
        let files = Files::new(&room(""));
        files.add("clear.png", png.get_ref());
        files.add("a.mtl", format!("newmtl wall\nKd 1 0 0\n{mtl}\n").as_bytes());
        files.add("room.obj", format!("mtllib a.mtl\n{OBJ}").as_bytes());
        let warnings = files.read(&[]).expect("a capture").warnings();
        let found = warnings.iter().filter(|warning| words.iter().all(|word| warning.contains(word)));
        assert_eq!(found.count(), expected, "{mtl}: {warnings:?}");
    }
}
