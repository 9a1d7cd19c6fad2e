//! A view in the browser: light is traced once, and what sensor and development make of it answers at once.
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
//! cannot be used, 404 for what is not there, 409 for what the light does not serve, 413, 429, 503 for what is too much;
//! `needs_trace` says whether tracing anew would serve it.
//!
//! | request | answer |
//! |---|---|
//! | `GET ` | the page; `view.css`, `*.js` beside it |
//! | `GET about` | JSON: what is viewed, `inputs`, and the `controls` and `planes` of each |
//! | `GET events` | server-sent events: `data:` is the JSON of [`Status`], at once and whenever it changes |
//! | `GET picture?QUERY` | a picture, see below |
//! | `GET capture?QUERY` | TOML: the keys of a capture file that QUERY changes |
//! | `POST trace` | JSON `{"do": "pause" \| "continue" \| "stop"}`, or `{"do": "start", "changes": ["KEY=VALUE", …]}`, which traces anew with these changes to the capture. 204 |
//!
//! QUERY names keys of a capture file, `exposure.time_s=0.02&sensor.preset=textbook-ccd`, those of `controls` alone, so
//! that no file can be named; and besides
//!
//! | key | means |
//! |---|---|
//! | `plane` | one of `planes`: `developed` (left out), `raw`, `electrons:G`, … |
//! | `frame` | number of the frame, 0 if left out |
//! | `input` | of several inputs the one of that number, 0 if left out |
//!
//! A picture is four bytes, the length of its description (little endian); the description, JSON filled up with spaces
//! to a multiple of four; and the values, little endian, row by row from the top, the channels of a pixel together. The
//! description has `plane`, `width`, `height`, `channels` (names), `type` ("u8", "u16", "f32"), `unit`, `light` (the
//! number of the light, see [`Status`]), `exposure`, `warnings`, `seconds` that it took, and of a developed picture
//! `bits`, its codes being those of `image.png`.

mod access;
mod answer;
mod controls;
mod events;
mod exposer;
mod page;
mod picture;
mod query;
mod server;
mod source;
mod status;
mod tracer;

pub use server::{View, serve};
pub use status::{Phase, Status};
