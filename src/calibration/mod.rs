//! What cameras are calibrated with and against.
//!
//! [`targets`] are flat patterns whose points are known: as drawings they can be printed, as meshes photographed. Nothing
//! here touches files or rays.

pub mod targets;
