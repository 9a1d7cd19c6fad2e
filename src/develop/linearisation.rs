//! Linearisation: the numbers of a file become digital numbers in proportion to the charge.

use crate::raw::RawImage;

/// From numbers of the file to linear digital numbers (DNG LinearizationTable, [Dng16](crate::references#dng16)).
pub(super) enum Linearisation<'a> {
    /// They are linear.
    Identity,
    /// By table; numbers past its end take its last entry.
    Table(&'a [u16]),
}

impl<'a> Linearisation<'a> {
    /// The table of the raw file, where there is one and it is wanted.
    pub(super) fn new(raw: &'a RawImage, wanted: bool) -> Self {
        match &raw.metadata.linearisation[..] {
            table @ [_, ..] if wanted => Self::Table(table),
            _ => Self::Identity,
        }
    }

    /// The linear number of a stored one, DN.
    #[inline]
    pub(super) fn linear(&self, dn: u16) -> f32 {
        match self {
            Self::Identity => f32::from(dn),
            Self::Table(table) => f32::from(table[usize::from(dn).min(table.len() - 1)]),
        }
    }
}
