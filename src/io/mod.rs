//! The files: capture files, scenes, pictures. With [`raw`](crate::raw) the only modules that read or write any.

pub mod output;
