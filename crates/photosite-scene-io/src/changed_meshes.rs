//! Cache of changed meshes, so that the scenes of a series share them.

use std::collections::HashMap;
use std::sync::Arc;

use photosite_transport::scene::description::MeshDescription;
use photosite_transport::texture::UvTransform;

/// Change to a mesh of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MeshChange {
    /// Another material, of this index.
    Material(usize),
    /// At least this number of UV sets, and tangents along one of them.
    Completed {
        /// Number of sets.
        uv_sets: usize,
        /// UV set that tangents follow, and its transform.
        tangents: Option<(usize, UvTransform)>,
    },
}

/// Meshes with their changed copies. A scene that shares its meshes with an earlier scene is built with less work
/// ([`build_after`](photosite_transport::scene::build_after)).
#[derive(Clone, Debug, Default)]
pub struct ChangedMeshes(HashMap<usize, Vec<Changed>>);

#[derive(Clone, Debug)]
struct Changed {
    change: MeshChange,
    /// Original mesh, kept so that no other gets its address, which is the key.
    _mesh: Arc<MeshDescription>,
    result: Arc<MeshDescription>,
}

impl ChangedMeshes {
    /// Changes a mesh: in place where nobody shares it, else a copy, which is made once.
    pub fn change(
        &mut self,
        mesh: &mut Arc<MeshDescription>,
        change: MeshChange,
        make: impl FnOnce(&mut MeshDescription),
    ) {
        if let Some(mesh) = Arc::get_mut(mesh) {
            return make(mesh);
        }
        let known = self.0.entry(Arc::as_ptr(mesh).addr()).or_default();
        let found = known.iter().find(|known| known.change == change).map(|known| Arc::clone(&known.result));
        *mesh = found.unwrap_or_else(|| {
            let mut result = MeshDescription::clone(mesh);
            make(&mut result);
            let result = Arc::new(result);
            known.push(Changed { change, _mesh: Arc::clone(mesh), result: Arc::clone(&result) });
            result
        });
    }
}
