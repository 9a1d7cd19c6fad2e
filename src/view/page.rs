//! The page, which the program carries in itself.

use hyper::StatusCode;

use super::answer::{Answer, of_bytes, refused};

/// Names, media types and texts of its files.
const FILES: [(&str, &str, &str); 3] = [
    ("", "text/html; charset=utf-8", include_str!("page/index.html")),
    ("view.css", "text/css; charset=utf-8", include_str!("page/view.css")),
    ("view.js", "text/javascript; charset=utf-8", include_str!("page/view.js")),
];

/// A file of the page.
pub(super) fn file(name: &str) -> Answer {
    match FILES.iter().find(|(known, ..)| *known == name) {
        Some((_, media_type, text)) => of_bytes(media_type, *text),
        None => refused(StatusCode::NOT_FOUND, "there is nothing at this address"),
    }
}
