//! IES files ([LM63](photosite_core::references#lm63)): luminous intensities of a luminaire as a goniophotometer
//! measured them.
//!
//! Files of all editions from 1986 on become a [`Profile`] in candela, of photometric type C.

use std::f32::consts::TAU;
use std::path::Path;

use photosite_core::{Error, Invalid, Result, input, text};
use photosite_transport::light::Profile;

/// Reads an IES file.
pub fn read_ies(path: &Path) -> Result<Profile> {
    let bytes = input::read_at_most(path, input::TREE_BYTES).map_err(|reason| Error::io(path, "read", reason))?;
    parse_ies(&bytes, path)
}

/// Reads an IES file from memory; `path` is for messages.
pub fn parse_ies(bytes: &[u8], path: &Path) -> Result<Profile> {
    let text = text::decode_any(bytes.to_vec()).map_err(|reason| Error::io(path, "read", reason))?;
    parse(&text).map_err(|(invalid, line)| match line {
        0 => invalid.in_file(path),
        line => invalid.at_line(path, line),
    })
}

/// A fault, and its line; 0 for none.
type Problem = (Invalid, usize);

/// The numbers that follow the keywords, with their lines.
struct Numbers<'a> {
    rest: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    last_line: usize,
}

impl Numbers<'_> {
    fn next(&mut self, what: &str) -> Result<f64, Problem> {
        let Some((line, word)) = self.rest.next() else {
            let invalid = Invalid::new(what, "is missing: the file ends too early");
            return Err((invalid.help("get the file again; it was truncated"), self.last_line));
        };
        self.last_line = line;
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            Ok(_) | Err(_) => Err((Invalid::new(what, format!("must be a number, got {word:?}")), line)),
        }
    }

    fn count(&mut self, what: &str, largest: f64) -> Result<usize, Problem> {
        let number = self.next(what)?;
        if number.fract() == 0.0 && (1.0..=largest).contains(&number) {
            return Ok(number as usize);
        }
        Err((Invalid::new(what, format!("must be a whole number from 1 to {largest}, got {number}")), self.last_line))
    }

    /// Reads rising angles in degrees.
    fn angles(&mut self, what: &str, count: usize) -> Result<Vec<f64>, Problem> {
        let mut angles: Vec<f64> = Vec::new();
        for _ in 0..count {
            let angle = self.next(what)?;
            if angles.last().is_some_and(|last| angle <= *last) {
                return Err((
                    Invalid::new(what, format!("must rise, but {angle} follows {:?}", angles[angles.len() - 1])),
                    self.last_line,
                ));
            }
            angles.push(angle);
        }
        Ok(angles)
    }
}

fn parse(text: &str) -> Result<Profile, Problem> {
    let lines = || text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let tilt = lines().find_map(|(line, text)| Some((line, text.strip_prefix("TILT=")?.trim().to_owned())));
    let Some((tilt_line, tilt)) = tilt else {
        let invalid = Invalid::new("", "is not an IES file: it has no line TILT=");
        return Err((invalid.help("give a photometric file of LM-63"), 0));
    };
    let words = lines().skip(tilt_line).flat_map(|(line, text)| {
        text.split(|c: char| c.is_whitespace() || c == ',')
            .filter(|word| !word.is_empty())
            .map(move |word| (line, word))
    });
    let mut numbers = Numbers { rest: Box::new(words), last_line: tilt_line };
    match &*tilt {
        "NONE" => {}
        // How the lamp fades when it is tilted; it is not tilted here.
        "INCLUDE" => {
            numbers.next("lamp-to-luminaire geometry")?;
            let pairs = numbers.count("number of tilt angles", 1000.0)?;
            for _ in 0..2 * pairs {
                numbers.next("tilt factors")?;
            }
        }
        file => {
            let invalid = Invalid::new("TILT", format!("refers to another file, {file:?}, which is not read"));
            return Err((invalid.help("write TILT=NONE"), tilt_line));
        }
    }
    numbers.next("number of lamps")?;
    numbers.next("lumens per lamp")?;
    let multiplier = numbers.next("candela multiplier")?;
    let vertical_count = numbers.count("number of vertical angles", 10_000.0)?;
    let horizontal_count = numbers.count("number of horizontal angles", 10_000.0)?;
    match numbers.next("photometric type")? {
        1.0 => {}
        other => {
            let name = if other == 2.0 { "B" } else { "A" };
            let invalid = Invalid::new("photometric type", format!("is {name} ({other}), which is not read"));
            return Err((invalid.help("convert the file to type C (1), as most are"), numbers.last_line));
        }
    }
    for what in ["units type", "width", "length", "height"] {
        numbers.next(what)?;
    }
    let factor = multiplier * numbers.next("ballast factor")? * numbers.next("ballast-lamp factor")?;
    numbers.next("input watts")?;
    let vertical = numbers.angles("vertical angles", vertical_count)?;
    let vertical_line = numbers.last_line;
    let horizontal = numbers.angles("horizontal angles", horizontal_count)?;
    let horizontal_line = numbers.last_line;
    if vertical[0] < 0.0 || vertical[vertical.len() - 1] > 180.0 {
        return Err((Invalid::new("vertical angles", "must lie between 0 and 180 degrees"), vertical_line));
    }
    let mut candela = Vec::new();
    for _ in 0..horizontal_count * vertical_count {
        let value = numbers.next("candela values")? * factor;
        if value < 0.0 {
            return Err((Invalid::new("candela values", "must not be negative"), numbers.last_line));
        }
        candela.push(value as f32);
    }
    let (horizontal, rows) = all_around(&horizontal).map_err(|invalid| (invalid, horizontal_line))?;
    let candela = rows.iter().flat_map(|row| candela[row * vertical_count..][..vertical_count].to_vec()).collect();
    let radians = |degrees: Vec<f64>| degrees.iter().map(|d| d.to_radians() as f32).collect::<Vec<_>>();
    let mut horizontal = radians(horizontal);
    if let [.., last] = &mut horizontal[..] {
        *last = last.min(TAU);
    }
    Ok(Profile::new(radians(vertical), horizontal, candela))
}

/// Horizontal angles from 0 to 360 degrees, and the file's angle that each repeats: files omit those given by symmetry.
fn all_around(angles: &[f64]) -> Result<(Vec<f64>, Vec<usize>), Invalid> {
    let mut rows: Vec<(f64, usize)> = angles.iter().copied().zip(0..).collect();
    let mirrored = |rows: &[(f64, usize)], about: f64| {
        let mirror = rows.iter().rev().map(|&(angle, row)| (2.0 * about - angle, row));
        mirror.skip_while(|(angle, _)| *angle <= about).collect::<Vec<_>>()
    };
    match (angles[0], angles[angles.len() - 1]) {
        (0.0, 0.0) => {}
        (0.0, 90.0) => {
            rows.extend(mirrored(&rows, 90.0));
            rows.extend(mirrored(&rows, 180.0));
        }
        (0.0, 180.0) => rows.extend(mirrored(&rows, 180.0)),
        (0.0, 360.0) => {}
        // Editions before that of 2002 leave out the last, which is the first.
        (0.0, last) if last > 180.0 && last < 360.0 && is_closed(angles) => rows.push((360.0, 0)),
        // Symmetric about the plane through 90° and 270°.
        (90.0, 270.0) => {
            let right: Vec<_> = rows.iter().map(|&(angle, row)| (540.0 - angle, row)).rev().collect();
            let whole: Vec<_> =
                rows.iter().chain(&right).flat_map(|&(angle, row)| [(angle, row), (angle - 360.0, row)]).collect();
            rows = whole.into_iter().filter(|(angle, _)| (0.0..=360.0).contains(angle)).collect();
            rows.sort_by(|a, b| a.0.total_cmp(&b.0));
            rows.dedup_by(|a, b| a.0 == b.0);
        }
        (first, last) => {
            let message = format!("go from {first} to {last} degrees");
            return Err(Invalid::new("horizontal angles", message)
                .help("they go from 0 to 0, 90, 180 or 360, or from 90 to 270"));
        }
    }
    Ok(rows.into_iter().unzip())
}

/// Whether the step from the last angle around to the first is no longer than the longest between two.
fn is_closed(angles: &[f64]) -> bool {
    let longest = angles.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    360.0 - angles[angles.len() - 1] <= longest + 1e-6
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// A luminaire of I = 100·cos θ cd below the horizon, 314.16 lm, in 1° steps, the same all around or by quadrants.
    fn cosine(horizontal: &[u16]) -> String {
        let mut text = "IESNA:LM-63-2002\n[TEST] none\n[MANUFAC] nobody\nTILT=NONE\n".to_owned();
        text += &format!("1 314.16 2.0 91 {} 1 2 0 0 0\n1.0 1.0 10\n", horizontal.len());
        for chunk in (0..=90u16).collect::<Vec<_>>().chunks(10) {
            text += &(chunk.iter().map(u16::to_string).collect::<Vec<_>>().join(" ") + "\n");
        }
        text += &(horizontal.iter().map(u16::to_string).collect::<Vec<_>>().join(" ") + "\n");
        for _ in horizontal {
            for v in 0..=90u16 {
                text += &format!("{:.4}\n", 50.0 * f64::from(v).to_radians().cos());
            }
        }
        text
    }

    #[test]
    fn the_flux_is_that_of_the_file() {
        for horizontal in [&[0u16][..], &[0, 45, 90], &[0, 90, 180], &[0, 120, 240, 360], &[90, 180, 270]] {
            let profile =
                parse(&cosine(horizontal)).map_err(|(invalid, line)| format!("{line}: {invalid}")).expect("valid");
            // Linear interpolation over 1° falls short by (1°)²/12 of the curvature, 3e-5; the midpoint rule by less.
            assert!((profile.flux_lm() / 314.16 - 1.0).abs() < 1e-4, "{horizontal:?}: {}", profile.flux_lm());
            assert!((profile.intensity(Vec3::NEG_Z) - 100.0).abs() < 1e-3);
            let aslant = Vec3::new(0.6, -0.4, -0.8).normalize();
            assert!((profile.intensity(aslant) / (100.0 * -aslant.z) - 1.0).abs() < 1e-4, "{horizontal:?}");
        }
    }

    #[test]
    fn symmetry_gives_what_the_file_leaves_out() {
        let (angles, rows) = all_around(&[0.0, 30.0, 90.0]).expect("valid");
        assert_eq!(angles, [0.0, 30.0, 90.0, 150.0, 180.0, 210.0, 270.0, 330.0, 360.0]);
        assert_eq!(rows, [0, 1, 2, 1, 0, 1, 2, 1, 0]);
        let (angles, rows) = all_around(&[90.0, 180.0, 270.0]).expect("valid");
        assert_eq!((angles, rows), (vec![0.0, 90.0, 180.0, 270.0, 360.0], vec![1, 0, 1, 2, 1]));
        let (angles, rows) = all_around(&[0.0, 120.0, 240.0]).expect("valid");
        assert_eq!((angles, rows), (vec![0.0, 120.0, 240.0, 360.0], vec![0, 1, 2, 0]));
        assert!(all_around(&[0.0, 90.0, 181.0]).is_err(), "nothing is known of the other side");
    }

    #[test]
    fn damage_is_named_with_its_line() {
        let good = cosine(&[0]);
        for (from, to, message, line) in [
            ("TILT=NONE", "TILT=lamp.tlt", "write TILT=NONE", 4),
            ("TILT=NONE", "", "no line TILT=", 0),
            (" 1 2 0 0 0", " 2 2 0 0 0", "type C", 5),
            ("1.0 1.0 10", "1.0 x 10", "got \"x\"", 6),
            ("0 1 2 3", "0 1 1 3", "must rise", 7),
            ("50.0000\n", "-50.0000\n", "negative", 18),
        ] {
            let (invalid, found) = parse(&good.replacen(from, to, 1)).expect_err(message);
            let text = format!("{invalid} {:?}", invalid);
            assert!(text.contains(message) && found == line, "{found}: {text}");
        }
        // Of the last number, "0.0000", parts are numbers as well.
        for len in 0..good.len() - "0.0000\n".len() {
            assert!(parse(&good[..len]).is_err(), "{len}");
        }
    }
}
