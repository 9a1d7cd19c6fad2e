//! Access to the server: only those who have its address, from its own pages, are answered.

use std::net::IpAddr;

use hyper::header::{HOST, ORIGIN};
use hyper::{HeaderMap, Method, Request};

use photosite_core::{Error, Result};

/// Bytes of a token.
const TOKEN_BYTES: usize = 16;

/// The token in the address, without which nothing is answered.
pub(super) struct Access {
    token: String,
}

/// Reason why a request is refused.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Refusal(pub(super) &'static str);

impl Access {
    /// A token that is given.
    pub(super) fn with_token(token: String) -> Result<Self> {
        let is_plain = token.bytes().all(|byte| byte.is_ascii_alphanumeric());
        if token.len() >= 2 * TOKEN_BYTES && is_plain {
            return Ok(Self { token });
        }
        let message = format!("the token of the address has to have at least {} letters and digits", 2 * TOKEN_BYTES);
        Err(Error::Usage { message, help: Some("for example what `openssl rand -hex 16` gives".into()) })
    }

    /// A token that nobody can guess.
    pub(super) fn random() -> Result<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(|reason| Error::Resources {
            message: format!("the system does not provide random numbers: {reason}"),
            help: None,
        })?;
        Ok(Self { token: bytes.iter().map(|byte| format!("{byte:02x}")).collect() })
    }

    /// The first part of all paths.
    pub(super) fn token(&self) -> &str {
        &self.token
    }

    /// The path behind the token, without its slash; `None` where the slash is missing.
    pub(super) fn path<'a, B>(&self, request: &'a Request<B>) -> Result<Option<&'a str>, Refusal> {
        let headers = request.headers();
        let host = text(headers, HOST.as_str()).unwrap_or_default();
        // Of two hosts it is not known which one the browser means.
        if !is_address(host) || headers.get_all(HOST).iter().count() > 1 {
            return Err(Refusal("this server answers only at its address, 127.0.0.1 or localhost, not at a name"));
        }
        let path = request.uri().path().strip_prefix('/').unwrap_or_default();
        let (token, rest) = path.split_once('/').map_or((path, None), |(token, rest)| (token, Some(rest)));
        if !is_same(token, &self.token) {
            return Err(Refusal("open the address that photosite view has printed: it ends with a token"));
        }
        let own = format!("http://{host}");
        let is_foreign = headers.get(ORIGIN).is_some_and(|origin| origin.as_bytes() != own.as_bytes());
        if is_foreign || is_sent_elsewhere(request.method(), headers) {
            return Err(Refusal("the request comes from another page, and this server only answers its own"));
        }
        Ok(rest)
    }
}

fn text<'a>(headers: &'a HeaderMap, name: &str) -> Option<&'a str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

/// Whether a host is an address, which nobody can let point elsewhere, or means this machine.
fn is_address(host: &str) -> bool {
    let is_port = |port: &str| port.parse::<u16>().is_ok();
    let name = match host.rsplit_once(':') {
        Some((name, port)) if is_port(port) && (!name.contains(':') || name.ends_with(']')) => name,
        Some(_) | None => host,
    };
    let literal = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    name.eq_ignore_ascii_case("localhost") || literal.parse::<IpAddr>().is_ok()
}

/// Whether the browser says that a page of another origin sends this. A link from there is followed.
fn is_sent_elsewhere(method: &Method, headers: &HeaderMap) -> bool {
    let follows_link = method == Method::GET && text(headers, "sec-fetch-mode") == Some("navigate");
    let site = text(headers, "sec-fetch-site");
    !follows_link && site.is_some_and(|site| site != "same-origin" && site != "none")
}

/// Compares without telling by its time how much is equal.
fn is_same(given: &str, token: &str) -> bool {
    let differences = given.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    given.len() == token.len() && differences == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(path: &str, headers: &[(&str, &str)]) -> Result<Option<String>, Refusal> {
        let access = Access { token: "ab12".to_owned() };
        let request =
            headers.iter().fold(Request::builder().uri(path), |request, (name, value)| request.header(*name, *value));
        access.path(&request.body(()).expect("a request")).map(|rest| rest.map(str::to_owned))
    }

    #[test]
    fn who_has_the_token_is_answered() {
        assert_eq!(asked("/ab12/view.js", &[("host", "127.0.0.1:8000")]), Ok(Some("view.js".to_owned())));
        assert_eq!(asked("/ab12", &[("host", "127.0.0.1:8000")]), Ok(None));
        for path in ["/", "/view.js", "/ab1/view.js", "/ab123/view.js", "/AB12/", "//ab12/"] {
            assert!(asked(path, &[("host", "127.0.0.1:8000")]).is_err(), "{path}");
        }
    }

    #[test]
    fn names_of_others_are_refused() {
        for host in ["127.0.0.1:80", "localhost:8000", "LocalHost", "[::1]:8000", "[::1]", "192.168.1.7:9"] {
            assert!(asked("/ab12/", &[("host", host)]).is_ok(), "{host}");
        }
        for host in
            ["evil.example", "evil.example:8000", "127.0.0.1.evil.example", "localhost.evil.example", "", "127.0.0.1:x"]
        {
            assert!(asked("/ab12/", &[("host", host)]).is_err(), "{host}");
        }
        assert!(asked("/ab12/", &[]).is_err());
        assert!(asked("/ab12/", &[("host", "127.0.0.1:8000"), ("host", "evil.example")]).is_err());
    }

    #[test]
    fn other_origins_are_refused() {
        let host = ("host", "127.0.0.1:8000");
        assert!(asked("/ab12/trace", &[host, ("origin", "http://127.0.0.1:8000")]).is_ok());
        for origin in ["null", "https://127.0.0.1:8000", "http://127.0.0.1:8001", "http://evil.example"] {
            assert!(asked("/ab12/trace", &[host, ("origin", origin)]).is_err(), "{origin}");
        }
        let link = [host, ("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate")];
        assert!(asked("/ab12/", &link).is_ok());
        for site in ["cross-site", "same-site"] {
            assert!(asked("/ab12/", &[host, ("sec-fetch-site", site), ("sec-fetch-mode", "no-cors")]).is_err());
        }
        assert!(asked("/ab12/", &[host, ("sec-fetch-site", "same-origin"), ("sec-fetch-mode", "cors")]).is_ok());
    }
}
