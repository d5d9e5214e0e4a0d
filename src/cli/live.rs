//! `--live`: a page to watch what is done while it is done, or to take part in it.

use std::io::{BufRead, ErrorKind, IsTerminal};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::Path;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use super::happening::happens;
use super::typed::Typed;
use super::{Failure, Outcome, output};
use crate::interaction::{Conversation, Reply};
use crate::session::{Embodied, LearnedSession, SessionSetup};
use crate::simulation::Stage;
use crate::view::live::{Asked, BabblingView, LivePage, LookingView, Server, TableView};
use crate::view::report::REPORT_FILE;

/// Where a page is served unless told otherwise; where that port is taken, at a free one.
const HERE: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8042);
const HERE_TEXT: &str = "127.0.0.1:8042";
/// How often a page that shows a scene is told of it.
const SHOWN_EVERY: Duration = Duration::from_millis(30);
/// How long a touch is seen before anything is done about it.
const SEEN: Duration = Duration::from_millis(300);
/// How late simulated time may be to be caught up with: what is later has stood still to think.
const LATE: Duration = Duration::from_millis(100);

/// Most requests of pages that wait while he is at one.
const MOST_ASKED: usize = 16;

/// Where a page is served: taken already.
pub struct Place {
    listener: TcpListener,
    /// Whether a browser is to show it.
    open: bool,
}

/// Whether there is a page, and where.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct LiveOptions {
    /// Serve a page to watch it live in a browser, for this machine alone unless another address is given
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
        let place = self.live.map(listen).transpose()?;
        Ok(place.map(|listener| Place { listener, open: self.open }))
    }
}

/// An address from the command line.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    let alone = || text.parse::<IpAddr>().map(|address| SocketAddr::new(address, HERE.port()));
    text.parse().or_else(|_| alone()).map_err(|_| {
        format!("give an address and a port, as in {HERE_TEXT}, or put --live last to have the page there")
    })
}

/// A page that is served, on which a session is watched.
pub struct Live {
    view: Arc<BabblingView>,
    server: Server,
}

impl Live {
    /// Serves a page about babbling, of which some touches are made already, and tells where.
    pub fn new(
        place: Place,
        embodied: &Embodied,
        setup: &SessionSetup,
        made: usize,
    ) -> Result<Live, Failure> {
        let touches = setup.babbling.touches;
        let view = Arc::new(BabblingView::new(embodied.agent(), embodied.truth(), touches, made));
        let server = serve(place, view.clone())?;
        Ok(Live { view, server })
    }

    /// What observes the session.
    pub fn view(&self) -> &BabblingView {
        &self.view
    }

    /// All is learned and written down.
    pub fn done(&self, folder: &Path, learned: &LearnedSession) {
        self.view.done(&learned.record.verdict, &learned.learned.schema, folder.join(REPORT_FILE));
    }

    /// All is done: who sits before a terminal can go on looking until they end it.
    pub fn rest(&self) {
        if std::io::stdin().is_terminal() && std::io::stderr().is_terminal() {
            tell!("done; http://{}/ stays until Enter or Ctrl-C", self.server.address());
            let _ = std::io::stdin().lock().read_line(&mut String::new());
        }
    }
}

/// Where a page is to be served that is all there is to a command.
pub fn place_at(address: Option<SocketAddr>, open: bool) -> Result<Place, Failure> {
    Ok(Place { listener: listen(address.unwrap_or(HERE))?, open })
}

/// A page to look at, until nobody wants it any more.
pub fn look(view: LookingView, place: Place) -> Outcome {
    let _server = serve(place, Arc::new(view))?;
    if std::io::stdin().is_terminal() {
        tell!("the page stays until Enter or Ctrl-C");
        let _ = std::io::stdin().lock().read_line(&mut String::new());
        return Ok(());
    }
    // Nobody types: a script, or the system that started it, ends it by a signal.
    tell!("the page stays until this process is ended, as by `kill {}`", std::process::id());
    loop {
        std::thread::park();
    }
}

fn listen(address: SocketAddr) -> Result<TcpListener, Failure> {
    let listener = match TcpListener::bind(address) {
        Err(error) if error.kind() == ErrorKind::AddrInUse && address == HERE => {
            TcpListener::bind(SocketAddr::new(HERE.ip(), 0))
        }
        bound => bound,
    };
    listener.map_err(|error| {
        Failure(format!("no page can be served at {address} ({error}): give another address with --live"))
    })
}

fn serve(place: Place, view: Arc<dyn LivePage>) -> Result<Server, Failure> {
    let server = Server::new(place.listener, view)
        .map_err(|error| Failure(format!("no page can be served ({error}): go on without --live")))?;
    tell!("live at http://{}/", server.address());
    if !server.address().ip().is_loopback() {
        tell!("whoever reaches that address can see the page, and talk there if it is of a conversation");
    }
    if place.open
        && let Err(error) = open::that_detached(format!("http://{}/", server.address()))
    {
        tell!("no browser can be opened ({error}): open that address yourself");
    }
    Ok(server)
}

/// What is heard of a partner.
enum Heard {
    Asked(Asked),
    /// Standard input has ended.
    End,
}

/// A conversation on a page and on standard input, with which it ends.
pub fn talk(mut conversation: Conversation, stage: &Stage, place: Place, name: &str, json: bool) -> Outcome {
    let (ask, asked) = mpsc::sync_channel(MOST_ASKED);
    let view = Arc::new(TableView::new(stage, ask)?);
    let server = serve(place, view.clone())?;
    let (looked_on, mut shown) = (view.clone(), Instant::now());
    let (mut clock, mut simulated) = (Instant::now(), stage.time());
    stage.watched_by(Box::new(move |stage, felt| {
        // No faster than it would really be.
        let (really, here) = (clock.elapsed(), Duration::from_secs_f64((stage.time() - simulated).max(0.0)));
        if really > here + LATE {
            (clock, simulated) = (Instant::now(), stage.time());
        }
        std::thread::sleep(here.saturating_sub(really));
        if shown.elapsed() >= SHOWN_EVERY {
            looked_on.shows(stage, felt);
            shown = Instant::now();
        }
    }));
    let (hear, heard) = mpsc::sync_channel(0);
    let typed = hear.clone();
    std::thread::spawn(move || {
        let Ok(mut lines) = Typed::new() else { return };
        // Who never typed a line, as where standard input is /dev/null, is no partner to end it.
        let mut partner = lines.in_terminal();
        while let Ok(Some(line)) = lines.line() {
            partner = true;
            if !line.is_empty() && typed.send(Heard::Asked(Asked::Say(line))).is_err() {
                return;
            }
        }
        if partner {
            let _ = typed.send(Heard::End);
        }
    });
    std::thread::spawn(move || asked.iter().try_for_each(|asked| hear.send(Heard::Asked(asked))));
    tell!("{name} listens, on the page and here");
    while let Ok(Heard::Asked(asked)) = heard.recv() {
        if let Asked::Say(text) = &asked
            && let Some(direction) = text.strip_prefix('/')
        {
            let told = happens(stage, direction).unwrap_or_else(|Failure(why)| why);
            view.says("the scene", &told, false);
            view.shows(stage, &[]);
            tell!("{told}");
            continue;
        }
        let (request, reply) = answered(&mut conversation, &view, asked)?;
        view.shows(stage, &[]);
        view.says(name, &reply.said, false);
        if json {
            output::line(format_args!("{}", reply.to_json(&request)));
        } else {
            say!("> {request}\n{}", reply.said);
        }
        if conversation.is_over() {
            break;
        }
    }
    view.ends();
    drop(server);
    Ok(())
}

/// What is asked in words, and the answer once it is done.
fn answered(
    conversation: &mut Conversation,
    view: &TableView,
    asked: Asked,
) -> Result<(String, Reply), Failure> {
    match asked {
        Asked::Say(text) => {
            view.says("you", &text, true);
            Ok((text.clone(), conversation.hear(&text)?))
        }
        Asked::Touch(receptor) => {
            let id = &conversation.actor.own.skin().receptors[receptor].id;
            let text = format!("(touches {id})");
            view.says("you", &text, true);
            view.feels(&[receptor]);
            std::thread::sleep(SEEN);
            Ok((text, conversation.touched(receptor)?))
        }
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
