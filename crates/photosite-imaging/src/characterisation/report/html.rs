//! Pages that need nothing besides themselves.

use std::fmt::Write;

use super::plot::Plot;

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

/// A page of this title, whose body is HTML.
pub fn page(title: &str, body: &str) -> String {
    let (title, version) = (escaped(title), env!("CARGO_PKG_VERSION"));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{body}\
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

/// Plots with what is said about them.
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

/// Text as HTML has it.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
