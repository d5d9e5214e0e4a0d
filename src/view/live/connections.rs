//! The connections of a live view: how many there are, and for how long.
//!
//! Files are what a process has few of, and who babbles needs some to the end. So only so many connections are held,
//! and a new one takes the place of whichever is of the least use. Where many have asked for nothing yet it is the one
//! that has been there for the longest without, else the one on which nothing has moved for the longest. Who opens the page
//! gets it, and who reads it keeps it, however many hold on to theirs.

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
use nix::sys::resource::{Resource, getrlimit};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep, timeout};

/// Most connections, …
const MOST: u64 = 64;
/// … and the share of the files that the process may open which they may take at the most.
const SHARE: u64 = 4;
/// The share of them that those who have asked for nothing yet are left with when places are scarce: newcomers need a
/// moment to ask.
const UNASKED: usize = 4;
/// How long a client may take for the head of a request, and leave a connection without one.
const HEAD: Duration = Duration::from_secs(10);
/// How long nothing may move on a connection. Pages are told something more often than that.
const QUIET: Duration = Duration::from_secs(20);
/// How often connections are looked through, at least.
const LOOK: Duration = Duration::from_secs(1);
/// How long a newcomer waits for the place of another: crowds take little of the processor so, and a browser waits no
/// longer among those that the system lets wait before the door.
const TURN: Duration = Duration::from_millis(2);
/// How long the system is left alone after it refused a connection, as it does where the process has no files left.
const RETRY: Duration = Duration::from_millis(200);
/// Bytes of a head, and of an answer that wait to be sent.
const BUFFER: usize = 64 << 10;
/// Bytes that the system keeps for a client that does not read them.
const SENT: usize = 256 << 10;

/// A connection that is held.
struct Held {
    /// When it came, milliseconds after the server began.
    came: u64,
    use_of_it: Arc<Use>,
    task: AbortHandle,
}

impl Held {
    fn has_asked(&self) -> bool {
        self.use_of_it.asked.load(Ordering::Relaxed)
    }

    /// When something moved on it, milliseconds after the server began.
    fn moved(&self) -> u64 {
        self.use_of_it.moved.load(Ordering::Relaxed)
    }
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
            if u128::from(now.saturating_sub(connection.moved())) > QUIET.as_millis() {
                connection.task.abort();
            }
        }
        match came {
            Ok(Ok((stream, _))) => {
                if held.len() >= most {
                    // Those who came before have their turn to ask first.
                    sleep(TURN).await;
                    make_room(&mut held);
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
    let files = getrlimit(Resource::RLIMIT_NOFILE).map_or(u64::MAX, |(soft, _)| soft);
    (files / SHARE).clamp(1, MOST) as usize
}

fn milliseconds(began: Instant) -> u64 {
    u64::try_from(began.elapsed().as_millis()).unwrap_or(u64::MAX)
}

/// Ends the connection that is of the least use.
fn make_room(held: &mut Vec<Held>) {
    let unasked = held.iter().filter(|connection| !connection.has_asked()).count();
    let spare_unasked = unasked <= held.len() / UNASKED;
    let usefulness = |connection: &Held| match connection.has_asked() {
        true => (!spare_unasked, connection.moved()),
        false => (spare_unasked, connection.came),
    };
    if let Some((k, _)) = held.iter().enumerate().min_by_key(|(_, connection)| usefulness(connection)) {
        held.swap_remove(k).task.abort();
    }
}

/// Answers a client on a task of its own.
fn hold(stream: TcpStream, routes: Router, began: Instant) -> Held {
    let came = milliseconds(began);
    let use_of_it = Arc::new(Use { moved: came.into(), ..Use::default() });
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
    Held { came, use_of_it, task: task.abort_handle() }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left of connections, by when they came, each with whether it has asked and when something moved on it.
    fn left(connections: &[(u64, bool, u64)]) -> Vec<u64> {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(async {
            let task = tokio::spawn(std::future::pending::<()>()).abort_handle();
            let held = |&(came, asked, moved): &(u64, bool, u64)| {
                let use_of_it = Arc::new(Use { asked: asked.into(), moved: moved.into() });
                Held { came, use_of_it, task: task.clone() }
            };
            let mut held: Vec<Held> = connections.iter().map(held).collect();
            make_room(&mut held);
            let mut left: Vec<u64> = held.iter().map(|connection| connection.came).collect();
            left.sort_unstable();
            left
        })
    }

    #[test]
    fn who_asks_for_nothing_makes_room_and_then_who_takes_nothing() {
        // The first has asked and reads; two idle, one of them sending bytes of a head.
        assert_eq!(left(&[(1, true, 9000), (2, false, 9500), (3, false, 3)]), [1, 3]);
        // A newcomer among those who have asked has its moment; of these one takes nothing.
        assert_eq!(left(&[(1, true, 9000), (2, true, 2000), (3, true, 9500), (4, false, 4)]), [1, 3, 4]);
        // Newcomers alone.
        assert_eq!(left(&[(1, false, 1), (2, false, 2)]), [2]);
        assert_eq!(left(&[]), [0u64; 0]);
    }
}
