//! Coverage of the sensor's wavelengths by the spectra of a scene.
//!
//! In: a scene as read, what the sensor makes of each wavelength. Out: a warning that names what is assumed there, or
//! nothing. The assumptions themselves are made where spectra are: [`Outside`](photosite_core::spectrum::Outside),
//! [`upsampling`](photosite_core::spectrum::upsampling), [`illuminant`](photosite_core::spectrum::illuminant).

use std::collections::HashSet;

use super::description::{
    Colour, EmissionDescription, EnvironmentDescription, LayeredDescription, MaterialModel, SceneDescription,
    TexturedColour, Visit,
};
use crate::light::Sky;
use photosite_core::spectrum::Spectrum;
use photosite_core::spectrum::upsampling::RANGE_NM;

/// The part of a channel's response that may lie where a spectrum is not known without a word.
const NEGLIGIBLE: f64 = 0.01;
/// Names that a message lists before it counts the others.
const NAMED: usize = 5;

/// Wavelengths between which something is known, nm.
type Range = [f32; 2];

/// A warning where a channel gets more than a hundredth of its response from wavelengths at which the spectrum of a
/// light or of a material is not known. `responses` in any unit, the transmittance of the lens included.
pub fn warning(scene: &SceneDescription, responses: &[Spectrum]) -> Option<String> {
    let unknown = |known: Range| responses.iter().map(|response| part_outside(response, known)).fold(0.0, f64::max);
    let assumed: Vec<(String, Range, f64)> = known_ranges(scene)
        .into_iter()
        .map(|(name, known)| (name, known, unknown(known)))
        .filter(|(_, _, part)| *part > NEGLIGIBLE)
        .collect();
    let (_, [first, last], part) = assumed.iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
    let mut names: Vec<&str> = assumed.iter().take(NAMED).map(|(name, ..)| name.as_str()).collect();
    let others = format!("{} more", assumed.len().saturating_sub(NAMED));
    if assumed.len() > NAMED {
        names.push(&others);
    }
    Some(format!(
        "up to {:.0} % of the sensor's response lies where spectra of the scene are not known ({}; known names are {first:.0} to \
         {last:.0} nm at least): there reflectances keep their value at the nearer end, daylight goes on as a blackbody, and \
         other lights are dark; give measured spectra that reach further, or put a filter in front of the sensor (sensor.filter)",
        100.0 * part,
        names.join(", "),
    ))
}

/// The part of a response that lies outside a range.
fn part_outside(response: &Spectrum, [first, last]: Range) -> f64 {
    let all = response.integral();
    let known = response.map(|lambda, value| {
        let is_known = (f64::from(first)..=f64::from(last)).contains(&lambda);
        if is_known { value } else { 0.0 }
    });
    if all > 0.0 { 1.0 - known.integral() / all } else { 0.0 }
}

/// Known ranges of all spectra of a scene, each with a name for messages.
fn known_ranges(scene: &SceneDescription) -> Vec<(String, Range)> {
    let mut all = Vec::new();
    match &scene.environment {
        Some(EnvironmentDescription::Constant { colour, .. }) => {
            all.push(("environment".to_owned(), of_colour(colour)))
        }
        Some(EnvironmentDescription::Image { .. }) => all.push(("environment".to_owned(), RANGE_NM)),
        Some(EnvironmentDescription::Sky(_)) => all.push(("sky".to_owned(), Sky::KNOWN_NM)),
        None => {}
    }
    all.extend(scene.lights.iter().map(|light| (format!("light \"{}\"", light.name), of_emission(&light.emission))));
    let used: HashSet<usize> = scene.meshes.iter().map(|mesh| mesh.material).collect();
    for (_, material) in scene.materials.iter().enumerate().filter(|(index, _)| used.contains(index)) {
        let light = material.emission.as_ref().map(of_emission);
        let known = light.into_iter().fold(of_model(&material.model), both);
        all.push((format!("material \"{}\"", material.name), known));
    }
    all
}

/// Range in which both are known.
fn both([a, b]: Range, [c, d]: Range) -> Range {
    [a.max(c), b.min(d)]
}

fn of_colour(colour: &Colour) -> Range {
    match colour {
        Colour::Rgb(_) => RANGE_NM,
        Colour::Spectrum(spectrum) => spectrum.known_nm(),
    }
}

fn of_textured(colour: &TexturedColour) -> Range {
    if colour.texture.is_some() { RANGE_NM } else { of_colour(&colour.colour) }
}

fn of_emission(emission: &EmissionDescription) -> Range {
    if emission.texture.is_some() { RANGE_NM } else { of_colour(&emission.colour) }
}

fn of_model(model: &MaterialModel) -> Range {
    let mut known = Known(None);
    model.visit(&mut known);
    known.0.unwrap_or(Spectrum::EVERYWHERE_NM)
}

/// Range in which all spectra of a model are known. Formulas of glasses hold as far as silicon sees, so that indices do
/// not count.
struct Known(Option<Range>);

impl Known {
    fn limit(&mut self, range: Range) {
        self.0 = Some(self.0.map_or(range, |known| both(known, range)));
    }
}

impl Visit for Known {
    fn colour(&mut self, colour: &TexturedColour) {
        self.limit(of_textured(colour));
    }

    fn spectrum(&mut self, spectrum: &Spectrum) {
        self.limit(spectrum.known_nm());
    }

    fn layered(&mut self, layers: &LayeredDescription) {
        self.limit(of_layers(layers));
    }
}

/// The colour of the base is always there; those of the other layers where files state them.
fn of_layers(layers: &LayeredDescription) -> Range {
    let LayeredDescription { base_colour, absorption_per_m, diffuse_transmission, sheen, .. } = layers;
    let absorption = absorption_per_m.as_ref().map(Spectrum::known_nm);
    let colours = [diffuse_transmission.as_ref().map(|(_, colour)| colour), sheen.as_ref().map(|(colour, _)| colour)];
    let stated = colours.into_iter().flatten().map(of_textured).chain(absorption);
    stated.fold(of_textured(base_colour), both)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::{Diffuse, MaterialDescription, MeshDescription};
    use photosite_core::spectrum::{Outside, illuminant};

    fn scene(light: &str, reflectance: Colour) -> SceneDescription {
        let model = MaterialModel::Diffuse(Diffuse { reflectance: TexturedColour::plain(reflectance) });
        let colour = Colour::Spectrum(illuminant::illuminant(light).expect("known"));
        SceneDescription {
            materials: vec![MaterialDescription::new("wall", model)],
            meshes: vec![MeshDescription::default().into()],
            environment: Some(EnvironmentDescription::Constant { colour, luminance_nit: Some(1.0) }),
            ..SceneDescription::default()
        }
    }

    fn band(first: f64, last: f64) -> Spectrum {
        Spectrum::from_fn(|lambda| f64::from(u8::from((first..=last).contains(&lambda))))
    }

    #[test]
    fn a_sensor_that_sees_what_no_spectrum_tells_is_warned_of() {
        let red = || Colour::Rgb([0.9, 0.1, 0.1]);
        let eye = [band(400.0, 700.0)];
        assert_eq!(warning(&scene("D65", red()), &eye), None);
        // Of 400 to 1000 nm 170 of 600 lie beyond 830 nm.
        let silicon = [band(400.0, 700.0), band(400.0, 1000.0)];
        let text = warning(&scene("D65", red()), &silicon).expect("a warning");
        assert!(text.contains("28 %") && text.contains("environment, material \"wall\""), "{text}");
        // A number is meant for all wavelengths, and lamp A is a formula.
        let grey = || Colour::Spectrum(Spectrum::constant(0.5));
        assert_eq!(warning(&scene("A", grey()), &silicon), None);
        let text = warning(&scene("FL2", grey()), &silicon).expect("a warning");
        assert!(text.contains("(environment;") && text.contains("380 to 780 nm"), "{text}");
        let measured = Spectrum::from_samples(&[450.0, 1100.0], &[0.2, 0.4], Outside::Hold).expect("sorted");
        let text = warning(&scene("A", Colour::Spectrum(measured)), &silicon).expect("a warning");
        assert!(text.contains("(material \"wall\";") && text.contains("450 to 1100 nm"), "{text}");
    }

    #[test]
    fn materials_that_no_mesh_has_are_passed_over() {
        let mut scene = scene("A", Colour::Rgb([0.5; 3]));
        assert!(warning(&scene, &[band(400.0, 1000.0)]).is_some());
        scene.meshes.clear();
        assert_eq!(warning(&scene, &[band(400.0, 1000.0)]), None);
    }
}
