//! Tests of the meaning of captures.

use std::f64::consts::PI;
use std::fs;

use glam::{DAffine3, DVec3};
use rstest::rstest;

use super::*;
use photosite_core::spectrum::{illuminant, library};
use photosite_core::units::{Celsius, Decibels, Seconds};
use photosite_sensor::{Counting, presets};
use photosite_transport::geometry::QuadricKind;
use photosite_transport::integrator::WavelengthChoice;
use photosite_transport::light::SpotLight;
use photosite_transport::optics::{BrownConrady, Falloff, Focus, LensKind, Projection};
use photosite_transport::sampler::SamplerKind;
use photosite_transport::scene::description::{
    AlphaMode, Colour, Dielectric, Diffuse, EnvironmentDescription, ImageLevel, LightKind, MaterialDescription,
    MaterialModel, Roughness,
};
use photosite_transport::texture::Wrap;

fn material<'a>(capture: &'a Capture, name: &str) -> &'a MaterialDescription {
    capture.scene.materials.iter().find(|material| material.name == name).expect("the geometry has it")
}

#[test]
fn a_capture_without_anything_but_geometry_has_defaults() {
    let capture = capture(&room(""));
    assert_eq!(capture.sensor, presets::model(presets::DEFAULT).expect("the default"));
    assert_eq!((capture.lens.kind, capture.lens.focal_length_m, capture.lens.f_number), (LensKind::Thin, 0.016, 8.0));
    assert!(matches!(capture.lens.focus, Focus::Distance(_)), "focused on what is framed");
    assert_eq!(capture.render, RenderSettings::default());
    assert!(matches!(capture.exposure.time, ExposureTime::Auto(_)));
    assert_eq!((capture.exposure.gain, capture.exposure.frames), (Decibels(0.0), 1));
    assert_eq!((&capture.output.raw[..], capture.output.electrons), (&[RawFormat::Dng][..], true));
    // Nothing describes the three materials of the OBJ file.
    assert_eq!(capture.warnings().len(), 3, "{:?}", capture.scene.warnings);
    let Some(EnvironmentDescription::Constant { luminance_nit: Some(nit), colour: Colour::Spectrum(colour) }) =
        &capture.scene.environment
    else {
        panic!("{:?}", capture.scene.environment)
    };
    assert!((nit * PI - 500.0).abs() < 1e-9 && colour == illuminant::d65());
}

#[test]
fn materials_replace_those_of_the_geometry() {
    let files = Files::new(&room(
        r#"
        [materials.wall]
        type = "diffuse"
        reflectance = { file = "red.csv" }
        [materials.lamp]
        emission = { spectrum = "cornell/light", luminance_nit = 5000 }
        double_sided = false
        [materials."ball.glass"]
        type = "dielectric"
        glass = "BK7"
        roughness = 0.25
        "#,
    ));
    files.add("red.csv", b"400,0.1\n700,0.7\n");
    let capture = files.read(&[]).expect("valid");
    assert!(capture.warnings().is_empty(), "{:?}", capture.scene.warnings);
    let MaterialModel::Diffuse(Diffuse { reflectance }) = &material(&capture, "wall").model else {
        panic!("{:?}", material(&capture, "wall"))
    };
    let Colour::Spectrum(red) = &reflectance.colour else { panic!("{reflectance:?}") };
    assert!((red.eval(550.0) - 0.4).abs() < 1e-6 && red.eval(1000.0) == 0.7);
    let lamp = material(&capture, "lamp");
    assert!(matches!(lamp.model, MaterialModel::Diffuse(_)) && !lamp.double_sided);
    assert_eq!(lamp.emission.as_ref().and_then(|e| e.level), Some(5000.0));
    let glass = material(&capture, "ball.glass");
    assert!(
        matches!(&glass.model, MaterialModel::Dielectric(Dielectric { index, distribution: Roughness { value: 0.25, anisotropy: 0.0 }, .. }) if Some(index) == library::glass("BK7").as_ref())
    );
    assert_eq!(glass.alpha, AlphaMode::Opaque);
}

#[rstest]
#[case::number("reflectance = 0.5")]
#[case::rgb("reflectance = [1, 0.5, 0]")]
#[case::linear("reflectance = { linear_rgb = [1, 0.5, 0] }")]
#[case::name("reflectance = \"cornell/white\"")]
fn reflectances_come_in_several_shapes(#[case] line: &str) {
    let capture = capture(&room(&format!("[materials.wall]\ntype = \"diffuse\"\n{line}")));
    let MaterialModel::Diffuse(Diffuse { reflectance }) = &material(&capture, "wall").model else {
        panic!("not diffuse")
    };
    match &reflectance.colour {
        Colour::Rgb(rgb) if line.contains("linear") => assert_eq!(*rgb, [1.0, 0.5, 0.0]),
        // sRGB 0.5 is 0.21404 in linear light.
        Colour::Rgb(rgb) => assert!((rgb[1] - 0.214_041).abs() < 1e-5 && rgb[0] == 1.0 && rgb[2] == 0.0, "{rgb:?}"),
        Colour::Spectrum(spectrum) if line.contains("white") => {
            assert_eq!(Some(spectrum), library::reflectance("cornell/white").as_ref())
        }
        Colour::Spectrum(spectrum) => assert_eq!((spectrum.min(), spectrum.max()), (0.5, 0.5)),
    }
}

#[test]
fn metals_indices_and_textures_come_in_several_shapes() {
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(1, 1).write_to(&mut png, image::ImageFormat::Png).expect("encoded");
    for (table, check) in [
        ("type = 'conductor'\nmetal = 'Au'", "Conductor"),
        (
            "type = 'conductor'\nmetal = { eta = 0.2, k = { file = 'k.csv' } }\nroughness = 0.3\nanisotropy = -0.5",
            "Conductor",
        ),
        ("type = 'conductor'\nmetal = { file = 'nk.csv' }", "Conductor"),
        ("type = 'dielectric'\nindex = 1.5", "Cauchy"),
        ("type = 'dielectric'\nindex = 1.5\nabbe_number = 60", "Cauchy"),
        ("type = 'dielectric'\nindex = { sellmeier_b = [1.03961212], sellmeier_c_um2 = [0.00600069867] }", "Sellmeier"),
        ("type = 'dielectric'\nindex = { cauchy_a = 1.5, cauchy_b_um2 = 0.004 }", "Cauchy"),
        ("type = 'dielectric'\nindex = { file = 'k.csv' }", "Table"),
        ("type = 'oren-nayar'\nreflectance = 0.5\nroughness = 0.8", "OrenNayar"),
        ("type = 'plastic'\nreflectance = [1, 0, 0]", "Layered"),
        ("type = 'plastic'\nreflectance = 0.5\nglass = 'BK7'\nroughness = 0.2", "Sellmeier"),
        ("type = 'thin-dielectric'\nindex = 1.5\ntransmittance = { file = 'part.csv' }", "ThinDielectric"),
        ("type = 'translucent'\nreflectance = { file = 'part.csv' }\ntransmittance = 0.3", "Translucent"),
        (
            "type = 'translucent'\nreflectance = 'reflectances/leaf'\ntransmittance = 'reflectances/leaf-transmittance'",
            "Translucent",
        ),
        ("type = 'retroreflective'\nretroreflectance = 0.4\nreflectance = [1, 1, 0]\nindex = 1.5", "Retroreflective"),
        ("type = 'phong'\ndiffuse = 0.3\nspecular = 0.6\nexponent = 20", "Phong"),
        (
            "type = 'mix'\nweight = 0.25\nfirst = { type = 'diffuse', reflectance = 0.5 }\nsecond = { type = 'mix', weight = 0.5, first = { type = 'conductor', metal = 'Au' }, second = { type = 'dielectric', index = 1.5 } }",
            "weight: 0.25",
        ),
        (
            "type = 'metallic-roughness'\nbase_colour = { texture = 'a.png', tiles = [2, 3], wrap = 'clamp' }\nroughness = 0.5\nnormal_map = { texture = 'a.png' }\nmetallic_roughness_map = { texture = 'a.png' }",
            "Layered",
        ),
    ] {
        let files = Files::new(&room(&format!("[materials.wall]\n{table}")));
        files.add("k.csv", b"500,3.0\n600,3.5\n");
        files.add("part.csv", b"500,0.3\n600,0.7\n");
        files.add("nk.csv", b"wavelength_nm,n,k\n500,0.5,3.0\n600,0.6,3.5\n");
        files.add("a.png", png.get_ref());
        let capture = files.read(&[]).unwrap_or_else(|error| panic!("{error}"));
        let wall = material(&capture, "wall");
        assert!(format!("{:?}", wall.model).contains(check), "{table}");
        if let MaterialModel::Layered(layers) = &wall.model
            && let Some(texture) = &layers.base_colour.texture
        {
            assert_eq!(texture.sampler.wrap, [Wrap::ClampToEdge; 2]);
            assert_eq!(capture.scene.images.len(), 1, "an image is read once");
            let mesh = &capture.scene.meshes[0];
            assert_eq!(mesh.tangents.len(), mesh.positions.len(), "a normal map brings tangents");
        }
    }
}

#[test]
fn lights_stand_where_they_are_put() {
    let capture = capture(&room(
        r#"
        [[lights]]
        type = "point"
        position_m = [1, 2, 3]
        intensity_cd = 100
        rgb = [1, 1, 1]
        [[lights]]
        type = "spot"
        name = "lamp"
        position_m = [0, 2, 0]
        look_at_m = [0, 0, 0]
        intensity_cd = 50
        outer_angle_deg = 30
        illuminant = "A"
        [[lights]]
        type = "directional"
        direction = [1, -1, 0]
        illuminance_lux = 1e5
        "#,
    ));
    let [point, spot, sun] = &capture.scene.lights[..] else { panic!("{:?}", capture.scene.lights) };
    assert!(matches!(point.kind, LightKind::Point(_)));
    assert_eq!((point.to_world.translation, point.name.as_str()), (DVec3::new(1.0, 2.0, 3.0), "lights[0]"));
    assert_eq!((spot.name.as_str(), spot.emission.level), ("lamp", Some(50.0)));
    assert!((spot.to_world.matrix3.z_axis - DVec3::Y).length() < 1e-12, "a light shines along −Z");
    assert!(matches!(spot.kind, LightKind::Spot(spot) if spot == SpotLight::new(0.0, (PI / 6.0) as f32)));
    assert!((sun.to_world.matrix3.z_axis - DVec3::new(-1.0, 1.0, 0.0).normalize()).length() < 1e-12);
}

#[test]
fn an_image_dark_above_the_horizon_gives_no_illuminance() {
    let files =
        Files::new("[scene]\ngeometry = ['room.obj']\nenvironment = { image = 'sky.hdr', illuminance_lux = 9 }");
    let pixels = image::Rgb32FImage::from_fn(2, 2, |_, y| image::Rgb([y as f32; 3]));
    pixels.save(files.0.path().join("sky.hdr")).expect("written");
    let error = files.read(&[]).expect_err("no light from above").to_string();
    assert!(error.contains("scene.environment.illuminance_lux: cannot be reached"), "{error}");
}

#[test]
fn environments_are_constant_or_images() {
    let with = |environment: &str| {
        let files = Files::new(&format!("[scene]\ngeometry = ['room.obj']\nenvironment = {environment}"));
        let pixels = image::Rgb32FImage::from_pixel(2, 1, image::Rgb([1.0, 2.0, 4.0]));
        pixels.save(files.0.path().join("sky.hdr")).expect("written");
        files.read(&[]).unwrap_or_else(|error| panic!("{error}")).scene
    };
    let scene = with("{ image = 'sky.hdr', rotation_deg = 90, illuminance_lux = 1000 }");
    assert!(
        matches!(&scene.environment, Some(EnvironmentDescription::Image { level: ImageLevel::HorizontalLux(1000.0), rotation_deg: 90.0, image }) if image.width == 2)
    );
    let scene = with("{ illuminant = '3000K' }");
    assert!(
        matches!(&scene.environment, Some(EnvironmentDescription::Constant { luminance_nit: None, .. })),
        "a blackbody is absolute"
    );
    let scene = with("{ linear_rgb = [0.1, 0.2, 0.3], luminance_nit = 7 }");
    assert!(matches!(
        &scene.environment,
        Some(EnvironmentDescription::Constant { luminance_nit: Some(_), colour: Colour::Rgb(_) })
    ));
    let scene = with("\"none\"");
    assert!(scene.environment.is_none() && scene.warnings.iter().any(|w| w.contains("black")), "{:?}", scene.warnings);
}

#[test]
fn the_camera_and_its_lens_are_as_written() {
    let capture = capture(&room(
        r#"
        [camera]
        position_m = [0, 1, 3]
        look_at_m = [0, 1, 0]
        [lens]
        type = "pinhole"
        focal_length_mm = 25
        f_number = 1.4
        focus_distance_m = "infinity"
        blades = 6
        falloff = "none"
        transmittance = 0.9
        distortion = { model = "brown-conrady", k = [-0.1, 0, 0] }
        intrinsics = { fx = 1000, fy = 1001, cx = 399.5, cy = 299.5 }
        "#,
    ));
    assert_eq!(capture.camera_to_world.translation, DVec3::new(0.0, 1.0, 3.0));
    let lens = &capture.lens;
    assert_eq!(
        (lens.kind, lens.focal_length_m, lens.f_number, lens.focus),
        (LensKind::Pinhole, 0.025, 1.4, Focus::Infinity)
    );
    assert_eq!((lens.blades, lens.falloff, lens.transmittance.max()), (6, Falloff::None, 0.9));
    let distortion = BrownConrady { k: [-0.1, 0.0, 0.0, 0.0, 0.0, 0.0], ..BrownConrady::default() };
    assert_eq!(lens.projection, Projection::BrownConrady(distortion));
    let intrinsics = lens.intrinsics.expect("given");
    assert_eq!((intrinsics.cx, intrinsics.cy), (400.0, 300.0), "OpenCV counts from the centre of the first pixel");
}

#[test]
fn keys_without_effect_are_warned_of() {
    for (lens, key) in [
        ("type = 'pinhole'\nautofocus = { method = 'contrast' }", "lens.autofocus"),
        ("type = 'hole'\nfocus_distance_m = 2", "lens.focus_distance_m"),
        ("type = 'none'\nf_number = 2", "lens.f_number"),
        ("type = 'none'\nmin_focus_distance_m = 2", "lens.min_focus_distance_m"),
        ("focus_distance_m = 2\nautofocus = { method = 'contrast' }", "lens.autofocus"),
    ] {
        let warnings = capture(&room(&format!("[lens]\n{lens}"))).warnings();
        assert!(warnings.iter().any(|w| w.starts_with(&format!("{key} has no effect"))), "{lens}: {warnings:?}");
    }
}

#[test]
fn a_hole_that_says_nothing_is_as_sharp_as_holes_are() {
    let lens = capture(&room("[lens]\ntype = 'hole'\nimage_distance_mm = 100")).lens;
    // Its diameter is that of the first dark ring, 2.44·λ·v/D.
    let diameter = lens.focal_length_m / lens.f_number;
    assert!((diameter - 2.44 * 550e-9 * 0.1 / diameter).abs() < 1e-12, "{diameter}");
}

#[test]
fn focal_lengths_follow_from_a_field_of_view() {
    let gltf = serde_json::json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "camera": 0, "name": "eye", "translation": [0, 0, 2] }],
        "cameras": [{ "type": "perspective", "name": "wide", "perspective": { "yfov": 1.0, "znear": 0.1 } }],
    });
    let read = |lens: &str| {
        let files = Files::new(&format!(
            "[scene]\ngeometry = ['room.obj', 'camera.gltf']\n[camera]\ngltf_camera = 'wide'\n[lens]\n{lens}"
        ));
        files.add("camera.gltf", gltf.to_string().as_bytes());
        files.read(&[]).unwrap_or_else(|error| panic!("{error}"))
    };
    let capture = read("focus_distance_m = 0.5");
    assert_eq!(capture.camera_to_world.translation, DVec3::new(0.0, 0.0, 2.0));
    // v = uf/(u − f) must put half the sensor's height at tan(0.5).
    let (u, f) = (0.5, capture.lens.focal_length_m);
    let half_height = 600.0 * 6e-6 / 2.0;
    assert!((half_height / (u * f / (u - f)) - 0.5f64.tan()).abs() < 1e-9);
    assert!((half_height / read("focus_distance_m = 'infinity'").lens.focal_length_m - 0.5f64.tan()).abs() < 1e-9);
    assert_eq!(read("focal_length_mm = 8").lens.focal_length_m, 0.008);
}

#[test]
fn a_sensor_is_a_preset_or_a_file_with_changes() {
    let read = |sensor: &str| {
        let files = Files::new(&room(sensor));
        fs::create_dir(files.0.path().join("sensors")).expect("created");
        let text = include_str!("../../../photosite-sensor/assets/sensors/sony-imx249-mono.toml");
        let quantum_efficiency = "../../../photosite-core/assets/spectra/quantum-efficiency/sony-imx249-mono.csv";
        assert!(text.contains(quantum_efficiency));
        files.add("sensors/mine.toml", text.replace(quantum_efficiency, "qe.csv").as_bytes());
        files.add("sensors/qe.csv", b"400,0.25\n700,0.75\n");
        files.add("other.csv", b"400,0.5\n700,0.5\n");
        files.read(&[]).unwrap_or_else(|error| panic!("{error}")).sensor
    };
    let sensor =
        read("[sensor]\npreset = \"sony-imx249-color\"\nresolution_px = [64, 48]\nnoise = { read_noise_e = 0 }");
    assert_eq!(
        (sensor.name.as_str(), sensor.resolution, sensor.noise.read_out.at(Decibels(0.0)).read.0),
        ("sony-imx249-color", [64, 48], 0.0)
    );
    assert_eq!(sensor.full_well, presets::model("sony-imx249-color").expect("listed").full_well);
    let sensor = read("[sensor]\npreset = \"sensors/mine.toml\"");
    assert_eq!((sensor.name.as_str(), sensor.quantum_efficiency[0].eval(550.0)), ("mine", 0.5));
    let sensor = read(
        "[sensor]\npreset = \"sensors/mine.toml\"\n[sensor.channels.Y]\nquantum_efficiency = { file = \"other.csv\" }",
    );
    assert_eq!(sensor.quantum_efficiency[0].eval(690.0), 0.5);
    // Another kind of shutter or counter leaves nothing of the preset's behind.
    let sensor = read("[sensor]\npreset = \"sony-imx363-color\"\nshutter = { kind = \"global\" }");
    assert_eq!(sensor.shutter.row_time().0, 0.0);
    let sensor = read("[sensor]\npreset = \"sony-imx363-color\"\nshutter = { row_time_us = 7.5 }");
    assert_eq!(sensor.shutter.row_time().0, 7.5e-6);
    let free_running = "spad = { counting = \"free-running\", dead_time_ns = 100 }";
    let sensor = read(&format!("[sensor]\npreset = \"swissspad2\"\n{free_running}"));
    let counting = sensor.architecture.spad().expect("a counter").counting;
    // Two roundings of 100 · 10⁻⁹.
    assert!(matches!(counting, Counting::FreeRunning { dead_time } if (dead_time.0 - 1e-7).abs() < 1e-22));
}

#[test]
fn settings_are_as_written() {
    let capture = capture(&room(
        r#"
        [exposure]
        time_s = 0.02
        gain_db = 6
        temperature_c = 40
        frames = 3
        [render]
        samples_per_pixel = 128
        time_limit_s = 1.5
        noise_target = 0.2
        max_depth = 5
        roulette_depth = 3
        splitting = 4
        wavelengths = "own-filter"
        sampler = "independent"
        seed = 18446744073709551615
        [output]
        raw = ["dng", "tiff", "pgm", "npy", "exr"]
        irradiance = { bands_nm = [400, 720, 20] }
        electrons = false
        preview_interval_s = 0
        checkpoint_interval_s = 0
        "#,
    ));
    let exposure = capture.exposure;
    assert_eq!((exposure.time, exposure.gain), (ExposureTime::Fixed(Seconds(0.02)), Decibels(6.0)));
    assert_eq!((exposure.temperature, exposure.frames), (Celsius(40.0), 3));
    let render = capture.render;
    assert_eq!((render.samples_per_pixel, render.max_depth, render.roulette_depth, render.seed), (128, 5, 3, u64::MAX));
    assert_eq!((render.splitting, render.wavelengths), (Some(4), WavelengthChoice::OwnFilter));
    assert_eq!((render.noise_target, render.sampler), (Some(0.2), SamplerKind::Independent));
    assert_eq!(render.time_limit(), Some(std::time::Duration::from_millis(1500)));
    let output = capture.output;
    assert_eq!(output.raw, [RawFormat::Dng, RawFormat::Tiff, RawFormat::Pgm, RawFormat::Npy, RawFormat::Exr]);
    assert!(!output.electrons && output.preview_interval.is_none() && output.checkpoint_interval.is_none());
    let bands = output.irradiance.expect("asked for");
    assert_eq!(
        (bands.count, bands.edges_nm(0), bands.edges_nm(15), bands.centre_nm(1)),
        (16, [400.0, 420.0], [700.0, 720.0], 430.0)
    );
}

#[test]
fn arguments_come_before_the_file() {
    let files = Files::new(&room(
        "[lens]\nf_number = 8\nfocal_length_mm = 12\n[[lights]]\ntype = 'point'\nposition_m = [0, 0, 0]\nintensity_cd = 1\n",
    ));
    let capture = files
        .read(&[
            "lens.f_number=4",
            "render.seed = 7",
            "sensor.preset=sony-imx249-mono",
            "sensor.adc.bits=10",
            "lights.0.intensity_cd=9",
            "scene.environment=none",
            "materials.wall={ type = \"diffuse\", reflectance = 0.25 }",
        ])
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((capture.lens.f_number, capture.lens.focal_length_m, capture.render.seed), (4.0, 0.012, 7));
    assert_eq!((capture.sensor.name.as_str(), capture.sensor.converter.bits), ("sony-imx249-mono", 10));
    assert_eq!(capture.scene.lights[0].emission.level, Some(9.0));
    assert!(capture.scene.environment.is_none());
    let MaterialModel::Diffuse(Diffuse { reflectance }) = &material(&capture, "wall").model else {
        panic!("not diffuse")
    };
    assert!(matches!(reflectance.colour, Colour::Spectrum(_)));
}

#[test]
fn a_variant_that_no_file_has_is_refused() {
    let files = Files::new(&room(""));
    let error = files.read(&["scene.variant=winter"]).expect_err("no glTF there").to_string();
    assert!(error.contains("scene.variant") && error.contains("no material variant \"winter\""), "{error}");
}

#[test]
fn a_scene_file_alone_is_a_capture() {
    let files = Files::new("");
    let path = files.0.path().join("room.obj");
    let capture =
        Capture::load_with(&path, &["render.samples_per_pixel=2".to_owned()]).unwrap_or_else(|error| panic!("{error}"));
    assert!(matches!(&capture.scene.environment, Some(EnvironmentDescription::Sky(sky)) if sky.has_sun));
    assert_eq!(capture.scene.surroundings.len(), 1);
    assert_eq!(capture.render.samples_per_pixel, 2);
    // The middle of the square is on the axis, at the distance that is focused on.
    let Focus::Distance(u) = capture.lens.focus else { panic!("{:?}", capture.lens.focus) };
    let centre = capture.camera_to_world.inverse().transform_point3(DVec3::new(0.5, 0.5, 0.0));
    // Places have five decimals.
    assert!((centre - DVec3::new(0.0, 0.0, -u)).length() < 2e-5, "{centre} {u}");
    let error = Capture::load_with(&path, &["lens.f_number=0".to_owned()]).expect_err("no lens").to_string();
    assert!(error.starts_with("override lens.f_number=0: lens.f_number: must be above 0"), "{error}");
}

#[test]
fn spheres_stand_among_the_geometry_with_materials_of_either() {
    let spheres = "
        [[scene.spheres]]
        material = 'wall'
        position_m = [1, 2, 3]
        radius_m = 0.5
        [[scene.spheres]]
        name = 'lens'
        material = 'glass'
        position_m = [0, 0, -1]
        radius_m = 0.25
        [materials.glass]
        type = 'dielectric'
        index = 1.5";
    let capture = capture(&room(spheres));
    let scene = &capture.scene;
    let found = scene.instances.iter().filter(|i| scene.meshes[i.meshes.start].quadric.is_some()).map(|i| {
        let material = &scene.materials[scene.meshes[i.meshes.start].material].name;
        let centre = i.to_world.translation.to_array();
        (i.name.as_str(), material.as_str(), centre, i.to_world.transform_vector3(DVec3::X).length())
    });
    let expected = [("sphere-0", "wall", [1.0, 2.0, 3.0], 0.5), ("lens", "glass", [0.0, 0.0, -1.0], 0.25)];
    assert_eq!(found.collect::<Vec<_>>(), expected);
    assert_eq!(scene.materials.iter().filter(|material| material.name == "wall").count(), 1);
}

#[test]
fn disks_and_cylinders_stand_with_their_axes_where_they_are_put() {
    let shapes = "
        [[scene.disks]]
        material = 'wall'
        position_m = [1, 2, 3]
        normal = [0, 5, 0]
        radius_m = 0.5
        [[scene.cylinders]]
        name = 'pipe'
        material = 'wall'
        position_m = [0, 0, -1]
        axis = [-2, 0, 0]
        radius_m = 0.25
        length_m = 3";
    let capture = capture(&room(shapes));
    let scene = &capture.scene;
    let found: Vec<_> = scene
        .instances
        .iter()
        .filter_map(|i| Some((i.name.as_str(), scene.meshes[i.meshes.start].quadric?, i.to_world)))
        .collect();
    let [("disk-0", QuadricKind::Disk, disk), ("pipe", QuadricKind::Cylinder, pipe)] = found[..] else {
        panic!("{found:?}")
    };
    let is_near = |to_world: DAffine3, unit: DVec3, world: DVec3| {
        let found = to_world.transform_point3(unit);
        assert!((found - world).length() < 1e-12, "{found} {world}");
    };
    is_near(disk, DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
    assert!((disk.matrix3.x_axis.cross(disk.matrix3.y_axis) - 0.25 * DVec3::Y).length() < 1e-12);
    is_near(pipe, DVec3::ZERO, DVec3::new(1.5, 0.0, -1.0));
    is_near(pipe, DVec3::Z, DVec3::new(-1.5, 0.0, -1.0));
    assert!((pipe.matrix3.x_axis.length() - 0.25).abs() < 1e-12);
}

/// Case: seen from +x with +y up, −z is to the right.
#[rstest]
#[case::default("", [DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z])]
#[case::turned("look_at_m = [7, 2, 3]", [DVec3::NEG_Z, DVec3::NEG_Y, DVec3::NEG_X])]
#[case::lying("look_at_m = [1, 9, 3]\nup = [1, 0, 0]", [DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y])]
fn targets_face_what_they_look_at(#[case] keys: &str, #[case] axes: [DVec3; 3]) {
    let capture = capture(&room(&format!("[[targets]]\ntype = 'circle-grid'\nposition_m = [1, 2, 3]\n{keys}")));
    let placed = &capture.targets[0];
    let [x, y, z] = axes;
    let matrix = placed.to_world.matrix3;
    assert!((matrix.x_axis - x).length() + (matrix.y_axis - y).length() + (matrix.z_axis - z).length() < 1e-12);
    // 9 by 7 circles, 20 mm apart: the middle of the sheet is the one in the middle.
    let (_, middle) = placed.points().nth(3 * 9 + 4).expect("63 circles");
    assert!((middle - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-12, "{middle}");
    let materials: Vec<_> = capture.scene.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(materials[materials.len() - 2..], ["circle-grid-white", "circle-grid-black"]);
}
