//! Raw content of a lens file, before glasses are looked up and apertures completed.

use photosite_core::Invalid;

use crate::checks::MOST_SURFACES;
use crate::prescription::{Blades, Claims, Coating};

/// Largest number of zoom or focus settings.
pub(super) const MOST_POSITIONS: usize = 50;

/// A fault of a file, with its line, counted from 1, where known.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) line: Option<usize>,
    pub(super) invalid: Invalid,
}

impl Fault {
    /// A fault of a line.
    pub(super) fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), invalid: Invalid::new("", message) }
    }

    /// A fault of the file as a whole.
    pub(super) fn of_file(message: impl Into<String>) -> Self {
        Self { line: None, invalid: Invalid::new("", message) }
    }

    /// Adds a remedy.
    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.invalid = self.invalid.help(help.into());
        self
    }
}

/// Message for more surfaces than lenses have.
pub(super) fn too_many(count: usize) -> String {
    format!("{count} surfaces, where lenses have at most {MOST_SURFACES}")
}

/// Fault at the line of the first surface beyond the largest number.
pub(super) fn too_many_surfaces(line: usize) -> Fault {
    Fault::at(line, format!("more than {MOST_SURFACES} surfaces"))
}

impl From<Invalid> for Fault {
    fn from(invalid: Invalid) -> Self {
        Self { line: None, invalid }
    }
}

/// Result of a reader.
pub(super) type Read<T> = std::result::Result<T, Fault>;

/// Medium of a gap, as the file gives it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) enum Medium {
    #[default]
    Air,
    /// A name, with the catalogues that it is looked up in first. `numbers` are n_d and ν_d beside it: those of the
    /// glass itself, or left over from another.
    Named { name: String, catalogues: Vec<String>, numbers: Numbers },
    /// Index at the d line, Abbe number, deviation of the partial dispersion P_gF.
    Model { nd: f64, vd: f64, deviation: f64 },
    /// n_d and ν_d of a table, as patents have them.
    Patent { nd: f64, vd: f64 },
    /// Constant index.
    Index(f64),
    /// A glass that the file defines.
    Defined(crate::prescription::Glass),
}

/// n_d and ν_d beside the name of a glass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Numbers {
    /// No numbers.
    #[default]
    None,
    /// Numbers of the glass, used where its name is not known.
    OfGlass(f64, f64),
    /// Numbers that may be left over from another glass, such as those behind the names of OpticStudio.
    Spare(f64, f64),
}

/// A surface of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Row {
    /// Line, where the format has lines.
    pub(super) line: Option<usize>,
    /// Path of the surface, where the format has keys: `surface_group.surfaces[3]`.
    pub(super) key: String,
    /// Name of the surface in the file's terms: `SURF 3`.
    pub(super) name: String,
    pub(super) radius_mm: Option<f64>,
    pub(super) thickness_mm: f64,
    pub(super) medium: Medium,
    pub(super) semi_aperture_mm: Option<f64>,
    pub(super) conic: f64,
    pub(super) asphere: Vec<(u32, f64)>,
    pub(super) is_stop: bool,
    pub(super) coating: Coating,
}

impl Row {
    /// Fault of the surface, by line or key as its format has it; `field` is the key within the surface.
    pub(super) fn fault(&self, field: &str, invalid: Invalid) -> Fault {
        let Invalid { message, help, .. } = invalid;
        let key = match (self.line, field) {
            (Some(_), _) => self.name.clone(),
            (None, "") => self.key.clone(),
            (None, field) => format!("{}.{field}", self.key),
        };
        Fault { line: self.line, invalid: Invalid { key, message, help } }
    }
}

/// Opening of the lens, where the file gives a figure instead of the stop's radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Opening {
    /// Diameter of the entrance pupil, mm.
    EntrancePupil(f64),
    /// f-number: focal length over the diameter of the entrance pupil.
    FNumber(f64),
}

/// A field of view of the file, with its vignetting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Field {
    /// Angle to the axis in object space, degrees.
    pub(super) angle_deg: f64,
    /// Fractions of the pupil's radius that are cut off at the upper and the lower rim.
    pub(super) vignetting: [f64; 2],
}

/// A zoom or focus setting of the file, by rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Setting {
    pub(super) label: String,
    /// Rows and the gaps behind them, mm.
    pub(super) gaps: Vec<(usize, f64)>,
    pub(super) half_field_deg: Option<f64>,
    pub(super) stop_semi_aperture_mm: Option<f64>,
    pub(super) object_distance_mm: Option<f64>,
    /// Focal length at infinity of the zoom setting.
    pub(super) focal_length_mm: Option<f64>,
    /// f-number of the stop in this setting.
    pub(super) f_number: Option<f64>,
}

/// Content of a lens file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) source: Option<String>,
    pub(super) licence: Option<String>,
    pub(super) patent: Option<String>,
    pub(super) claims: Claims,
    pub(super) rows: Vec<Row>,
    pub(super) blades: Option<Blades>,
    pub(super) settings: Vec<Setting>,
    pub(super) opening: Option<Opening>,
    pub(super) fields: Vec<Field>,
    /// Whether the format leaves out semi-apertures where the beam defines them, so that they are derived from it.
    pub(super) derives_apertures: bool,
    /// Whether the last gap is replaced so that parallel light is in focus.
    pub(super) last_gap_is_unused: bool,
    /// Whether semi-apertures are as the author means them: surfaces that cross within them are an error. In other
    /// formats they are drawn or estimated, and cut back.
    pub(super) keeps_rims: bool,
    /// Suspicious values.
    pub(super) warnings: Vec<String>,
    /// Assumptions.
    pub(super) assumed: Vec<String>,
    /// Unused content.
    pub(super) ignored: Vec<String>,
}

impl Draft {
    pub(super) fn assume(&mut self, what: impl Into<String>) {
        push_once(&mut self.assumed, what.into());
    }

    pub(super) fn ignore(&mut self, what: impl Into<String>) {
        push_once(&mut self.ignored, what.into());
    }

    /// Scales all lengths from a unit of `mm` millimetres.
    pub(super) fn scale(&mut self, mm: f64) {
        if mm == 1.0 {
            return;
        }
        let by = |length: &mut Option<f64>| *length = length.map(|length| length * mm);
        for row in &mut self.rows {
            by(&mut row.radius_mm);
            row.thickness_mm *= mm;
            by(&mut row.semi_aperture_mm);
            for (order, coefficient) in &mut row.asphere {
                *coefficient *= mm.powi(1 - i32::try_from(*order).unwrap_or(i32::MAX));
            }
        }
        for setting in &mut self.settings {
            setting.gaps.iter_mut().for_each(|(_, gap)| *gap *= mm);
            by(&mut setting.stop_semi_aperture_mm);
            by(&mut setting.object_distance_mm);
            by(&mut setting.focal_length_mm);
        }
        by(&mut self.claims.focal_length_mm);
        by(&mut self.claims.image_half_diagonal_mm);
        if let Some(Opening::EntrancePupil(diameter)) = &mut self.opening {
            *diameter *= mm;
        }
    }

    /// Drops flat surfaces between air and air that are neither the stop nor limit the beam, which programs have for
    /// their drawings. `limits` holds for each row whether the file gives it an aperture that cuts rays off.
    pub(super) fn drop_dummies(&mut self, limits: &[bool]) {
        let mut is_dummy = Vec::with_capacity(self.rows.len());
        let mut before_is_air = true;
        for (row, &limits) in self.rows.iter().zip(limits) {
            let is_in_air = before_is_air && row.medium == Medium::Air;
            before_is_air = row.medium == Medium::Air;
            is_dummy.push(is_in_air && !row.is_stop && !limits && row.radius_mm.is_none() && row.asphere.is_empty());
        }
        // In front of the first surface a gap counts nothing: that is where z is 0.
        let merged = |gaps: &[f64]| {
            let mut sums: Vec<f64> = Vec::new();
            for (&gap, &is_dummy) in gaps.iter().zip(&is_dummy) {
                match sums.last_mut() {
                    Some(sum) if is_dummy => *sum += gap,
                    None if is_dummy => {}
                    _ => sums.push(gap),
                }
            }
            sums
        };
        let own: Vec<f64> = self.rows.iter().map(|row| row.thickness_mm).collect();
        let own_merged = merged(&own);
        let of_settings = self.settings.iter().map(|setting| {
            let mut gaps = own.clone();
            for &(row, gap) in &setting.gaps {
                gaps[row] = gap;
            }
            merged(&gaps)
        });
        let of_settings: Vec<Vec<f64>> = of_settings.collect();
        let varies = |row: usize| of_settings.iter().any(|gaps| gaps[row] != own_merged[row]);
        for (setting, gaps) in self.settings.iter_mut().zip(&of_settings) {
            setting.gaps = gaps.iter().copied().enumerate().filter(|(row, _)| varies(*row)).collect();
        }
        let mut dropped = Vec::new();
        let mut is_dummy = is_dummy.into_iter();
        self.rows.retain(|row| {
            let is_kept = !is_dummy.next().unwrap_or(false);
            if !is_kept {
                dropped.push(row.name.clone());
            }
            is_kept
        });
        for (row, thickness) in self.rows.iter_mut().zip(own_merged) {
            row.thickness_mm = thickness;
        }
        if !dropped.is_empty() {
            self.ignore(format!("flat surfaces in air that limit no beam: {}", dropped.join(", ")));
        }
    }
}

fn push_once(list: &mut Vec<String>, what: String) {
    if !list.contains(&what) {
        list.push(what);
    }
}
