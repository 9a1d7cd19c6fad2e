//! Statements of colours that a file of another format has no place for.

use std::path::Path;

use super::formats::{EXR, Format, PNG};
use super::stated_colours::StatedColours;
use photosite_scene_io::exr::of_colours;

impl StatedColours {
    /// Warning of statements that the file at the path makes and one of that format cannot; `None` where it can make
    /// all that matter.
    pub fn lost_in(&self, format: &Format, path: &Path) -> Option<String> {
        let mut lost: Vec<&str> = Vec::new();
        let is_carried = self.profile.is_some() && format.has_profile;
        if self.profile.is_some() && !format.has_profile {
            lost.push("its ICC profile");
        }
        // A profile says more than the rest, and what is left of sRGB is what a file without a statement says.
        if *format != PNG && !is_carried {
            lost.extend(self.code_points.map(|_| "cICP"));
            lost.extend(self.gamma.filter(|_| self.srgb.is_none()).map(|_| "gAMA"));
            lost.extend(self.chromaticities.filter(|_| self.srgb.is_none()).map(|_| "cHRM"));
        }
        if *format != EXR {
            lost.extend(of_colours(&self.attributes).map(|(name, _)| name));
        }
        let lost = (!lost.is_empty()).then(|| lost.join(", "))?;
        Some(format!("what {} says of its colours by {lost} is not carried over", path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::{PPM, TIFF};
    use crate::noisy_image::make_noisy;
    use crate::plain_image::{PlainImage, write_plain_image};
    use photosite_core::colour::ColourSpace;
    use photosite_core::image::{Channel, Planes};
    use photosite_core::output::write_whole;
    use photosite_measure::synthetic_noise::SyntheticNoise;

    /// Function of a command that writes an image anew: the image for a file of that format, and warnings.
    type Rewrites = fn(&Path, &Format) -> (PlainImage, Vec<String>);

    fn rectified(path: &Path, format: &Format) -> (PlainImage, Vec<String>) {
        let (image, mut warnings) = PlainImage::read(path).expect("read");
        warnings.extend(image.colours.lost_in(format, path));
        (image, warnings)
    }

    fn noisy(path: &Path, format: &Format) -> (PlainImage, Vec<String>) {
        let mut noise = SyntheticNoise::default();
        noise.gaussian.sigma = 1.0;
        let noisy = make_noisy(path, &noise, false, 0, format).expect("read");
        (noisy.image, noisy.warnings)
    }

    const COMMANDS: [Rewrites; 2] = [rectified, noisy];

    fn image(colours: StatedColours, largest: Option<u16>) -> PlainImage {
        let channel = |name: &str| Channel { name: name.to_owned(), data: vec![1.0, 2.0] };
        let planes = Planes::new(2, 1, ["R", "G", "B"].map(channel).to_vec()).expect("right sizes");
        PlainImage { colours, ..PlainImage::plain(planes, largest) }
    }

    /// Test of every statement with every command: it is in the new file, or a warning names it.
    #[test]
    fn statements_are_carried_over_or_named() {
        let none = StatedColours::default;
        let profile = Some(b"a profile".to_vec());
        let (gamma, chromaticities) = (Some(0.45455f32.into()), Some(ColourSpace::DisplayP3.chromaticities()));
        let srgb = Some(png::SrgbRenderingIntent::Saturation);
        let code_points = Some([12, 13]);
        let folder = tempfile::tempdir().expect("a folder");
        for (stated, lost_in_tiff, lost_in_ppm) in [
            (none(), "", ""),
            (StatedColours { srgb, ..none() }, "", ""),
            (StatedColours { profile: profile.clone(), ..none() }, "", "its ICC profile"),
            (StatedColours { code_points, ..none() }, "cICP", "cICP"),
            (StatedColours { gamma, ..none() }, "gAMA", "gAMA"),
            (StatedColours { gamma, chromaticities, ..none() }, "gAMA, cHRM", "gAMA, cHRM"),
            (StatedColours { profile, code_points, gamma, ..none() }, "", "its ICC profile, cICP, gAMA"),
        ] {
            let path = folder.path().join("stated.png");
            write_whole(&path, |to| write_plain_image(&image(stated, Some(255)), &PNG, to)).expect("written");
            let (stated, _) = PlainImage::read(&path).expect("read");
            for (rewrites, (format, lost)) in COMMANDS
                .into_iter()
                .flat_map(|rewrites| [(PNG, ""), (TIFF, lost_in_tiff), (PPM, lost_in_ppm)].map(|f| (rewrites, f)))
            {
                let (image, warnings) = rewrites(&path, &format);
                let named = format!("by {lost} is not carried over");
                assert_eq!(
                    warnings.iter().any(|what| what.contains("not carried over")),
                    !lost.is_empty(),
                    "{format:?}"
                );
                assert!(lost.is_empty() || warnings.iter().any(|what| what.ends_with(&named)), "{warnings:?}");
                let copy = folder.path().join(format!("copy.{}", format.ending()));
                write_whole(&copy, |to| write_plain_image(&image, &format, to)).expect("written");
                let (copy, _) = PlainImage::read(&copy).expect("read");
                if format == PNG {
                    assert_eq!(copy.colours, stated.colours);
                } else if format == TIFF {
                    assert_eq!(copy.colours.profile, stated.colours.profile);
                }
            }
        }
    }

    #[test]
    fn chromaticities_of_exr_files_are_carried_over_or_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("stated.exr");
        for (space, is_named) in [(ColourSpace::Srgb, false), (ColourSpace::Rec2020, true)] {
            let stated = StatedColours::of_exr([(
                "chromaticities",
                crate::exr::Attribute::Chromaticities(space.chromaticities()),
            )]);
            write_whole(&path, |to| write_plain_image(&image(stated, None), &EXR, to)).expect("written");
            for rewrites in COMMANDS {
                let (image, warnings) = rewrites(&path, &EXR);
                assert!(warnings.is_empty(), "{warnings:?}");
                assert!(image.colours.attributes.iter().any(|(name, _)| name == "chromaticities"));
                let (_, warnings) = rewrites(&path, &TIFF);
                assert_eq!(
                    warnings.iter().any(|what| what.contains("by chromaticities is not")),
                    is_named,
                    "{warnings:?}"
                );
            }
        }
    }
}
