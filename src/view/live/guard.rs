//! Which requests a live view answers, and what a browser may do with the answer.

use std::net::IpAddr;
use std::time::Duration;

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};
use tokio::time::timeout;

/// How long a request may take, its body included; what is told on and on is no longer part of it.
const ANSWER: Duration = Duration::from_secs(10);
/// What holds for every answer: no other site may show it in a frame, read it, or learn that it was asked for.
const EVERYWHERE: [(HeaderName, &str); 6] = [
    (header::CONTENT_SECURITY_POLICY, "default-src 'none'; frame-ancestors 'none'"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (header::CACHE_CONTROL, "no-store"),
];

/// Keeps other sites' pages out: a name that leads here without being this machine's (DNS rebinding), and requests
/// that a page from elsewhere makes. Who takes too long to ask is not waited for.
pub(super) async fn guard(request: Request, next: Next) -> Response {
    let mut answer = if ours(request.headers()) {
        match timeout(ANSWER, next.run(request)).await {
            Ok(answer) => answer,
            Err(_) => (StatusCode::REQUEST_TIMEOUT, "the request timed out").into_response(),
        }
    } else {
        (StatusCode::FORBIDDEN, "open this page at the address that bodyschema printed").into_response()
    };
    for (name, value) in EVERYWHERE {
        answer.headers_mut().entry(name).or_insert(HeaderValue::from_static(value));
    }
    answer
}

/// What a page may do in which one script runs, that one alone: it speaks to this server, draws what is in it, and
/// loads nothing.
pub(super) fn policy(script: &str) -> String {
    let hash = STANDARD.encode(Sha256::digest(script));
    format!(
        "default-src 'none'; script-src 'sha256-{hash}'; style-src 'unsafe-inline'; img-src data:; connect-src 'self'; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )
}

/// Whether a request is for an address, not for a name, and comes from no other site.
fn ours(headers: &HeaderMap) -> bool {
    let text = |name| headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
    let Some(host) = text(header::HOST) else { return false };
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.chars().all(|c| c.is_ascii_digit()) => name,
        _ => host,
    };
    let name = name.trim_start_matches('[').trim_end_matches(']');
    let here = name == "localhost" || name.parse::<IpAddr>().is_ok();
    here && headers
        .get(header::ORIGIN)
        .is_none_or(|origin| origin.as_bytes() == format!("http://{host}").as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_sites_are_kept_out() {
        let is_ours = |host: &str, origin: Option<&str>| {
            let mut headers = HeaderMap::new();
            headers.insert(header::HOST, host.parse().unwrap());
            if let Some(origin) = origin {
                headers.insert(header::ORIGIN, origin.parse().unwrap());
            }
            ours(&headers)
        };
        assert!(is_ours("127.0.0.1:8042", None));
        assert!(is_ours("localhost:8042", Some("http://localhost:8042")));
        assert!(is_ours("[::1]:8042", Some("http://[::1]:8042")));
        assert!(is_ours("192.168.0.7", None));
        assert!(!is_ours("elsewhere.example:8042", None));
        assert!(!is_ours("127.0.0.1:8042", Some("http://elsewhere.example")));
        assert!(!is_ours("127.0.0.1:8042", Some("null")));
        assert!(!ours(&HeaderMap::new()));
    }

    #[test]
    fn a_script_is_known_by_its_hash() {
        // The example of hashes in Content Security Policy Level 3.
        let policy = policy("alert('Hello, world.');");
        assert!(policy.contains("'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng='"), "{policy}");
    }
}
