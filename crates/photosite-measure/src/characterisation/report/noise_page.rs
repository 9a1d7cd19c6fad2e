//! The page of estimates of noise, and its plots.

use std::fmt::Write;

use serde::Serialize;

use super::html::{self, escaped};
use super::noise_curves::plots;
use super::plot::Plot;
use crate::characterisation::noise::{NoiseEstimate, figures};

/// The noise of images.
#[derive(Clone, Debug, Serialize)]
pub struct NoiseReport {
    /// The files.
    pub files: Vec<String>,
    /// Left, top, width, height of what was looked at, in the active area where there is one.
    pub patch_px: [usize; 4],
    /// The pixels of the file that are looked at, where masked ones are left out: left, top, width, height.
    pub active_area_px: Option<[usize; 4]>,
    /// Unit of the pixel values, where the file states it.
    pub unit: Option<String>,
    /// Each channel, or of a mosaic each place in its tile.
    pub planes: Vec<PlaneNoise>,
}

/// One channel, or the pixels of one place in the tile of a mosaic.
#[derive(Clone, Debug, Serialize)]
pub struct PlaneNoise {
    /// Name of the channel.
    pub name: String,
    /// Estimate of the channel's noise.
    #[serde(flatten)]
    pub estimate: NoiseEstimate,
}

impl NoiseReport {
    /// Unit of the pixel values in texts: empty where it is unknown.
    pub fn unit(&self) -> &str {
        let unit = self.unit.as_deref().unwrap_or("");
        if unit.starts_with("codes") { "codes" } else { unit }
    }

    /// The page as HTML, which refers to nothing outside itself.
    pub fn html(&self) -> String {
        let [x, y, width, height] = self.patch_px;
        let mut conditions = vec![
            ("Images".to_owned(), self.files.join(", ")),
            ("Patch".to_owned(), format!("{width} × {height} pixels at {x}, {y}")),
        ];
        if let Some([x, y, width, height]) = self.active_area_px {
            conditions.push(("Active area".to_owned(), format!("{width} × {height} pixels at {x}, {y}")));
        }
        let mut html = "<h1>Noise</h1>\n".to_owned();
        html += &html::conditions(&conditions);
        for PlaneNoise { name, estimate } in &self.planes {
            let _ = writeln!(html, "<h2>{}</h2>\n<table>\n<tbody>", escaped(name));
            for (figure, value) in figures(estimate, self.unit()) {
                let _ = writeln!(html, "<tr><th>{}</th><td>{}</td></tr>", escaped(figure), escaped(&value));
            }
            html += "</tbody>\n</table>\n";
            let plots: Vec<Plot> = plots(estimate, self.unit()).into_iter().map(|(_, plot)| plot).collect();
            html += &html::figures(&plots);
        }
        html::page("Noise", &html)
    }

    /// All plots as PNG files, with their names without extension, such as `R-sigma-map`.
    pub fn png_plots(&self) -> Vec<(String, Vec<u8>)> {
        let of_plane = |PlaneNoise { name, estimate }: &PlaneNoise| {
            let place: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
            let place = place.replace("--", "-");
            let named = move |(kind, plot): (&'static str, Plot)| (format!("{place}-{kind}"), plot.chart.png());
            plots(estimate, self.unit()).into_iter().map(named).collect::<Vec<_>>()
        };
        self.planes.iter().flat_map(of_plane).collect()
    }
}
