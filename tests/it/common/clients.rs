//! Clients of a page that ask for nothing, or slowly, and hold on.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often slow clients send a byte, or take one.
const EVERY: Duration = Duration::from_millis(500);
/// How long a client waits until it comes again that was sent away.
const AGAIN: Duration = Duration::from_secs(3);
/// How long a client waits to be let in.
const PATIENCE: Duration = Duration::from_millis(20);

/// What a client does with its connection.
#[derive(Clone, Copy)]
enum Manner {
    /// It asks for nothing.
    Idle,
    /// It never comes to the end of its request's head, …
    SlowHead,
    /// … or of its body.
    SlowBody,
    /// It asks for all news, and reads none of it.
    Deaf,
    /// It takes the page byte by byte.
    SlowReader,
}

struct Client {
    manner: Manner,
    stream: Option<TcpStream>,
    /// When it comes again.
    again: Instant,
}

/// A crowd of clients; it leaves when it is dropped.
pub struct Clients {
    done: Arc<AtomicBool>,
    inside: Arc<AtomicUsize>,
    thread: Option<JoinHandle<()>>,
}

impl Clients {
    /// So many idle ones, and as many slow ones of four kinds, of a page at a host and port.
    pub fn new(host: &str, each: usize) -> Clients {
        let (done, inside) = (Arc::<AtomicBool>::default(), Arc::<AtomicUsize>::default());
        let (ended, holding) = (done.clone(), inside.clone());
        let address: SocketAddr = host.parse().unwrap();
        let slow = [Manner::SlowHead, Manner::SlowBody, Manner::Deaf, Manner::SlowReader];
        let manners = (0..each).flat_map(move |k| [Manner::Idle, slow[k % slow.len()]]);
        let now = Instant::now();
        let mut clients: Vec<_> = manners.map(|manner| Client { manner, stream: None, again: now }).collect();
        let work = move || {
            while !ended.load(Ordering::Relaxed) {
                let round = Instant::now();
                for k in 0..clients.len() {
                    if ended.load(Ordering::Relaxed) {
                        break;
                    }
                    clients[k].go_on(address);
                    let inside = clients.iter().filter(|client| client.stream.is_some()).count();
                    holding.fetch_max(inside, Ordering::Relaxed);
                }
                std::thread::sleep(EVERY.saturating_sub(round.elapsed()));
            }
        };
        Clients { done, inside, thread: Some(std::thread::spawn(work)) }
    }

    /// How many held a connection at once, at the most.
    pub fn most_inside(&self) -> usize {
        self.inside.load(Ordering::Relaxed)
    }
}

impl Client {
    /// Comes if it is outside, else sends or takes its next byte.
    fn go_on(&mut self, address: SocketAddr) {
        let Some(stream) = &mut self.stream else {
            if self.again <= Instant::now() {
                self.stream = begin(self.manner, address);
                self.again = Instant::now() + AGAIN;
            }
            return;
        };
        let mut byte = [0];
        let went_on = match self.manner {
            Manner::SlowHead | Manner::SlowBody => stream.write(b"x"),
            Manner::Idle | Manner::SlowReader => stream.read(&mut byte),
            Manner::Deaf => stream.peek(&mut byte),
        };
        let is_inside = match went_on {
            Ok(bytes) => bytes > 0,
            Err(error) => error.kind() == ErrorKind::WouldBlock,
        };
        if !is_inside {
            self.stream = None;
            self.again = Instant::now() + AGAIN;
        }
    }
}

fn begin(manner: Manner, address: SocketAddr) -> Option<TcpStream> {
    let mut stream = TcpStream::connect_timeout(&address, PATIENCE).ok()?;
    stream.set_nonblocking(true).ok()?;
    let request = match manner {
        Manner::Idle => String::new(),
        Manner::SlowHead => format!("GET / HTTP/1.1\r\nhost: {address}\r\nx-slow: "),
        Manner::SlowBody => format!(
            "POST /say HTTP/1.1\r\nhost: {address}\r\ncontent-type: application/json\r\ncontent-length: 1000\r\n\r\n"
        ),
        Manner::Deaf => format!("GET /events HTTP/1.1\r\nhost: {address}\r\n\r\n"),
        Manner::SlowReader => format!("GET / HTTP/1.1\r\nhost: {address}\r\n\r\n"),
    };
    stream.write_all(request.as_bytes()).ok()?;
    Some(stream)
}

impl Drop for Clients {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
