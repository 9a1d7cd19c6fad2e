//! Images that are written a row at a time, since they may be larger than the memory.

use std::io;

use photosite_core::image::Planes;

/// Planes of one image, in memory or not.
pub trait ImageRows: Sync {
    /// Columns and rows.
    fn size(&self) -> [usize; 2];

    /// Names of the planes.
    fn names(&self) -> Vec<&str>;

    /// Fills `to` with a row of the plane of that index.
    fn read_row(&self, plane: usize, row: usize, to: &mut [f32]) -> io::Result<()>;
}

impl ImageRows for Planes {
    fn size(&self) -> [usize; 2] {
        [self.width(), self.height()]
    }

    fn names(&self) -> Vec<&str> {
        self.channels().iter().map(|channel| &*channel.name).collect()
    }

    fn read_row(&self, plane: usize, row: usize, to: &mut [f32]) -> io::Result<()> {
        to.copy_from_slice(&self.channels()[plane].data[row * self.width()..][..self.width()]);
        Ok(())
    }
}
