//! Figures of EMVA 1288 as text: what image sets must show, and what they do show.

use super::print::rounded;
use crate::characterisation::Row;
use crate::characterisation::report::{ChannelReport, Report};
use crate::io::image_sets::ImageSets;

/// The figures that the image sets of a sensor must show, a column for each channel.
pub(super) fn expected_text(sets: &ImageSets) -> String {
    let heads: Vec<String> =
        sets.channels.iter().map(|c| format!("{} at {} nm", c.channel, rounded(c.wavelength_nm, 6))).collect();
    let columns: Vec<Vec<Row>> = sets.channels.iter().map(|c| c.expected.rows()).collect();
    let title =
        format!("{}: expected of {} × {} pixels at {} dB", sets.sensor, sets.size_px[0], sets.size_px[1], sets.gain_db);
    format!("{title}\n\n{}", table(&heads, &columns))
}

/// Rows of figures side by side.
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

/// Cells in columns: three of words, then numbers.
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

/// What image sets show, beside what they are expected to show.
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
