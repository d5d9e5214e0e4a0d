//! `--live`: a page to follow a command live, or to take part.

use std::io::{BufRead, ErrorKind, IsTerminal};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;

use super::{Failure, Outcome};
use crate::view::live::{LivePage, LookingView, Server};

/// Where a page is served unless told otherwise; where that port is taken, at a free one.
const HERE: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8042);
const HERE_TEXT: &str = "127.0.0.1:8042";
/// Variables one of which is set where a browser has a screen. Without any, `xdg-open` would start a browser for terminals.
const DISPLAYS: [&str; 3] = ["DISPLAY", "WAYLAND_DISPLAY", "BROWSER"];

/// Where a page is served: taken already.
pub struct Place {
    listener: TcpListener,
    /// Whether a browser is to show it.
    open: bool,
}

impl Place {
    /// Takes an address, or the default one.
    pub fn new(address: Option<SocketAddr>, open: bool) -> Result<Place, Failure> {
        let address = address.unwrap_or(HERE);
        let listener = match TcpListener::bind(address) {
            Err(error) if error.kind() == ErrorKind::AddrInUse && address == HERE => {
                TcpListener::bind(SocketAddr::new(HERE.ip(), 0))
            }
            bound => bound,
        };
        let listener = listener.map_err(|error| {
            Failure(format!("cannot serve a page at {address} ({error}): give another address with --live"))
        })?;
        Ok(Place { listener, open })
    }
}

/// Whether there is a page, and where.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct LiveOptions {
    /// Serve a page to watch it live in a browser, on this machine only unless another address is given
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = HERE_TEXT, value_parser = address, help_heading = "Output")]
    live: Option<SocketAddr>,
    /// Open that page in a browser
    #[arg(long, requires = "live", help_heading = "Output")]
    open: bool,
}

impl LiveOptions {
    /// Where a page is to be served, where one is: taken at once, so that an address which cannot be had is told of
    /// before anything else is done.
    pub fn place(&self) -> Result<Option<Place>, Failure> {
        self.live.map(|address| Place::new(Some(address), self.open)).transpose()
    }
}

/// An address from the command line.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let alone = || text.parse::<IpAddr>().map(|address| SocketAddr::new(address, HERE.port()));
    text.parse().or_else(|_| alone()).map_err(|_| {
        format!("give an address and a port, such as {HERE_TEXT}, or put --live last for the default")
    })
}

/// Goes on serving where somebody sits before a terminal, until they end it; whether somebody did.
pub fn rest(server: &Server) -> bool {
    let attended = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
    if attended {
        tell!("http://{}/ is served until Enter or Ctrl-C", server.address());
        let _ = std::io::stdin().lock().read_line(&mut String::new());
    }
    attended
}

/// A page to look at, until nobody wants it any more.
pub fn look(view: LookingView, place: Place) -> Outcome {
    let server = serve(place, Arc::new(view))?;
    if rest(&server) {
        return Ok(());
    }
    // Nobody types: a script, or the system that started it, ends it by a signal.
    tell!("the page is served until this process ends (`kill {}`)", std::process::id());
    loop {
        std::thread::park();
    }
}

/// Serves a page, and opens it in a browser where that is asked for.
pub fn serve(place: Place, view: Arc<dyn LivePage>) -> Result<Server, Failure> {
    let server = Server::new(place.listener, view)
        .map_err(|error| Failure(format!("cannot serve a page ({error}): run without --live")))?;
    tell!("live at http://{}/", server.address());
    if !server.address().ip().is_loopback() {
        tell!("anyone who can reach that address can see the page, and talk there during a conversation");
    }
    if place.open {
        show(&format!("http://{}/", server.address()));
    }
    Ok(server)
}

/// Opens a page in a browser, or prints where it is.
pub fn show(page: &str) {
    let opened = match DISPLAYS.iter().any(|name| std::env::var_os(name).is_some()) {
        true => open::that_detached(page).map_err(|error| error.to_string()),
        false => Err("there is no display".into()),
    };
    if let Err(why) = opened {
        tell!("cannot open a browser ({why}): open {page} in one yourself");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_taken_with_and_without_a_port() {
        assert_eq!(address(HERE_TEXT), Ok(HERE));
        assert_eq!(address("127.0.0.1"), Ok(HERE));
        assert_eq!(address("[::1]:80").map(|address| address.port()), Ok(80));
        assert!(address("mjcf/max/max.xml").is_err_and(|error| error.contains("--live")));
    }
}
