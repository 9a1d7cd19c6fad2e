//! The files that stand for a capture or a part of it, read and written.

pub(crate) mod dataset;
pub(crate) mod init;
pub(crate) mod input;
pub(crate) mod relocate;
pub(crate) mod saved;
pub(crate) mod sections;
pub(crate) mod stored;
pub(crate) mod stored_report;
pub(crate) mod synthetic_noise;
