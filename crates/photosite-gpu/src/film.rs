//! Film of a render on a card: its camera, wavelengths and responses.

use photosite_transport::integrator::PackedFilm;

use crate::uniform::uniform_block;

/// Places of tables among the vectors of a film.
#[derive(Clone, Copy, Debug, Default)]
struct Places {
    densities: u32,
    tile: u32,
    transmittance: u32,
    responses: u32,
    corners: u32,
    stops: u32,
    lens: u32,
    poses: u32,
}

/// A film with the places of its tables.
pub(crate) struct Row<'a> {
    film: &'a PackedFilm<'a>,
    places: Places,
}

uniform_block! {
    Row<'_>:
    poses: "u32" = |r| r.places.poses,
    pose_count: "u32" = |r| r.film.camera.poses.len() as u32,
    fx: "f32" = |r| r.film.camera.intrinsics[0].to_bits(),
    fy: "f32" = |r| r.film.camera.intrinsics[1].to_bits(),
    cx: "f32" = |r| r.film.camera.intrinsics[2].to_bits(),
    cy: "f32" = |r| r.film.camera.intrinsics[3].to_bits(),
    skew: "f32" = |r| r.film.camera.intrinsics[4].to_bits(),
    lens_step: "u32" = |r| r.film.camera.table.as_ref().map_or(0, |table| table.step),
    lens_columns: "u32" = |r| r.film.camera.table.as_ref().map_or(0, |table| table.columns),
    lens_rows: "u32" = |r| r.film.camera.table.as_ref().map_or(0, |table| table.rows),
    lens: "u32" = |r| r.places.lens,
    is_flat: "u32" = |r| u32::from(r.film.camera.is_flat),
    reach_cos: "f32" = |r| r.film.camera.reach_cos.to_bits(),
    reach_sin: "f32" = |r| r.film.camera.reach_sin.to_bits(),
    aperture_radius: "f32" = |r| r.film.camera.radius.to_bits(),
    has_aperture: "u32" = |r| u32::from(r.film.camera.has_aperture),
    blades: "u32" = |r| r.film.camera.corners.len().saturating_sub(1) as u32,
    corners: "u32" = |r| r.places.corners,
    pupil_scale: "f32" = |r| r.film.camera.pupil_scale.to_bits(),
    vergence: "f32" = |r| r.film.camera.vergence.to_bits(),
    stop_count: "u32" = |r| r.film.camera.stops.len() as u32,
    stops: "u32" = |r| r.places.stops,
    image_distance: "f32" = |r| r.film.camera.image_distance.to_bits(),
    perspective_distance: "f32" = |r| r.film.camera.perspective_distance.to_bits(),
    sample_sr: "f32" = |r| r.film.camera.sample_sr.to_bits(),
    falls_off: "u32" = |r| u32::from(r.film.camera.falls_off),
    has_circle: "u32" = |r| u32::from(r.film.camera.image_circle.is_some()),
    circle_x: "f32" = |r| r.film.camera.image_circle.map_or(0, |circle| circle[0].to_bits()),
    circle_y: "f32" = |r| r.film.camera.image_circle.map_or(0, |circle| circle[1].to_bits()),
    circle_width: "f32" = |r| r.film.camera.image_circle.map_or(0, |circle| circle[2].to_bits()),
    circle_height: "f32" = |r| r.film.camera.image_circle.map_or(0, |circle| circle[3].to_bits()),
    has_times: "u32" = |r| u32::from(r.film.camera.times.is_some()),
    time: "f32" = |r| r.film.camera.time.to_bits(),
    first_row: "f32" = |r| r.film.camera.times.map_or(0, |times| times.first_row.to_bits()),
    row_time: "f32" = |r| r.film.camera.times.map_or(0, |times| times.row_time.to_bits()),
    exposure: "f32" = |r| r.film.camera.times.map_or(0, |times| times.exposure.to_bits()),
    seed_low: "u32" = |r| r.film.seed as u32,
    seed_high: "u32" = |r| (r.film.seed >> 32) as u32,
    squares: "u32" = |r| r.film.order[0],
    log2_side: "u32" = |r| r.film.order[1],
    log2_samples: "u32" = |r| r.film.order[2],
    has_single_wavelengths: "u32" = |r| u32::from(r.film.has_single_wavelengths),
    densities: "u32" = |r| r.places.densities,
    tile: "u32" = |r| r.places.tile,
    tile_width: "u32" = |r| r.film.tile_width,
    tile_height: "u32" = |r| r.film.tile.len() as u32 / r.film.tile_width,
    transmittance: "u32" = |r| r.places.transmittance,
    responses: "u32" = |r| r.places.responses,
    groups: "u32" = |r| r.film.groups,
}

/// Numbers and tables of a film as kernels read them.
pub(crate) fn packed(film: &PackedFilm<'_>) -> (Vec<u32>, Vec<[f32; 4]>) {
    let mut table = Vec::new();
    let mut section = |rows: &mut dyn Iterator<Item = [f32; 4]>| {
        let first = table.len() as u32;
        table.extend(rows);
        first
    };
    let pair = |&[x, y]: &[f32; 2]| [x, y, 0.0, 0.0];
    let one = |x: f32| [x, 0.0, 0.0, 0.0];
    let places = Places {
        densities: section(&mut film.densities.iter().map(|&[before, density, nm]| [before, density, nm, 0.0])),
        tile: section(&mut film.tile.iter().map(|&density| one(density as f32))),
        transmittance: section(&mut film.transmittance.iter().copied().map(one)),
        responses: section(&mut film.responses.iter().copied()),
        corners: section(&mut film.camera.corners.iter().map(pair)),
        stops: section(&mut film.camera.stops.iter().map(pair)),
        poses: section(&mut film.camera.poses.iter().flatten().map(|&[x, y, z]| [x, y, z, 0.0])),
        lens: section(&mut film.camera.table.iter().flat_map(|table| table.nodes.iter().copied())),
    };
    (values(&Row { film, places }), table)
}
