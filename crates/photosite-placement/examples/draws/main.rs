//! Repeated draws of places, printed with the meshes as JSON, for `tests/judges/placement.py`.
//!
//! ```sh
//! cargo run -p photosite-placement --example draws -- 1000 > draws.json
//! ```

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use photosite_core::Invalid;
use photosite_core::math::hash::hash64;
use photosite_placement::{
    Bin, Contact, Fixed, Item, Method, Pose, Region, Request, RestingPose, Shape, Support, Turn, cuboid, place,
};
use serde_json::{Value, json};

mod shapes;

/// The kinds of draws, which take turns.
const KINDS: [&str; 8] = ["pile", "bin", "table", "stack", "rest", "rest on table", "surface", "box"];

fn main() -> Result<(), Invalid> {
    let mut arguments = std::env::args().skip(1);
    let draws: u64 = arguments.next().and_then(|count| count.parse().ok()).unwrap_or(8);
    let only = arguments.next();
    let mut meshes: Vec<(String, shapes::Mesh)> =
        shapes::all().into_iter().map(|(name, mesh)| (name.to_owned(), mesh)).collect();
    let count = meshes.len();
    let bin = Bin { size: DVec3::new(0.3, 0.15, 0.2), position: DVec3::new(0.1, 0.01, 0.0), wall: 0.01 };
    meshes.push(("table".to_owned(), cuboid(DVec3::new(-0.3, 0.68, -0.2), DVec3::new(0.3, 0.7, 0.2))));
    meshes.push(("bin".to_owned(), bin.mesh()));
    let shapes: Vec<Arc<Shape>> =
        meshes.iter().map(|(_, (p, t))| Shape::new(p, t).map(Arc::new)).collect::<Result<_, _>>()?;
    let table = Fixed { shape: shapes[count].clone(), scale: 1.0, pose: Pose::IDENTITY };
    let mut seconds = vec![Vec::new(); KINDS.len()];
    let mut told: Vec<Value> = Vec::new();
    for draw in 0..draws {
        let kind = (draw % KINDS.len() as u64) as usize;
        if only.as_deref().is_some_and(|only| only != KINDS[kind]) {
            continue;
        }
        let seed = hash64(7, draw);
        let chosen = |n: usize| (0..n).map(|i| (hash64(seed, i as u64) % count as u64) as usize).collect::<Vec<_>>();
        let on_table = Region { min: DVec3::new(-0.25, 0.7, -0.15), max: DVec3::new(0.25, 0.9, 0.15) };
        let ground = Region { min: DVec3::new(-0.15, 0.0, -0.15), max: DVec3::new(0.15, 0.3, 0.15) };
        let above = Region { min: DVec3::new(-0.3, 0.69, -0.2), max: DVec3::new(0.3, f64::INFINITY, 0.2) };
        let flat = |n: usize| (0..n).map(|i| [0, 4, 1][i % 3]).collect::<Vec<_>>();
        let (which, how, fixed, seen): (Vec<usize>, Method, Vec<Fixed>, Vec<usize>) = match kind {
            0 => (chosen(8), Method::Drop { region: ground, keep_in: None }, vec![], vec![]),
            1 => {
                let how = Method::Drop { region: bin.region(), keep_in: Some(bin.inside()) };
                (chosen(10), how, bin.fixed()?, vec![count + 1])
            }
            2 => (chosen(6), Method::Drop { region: on_table, keep_in: Some(above) }, vec![table.clone()], vec![count]),
            3 => (flat(3), Method::Stack { position: DVec3::ZERO }, vec![], vec![]),
            4 => (chosen(6), Method::Rest { on: Support::Ground(ground) }, vec![], vec![]),
            5 => (chosen(5), Method::Rest { on: Support::Fixed(0) }, vec![table.clone()], vec![count]),
            6 => (chosen(5), Method::Surface { on: 0, turn: Turn::Any }, vec![table.clone()], vec![count]),
            _ => (chosen(8), Method::Box { region: on_table, turn: Turn::Any }, vec![table.clone()], vec![count]),
        };
        let scale = |i: usize| 0.8 + 0.1 * (hash64(seed, 100 + i as u64) % 5) as f64;
        let items: Vec<Item> =
            which.iter().enumerate().map(|(i, s)| Item { scale: scale(i), ..Item::new(shapes[*s].clone()) }).collect();
        let request = Request {
            items,
            how,
            fixed,
            ground_height_m: Some(0.0),
            min_distance_m: 0.001,
            contact: Contact::default(),
            seed,
        };
        let start = Instant::now();
        let placed = place(&request);
        seconds[kind].push(start.elapsed().as_secs_f64());
        let poses = match placed {
            Ok(poses) => poses,
            Err(error) => {
                eprintln!("draw {draw} ({}): {error}", KINDS[kind]);
                told.push(json!({ "kind": KINDS[kind], "error": error.to_string() }));
                continue;
            }
        };
        let object = |shape: usize, scale: f64, pose: &Pose| {
            let q = pose.rotation;
            json!({ "shape": shape, "scale": scale, "position_m": pose.position.to_array(),
                "quaternion_wxyz": [q.w, q.x, q.y, q.z] })
        };
        let objects: Vec<Value> =
            which.iter().zip(&poses).enumerate().map(|(i, (s, pose))| object(*s, scale(i), pose)).collect();
        let fixed: Vec<Value> = seen.iter().map(|s| object(*s, 1.0, &Pose::IDENTITY)).collect();
        told.push(json!({ "kind": KINDS[kind], "ground_height_m": 0.0, "objects": objects, "fixed": fixed,
            "friction": request.contact.friction, "is_held": kind < 6 }));
    }
    for (kind, mut times) in KINDS.iter().zip(seconds).filter(|(_, times)| !times.is_empty()) {
        times.sort_by(f64::total_cmp);
        let mean = times.iter().sum::<f64>() / times.len() as f64;
        eprintln!("{kind}: {mean:.3} s on average, at most {:.3} s, {} draws", times[times.len() - 1], times.len());
    }
    let shape = |(name, (positions, triangles)): &(String, shapes::Mesh)| {
        let positions: Vec<[f64; 3]> = positions.iter().map(|p| p.to_array()).collect();
        json!({ "name": name, "positions": positions, "triangles": triangles })
    };
    let mut all: Vec<Value> = meshes.iter().map(shape).collect();
    for (told, shape) in all.iter_mut().zip(&shapes) {
        let resting = |pose: &RestingPose| {
            let down = pose.rotation.inverse() * DVec3::NEG_Y;
            json!({ "down": down.to_array(), "probability": pose.probability })
        };
        told["resting"] = shape.resting_poses().iter().map(resting).collect();
    }
    println!("{}", json!({ "shapes": all, "draws": told }));
    Ok(())
}
