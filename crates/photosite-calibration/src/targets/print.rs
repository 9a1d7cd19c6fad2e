//! Targets on paper: SVG and PDF in true size, as one page without a margin of its own.
//!
//! In: a [`Target`]. Out: the bytes of the file. The printer must not scale it ("actual size", 100 %).

use std::fmt::Write;

use glam::DVec2;
use pdf_writer::{Content, Finish, Pdf, Rect, Ref};

use super::{Outline, Target};
use photosite_core::Invalid;

/// PDF's unit: 1/72 inch.
const POINTS_PER_M: f64 = 72.0 / 0.0254;
/// The longest side of a page that PDF 1.7 knows (ISO 32000-1, annex C), points.
const LONGEST_PAGE: f64 = 14_400.0;
/// Control points of the cubic curve that stands for a quarter of a circle, over its radius: it leaves the circle by
/// 3·10⁻⁴ of the radius.
const KAPPA: f64 = 0.552_284_749_830_793_6;

/// Draws shapes as they follow each other in the same ink; what touches becomes one path, without seams between.
fn paths(target: &Target) -> impl Iterator<Item = (usize, &[super::Shape])> {
    target.shapes.chunk_by(|a, b| a.ink == b.ink).map(|shapes| (shapes[0].ink, shapes))
}

/// An SVG document in millimetres.
pub fn svg(target: &Target, title: &str) -> String {
    let size = target.size_m() * 1e3;
    let mm = |p: DVec2| (p - target.sheet[0]) * 1e3;
    let colour = |ink: usize| {
        let [r, g, b] = target.inks[ink].print;
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    let [width, height] = [number(size.x), number(size.y)];
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" \
         viewBox=\"0 0 {width} {height}\">\n<title>{}</title>\n<path fill=\"{}\" d=\"M0 0H{width}V{height}H0Z\"/>\n",
        escaped(title),
        colour(0)
    );
    for (ink, shapes) in paths(target) {
        let _ = write!(text, "<path fill=\"{}\" d=\"", colour(ink));
        for shape in shapes {
            match &shape.outline {
                Outline::Polygon(corners) => {
                    for (i, corner) in corners.iter().enumerate() {
                        let p = mm(*corner);
                        let _ = write!(text, "{}{} {}", if i == 0 { 'M' } else { 'L' }, number(p.x), number(p.y));
                    }
                    text.push('Z');
                }
                Outline::Disc { centre, radius } => {
                    let (c, r) = (mm(*centre), number(radius * 1e3));
                    let [left, right, y] = [number(c.x - radius * 1e3), number(c.x + radius * 1e3), number(c.y)];
                    let _ = write!(text, "M{left} {y}A{r} {r} 0 0 1 {right} {y}A{r} {r} 0 0 1 {left} {y}Z");
                }
            }
        }
        text.push_str("\"/>\n");
    }
    text + "</svg>\n"
}

/// As many decimals of a millimetre as a nanometre needs.
fn number(mm: f64) -> String {
    let text = format!("{mm:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A PDF document of one page.
pub fn pdf(target: &Target, title: &str) -> Result<Vec<u8>, Invalid> {
    let size = target.size_m() * POINTS_PER_M;
    if size.max_element() > LONGEST_PAGE {
        let metres = LONGEST_PAGE / POINTS_PER_M;
        let message = format!("{:.2} m is longer than a PDF page can be", target.size_m().max_element());
        return Err(Invalid::new("", message).help(format!("at most {metres:.2} m; write SVG instead")));
    }
    let [catalog, pages, page, contents, info] = [1, 2, 3, 4, 5].map(Ref::new);
    // PDF's y points up.
    let point = |p: DVec2| {
        let p = (p - target.sheet[0]) * POINTS_PER_M;
        [p.x as f32, (size.y - p.y) as f32]
    };
    let mut content = Content::new();
    let fill = |content: &mut Content, ink: usize| {
        let [r, g, b] = target.inks[ink].print.map(|value| f32::from(value) / 255.0);
        if r == g && g == b {
            content.set_fill_gray(r);
        } else {
            content.set_fill_rgb(r, g, b);
        }
    };
    fill(&mut content, 0);
    content.rect(0.0, 0.0, size.x as f32, size.y as f32).fill_nonzero();
    for (ink, shapes) in paths(target) {
        fill(&mut content, ink);
        for shape in shapes {
            match &shape.outline {
                Outline::Polygon(corners) => {
                    for (i, corner) in corners.iter().enumerate() {
                        let [x, y] = point(*corner);
                        if i == 0 {
                            content.move_to(x, y)
                        } else {
                            content.line_to(x, y)
                        };
                    }
                }
                Outline::Disc { centre, radius } => {
                    let at = |x: f64, y: f64| point(*centre + DVec2::new(x, y) * *radius);
                    let [x, y] = at(1.0, 0.0);
                    content.move_to(x, y);
                    for quarter in 0..4 {
                        let turn = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
                        let ([cx, cy], [sx, sy]) = (turn[quarter], turn[(quarter + 1) % 4]);
                        let [x1, y1] = at(cx + KAPPA * sx, cy + KAPPA * sy);
                        let [x2, y2] = at(sx + KAPPA * cx, sy + KAPPA * cy);
                        let [x3, y3] = at(sx, sy);
                        content.cubic_to(x1, y1, x2, y2, x3, y3);
                    }
                }
            }
            content.close_path();
        }
        content.fill_nonzero();
    }
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let mut sheet = pdf.page(page);
    sheet.media_box(Rect::new(0.0, 0.0, size.x as f32, size.y as f32)).parent(pages).contents(contents);
    sheet.resources();
    sheet.finish();
    pdf.stream(contents, &content.finish());
    pdf.document_info(info).title(pdf_writer::TextStr(title));
    Ok(pdf.finish())
}
