//! The web server of a live view.

use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use tokio::sync::{oneshot, watch};
use tokio::time::MissedTickBehavior;
use tokio_stream::wrappers::WatchStream;
use tokio_stream::{Stream, StreamExt};

/// How often pages are told what is new.
const EVERY: Duration = Duration::from_millis(50);
/// How long pages have to take in the last of it.
const LAST: Duration = Duration::from_millis(400);
/// The longest line that is heard, characters.
const LONGEST_LINE: usize = 500;

/// What a page shows.
pub trait LivePage: Send + Sync + 'static {
    /// The page, before anything has happened.
    fn page(&self) -> String;
    /// The newest state, as JSON.
    fn newest(&self) -> String;
    /// What changes slowly: charts by the ids of their places, as a JSON object of SVG.
    fn charts(&self) -> String {
        "{}".into()
    }
    /// The report to read, once there is one.
    fn report(&self) -> Option<PathBuf> {
        None
    }
    /// Takes what a page asks for; whether anyone listens.
    fn ask(&self, _asked: Asked) -> bool {
        false
    }
}

/// What a page asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Asked {
    /// A line that was typed.
    Say(String),
    /// A touch of a receptor, by its index.
    Touch(usize),
}

/// A server that runs until it is dropped.
pub struct Server {
    address: SocketAddr,
    quit: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Clone)]
struct Shared {
    view: Arc<dyn LivePage>,
    newest: watch::Sender<Arc<str>>,
}

impl Server {
    /// Serves a view on a thread of its own.
    ///
    /// # Errors
    /// Where the system refuses a socket or a thread.
    pub fn new(listener: TcpListener, view: Arc<dyn LivePage>) -> std::io::Result<Server> {
        let address = listener.local_addr()?;
        listener.set_nonblocking(true)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (quit, asked_to_quit) = oneshot::channel::<()>();
        let work = move || {
            runtime.block_on(async {
                let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
                let shared = Shared { view, newest: watch::Sender::new("{}".into()) };
                tokio::spawn(tell(shared.clone()));
                tokio::spawn(async move { axum::serve(listener, routes(shared)).await });
                // Whoever drops the server wants it to end, too.
                let _ = asked_to_quit.await;
            });
        };
        let thread = std::thread::Builder::new().name("live".into()).spawn(work)?;
        Ok(Server { address, quit: Some(quit), thread: Some(thread) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        std::thread::sleep(LAST);
        if let Some(quit) = self.quit.take() {
            let _ = quit.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Puts the newest state into words as long as anyone looks.
async fn tell(shared: Shared) {
    let mut ticks = tokio::time::interval(EVERY);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    loop {
        ticks.tick().await;
        if shared.newest.receiver_count() > 0 {
            let state = shared.view.newest();
            shared.newest.send_if_modified(|before| {
                let news = **before != *state;
                if news {
                    *before = state.into();
                }
                news
            });
        }
    }
}

fn routes(shared: Shared) -> Router {
    Router::new()
        .route("/", get(|State(shared): State<Shared>| async move { Html(shared.view.page()) }))
        .route("/charts", get(charts))
        .route("/events", get(events))
        .route("/report", get(report))
        .route("/say", post(say))
        .route("/touch", post(touch))
        .layer(from_fn(guard))
        .with_state(shared)
}

/// Keeps other sites' pages out: a name that leads here without being this machine's (DNS rebinding), and requests
/// that a page from elsewhere makes.
async fn guard(request: Request, next: Next) -> Response {
    if ours(request.headers()) {
        next.run(request).await
    } else {
        (StatusCode::FORBIDDEN, "open this page by the address that bodyschema printed").into_response()
    }
}

/// Whether a request is for an address, not for a name, and comes from no other site.
fn ours(headers: &HeaderMap) -> bool {
    let text = |name| headers.get(name).and_then(|value: &header::HeaderValue| value.to_str().ok());
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

async fn charts(State(shared): State<Shared>) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], shared.view.charts())
}

/// The state whenever it is new. Who cannot follow misses what was in between.
async fn events(State(shared): State<Shared>) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let news = WatchStream::from_changes(shared.newest.subscribe());
    // Who comes late is told where things stand.
    let now: Arc<str> = shared.view.newest().into();
    let states = tokio_stream::once(now).chain(news);
    Sse::new(states.map(|state| Ok(Event::default().data(&*state)))).keep_alive(KeepAlive::default())
}

async fn report(State(shared): State<Shared>) -> Response {
    let page = shared.view.report().and_then(|path| std::fs::read_to_string(path).ok());
    match page {
        Some(page) => Html(page).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no report yet: it is written once all is learned")
            .into_response(),
    }
}

#[derive(Deserialize)]
struct SayRequest {
    text: String,
}

#[derive(Deserialize)]
struct TouchRequest {
    receptor: usize,
}

async fn say(State(shared): State<Shared>, Json(SayRequest { text }): Json<SayRequest>) -> StatusCode {
    heard(&shared, Asked::Say(text.trim().chars().take(LONGEST_LINE).collect()))
}

async fn touch(
    State(shared): State<Shared>,
    Json(TouchRequest { receptor }): Json<TouchRequest>,
) -> StatusCode {
    heard(&shared, Asked::Touch(receptor))
}

fn heard(shared: &Shared, asked: Asked) -> StatusCode {
    if shared.view.ask(asked) { StatusCode::NO_CONTENT } else { StatusCode::NOT_FOUND }
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
}
