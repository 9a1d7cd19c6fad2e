//! Pages that need nothing besides themselves.

use std::fmt::Write;

use super::plot::Plot;

/// Colours and letters of all pages of photosite, dark or light as the reader has set it.
pub const LOOK: &str = include_str!("look.css");

const STYLE: &str = "
body { margin: 0 auto; max-width: 1180px; padding: 2rem 1.5rem 4rem; }
h1 { font-size: 1.7rem; margin: 0; } h2 { font-size: 1.25rem; margin: 2.6rem 0 .8rem; border-bottom: 2px solid var(--accent); }
.subtitle { margin: .2rem 0 1rem; color: var(--faint); }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .1rem 1.2rem; margin: 0; }
dt { color: var(--faint); } dd { margin: 0; overflow-wrap: anywhere; }
.table { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .22rem .7rem; border-bottom: 1px solid var(--line); text-align: left; font-weight: normal; }
thead th { color: var(--faint); border-bottom-width: 2px; } td.n, th.n { text-align: right; }
tr.part th { padding-left: 2rem; color: var(--faint); }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(420px, 100%), 1fr)); gap: 1.4rem; margin-top: 1.6rem; }
figure { margin: 0; background: var(--panel); border: 1px solid var(--line); border-radius: 6px; padding: .7rem .8rem; break-inside: avoid; }
figure svg { width: 100%; height: auto; display: block; border-radius: 4px; } figcaption { color: var(--faint); font-size: .87rem; }
figcaption strong { color: var(--text); font-size: .98rem; }
footer { margin-top: 3rem; color: var(--faint); font-size: .85rem; }
/* Plots are drawn on white: turned over, hues stay. */
@media screen and (prefers-color-scheme: dark) { figure svg { filter: invert(.88) hue-rotate(180deg); } }
";

/// A page of this title, whose body is HTML.
pub fn page(title: &str, body: &str) -> String {
    let (title, version) = (escaped(title), env!("CARGO_PKG_VERSION"));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n<style>{LOOK}{STYLE}</style>\n</head>\n<body>\n{body}\
         <footer>photosite {version}</footer>\n</body>\n</html>\n"
    )
}

/// Names and values.
pub fn conditions(conditions: &[(String, String)]) -> String {
    let mut html = "<dl>\n".to_owned();
    for (name, value) in conditions {
        let _ = writeln!(html, "<dt>{}</dt><dd>{}</dd>", escaped(name), escaped(value));
    }
    html + "</dl>\n"
}

/// Plots with their captions.
pub fn figures(plots: &[Plot]) -> String {
    let mut html = "<div class=\"plots\">\n".to_owned();
    for Plot { title, caption, chart } in plots {
        let _ = writeln!(
            html,
            "<figure>\n<figcaption><strong>{title}.</strong> {}</figcaption>\n{}</figure>",
            escaped(caption),
            chart.svg()
        );
    }
    html + "</div>\n"
}

/// Text with HTML's special characters escaped.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
