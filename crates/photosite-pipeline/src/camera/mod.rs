//! Camera of a capture: lens, focus, the responses that its film is summed for, and the corrections of the lens in
//! images.

pub(crate) mod autofocus;
pub(crate) mod capture_camera;
pub(crate) mod colour_checker;
pub(crate) mod film_responses;
pub(crate) mod focusing;
pub(crate) mod lens_corrections;
