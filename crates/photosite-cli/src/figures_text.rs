//! Figures of EMVA 1288 as text: expected and measured ones of image sets.

use super::print::rounded;
use photosite_files::image_sets::ImageSets;
use photosite_measure::characterisation::Row;
use photosite_measure::characterisation::report::{ChannelReport, PairReport, PairedFigure, Report};

/// Expected figures of a sensor's image sets, a column for each channel.
pub(super) fn expected_text(sets: &ImageSets) -> String {
    let heads: Vec<String> =
        sets.channels.iter().map(|c| format!("{} at {} nm", c.channel, rounded(c.wavelength_nm, 6))).collect();
    let columns: Vec<Vec<Row>> = sets.channels.iter().map(|c| c.expected.rows()).collect();
    let title =
        format!("{}: expected of {} × {} pixels at {} dB", sets.sensor, sets.size_px[0], sets.size_px[1], sets.gain_db);
    format!("{title}\n\n{}", table(&heads, &columns))
}

/// Table of rows of figures, side by side.
fn table(heads: &[String], columns: &[Vec<Row>]) -> String {
    let Some(first) = columns.first() else { return String::new() };
    let cell = |row: Row| row.cell(|x| rounded(x, 5).to_string());
    let mut grid = vec![[vec![String::new(); 3], heads.to_vec()].concat()];
    for (i, Row { name, symbol, unit, .. }) in first.iter().enumerate() {
        let values = columns.iter().map(|column| cell(column[i]));
        grid.push([name, symbol, unit].iter().map(|s| (**s).to_owned()).chain(values).collect());
    }
    aligned(&grid)
}

/// Lines of cells in aligned columns: three of words, then numbers.
fn aligned(grid: &[Vec<String>]) -> String {
    let width = |column: usize| grid.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..grid[0].len()).map(width).collect();
    let line = |cells: &Vec<String>| {
        let cells = cells
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(i, (cell, &width))| if i < 3 { format!("{cell:width$}") } else { format!("{cell:>width$}") });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    grid.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Measured figures of image sets, next to the expected ones, as text.
pub(super) fn measured_text(report: &Report) -> String {
    let channel = |channel: &ChannelReport| {
        let cell = |row: Row| row.cell(|x| rounded(x, 5).to_string());
        let mut lines = vec![["", "", "", "measured", "expected", "deviation"].map(str::to_owned).to_vec()];
        for line in channel.lines() {
            let Row { name, symbol, unit, .. } = line.measured;
            let expected = Row { value: line.expected, bound: None, ..line.measured };
            lines.push(vec![
                name.to_owned(),
                symbol.to_owned(),
                unit.to_owned(),
                cell(line.measured),
                cell(expected),
                line.deviation(),
            ]);
        }
        let missing = channel.evaluation.not_measured().into_iter();
        let missing: String = missing.map(|n| format!("\nnot measured: {}; {}", n.figure, n.reason)).collect();
        let notes: String = channel.notes().into_iter().map(|note| format!("\n{note}")).collect();
        format!("{}\n{}{missing}{notes}", channel.title, aligned(&lines))
    };
    report.channels.iter().map(channel).collect::<Vec<_>>().join("\n\n")
}

/// Figures of two image sets side by side, as text.
pub(super) fn paired_text(pair: &PairReport) -> String {
    let names = pair.sets.each_ref().map(|(name, _)| name.as_str());
    let channel = |(title, figures): (&str, Vec<PairedFigure>)| {
        let head = ["", "", "", names[0], names[1], "difference", "standard errors"];
        let mut lines = vec![head.map(str::to_owned).to_vec()];
        for PairedFigure { first: Row { name, symbol, unit, value, .. }, second, difference, in_errors } in figures {
            let cell = |value: Option<f64>, digits| value.map_or("–".to_owned(), |x| rounded(x, digits).to_string());
            let score = in_errors.map_or("–".to_owned(), |z| format!("{z:+.1}"));
            let values = [cell(value, 5), cell(second, 5), cell(difference, 3), score];
            lines.push([name, symbol, unit].map(str::to_owned).into_iter().chain(values).collect());
        }
        format!("{title}\n{}", aligned(&lines))
    };
    pair.channels().map(channel).collect::<Vec<_>>().join("\n\n")
}
