//! Scene files: glTF, OBJ with MTL, PLY, STL, environment maps and IES profiles become the descriptions of
//! [`photosite_transport::scene`].

#![forbid(unsafe_code)]

mod assemble;
mod bitmap_file;
mod changed_meshes;
mod complete;
mod decoded;
mod environment;
mod envmap;
pub mod exr;
pub mod gltf;
mod ies;
pub mod linear;
mod mesh;
pub mod obj;
pub mod ply;
mod polygon;
mod stand_in;
pub mod stl;
mod tangents;

pub use bitmap_file::read_bitmap;
pub use changed_meshes::{ChangedMeshes, MeshChange};
pub use complete::complete;
pub use decoded::{decode, dimensions};
pub use environment::{EnvironmentFile, decode_environment, read_environment};
pub use ies::{parse_ies, read_ies};
pub use mesh::MissingNormals;

/// Message for the user on triangles that were left out.
fn zero_area_message(count: usize) -> String {
    match count {
        1 => "1 triangle of zero area is left out".to_owned(),
        _ => format!("{count} triangles of zero area are left out"),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use photosite_core::Sandbox;
    use photosite_transport::scene::description::SceneDescription;
    use rstest::rstest;

    use super::*;

    const OBJ: &str = "# größe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nmtllib a.mtl\nusemtl grün\nf 1 2 3\n";
    const MTL: &str = "newmtl grün\nKd 0 1 0\n";
    const PLY: &str = "ply\nformat ascii 1.0\ncomment größe\nelement vertex 3\nproperty float x\nproperty float y\n\
                       property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
                       0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    const STL: &str = "solid größe\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
                       endloop\nendfacet\nendsolid\n";
    const GLTF: &str = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "nodes":[{"mesh":0}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":
        "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}"#;
    const IES: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 100 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n50 50\n";

    /// Bytes of a text in an encoding, with line ends.
    fn encoded(text: &str, encoding: &str, end: &str) -> Vec<u8> {
        let text = text.replace('\n', end);
        let wide = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
        match encoding {
            "utf-8" => text.into_bytes(),
            "utf-8-mark" => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
            "utf-16-le" => [b"\xff\xfe", &wide(u16::to_le_bytes)[..]].concat(),
            "utf-16-be" => [b"\xfe\xff", &wide(u16::to_be_bytes)[..]].concat(),
            "utf-16-unmarked" => wide(u16::to_le_bytes),
            "latin-1" => text.chars().map(|c| u8::try_from(u32::from(c)).expect("Latin-1")).collect(),
            other => panic!("{other}"),
        }
    }

    fn read(path: &Path) -> photosite_core::Result<SceneDescription> {
        let sandbox = Sandbox::default();
        match path.extension().and_then(|e| e.to_str()) {
            Some("obj") => obj::read(path, &obj::Choice::default()).map(|file| file.scene),
            Some("ply") => ply::read(path, MissingNormals::Flat, &sandbox),
            Some("stl") => stl::read(path, MissingNormals::Flat),
            Some(_) | None => gltf::read(path, gltf::Choice::default()).map(|file| file.scene),
        }
    }

    #[rstest]
    fn texts_are_read_in_every_encoding_and_with_every_end_of_lines(
        #[values("utf-8", "utf-8-mark", "utf-16-le", "utf-16-be", "utf-16-unmarked", "latin-1")] encoding: &str,
        #[values("\n", "\r\n", "\r")] end: &str,
    ) {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in [("a.mtl", MTL), ("a.obj", OBJ), ("a.ply", PLY), ("a.stl", STL), ("a.gltf", GLTF)] {
            let path = folder.path().join(name);
            std::fs::write(&path, encoded(text, encoding, end)).expect("written");
            if name == "a.mtl" {
                continue;
            }
            let scene = read(&path).expect(name);
            assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]], "{name}");
            assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
            if name == "a.obj" {
                assert_eq!(scene.materials[0].name, "grün");
            }
        }
        let lamp = parse_ies(&encoded(IES, encoding, end), "a.ies".as_ref()).expect("a lamp");
        assert!((lamp.intensity(glam::Vec3::NEG_Z) - 50.0).abs() < 1e-3);
    }
}
