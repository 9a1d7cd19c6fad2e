// Camera, wavelengths and responses of a film; photosite-transport's integrator/packed_film.rs. Numbers stand in
// `film`, whose fields are made of those of Rust; tables of four numbers stand in `film_tables`, at the places that it
// has.

@group(3) @binding(0) var<uniform> film: Film;
@group(3) @binding(1) var<storage, read> film_tables: array<vec4<f32>>;
