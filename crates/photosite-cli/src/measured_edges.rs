//! Figures of edges for `photosite measure mtf`, in pixels and in mm, as text and as a plot.

use std::path::Path;

use serde::Serialize;

use photosite_core::{Error, Result};
use photosite_measure::characterisation::report::chart::{Axis, BLUE, Chart, Curve, GREY, Mark, ORANGE};
use photosite_measure::measures::EdgeResponse;

/// Standard error of the modulation at half the Nyquist frequency above which a warning is given.
const RAGGED: f64 = 0.02;
/// Number of points of the curve of a pixel alone.
const POINTS: u32 = 100;

/// Edge with its figures.
#[derive(Serialize)]
pub(super) struct MeasuredEdge {
    /// Region of the edge: column, row, columns, rows.
    region: [usize; 4],
    #[serde(flatten)]
    response: EdgeResponse,
    /// Width and height of the pixels, µm; `null` where unknown, as are all figures in mm then.
    pixel_pitch_um: Option<[f64; 2]>,
    frequency_cy_per_mm: Option<Vec<f64>>,
    mtf50_cy_per_mm: Option<f64>,
    mtf10_cy_per_mm: Option<f64>,
    /// Nyquist frequency, half a cycle per pixel, in cycles per mm.
    nyquist_cy_per_mm: Option<f64>,
}

impl MeasuredEdge {
    pub(super) fn new((region, response): ([usize; 4], EdgeResponse), pitch_m: Option<[f64; 2]>) -> Self {
        let per_mm = pitch_m.map(|pitch_m| response.cycles_per_mm(pitch_m));
        let in_mm = |f: Option<f64>| f.zip(per_mm).map(|(f, per_mm)| f * per_mm);
        Self {
            region,
            pixel_pitch_um: pitch_m.map(|pitch| pitch.map(|m| (m * 1e9).round() / 1e3)),
            frequency_cy_per_mm: per_mm.map(|per_mm| response.frequency_cy_per_px.iter().map(|f| f * per_mm).collect()),
            mtf50_cy_per_mm: in_mm(response.mtf50_cy_per_px),
            mtf10_cy_per_mm: in_mm(response.mtf10_cy_per_px),
            nyquist_cy_per_mm: in_mm(Some(0.5)),
            response,
        }
    }

    /// Standard error of the edge's MTF by its noise, where that makes the curve ragged.
    fn ragged(&self) -> Option<f64> {
        Some(self.response.standard_error_at_half_nyquist).filter(|error| *error > RAGGED)
    }

    fn side(&self) -> &'static str {
        if self.response.is_vertical { "columns" } else { "rows" }
    }
}

/// Warning of edges whose noise makes the curve ragged.
pub(super) fn noise_warning(edges: &[MeasuredEdge]) -> Option<String> {
    let ragged: Vec<f64> = edges.iter().filter_map(MeasuredEdge::ragged).collect();
    let largest = ragged.iter().copied().fold(0.0, f64::max);
    let whose = match (edges.len(), ragged.len()) {
        (_, 0) => return None,
        (1, _) => String::new(),
        (all, some) => format!(" of {some} of {all} edges"),
    };
    Some(format!(
        "noise of the pixels leaves a standard error of {largest:.3} in the MTF{whose} at 0.25 cycles per pixel: take longer \
         edges, a brighter exposure or, of a render, more samples per pixel (--spp)"
    ))
}

/// Text about edges: a single one with its curve, several in a table.
pub(super) fn edges_text(edges: &[MeasuredEdge]) -> String {
    let unknown = if edges.iter().any(|edge| edge.pixel_pitch_um.is_none()) {
        "\n\nThe pixel pitch is not known; --pitch-um gives frequencies in line pairs per mm, too."
    } else {
        ""
    };
    let text = if let [edge] = edges { edge_text(edge) } else { table(edges) };
    text + unknown
}

/// Frequency in both units.
fn frequency(per_px: Option<f64>, per_mm: Option<f64>) -> String {
    let Some(per_px) = per_px else { return "not reached".to_owned() };
    let in_mm = per_mm.map_or_else(String::new, |per_mm| format!(", {per_mm:.2} lp/mm"));
    format!("{per_px:.4} cycles per pixel{in_mm}")
}

fn edge_text(edge: &MeasuredEdge) -> String {
    let response = &edge.response;
    let mut text = format!(
        "edge {:.2}° off the {}\nMTF50  {}\nMTF10  {}\nat {}  {:.4}\nstandard error at 0.25 cycles per pixel  {:.4}\n\n",
        response.angle_deg,
        edge.side(),
        frequency(response.mtf50_cy_per_px, edge.mtf50_cy_per_mm),
        frequency(response.mtf10_cy_per_px, edge.mtf10_cy_per_mm),
        frequency(Some(0.5), edge.nyquist_cy_per_mm),
        response.at_nyquist,
        response.standard_error_at_half_nyquist
    );
    text += "cycles per pixel  ";
    text += if edge.frequency_cy_per_mm.is_some() { "   lp/mm  MTF" } else { "MTF" };
    let shown = (0..response.mtf.len()).step_by(5).filter(|i| response.frequency_cy_per_px[*i] <= 0.5);
    for i in shown {
        let in_mm = edge.frequency_cy_per_mm.as_ref().map_or_else(String::new, |all| format!("  {:>8.2}", all[i]));
        text += &format!("\n{:>16.2}{in_mm}  {:.4}", response.frequency_cy_per_px[i], response.mtf[i]);
    }
    text
}

fn table(edges: &[MeasuredEdge]) -> String {
    let mut text = format!(
        "{:>22}  {:>15}  {:>17}  {:>17}  {:>7}  {:>14}",
        "region", "off the", "MTF50 cy/px lp/mm", "MTF10 cy/px lp/mm", "Nyquist", "standard error"
    );
    let pair = |px: Option<f64>, mm: Option<f64>| {
        let number = |x: Option<f64>, digits: usize| x.map_or_else(|| "–".to_owned(), |x| format!("{x:.digits$}"));
        format!("{} {:>7}", number(px, 4), number(mm, 2))
    };
    for edge in edges {
        let response = &edge.response;
        text += &format!(
            "\n{:>22}  {:>6.2}° {:>7}  {:>17}  {:>17}  {:>7.4}  {:>14.4}",
            edge.region.map(|n| n.to_string()).join(","),
            response.angle_deg,
            edge.side(),
            pair(response.mtf50_cy_per_px, edge.mtf50_cy_per_mm),
            pair(response.mtf10_cy_per_px, edge.mtf10_cy_per_mm),
            response.at_nyquist,
            response.standard_error_at_half_nyquist
        );
    }
    text
}

/// Format of a plot, by the extension of its name.
#[derive(Clone, Copy)]
pub(super) enum PlotFormat {
    Svg,
    Png,
}

impl PlotFormat {
    pub(super) fn of(path: &Path) -> Result<Self> {
        match path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase().as_str() {
            "svg" => Ok(Self::Svg),
            "png" => Ok(Self::Png),
            other => Err(Error::Usage {
                message: format!("{}: a plot cannot be written as {other:?}", path.display()),
                help: Some("write it to a .svg or a .png file".into()),
            }),
        }
    }

    /// File of a plot of edges.
    pub(super) fn file(self, edges: &[MeasuredEdge]) -> Vec<u8> {
        let chart = chart(edges);
        match self {
            Self::Svg => chart.svg().into_bytes(),
            Self::Png => chart.png(),
        }
    }
}

/// Chart of the edges' modulation over frequency, with that of a square pixel alone.
fn chart(edges: &[MeasuredEdge]) -> Chart {
    // In mm only where all of them are known.
    let per_mm =
        edges.iter().map(|edge| edge.nyquist_cy_per_mm.map(|nyquist| 2.0 * nyquist)).collect::<Option<Vec<f64>>>();
    let last = per_mm.as_ref().map_or(1.0, |all| all.iter().copied().fold(0.0, f64::max));
    let curve = |edge: &MeasuredEdge, label: &str| {
        let frequency = edge.frequency_cy_per_mm.as_ref().filter(|_| per_mm.is_some());
        let frequency = frequency.unwrap_or(&edge.response.frequency_cy_per_px).iter().copied();
        let (mark, colour) = if edge.response.is_vertical { (Mark::Line, BLUE) } else { (Mark::Line, ORANGE) };
        Curve::new(label, mark, colour, frequency.zip(edge.response.mtf.iter().copied()).collect())
    };
    let mut curves = Vec::new();
    for (is_vertical, label) in [(true, "edges along columns"), (false, "edges along rows")] {
        let alike = edges.iter().filter(|edge| edge.response.is_vertical == is_vertical);
        curves.extend(alike.enumerate().map(|(i, edge)| curve(edge, if i == 0 { label } else { "" })));
    }
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (std::f64::consts::PI * x).sin() / (std::f64::consts::PI * x) };
    let pixel = (0..=POINTS).map(|i| f64::from(i) / f64::from(POINTS)).map(|f| (f * last, sinc(f).abs()));
    curves.push(Curve::new("a square pixel alone", Mark::Dashes, GREY, pixel.collect()));
    let most = edges.iter().flat_map(|edge| &edge.response.mtf).copied().fold(1.0, f64::max);
    let unit = if per_mm.is_some() { "cycles per mm" } else { "cycles per pixel" };
    Chart { x: Axis::linear(unit).within(0.0, last), y: Axis::linear("modulation").within(0.0, 1.05 * most), curves }
}
