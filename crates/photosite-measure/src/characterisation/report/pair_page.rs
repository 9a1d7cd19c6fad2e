//! Two image sets side by side: each figure of both with its difference in standard errors, and their curves in one plot.

use std::fmt::Write;

use photosite_core::Invalid;

use super::chart::{BLUE, Chart, Curve, Mark, ORANGE};
use super::html::{self, escaped};
use super::page::{ChannelReport, Report};
use super::plot::{Plot, digits};
use crate::characterisation::{RelativeErrors, Row};

/// Reports of two image sets with the same channels.
#[derive(Clone, Debug)]
pub struct PairReport {
    /// Names and reports of both.
    pub sets: [(String, Report); 2],
}

/// Figure of two sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairedFigure {
    /// Figure of the first.
    pub first: Row,
    /// Value of the second.
    pub second: Option<f64>,
    /// Difference of the second from the first.
    pub difference: Option<f64>,
    /// The same in standard errors, where the images tell these.
    pub in_errors: Option<f64>,
}

impl PairReport {
    /// Two reports under their names.
    ///
    /// # Errors
    ///
    /// Reports of different numbers of channels.
    pub fn new(sets: [(String, Report); 2]) -> Result<Self, Invalid> {
        let [first, second] = [0, 1].map(|i| sets[i].1.channels.len());
        if first != second {
            let message = format!("{first} channels and {second} channels cannot stand side by side");
            return Err(Invalid::new("", message).help("give descriptors of one channel each"));
        }
        Ok(Self { sets })
    }

    /// Channels of both with their figures.
    pub fn channels(&self) -> impl Iterator<Item = (&str, Vec<PairedFigure>)> {
        let [first, second] = [0, 1].map(|i| self.sets[i].1.channels.iter());
        first.zip(second).map(|(first, second)| (first.title.as_str(), paired(first, second)))
    }

    /// The page as HTML, which refers to nothing outside itself.
    pub fn html(&self) -> String {
        let [(first, of_first), (second, of_second)] = &self.sets;
        let mut html = format!(
            "<h1>{} and {}</h1>\n<p class=\"subtitle\">Two image sets after EMVA 1288.</p>\n",
            escaped(first),
            escaped(second)
        );
        for ((title, figures), (a, b)) in self.channels().zip(of_first.channels.iter().zip(&of_second.channels)) {
            let _ = writeln!(html, "<h2>{}</h2>", escaped(title));
            html += &table([first, second], &figures);
            let plots: Vec<Plot> =
                a.plots().into_iter().zip(b.plots()).filter_map(|(a, b)| both(a, b, [first, second])).collect();
            html += &html::figures(&plots);
        }
        html::page(&format!("{first} and {second}: EMVA 1288"), &html)
    }
}

fn paired(first: &ChannelReport, second: &ChannelReport) -> Vec<PairedFigure> {
    let errors = [first, second].map(|c| RelativeErrors::new(&c.evaluation, c.pixels as f64, c.stacks.as_ref()));
    let rows = first.evaluation.figures.rows().into_iter().zip(second.evaluation.figures.rows());
    // Errors of dark currents are those of their lines, in DN; electrons err as K does, too, and their variances twice.
    let current = |i: usize, row: &Row| {
        let figures = &[first, second][i].evaluation.figures;
        let (error, power) = match row.symbol {
            "μ_I.mean" => (figures.dark_current_mean_error_e_per_s?, 1.0),
            "μ_I.var" => (figures.dark_current_variance_error_e_per_s?, 2.0),
            _ => return None,
        };
        Some(error.hypot(power * errors[i].gain * row.value?))
    };
    let pair = |(a, b): (Row, Row)| {
        let difference = a.value.zip(b.value).map(|(a, b)| b - a);
        let error = |i: usize, row: &Row| {
            let relative = errors[i].of_row(row.symbol, row.unit).zip(row.value).map(|(r, value)| r * value.abs());
            relative.or_else(|| current(i, row))
        };
        let in_errors = difference.zip(error(0, &a).zip(error(1, &b))).map(|(d, (a, b))| d / a.hypot(b));
        PairedFigure { first: a, second: b.value, difference, in_errors }
    };
    rows.filter(|(row, _)| !row.symbol.is_empty()).map(pair).collect()
}

fn table(names: [&String; 2], figures: &[PairedFigure]) -> String {
    let [first, second] = names.map(|name| escaped(name));
    let mut html = format!(
        "<div class=\"table\">\n<table>\n<thead><tr><th>figure</th><th>symbol</th><th>unit</th><th class=\"n\">{first}</th>\
         <th class=\"n\">{second}</th><th class=\"n\">difference</th><th class=\"n\">in standard errors</th></tr></thead>\n<tbody>\n"
    );
    for PairedFigure { first, second, difference, in_errors } in figures {
        let Row { name, symbol, unit, .. } = first;
        let cell = |value: &Option<f64>, n| value.map_or("–".to_owned(), |x| digits(x, n));
        let _ = writeln!(
            html,
            "<tr><th>{name}</th><td>{symbol}</td><td>{unit}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td></tr>",
            cell(&first.value, 5),
            cell(second, 5),
            cell(difference, 3),
            in_errors.map_or("–".to_owned(), |z| format!("{z:+.1}"))
        );
    }
    html + "</tbody>\n</table>\n</div>\n"
}

/// The measured curves of two plots of the same kind in one, without what was fitted to them. `None` for other pairs.
fn both(first: Plot, second: Plot, names: [&String; 2]) -> Option<Plot> {
    if first.title != second.title {
        return None;
    }
    let range = |a: Option<[f64; 2]>, b: Option<[f64; 2]>| a.zip(b).map(|([a, b], [c, d])| [a.min(c), b.max(d)]);
    let [(x, y), (of_second_x, of_second_y)] = [(&first.chart.x, &first.chart.y), (&second.chart.x, &second.chart.y)];
    let mut axes = [x.clone(), y.clone()];
    axes[0].range = range(x.range, of_second_x.range);
    axes[1].range = range(y.range, of_second_y.range);
    let measured = |curves: Vec<Curve>, name: &String, colour| {
        let main = curves.into_iter().find(|curve| curve.mark != Mark::Dashes && curve.colour == BLUE)?;
        Some(Curve { label: name.clone(), colour, ..main })
    };
    let curves = vec![measured(first.chart.curves, names[0], BLUE)?, measured(second.chart.curves, names[1], ORANGE)?];
    let [x, y] = axes;
    Some(Plot { title: first.title, caption: String::new(), chart: Chart { x, y, curves } })
}
