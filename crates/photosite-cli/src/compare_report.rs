//! Report of `photosite compare` in words.

use photosite_capture::report::{ComparedFile, ComparisonReport, UntestedChannels};
use photosite_measure::validation::{ChannelDifference, Comparison, PixelDifference, Verdict, ZScores};

/// Report as text.
pub(super) fn text(report: &ComparisonReport) -> String {
    let comparison = &report.comparison;
    let mut blocks = vec![files(report), errors(comparison)];
    blocks.extend(z_scores(comparison));
    if !comparison.worst.is_empty() {
        blocks.push(worst(&comparison.worst));
    }
    blocks.extend(report.picture.as_ref().map(|p| {
        let ends = format!("darkest blue −{0} and below, darkest red +{0} and above", p.range);
        format!("{} shows {}: {ends}, white no difference, yellow no number", p.file, p.shows)
    }));
    blocks.push(outcome(report));
    blocks.join("\n\n")
}

fn files(report: &ComparisonReport) -> String {
    let [width, height] = report.comparison.resolution_px;
    let line = |letter: &str, f: &ComparedFile| {
        let variances = if f.variances { ", with variances" } else { "" };
        let unit = f.unit.as_deref().unwrap_or("unit not stated");
        format!("{letter}  {}: {width} × {height}, {}, {unit}{variances}", f.file, f.channels.join(" "))
    };
    line("A", &report.a) + "\n" + &line("B", &report.b)
}

fn errors(comparison: &Comparison) -> String {
    let header = [
        "channel",
        "mean A",
        "mean B",
        "difference",
        "",
        "RMSE",
        "MAE",
        "relative MSE",
        "PSNR dB",
        "peak",
        "not finite",
    ];
    let row = |c: &ChannelDifference| {
        let percent = format!("{:+.3} %", c.mean_difference_percent);
        let numbers = [c.mean_a, c.mean_b, c.mean_difference].map(digits);
        let errors = [c.rmse, c.mae, c.relative_mse].map(digits);
        let [a, b, difference] = numbers;
        let [rmse, mae, relative] = errors;
        let psnr = format!("{:.2}", c.psnr_db);
        vec![
            c.channel.clone(),
            a,
            b,
            difference,
            percent,
            rmse,
            mae,
            relative,
            psnr,
            digits(c.peak),
            c.non_finite.to_string(),
        ]
    };
    let rows = table(&header, comparison.channels.iter().map(row).collect());
    format!("{rows}\nrelative MSE: mean of (a − b)²/(b² + {}·mean(b)²)", comparison.epsilon)
}

/// Z-scores of the channels whose variances are known, next to those of N(0, 1).
fn z_scores(comparison: &Comparison) -> Option<String> {
    let known: Vec<(&str, &ZScores)> =
        comparison.channels.iter().filter_map(|c| Some((&c.channel[..], c.z_scores.as_ref()?))).collect();
    let (_, first) = known.first()?;
    let header = [
        "z-scores",
        "pixels",
        "z of the mean",
        "mean z",
        "spread",
        "|z| > 2",
        "> 3",
        "> 4",
        "largest",
        "KS distance",
        "p",
    ];
    let percent = |x: f64| format!("{:.4} %", 100.0 * x);
    let row = |&(name, z): &(&str, &ZScores)| {
        let [two, three, four] = z.tails.map(|tail| percent(tail.fraction));
        let [mean, spread, distance] = [z.mean, z.spread, z.ks_distance].map(|x| format!("{x:.4}"));
        let largest = format!("{:.2}", z.largest);
        let p = format!("{:.2e}", z.ks_p_value);
        let of_mean = format!("{:+.2}", z.of_mean);
        vec![name.to_owned(), z.tests.to_string(), of_mean, mean, spread, two, three, four, largest, distance, p]
    };
    let mut rows: Vec<_> = known.iter().map(row).collect();
    let [two, three, four] = first.tails.map(|tail| percent(tail.expected));
    let of = |text: &str| text.to_owned();
    rows.push(vec![of("N(0, 1)"), of(""), of(""), of("0"), of("1"), two, three, four, of(""), of("0"), of("")]);
    let mut text = table(&header, rows) + "\nz = (a − b)/√(var a + var b); of the mean Σ(a − b)/√Σ(var a + var b)";
    let sum = |of: fn(&ZScores) -> usize| known.iter().map(|(_, z)| of(z)).sum::<usize>();
    let (equal, different) = (sum(|z| z.equal_without_variance), sum(|z| z.different_without_variance));
    if equal > 0 {
        text += &format!("; {equal} left out, equal without any variance");
    }
    if different > 0 {
        text += &format!("; {different} infinite, different without any variance");
    }
    text += "\nVariances are estimates too: from fewer than about 64 samples per pixel, tails are longer than those of N(0, 1).";
    Some(text)
}

fn worst(pixels: &[PixelDifference]) -> String {
    let tested = pixels.iter().any(|p| p.z.is_some());
    let row = |p: &PixelDifference| {
        let mut cells = vec![format!("({}, {})", p.x, p.y), p.channel.clone()];
        cells.extend([p.a, p.b, p.a - p.b].map(digits));
        if tested {
            cells.push(p.z.map_or_else(String::new, |z| format!("{z:+.2}")));
            cells.push(p.p_value.map_or_else(String::new, |p| format!("{p:.1e}")));
        }
        cells
    };
    let header = ["worst pixels", "channel", "A", "B", "difference", "z", "p"];
    table(&header[..if tested { 7 } else { 5 }], pixels.iter().map(row).collect())
}

fn outcome(report: &ComparisonReport) -> String {
    if report.outcome == "not judged" {
        let [UntestedChannels { missing, help, .. }, ..] = &report.untested[..] else {
            return "not judged: no variances are known and no limit was set".to_owned();
        };
        return format!(
            "not judged: {missing}, so that noise cannot be told from a difference, and no limit was set\n  {help}, or set \
             a limit such as --max-rmse"
        );
    }
    let mut text = report.outcome.to_owned();
    if let Some(Verdict { alpha, tests, z_bound, agree: true, .. }) = &report.comparison.verdict {
        text +=
            &format!("\n  noise explains all pixels and means: |z| ≤ {z_bound:.2} (Šidák, α = {alpha}, {tests} tests)");
    }
    let untested = |u: &UntestedChannels| {
        format!("not tested against noise: {}, since {}; {}", u.channels.join(", "), u.missing, u.help)
    };
    let lines = report.failures.iter().cloned().chain(report.untested.iter().map(untested));
    lines.fold(text, |text, line| text + "\n  " + &line)
}

/// Table with columns as wide as needed: names to the left, numbers to the right.
fn table(header: &[&str], rows: Vec<Vec<String>>) -> String {
    let header: Vec<String> = header.iter().map(|&cell| cell.to_owned()).collect();
    let lines: Vec<Vec<String>> = std::iter::once(header).chain(rows).collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
    let pad = |(column, cell): (usize, &String)| match column {
        0 => format!("{cell:<0$}", widths[0]),
        _ => format!("{cell:>0$}", widths[column]),
    };
    let line = |cells: &Vec<String>| {
        let text = cells.iter().enumerate().map(pad).collect::<Vec<_>>().join("  ");
        text.trim_end().to_owned()
    };
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Number with six significant digits, without an exponent where few zeros suffice.
fn digits(x: f64) -> String {
    let exponent = x.abs().log10().floor();
    if x == 0.0 || !x.is_finite() {
        format!("{x}")
    } else if (-4.0..6.0).contains(&exponent) {
        format!("{x:.0$}", (5.0 - exponent) as usize)
    } else {
        format!("{x:.5e}")
    }
}
