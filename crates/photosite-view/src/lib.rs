//! View in the browser: light is traced once, and the images that sensor and development make of it answer at once.
//!
//! A server on this machine gives one page, and what the page asks for. Nothing is loaded from elsewhere.
//!
//! # Who is answered
//!
//! The address is `http://127.0.0.1:PORT/TOKEN/`, with a token of 128 random bits as the first part of each path, which
//! relative addresses in the page carry along. A request is refused with 403 where its path does not begin with the
//! token; where its `Host` is neither an IP address nor `localhost` (a page elsewhere may let a name of its own point
//! here); and where `Origin` or `Sec-Fetch-Site` say that another page asks.
//!
//! # What is answered
//!
//! Paths are those after the token. Errors are JSON, `{"message", "help", "needs_trace"}`, with the status 400 for what
//! cannot be used, 404 for what is not there, 409 for what the light does not serve, 413, 414, 503 for what is too
//! much; `needs_trace` says whether tracing anew would serve it.
//!
//! | request | answer |
//! |---|---|
//! | `GET ` | the page, `view.css` and scripts beside it |
//! | `GET about` | JSON: `version`; `name`; `has_sheet`; `inputs`, each with `name` and `kind` ("scene", "light", "file", or "image" of a data set); `controls`, each with `key`, `group`, `label`, `unit`, `about`, and `kind`: "linear" with `min`, `max`, `step`; "logarithmic" and "whole" with `min`, `max`; "choice" and "several" with `options`, each `name` and `about`; "flag" |
//! | `GET events` | server-sent events: `data:` is the JSON of [`Status`], at once and whenever it changes |
//! | `GET image?QUERY` | an image, see below |
//! | `GET pixel?x=X&y=Y&QUERY` | JSON of a pixel that sees light, counted from the top left: `electrons` with `[channel, mean, sigma]` each, `raw` and `developed` with `[channel, value]` each; `null` where there is none |
//! | `GET noise?QUERY` | JSON `{"noise_ratio"}`: noise of light transport over that of the sensor at the exposure of QUERY; `null` where it is not known |
//! | `GET capture?QUERY` | TOML: the capture as QUERY and the trace have changed it, with absolute paths, which renders to the image that is shown; at its head the keys that were changed. Of a raw file the keys of its development |
//! | `GET sheet` | JSON of a data set: `cameras`; `frames`; `images`, in the order of `inputs`, each with `frame`, `camera`, `time_s`, and `facts`, by which they differ; `widths` of small images |
//! | `GET image?input=N&width=W` | an image of a data set: `image.png`, or without too many pixels as JPEG |
//! | `GET overlays?input=N` | JSON of what is drawn over it: [`Overlays`](photosite_dataset::Overlays) |
//! | `POST trace` | JSON `{"do": "pause" \| "continue" \| "stop"}`, or `{"do": "start", "changes": {KEY: VALUE, …}, "frame": N}`, which traces anew with these changes in place of earlier ones: poses of `camera`, some of `lens`, `sensor.preset`, `output.irradiance` and `output.ideal`; `frame`, 0 if left out, is the one whose light is traced where camera or scene move. 204 |
//!
//! QUERY names keys of a capture file, `exposure.time_s=0.02&sensor.preset=textbook-ccd`, those of `controls` alone, so
//! that no file can be named; values of "several" are separated by commas. Besides there are
//!
//! | key | means |
//! |---|---|
//! | `plane` | one of `planes`: `developed` (left out), `raw`, `electrons:G`, `sigma:G`, `noise:read_noise_e`, `truth:depth`, `irradiance:550`, `ideal` |
//! | `frame` | number of the frame; left out, 0, or that whose light is traced |
//! | `input` | of several inputs the one of that number, 0 if left out |
//! | `view` | `x0,y0,x1,y1`: these pixels alone, x1 and y1 excluded |
//! | `screen` | `columns,rows` that show them: of more than 2^20 pixels means come, as fine as the screen, of instances and materials every few |
//! | `step` | number of columns and rows from one pixel that is sent to the next, without averaging |
//!
//! An image is four bytes, the length of its description (little endian); the description, JSON filled up with spaces
//! to a multiple of four; and the values, little endian, row by row from the top, the channels of a pixel together. The
//! description has `plane`, `width`, `height`, and where these pixels lie: `full` (columns and rows of the whole
//! image), `at` (the first column and row), `step` (columns and rows from one to the next) and `is_mean`; `channels`
//! (names), `type` ("u8", "u16", "f32"), `unit`; `light`, the number of the light (see [`Status`]); `planes`, all that
//! there are; `settings`, by the keys of the controls, as they are; `stages`, those that the sensor has, which alone
//! can be left out to some effect; `sensors`, the presets that the light tells of without tracing anew; `anew`, keys of
//! controls for which it is traced anew; `raw` with `black_dn`, `white_dn`, `bits`, `active` (column, row, columns and
//! rows of the pixels that see light) and `tile` (names of the filters, rows of them); `warnings`; and `seconds` that
//! it took. The values of `developed` are the codes of `image.png`.

#![forbid(unsafe_code)]

mod access;
mod answer;
mod changes;
mod connection;
mod controls;
mod events;
mod exposer;
mod guests;
mod page;
mod plane;
mod query;
mod recent;
mod sent_image;
mod server;
mod settings;
mod sheet;
mod source;
mod status;
mod tracer;
mod window;

pub use server::{View, serve};
pub use source::{Input, OpenFile};
pub use status::{CameraState, Phase, Status};
pub use tracer::Outside;
