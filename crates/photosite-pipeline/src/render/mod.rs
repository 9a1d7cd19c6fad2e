//! Renders into folders: images that are traced, exposed, developed and written.

pub(crate) mod destination;
pub(crate) mod image_report;
pub(crate) mod image_series;
pub(crate) mod render_into;
pub(crate) mod request;
pub(crate) mod results;
