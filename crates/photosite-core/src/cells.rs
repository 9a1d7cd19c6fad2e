//! Cells of an image sensor: the place of each on the sensor, and whether it lies in the image circle.
//!
//! Places are continuous pixel coordinates: pitches from the top-left corner along a row, rows downwards. Rectangular
//! cells stand in columns. Rows of hexagonal cells are staggered: every second one, from the second on, lies half a
//! pitch farther to the right, and a cell holds all places nearer to its centre than to any other. With the pitch p
//! along rows and the distance q between them that is, about the centre,
//!
//! |x| ≤ p/2,  |y| ≤ q·(½ + a − 4·a·|x|/p),  a = (p/q)²/8
//!
//! a hexagon of the area p·q, regular for q = p·√3/2 (the lattice that samples an isotropic image with the fewest
//! cells, [Mersereau79](crate::references#mersereau79)). The cells are valid for q ≥ p/2: closer rows have neighbours
//! beyond the next one.

use glam::DVec2;

/// Distance of the rows of regular hexagons over their pitch, √3/2.
pub const REGULAR_ROWS: f64 = 0.866_025_403_784_438_6;

/// The cells of a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CellLayout {
    /// Shape of all cells.
    pub shape: CellShape,
    /// The part of the sensor that sees light; `None` for all of it.
    pub image_circle: Option<ImageCircle>,
}

/// The shape of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CellShape {
    /// Rectangles in rows and columns.
    #[default]
    Rectangular,
    /// Hexagons in staggered rows.
    Hexagonal(Hexagon),
}

/// A hexagonal cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hexagon {
    /// a of the module's equation, 0 to ½.
    slant: f64,
}

/// A circle on the sensor; cells with their centres in it see light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageCircle {
    /// Centre in pixels: columns from the left edge, rows from the top.
    pub centre_px: DVec2,
    /// Radius in pitches along a row, and in row distances across.
    pub radii_px: DVec2,
}

impl Hexagon {
    /// Hexagon of a pitch along rows and a distance between rows, in one unit; `None` where rows lie closer than half a
    /// pitch.
    pub fn new([pitch, rows]: [f64; 2]) -> Option<Self> {
        let slant = (pitch / rows).powi(2) / 8.0;
        (rows > 0.0 && slant <= 0.5).then_some(Self { slant })
    }

    /// Centre of the neighbouring cell that a place in a cell's bounding rectangle belongs to, relative to the cell's
    /// own centre; `None` where the place is the cell's own.
    #[inline]
    fn neighbour(self, about_centre: DVec2) -> Option<DVec2> {
        let DVec2 { x, y } = about_centre;
        let is_outside = y.abs() > 0.5 + self.slant - 4.0 * self.slant * x.abs();
        is_outside.then(|| DVec2::new(0.5f64.copysign(x), 1f64.copysign(y)))
    }
}

impl ImageCircle {
    /// Circle of a diameter about the middle of a sensor of `size` columns and rows; diameter and pitch in one unit.
    pub fn new(diameter: f64, size: [usize; 2], pitch: [f64; 2]) -> Self {
        let half = |axis: usize| size[axis] as f64 / 2.0;
        Self {
            centre_px: DVec2::new(half(0), half(1)),
            radii_px: DVec2::new(diameter / pitch[0], diameter / pitch[1]) / 2.0,
        }
    }

    /// Whether a place, px, lies in the circle.
    #[inline]
    pub fn contains(&self, place: DVec2) -> bool {
        ((place - self.centre_px) / self.radii_px).length_squared() <= 1.0
    }
}

impl CellLayout {
    /// Whether every second row lies half a pitch farther to the right.
    #[inline]
    pub fn is_staggered(&self) -> bool {
        match self.shape {
            CellShape::Rectangular => false,
            CellShape::Hexagonal(_) => true,
        }
    }

    /// Place in a cell (column and row) for two numbers in [0, 1): uniform numbers give places uniform over the cell.
    /// The rectangle about a hexagonal cell covers it but for corners that belong to its neighbours; places in these
    /// move to the opposite sides.
    #[inline]
    pub fn place(&self, [column, row]: [usize; 2], within: [f64; 2]) -> DVec2 {
        let corner = DVec2::new(column as f64, row as f64);
        let within = DVec2::from_array(within);
        match self.shape {
            CellShape::Rectangular => corner + within,
            CellShape::Hexagonal(hexagon) => {
                let place = corner + DVec2::new(shift(row as f64), 0.0) + within;
                place - hexagon.neighbour(within - 0.5).unwrap_or(DVec2::ZERO)
            }
        }
    }

    /// The centre of a cell, column and row.
    #[inline]
    pub fn centre(&self, cell: [usize; 2]) -> DVec2 {
        self.place(cell, [0.5; 2])
    }

    /// Column and row, whole numbers, of the cell that a place belongs to; beside the sensor, of the cell that would be
    /// there.
    #[inline]
    pub fn cell_at(&self, place: DVec2) -> DVec2 {
        match self.shape {
            CellShape::Rectangular => place.floor(),
            CellShape::Hexagonal(hexagon) => {
                let row = place.y.floor();
                let column = (place.x - shift(row)).floor();
                let centre = DVec2::new(column + shift(row), row) + 0.5;
                match hexagon.neighbour(place - centre) {
                    None => DVec2::new(column, row),
                    Some(way) => {
                        let centre = centre + way - 0.5;
                        DVec2::new(centre.x - shift(centre.y), centre.y)
                    }
                }
            }
        }
    }

    /// Whether the cell that a place belongs to sees light.
    #[inline]
    pub fn sees_light(&self, place: DVec2) -> bool {
        let Some(circle) = &self.image_circle else { return true };
        let cell = self.cell_at(place);
        let shift = if self.is_staggered() { shift(cell.y) } else { 0.0 };
        circle.contains(cell + DVec2::new(0.5 + shift, 0.5))
    }
}

/// Shift of a row of staggered cells to the right, in pitches: 0 or ½.
#[inline]
pub fn shift(row: f64) -> f64 {
    0.5 * row.rem_euclid(2.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 240;

    fn hexagonal(rows: f64) -> CellLayout {
        CellLayout { shape: CellShape::Hexagonal(Hexagon::new([1.0, rows]).expect("far enough")), image_circle: None }
    }

    /// Evenly spaced numbers, with the cells' centres between them and none on a corner.
    fn within() -> impl Iterator<Item = [f64; 2]> {
        let at = |i: usize| (i as f64 + 0.43) / N as f64;
        (0..N * N).map(move |i| [at(i % N), at(i / N)])
    }

    /// The second moments of a regular hexagon of the width p, 5/72·p² along both axes (of a square they are p²/12),
    /// show that places fill a cell; each place is nearest to the centre of its own cell.
    #[test]
    fn places_fill_the_hexagon_and_know_their_cell() {
        for rows in [0.6, REGULAR_ROWS, 1.0, 1.7] {
            let layout = hexagonal(rows);
            for cell in [[3, 4], [3, 5]] {
                let centre = layout.centre(cell);
                assert_eq!(centre, DVec2::new(3.5 + 0.5 * (cell[1] % 2) as f64, cell[1] as f64 + 0.5));
                let (mut sum, mut squares) = (DVec2::ZERO, DVec2::ZERO);
                for numbers in within() {
                    let place = layout.place(cell, numbers);
                    let found = layout.cell_at(place);
                    assert_eq!(found, DVec2::new(cell[0] as f64, cell[1] as f64), "{place} of {rows}");
                    let metric = |d: DVec2| d * DVec2::new(1.0, rows);
                    let own = metric(place - centre);
                    for (x, y) in [(1.0, 0.0), (-1.0, 0.0), (0.5, 1.0), (-0.5, 1.0), (0.5, -1.0), (-0.5, -1.0)] {
                        assert!(own.length() <= metric(place - centre - DVec2::new(x, y)).length() + 1e-12);
                    }
                    sum += own;
                    squares += own * own;
                }
                let count = (N * N) as f64;
                // The grid is 0.07 of its step off the middle; pieces that change sides have that error, too.
                assert!((sum / count).length() < 1.0 / N as f64, "{}", sum / count);
                if rows == REGULAR_ROWS {
                    // Strips of the grid that the edges cut: 1/N of the whole.
                    let error = (squares / count / (5.0 / 72.0) - 1.0).abs();
                    assert!(error.max_element() < 1.0 / N as f64, "{error}");
                }
            }
        }
    }

    #[test]
    fn rows_that_are_too_close_make_no_hexagons() {
        assert!(Hexagon::new([1.0, 0.5]).is_some());
        assert!([0.49, 0.0, -1.0, f64::NAN].iter().all(|&rows| Hexagon::new([1.0, rows]).is_none()));
    }

    #[test]
    fn cells_with_their_centre_in_the_circle_see_light() {
        let layout = |shape| CellLayout { shape, image_circle: Some(ImageCircle::new(8.0, [10, 8], [1.0, 2.0])) };
        let square = layout(CellShape::Rectangular);
        // Radii of 4 columns and 2 rows about 5, 4.
        let seen = |x: f64, y: f64| square.sees_light(DVec2::new(x, y));
        assert!(seen(1.0, 4.0) && !seen(0.99, 4.0) && seen(5.0, 2.0) && !seen(5.0, 1.99));
        let hexagonal = layout(hexagonal(2.0).shape);
        // The centre of the first cell of the second row lies at 1, that of the fourth row's second one at 2.
        let count = |layout: CellLayout, row: usize| {
            (0..10).filter(|&column| layout.sees_light(layout.centre([column, row]))).count()
        };
        assert_eq!((count(square, 3), count(square, 4)), (8, 8));
        // Centres at 1.5 … 8.5 of even rows, at 2 … 8 of odd ones: (x − 5)²/16 + (½)²/4 ≤ 1 ends at 5 ± 3.87.
        assert_eq!((count(hexagonal, 3), count(hexagonal, 4)), (7, 8));
    }
}
