//! Plots of curves and points as SVG and as PNG.

use std::sync::Once;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
pub use plotters::prelude::RGBColor;

use plotters::prelude::{
    BitMapBackend, ChartBuilder, Circle, DashedLineSeries, DrawingArea, DrawingAreaErrorKind, DrawingBackend,
    FontStyle, IntoDrawingArea, IntoFont, IntoLogRange, LineSeries, PathElement, Ranged, SVGBackend, ShapeStyle, Text,
    WHITE,
};
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Measured points and the first of the lines.
pub const BLUE: RGBColor = RGBColor(31, 95, 168);
/// Fits and expectations.
pub const ORANGE: RGBColor = RGBColor(213, 94, 0);
/// Limits.
pub const GREY: RGBColor = RGBColor(120, 120, 120);
/// A third line.
pub const GREEN: RGBColor = RGBColor(0, 130, 100);
const INK: RGBColor = RGBColor(40, 44, 52);
const GRID: RGBColor = RGBColor(222, 225, 230);
const FINE_GRID: RGBColor = RGBColor(241, 243, 246);

/// The plotting library rounds positions to whole units, so there are more of them than pixels of a screen.
const SIZE: (u32, u32) = (1440, 960);
/// Font that SVG asks for; [`FONT_FILE`] is registered under this name.
const FONT: &str = "Helvetica, Arial, sans-serif";
/// The letters of PNG, by which those of SVG are placed, too: DejaVu Sans, reduced to what plots need.
const FONT_FILE: &[u8] = include_bytes!("../../../assets/fonts/DejaVuSans-plots.ttf");
/// Strokes of a broken line; [`GAP`] lies between them.
const DASH: u32 = 14;
const GAP: u32 = 10;
/// Margin at the left, for the labels of the vertical axis; [`RIGHT`] stays free at the right.
const LEFT: u32 = 150;
const RIGHT: u32 = 40;
/// Drawn pixels along each side of a pixel of a PNG, which is their mean: edges are smooth.
const FINER: usize = 2;

/// An axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Label of the axis, with its unit.
    pub label: String,
    /// Whether steps of the axis are powers of ten.
    pub logarithmic: bool,
    /// Range of the axis; `None` for one that holds all points.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// Axis with even steps.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), logarithmic: false, range: None }
    }

    /// Axis whose steps are powers of ten.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { label: label.into(), logarithmic: true, range: None }
    }

    /// Limits the axis to a range.
    #[must_use]
    pub fn within(mut self, from: f64, to: f64) -> Self {
        self.range = Some([from, to]);
        self
    }
}

/// Mark by which a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Dots.
    Points,
    /// A line.
    Line,
    /// A broken line.
    Dashes,
}

/// Points that belong together.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Label in the legend; empty for none.
    pub label: String,
    /// Mark of the points.
    pub mark: Mark,
    /// Colour of the curve.
    pub colour: RGBColor,
    /// Points of the curve.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    fn style(&self) -> ShapeStyle {
        ShapeStyle { color: self.colour.into(), filled: self.mark == Mark::Points, stroke_width: 4 }
    }

    /// A series.
    pub fn new(label: impl Into<String>, mark: Mark, colour: RGBColor, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), mark, colour, points }
    }
}

/// A plot.
#[derive(Clone, Debug)]
pub struct Chart {
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// Curves. The legend stands above, where none of them can be.
    pub curves: Vec<Curve>,
}

type DrawResult<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

impl Chart {
    /// The plot as an `svg` element. Points that an axis cannot show are left out.
    pub fn svg(&self) -> String {
        let mut svg = String::new();
        let drawn = self.draw_on(&SVGBackend::with_string(&mut svg, SIZE).into_drawing_area());
        // Drawing into memory cannot run out of anything.
        drawn.unwrap_or_else(|error| panic!("cannot draw the plot of {}: {error}", self.y.label));
        svg
    }

    /// The plot as a PNG file of half the size.
    pub fn png(&self) -> Vec<u8> {
        let [width, height] = [SIZE.0, SIZE.1].map(|side| side as usize);
        let mut fine = vec![0; 3 * width * height];
        let drawn = self.draw_on(&BitMapBackend::with_buffer(&mut fine, SIZE).into_drawing_area());
        drawn.unwrap_or_else(|error| panic!("cannot draw the plot of {}: {error}", self.y.label));
        let size = [width / FINER, height / FINER];
        let mean = |i: usize| {
            let (pixel, component) = (i / 3, i % 3);
            let (x, y) = (pixel % size[0] * FINER, pixel / size[0] * FINER);
            let at = |k: usize| usize::from(fine[3 * ((y + k / FINER) * width + x + k % FINER) + component]);
            let sum: usize = (0..FINER * FINER).map(at).sum();
            ((sum + FINER * FINER / 2) / (FINER * FINER)) as u8
        };
        let pixels: Vec<u8> = (0..3 * size[0] * size[1]).map(mean).collect();
        png_file(size.map(|side| side as u32), &pixels).expect("memory takes a whole file")
    }

    fn draw_on<'a, B: DrawingBackend + 'a>(&self, area: &DrawingArea<B, Shift>) -> DrawResult<B> {
        provide_font();
        let shown = |&(x, y): &(f64, f64)| {
            x.is_finite() && y.is_finite() && (!self.x.logarithmic || x > 0.0) && (!self.y.logarithmic || y > 0.0)
        };
        let curves: Vec<Curve> = self
            .curves
            .iter()
            .map(|curve| Curve { points: curve.points.iter().copied().filter(shown).collect(), ..curve.clone() })
            .collect();
        let all = || curves.iter().flat_map(|curve| curve.points.iter());
        let x = bounds(&self.x, all().map(|p| p.0));
        let y = bounds(&self.y, all().map(|p| p.1));
        let [x, y] = [x, y].map(|[from, to]| from..to);
        match (self.x.logarithmic, self.y.logarithmic) {
            (false, false) => self.draw(area, &curves, x, y),
            (true, false) => self.draw(area, &curves, x.log_scale(), y),
            (false, true) => self.draw(area, &curves, x, y.log_scale()),
            (true, true) => self.draw(area, &curves, x.log_scale(), y.log_scale()),
        }
    }

    fn draw<'a, B, X, Y>(&self, area: &DrawingArea<B, Shift>, curves: &[Curve], x: X, y: Y) -> DrawResult<B>
    where
        B: DrawingBackend + 'a,
        X: AsRangedCoord<Value = f64> + Clone,
        Y: AsRangedCoord<Value = f64> + Clone,
        X::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
        Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    {
        area.fill(&WHITE)?;
        let above = draw_legend(area, curves)?;
        let mut chart = ChartBuilder::on(area)
            .margin_top(24 + above)
            .margin_right(RIGHT)
            .margin_bottom(12)
            .margin_left(12)
            .x_label_area_size(100)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(x, y)?;
        let text = |size: u32| (FONT, size).into_font().color(&INK);
        chart
            .configure_mesh()
            .bold_line_style(GRID)
            .light_line_style(FINE_GRID)
            .axis_style(ShapeStyle { color: INK.into(), filled: false, stroke_width: 2 })
            .x_labels(8)
            .y_labels(8)
            .label_style(text(30))
            .axis_desc_style(text(34))
            .x_desc(self.x.label.as_str())
            .y_desc(self.y.label.as_str())
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .draw()?;
        for curve in curves {
            let style = curve.style();
            let points = curve.points.iter().copied();
            match curve.mark {
                Mark::Points => chart.draw_series(points.map(|p| Circle::new(p, 7, style)))?,
                Mark::Line => chart.draw_series(LineSeries::new(points, style))?,
                Mark::Dashes => chart.draw_series(DashedLineSeries::new(points, DASH, GAP, style))?,
            };
        }
        area.present()
    }
}

/// Draws what the curves are called, side by side from the left, in as many rows as that takes, and returns their height.
fn draw_legend<'a, B: DrawingBackend + 'a>(
    area: &DrawingArea<B, Shift>,
    curves: &[Curve],
) -> Result<u32, DrawingAreaErrorKind<B::ErrorType>> {
    const ROW: i32 = 44;
    const SAMPLE: i32 = (2 * DASH + GAP) as i32;
    const BEFORE_TEXT: i32 = 14;
    const BETWEEN: i32 = 44;
    let (first, end) = (LEFT as i32 + 12, (SIZE.0 - RIGHT) as i32);
    let text = (FONT, 30).into_font();
    let (mut x, mut rows) = (first, 0);
    for curve in curves.iter().filter(|curve| !curve.label.is_empty()) {
        // Without its letters, those of a usual width stand for it.
        let letters = curve.label.chars().count() as u32;
        let width = text.box_size(&curve.label).map_or(18 * letters, |(width, _)| width) as i32;
        let whole = SAMPLE + BEFORE_TEXT + width;
        if rows == 0 || x + whole > end {
            (x, rows) = (first, rows + 1);
        }
        let y = 12 + ROW * rows - ROW / 2;
        let style = curve.style();
        match curve.mark {
            Mark::Points => area.draw(&Circle::new((x + SAMPLE / 2, y), 7, style))?,
            Mark::Line => area.draw(&PathElement::new(vec![(x, y), (x + SAMPLE, y)], style))?,
            Mark::Dashes => {
                for from in [x, x + (DASH + GAP) as i32] {
                    area.draw(&PathElement::new(vec![(from, y), (from + DASH as i32, y)], style))?;
                }
            }
        }
        let middle = text.color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(curve.label.clone(), (x + SAMPLE + BEFORE_TEXT, y), middle))?;
        x += whole + BETWEEN;
    }
    Ok((ROW * rows) as u32)
}

/// Registers the font once.
fn provide_font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let registered = register_font(FONT, FontStyle::Normal, FONT_FILE);
        registered.unwrap_or_else(|_| panic!("the font that comes along is whole"));
    });
}

fn png_file([width, height]: [u32; 2], rgb: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(file)
}

/// The ends of an axis: what was asked for, or what holds all values with a little room.
fn bounds(axis: &Axis, values: impl Iterator<Item = f64>) -> [f64; 2] {
    if let Some(range) = axis.range {
        return range;
    }
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
    match (low.is_finite() && high.is_finite(), axis.logarithmic) {
        (false, true) => [0.1, 10.0],
        (false, false) => [0.0, 1.0],
        // Whole decades, so that there are at least two labels.
        (true, true) => [low.log10().floor(), (high * 1.001).log10().ceil()].map(|exponent| 10f64.powf(exponent)),
        (true, false) => {
            let room = if high > low { 0.04 * (high - low) } else { low.abs().max(1.0) };
            // What begins at nothing is shown from nothing.
            let low = if low >= 0.0 && low < 0.1 * high { 0.0 } else { low - room };
            [low, high + room]
        }
    }
}

/// A number at an axis: powers of ten where they are shorter.
fn tick(value: &f64) -> String {
    let magnitude = value.abs();
    // Next to nothing is what rounding errors left of nothing.
    if magnitude < 1e-14 {
        return "0".to_owned();
    }
    if (1e-3..1e5).contains(&magnitude) {
        // Ticks lie at round numbers, which rounding errors must not show.
        let digits = (5.0 - magnitude.max(1e-3).log10().floor()).clamp(0.0, 9.0) as usize;
        let text = format!("{value:.digits$}");
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        return text.to_owned();
    }
    let exponent = magnitude.log10().floor() as i32;
    let mantissa = value / 10f64.powi(exponent);
    let power: String = exponent.to_string().chars().map(superscript).collect();
    if (mantissa - 1.0).abs() < 1e-6 {
        format!("10{power}")
    } else {
        format!("{}·10{power}", (mantissa * 1e3).round() / 1e3)
    }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32(c as u32 - '0' as u32 + 0x2070).unwrap_or(c),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_short() {
        for (value, text) in [
            (0.0, "0"),
            (-2.2e-16, "0"),
            (0.1 + 0.2, "0.3"),
            (-0.02, "-0.02"),
            (12_000.0, "12000"),
            (1e5, "10⁵"),
            (2.5e-4, "2.5·10⁻⁴"),
            (1e-12, "10⁻¹²"),
        ] {
            assert_eq!(tick(&value), text);
        }
    }

    #[test]
    fn any_points_can_be_drawn() {
        let axes: [fn(&'static str) -> Axis; 2] = [|label| Axis::linear(label), |label| Axis::logarithmic(label)];
        for x in axes {
            for y in axes {
                for points in [vec![], vec![(1.0, 1.0)], vec![(0.0, -1.0), (f64::NAN, 2.0), (3.0, f64::INFINITY)]] {
                    let curves = [Mark::Points, Mark::Line, Mark::Dashes]
                        .map(|mark| Curve::new("curve", mark, BLUE, points.clone()))
                        .to_vec();
                    let (x, y) = (x("time in s"), y("signal in DN"));
                    let chart = Chart { x, y, curves };
                    let svg = chart.svg();
                    assert!(svg.starts_with("<svg") && svg.contains("signal in DN"), "{svg}");
                    let decoder = png::Decoder::new(std::io::Cursor::new(chart.png()));
                    let mut reader = decoder.read_info().expect("a PNG file");
                    let mut pixels = vec![0; 3 * 720 * 480];
                    let info = reader.next_frame(&mut pixels).expect("whole");
                    assert_eq!((info.width, info.height), (720, 480));
                    // Letters and lines take a part of it.
                    let dark = pixels.iter().filter(|&&v| v < 128).count();
                    assert!((3000..100_000).contains(&dark), "{dark}");
                }
            }
        }
    }
}
