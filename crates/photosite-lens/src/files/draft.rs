//! What a reader has found in a file, before glasses are looked up and apertures are complete.

use photosite_core::Invalid;

use crate::checks::MOST_SURFACES;
use crate::prescription::{Blades, Claims, Coating};

/// Most settings of a zoom or of the focus.
pub(super) const MOST_POSITIONS: usize = 50;

/// What is wrong with a file, and in which line, counted from 1.
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

    /// Says what to write instead.
    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.invalid = self.invalid.help(help.into());
        self
    }
}

/// More surfaces than lenses have.
pub(super) fn too_many(count: usize) -> String {
    format!("{count} surfaces, where lenses have at most {MOST_SURFACES}")
}

/// The fault of the line with the first surface too many.
pub(super) fn too_many_surfaces(line: usize) -> Fault {
    Fault::at(line, format!("more than {MOST_SURFACES} surfaces"))
}

impl From<Invalid> for Fault {
    fn from(invalid: Invalid) -> Self {
        Self { line: None, invalid }
    }
}

/// What a reader makes of a file.
pub(super) type Read<T> = std::result::Result<T, Fault>;

/// What fills a gap, as the file says it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) enum Medium {
    #[default]
    Air,
    /// A name, with the catalogues that it is looked up in first. `numbers` are n_d and ν_d that stand beside it: those
    /// of the glass itself, or only left over from something else.
    Named { name: String, catalogues: Vec<String>, numbers: Numbers },
    /// Index at the d line, Abbe number, deviation of the partial dispersion P_gF.
    Model { nd: f64, vd: f64, deviation: f64 },
    /// n_d and ν_d of a table, as patents have them.
    Patent { nd: f64, vd: f64 },
    /// The same index at all wavelengths.
    Index(f64),
    /// A glass that the file defines.
    Defined(crate::prescription::Glass),
}

/// n_d and ν_d beside the name of a glass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Numbers {
    /// There are none.
    #[default]
    None,
    /// They are those of the glass: they stand for it where the name is not known.
    OfGlass(f64, f64),
    /// They may be left over from another glass, as those behind the names of OpticStudio.
    Spare(f64, f64),
}

/// A surface of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Row {
    /// Its line, where the format has lines.
    pub(super) line: Option<usize>,
    /// Its path, where the format has keys: `surface_group.surfaces[3]`.
    pub(super) key: String,
    /// What the file calls it: `SURF 3`.
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
    /// Its fault, in the way of its format; `field` is the key in it, where there are keys.
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

/// What opens the lens, where the file says so by a figure instead of the stop's radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Opening {
    /// Diameter of the entrance pupil, mm.
    EntrancePupil(f64),
    /// EFL over that diameter.
    FNumber(f64),
}

/// A field of view of the file, with what it cuts off the beam there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Field {
    /// Angle to the axis in object space, degrees.
    pub(super) angle_deg: f64,
    /// Parts of the pupil's radius that are cut off at the upper and the lower rim.
    pub(super) vignetting: [f64; 2],
}

/// A setting of the file, by rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Setting {
    pub(super) label: String,
    /// Rows and the gaps behind them, mm.
    pub(super) gaps: Vec<(usize, f64)>,
    pub(super) half_field_deg: Option<f64>,
    pub(super) stop_semi_aperture_mm: Option<f64>,
    pub(super) object_distance_mm: Option<f64>,
    /// Of a zoom, the focal length at infinity of its setting.
    pub(super) focal_length_mm: Option<f64>,
    /// The f-number that the stop opens to here.
    pub(super) f_number: Option<f64>,
}

/// What a file says of a lens.
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
    /// Whether the format leaves out semi-apertures where the beam defines them, so that they are derived of it.
    pub(super) derives_apertures: bool,
    /// Whether the last gap is not to be used, so that parallel light is focused.
    pub(super) last_gap_is_unused: bool,
    /// Whether semi-apertures are as their author means them: what runs through each other within them is an error. In
    /// other formats they are drawn or estimated, and cut back.
    pub(super) keeps_rims: bool,
    /// What looks wrong.
    pub(super) warnings: Vec<String>,
    /// What had to be assumed.
    pub(super) assumed: Vec<String>,
    /// What was there and is not used.
    pub(super) ignored: Vec<String>,
}

impl Draft {
    pub(super) fn assume(&mut self, what: impl Into<String>) {
        push_once(&mut self.assumed, what.into());
    }

    pub(super) fn ignore(&mut self, what: impl Into<String>) {
        push_once(&mut self.ignored, what.into());
    }

    /// Scales what is in another unit, of so many mm.
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

    /// Drops flat surfaces between air and air that are neither the stop nor limit the beam, as programs have them for
    /// their drawings. `limits` says of each row whether the file gives it an aperture that cuts rays off.
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
