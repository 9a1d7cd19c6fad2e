//! Colours of a chart whose patches are known: how far an image's lie from them.

use glam::DVec3;
use serde::Serialize;

use photosite_core::Invalid;
use photosite_core::colour::{ColourSpace, cielab, difference};
use photosite_core::image::Planes;

/// Colour differences over the patches of a chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckerReport {
    /// Reports on each patch.
    pub patches: Vec<PatchReport>,
    /// Factor that the image was multiplied by, so that its brightness is that of the chart: an image's exposure is a
    /// matter of taste, its colours are not.
    pub scale: f64,
    /// Mean of ΔE₀₀.
    pub mean_delta_e_2000: f64,
    /// Median of ΔE₀₀.
    pub median_delta_e_2000: f64,
    /// Largest ΔE₀₀.
    pub largest_delta_e_2000: f64,
    /// Mean of ΔE\*ab.
    pub mean_delta_e_76: f64,
}

/// A patch in an image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatchReport {
    /// Name of the patch.
    pub name: String,
    /// Number of pixels of the patch that were averaged.
    pub pixels: usize,
    /// L\*, a\*, b\* of the mean of the pixels, after scaling.
    pub lab: [f64; 3],
    /// CIELAB colour that the patch should have.
    pub expected_lab: [f64; 3],
    /// ΔE₀₀ between the two.
    pub delta_e_2000: f64,
    /// ΔE\*ab between the two.
    pub delta_e_76: f64,
}

/// Compares the mean linear sRGB of each patch with its colour, XYZ relative to the white of sRGB. `patch_of` says for
/// every pixel which of the patches it shows, if any.
pub fn checker(
    image: &Planes,
    patch_of: &[Option<usize>],
    patches: &[(String, DVec3)],
) -> Result<CheckerReport, Invalid> {
    let [Some(red), Some(green), Some(blue)] = ["R", "G", "B"].map(|name| image.plane(name)) else {
        return Err(Invalid::new("", "the image has no channels R, G and B").help("give a developed colour image"));
    };
    let to_xyz = ColourSpace::Srgb.to_xyz();
    let mut sums = vec![(DVec3::ZERO, 0usize); patches.len()];
    for (i, patch) in patch_of.iter().enumerate() {
        if let Some((sum, count)) = patch.and_then(|patch| sums.get_mut(patch)) {
            *sum += DVec3::new(red[i].into(), green[i].into(), blue[i].into());
            *count += 1;
        }
    }
    let seen: Vec<(&(String, DVec3), DVec3, usize)> = (patches.iter().zip(&sums))
        .filter(|(_, (_, count))| *count > 0)
        .map(|(patch, (sum, count))| (patch, to_xyz * (*sum / *count as f64), *count))
        .collect();
    // Least squares of luminance.
    let numerator: f64 = seen.iter().map(|((_, expected), found, _)| expected.y * found.y).sum();
    let denominator: f64 = seen.iter().map(|(_, found, _)| found.y * found.y).sum();
    let scale = numerator / denominator;
    if seen.is_empty() || !(scale.is_finite() && scale > 0.0) {
        return Err(Invalid::new("", "shows the chart black"));
    }
    let white = ColourSpace::Srgb.white();
    let report = |((name, expected), found, pixels): &(&(String, DVec3), DVec3, usize)| {
        let (lab, expected) = (cielab::from_xyz(*found * scale, white), cielab::from_xyz(*expected, white));
        PatchReport {
            name: name.clone(),
            pixels: *pixels,
            lab: lab.to_array(),
            expected_lab: expected.to_array(),
            delta_e_2000: difference::delta_e_2000(lab, expected),
            delta_e_76: difference::delta_e_76(lab, expected),
        }
    };
    let patches: Vec<PatchReport> = seen.iter().map(report).collect();
    let mut sorted: Vec<f64> = patches.iter().map(|patch| patch.delta_e_2000).collect();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    Ok(CheckerReport {
        scale,
        mean_delta_e_2000: sorted.iter().sum::<f64>() / n as f64,
        median_delta_e_2000: 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
        largest_delta_e_2000: sorted[n - 1],
        mean_delta_e_76: patches.iter().map(|patch| patch.delta_e_76).sum::<f64>() / n as f64,
        patches,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::image::Channel;

    #[test]
    fn exposure_does_not_count_and_colour_does() {
        let white = ColourSpace::Srgb.white();
        let patches =
            [("grey".to_owned(), 0.4 * white), ("dark".to_owned(), 0.1 * white), ("unseen".to_owned(), white)];
        let patch_of = [Some(0), Some(0), Some(1), None];
        let image = |red: f32| {
            let plane = |name: &str, factor: f32| Channel {
                name: name.to_owned(),
                data: [0.2, 0.2, 0.05, 9.0].map(|v| v * factor).to_vec(),
            };
            let channels = vec![plane("R", red), plane("G", 1.0), plane("B", 1.0)];
            checker(&Planes::new(4, 1, channels).expect("right sizes"), &patch_of, &patches).expect("seen")
        };
        let grey = image(1.0);
        assert!((grey.scale - 2.0).abs() < 1e-6 && grey.largest_delta_e_2000 < 1e-4, "{grey:?}");
        assert_eq!(grey.patches.iter().map(|p| p.pixels).collect::<Vec<_>>(), [2, 1]);
        let reddish = image(1.2);
        assert!(reddish.mean_delta_e_2000 > 3.0 && reddish.patches[0].lab[1] > 3.0, "{reddish:?}");
    }

    #[test]
    fn images_without_the_chart_are_refused() {
        let grey = Planes::zeros(2, 1, ["Y"]);
        assert!(checker(&grey, &[None, None], &[]).is_err());
        let black = Planes::zeros(2, 1, ["R", "G", "B"]);
        assert!(checker(&black, &[Some(0), Some(0)], &[("white".to_owned(), DVec3::ONE)]).is_err());
    }
}
