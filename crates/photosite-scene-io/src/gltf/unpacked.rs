//! Values of a packed primitive, in place of its accessors.

use std::collections::HashMap;

/// Content of a Draco stream.
pub(super) struct Unpacked {
    /// Components of all values, by the accessor that describes them.
    pub(super) values: HashMap<usize, Vec<f32>>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Unpacked {
    /// Values of an accessor, if they are in the stream.
    pub(super) fn values<const N: usize>(&self, accessor: usize) -> Option<Vec<[f32; N]>> {
        Some(self.values.get(&accessor)?.as_chunks::<N>().0.to_vec())
    }
}
