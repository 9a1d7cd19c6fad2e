//! Refusals by key of what a device does not have: it develops as the processor does, or not at all.
//!
//! Settings and facts of a file are named one by one, so that a new one does not compile before it is known here.

use photosite_core::Invalid;
use photosite_raw::{Opcode, RawImage, RawMetadata};

use crate::choices::{ColourModel, Defects, Highlights, NoiseFilter, Thresholding, ToneCurve, WhiteBalance};
use crate::opcodes::opcodes;
use crate::settings::DevelopSettings;

/// Refusal of something that a device does not have.
pub(super) fn refused(key: &str, what: &str) -> Invalid {
    Invalid::new(key, format!("graphics cards do not have {what} yet")).help("develop with --device cpu")
}

fn refuse_first<const N: usize>(all: [(bool, &str, &str); N]) -> Result<(), Invalid> {
    match all.into_iter().find(|(is_set, ..)| *is_set) {
        Some((_, key, what)) => Err(refused(key, what)),
        None => Ok(()),
    }
}

/// Refuses the first setting that a device does not have whatever the raw image is.
pub(super) fn check_settings(settings: &DevelopSettings) -> Result<(), Invalid> {
    let DevelopSettings {
        defects,
        white_balance,
        highlights,
        noise_filter,
        kernel,
        digital_zoom,
        resize_px,
        colour_model,
        tone_curve,
        threshold,
        sharpening,
        dither,
        // Found by the functions that the processor asks
        raw: _,
        linearisation: _,
        black_level: _,
        lens_falloff: _,
        temperature_k: _,
        tint: _,
        colour_matrix: _,
        colour_space: _,
        exposure_ev: _,
        gamma: _,
        orientation: _,
        bits: _,
        // Judged by what they do to a raw image
        demosaic: _,
        distortion: _,
        square_pixels: _,
        default_crop: _,
        // Say more of choices that are refused
        patch_px: _,
        noise_radius_px: _,
        noise_strength: _,
        noise_sigma_px: _,
        noise_sigma_range: _,
        kernel_normalised: _,
        resize_filter: _,
        resize_antialias: _,
        tone_key: _,
        tone_white: _,
        tone_bias: _,
        tone_contrast: _,
        tone_sigma_px: _,
        tone_sigma_range: _,
        threshold_level: _,
        sharpening_radius_px: _,
        // Of files alone
        jpeg_quality: _,
    } = settings;
    let mends_defects = match defects {
        Defects::None => false,
        Defects::Median => true,
    };
    let balances_by_image = match white_balance {
        WhiteBalance::GreyWorld | WhiteBalance::WhitePatch | WhiteBalance::Patch => true,
        WhiteBalance::AsShot
        | WhiteBalance::Temperature
        | WhiteBalance::Candle
        | WhiteBalance::Incandescent
        | WhiteBalance::Halogen
        | WhiteBalance::Fluorescent
        | WhiteBalance::D50
        | WhiteBalance::Flash
        | WhiteBalance::Daylight
        | WhiteBalance::Overcast
        | WhiteBalance::Shade
        | WhiteBalance::BlueSky
        | WhiteBalance::None => false,
    };
    let mends_highlights = match highlights {
        Highlights::Clip | Highlights::None => false,
        Highlights::Blend | Highlights::Reconstruct => true,
    };
    let smooths = match noise_filter {
        NoiseFilter::None => false,
        NoiseFilter::Mean
        | NoiseFilter::Gaussian
        | NoiseFilter::Median
        | NoiseFilter::Bilateral
        | NoiseFilter::NonLocalMeans => true,
    };
    let converts = match colour_model {
        ColourModel::Rgb | ColourModel::Grey | ColourModel::EncodedGrey => false,
        ColourModel::Hsv | ColourModel::Hsl | ColourModel::Hsi | ColourModel::Lab => true,
    };
    let maps_by_image = match tone_curve {
        ToneCurve::Linear | ToneCurve::Srgb | ToneCurve::Gamma | ToneCurve::Filmic => false,
        ToneCurve::Reinhard | ToneCurve::Log | ToneCurve::Local => true,
    };
    let is_binary = match threshold {
        Thresholding::None => false,
        Thresholding::Level | Thresholding::Otsu => true,
    };
    refuse_first([
        (mends_defects, "develop.defects", "corrections of defective pixels"),
        (balances_by_image, "develop.white_balance", "white balance by the image's own pixels"),
        (mends_highlights, "develop.highlights", "highlights other than \"clip\" and \"none\""),
        (smooths, "develop.noise_filter", "noise filters"),
        (kernel.is_some(), "develop.kernel", "kernels"),
        (*digital_zoom != 1.0, "develop.digital_zoom", "digital zooms"),
        (resize_px.is_some(), "develop.resize_px", "resizing"),
        (maps_by_image, "develop.tone_curve", "tone curves other than \"srgb\", \"linear\", \"gamma\" and \"filmic\""),
        (converts, "develop.colour_model", "colour models other than \"rgb\" and grey ones"),
        (is_binary, "develop.threshold", "thresholds"),
        (*sharpening != 0.0, "develop.sharpening", "sharpening"),
        (*dither, "develop.dither", "dithering"),
    ])
}

/// Refuses the first fact about a raw image that a device does not know how to follow.
pub(super) fn check_file(raw: &RawImage, lens_falloff: bool) -> Result<(), Invalid> {
    let RawImage {
        black_level_dn,
        metadata,
        // Found by the functions that the processor asks
        width: _,
        height: _,
        active_area: _,
        linearisation: _,
        white_level_dn: _,
        channel_whites_dn: _,
        // Judged with the method of demosaicking
        cfa: _,
        // Not looked at by development
        data: _,
        bits: _,
    } = raw;
    let RawMetadata {
        is_staggered,
        opcodes: _,
        // Found by the functions that the processor asks
        calibrations: _,
        as_shot_neutral: _,
        as_shot_white_xy: _,
        baseline_exposure_ev: _,
        orientation: _,
        // Judged by the resampling that they ask for
        pixel_pitch_m: _,
        stated_pixel_aspect: _,
        default_crop: _,
        distortion: _,
        // Of noise filters, which are refused
        noise_profile: _,
        // Not looked at by development
        camera_model: _,
        camera_serial: _,
        exposure_time_s: _,
        iso: _,
        f_number: _,
        focal_length_m: _,
        left_out: _,
    } = metadata;
    let has_deltas = [black_level_dn.column_deltas(), black_level_dn.row_deltas()].map(|deltas| !deltas.is_empty());
    let has_opcodes = |list: usize| opcodes(raw, list, lens_falloff).next().is_some();
    let has_no_map = |opcode: &Opcode| match opcode {
        Opcode::GainMap(_) => false,
        Opcode::FixVignetteRadial { .. }
        | Opcode::FixBadPixelsConstant(_)
        | Opcode::FixBadPixelsList(_)
        | Opcode::MapTable(..)
        | Opcode::MapPolynomial(..)
        | Opcode::PerLine(..) => true,
    };
    refuse_first([
        (*is_staggered, "CFALayout", "hexagonal cells"),
        (has_deltas[0], "BlackLevelDeltaH", "black levels of columns"),
        (has_deltas[1], "BlackLevelDeltaV", "black levels of rows"),
        (has_opcodes(0), "OpcodeList1", "changes of stored values"),
        (
            opcodes(raw, 1, lens_falloff).any(has_no_map),
            "OpcodeList2",
            "changes of linear values other than by maps of gains",
        ),
        (has_opcodes(2), "OpcodeList3", "changes of demosaicked values"),
    ])
}

#[cfg(test)]
mod tests {
    use super::super::PackedDevelopment;
    use super::*;
    use crate::choices::Demosaic;
    use photosite_raw::Cfa;

    fn key_of(settings: &DevelopSettings) -> Option<String> {
        let cfa = Cfa::parse("RGGB").expect("known");
        let raw = RawImage::bare(16, 12, vec![100; 192], cfa, 4095);
        PackedDevelopment::new(&raw, settings).err().map(|refused| refused.key)
    }

    #[test]
    fn what_a_device_lacks_is_named_by_its_key() {
        let default = DevelopSettings::default;
        assert_eq!(key_of(&default()), None);
        for (settings, key) in [
            (DevelopSettings { defects: Defects::Median, ..default() }, "develop.defects"),
            (DevelopSettings { white_balance: WhiteBalance::GreyWorld, ..default() }, "develop.white_balance"),
            (DevelopSettings { highlights: Highlights::Blend, ..default() }, "develop.highlights"),
            (DevelopSettings { noise_filter: NoiseFilter::Median, ..default() }, "develop.noise_filter"),
            (DevelopSettings { kernel: Some(vec![vec![1.0]]), ..default() }, "develop.kernel"),
            (DevelopSettings { digital_zoom: 2.0, ..default() }, "develop.digital_zoom"),
            (DevelopSettings { resize_px: Some([8, 6]), ..default() }, "develop.resize_px"),
            (DevelopSettings { tone_curve: ToneCurve::Local, ..default() }, "develop.tone_curve"),
            (DevelopSettings { colour_model: ColourModel::Lab, ..default() }, "develop.colour_model"),
            (DevelopSettings { threshold: Thresholding::Otsu, ..default() }, "develop.threshold"),
            (DevelopSettings { sharpening: 0.5, ..default() }, "develop.sharpening"),
            (DevelopSettings { dither: true, ..default() }, "develop.dither"),
            (DevelopSettings { demosaic: Demosaic::Lmmse, ..default() }, "develop.demosaic"),
            // What no development has
            (DevelopSettings { bits: 12, ..default() }, "develop.bits"),
            (DevelopSettings { white_balance: WhiteBalance::Daylight, ..default() }, "develop.white_balance"),
        ] {
            assert_eq!(key_of(&settings).as_deref(), Some(key));
        }
    }

    #[test]
    fn pixel_values_do_not_count() {
        let raw = RawImage::bare(16, 12, vec![100; 192], Cfa::parse("RGGB").expect("known"), 4095);
        let packed =
            |raw: &RawImage| PackedDevelopment::new(raw, &DevelopSettings::default()).expect("a device has it");
        assert_eq!(packed(&raw), packed(&raw.with_data(Vec::new())));
    }
}
