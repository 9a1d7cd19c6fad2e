//! Answers of the server.

use std::convert::Infallible;

use http_body_util::combinators::BoxBody;
use http_body_util::{BodyExt, Full};
use hyper::body::Bytes;
use hyper::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName, HeaderValue, REFERRER_POLICY};
use hyper::{Response, StatusCode};
use serde_json::json;

use photosite_core::Error;

pub(super) type Body = BoxBody<Bytes, Infallible>;
pub(super) type Answer = Response<Body>;

/// Headers of all answers: nothing of other servers, in no frame of others, kept by nobody, and the token goes nowhere.
const HEADERS: [(HeaderName, &str); 6] = [
    (CACHE_CONTROL, "no-store"),
    (
        CONTENT_SECURITY_POLICY,
        "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'; form-action 'none'; base-uri 'none'",
    ),
    (REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("x-content-type-options"), "nosniff"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
];

/// A body of a media type.
pub(super) fn of_body(status: StatusCode, media_type: &'static str, body: Body) -> Answer {
    let mut answer = Response::new(body);
    *answer.status_mut() = status;
    answer.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(media_type));
    for (name, value) in HEADERS {
        answer.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    answer
}

/// Bytes of a media type.
pub(super) fn of_bytes(media_type: &'static str, bytes: impl Into<Bytes>) -> Answer {
    of_body(StatusCode::OK, media_type, Full::new(bytes.into()).boxed())
}

/// Answer of JSON.
pub(super) fn of_json(value: &serde_json::Value) -> Answer {
    of_bytes("application/json", value.to_string())
}

/// Empty answer of a request that is done.
pub(super) fn done() -> Answer {
    let body = Full::new(Bytes::new()).boxed();
    of_body(StatusCode::NO_CONTENT, "text/plain; charset=utf-8", body)
}

/// Answer of words alone, for clients that have no page.
pub(super) fn refused(status: StatusCode, words: &'static str) -> Answer {
    of_body(status, "text/plain; charset=utf-8", Full::new(Bytes::from(format!("{words}\n"))).boxed())
}

/// Failure of a request: status, message and help.
#[derive(Debug)]
pub(super) struct Failure {
    pub(super) status: StatusCode,
    pub(super) message: String,
    pub(super) help: Option<String>,
    /// Whether tracing anew would serve the request.
    pub(super) needs_trace: bool,
}

impl Failure {
    pub(super) fn new(status: StatusCode, message: impl Into<String>) -> Self {
        Self { status, message: message.into(), help: None, needs_trace: false }
    }

    pub(super) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// Failure by an error, with this status.
    pub(super) fn of(error: Error, status: StatusCode) -> Self {
        Self { status, ..Self::from(error) }
    }

    pub(super) fn answer(&self) -> Answer {
        let Self { status, message, help, needs_trace } = self;
        let value = json!({ "message": message, "help": help, "needs_trace": needs_trace });
        of_body(*status, "application/json", Full::new(Bytes::from(value.to_string())).boxed())
    }
}

impl From<Error> for Failure {
    /// Failure of a request for something that cannot be used.
    fn from(error: Error) -> Self {
        let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
        Self { help, ..Self::new(StatusCode::BAD_REQUEST, error.to_string()) }
    }
}
