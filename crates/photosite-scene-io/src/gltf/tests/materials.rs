//! Materials, their extensions, textures and variants.

use super::*;

#[test]
fn a_material_keeps_all_it_says() {
    let image = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let pixels = image::RgbaImage::from_pixel(2, 2, image::Rgba([1, 2, 3, 4]));
        pixels.write_to(&mut bytes, image::ImageFormat::Png).expect("encoded");
        bytes.into_inner()
    };
    let mut fixture = Fixture::square();
    let view = fixture.view(&image);
    fixture.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    fixture.json["samplers"] = json!([{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }]);
    fixture.json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    let moved =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0.25], "rotation": 1.5, "scale": [2, 3], "texCoord": 0 }});
    fixture.json["materials"] = json!([{
        "name": "paint",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6,
            "baseColorTexture": { "index": 0, "texCoord": 1, "extensions": moved },
        },
        "normalTexture": { "index": 0, "scale": 0.7, "extensions": moved },
        "emissiveFactor": [1.0, 0.5, 0.0],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 300.0 } },
        "alphaMode": "MASK", "doubleSided": true,
    }]);
    fixture.primitive()["material"] = json!(0);
    let scene = fixture.scene();
    assert_eq!(scene.images.len(), 1, "an image is decoded once");
    assert!(matches!(&scene.images[0].texels, Texels::Rgba8(t) if t[3] == [1, 2, 3, 4]));
    let material = &scene.materials[0];
    assert_eq!((material.name.as_str(), material.double_sided, material.alpha_factor), ("paint", true, 0.4));
    assert_eq!(material.alpha, AlphaMode::Mask { cutoff: 0.5 });
    assert!(material.alpha_texture.is_some());
    let MaterialModel::Layered(layers) = &material.model else { panic!("{:?}", material.model) };
    let (Colour::Rgb(base), Some(texture)) = (&layers.base_colour.colour, &layers.base_colour.texture) else {
        panic!("{:?}", layers.base_colour)
    };
    assert_eq!((*base, layers.metallic.value, layers.roughness.value), ([0.1, 0.2, 0.3], 0.5, 0.6));
    assert_eq!(texture.uv_set, 0, "the transform overrides texCoord");
    assert_eq!(texture.sampler.wrap, [Wrap::ClampToEdge, Wrap::MirroredRepeat]);
    assert_eq!(texture.sampler.filter, Filter::Nearest);
    let (normal, scale) = material.normal_map.as_ref().expect("a normal map");
    assert_eq!((*scale, normal.transform.rotation_rad, normal.transform.scale), (0.7, 1.5, Vec2::new(2.0, 3.0)));
    let emission = material.emission.as_ref().expect("emission");
    assert!(matches!(emission.colour, Colour::Rgb([1.0, 0.5, 0.0])) && emission.level == Some(300.0));
}

#[test]
fn extensions_of_materials_are_read_with_their_defaults() {
    let with = |extensions: Value| {
        let scene = Fixture::square().with("/materials", json!([{ "extensions": extensions }])).scene();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let MaterialModel::Layered(layers) = &scene.materials[0].model else { panic!("not layered") };
        layers.clone()
    };
    let plain = with(json!({}));
    assert!((plain.index.index(589.0) - 1.5).abs() < 1e-9 && plain.metallic.value == 1.0);
    assert!(plain.coat.is_none() && plain.sheen.is_none() && plain.film.is_none() && plain.absorption_per_m.is_none());
    let index = with(json!({ "KHR_materials_ior": { "ior": 1.7 }, "KHR_materials_dispersion": { "dispersion": 0.5 } }));
    assert!((index.index.abbe_number() - 40.0).abs() < 0.01 && (index.index.index(587.5618) - 1.7).abs() < 1e-4);
    assert_eq!(with(json!({ "KHR_materials_ior": { "ior": 0 } })).normal_reflectance, Some(1.0));
    let thin = with(json!({ "KHR_materials_transmission": { "transmissionFactor": 0.8 }, "KHR_materials_volume": {} }));
    assert!(thin.transmission.value == 0.8 && thin.absorption_per_m.is_none());
    let volume = json!({ "thicknessFactor": 0.1, "attenuationDistance": 0.5, "attenuationColor": [0.25, 0.25, 0.25] });
    let thick = with(json!({ "KHR_materials_volume": volume }));
    // A grey of 1/4 after half a metre: ln 4 / 0.5 m at every wavelength.
    let absorption = thick.absorption_per_m.expect("a volume");
    assert!((f64::from(absorption.eval(500.0)) - 4f64.ln() / 0.5).abs() < 1e-5);
    let coat = with(json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.2 } }));
    assert!(coat.coat.is_some_and(|coat| coat.weight.value == 1.0 && coat.roughness.value == 0.2));
    let film = with(json!({ "KHR_materials_iridescence": { "iridescenceFactor": 1.0 } })).film.expect("a film");
    assert_eq!((film.index, film.thickness_nm), (1.3, [100.0, 400.0]));
    assert!(with(json!({ "KHR_materials_sheen": {} })).sheen.is_none());
    let leaf = json!({ "diffuseTransmissionFactor": 0.4 });
    let (part, _) = with(json!({ "KHR_materials_diffuse_transmission": leaf })).diffuse_transmission.expect("a leaf");
    assert_eq!(part.value, 0.4);
    let glossy = json!({ "glossinessFactor": 0.75, "specularFactor": [0.5, 0.25, 0.125] });
    let glossy = with(json!({ "KHR_materials_pbrSpecularGlossiness": glossy }));
    assert_eq!((glossy.roughness.value, glossy.metallic.value, glossy.normal_reflectance), (0.25, 0.0, Some(1.0)));
    assert!(matches!(glossy.specular_colour.colour, Colour::Rgb([0.5, 0.25, 0.125])));
}

#[rstest]
#[case::index("KHR_materials_ior", json!({ "ior": 0.5 }), "materials[0].extensions.KHR_materials_ior.ior: must be at least 1")]
#[case::film("KHR_materials_iridescence", json!({ "iridescenceIor": -1 }), "iridescenceIor: must be at least 1")]
#[case::distance("KHR_materials_volume", json!({ "thicknessFactor": 1, "attenuationDistance": 0 }), "must be above 0")]
#[case::negative("KHR_materials_dispersion", json!({ "dispersion": -1 }), "must not be negative")]
#[case::kind("KHR_materials_sheen", json!({ "sheenColorFactor": "red" }), "KHR_materials_sheen: invalid type")]
#[case::texture("KHR_materials_clearcoat", json!({ "clearcoatTexture": { "index": 7 } }), "refers to textures[7]")]
fn impossible_extensions_are_refused(#[case] name: &str, #[case] table: Value, #[case] message: &str) {
    let error = Fixture::square().with("/materials", json!([{ "extensions": { name: table } }])).error();
    assert!(error.contains(message), "{error}");
}

#[test]
fn a_variant_is_chosen_by_its_name() {
    let fixture = || {
        let mut fixture = Fixture::square().with("/materials", json!([{ "name": "red" }, { "name": "blue" }]));
        let variants = json!({ "variants": [{ "name": "summer" }, { "name": "winter" }] });
        fixture.json["extensions"] = json!({ "KHR_materials_variants": variants });
        fixture.primitive()["material"] = json!(0);
        let mappings = json!({ "mappings": [{ "variants": [1], "material": 1 }] });
        fixture.primitive()["extensions"] = json!({ "KHR_materials_variants": mappings });
        fixture
    };
    for (variant, material) in [(None, 0), (Some("summer"), 0), (Some("winter"), 1), (Some("autumn"), 0)] {
        let file = fixture().variant(variant).expect("valid");
        assert_eq!(file.variants, ["summer", "winter"]);
        assert_eq!(file.scene.meshes[0].material, material, "{variant:?}");
    }
    assert!(fixture().with("/extensions/KHR_materials_variants", json!(3)).error().contains("KHR_materials_variants"));
}

#[test]
fn webp_images_are_read() {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbaImage::from_pixel(2, 2, image::Rgba([1, 2, 3, 4]));
    pixels.write_to(&mut bytes, image::ImageFormat::WebP).expect("encoded");
    let mut fixture = Fixture::square();
    let view = fixture.view(&bytes.into_inner());
    fixture.json["images"] = json!([{ "bufferView": view, "mimeType": "image/webp" }]);
    fixture.json["textures"] = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    fixture.json["materials"] = json!([{ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 } }]);
    let scene = fixture.with("/extensionsRequired", json!(["EXT_texture_webp"])).scene();
    assert!(matches!(&scene.images[0].texels, Texels::Rgba8(t) if t[3] == [1, 2, 3, 4]));
}
