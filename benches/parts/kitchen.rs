//! A kitchen of some 57 000 triangles: large walls and boards beside small round things, as interiors have.

use std::f32::consts::TAU;

use glam::Vec3;
use photosite::scene::description::{MeshDescription, SceneDescription};

use crate::scenes::of_one_mesh;

/// 4 m × 3 m, 2.6 m high, with a corner at the origin. Cupboards and shelves of bowls along two walls, a table with
/// chairs in the middle, a window in the wall at z = 0.
pub(crate) fn kitchen() -> SceneDescription {
    let mut mesh = MeshDescription::default();
    room(&mut mesh);
    cupboards(&mut mesh);
    shelves(&mut mesh);
    table_and_chairs(&mut mesh);
    // A lamp's shade.
    let profile = [(0.04, 0.25), (0.1, 0.2), (0.18, 0.1), (0.25, 0.0)];
    lathe(&mut mesh, Vec3::new(2.0, 2.35, 1.6), &profile, 48);
    of_one_mesh([0.7; 3], mesh)
}

/// Floor, ceiling and walls; a recess with bars is the window.
fn room(mesh: &mut MeshDescription) {
    let (x, y, z) = (4.0, 2.6, 3.0);
    let thin = 0.1;
    cuboid(mesh, Vec3::new(-thin, -thin, -thin), Vec3::new(x + thin, 0.0, z + thin));
    cuboid(mesh, Vec3::new(-thin, y, -thin), Vec3::new(x + thin, y + thin, z + thin));
    cuboid(mesh, Vec3::new(-thin, 0.0, 0.0), Vec3::new(0.0, y, z));
    cuboid(mesh, Vec3::new(x, 0.0, 0.0), Vec3::new(x + thin, y, z));
    cuboid(mesh, Vec3::new(0.0, 0.0, z), Vec3::new(x, y, z + thin));
    // Around the window, 1.2 m × 1 m.
    cuboid(mesh, Vec3::new(0.0, 0.0, -thin), Vec3::new(x, 1.1, 0.0));
    cuboid(mesh, Vec3::new(0.0, 2.1, -thin), Vec3::new(x, y, 0.0));
    cuboid(mesh, Vec3::new(0.0, 1.1, -thin), Vec3::new(2.2, 2.1, 0.0));
    cuboid(mesh, Vec3::new(3.4, 1.1, -thin), Vec3::new(x, 2.1, 0.0));
    for i in 0..12 {
        let height = 1.14 + 0.08 * i as f32;
        cuboid(mesh, Vec3::new(2.2, height, -0.07), Vec3::new(3.4, height + 0.01, -0.03));
    }
}

/// A row along each of two walls, each with a door and a round handle, below a worktop.
fn cupboards(mesh: &mut MeshDescription) {
    for i in 0..6 {
        let x = 0.62 + 0.55 * i as f32;
        cuboid(mesh, Vec3::new(x, 0.1, 0.0), Vec3::new(x + 0.54, 0.86, 0.56));
        cuboid(mesh, Vec3::new(x + 0.02, 0.12, 0.56), Vec3::new(x + 0.52, 0.84, 0.58));
        lathe(mesh, Vec3::new(x + 0.46, 0.7, 0.6), &KNOB, 24);
    }
    for i in 0..4 {
        let z = 0.62 + 0.55 * i as f32;
        cuboid(mesh, Vec3::new(0.0, 0.1, z), Vec3::new(0.56, 0.86, z + 0.54));
        cuboid(mesh, Vec3::new(0.56, 0.12, z + 0.02), Vec3::new(0.58, 0.84, z + 0.52));
        lathe(mesh, Vec3::new(0.6, 0.7, z + 0.46), &KNOB, 24);
    }
    cuboid(mesh, Vec3::new(0.0, 0.86, 0.0), Vec3::new(4.0, 0.9, 0.6));
    cuboid(mesh, Vec3::new(0.0, 0.86, 0.6), Vec3::new(0.6, 0.9, 3.0));
}

/// Three boards on the wall at x = 0 and two beside the window, all full of bowls; more bowls on the worktop.
fn shelves(mesh: &mut MeshDescription) {
    for row in 0..3 {
        let y = 1.4 + 0.35 * row as f32;
        cuboid(mesh, Vec3::new(0.0, y, 0.3), Vec3::new(0.3, y + 0.02, 2.9));
        for i in 0..10 {
            lathe(mesh, Vec3::new(0.15, y + 0.02, 0.45 + 0.25 * i as f32), &BOWL, 44);
        }
    }
    for row in 0..2 {
        let y = 1.4 + 0.35 * row as f32;
        cuboid(mesh, Vec3::new(0.3, y, 0.0), Vec3::new(2.1, y + 0.02, 0.28));
        for i in 0..6 {
            lathe(mesh, Vec3::new(0.5 + 0.28 * i as f32, y + 0.02, 0.14), &BOWL, 44);
        }
    }
    for i in 0..5 {
        lathe(mesh, Vec3::new(1.0 + 0.6 * i as f32, 0.9, 0.3), &BOWL, 44);
    }
}

/// A table with turned legs, bowls on it, and four chairs around it.
fn table_and_chairs(mesh: &mut MeshDescription) {
    cuboid(mesh, Vec3::new(1.4, 0.72, 1.2), Vec3::new(2.6, 0.76, 2.0));
    for (x, z) in [(1.48, 1.28), (2.52, 1.28), (1.48, 1.92), (2.52, 1.92)] {
        turned_leg(mesh, Vec3::new(x, 0.0, z), 0.72, 0.04);
    }
    for i in 0..4 {
        lathe(mesh, Vec3::new(1.6 + 0.27 * i as f32, 0.76, 1.45 + 0.1 * (i % 3) as f32), &BOWL, 44);
    }
    for (x, z, back) in [(1.6, 0.9, -0.18), (2.2, 0.9, -0.18), (1.6, 2.2, 0.18), (2.2, 2.2, 0.18)] {
        let seat = Vec3::new(x, 0.44, z);
        cuboid(mesh, seat - Vec3::new(0.2, 0.0, 0.2), seat + Vec3::new(0.2, 0.03, 0.2));
        for (u, v) in [(-0.17, -0.17), (0.17, -0.17), (-0.17, 0.17), (0.17, 0.17)] {
            turned_leg(mesh, Vec3::new(x + u, 0.0, z + v), 0.44, 0.02);
        }
        for i in 0..6 {
            turned_leg(mesh, Vec3::new(x - 0.17 + 0.068 * i as f32, 0.47, z + back), 0.4, 0.01);
        }
        cuboid(mesh, Vec3::new(x - 0.2, 0.87, z + back - 0.02), Vec3::new(x + 0.2, 0.95, z + back + 0.02));
    }
}

/// Radius and height along outside and inside.
const BOWL: [(f32, f32); 10] = [
    (0.0, 0.0),
    (0.04, 0.0),
    (0.05, 0.01),
    (0.085, 0.04),
    (0.1, 0.09),
    (0.094, 0.09),
    (0.08, 0.043),
    (0.046, 0.016),
    (0.02, 0.011),
    (0.0, 0.01),
];

const KNOB: [(f32, f32); 5] = [(0.0, -0.015), (0.012, -0.012), (0.018, 0.0), (0.012, 0.012), (0.0, 0.015)];

/// A leg with beads.
fn turned_leg(mesh: &mut MeshDescription, foot: Vec3, height: f32, radius: f32) {
    let profile: Vec<_> =
        (0..=12).map(|i| (radius * (1.0 + 0.3 * (i as f32 * 1.7).sin()), height * i as f32 / 12.0)).collect();
    lathe(mesh, foot, &profile, 18);
}

/// A profile of (radius, height) turned about a vertical axis.
fn lathe(mesh: &mut MeshDescription, foot: Vec3, profile: &[(f32, f32)], sectors: u32) {
    let first = mesh.positions.len() as u32;
    for &(radius, height) in profile {
        mesh.positions.extend((0..sectors).map(|i| {
            let (sin, cos) = (TAU * i as f32 / sectors as f32).sin_cos();
            foot + Vec3::new(radius * cos, height, radius * sin)
        }));
    }
    for (ring, pair) in profile.windows(2).enumerate() {
        let (below, above) = (first + ring as u32 * sectors, first + (ring as u32 + 1) * sectors);
        for i in 0..sectors {
            let j = (i + 1) % sectors;
            // At the axis a ring is a point.
            if pair[0].0 > 0.0 {
                mesh.triangles.push([below + i, below + j, above + i]);
            }
            if pair[1].0 > 0.0 {
                mesh.triangles.push([below + j, above + j, above + i]);
            }
        }
    }
}

/// A box between two corners.
fn cuboid(mesh: &mut MeshDescription, low: Vec3, high: Vec3) {
    let first = mesh.positions.len() as u32;
    let corner = |i: u32| Vec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), high, low);
    mesh.positions.extend((0..8).map(corner));
    const SIDES: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for [a, b, c, d] in SIDES {
        mesh.triangles.extend([[a, b, c], [a, c, d]].map(|triangle| triangle.map(|i| first + i)));
    }
}
