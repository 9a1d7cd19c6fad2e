//! Positions of things: cameras, lights, instances, skins, morph targets, animations.

use super::*;

#[test]
fn cameras_and_lights_stand_where_their_nodes_are() {
    let mut fixture = Fixture::square();
    fixture.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    fixture.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "intensity": 40.0, "color": [1.0, 0.9, 0.8], "spot": { "outerConeAngle": 0.6 } },
        { "type": "directional", "name": "sun", "intensity": 1000.0 },
    ]}});
    fixture.json["nodes"] = json!([
        { "name": "rig", "scale": [2, 2, 2], "translation": [0, 1, 0], "children": [1, 2, 3] },
        { "name": "eye", "camera": 0, "translation": [0, 0, 3] },
        { "name": "lamp", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "extensions": { "KHR_lights_punctual": { "light": 1 } } },
    ]);
    let scene = fixture.scene();
    let camera = &scene.cameras[0];
    assert_eq!((camera.name.as_str(), camera.vertical_fov_rad), ("eye", 0.5));
    assert_eq!(camera.to_world.translation, DVec3::new(0.0, 1.0, 6.0));
    assert_eq!(camera.to_world.matrix3.determinant(), 1.0, "the scale of the parent is left out");
    assert!(matches!(scene.lights[0].kind, LightKind::Spot(spot) if spot == SpotLight::new(0.0, 0.6)));
    assert_eq!((scene.lights[0].name.as_str(), scene.lights[0].emission.level), ("lamp", Some(40.0)));
    assert_eq!(scene.lights[1].name, "sun");
    assert!(matches!(scene.lights[1].kind, LightKind::Directional(_)));
}

#[test]
fn morph_targets_move_vertices_by_their_weights() {
    let morphed = || {
        let mut fixture = Fixture::square();
        let up = fixture.floats("VEC3", &[0., 0., 1.].repeat(4));
        let right = fixture.floats("VEC3", &[2., 0., 0.].repeat(4));
        fixture.primitive()["targets"] = json!([{ "POSITION": up }, { "POSITION": right }]);
        fixture
    };
    let first = |fixture: Fixture| fixture.scene().meshes[0].positions[0];
    assert_eq!(first(morphed()), Vec3::ZERO);
    assert_eq!(first(morphed().with("/meshes/0/weights", json!([0.5, 0.25]))), Vec3::new(0.5, 0.0, 0.5));
    let by_node = morphed().with("/meshes/0/weights", json!([0.5, 0.25])).with("/nodes/0/weights", json!([0, 1]));
    assert_eq!(first(by_node), Vec3::new(2.0, 0.0, 0.0));
    let mut torn = morphed().with("/meshes/0/weights", json!([1, 1]));
    let short = torn.floats("VEC3", &[0.0; 9]);
    torn.primitive()["targets"][1]["POSITION"] = json!(short);
    assert!(torn.error().contains("targets[1].POSITION: has 3 entries for 4 vertices"));
}

#[test]
fn skinned_vertices_follow_their_joints() {
    let mut fixture = Fixture::square();
    let joints = fixture.accessor("VEC4", 5121, 4, &[[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]].concat());
    let weights =
        fixture.floats("VEC4", &[[1., 0., 0., 0.], [1., 0., 0., 0.], [0.5, 0.5, 0., 0.], [0., 0., 0., 0.]].concat());
    // The second joint was bound one unit along x, and stands three along x now: it moves what follows it by two.
    let unmoved = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
    let mut bound = unmoved;
    bound[12] = -1.0;
    let binds = fixture.floats("MAT4", &[unmoved, bound].concat());
    fixture.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    fixture.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    fixture.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [50, 0, 0] }, {}, { "translation": [3, 0, 0] }
    ]);
    fixture.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    fixture.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": binds }]);
    let text = fixture.text();
    let file = read_bytes(text.as_bytes(), Path::new("scene.gltf"), Choice::default()).expect("valid");
    let [x, y] = [Vec3::X, Vec3::Y];
    assert_eq!(file.scene.meshes[0].positions, [Vec3::ZERO, x * 3.0, x * 2.0 + y, y]);
    assert_eq!(file.scene.instances[0].to_world, DAffine3::IDENTITY);
    let error = |from: &str, to: &str| {
        let damaged = text.replace(from, to);
        assert_ne!(damaged, text);
        read_bytes(damaged.as_bytes(), Path::new("scene.gltf"), Choice::default()).expect_err("damaged").to_string()
    };
    assert!(error("\"skin\": 0", "\"skin\": 4").contains("refers to skins[4]"));
    let compact = text.split_whitespace().collect::<String>();
    let fewer = compact.replace("\"joints\":[1,2]", "\"joints\":[1]");
    let error =
        read_bytes(fewer.as_bytes(), Path::new("scene.gltf"), Choice::default()).expect_err("damaged").to_string();
    assert!(error.contains("vertex 1 follows joint 1 of 1"), "{error}");
}

/// A square that goes 2 m along x in 2 s and then turns by 90° about y in 1 s, with a camera and a light on it, and a
/// morph target that comes in the same time.
fn animated() -> Fixture {
    let mut f = Fixture::square();
    let times = f.floats("SCALAR", &[0.0, 2.0]);
    let way = f.floats("VEC3", &[0., 0., 0., 2., 0., 0.]);
    let turning = f.floats("SCALAR", &[2.0, 3.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turn = f.floats("VEC4", &[0., 0., 0., 1., 0., half, 0., half]);
    let weights = f.floats("SCALAR", &[0.0, 1.0]);
    let raised = f.floats("VEC3", &[0., 0., 1.].repeat(4));
    f.primitive()["targets"] = json!([{ "POSITION": raised }]);
    let sampler = |input: usize, output: usize| json!({ "input": input, "output": output });
    let channel = |sampler: usize, path: &str| json!({ "sampler": sampler, "target": { "node": 0, "path": path } });
    f.with(
        "/animations",
        json!([{ "name": "go", "samplers": [sampler(times, way), sampler(turning, turn), sampler(times, weights)],
            "channels": [channel(0, "translation"), channel(1, "rotation"), channel(2, "weights")] }]),
    )
    .with("/nodes", json!([{ "name": "node", "mesh": 0, "children": [1] }, { "camera": 0, "translation": [0, 0, 1] }]))
    .with("/cameras", json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]))
}

fn at_moment(fixture: Fixture, start_s: f64, duration_s: f64) -> Result<SceneDescription> {
    let moment = Moment { animation: "go".into(), start_s, duration_s };
    let choice = Choice { moment: Some(&moment), ..Choice::default() };
    read_bytes(fixture.text().as_bytes(), Path::new("scene.gltf"), choice).map(|file| file.scene)
}

#[test]
fn animations_are_evaluated_over_the_time_of_an_image() {
    // On a straight way two times are enough, at 0.5 m and 1.5 m; the morph target is there by a quarter, then three.
    let scene = at_moment(animated(), 0.5, 1.0).expect("valid");
    let (instance, mesh) = (&scene.instances[0], &scene.meshes[0]);
    assert_eq!((instance.to_world.translation, instance.later.len()), (DVec3::X * 0.5, 1));
    assert_eq!(instance.later[0].translation, DVec3::X * 1.5);
    assert_eq!((mesh.positions[2].z, mesh.later_shapes.len(), mesh.later_shapes[0].positions[2].z), (0.25, 1, 0.75));
    assert_eq!(scene.cameras[0].later[0].translation, DVec3::new(1.5, 0.0, 1.0));
    // A quarter turn is cut into parts of less than 5.2°, the angle of which the arc is 0.1 % off its chord: 32, of
    // 2.8°.
    let scene = at_moment(animated(), 2.0, 1.0).expect("valid");
    let places = &scene.instances[0].later;
    assert_eq!(places.len(), 32);
    assert!(places[31].abs_diff_eq(
        DAffine3::from_translation(DVec3::X * 2.0) * DAffine3::from_rotation_y(std::f64::consts::FRAC_PI_2),
        1e-6
    ));
    // The weight has come to its end and stays.
    assert!(scene.meshes[0].later_shapes.is_empty() && scene.meshes[0].positions[2].z == 1.0);
    // Of an animation that the file lacks, and in no time, there is one place.
    let still = at_moment(animated(), 1.0, 0.0).expect("valid");
    assert_eq!((still.instances[0].to_world.translation, still.instances[0].later.len()), (DVec3::X, 0));
    assert_eq!(animated().scene().instances[0].to_world, DAffine3::IDENTITY);
}

#[rstest]
#[case::sampler("/animations/0/channels/0/sampler", json!(9), "animations[0].channels[0].sampler")]
#[case::node("/animations/0/channels/0/target/node", json!(9), "animations[0].channels[0].target.node")]
#[case::input("/animations/0/samplers/0/input", json!(99), "animations[0].samplers[0].input")]
#[case::still_times("/animations/0/samplers/0/input", json!(1), "needs SCALAR")]
#[case::count("/animations/0/samplers/0/output", json!(0), "holds 12 numbers for 2 times")]
#[case::interpolation("/animations/0/samplers/0/interpolation", json!("SPLINE"), "write LINEAR, STEP or CUBICSPLINE")]
#[case::matrix("/nodes/0/matrix", json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "has a matrix")]
fn damaged_animations_are_refused(#[case] pointer: &str, #[case] value: Value, #[case] message: &str) {
    let error = at_moment(animated().with(pointer, value), 0.0, 1.0).expect_err("refused");
    let text = format!("{error} {:?}", error);
    assert!(text.contains(message), "{text}");
}

/// A way of a channel of `animated` by KHR_animation_pointer.
fn pointer_target(pointer: &str) -> Value {
    json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } })
}

#[test]
fn pointers_to_nodes_move_them_and_others_are_named() {
    let target = "/animations/0/channels/0/target";
    let expected = at_moment(animated(), 0.5, 1.0).expect("valid").instances[0].clone();
    let by_pointer = || animated().with(target, pointer_target("/nodes/0/translation"));
    for required in [json!([]), json!(["KHR_animation_pointer"])] {
        let scene = at_moment(by_pointer().with("/extensionsRequired", required), 0.5, 1.0).expect("valid");
        assert_eq!((scene.instances[0].to_world, &scene.instances[0].later), (expected.to_world, &expected.later));
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    }
    // A node that some programs name beside the pointer says nothing.
    let beside = by_pointer()
        .with(&format!("{target}/node"), json!(1))
        .with("/extensionsUsed", json!(["KHR_animation_pointer"]));
    assert_eq!(at_moment(beside, 0.5, 1.0).expect("valid").instances[0].to_world, expected.to_world);

    for pointer in [
        "/materials/0/pbrMetallicRoughness/baseColorFactor",
        "/nodes/0/extensions/KHR_node_visibility/visible",
        "/nodes/0/translation/0",
        "/nodes/x/translation",
        "nodes/0/translation",
    ] {
        let fixture = || animated().with(target, pointer_target(pointer));
        let scene = at_moment(fixture(), 0.5, 1.0).expect("read");
        assert_eq!(scene.instances[0].to_world, DAffine3::IDENTITY);
        assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
        assert!(scene.warnings[0].contains("animations[0].channels[0]") && scene.warnings[0].contains(pointer));
        let error = fixture().with("/extensionsRequired", json!(["KHR_animation_pointer"])).error();
        assert!(error.contains("animations[0].channels[0].target: moves") && error.contains(pointer), "{error}");
    }
    let error = at_moment(animated().with(target, pointer_target("/nodes/9/translation")), 0.0, 1.0).expect_err("none");
    assert!(error.to_string().contains("refers to nodes[9]"), "{error}");
}

#[test]
fn channels_without_a_node_are_left_out_with_one_warning() {
    let mut fixture = animated();
    for channel in fixture.json["animations"][0]["channels"].as_array_mut().expect("channels") {
        channel["target"].as_object_mut().expect("a target").shift_remove("node");
    }
    let scene = at_moment(fixture, 0.5, 1.0).expect("read");
    let instance = &scene.instances[0];
    assert!(instance.later.iter().all(|place| *place == instance.to_world), "{:?}", instance.later);
    let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
    assert!(warning.contains("animations[0].channels[0] has no node") && warning.contains("2 more"), "{warning}");
    // An error behind what was filled in is told.
    let mut fixture = animated().with("/scenes", json!([{}, { "nodes": [0] }])).with("/nodes/0/mesh", json!("x"));
    fixture.json["scene"] = json!(1);
    assert!(fixture.error().contains("invalid type: string \"x\""));
}

#[test]
fn hidden_nodes_hide_what_is_below_them_but_cameras() {
    let hidden = |visible: Value| json!({ "KHR_node_visibility": { "visible": visible } });
    let lamp = json!({ "KHR_lights_punctual": { "light": 0 }, "KHR_node_visibility": { "visible": true } });
    let scene = |top: Value| {
        animated()
            .with("/extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } }))
            .with("/extensionsRequired", json!(["KHR_node_visibility", "KHR_lights_punctual"]))
            .with(
                "/nodes",
                json!([{ "children": [1, 2], "extensions": top }, { "mesh": 0, "extensions": lamp }, { "camera": 0 }]),
            )
            .read()
    };
    for (top, there) in [(hidden(json!(true)), 1), (hidden(json!(false)), 0), (json!({ "KHR_node_visibility": {} }), 1)]
    {
        let scene = scene(top.clone()).expect("valid");
        assert_eq!((scene.instances.len(), scene.lights.len(), scene.cameras.len()), (there, there, 1), "{top}");
    }
    let error = scene(hidden(json!("no"))).expect_err("refused").to_string();
    assert!(error.contains("nodes[0].extensions.KHR_node_visibility.visible: must be true or false"), "{error}");
}

#[test]
fn instances_stand_where_the_accessors_say() {
    let mut fixture = Fixture::square();
    let translations = fixture.floats("VEC3", &[0., 0., 0., 5., 0., 0.]);
    let scales = fixture.floats("VEC3", &[1., 1., 1., 2., 2., 2.]);
    fixture.json["nodes"][0]["translation"] = json!([0, 1, 0]);
    let attributes = json!({ "attributes": { "TRANSLATION": translations, "SCALE": scales, "_ID": 0 } });
    fixture.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": attributes });
    let scene = fixture.scene();
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 2));
    let corner = scene.instances[1].to_world.transform_point3(DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(corner, DVec3::new(7.0, 3.0, 0.0));
}
