//! The page, which the program carries in itself.

use hyper::StatusCode;

use super::answer::{Answer, of_bytes, refused};
use photosite_measure::characterisation::report::LOOK;

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Files of the page: names, media types and texts.
const FILES: [(&str, &str, &str); 19] = [
    ("", HTML, include_str!("page/index.html")),
    ("look.css", CSS, LOOK),
    ("view.css", CSS, include_str!("page/view.css")),
    ("view.js", SCRIPT, include_str!("page/view.js")),
    ("session.js", SCRIPT, include_str!("page/session.js")),
    ("status.js", SCRIPT, include_str!("page/status.js")),
    ("images.js", SCRIPT, include_str!("page/images.js")),
    ("inspect.js", SCRIPT, include_str!("page/inspect.js")),
    ("light.js", SCRIPT, include_str!("page/light.js")),
    ("pointer.js", SCRIPT, include_str!("page/pointer.js")),
    ("server.js", SCRIPT, include_str!("page/server.js")),
    ("stage.js", SCRIPT, include_str!("page/stage.js")),
    ("colours.js", SCRIPT, include_str!("page/colours.js")),
    ("controls.js", SCRIPT, include_str!("page/controls.js")),
    ("measure.js", SCRIPT, include_str!("page/measure.js")),
    ("camera.js", SCRIPT, include_str!("page/camera.js")),
    ("sheet.css", CSS, include_str!("page/sheet.css")),
    ("sheet.js", SCRIPT, include_str!("page/sheet.js")),
    ("overlays.js", SCRIPT, include_str!("page/overlays.js")),
];
/// Page of a data set. Its images are looked at, one at a time, on the page of other inputs, under this name.
const SHEET: &str = include_str!("page/sheet.html");
const ONE_OF_SHEET: &str = "frame";

/// A file of the page, of that of a data set where `has_sheet`.
pub(super) fn file(name: &str, has_sheet: bool) -> Answer {
    let name = match name {
        "" if has_sheet => return of_bytes(HTML, SHEET),
        ONE_OF_SHEET if has_sheet => "",
        other => other,
    };
    match FILES.iter().find(|(known, ..)| *known == name) {
        Some((_, media_type, text)) => of_bytes(media_type, *text),
        None => refused(StatusCode::NOT_FOUND, "there is nothing at this address"),
    }
}
