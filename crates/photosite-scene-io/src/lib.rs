//! Scene files: glTF, OBJ with MTL, PLY, STL, environment pictures and IES profiles become the descriptions of
//! [`photosite_transport::scene`].

#![forbid(unsafe_code)]

mod assemble;
mod changed_meshes;
mod complete;
mod decoded;
mod environment;
pub mod exr;
pub mod gltf;
mod ies;
pub mod linear;
mod mesh;
pub mod obj;
mod picture;
pub mod ply;
mod polygon;
mod stand_in;
pub mod stl;
mod tangents;

pub use changed_meshes::{ChangedMeshes, MeshChange};
pub use complete::complete;
pub use decoded::{decode, dimensions};
pub use environment::{EnvironmentFile, decode_environment, read_environment};
pub use ies::{parse_ies, read_ies};
pub use mesh::MissingNormals;
pub use picture::read_picture;

/// Tells the user of triangles that were left out.
fn zero_area_message(count: usize) -> String {
    match count {
        1 => "1 triangle of zero area is left out".to_owned(),
        _ => format!("{count} triangles of zero area are left out"),
    }
}
