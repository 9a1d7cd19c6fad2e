//! The page.

use std::fmt::Write;

use crate::characterisation::{Evaluation, Figures, NotMeasured, Row, SpatialStack};

use super::curves::{self, Plot, digits};
use super::points::{SpectralPoint, ThermalPoint};

/// All that a page tells.
#[derive(Clone, Debug)]
pub struct Report {
    /// Name of the sensor.
    pub sensor: String,
    /// What it is, in a sentence; may be empty.
    pub description: String,
    /// What else a reader should know, such as the size of the images: names and values.
    pub conditions: Vec<(String, String)>,
    /// What was measured of each channel.
    pub channels: Vec<ChannelReport>,
}

/// What was measured of one channel.
#[derive(Clone, Debug)]
pub struct ChannelReport {
    /// Its name, with what light it was measured in.
    pub title: String,
    /// The figures that were put in, where they are known.
    pub expected: Option<Figures>,
    /// The figures that came out, with their curves.
    pub evaluation: Evaluation,
    /// The dark and the bright stack, where there are any.
    pub stacks: Option<[SpatialStack; 2]>,
    /// Quantum efficiency at other wavelengths.
    pub spectral: Vec<SpectralPoint>,
    /// Dark current at several temperatures.
    pub thermal: Vec<ThermalPoint>,
    /// Rise of temperature that doubles the dark current, K: expected and measured.
    pub doubling_temperature_k: Option<[f64; 2]>,
}

const STYLE: &str = "
body { margin: 0 auto; max-width: 1180px; padding: 2rem 1.5rem 4rem; color: #282c34; background: #fff;
  font: 15px/1.5 Helvetica, Arial, sans-serif; }
h1 { font-size: 1.7rem; margin: 0; } h2 { font-size: 1.25rem; margin: 2.6rem 0 .8rem; border-bottom: 2px solid #1f5fa8; }
.subtitle { margin: .2rem 0 1rem; color: #5a606b; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .1rem 1.2rem; margin: 0; }
dt { color: #5a606b; } dd { margin: 0; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .22rem .7rem; border-bottom: 1px solid #e4e7ec; text-align: left; font-weight: normal; }
thead th { color: #5a606b; border-bottom: 2px solid #c9ced6; } td.n, th.n { text-align: right; }
tr.part th { padding-left: 2rem; color: #5a606b; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(420px, 1fr)); gap: 1.4rem; margin-top: 1.6rem; }
figure { margin: 0; border: 1px solid #e4e7ec; border-radius: 6px; padding: .7rem .8rem; break-inside: avoid; }
figure svg { width: 100%; height: auto; display: block; } figcaption { color: #5a606b; font-size: .87rem; }
figcaption strong { color: #282c34; font-size: .98rem; }
footer { margin-top: 3rem; color: #5a606b; font-size: .85rem; }
";

impl Report {
    /// The page as HTML, which refers to nothing outside itself.
    pub fn html(&self) -> String {
        let mut html = String::new();
        let sensor = escaped(&self.sensor);
        let _ = write!(
            html,
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
             content=\"width=device-width\">\n<title>{sensor}: EMVA 1288</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
             <h1>{sensor}</h1>\n<p class=\"subtitle\">{}Characterised after EMVA 1288, release 4.0 linear.</p>\n<dl>\n",
            if self.description.is_empty() { String::new() } else { escaped(&self.description) + "<br>" }
        );
        for (name, value) in &self.conditions {
            let _ = writeln!(html, "<dt>{}</dt><dd>{}</dd>", escaped(name), escaped(value));
        }
        html += "</dl>\n";
        for channel in &self.channels {
            let _ = writeln!(html, "<h2>{}</h2>", escaped(&channel.title));
            html += &channel.table();
            for NotMeasured { figure, reason } in channel.evaluation.not_measured() {
                let _ = writeln!(html, "<p>Not measured: {}; {}.</p>", escaped(figure), escaped(reason));
            }
            html += "<div class=\"plots\">\n";
            for Plot { title, caption, chart } in channel.plots() {
                let _ = writeln!(
                    html,
                    "<figure>\n<figcaption><strong>{title}.</strong> {}</figcaption>\n{}</figure>",
                    escaped(&caption),
                    chart.svg()
                );
            }
            html += "</div>\n";
        }
        let version = env!("CARGO_PKG_VERSION");
        let _ = write!(html, "<footer>photosite {version}</footer>\n</body>\n</html>\n");
        html
    }
}

impl ChannelReport {
    fn plots(&self) -> Vec<Plot> {
        let e = &self.evaluation;
        let mut plots = vec![curves::photon_transfer(e), curves::snr(e), curves::responsivity(e)];
        plots.extend(curves::linearity(e));
        plots.extend(curves::quantum_efficiency(&self.spectral));
        plots.extend(curves::temperature(&self.thermal));
        plots.extend(curves::dark_signal(e));
        if let (Some(stacks), Some(variances)) = (&self.stacks, &e.spatial) {
            plots.extend(curves::non_uniformity(&e.figures, stacks, variances));
        }
        plots
    }

    /// Expected and measured figures side by side.
    fn table(&self) -> String {
        let mut html = "<table>\n<thead><tr><th>figure</th><th>symbol</th><th>unit</th><th class=\"n\">measured</th>\
                        <th class=\"n\">expected</th><th class=\"n\">deviation</th></tr></thead>\n<tbody>\n"
            .to_owned();
        for line in self.lines() {
            let class = if line.measured.name.starts_with("of which") { " class=\"part\"" } else { "" };
            let Row { name, symbol, unit, value } = line.measured;
            let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |x| digits(x, 5));
            let _ = writeln!(
                html,
                "<tr{class}><th>{name}</th><td>{}</td><td>{unit}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{}</td></tr>",
                subscripts(symbol),
                cell(value),
                cell(line.expected),
                line.deviation()
            );
        }
        html + "</tbody>\n</table>\n"
    }

    /// The lines of the table.
    pub fn lines(&self) -> Vec<Comparison> {
        let measured = self.evaluation.figures.rows();
        let expected = self.expected.map(|figures| figures.rows());
        let mut lines: Vec<Comparison> = measured
            .iter()
            .enumerate()
            .map(|(i, &measured)| Comparison { measured, expected: expected.as_ref().and_then(|rows| rows[i].value) })
            .collect();
        if let Some([expected, measured]) = self.doubling_temperature_k {
            let (name, symbol, unit) = ("Doubling temperature of the dark current", "T_d", "K");
            let measured = Row { name, symbol, unit, value: Some(measured) };
            lines.push(Comparison { measured, expected: Some(expected) });
        }
        lines
    }
}

/// A line of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// What was measured.
    pub measured: Row,
    /// What was put in, where it is known.
    pub expected: Option<f64>,
}

impl Comparison {
    /// How far the measured figure is from the expected one, in words: percent of it, or the difference from nothing.
    pub fn deviation(&self) -> String {
        match (self.measured.value, self.expected) {
            (Some(measured), Some(expected)) if expected != 0.0 && !["dB", "bit"].contains(&self.measured.unit) => {
                format!("{:+.2} %", 100.0 * (measured / expected - 1.0))
            }
            (Some(measured), Some(expected)) => format!("{:+.4}", measured - expected),
            (Some(_) | None, Some(_) | None) => String::new(),
        }
    }
}

/// `μ_y.dark` as μ with an index.
fn subscripts(symbol: &str) -> String {
    match symbol.split_once('_') {
        Some((letter, index)) => format!("<i>{letter}</i><sub>{index}</sub>"),
        None => format!("<i>{symbol}</i>"),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
