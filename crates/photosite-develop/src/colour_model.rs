//! Colour models: the meaning of an image's values where they are no components of the colour space.

use glam::DVec3;
use rayon::prelude::*;

use photosite_core::rows::{for_each_value, values};

use super::choices::ColourModel;
use super::settings::DevelopSettings;
use photosite_core::colour::{ColourSpace, Transfer, cielab, hue};
use photosite_core::image::{Channel, Planes};

/// Luminance Y of linear planes of the space: of a single plane itself.
pub(super) fn luminance(image: &Planes, space: ColourSpace) -> Vec<f32> {
    let [r, g, b] = match image.channels() {
        [grey] => return grey.data.clone(),
        [r, g, b, ..] => [r, g, b].map(|channel| &channel.data),
        // No step before leaves other numbers of planes.
        [] | [_, _] => return vec![0.0; image.width() * image.height()],
    };
    let weights = space.luminance_weights();
    values(r.len(), |i| weights.dot(vector(&r[i], &g[i], &b[i])) as f32)
}

/// Turns linear planes into a plane of their luminance, if the settings ask for grey.
pub(super) fn to_grey(image: Planes, settings: &DevelopSettings) -> Planes {
    if !settings.colour_model.is_grey() || image.channels().len() == 1 {
        return image;
    }
    grey(&image, "Y", luminance(&image, settings.colour_space))
}

/// Image of a single plane.
fn grey(image: &Planes, name: &str, data: Vec<f32>) -> Planes {
    let channel = Channel { name: name.to_owned(), data };
    Planes::new(image.width(), image.height(), vec![channel]).expect("a plane keeps its size")
}

/// Values of the settings' colour model, from linear planes of their colour space. A plane of grey counts as three
/// equal ones. What is shown as it is stays as it is.
pub fn in_model(image: Planes, settings: &DevelopSettings) -> Planes {
    let space = settings.colour_space;
    let transfer = settings.transfer();
    let encoded = |linear: DVec3| linear.to_array().map(|v| code(v, transfer)).into();
    match settings.colour_model {
        ColourModel::Rgb | ColourModel::Grey => image,
        ColourModel::EncodedGrey => {
            let mut data = luminance(&image, space);
            for_each_value(&mut data, |value| *value = code(f64::from(*value), transfer) as f32);
            grey(&image, "Y'", data)
        }
        ColourModel::Hsv => converted(image, ["H", "S", "V"], |linear| hue::rgb_to_hsv(encoded(linear))),
        ColourModel::Hsl => converted(image, ["H", "S", "L"], |linear| hue::rgb_to_hsl(encoded(linear))),
        ColourModel::Hsi => converted(image, ["H", "S", "I"], |linear| hue::rgb_to_hsi(encoded(linear))),
        ColourModel::Lab => {
            let (to_xyz, white) = (space.to_xyz(), space.white());
            // Grey is Y of that white.
            let to_xyz = if image.channels().len() == 1 && space == ColourSpace::Xyz {
                ColourSpace::Srgb.to_xyz()
            } else {
                to_xyz
            };
            converted(image, ["L", "a", "b"], |linear| cielab::from_xyz(to_xyz * linear, white))
        }
    }
}

/// Code of a linear value before it is rounded.
fn code(linear: f64, transfer: Transfer) -> f64 {
    // Not-a-number is black, too.
    transfer.encode_exactly(if linear > 0.0 { linear.min(1.0) } else { 0.0 })
}

fn converted(image: Planes, names: [&str; 3], convert: impl Fn(DVec3) -> DVec3 + Sync) -> Planes {
    let (width, height) = (image.width(), image.height());
    let mut planes: Vec<Vec<f32>> = image.into_channels().into_iter().map(|channel| channel.data).collect();
    while planes.len() < 3 {
        planes.push(planes[0].clone());
    }
    if let [first, second, third, ..] = &mut planes[..] {
        first.par_iter_mut().zip(second).zip(third).for_each(|((a, b), c)| {
            [*a, *b, *c] = convert(vector(a, b, c)).as_vec3().to_array();
        });
    }
    let channels = names.into_iter().zip(planes).map(|(name, data)| Channel { name: name.to_owned(), data });
    Planes::new(width, height, channels.collect()).expect("planes keep their size")
}

fn vector(a: &f32, b: &f32, c: &f32) -> DVec3 {
    DVec3::new((*a).into(), (*b).into(), (*c).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(rgb: [f32; 3]) -> Planes {
        let channel = |(name, v): (&str, f32)| Channel { name: name.to_owned(), data: vec![v; 2] };
        Planes::new(2, 1, ["R", "G", "B"].into_iter().zip(rgb).map(channel).collect()).expect("right sizes")
    }

    fn model(colour_model: ColourModel) -> DevelopSettings {
        DevelopSettings { colour_model, ..DevelopSettings::default() }
    }

    fn numbers(image: &Planes) -> Vec<(&str, f32)> {
        image.channels().iter().map(|c| (&c.name[..], c.data[1])).collect()
    }

    #[test]
    fn known_colours_have_their_numbers() {
        // Linear 0.214041 is a code of 0.5.
        let half_red = image([0.214_041_14, 0.0, 0.0]);
        for (colour_model, expected) in [
            (ColourModel::Hsv, [("H", 0.0), ("S", 1.0), ("V", 0.5)]),
            (ColourModel::Hsl, [("H", 0.0), ("S", 1.0), ("L", 0.25)]),
            (ColourModel::Hsi, [("H", 0.0), ("S", 1.0), ("I", 0.5 / 3.0)]),
            // Of a grey of half the luminance below.
            (ColourModel::Rgb, [("R", 0.214_041_14), ("G", 0.0), ("B", 0.0)]),
        ] {
            let found = in_model(half_red.clone(), &model(colour_model));
            for ((name, found), (expected_name, expected)) in numbers(&found).into_iter().zip(expected) {
                assert_eq!(name, expected_name);
                assert!((found - expected).abs() < 1e-6, "{colour_model:?}: {name} = {found}");
            }
        }
        let lab = in_model(image([0.18; 3]), &model(ColourModel::Lab));
        // 116·0.18^(1/3) − 16 by a calculator.
        assert!((lab.channels()[0].data[0] - 49.496_1).abs() < 1e-4 && lab.channels()[1].data[0].abs() < 1e-4);
    }

    #[test]
    fn grey_is_luminance_and_a_grey_image_has_every_model() {
        let grey = to_grey(image([0.0, 1.0, 0.0]), &model(ColourModel::Grey));
        assert!((numbers(&grey)[0].1 - 0.715_2).abs() < 1e-4);
        let half = in_model(
            to_grey(image([0.214_041_14; 3]), &model(ColourModel::EncodedGrey)),
            &model(ColourModel::EncodedGrey),
        );
        assert!(numbers(&half).len() == 1 && (numbers(&half)[0].1 - 0.5).abs() < 1e-6, "{half:?}");
        for (colour_space, colour_model) in [
            (ColourSpace::Srgb, ColourModel::Lab),
            (ColourSpace::Xyz, ColourModel::Lab),
            (ColourSpace::Acescg, ColourModel::Hsl),
        ] {
            let settings = DevelopSettings { colour_space, ..model(colour_model) };
            let channel = Channel { name: "Y".to_owned(), data: vec![1.0] };
            let found = in_model(Planes::new(1, 1, vec![channel]).expect("right size"), &settings);
            let expected = if colour_model == ColourModel::Lab { [100.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
            let apart = found.channels().iter().zip(expected).map(|(c, e)| (c.data[0] - e).abs()).fold(0.0, f32::max);
            assert!(apart < 1e-4, "{colour_space:?} {colour_model:?}: {found:?}");
        }
    }
}
