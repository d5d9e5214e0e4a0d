//! The web server of a live view.

use std::convert::Infallible;
use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, RawQuery, State};
use axum::http::{StatusCode, header};
use axum::middleware::from_fn;
use axum::response::sse::{Event, Sse};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Extension, Json, Router};
use futures_util::stream::{self, Stream};
use serde::Deserialize;
use tokio::sync::{oneshot, watch};
use tokio::time::{MissedTickBehavior, timeout};

use super::connections::{LastUse, serve};
use super::guard::{guard, policy};
use super::locked;
use crate::view::report;
use crate::view::script;

/// How often pages are told what is new.
const EVERY: Duration = Duration::from_millis(50);
/// How long pages have to take in the last of it.
const LAST: Duration = Duration::from_millis(400);
/// How often a page is told that it is still served where nothing is new.
const STILL: Duration = Duration::from_secs(1);
/// The longest line that is heard, characters, …
const LONGEST_LINE: usize = 500;
/// … and the longest body of a request, bytes: such a line in the longest of all ways to write it as JSON.
const LONGEST_BODY: usize = 16 << 10;
/// What a page shows.
pub trait LivePage: Send + Sync + 'static {
    /// The page, before anything has happened; `query` is what its address asks for after the question mark. `None` if there
    /// is no such page.
    fn page(&self, query: &str) -> Option<String>;
    /// What to show next to everyone, as JSON: asked for at every tick as long as anyone looks.
    fn newest(&self) -> String {
        "{}".into()
    }
    /// What changes slowly: charts by the ids of their places, as a JSON object of SVG.
    fn charts(&self) -> String {
        "{}".into()
    }
    /// The report to read, once there is one.
    fn report(&self) -> Option<PathBuf> {
        None
    }
    /// Takes what a page asks for, and waits for nobody.
    fn ask(&self, _asked: Asked) -> Reception {
        Err(StatusCode::NOT_FOUND)
    }
}

/// The answer to what a page asks for: JSON for the browser that asked, or nothing if it will be heard; an error if there is no such
/// thing or nobody to hear it, or too much waits to be heard already.
pub type Reception = Result<Option<String>, StatusCode>;

/// What a page asks for, as in `{"say": "hello"}`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Asked {
    /// A line that was typed.
    Say(String),
    /// A touch of a receptor, by its index.
    Touch(usize),
    /// To be shown something.
    Show(ShowRequest),
}

/// What a browser looks at. It says all of it each time.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct ShowRequest {
    /// One of the sessions, by its number from 0.
    pub session: usize,
    /// Another of them beside it, or none.
    pub beside: Option<usize>,
    /// A touch, counted from 1; 0 for the rest posture.
    pub touch: usize,
    /// A posture instead: coordinates in the creature's order, radians and metres.
    pub posture: Option<Vec<f64>>,
}

/// A server that runs until it is dropped.
pub struct Server {
    address: SocketAddr,
    /// What ends it, and the thread that ends then.
    running: Option<(oneshot::Sender<()>, JoinHandle<()>)>,
}

#[derive(Clone)]
struct Shared {
    view: Arc<dyn LivePage>,
    /// The page that was asked for last, and by which query.
    page: Arc<Mutex<Option<(String, Bytes)>>>,
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
                let shared = Shared { view, page: Arc::default(), newest: watch::Sender::new("{}".into()) };
                tokio::spawn(tell(shared.clone()));
                tokio::spawn(serve(listener, routes(shared)));
                // Whoever drops the server wants it to end, too.
                let _ = asked_to_quit.await;
            });
        };
        let thread = std::thread::Builder::new().name("live".into()).spawn(work)?;
        Ok(Server { address, running: Some((quit, thread)) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        std::thread::sleep(LAST);
        if let Some((quit, thread)) = self.running.take() {
            let _ = quit.send(());
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
        .route("/", get(page))
        .route("/charts", get(charts))
        .route("/events", get(events))
        .route("/report", get(finished_report))
        .route("/ask", post(ask))
        .layer(DefaultBodyLimit::max(LONGEST_BODY))
        .layer(from_fn(guard))
        .with_state(shared)
}

async fn page(State(shared): State<Shared>, RawQuery(query): RawQuery) -> Response {
    let query = query.unwrap_or_default();
    let page = {
        let mut kept = locked(&shared.page);
        match &*kept {
            Some((of, page)) if *of == query => Some(page.clone()),
            _ => shared.view.page(&query).map(|page| kept.insert((query, page.into())).1.clone()),
        }
    };
    answer(page, super::SCRIPT, "no such page: leave out everything after the question mark")
}

async fn charts(State(shared): State<Shared>) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], shared.view.charts())
}

/// The state whenever it is new. A client that cannot follow misses the states in between.
async fn events(
    State(shared): State<Shared>,
    Extension(last_use): Extension<LastUse>,
) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let first = shared.newest.receiver_count() == 0;
    let mut news = shared.newest.subscribe();
    if first {
        // While nobody looked nothing was sent.
        shared.newest.send_replace(shared.view.newest().into());
    }
    // Whoever comes late gets the state as it is.
    news.mark_changed();
    Sse::new(stream::unfold((news, last_use), |(mut news, last_use)| async {
        let event = match timeout(STILL, news.changed()).await {
            Ok(changed) => {
                changed.ok()?;
                Event::default().data(&**news.borrow_and_update())
            }
            Err(_) => Event::default().comment("nothing new"),
        };
        // It is asked for only where the client has taken what came before.
        last_use.note();
        Some((Ok(event), (news, last_use)))
    }))
}

async fn finished_report(State(shared): State<Shared>) -> Response {
    let page = shared.view.report().and_then(|path| std::fs::read(path).ok());
    answer(page, report::SCRIPT, "no report yet: it is written when learning is complete")
}

async fn ask(State(shared): State<Shared>, Json(asked): Json<Asked>) -> Response {
    let asked = match asked {
        Asked::Say(text) => Asked::Say(text.trim().chars().take(LONGEST_LINE).collect()),
        other => other,
    };
    match shared.view.ask(asked) {
        Ok(None) => StatusCode::NO_CONTENT.into_response(),
        Ok(Some(json)) => ([(header::CONTENT_TYPE, "application/json")], json).into_response(),
        Err(refused) => refused.into_response(),
    }
}

/// A page in which one script runs; what is missing is said where there is no such page.
fn answer(page: Option<impl Into<Bytes>>, own_script: &str, missing: &'static str) -> Response {
    match page {
        Some(page) => {
            let policy = [(header::CONTENT_SECURITY_POLICY, policy(&script(own_script)))];
            (policy, Html(page.into())).into_response()
        }
        None => (StatusCode::NOT_FOUND, missing).into_response(),
    }
}
