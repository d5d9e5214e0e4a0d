//! The connections of a live view: how many there are, and for how long.
//!
//! File descriptors are scarce, and babbling needs some to the end. So the number of connections is limited, and a new one
//! replaces the least useful: where many have not asked for anything yet the oldest of these, else the one that has taken
//! nothing for the longest. Whoever opens the page gets it and keeps it, however many clients hold on to theirs.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use nix::sys::resource::{Resource, getrlimit};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep, timeout};

use super::locked;

/// Most connections.
const MOST: u64 = 64;
/// The share of the files that the process may open which connections may take at most.
const SHARE: u64 = 4;
/// The share of connections without a request that is spared where places are scarce: newcomers need a moment to ask.
const UNASKED: usize = 4;
/// How long a client may take for the head of a request.
const HEAD: Duration = Duration::from_secs(10);
/// How long a connection is held that takes nothing. Pages are sent something more often than that.
const QUIET: Duration = Duration::from_secs(20);
/// How often connections are looked through, at least.
const LOOK: Duration = Duration::from_secs(1);
/// How long a newcomer waits for the place of another: crowds take little processor time that way.
const TURN: Duration = Duration::from_millis(2);
/// How long to wait after the system refused a connection, as it does where the process has no files left.
const RETRY: Duration = Duration::from_millis(200);
/// Bytes of a head, and of an answer that wait to be sent.
const BUFFER: usize = 64 << 10;
/// Bytes that the system keeps for a client that does not read them.
const SENT: usize = 256 << 10;

/// When a connection last asked or took something; `None` as long as it has asked for nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct LastUse(Arc<Mutex<Option<Instant>>>);

impl LastUse {
    /// It is of use now.
    pub fn note(&self) {
        *locked(&self.0) = Some(Instant::now());
    }

    fn get(&self) -> Option<Instant> {
        *locked(&self.0)
    }
}

/// A connection that is held.
struct Held {
    last_use: LastUse,
    task: AbortHandle,
}

/// Serves whoever connects, as long as it is polled. Handlers find the [`LastUse`] of their connection among the request's
/// extensions.
pub(super) async fn serve(listener: TcpListener, routes: Router) {
    // Where the system refuses it keeps more for each.
    let _ = socket2::SockRef::from(&listener).set_send_buffer_size(SENT);
    let files = getrlimit(Resource::RLIMIT_NOFILE).map_or(u64::MAX, |(soft, _)| soft);
    let most = (files / SHARE).clamp(1, MOST) as usize;
    // In the order in which they came.
    let mut held: Vec<Held> = Vec::new();
    loop {
        let came = timeout(LOOK, listener.accept()).await;
        held.retain(|connection| !connection.task.is_finished());
        let quiet = |connection: &&Held| connection.last_use.get().is_some_and(|last| last.elapsed() > QUIET);
        held.iter().filter(quiet).for_each(|connection| connection.task.abort());
        match came {
            Ok(Ok((stream, _))) => {
                if held.len() >= most {
                    // Those that came before have their turn to ask first.
                    sleep(TURN).await;
                    make_room(&mut held);
                }
                held.push(hold(stream, routes.clone()));
            }
            Ok(Err(_)) => sleep(RETRY).await,
            Err(_) => {}
        }
    }
}

/// Ends the least useful connection.
fn make_room(held: &mut Vec<Held>) {
    let uses: Vec<Option<Instant>> = held.iter().map(|connection| connection.last_use.get()).collect();
    let unasked = uses.iter().filter(|last| last.is_none()).count();
    let victim = if unasked > held.len() / UNASKED {
        uses.iter().position(Option::is_none)
    } else {
        let asked = uses.iter().enumerate().filter_map(|(k, last)| Some((k, (*last)?)));
        asked.min_by_key(|(_, last)| *last).map(|(k, _)| k)
    };
    if let Some(victim) = victim {
        held.remove(victim).task.abort();
    }
}

/// Answers a client on a task of its own.
fn hold(stream: TcpStream, routes: Router) -> Held {
    let last_use = LastUse::default();
    let (routes, noted) = (TowerToHyperService::new(routes), last_use.clone());
    let service = service_fn(move |mut request: hyper::Request<hyper::body::Incoming>| {
        noted.note();
        request.extensions_mut().insert(noted.clone());
        routes.call(request)
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD).max_buf_size(BUFFER);
    let connection = http.serve_connection(TokioIo::new(stream), service);
    let task = tokio::spawn(async move {
        // Whoever goes away, or talks nonsense, is nobody's loss.
        let _ = connection.await;
    });
    Held { last_use, task: task.abort_handle() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_useful_connection_makes_room() {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        // What is left of connections, by their numbers from 0, each with the second of its last use.
        let left = |uses: &[Option<u64>]| {
            runtime.block_on(async {
                let began = Instant::now();
                let task = || tokio::spawn(std::future::pending::<()>()).abort_handle();
                let uses = uses.iter().map(|last| last.map(|seconds| began + Duration::from_secs(seconds)));
                let of = |last| Held { last_use: LastUse(Arc::new(Mutex::new(last))), task: task() };
                let mut held: Vec<Held> = uses.map(of).collect();
                let tasks: Vec<_> = held.iter().map(|connection| connection.task.id()).collect();
                make_room(&mut held);
                let is_left = |k: &usize| held.iter().any(|connection| connection.task.id() == tasks[*k]);
                (0..tasks.len()).filter(is_left).collect::<Vec<_>>()
            })
        };
        // One has asked and reads; two idle, of which the older goes.
        assert_eq!(left(&[Some(9), None, None]), [0, 2]);
        // A newcomer among those that have asked has its moment; one of these takes nothing.
        assert_eq!(left(&[Some(9), Some(2), Some(8), None]), [0, 2, 3]);
        assert_eq!(left(&[None, None]), [1]);
        assert_eq!(left(&[]), [0usize; 0]);
    }
}
