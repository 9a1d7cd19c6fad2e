//! A target for each reader: any bytes are read or are an error, without a panic.

/// Does with bytes what is under fire.
pub(crate) type Target = fn(&[u8]);

/// Declares the modules of targets, and the table of them.
macro_rules! targets {
    ($($name:ident),* $(,)?) => {
        $(mod $name;)*

        /// Targets by the names of their files.
        pub(crate) const TARGETS: &[(&str, Target)] = &[$((stringify!($name), $name::target)),*];
    };
}

targets! {
    bitmap,
    calibration_files,
    capture,
    capture_keys,
    csv,
    dataset,
    descriptor,
    develop,
    dng,
    environment,
    exr,
    film,
    gltf,
    ies,
    kernel,
    lens_deeplens,
    lens_json,
    lens_optical_bench,
    lens_optiland,
    lens_pbrt,
    lens_rayoptics,
    lens_seq,
    lens_toml,
    lens_zmx,
    linear_image,
    manifest,
    mtl,
    npy,
    obj,
    overrides,
    parts,
    ply,
    pnm,
    render,
    report,
    sensor,
    stl,
    tiff,
}
