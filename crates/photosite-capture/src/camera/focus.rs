//! Focus of a lens: from the keys to a [`Focus`].

use super::super::tables::{AutofocusKind, AutofocusSearchTable, AutofocusTable, FocusDistance, LensTable};
use super::super::tree::numbers::positive_number;
use photosite_core::Invalid;
use photosite_core::warnings::Warnings;
use photosite_transport::optics::{AutofocusMethod, ContrastAutofocus, Focus, LensKind, Sharpness};

/// Focus distance that is that of the middle of the geometry, by its name.
pub(crate) const ON_SCENE: &str = "scene";
/// Bounds of a search for the most contrast, px: windows that fit in memory, and in which a peak is found at all.
const WINDOW_PX: std::ops::RangeInclusive<u32> = 8..=1024;
const STEPS: std::ops::RangeInclusive<u32> = 5..=200;

/// Focus of a lens. `unstated` holds where the table says nothing of it, or to focus on the scene.
pub(crate) fn focus(
    table: &LensTable,
    kind: LensKind,
    size_px: [f64; 2],
    unstated: Option<Focus>,
    warnings: &mut Warnings,
) -> Result<Focus, Invalid> {
    let given = [
        ("focus_distance_m", table.focus_distance_m.is_some()),
        ("autofocus_px", table.autofocus_px.is_some()),
        ("image_distance_mm", table.image_distance_mm.is_some()),
    ];
    let mut keys = given.iter().filter(|(_, is_given)| *is_given).map(|(key, _)| *key);
    let (first, second) = (keys.next(), keys.next());
    let has_focus = match kind {
        LensKind::Thin | LensKind::Prescription => true,
        LensKind::Pinhole | LensKind::Hole | LensKind::Bare => false,
    };
    if !has_focus {
        let has_effect = |key: &str| kind == LensKind::Hole && key == "image_distance_mm";
        let is_infinite = matches!(&table.focus_distance_m, Some(FocusDistance::Name(name)) if name == "infinity");
        let says_so = |key: &str| is_infinite && key == "focus_distance_m";
        let idle = first.filter(|key| !(has_effect(key) || says_so(key)));
        let idle = idle.or(table.autofocus.map(|_| "autofocus"));
        if let Some(key) = idle.or(table.min_focus_distance_m.map(|_| "min_focus_distance_m")) {
            let why = match kind {
                LensKind::Pinhole => "a pinhole has no focus, and its image lies one focal length behind it",
                LensKind::Hole => "a hole has no focus; image_distance_mm is where the sensor stands",
                LensKind::Bare | LensKind::Thin | LensKind::Prescription => "there is no lens",
            };
            warnings.once(format!("lens.{key} has no effect: {why}; remove the key, or write type = \"thin\""));
        }
        return Ok(Focus::Infinity);
    }
    if let (Some(first), Some(second)) = (first, second) {
        return Err(Invalid::new(second, format!("cannot be combined with {first}")).help("keep one of them"));
    }
    let method = method(table.autofocus.as_ref()).map_err(|invalid| invalid.within("autofocus"))?;
    if kind == LensKind::Prescription && method != AutofocusMethod::Exact {
        let message = "the search for contrast does not move the glass of lens.prescription yet";
        return Err(Invalid::new("autofocus.method", message).help("remove it: autofocus is exact then"));
    }
    let centre = size_px.map(|n| n / 2.0);
    let focus = match (&table.focus_distance_m, &table.autofocus_px, table.image_distance_mm) {
        (Some(FocusDistance::Name(name)), ..) if name != ON_SCENE => focus_distance(name)?,
        (Some(FocusDistance::Metres(u)), ..) => Focus::Distance(*u),
        (_, Some(pixel), _) => Focus::Autofocus { pixel: place(pixel, size_px)?, method },
        (_, _, Some(mm)) => Focus::ImageDistance(positive_number("image_distance_mm", mm, "16.5")? / 1e3),
        (None, None, None) if table.autofocus.is_some() => Focus::Autofocus { pixel: centre, method },
        (Some(FocusDistance::Name(_)) | None, None, None) => {
            unstated.unwrap_or(Focus::Autofocus { pixel: centre, method })
        }
    };
    if let (Some(_), Focus::Distance(_) | Focus::Infinity | Focus::ImageDistance(_)) = (table.autofocus, focus) {
        warnings.once("lens.autofocus has no effect: the focus is stated; write autofocus_px in its place");
    }
    Ok(focus)
}

fn focus_distance(name: &str) -> Result<Focus, Invalid> {
    match name {
        "infinity" => Ok(Focus::Infinity),
        _ => Err(Invalid::new("focus_distance_m", format!("unknown distance {name:?}"))
            .help("write a number of metres, \"infinity\" or \"scene\"")),
    }
}

fn place(pixel: &AutofocusTable, size_px: [f64; 2]) -> Result<[f64; 2], Invalid> {
    match pixel {
        AutofocusTable::Pixel(pixel) if (0..2).all(|i| (0.0..=size_px[i]).contains(&pixel[i])) => Ok(*pixel),
        AutofocusTable::Pixel(pixel) => {
            let message = format!("{pixel:?} is not on the sensor of {} × {} pixels", size_px[0], size_px[1]);
            Err(Invalid::new("autofocus_px", message).help("pixels count from the top-left corner"))
        }
        AutofocusTable::Name(name) if name == "centre" => Ok(size_px.map(|n| n / 2.0)),
        AutofocusTable::Name(name) => Err(Invalid::new("autofocus_px", format!("unknown place {name:?}"))
            .help("write a pixel such as [400, 300], or \"centre\"")),
    }
}

fn method(table: Option<&AutofocusSearchTable>) -> Result<AutofocusMethod, Invalid> {
    let Some(table) = table else { return Ok(AutofocusMethod::Exact) };
    let of_contrast = [
        ("window_px", table.window_px.is_some()),
        ("steps", table.steps.is_some()),
        ("measure", table.measure.is_some()),
    ];
    if table.method != Some(AutofocusKind::Contrast) {
        return match of_contrast.iter().find(|(_, is_given)| *is_given) {
            Some((key, _)) => Err(Invalid::new(*key, "belongs to the search for contrast")
                .help("write method = \"contrast\", too, or remove it")),
            None => Ok(AutofocusMethod::Exact),
        };
    }
    let window_px = table.window_px.unwrap_or(64);
    let steps = table.steps.unwrap_or(12);
    for (key, value, range) in [("window_px", window_px, WINDOW_PX), ("steps", steps, STEPS)] {
        if !range.contains(&value) {
            let message = format!("must lie between {} and {}, got {value}", range.start(), range.end());
            return Err(Invalid::new(key, message));
        }
    }
    let measure = table.measure.unwrap_or(Sharpness::Gradient);
    Ok(AutofocusMethod::Contrast(ContrastAutofocus { window_px, steps, measure }))
}
