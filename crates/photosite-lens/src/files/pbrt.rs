//! pbrt's realistic camera: radius, thickness, index and diameter of each surface.

use super::draft::{Draft, Fault, Medium, Read, Row};
use super::text::number;
use crate::checks::MOST_SURFACES;
use crate::files::draft::too_many_surfaces;
use crate::files::patent::patent_in;

/// Reads a file.
pub(super) fn read(text: &str) -> Read<Draft> {
    let mut draft = Draft { last_gap_is_unused: true, ..Draft::default() };
    let mut numbers: Vec<(usize, f64)> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let (values, comment) = line.split_once('#').unwrap_or((line, ""));
        // The first comment is the title.
        if draft.name.is_empty() {
            draft.name = comment.trim().to_owned();
        }
        if draft.patent.is_none() {
            draft.patent = patent_in(comment);
        }
        for word in values.split_whitespace() {
            let value = number(word).ok_or_else(|| {
                Fault::at(i + 1, format!("{word} is not a number"))
                    .help("each surface is its radius, its thickness, the index behind it and its diameter")
            })?;
            numbers.push((i + 1, value));
        }
        if numbers.len() > 4 * MOST_SURFACES {
            return Err(too_many_surfaces(i + 1));
        }
    }
    if numbers.is_empty() || !numbers.len().is_multiple_of(4) {
        let message = format!("{} numbers, which are not four for each surface", numbers.len());
        return Err(Fault::of_file(message)
            .help("each surface is its radius, its thickness, the index behind it and its diameter"));
    }
    let quadruples = || numbers.chunks_exact(4);
    let [first, last] = [quadruples().next(), quadruples().last()].map(|surface| surface.map_or(0.0, |s| s[1].1));
    if first == 0.0 && last != 0.0 && numbers.len() > 4 {
        return Err(Fault::at(
            numbers[1].0,
            "the first thickness is 0 and the last is not: an old file, whose numbers are the gaps before the surfaces",
        )
        .help("move each thickness up to the surface before it, and put the distance to the film last"));
    }
    for (i, surface) in quadruples().enumerate() {
        let [(line, radius), (_, thickness_mm), (_, index), (_, diameter)] =
            [surface[0], surface[1], surface[2], surface[3]];
        let medium = if index == 0.0 || index == 1.0 { Medium::Air } else { Medium::Index(index) };
        draft.rows.push(Row {
            line: Some(line),
            name: format!("surface {}", i + 1),
            radius_mm: (radius != 0.0).then_some(radius),
            thickness_mm,
            medium,
            semi_aperture_mm: Some(diameter / 2.0),
            is_stop: radius == 0.0,
            ..Row::default()
        });
    }
    draft.assume("lengths are mm, and each index holds at all wavelengths: pbrt's lenses have no dispersion");
    draft.assume("a radius of 0 is the stop: pbrt's files have no flat glass");
    Ok(draft)
}
