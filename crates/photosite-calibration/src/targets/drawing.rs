//! A target as a drawing: inks, shapes over paper, points and markers.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use photosite_core::spectrum::{Spectrum, cie, illuminant, library, rgb};

/// A flat target in its own frame (x right, y down, metres).
#[derive(Clone, Debug)]
pub struct Target {
    /// Top-left and bottom-right corner of the sheet.
    pub sheet: [DVec2; 2],
    /// The first is that of the sheet.
    pub inks: Vec<Ink>,
    /// Later ones lie over earlier ones. Their edges may touch, but not cross.
    pub shapes: Vec<Shape>,
    /// The points that a calibration finds, in OpenCV's order.
    pub points: Vec<Point>,
    /// The markers, by their place on the board.
    pub markers: Vec<Marker>,
}

/// What a part of a target is covered with. A matt surface.
#[derive(Clone, Debug)]
pub struct Ink {
    /// Name within the target.
    pub name: String,
    /// Spectral reflectance, 0–1.
    pub reflectance: Spectrum,
    /// Colour in files for printers, sRGB.
    pub print: [u8; 3],
}

/// A part of the sheet in another ink.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Edge of the shape.
    pub outline: Outline,
    /// Index of its ink.
    pub ink: usize,
}

/// The edge of a shape.
#[derive(Clone, Debug)]
pub enum Outline {
    /// A simple polygon.
    Polygon(Vec<DVec2>),
    /// A disc.
    Disc {
        /// Middle of the shape.
        centre: DVec2,
        /// m.
        radius: f64,
    },
}

/// A point that is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Name within the target: its number, or what it is the corner of.
    pub name: String,
    /// In the frame of the target, m.
    pub position_m: DVec2,
}

/// A marker.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// OpenCV's name of the dictionary.
    pub dictionary: &'static str,
    /// Number in the dictionary.
    pub id: u32,
    /// Clockwise from the marker's own top-left corner, as OpenCV detects them, m.
    pub corners_m: [DVec2; 4],
}

impl Ink {
    /// White, unless a material of the capture file says otherwise: the white patch of the ColorChecker.
    pub fn white() -> Self {
        Self { print: [255; 3], ..Self::named("white", "colour-checker/19-white") }
    }

    /// Black, unless a material of the capture file says otherwise: the black patch of the ColorChecker.
    pub fn black() -> Self {
        Self { print: [0; 3], ..Self::named("black", "colour-checker/24-black") }
    }

    /// With a reflectance of the library.
    pub fn named(name: &str, reflectance: &str) -> Self {
        let spectrum = library::reflectance(reflectance).expect("the library's reflectances are part of the program");
        Self::of_spectrum(name, spectrum)
    }

    /// The same reflectance at all wavelengths.
    pub fn grey(name: impl Into<String>, reflectance: f64) -> Self {
        Self::of_spectrum(name, Spectrum::constant(reflectance as f32))
    }

    fn of_spectrum(name: impl Into<String>, reflectance: Spectrum) -> Self {
        let print = linear_srgb(&reflectance).map(|value| (rgb::encode(value as f32) * 255.0).round() as u8);
        Self { name: name.into(), reflectance, print }
    }

    /// For programs that know no spectra: linear sRGB under D65, 0–1.
    pub fn linear_srgb(&self) -> [f64; 3] {
        linear_srgb(&self.reflectance)
    }
}

/// The colour of a surface under D65, linear, 0–1; what lies outside of sRGB is clipped.
fn linear_srgb(reflectance: &Spectrum) -> [f64; 3] {
    let light = illuminant::d65();
    let white = cie::xyz(light)[1];
    let xyz = cie::xyz(&reflectance.product(light)).map(|value| value / white);
    let linear = *rgb::xyz_to_rgb() * DVec3::from_array(xyz);
    linear.to_array().map(|value| value.clamp(0.0, 1.0))
}

impl Target {
    /// An empty sheet of the first ink.
    pub(super) fn sheet(top_left: DVec2, bottom_right: DVec2, inks: Vec<Ink>) -> Self {
        Self { sheet: [top_left, bottom_right], inks, shapes: Vec::new(), points: Vec::new(), markers: Vec::new() }
    }

    /// Width and height of the sheet, m.
    pub fn size_m(&self) -> DVec2 {
        self.sheet[1] - self.sheet[0]
    }

    pub(super) fn add_rectangle(&mut self, top_left: DVec2, bottom_right: DVec2, ink: usize) {
        let [a, c] = [top_left, bottom_right];
        self.add_polygon(vec![a, DVec2::new(c.x, a.y), c, DVec2::new(a.x, c.y)], ink);
    }

    pub(super) fn add_square(&mut self, top_left: DVec2, side: f64, ink: usize) {
        self.add_rectangle(top_left, top_left + side, ink);
    }

    pub(super) fn add_polygon(&mut self, corners: Vec<DVec2>, ink: usize) {
        self.shapes.push(Shape { outline: Outline::Polygon(corners), ink });
    }

    pub(super) fn add_disc(&mut self, centre: DVec2, radius: f64, ink: usize) {
        self.shapes.push(Shape { outline: Outline::Disc { centre, radius }, ink });
    }

    pub(super) fn add_point(&mut self, name: impl Into<String>, position_m: DVec2) {
        self.points.push(Point { name: name.into(), position_m });
    }

    /// A point named by its number.
    pub(super) fn add_next_point(&mut self, position_m: DVec2) {
        self.add_point(self.points.len().to_string(), position_m);
    }

    /// Takes the middle of the sheet as the origin.
    pub(super) fn centred(mut self) -> Self {
        let middle = (self.sheet[0] + self.sheet[1]) / 2.0;
        let moved = |p: &mut DVec2| *p -= middle;
        self.sheet.iter_mut().for_each(moved);
        for shape in &mut self.shapes {
            match &mut shape.outline {
                Outline::Polygon(corners) => corners.iter_mut().for_each(moved),
                Outline::Disc { centre, radius: _ } => moved(centre),
            }
        }
        self.points.iter_mut().for_each(|point| moved(&mut point.position_m));
        self.markers.iter_mut().flat_map(|marker| &mut marker.corners_m).for_each(moved);
        self
    }
}

/// Sides of the polygon that stands for a disc.
const DISC_SIDES: u32 = 128;

impl Outline {
    /// The corners of the polygon that stands for it in a mesh. That of a disc has 128 sides and the disc's own area
    /// and middle; it leaves the circle by no more than 2·10⁻⁴ of the radius.
    pub fn corners(&self) -> Vec<DVec2> {
        match self {
            Self::Polygon(corners) => corners.clone(),
            Self::Disc { centre, radius } => {
                let step = TAU / f64::from(DISC_SIDES);
                let circumradius = radius * (step / step.sin()).sqrt();
                let corner = |i: u32| *centre + circumradius * DVec2::from_angle((f64::from(i) + 0.5) * step);
                (0..DISC_SIDES).map(corner).collect()
            }
        }
    }
}
