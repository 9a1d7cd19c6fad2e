//! What a packed primitive holds, in place of its accessors.

use std::collections::HashMap;

/// What a stream holds.
pub(super) struct Unpacked {
    /// By the accessor that describes them, the components of all values.
    pub(super) values: HashMap<usize, Vec<f32>>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Unpacked {
    /// The values that an accessor stands for, if they are of the stream.
    pub(super) fn values<const N: usize>(&self, accessor: usize) -> Option<Vec<[f32; N]>> {
        Some(self.values.get(&accessor)?.as_chunks::<N>().0.to_vec())
    }
}
