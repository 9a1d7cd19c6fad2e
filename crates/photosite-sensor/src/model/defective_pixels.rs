//! Defective pixels of one sensor by their places, from a file, in place of parts of a million.

use std::sync::Arc;

use photosite_core::Invalid;

use super::defects::Defects;

/// What a pixel does in place of what others do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PixelDefect {
    /// More dark current than others at the reference temperature, e⁻/s.
    Hot(f64),
    /// No answer to light.
    Dead,
    /// Always this number, DN.
    Stuck(u16),
}

/// Defective pixels of a sensor by their places.
#[derive(Clone, Debug, PartialEq)]
pub struct DefectivePixels {
    size: [usize; 2],
    /// Pixels by row, then column, shared between the copies of a sensor.
    pixels: Arc<[([usize; 2], PixelDefect)]>,
}

/// First line of the file.
const HEADER: &str = "column,row,kind,value";

impl DefectivePixels {
    /// Pixels of a table of a sensor of these columns and rows, whose converter goes up to `max_dn`.
    ///
    /// # Errors
    ///
    /// Lines of another form, pixels outside of the sensor or named twice, numbers that the converter does not have.
    pub fn parse(text: &str, size: [usize; 2], max_dn: u16) -> Result<Self, Invalid> {
        let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let is_header = |line: &str| line.split(',').map(str::trim).eq(HEADER.split(','));
        if !lines.next().is_some_and(|(_, line)| is_header(line)) {
            return Err(Invalid::new("", "does not begin as a table of defective pixels")
                .help(format!("write the line {HEADER}, then one for each pixel, such as 17,4,hot,250 or 3,9,dead,")));
        }
        let mut pixels = Vec::new();
        for (number, line) in lines {
            pixels.push(pixel(line, size, max_dn).map_err(|Invalid { message, help, .. }| Invalid {
                key: String::new(),
                message: format!("line {number}: {message}"),
                help,
            })?);
        }
        pixels.sort_by_key(|&([x, y], _)| (y, x));
        if let Some(pair) = pixels.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let [x, y] = pair[0].0;
            return Err(Invalid::new("", format!("names the pixel at column {x}, row {y} twice")).help("keep one line"));
        }
        Ok(Self { size, pixels: pixels.into() })
    }

    /// Defective pixels of a row: their columns, and what each does.
    pub(crate) fn row(&self, y: usize) -> impl Iterator<Item = (usize, PixelDefect)> + '_ {
        let first = self.pixels.partition_point(|&([_, row], _)| row < y);
        let of_row = self.pixels[first..].iter().take_while(move |([_, row], _)| *row == y);
        of_row.map(|&([x, _], defect)| (x, defect))
    }

    /// Columns and rows of the sensor.
    pub(super) fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Parts of all pixels, and the mean of the dark currents: what stands for the table where places do not count.
    pub(super) fn statistics(&self) -> Defects {
        let all = (self.size[0] * self.size[1]) as f64;
        let hot: Vec<f64> = self
            .pixels
            .iter()
            .filter_map(|(_, d)| if let PixelDefect::Hot(rate) = d { Some(*rate) } else { None })
            .collect();
        let part = |is: fn(&PixelDefect) -> bool| self.pixels.iter().filter(|(_, d)| is(d)).count() as f64 / all;
        Defects {
            hot: hot.len() as f64 / all,
            hot_dark_current_e_per_s: hot.iter().sum::<f64>() / hot.len().max(1) as f64,
            dead: part(|d| *d == PixelDefect::Dead),
            stuck: part(|d| matches!(d, PixelDefect::Stuck(_))),
        }
    }
}

/// Pixel of a line.
fn pixel(line: &str, size: [usize; 2], max_dn: u16) -> Result<([usize; 2], PixelDefect), Invalid> {
    let form = || Invalid::new("", format!("{line:?} is not of the form {HEADER}")).help("for example 17,4,hot,250");
    let cells: Vec<&str> = line.split(',').map(str::trim).collect();
    let (&[column, row, kind], value) = cells.split_first_chunk::<3>().ok_or_else(form)?;
    let [x, y] = [column, row].map(|cell| cell.parse::<usize>().map_err(|_| form()));
    let (x, y) = (x?, y?);
    if x >= size[0] || y >= size[1] {
        let message = format!("column {x}, row {y} lies outside of {} × {} pixels", size[0], size[1]);
        return Err(Invalid::new("", message).help("columns and rows count from 0"));
    }
    let number = match value {
        [] | [""] => None,
        [value] => Some(value.parse::<f64>().map_err(|_| form())?),
        _ => return Err(form()),
    };
    let defect = match (kind, number) {
        ("hot", Some(rate)) if rate > 0.0 && rate.is_finite() => PixelDefect::Hot(rate),
        ("hot", _) => {
            return Err(Invalid::new("", "a hot pixel needs its dark current").help("write e⁻/s above 0, 17,4,hot,250"));
        }
        ("dead", None) => PixelDefect::Dead,
        ("dead", Some(_)) => return Err(Invalid::new("", "a dead pixel has no value").help("write 3,9,dead,")),
        ("stuck", Some(dn)) if dn.fract() == 0.0 && (0.0..=f64::from(max_dn)).contains(&dn) => {
            PixelDefect::Stuck(dn as u16)
        }
        ("stuck", _) => {
            let message = format!("a stuck pixel needs its number, 0 to {max_dn}");
            return Err(Invalid::new("", message).help("for example 3,9,stuck,1023"));
        }
        (other, _) => {
            return Err(
                Invalid::new("", format!("no kind of defect is called {other:?}")).help("write hot, dead or stuck")
            );
        }
    };
    Ok(([x, y], defect))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "# a camera\ncolumn,row,kind,value\n3,1,hot,250\n0,1,dead,\n2, 0, stuck, 17\n";

    #[test]
    fn pixels_are_found_by_row() {
        let found = DefectivePixels::parse(TABLE, [4, 2], 1023).expect("a table");
        assert_eq!(found.row(0).collect::<Vec<_>>(), [(2, PixelDefect::Stuck(17))]);
        assert_eq!(found.row(1).collect::<Vec<_>>(), [(0, PixelDefect::Dead), (3, PixelDefect::Hot(250.0))]);
        let Defects { hot, hot_dark_current_e_per_s, dead, stuck } = found.statistics();
        assert_eq!([hot, hot_dark_current_e_per_s, dead, stuck], [0.125, 250.0, 0.125, 0.125]);
    }

    #[test]
    fn what_a_table_cannot_say_is_named_by_its_line() {
        for (line, said) in [
            ("4,0,dead,", "line 2: column 4, row 0 lies outside of 4 × 2 pixels"),
            ("1,0,hot,", "line 2: a hot pixel needs its dark current"),
            ("1,0,hot,-1", "line 2: a hot pixel needs"),
            ("1,0,stuck,1024", "line 2: a stuck pixel needs its number, 0 to 1023"),
            ("1,0,stuck,1.5", "line 2: a stuck pixel needs"),
            ("1,0,dead,5", "line 2: a dead pixel has no value"),
            ("1,0,odd,", "line 2: no kind of defect is called \"odd\""),
            ("1;0;dead", "line 2: \"1;0;dead\" is not of the form"),
            ("1,0,dead,\n1,0,hot,5", "names the pixel at column 1, row 0 twice"),
        ] {
            let text = format!("{HEADER}\n{line}\n");
            let invalid = DefectivePixels::parse(&text, [4, 2], 1023).expect_err(line);
            assert!(invalid.message.contains(said) && invalid.help.is_some(), "{invalid:?}");
        }
        assert!(DefectivePixels::parse("x,y\n", [4, 2], 1023).is_err());
    }
}
