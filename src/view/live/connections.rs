//! The connections of a live view: how many there are, and for how long.
//!
//! Files are what a process has few of, and who babbles needs some to the end. So only so many connections are held,
//! and a new one takes the place of whichever has been of the least use: of one that has asked for nothing, else of the
//! one on which nothing has moved for the longest. Who opens the page gets it, however many hold on to theirs.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::Router;
use hyper::rt::{Read, ReadBufCursor, Write};
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep, timeout};

/// Most connections, …
const MOST: u64 = 64;
/// … and the share of the files that the process may open which they may take at the most.
const SHARE: u64 = 4;
/// How long a client may take for the head of a request, and leave a connection without one.
const HEAD: Duration = Duration::from_secs(10);
/// How long nothing may move on a connection. Pages are told something more often than that.
const QUIET: Duration = Duration::from_secs(20);
/// How often connections are looked through, at least.
const LOOK: Duration = Duration::from_secs(1);
/// How long a newcomer waits for the place of another: who comes in crowds takes little of the processor so.
const TURN: Duration = Duration::from_millis(10);
/// How long the system is left alone after it refused a connection, as it does where the process has no files left.
const RETRY: Duration = Duration::from_millis(200);
/// Bytes of a head, and of an answer that wait to be sent.
const BUFFER: usize = 64 << 10;
/// Bytes that the system keeps for a client that does not read them.
const SENT: usize = 256 << 10;

/// A connection that is held.
struct Held {
    use_of_it: Arc<Use>,
    task: AbortHandle,
}

/// What use a connection is.
#[derive(Default)]
struct Use {
    /// Whether a request came.
    asked: AtomicBool,
    /// When something moved on it, milliseconds after the server began.
    moved: AtomicU64,
}

/// A client's stream, which notes when something moves on it.
struct Watched {
    stream: TokioIo<TcpStream>,
    use_of_it: Arc<Use>,
    began: Instant,
}

/// Serves whoever connects, as long as it is polled.
pub(super) async fn serve(listener: TcpListener, routes: Router) {
    // Where the system refuses it keeps more for each.
    let _ = socket2::SockRef::from(&listener).set_send_buffer_size(SENT);
    let (most, began) = (most(), Instant::now());
    let mut held: Vec<Held> = Vec::new();
    loop {
        let came = timeout(LOOK, listener.accept()).await;
        let now = milliseconds(began);
        held.retain(|connection| !connection.task.is_finished());
        for connection in &held {
            let moved = connection.use_of_it.moved.load(Ordering::Relaxed);
            if u128::from(now.saturating_sub(moved)) > QUIET.as_millis() {
                connection.task.abort();
            }
        }
        match came {
            Ok(Ok((stream, _))) => {
                if held.len() >= most {
                    make_room(&mut held);
                    sleep(TURN).await;
                }
                held.push(hold(stream, routes.clone(), began));
            }
            Ok(Err(_)) => sleep(RETRY).await,
            Err(_) => {}
        }
    }
}

/// Most connections that this process may hold.
fn most() -> usize {
    let files = rlimit::Resource::NOFILE.get_soft().unwrap_or(u64::MAX);
    (files / SHARE).clamp(1, MOST) as usize
}

fn milliseconds(began: Instant) -> u64 {
    u64::try_from(began.elapsed().as_millis()).unwrap_or(u64::MAX)
}

/// Ends the connection that is of the least use.
fn make_room(held: &mut Vec<Held>) {
    let usefulness = |connection: &Held| {
        let Use { asked, moved } = &*connection.use_of_it;
        (asked.load(Ordering::Relaxed), moved.load(Ordering::Relaxed))
    };
    if let Some((k, _)) = held.iter().enumerate().min_by_key(|(_, connection)| usefulness(connection)) {
        held.swap_remove(k).task.abort();
    }
}

/// Answers a client on a task of its own.
fn hold(stream: TcpStream, routes: Router, began: Instant) -> Held {
    let use_of_it = Arc::new(Use { moved: milliseconds(began).into(), ..Use::default() });
    let watched = Watched { stream: TokioIo::new(stream), use_of_it: use_of_it.clone(), began };
    let (routes, asked) = (TowerToHyperService::new(routes), use_of_it.clone());
    let service = service_fn(move |request| {
        asked.asked.store(true, Ordering::Relaxed);
        routes.call(request)
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD).max_buf_size(BUFFER);
    let connection = http.serve_connection(watched, service);
    let task = tokio::spawn(async move {
        // Who goes away, or talks nonsense, is nobody's loss.
        let _ = connection.await;
    });
    Held { use_of_it, task: task.abort_handle() }
}

impl Watched {
    fn note<T>(&self, came: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if let Poll::Ready(Ok(_)) = came {
            self.use_of_it.moved.store(milliseconds(self.began), Ordering::Relaxed);
        }
        came
    }
}

impl Read for Watched {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: ReadBufCursor<'_>,
    ) -> Poll<io::Result<()>> {
        let came = Pin::new(&mut self.stream).poll_read(context, buffer);
        self.note(came)
    }
}

impl Write for Watched {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let came = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.note(came)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let came = Pin::new(&mut self.stream).poll_write_vectored(context, bytes);
        self.note(came)
    }
}
