//! The ideal image: what an observer with the eyes of the CIE would make of the light on the sensor. It has no noise
//! but that of light transport, no mosaic and no error of the colour matrix, so that each of these can be told apart.
//!
//! In: ∫ E(λ)·(x̄, ȳ, z̄)(λ) dλ at every pixel, from the same film as the electrons. Out: planes like those of
//! [`develop_linear`](super::develop_linear), adapted to the same white, 1 being white at saturation.

use glam::DVec3;

use super::colour;
use super::develop::shown;
use super::settings::DevelopSettings;
use photosite_core::Invalid;
use photosite_core::image::Planes;
use photosite_core::spectrum::{Spectrum, cie};

/// Planes X, Y and Z become the colour space of the settings. `light` is the light of the scene (any unit) as the lens
/// lets it through; `responses` are those of the sensor's channels, e⁻·s⁻¹ per W·m⁻²·nm⁻¹; `saturation` is the rate of
/// electrons, e⁻·s⁻¹, that just saturates a pixel.
pub fn ideal(
    xyz: Planes,
    light: &Spectrum,
    responses: &[(String, Spectrum)],
    saturation: f64,
    settings: &DevelopSettings,
) -> Result<Planes, Invalid> {
    let white = DVec3::from_array(cie::xyz(light));
    // Of a white surface in this light, the channel that sees most of it is the first to saturate.
    let most = responses.iter().map(|(_, response)| response.product(light).integral()).fold(0.0, f64::max);
    let full = white.y * saturation / most;
    if !(full.is_finite() && full > 0.0) {
        let message = "an ideal image needs a light that both the eye and the sensor see";
        return Err(Invalid::new("ideal", message).help("leave out output.ideal"));
    }
    let from_xyz = settings.colour_space.from_xyz(white / white.y) * (1.0 / full);
    let columns = [from_xyz.x_axis, from_xyz.y_axis, from_xyz.z_axis];
    Ok(shown(colour::apply(xyz, &columns, settings.colour_space, settings.exposure_ev.exp2()), settings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::image::Channel;
    use photosite_core::spectrum::illuminant;

    #[test]
    fn a_white_surface_that_just_saturates_is_white() {
        let light = illuminant::a().scale(1e-3);
        let responses = [("G".to_owned(), Spectrum::constant(2.0)), ("R".to_owned(), Spectrum::constant(3.0))];
        // The light on the sensor is `light` itself, so that R counts 3·∫ light.
        let saturation = 3.0 * light.integral();
        let [x, y, z] = cie::xyz(&light);
        let plane = |name: &str, v: f64| Channel { name: name.to_owned(), data: vec![v as f32, 0.5 * v as f32] };
        let xyz = Planes::new(2, 1, vec![plane("X", x), plane("Y", y), plane("Z", z)]).expect("right sizes");
        let found = ideal(xyz, &light, &responses, saturation, &DevelopSettings::default()).expect("seen");
        for channel in found.channels() {
            assert!((channel.data[0] - 1.0).abs() < 1e-5 && (channel.data[1] - 0.5).abs() < 1e-5, "{channel:?}");
        }
        let infrared = Spectrum::from_fn(|lambda| if lambda > 900.0 { 1.0 } else { 0.0 });
        let dark = Planes::zeros(1, 1, ["X", "Y", "Z"]);
        assert!(ideal(dark, &infrared, &responses, 1.0, &DevelopSettings::default()).is_err());
    }
}
