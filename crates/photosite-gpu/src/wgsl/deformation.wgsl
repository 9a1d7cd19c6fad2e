// Meshes that change their shape, whose corners move on straight lines between evenly spaced times; `Deformation` of
// photosite-transport's geometry/mesh.rs.

struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

/// A corner after a part of the way.
fn between(start: vec4<u32>, end: vec4<u32>, part: f32) -> vec3<f32> {
    return bitcast<vec3<f32>>(start.xyz) * (1.0 - part) + bitcast<vec3<f32>>(end.xyz) * part;
}

/// Corners at a time of the triangle at a slot, whose corners at the end of that part of the time are so many slots
/// later.
fn corners_at(slot: u32, later: u32, time: f32) -> Corners {
    let start = slot * TRIANGLE_WORDS;
    let end = start + later * TRIANGLE_WORDS;
    let a = triangles[end];
    let part = segment(time, a.w).part;
    return Corners(
        between(triangles[start], a, part),
        between(triangles[start + 1u], triangles[end + 1u], part),
        between(triangles[start + 2u], triangles[end + 2u], part),
    );
}

/// Corners at a time of a triangle that emits, whose shapes begin at a place.
fn emissive_corners_at(place: u32, parts: u32, time: f32) -> Corners {
    let now = segment(time, parts);
    let at = params.motions + place + 3u * now.index;
    return Corners(
        between(tables[at], tables[at + 3u], now.part),
        between(tables[at + 1u], tables[at + 4u], now.part),
        between(tables[at + 2u], tables[at + 5u], now.part),
    );
}

/// Root at a time of the hierarchies of an instance whose words begin there.
fn root_at(instance: u32, time: f32) -> u32 {
    let roots = tables[instance];
    return tables[params.motions + roots.x + segment(time, roots.y).index].x;
}
