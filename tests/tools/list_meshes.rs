//! Prints the meshes of PLY and STL files, for programs that nobody here wrote to read the same
//! (`tests/judges/meshes.py`).
//!
//! `cargo run --release --example list_meshes -- flat|smooth FILE… > meshes.json`

use std::path::Path;

use photosite::Sandbox;
use photosite::io::{ChangedMeshes, MissingNormals, complete, ply, stl};
use photosite::scene::description::{MeshDescription, SceneDescription};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let missing = match arguments.next().as_deref() {
        Some("flat") => MissingNormals::Flat,
        Some("smooth") => MissingNormals::Smooth,
        other => return Err(format!("flat or smooth, not {other:?}").into()),
    };
    let files: Result<Vec<Value>, photosite::Error> = arguments.map(|file| listed(&file, missing)).collect();
    println!("{}", serde_json::to_string(&files?)?);
    Ok(())
}

fn listed(file: &str, missing: MissingNormals) -> Result<Value, photosite::Error> {
    let path = Path::new(file);
    let mut scene: SceneDescription = match path.extension().and_then(|extension| extension.to_str()) {
        Some("ply") => ply::read(path, missing, &Sandbox::default())?,
        _ => stl::read(path, missing)?,
    };
    complete(&mut scene, &mut ChangedMeshes::default());
    Ok(json!({
        "meshes": scene.meshes.iter().map(|each| mesh(each)).collect::<Vec<_>>(),
        "materials": scene.materials.iter().map(|material| &material.name).collect::<Vec<_>>(),
        "pictures": scene.images.iter().map(|image| [image.width, image.height]).collect::<Vec<_>>(),
        "warnings": scene.warnings,
    }))
}

fn mesh(mesh: &MeshDescription) -> Value {
    json!({
        "name": mesh.name,
        "positions": mesh.positions.iter().map(|p| p.to_array()).collect::<Vec<_>>(),
        "normals": mesh.normals.iter().map(|n| n.to_array()).collect::<Vec<_>>(),
        "uvs": mesh.uvs.iter().map(|uvs| uvs.iter().map(|uv| uv.to_array()).collect()).collect::<Vec<Vec<_>>>(),
        "colours": mesh.colours.iter().map(|c| c.to_array()).collect::<Vec<_>>(),
        "triangles": mesh.triangles,
    })
}
