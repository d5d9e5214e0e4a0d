//! The report as a browser shows it: every picture holds data, nothing is fetched and nothing complains.
//!
//! It takes Chromium. Where there is none the tests say so and are skipped, unless `BODYSCHEMA_BROWSER=required`.

#[path = "common/browser.rs"]
mod browser;
mod common;

use std::path::Path;
use std::sync::{Arc, Mutex};

use browser::{PATIENCE, browser, evaluate};
use common::program::succeeds;
use common::repository;
use headless_chrome::protocol::cdp::types::Event;
use headless_chrome::protocol::cdp::{Emulation, Log::LogEntryLevel, Network};
use headless_chrome::{Browser, Tab};
use serde_json::Value;

/// Every picture of a page with all there is to show.
const PICTURES: [&str; 7] =
    ["body", "curve", "joint-errors", "residuals", "uncertainty", "touch-matrix", "reachable"];
/// The most bytes of a page.
const MOST_BYTES: u64 = 8_000_000;

/// What a page said while it was opened.
#[derive(Default)]
struct Heard {
    /// Addresses that were asked for.
    requests: Vec<String>,
    /// What the console was told, and errors.
    complaints: Vec<String>,
}

/// Opens a page and waits until the pictures that it begins with are drawn.
fn open(browser: &Browser, page: &Path) -> (Arc<Tab>, Heard) {
    let tab = browser.new_tab().unwrap();
    tab.set_default_timeout(PATIENCE);
    tab.enable_log().unwrap().enable_runtime().unwrap();
    tab.call_method(Network::Enable {
        max_total_buffer_size: None,
        max_resource_buffer_size: None,
        max_post_data_size: None,
        report_direct_socket_traffic: None,
        enable_durable_messages: None,
    })
    .unwrap();
    let heard = Arc::new(Mutex::new(Heard::default()));
    let listener = heard.clone();
    let listen = move |event: &Event| {
        let mut heard = listener.lock().unwrap();
        match event {
            Event::NetworkRequestWillBeSent(sent) => heard.requests.push(sent.params.request.url.clone()),
            Event::RuntimeExceptionThrown(thrown) => heard.complaints.push(format!("{:?}", thrown.params)),
            Event::RuntimeConsoleAPICalled(called) => heard.complaints.push(format!("{:?}", called.params)),
            // Browsers also log advice on speed, which is no complaint.
            Event::LogEntryAdded(added) if added.params.entry.level == LogEntryLevel::Error => {
                heard.complaints.push(added.params.entry.text.clone());
            }
            _ => {}
        }
    };
    tab.add_event_listener(Arc::new(listen)).unwrap();
    let address = format!("file://{}", page.display());
    tab.navigate_to(&address).unwrap();
    tab.wait_for_element("html[data-drawn]").unwrap();
    let mut heard = std::mem::take(&mut *heard.lock().unwrap());
    heard.requests.retain(|request| *request != address && !request.starts_with("data:"));
    (tab, heard)
}

/// The share of a picture that is drawn on, and how many colours it has, a pixel of three.
fn pixels(tab: &Tab, picture: &str) -> (f64, u64) {
    let script = format!(
        r#"await (async () => {{
            const place = document.getElementById("{picture}");
            const image = new Image();
            image.src = await Plotly.toImage(place, {{ format: "png", width: 600, height: 500 }});
            await image.decode();
            const canvas = document.createElement("canvas");
            [canvas.width, canvas.height] = [600, 500];
            const context = canvas.getContext("2d");
            context.drawImage(image, 0, 0);
            const data = context.getImageData(0, 0, 600, 500).data;
            const colours = new Set();
            let drawn = 0;
            for (let i = 0; i < data.length; i += 12) {{
                if (data[i + 3] < 16) continue;
                drawn += 1;
                colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
            }}
            return [drawn / (data.length / 12), colours.size];
        }})()"#
    );
    let found = evaluate(tab, &script);
    (found[0].as_f64().unwrap(), found[1].as_u64().unwrap())
}

#[test]
fn every_picture_is_drawn_and_nothing_is_fetched() {
    let Some(browser) = browser() else { return };
    let place = tempfile::tempdir().unwrap();
    let model = repository("mjcf/max/max.xml");
    let model = model.to_str().unwrap();
    succeeds(place.path(), &["babble", model, "--touches", "100", "--input", "contact", "--out", "max"]);
    succeeds(place.path(), &["space", "max", "--voxel", "0.08"]);
    succeeds(place.path(), &["report", "max"]);
    let page = place.path().join("max/report.html");
    let bytes = std::fs::metadata(&page).unwrap().len();
    assert!(bytes <= MOST_BYTES, "{bytes} bytes");

    let (tab, heard) = open(&browser, &page);
    assert_eq!(heard.requests, Vec::<String>::new());
    assert_eq!(heard.complaints, Vec::<String>::new());
    // The DOM: every picture is there, with its traces and something drawn.
    for picture in PICTURES {
        let script = format!(
            r##"await (async () => {{
                const place = document.getElementById("{picture}");
                place.scrollIntoView();
                while (place.dataset.drawn === undefined) await new Promise((done) => setTimeout(done, 20));
                const size = (t) => Math.max(...["x", "y", "z"].map((k) => (t[k] ? t[k].length : 0)));
                return [place.data.map(size), place.querySelectorAll("svg.main-svg").length,
                        place.scrollWidth <= place.clientWidth];
            }})()"##
        );
        let found = evaluate(&tab, &script);
        let points: Vec<u64> = found[0].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect();
        // A hundred touches are learned from at two checkpoints.
        assert!(points.iter().sum::<u64>() >= 4, "{picture}: {points:?}");
        assert!(found[1].as_u64().unwrap() >= 1, "{picture} is not drawn");
        assert_eq!(found[2], Value::Bool(true), "{picture} is wider than its place");
        let (share, colours) = pixels(&tab, picture);
        assert!(share > 0.01 && colours > 20, "{picture}: {share} of it drawn on in {colours} colours");
    }
    let text = evaluate(&tab, "document.body.innerText");
    for words in ["babble", "--touches 100", "cores", "MuJoCo", "Seed", "What stays undetermined"] {
        assert!(text.as_str().unwrap().to_lowercase().contains(&words.to_lowercase()), "{words}");
    }

    // The slider leads from the onset, in which the body is elsewhere, to what was learned.
    let steps =
        evaluate(&tab, r#"document.getElementById("body").layout.sliders[0].steps.map((s) => s.label)"#);
    let steps = steps.as_array().unwrap();
    assert_eq!((&steps[0], steps.last().unwrap()), (&Value::from("onset"), &Value::from("100")));
    let reach = |tab: &Tab| evaluate(tab, r#"Math.max(...document.getElementById("body").data[0].z)"#);
    let learned = reach(&tab).as_f64().unwrap();
    let slide = r#"await (async () => {
        const place = document.getElementById("body");
        const rail = place.querySelector(".slider-rail-touch-rect").getBoundingClientRect();
        const at = { clientX: rail.left + 1, clientY: rail.top + rail.height / 2, bubbles: true };
        const moved = new Promise((done) => place.once("plotly_restyle", done));
        place.querySelector(".slider-rail-touch-rect").dispatchEvent(new MouseEvent("mousedown", at));
        document.dispatchEvent(new MouseEvent("mouseup", at));
        await moved;
        return 0;
    })()"#;
    evaluate(&tab, slide);
    let onset = reach(&tab).as_f64().unwrap();
    assert!(learned > 0.6 && onset < 0.5, "the head is {learned} m above the pelvis, {onset} m at the onset");

    // Dark: the ink of labels is light.
    let ink = r#"getComputedStyle(document.querySelector("\#residuals .xtick text")).fill"#;
    let lightness = |tab: &Tab| {
        let fill = evaluate(tab, &ink.replace('\\', ""));
        let digits: Vec<u32> = fill
            .as_str()
            .unwrap()
            .split(|c: char| !c.is_ascii_digit())
            .filter_map(|n| n.parse().ok())
            .collect();
        digits[..3].iter().sum::<u32>() / 3
    };
    assert!(lightness(&tab) < 100);
    tab.call_method(Emulation::SetEmulatedMedia {
        media: None,
        features: Some(vec![Emulation::MediaFeature {
            name: "prefers-color-scheme".into(),
            value: "dark".into(),
        }]),
    })
    .unwrap();
    evaluate(&tab, "await new Promise((done) => setTimeout(() => done(0), 500))");
    assert!(lightness(&tab) > 160);
    assert!(tab.print_to_pdf(None).unwrap().starts_with(b"%PDF"));
}

#[test]
fn a_recording_has_a_page_without_the_truth() {
    let Some(browser) = browser() else { return };
    let place = tempfile::tempdir().unwrap();
    let model = repository("mjcf/max/max.xml");
    let model = model.to_str().unwrap();
    let babble =
        ["babble", model, "--touches", "60", "--input", "contact", "--learner", "hersch", "--out", "made"];
    succeeds(place.path(), &babble);
    let learn =
        ["learn", "--creature", "made/session.json", "--log", "made/touches.jsonl", "--out", "recorded"];
    succeeds(place.path(), &learn);
    let (tab, heard) = open(&browser, &place.path().join("recorded/report.html"));
    assert_eq!((heard.requests, heard.complaints), Default::default());
    let names = evaluate(&tab, r#"document.getElementById("body").data.map((trace) => trace.name || "")"#);
    assert_eq!(names, serde_json::json!(["limbs", "receptors", "bones", "joints"]));
    let (share, colours) = pixels(&tab, "body");
    assert!(share > 0.01 && colours > 20, "{share} of it drawn on in {colours} colours");
}
