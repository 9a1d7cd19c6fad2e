//! Curves over the field, and of modulation transfer.

use super::compute::LINES;
use super::figures::{ChiefFigures, FieldFigures, MtfFigures, PositionFigures};
use photosite_measure::characterisation::report::chart::{Axis, BLUE, Chart, Curve, GREEN, Mark, ORANGE, RGBColor};
use photosite_measure::characterisation::report::plot::Plot;

/// Colours of F, d and C: blue, green, and orange for red.
pub(super) const COLOURS: [RGBColor; 3] = [BLUE, GREEN, ORANGE];

/// Plots of a position.
pub(super) fn plots(position: &PositionFigures) -> Vec<Plot> {
    let mut plots =
        vec![field_curves(position), distortion(position), illumination(position), lateral_colour(position)];
    plots.extend(modulation_by_frequency(position));
    plots.push(modulation_by_field(position));
    plots
}

/// Plot of a figure of the chief ray over its angle.
fn by_angle(position: &PositionFigures, of: impl Fn(&ChiefFigures) -> Option<f64>) -> Vec<(f64, f64)> {
    position.curves.iter().filter_map(|chief| Some((chief.field_deg, of(chief)?))).collect()
}

/// Plot of a figure of every field over its angle.
fn by_field(position: &PositionFigures, of: impl Fn(&FieldFigures) -> Option<f64>) -> Vec<(f64, f64)> {
    position.fields.iter().filter_map(|field| Some((field.chief.field_deg, of(field)?))).collect()
}

fn angle(position: &PositionFigures) -> Axis {
    Axis::linear("field in °").within(0.0, position.half_field_deg)
}

fn field_curves(position: &PositionFigures) -> Plot {
    let curves = vec![
        Curve::new("tangential", Mark::Line, BLUE, by_angle(position, |chief| chief.tangential_focus_mm)),
        Curve::new("sagittal", Mark::Dashes, ORANGE, by_angle(position, |chief| chief.sagittal_focus_mm)),
    ];
    Plot {
        title: "Field curves",
        caption: "Where rays close to the chief ray of d cross it, behind the sensor.".to_owned(),
        chart: Chart { x: angle(position), y: Axis::linear("behind the sensor in mm"), curves },
    }
}

fn distortion(position: &PositionFigures) -> Plot {
    Plot {
        title: "Distortion",
        caption: "Height of the chief ray over f·tan θ, less 1.".to_owned(),
        chart: Chart {
            x: angle(position),
            y: Axis::linear("distortion in %"),
            curves: vec![Curve::new("", Mark::Line, BLUE, by_angle(position, |chief| Some(chief.distortion_percent)))],
        },
    }
}

fn illumination(position: &PositionFigures) -> Plot {
    Plot {
        title: "Relative illumination",
        caption: "Irradiance in uniform light, over that of the middle, with all that apertures cut off.".to_owned(),
        chart: Chart {
            x: angle(position),
            y: Axis::linear("relative illumination").within(0.0, 1.05),
            curves: vec![Curve::new(
                "",
                Mark::Line,
                BLUE,
                by_field(position, |field| Some(field.relative_illumination)),
            )],
        },
    }
}

fn lateral_colour(position: &PositionFigures) -> Plot {
    let curves = vec![
        Curve::new("F", Mark::Line, COLOURS[0], by_angle(position, |chief| chief.lateral_colour_f_um)),
        Curve::new("C", Mark::Line, COLOURS[2], by_angle(position, |chief| chief.lateral_colour_c_um)),
    ];
    Plot {
        title: "Lateral colour",
        caption: "Chief rays of F and C on the sensor, beyond that of d.".to_owned(),
        chart: Chart { x: angle(position), y: Axis::linear("beyond d in µm"), curves },
    }
}

/// Indices of the fields that are plotted: on the axis, at about 0.7 of the field and at its edge.
pub(super) fn shown_fields(position: &PositionFigures) -> Vec<usize> {
    let last = position.fields.len().saturating_sub(1);
    let mut shown = vec![0, (0.7 * last as f64).round() as usize, last];
    shown.dedup();
    shown
}

fn modulation_by_frequency(position: &PositionFigures) -> Vec<Plot> {
    let titles =
        ["Modulation transfer on the axis", "Modulation transfer in the field", "Modulation transfer at the edge"];
    let plot = |(title, i): (&'static str, usize)| {
        let field = &position.fields[i];
        let mut curves = Vec::new();
        let mut methods = Vec::new();
        for (((line, _), colour), mtf) in LINES.into_iter().zip(COLOURS).zip(&field.mtf) {
            let Some(mtf) = mtf else { continue };
            let points = |values: &[f64]| mtf.frequency_per_mm.iter().copied().zip(values.iter().copied()).collect();
            curves.push(Curve::new(format!("{line} T"), Mark::Line, colour, points(&mtf.tangential)));
            curves.push(Curve::new(format!("{line} S"), Mark::Dashes, colour, points(&mtf.sagittal)));
            methods.push(format!(
                "{line} {:.2} λ by {}",
                mtf.rms_waves,
                if mtf.method == "wave" { "the wave" } else { "rays" }
            ));
        }
        Plot {
            title,
            caption: format!(
                "At {:.2}°, tangential (T) and sagittal (S); rms of the wave front: {}.",
                field.chief.field_deg,
                methods.join(", ")
            ),
            chart: Chart {
                x: Axis::linear("cycles per mm").within(0.0, 100.0),
                y: Axis::linear("modulation").within(0.0, 1.0),
                curves,
            },
        }
    };
    titles.into_iter().zip(shown_fields(position)).map(plot).collect()
}

fn modulation_by_field(position: &PositionFigures) -> Plot {
    let mut curves = Vec::new();
    for (frequency, colour) in [(10.0, BLUE), (20.0, GREEN), (40.0, ORANGE)] {
        let at = |values: fn(&MtfFigures) -> &Vec<f64>| {
            by_field(position, |field| {
                let mtf = field.mtf[1].as_ref()?;
                let i = mtf.frequency_per_mm.iter().position(|known| *known == frequency)?;
                values(mtf).get(i).copied()
            })
        };
        curves.push(Curve::new(format!("{frequency} T"), Mark::Line, colour, at(|mtf| &mtf.tangential)));
        curves.push(Curve::new(format!("{frequency} S"), Mark::Dashes, colour, at(|mtf| &mtf.sagittal)));
    }
    Plot {
        title: "Modulation transfer over the field",
        caption: "At d, for 10, 20 and 40 cycles per mm, tangential (T) and sagittal (S).".to_owned(),
        chart: Chart { x: angle(position), y: Axis::linear("modulation").within(0.0, 1.0), curves },
    }
}
