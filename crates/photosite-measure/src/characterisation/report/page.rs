//! The page.

use std::fmt::Write;

use crate::characterisation::{Evaluation, Figures, NotMeasured, Row, SpatialStack};

use super::curves;
use super::html::{self, escaped};
use super::plot::{Plot, digits};
use super::points::{SpectralPoint, ThermalPoint};

/// Report on a characterised sensor: one page.
#[derive(Clone, Debug)]
pub struct Report {
    /// Name of the sensor.
    pub sensor: String,
    /// Description of the sensor, in a sentence; may be empty.
    pub description: String,
    /// Further conditions, such as the size of the images: names and values.
    pub conditions: Vec<(String, String)>,
    /// Results of each channel.
    pub channels: Vec<ChannelReport>,
}

/// Results of one channel.
#[derive(Clone, Debug)]
pub struct ChannelReport {
    /// Name of the channel, with the light that it was measured in.
    pub title: String,
    /// Pixels of every image.
    pub pixels: usize,
    /// Figures of the sensor's model, where they are known.
    pub expected: Option<Figures>,
    /// Measured figures, with their curves.
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

impl Report {
    /// The page as HTML, which refers to nothing outside itself.
    pub fn html(&self) -> String {
        let description = if self.description.is_empty() { String::new() } else { escaped(&self.description) + "<br>" };
        let mut html = format!(
            "<h1>{}</h1>\n<p class=\"subtitle\">{description}Characterised after EMVA 1288, release 4.0 linear.</p>\n",
            escaped(&self.sensor)
        );
        html += &html::conditions(&self.conditions);
        for channel in &self.channels {
            let _ = writeln!(html, "<h2>{}</h2>", escaped(&channel.title));
            html += &channel.table();
            for NotMeasured { figure, reason } in channel.evaluation.not_measured() {
                let _ = writeln!(html, "<p>Not measured: {}; {}.</p>", escaped(figure), escaped(&reason));
            }
            for note in channel.notes() {
                let _ = writeln!(html, "<p>{}</p>", escaped(&note));
            }
            html += &html::figures(&channel.plots());
        }
        html::page(&format!("{}: EMVA 1288", self.sensor), &html)
    }
}

impl ChannelReport {
    pub(super) fn plots(&self) -> Vec<Plot> {
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
        let mut html = "<div class=\"table\">\n<table>\n<thead><tr><th>figure</th><th>symbol</th><th>unit</th><th class=\"n\">measured</th>\
                        <th class=\"n\">expected</th><th class=\"n\">deviation</th></tr></thead>\n<tbody>\n"
            .to_owned();
        for line in self.lines() {
            let class = if line.measured.name.starts_with("of which") { " class=\"part\"" } else { "" };
            let Row { name, symbol, unit, .. } = line.measured;
            let expected = Row { value: line.expected, bound: None, ..line.measured };
            let cell = |row: Row| escaped(&row.cell(|x| digits(x, 5)));
            let _ = writeln!(
                html,
                "<tr{class}><th>{name}</th><td>{}</td><td>{unit}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
                 <td class=\"n\">{}</td></tr>",
                subscripts(symbol),
                cell(line.measured),
                cell(expected),
                line.deviation()
            );
        }
        html + "</tbody>\n</table>\n</div>\n"
    }

    /// Notes on figures that are not what they are expected to be.
    pub fn notes(&self) -> Vec<String> {
        let Some(expected) = self.expected else { return Vec::new() };
        let e = &self.evaluation;
        let number = e.saturation + 1;
        let percent = 100.0 * (e.figures.saturation_e / expected.saturation_e - 1.0);
        vec![format!(
            "Saturation capacity: the standard takes the bright pair of the largest variance (pair {number} of {}, {} e⁻), \
             where the first pixels are full; expected is the signal at which all are, {} e⁻ ({percent:+.1} %).",
            e.points.len(),
            digits(e.figures.saturation_e, 5),
            digits(expected.saturation_e, 5)
        )]
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
            let measured = Row { name, symbol, unit, value: Some(measured), bound: None };
            lines.push(Comparison { measured, expected: Some(expected) });
        }
        lines
    }
}

/// A line of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Measured figure.
    pub measured: Row,
    /// Expected value, from the sensor's model, where it is known.
    pub expected: Option<f64>,
}

impl Comparison {
    /// Deviation of the measured figure from the expected one, in words: percent of it, or the difference from nothing.
    pub fn deviation(&self) -> String {
        // Of a figure that is not known, none is.
        match (self.measured.value.filter(|_| self.measured.bound.is_none()), self.expected) {
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
