//! Lights without a surface, and the environment.

use glam::{DAffine3, DVec3};

use super::bitmaps;
use super::difference::Difference;
use super::element::Element;
use super::output::{Output, quoted};
use super::sensor::rows;
use photosite_core::spectrum::{Spectrum, SpectrumTable};
use photosite_transport::light::{Sky, SkyConditions};
use photosite_transport::scene::description::{EnvironmentDescription, LightDescription, LightKind, SceneDescription};
use photosite_transport::scene::{emission_spectrum, nit_per_unit};

/// Integral of the observer's V(λ) by which Mitsuba brings D65 to a luminance of 1 (its CIE_Y_NORMALIZATION, CIE 1931),
/// times the luminous efficacy: an RGB colour of 1 is this many nit.
const NIT_OF_MITSUBA_WHITE: f64 = 106.856895 * 683.0;

/// Narrowest edge of a spot light, rad; a narrower one is as good as hard.
const HARD_EDGE_RAD: f32 = 1e-3;

/// Radius of the disk that stands for the ground of a sky, over its depth below all else: it ends 10 µrad below the
/// horizon.
const GROUND_RADIUS: f64 = 1e5;

/// Elements of all lights of a scene with a camera there.
pub(super) fn lights(scene: &SceneDescription, camera: DVec3, out: &mut Output) -> Vec<Element> {
    let mut elements: Vec<_> = scene.lights.iter().filter_map(|l| light(l, out)).collect();
    elements.extend(scene.environment.as_ref().map(|e| environment(e, out)));
    if let Some(EnvironmentDescription::Sky(conditions)) = &scene.environment {
        let (_, light) = Sky::new(conditions, &mut SpectrumTable::default());
        if light.ground.max() > 0.0 {
            elements.push(ground(&light.ground, scene, camera));
        }
    }
    elements
}

/// Ground of a sky, which is black below the horizon in Mitsuba: a disk that emits and reflects nothing, far below and
/// far wider.
fn ground(radiance: &Spectrum, scene: &SceneDescription, camera: DVec3) -> Element {
    let (low, high) = scene.subject_bounds().unwrap_or((camera, camera));
    let (low, high) = (low.min(camera), high.max(camera));
    let lowest = scene.instances.iter().flat_map(|instance| {
        let positions = scene.meshes[instance.meshes.clone()].iter().flat_map(|mesh| &mesh.positions);
        positions.map(|p| instance.to_world.transform_point3(p.as_dvec3()).y)
    });
    let depth = low.distance(high).max(1.0);
    let centre = DVec3 { y: lowest.fold(low.y, f64::min) - depth, ..(low + high) / 2.0 };
    // Mitsuba's disk faces +z.
    let turned = DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    let to_world =
        DAffine3::from_translation(centre) * turned * DAffine3::from_scale(DVec3::splat(GROUND_RADIUS * depth));
    Element::object("shape", "disk")
        .transform("to_world", rows(to_world))
        .child(Element::object("bsdf", "diffuse").spectrum("reflectance", &Spectrum::constant(0.0)))
        .child(Element::object("emitter", "area").spectrum("radiance", radiance))
}

fn light(light: &LightDescription, out: &mut Output) -> Option<Element> {
    // Motion is told of the capture as a whole.
    let LightDescription { name, to_world, later: _, kind, emission } = light;
    let spectrum = emission_spectrum(&emission.colour, emission.level);
    Some(match kind {
        LightKind::Point(_) => {
            let [x, y, z] = to_world.translation.to_array();
            let position =
                Element::new("point").named("position").attribute("x", x).attribute("y", y).attribute("z", z);
            Element::object("emitter", "point").child(position).spectrum("intensity", &spectrum)
        }
        LightKind::Spot(spot) => {
            let (inner_rad, outer_rad) = (spot.inner_rad(), spot.outer_rad());
            if outer_rad - inner_rad > HARD_EDGE_RAD {
                out.approximate(Difference::SoftEdge { light: quoted("light", name) });
            }
            // Mitsuba's spot lights shine along +z.
            let turned = *to_world * DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0));
            Element::object("emitter", "spot")
                .transform("to_world", rows(turned))
                .spectrum("intensity", &spectrum)
                .float("cutoff_angle", f64::from(outer_rad).to_degrees())
                .float("beam_width", f64::from(inner_rad).to_degrees())
        }
        LightKind::Directional(_) => {
            let [x, y, z] = to_world.transform_vector3(DVec3::NEG_Z).to_array();
            let direction =
                Element::new("vector").named("direction").attribute("x", x).attribute("y", y).attribute("z", z);
            Element::object("emitter", "directional").child(direction).spectrum("irradiance", &spectrum)
        }
        LightKind::Profile(_) | LightKind::Projector(_) | LightKind::GaussianBeam(_) => {
            out.approximate(Difference::KindOfLight { light: quoted("light", name), kind: kind.name() });
            return None;
        }
    })
}

fn environment(environment: &EnvironmentDescription, out: &mut Output) -> Element {
    match environment {
        EnvironmentDescription::Constant { colour, luminance_nit } => {
            Element::object("emitter", "constant").spectrum("radiance", &emission_spectrum(colour, *luminance_nit))
        }
        EnvironmentDescription::Sky(SkyConditions { towards_sun, turbidity, ground_albedo, has_sun }) => {
            if out.sees_beyond_cie {
                out.approximate(Difference::SkyBeyondItsTables);
            }
            let [x, y, z] = towards_sun.to_array();
            // In world space, whereas up is +z in the emitter's own.
            let direction =
                Element::new("vector").named("sun_direction").attribute("x", x).attribute("y", y).attribute("z", z);
            let turned = DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
            Element::object("emitter", "sunsky")
                .child(direction)
                .float("turbidity", *turbidity)
                .float("albedo", *ground_albedo)
                .float("sun_scale", f64::from(u8::from(*has_sun)))
                .transform("to_world", rows(turned))
        }
        EnvironmentDescription::Image { image, level, rotation_deg } => {
            if out.sees_beyond_cie {
                out.approximate(Difference::ImageBeyondCie);
            }
            let coloured = !bitmaps::is_of_one_colour(image);
            if coloured {
                out.approximate(Difference::ImageColours);
            }
            // Its centre looks along +z in Mitsuba.
            let turned = DAffine3::from_rotation_y((rotation_deg + 180.0).to_radians());
            Element::object("emitter", "envmap")
                .string("filename", out.exr("textures/environment.exr".to_owned(), &bitmaps::panorama(image, coloured)))
                .float("scale", nit_per_unit(image, *level) / NIT_OF_MITSUBA_WHITE)
                .transform("to_world", rows(turned))
        }
    }
}
