//! Images of textures: PNG, JPEG, WebP, TIFF, PNM, HDR.


pub(crate) fn target(data: &[u8]) {
    let _ = photosite_scene_io::decode(data, "picture");
}
