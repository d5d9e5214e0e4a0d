//! Clients that hold on to their connections take nothing from who babbles, nor from who looks.

use std::time::{Duration, Instant};

use nix::sys::resource::{Resource, getrlimit, setrlimit};
use serde_json::Value;

use crate::common::browser::browser;
use crate::common::clients::Clients;
use crate::common::repository;
use crate::common::served::Served;

/// Idle clients, and as many slow ones.
const EACH: usize = 60;
/// Files that a process may have open: fewer than there are clients.
const FILES: u32 = 64;

/// What a session made: touches, and how many a second.
struct Babbled {
    touches: u64,
    rate: f64,
}

fn babbled(folder: &std::path::Path) -> Babbled {
    let text = std::fs::read_to_string(folder.join("session.json")).unwrap();
    let session: Value = serde_json::from_str(&text).unwrap();
    let log = std::fs::read_to_string(folder.join("touches.jsonl")).unwrap();
    // The first line is the header.
    let touches = log.lines().count() as u64 - 1;
    Babbled { touches, rate: touches as f64 / session["effort"]["babbling_s"].as_f64().unwrap() }
}

#[test]
fn babbling_ends_well_with_more_clients_than_files() {
    let place = tempfile::tempdir().unwrap();
    let model = repository("mjcf/max/max.xml");
    let babble = ["babble", model.to_str().unwrap(), "--policy", "random", "--touches", "2000"];
    let babble = [&babble[..], &["--learner", "hersch", "--out", "max"]].concat();
    let served = Served::within(place.path(), FILES, &babble);
    let clients = Clients::new(served.host(), EACH);
    std::thread::sleep(Duration::from_millis(500));
    // Whoever comes gets the page while they hold on.
    let page = served.answer("GET", "/", "host: HERE\r\n", "");
    assert!(page.starts_with("HTTP/1.1 200") && page.ends_with("</html>\n"));
    let (status, said) = served.end();
    assert!(status.success(), "{said}");
    assert!(clients.most_inside() > FILES as usize / 8, "{} clients", clients.most_inside());
    assert_eq!(babbled(&place.path().join("max")).touches, 2000);
    assert!(place.path().join("max/report.html").exists());
}

#[test]
#[ignore = "needs Chromium"]
fn a_browser_gets_its_page_beside_clients_that_hold_on() {
    let browser = browser();
    let place = tempfile::tempdir().unwrap();
    let model = repository("mjcf/max/max.xml");
    let babble = ["babble", model.to_str().unwrap(), "--policy", "random", "--touches", "1000000"];
    let served = Served::within(place.path(), FILES, &[&babble[..], &["--out", "max"]].concat());
    let _clients = Clients::new(served.host(), EACH);
    std::thread::sleep(Duration::from_millis(500));
    let tab = browser.open(&served.address);
    tab.wait("!!window.live && window.live.updates > 20");
    tab.wait("document.querySelector('#made .line')?.getAttribute('d').split('L').length > 3");
    let updates = tab.evaluate("window.live.updates").as_f64().unwrap();
    tab.wait(&format!("window.live.updates > {updates} + 20"));
    // Its own policy refuses nothing of the page: not its style, its script, its drawings, its news.
    let complaints = tab.complaints();
    let refused = complaints.iter().filter(|complaint| complaint.contains("Content Security Policy")).count();
    assert_eq!(refused, 0, "{complaints:?}");
}

#[test]
fn answers_are_nobody_elses() {
    let place = tempfile::tempdir().unwrap();
    let model = repository("mjcf/max/max.xml");
    let babble = ["babble", model.to_str().unwrap(), "--policy", "random", "--touches", "1000000"];
    let served = Served::new(place.path(), &[&babble[..], &["--out", "max"]].concat());
    for path in ["/", "/charts", "/report", "/nowhere"] {
        let answer = served.answer("GET", path, "host: HERE\r\n", "").to_lowercase();
        let head = answer.split("\r\n\r\n").next().unwrap();
        for header in ["x-frame-options: deny", "x-content-type-options: nosniff", "frame-ancestors 'none'"] {
            assert!(head.contains(header), "{path}: {head}");
        }
    }
    let page = served.answer("GET", "/", "host: HERE\r\n", "");
    assert!(page.contains("script-src 'sha256-") && !page.contains("'unsafe-eval'"));

    // What is asked is short, and comes from this page.
    let json = "host: HERE\r\ncontent-type: application/json\r\n";
    let long = format!("{{\"say\":\"{}\"}}", "x".repeat(100_000));
    assert!(served.answer("POST", "/ask", json, &long).starts_with("HTTP/1.1 413"));
    let rebound = json.replace("HERE", "elsewhere.example");
    assert!(served.answer("POST", "/ask", &rebound, "{\"say\":\"rest\"}").starts_with("HTTP/1.1 403"));
    let plain = "host: HERE\r\ncontent-type: text/plain\r\n";
    assert!(served.answer("POST", "/ask", plain, "{\"say\":\"rest\"}").starts_with("HTTP/1.1 415"));
}

/// By `cargo test --release --test it large::clients -- --ignored --nocapture`.
mod large {
    use super::*;

    /// Pairs of runs, without clients and with them, in turns.
    const PAIRS: usize = 9;
    const MANY: usize = 500;

    fn median(mut values: Vec<f64>) -> f64 {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }

    #[test]
    #[ignore = "large: nine pairs of sessions, without and with 500 idle and 500 slow clients"]
    fn clients_that_are_idle_or_slow_take_nothing_from_babbling() {
        // This process has as many files open as there are clients.
        let (_, most) = getrlimit(Resource::RLIMIT_NOFILE).unwrap();
        setrlimit(Resource::RLIMIT_NOFILE, most.min(4 * MANY as u64), most).unwrap();
        let model = repository("mjcf/max/max.xml");
        let run = |each: usize| {
            let place = tempfile::tempdir().unwrap();
            let babble = ["babble", model.to_str().unwrap(), "--policy", "random", "--touches", "20000"];
            let babble = [&babble[..], &["--learner", "hersch", "--out", "max"]].concat();
            let served = Served::within(place.path(), 256, &babble);
            let clients = (each > 0).then(|| Clients::new(served.host(), each));
            std::thread::sleep(Duration::from_secs(2));
            let began = Instant::now();
            assert!(served.answer("GET", "/", "host: HERE\r\n", "").ends_with("</html>\n"));
            let page = began.elapsed().as_secs_f64();
            let (status, said) = served.end();
            assert!(status.success(), "{said}");
            let took = said.lines().find_map(|line| line.strip_prefix("took ")).expect("bash tells the time");
            let seconds: Vec<f64> = took.split(' ').map(|number| number.parse().unwrap()).collect();
            let Babbled { touches, rate } = babbled(&place.path().join("max"));
            assert_eq!(touches, 20_000);
            (rate, seconds[1] + seconds[2], page, clients.map_or(0, |clients| clients.most_inside()))
        };
        let (mut rates, mut busy) = (Vec::new(), Vec::new());
        for pair in 0..PAIRS {
            // Who comes first takes turns: the machine may be getting busier.
            let (alone, crowded) = if pair % 2 == 0 {
                let alone = run(0);
                (alone, run(MANY))
            } else {
                let crowded = run(MANY);
                (run(0), crowded)
            };
            rates.push(crowded.0 / alone.0);
            busy.push(crowded.1 / alone.1);
            eprintln!(
                "{:.0} touches a second alone, {:.0} with clients ({:.3} of it), {:.3} of its processor time; {} held \
                 connections or waited for one, and another got the page in {:.0} ms",
                alone.0,
                crowded.0,
                crowded.0 / alone.0,
                crowded.1 / alone.1,
                crowded.3,
                1e3 * crowded.2
            );
        }
        let (rate, busy) = (median(rates), median(busy));
        eprintln!("medians of {PAIRS} pairs: {rate:.3} of the rate, {busy:.3} of the processor time");
        assert!(rate > 0.95 && busy < 1.05, "{rate:.3} of the rate, {busy:.3} of the processor time");
    }
}
