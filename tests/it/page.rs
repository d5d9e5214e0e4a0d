//! The report as a browser shows it: every picture holds data, nothing is fetched and nothing complains.
//!
//! That needs Chromium: these tests are ignored unless they are asked for.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use base64::Engine;

use crate::common::browser::{Browser, Tab, browser};
use crate::common::program::succeeds;
use crate::common::sessions;
use crate::common::shell::copy;
use crate::common::{python, repository};
use serde_json::{Value, json};

/// Every picture of a page with all there is to show.
const PICTURES: [&str; 4] = ["body", "curve", "touch-matrix", "reachable"];
/// The most bytes of a page.
const MOST_BYTES: u64 = 1_500_000;
/// The figures of the first body that is drawn: when it was there, when the page was loaded, both in milliseconds from the
/// beginning, and how often it is drawn a second while it is turned.
const SPEED: &str = r#"await (async () => {
    const { body } = document.getElementById("body");
    const loaded = performance.getEntriesByType("navigation")[0].loadEventEnd;
    const drawn = performance.getEntriesByName("body drawn")[0].startTime;
    const [before, began] = [body.draws(), performance.now()];
    while (performance.now() - began < 2000) {
        body.turn(3, 0);
        await new Promise(requestAnimationFrame);
    }
    return [drawn, loaded, 1000 * (body.draws() - before) / (performance.now() - began)];
})()"#;

/// Plays all steps: the millimetres as they were counted, what the slider and the button say in the end, and frames a second.
const PLAYED: &str = r#"await (async () => {
    const { body } = document.getElementById("body");
    const [button, off] = [".play", ".off"].map((name) => document.querySelector(name));
    const says = button.textContent;
    const [counted, before, began] = [[], body.draws(), performance.now()];
    button.click();
    do {
        const mm = Number(off.textContent.replace("< ", "").replace(" mm", ""));
        if (counted.at(-1) !== mm) counted.push(mm);
        await new Promise(requestAnimationFrame);
    } while (button.textContent !== says);
    const rate = 1000 * (body.draws() - before) / (performance.now() - began);
    await new Promise((done) => setTimeout(done, 500));
    return [counted, document.querySelector(".slider output").textContent, button.textContent, rate];
})()"#;

/// Gives a page `settled()`, which waits until its body is not drawn any more.
const SETTLED: &str = r#"(() => {
    const { body } = document.getElementById("body");
    window.settled = async () => {
        for (let draws = -1; draws !== body.draws();) {
            draws = body.draws();
            await new Promise((done) => setTimeout(done, 1000));
        }
    };
    return 0;
})()"#;

/// Opens a page and waits until the pictures that it begins with are drawn; it fetches nothing and complains of nothing.
fn open(browser: &'static Browser, page: &Path) -> Tab {
    let address = format!("file://{}", page.display());
    let tab = browser.open(&address);
    tab.wait("document.querySelector('html[data-drawn]') !== null");
    let mut requests = tab.requests();
    requests.retain(|request| *request != address && !request.starts_with("data:"));
    assert_eq!(requests, Vec::<String>::new());
    assert_eq!(tab.complaints(), Vec::<String>::new());
    tab.evaluate(SETTLED);
    tab
}

/// The share of a core that the page takes where nobody does anything, over three seconds.
fn share_at_rest(tab: &Tab) -> f64 {
    std::thread::sleep(Duration::from_secs(1));
    tab.call("Performance.enable", json!({}));
    let metrics = || {
        let metrics = tab.call("Performance.getMetrics", json!({}))["metrics"].take();
        ["TaskDuration", "Timestamp"].map(|name| {
            let metric = metrics.as_array().unwrap().iter().find(|metric| metric["name"] == name).unwrap();
            metric["value"].as_f64().unwrap()
        })
    };
    let before = metrics();
    std::thread::sleep(Duration::from_secs(3));
    let after = metrics();
    (after[0] - before[0]) / (after[1] - before[1])
}

/// The share of a picture that is drawn on, and how many colours it has, a pixel of three: of a canvas its own pixels, of
/// a chart those that it has with the style of the page.
fn pixels(tab: &Tab, picture: &str) -> (f64, u64) {
    let script = format!(
        r##"await (async () => {{
            const place = document.getElementById("{picture}");
            let canvas = place;
            if (place.tagName !== "CANVAS") {{
                const svg = place.querySelector("svg").cloneNode(true);
                svg.setAttribute("xmlns", "http://www.w3.org/2000/svg");
                const style = document.createElementNS("http://www.w3.org/2000/svg", "style");
                style.textContent = document.querySelector("style").textContent;
                svg.prepend(style);
                const image = new Image();
                image.src = "data:image/svg+xml," + encodeURIComponent(new XMLSerializer().serializeToString(svg));
                await image.decode();
                canvas = document.createElement("canvas");
                [canvas.width, canvas.height] = [600, 500];
                canvas.getContext("2d").drawImage(image, 0, 0, 600, 500);
            }}
            const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
            const colours = new Set();
            let drawn = 0;
            for (let i = 0; i < data.length; i += 12) {{
                if (data[i + 3] < 16) continue;
                drawn += 1;
                colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
            }}
            return [drawn / (data.length / 12), colours.size];
        }})()"##
    );
    let found = tab.evaluate(&script);
    (found[0].as_f64().unwrap(), found[1].as_u64().unwrap())
}

#[test]
#[ignore = "needs Chromium and axe-core"]
fn every_picture_is_drawn_and_nothing_is_fetched() {
    let browser = browser();
    let place = tempfile::tempdir().unwrap();
    copy(sessions::max(), place.path());
    succeeds(place.path(), &["reach", "max", "--voxel", "0.08"]);
    succeeds(place.path(), &["report", "max"]);
    let page = place.path().join("max/report.html");
    let bytes = fs::metadata(&page).unwrap().len();
    assert!(bytes <= MOST_BYTES, "{bytes} bytes");

    let tab = open(browser, &page);
    // The DOM: every picture is there, with marks that say what they are and something drawn.
    for picture in PICTURES {
        let script = format!(
            r##"(() => {{
                const place = document.getElementById("{picture}");
                const words = [...place.querySelectorAll("title")].filter((title) => title.textContent.length > 3);
                return [words.length, place.scrollWidth <= place.clientWidth];
            }})()"##
        );
        let found = tab.evaluate(&script);
        assert!(picture == "body" || found[0].as_u64().unwrap() >= 4, "{picture}: {found}");
        assert_eq!(found[1], Value::Bool(true), "{picture} is wider than its place");
        let (share, colours) = pixels(&tab, picture);
        assert!(share > 0.01 && colours > 20, "{picture}: {share} of it drawn on in {colours} colours");
    }
    // All that is written at axes is within its picture.
    let cut = "[...document.querySelectorAll('svg.chart')].flatMap((svg) => {
        const all = svg.getBoundingClientRect();
        const out = (at) => at.left < all.left - 0.5 || at.right > all.right + 0.5 || at.top < all.top - 0.5 || at.bottom > all.bottom + 0.5;
        const texts = [...svg.querySelectorAll('text')].filter((text) => text.textContent.trim());
        return texts.filter((text) => out(text.getBoundingClientRect())).map((text) => text.textContent);
    })";
    assert_eq!(tab.evaluate(cut), json!([]));
    // Paper has another width than the screen that the body was drawn for: it keeps its shape.
    tab.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
    let shape = tab.evaluate(
        "(() => {
        const canvas = document.getElementById('body');
        [canvas.width, canvas.height] = [600, 150];
        const { width, height } = canvas.getBoundingClientRect();
        return width / height;
    })()",
    );
    assert!((shape.as_f64().unwrap() / 4.0 - 1.0).abs() < 0.02, "{shape}");
    let paper = json!({ "width": 700, "height": 1000, "deviceScaleFactor": 1, "mobile": false });
    tab.call("Emulation.setDeviceMetricsOverride", paper);
    let cut = tab.evaluate(
        "(() => {
        const canvas = document.getElementById('body');
        [canvas.width, canvas.height] = [300, 900];
        return [canvas.offsetHeight - canvas.parentElement.clientHeight, getComputedStyle(canvas).objectFit];
    })()",
    );
    assert!(cut[0].as_f64().unwrap() <= 0.0 && cut[1] == "contain", "{cut}");
    tab.call("Emulation.clearDeviceMetricsOverride", json!({}));
    tab.call("Emulation.setEmulatedMedia", json!({ "media": "" }));
    tab.evaluate("(() => { document.getElementById('body').body.turn(0, 0); return 0; })()");
    // A limb says how well it is located; clicked, it stands out in charts and tables, whose rows light up their limbs.
    let linked = tab.evaluate(
        r#"await (async () => {
        const canvas = document.getElementById("body");
        const box = canvas.getBoundingClientRect();
        const at = { clientX: box.left + box.width / 2, clientY: 0, pointerId: 1, bubbles: true };
        canvas.setPointerCapture = () => {};
        const click = () => ["pointerdown", "pointerup"].forEach((name) => canvas.dispatchEvent(new PointerEvent(name, at)));
        await settled();
        const before = canvas.toDataURL();
        // Wherever the body stands in its picture.
        const parts = Array.from({ length: 15 }, (_, k) => 0.15 + 0.05 * k);
        for (const [x, y] of parts.flatMap((x) => parts.map((y) => [x, y]))) {
            [at.clientX, at.clientY] = [box.left + box.width * x, box.top + box.height * y];
            click();
            if (document.querySelector(".tip").textContent) break;
        }
        const [tip, aside] = [document.querySelector(".tip").textContent, document.querySelectorAll(".aside").length];
        click();
        await settled();
        const after = canvas.toDataURL();
        const row = [...document.querySelectorAll("th")].find((name) => name.textContent === "left_hand").parentElement;
        row.dispatchEvent(new PointerEvent("pointerenter"));
        await settled();
        const lit = canvas.toDataURL();
        row.dispatchEvent(new PointerEvent("pointerleave"));
        await settled();
        return [tip, aside, document.querySelectorAll(".aside").length, before === after, lit !== after];
    })()"#,
    );
    assert!(linked[0].as_str().unwrap().contains(": located to within "), "{linked}");
    assert!(linked[1].as_u64().unwrap() > 10 && linked[2] == 0, "{linked}");
    assert_eq!([&linked[3], &linked[4]], [&json!(true); 2]);
    tab.accessible();
    tab.picture("report");
    let speed = tab.evaluate(SPEED);
    let [drawn, loaded, turning] = [0, 1, 2].map(|k| speed[k].as_f64().unwrap());
    eprintln!(
        "{bytes} bytes; body drawn after {drawn:.0} ms, loaded after {loaded:.0} ms; {turning:.1} frames a second"
    );
    // How fast depends on the machine, so that only a page that stands still fails.
    assert!(turning > 1.0, "{turning} frames a second");
    let share = share_at_rest(&tab);
    eprintln!("{share:.4} of a core at rest");
    assert!(share < 0.05, "{share} of a core at rest");
    let text = tab.evaluate("document.body.innerText");
    for words in ["babble", "--touches 1000", "cores", "MuJoCo", "Seed", "Undetermined joints and limbs"] {
        assert!(text.as_str().unwrap().to_lowercase().contains(&words.to_lowercase()), "{words}");
    }

    // The slider leads from the initial guess, in which the body is elsewhere, to what was learned.
    let steps = tab.evaluate("JSON.parse(document.querySelector('figure.body script').textContent).steps");
    let names: Vec<&str> =
        steps.as_array().unwrap().iter().map(|step| step["name"].as_str().unwrap()).collect();
    assert_eq!((names[0], *names.last().unwrap()), ("initial guess", "1000"));
    let highest = r#"Math.max(...document.getElementById("body").body.poses.learned.begins.filter((_, k) => k % 3 === 2))"#;
    // Places are told in tenths of millimetres.
    let reach = |tab: &Tab| tab.evaluate(highest).as_f64().unwrap() / 1e4;
    let picture = |tab: &Tab| tab.evaluate(r#"document.getElementById("body").toDataURL()"#);
    let (learned, before) = (reach(&tab), picture(&tab));
    let slide = r#"await (async () => {
        const slider = document.querySelector(".slider input");
        slider.value = 0;
        slider.dispatchEvent(new Event("input"));
        await new Promise((done) => setTimeout(done, 500));
        return document.querySelector(".slider output").textContent;
    })()"#;
    assert_eq!(tab.evaluate(slide), "initial guess");
    let initial_guess = reach(&tab);
    assert!(
        learned > 0.5 && initial_guess < 0.5,
        "the neck is {learned} m above the pelvis, {initial_guess} m at the initial guess"
    );
    assert_ne!(picture(&tab), before);

    // Played, it comes from there to the end, limbs moving between steps and millimetres counting down.
    let played = tab.evaluate(PLAYED);
    let counted: Vec<f64> = played[0].as_array().unwrap().iter().map(|mm| mm.as_f64().unwrap()).collect();
    assert!(counted.len() > 2 && counted[0] > 50.0 && *counted.last().unwrap() < 1.0, "{counted:?}");
    assert_eq!((&played[1], &played[2]), (&json!("1000"), &json!("▶ play learning")));
    eprintln!("{:.1} frames a second while it is played", played[3].as_f64().unwrap());
    assert_eq!(reach(&tab), learned);

    // What is switched off is not drawn; auras and neighbours are off at first.
    let switch = |which: &str| {
        tab.evaluate(&format!(
            r#"await (async () => {{
                document.querySelectorAll(".switches input{which}").forEach((box) => box.click());
                await new Promise((done) => setTimeout(done, 500));
                return 0;
            }})()"#
        ))
    };
    switch(":checked");
    assert_eq!(pixels(&tab, "body"), (0.0, 0));
    // Auras are veils that fill much of it, the map is of lines.
    switch("[data-layer='auras']");
    assert!(pixels(&tab, "body").0 > 0.01, "{:?}", pixels(&tab, "body"));
    switch("[data-layer='auras']");
    assert_eq!(pixels(&tab, "body"), (0.0, 0));
    switch("[data-layer='neighbouring receptors']");
    let (lines, _) = pixels(&tab, "body");
    assert!((0.001..0.2).contains(&lines), "{lines}");
    switch("[data-layer='neighbouring receptors']");

    // Dark: the ink of labels is light.
    let ink = r#"getComputedStyle(document.querySelector("\#curve text")).fill"#;
    let lightness = |tab: &Tab| {
        let fill = tab.evaluate(&ink.replace('\\', ""));
        let digits: Vec<u32> = fill
            .as_str()
            .unwrap()
            .split(|c: char| !c.is_ascii_digit())
            .filter_map(|n| n.parse().ok())
            .collect();
        digits[..3].iter().sum::<u32>() / 3
    };
    assert!(lightness(&tab) < 100);
    let dark = json!({ "name": "prefers-color-scheme", "value": "dark" });
    tab.call("Emulation.setEmulatedMedia", json!({ "features": [dark] }));
    tab.evaluate("await new Promise((done) => setTimeout(() => done(0), 500))");
    assert!(lightness(&tab) > 160);
    let printed = tab.call("Page.printToPDF", json!({}));
    let pdf = base64::engine::general_purpose::STANDARD.decode(printed["data"].as_str().unwrap()).unwrap();
    let pdf = String::from_utf8_lossy(&pdf);
    let sheets = pdf.matches("/Type /Page\n").count();
    assert!(pdf.starts_with("%PDF-") && (1..=3).contains(&sheets), "printed on {sheets} sheets");
}

#[test]
#[ignore = "needs Chromium and axe-core"]
fn a_recording_has_a_page_without_the_truth() {
    let browser = browser();
    let place = tempfile::tempdir().unwrap();
    copy(sessions::max(), place.path());
    let learn =
        ["learn", "--creature", "max/session.json", "--log", "max/touches.jsonl", "--out", "recorded"];
    succeeds(place.path(), &learn);
    let tab = open(browser, &place.path().join("recorded/report.html"));
    tab.accessible();
    tab.picture("recording");
    let names = tab
        .evaluate("[...document.querySelectorAll('.switches label')].map((label) => label.innerText.trim())");
    assert_eq!(names, serde_json::json!(["limbs", "receptors", "joints", "auras", "neighbouring receptors"]));
    let (share, colours) = pixels(&tab, "body");
    assert!(share > 0.01 && colours > 20, "{share} of it drawn on in {colours} colours");
}

/// A place of the picture, pixels from its top left, where a limb far from the middle can be pulled, and that limb.
const HANDLE: &str = r#"(() => {
    const canvas = document.getElementById("body");
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const shares = Array.from({ length: 90 }, (_, k) => 0.05 + 0.01 * k);
    const places = shares.flatMap((x) => shares.map((y) => [x * width, y * height]));
    const far = ([x, y]) => Math.hypot(x - width / 2, y - height / 2);
    const pulled = places.filter((place) => canvas.body.handleAt(place));
    const at = pulled.reduce((best, place) => (far(place) > far(best) ? place : best));
    return [at[0] + left, at[1] + top, width / 2 + left, height / 2 + top, canvas.body.handleAt(at)];
})()"#;
/// How far the body's coordinates are beyond their ranges, and how many differ from those of the rest posture; `null` at rest.
const POSTURE: &str = r#"(() => {
    const { kinematics, posture } = document.getElementById("body").body;
    const now = posture();
    if (!now) return null;
    const beyond = kinematics.dofs.map(({ kind, coordinate, range: [low, high] }) => {
        const x = kind === "ball" ? 2 * Math.acos(Math.min(1, Math.abs(now[coordinate]))) : now[coordinate];
        return Math.max(low - x, x - high);
    });
    return [Math.max(...beyond), now.filter((x, k) => Math.abs(x - kinematics.rest[k]) > 1e-3).length];
})()"#;

/// Asserts that the body has left its rest posture and is within the ranges of its joints.
fn in_a_posture(tab: &Tab, how: &str) {
    let posture = tab.evaluate(POSTURE);
    assert!(!posture.is_null(), "{how}: it stays at rest");
    assert!(posture[0].as_f64().unwrap() < 1e-9, "{how}: a joint is beyond its range: {posture}");
    assert!(posture[1].as_u64().unwrap() > 0, "{how}: nothing has moved");
}

/// Presses a key, with Shift or without.
fn press(tab: &Tab, key: &str, shift: bool) {
    for kind in ["keyDown", "keyUp"] {
        tab.call(
            "Input.dispatchKeyEvent",
            json!({ "type": kind, "key": key, "modifiers": 8 * u8::from(shift) }),
        );
    }
}

#[test]
#[ignore = "needs Chromium and axe-core"]
fn limbs_are_pulled_by_mouse_finger_and_keys_within_the_ranges_of_joints() {
    let browser = browser();
    let place = tempfile::tempdir().unwrap();
    copy(sessions::max(), place.path());
    // It has hinges, slides and a ball.
    let model = repository("mjcf/contraption/contraption.xml");
    succeeds(place.path(), &["babble", model.to_str().unwrap(), "--out", "contraption"]);
    for session in ["max", "contraption"] {
        let tab = open(browser, &place.path().join(session).join("report.html"));
        let said =
            || tab.evaluate("document.querySelector('.said').textContent").as_str().unwrap().to_string();
        let picture =
            || tab.evaluate("await settled().then(() => document.getElementById('body').toDataURL())");
        assert_eq!(tab.evaluate("document.querySelector('.hint').textContent"), "Drag a limb to pull it.");
        let at_rest = picture();
        let at = tab.evaluate(HANDLE);
        let number = |k: usize| at[k].as_f64().unwrap();
        let ([x, y], handle) = ([number(0), number(1)], &at[4]);
        // A little towards the middle, where it can be: the limb's point is then under the pointer.
        let towards = |share: f64| [x + share * (number(2) - x), y + share * (number(3) - y)];
        let mouse = |kind: &str, [x, y]: [f64; 2]| {
            let at = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 });
            tab.call("Input.dispatchMouseEvent", at);
        };
        mouse("mousePressed", [x, y]);
        (1..=10).for_each(|k| mouse("mouseMoved", towards(0.015 * f64::from(k))));
        mouse("mouseReleased", towards(0.15));
        in_a_posture(&tab, "mouse");
        let sentence = said();
        assert!(sentence.contains("located") && sentence.contains("It gets "), "{sentence}");
        let off = tab.evaluate(&format!(
            "(() => {{
                const canvas = document.getElementById('body');
                const {{ left, top }} = canvas.getBoundingClientRect();
                return canvas.body.farFrom({handle}, [{} - left, {} - top]);
            }})()",
            towards(0.15)[0],
            towards(0.15)[1]
        ));
        let (off, reached) = (off.as_f64().unwrap(), sentence.contains("It gets there."));
        assert!(!reached || off < 3.0, "{off} pixels from the pointer: {sentence}");
        assert_ne!(picture(), at_rest);
        // Far outside it cannot be: it says how near it gets.
        mouse("mousePressed", towards(0.15));
        mouse("mouseMoved", [x, y]);
        mouse("mouseMoved", [number(2), number(3) - 2000.0]);
        mouse("mouseReleased", [number(2), number(3) - 2000.0]);
        in_a_posture(&tab, "out of reach");
        assert!(said().contains("It gets to within "), "{}", said());
        tab.picture(&format!("pulled-{session}"));

        // Esc goes back to the rest posture; keys choose limbs and pull them, and the list says which.
        tab.evaluate("(() => { document.getElementById('body').focus(); return 0; })()");
        press(&tab, "Escape", false);
        assert_eq!((tab.evaluate(POSTURE), picture()), (Value::Null, at_rest.clone()));
        press(&tab, "p", false);
        let chosen = tab.evaluate("document.querySelector('.limb select').selectedOptions[0].textContent");
        assert!(said().starts_with(chosen.as_str().unwrap()), "{chosen}: {}", said());
        assert!(tab.evaluate("document.querySelectorAll('.aside').length").as_u64().unwrap() > 5);
        ["ArrowLeft", "ArrowUp", "ArrowRight"].iter().for_each(|key| press(&tab, key, true));
        in_a_posture(&tab, "keys");
        tab.accessible();
        press(&tab, "Escape", false);

        // A finger on a limb pulls it, and does not scroll the page.
        let finger = |kind: &str, at: &[[f64; 2]]| {
            let points: Vec<Value> = at.iter().map(|[x, y]| json!({ "x": x, "y": y })).collect();
            tab.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }));
        };
        finger("touchStart", &[[x, y]]);
        (1..=10).for_each(|k| finger("touchMove", &[towards(0.02 * f64::from(k))]));
        finger("touchEnd", &[]);
        in_a_posture(&tab, "finger");
        assert_eq!(tab.evaluate("scrollY"), 0);
        assert_eq!(tab.complaints(), Vec::<String>::new());

        // A mark of a chart that names receptors shows them, from the keyboard as well; a limb that is chosen dims the others'.
        let before = picture();
        tab.evaluate("(() => { document.getElementById('curve').focus(); return 0; })()");
        press(&tab, "ArrowRight", false);
        let mark = tab.evaluate("document.querySelector('#curve + .mark').textContent");
        assert!(mark.as_str().unwrap().starts_with("touch 1, "), "{mark}");
        assert_ne!(picture(), before, "the receptors of touch 1 are not shown");
        tab.evaluate("(() => { document.getElementById('curve').blur(); return 0; })()");
        assert_eq!(picture(), before);
        let dimmed = "(() => {
            const list = document.querySelector('.limb select');
            [list.value] = [list.options[3].value];
            list.dispatchEvent(new Event('change'));
            const dots = [...document.querySelectorAll('#curve circle')].filter((dot) => /^touch .*, /.test(dot.textContent));
            return [dots.length, dots.filter((dot) => dot.classList.contains('aside')).length];
        })()";
        let dots = tab.evaluate(dimmed);
        let [all, aside] = [0, 1].map(|k| dots[k].as_u64().unwrap());
        assert!(all > 20 && 0 < aside && aside < all, "{aside} of {all} touches are dimmed");
    }
}

#[test]
#[ignore = "needs Chromium, axe-core and mdbook"]
fn the_site_is_accessible_and_complains_of_nothing() {
    let browser = browser();
    let mut site = Command::new(repository(".ci/site"));
    site.arg(env!("CARGO_BIN_EXE_bodyschema")).arg(python::packages().join("bin/mdbook"));
    let made = site.output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let book = repository("target/book");
    let pages = fs::read_dir(&book).unwrap().map(|entry| entry.unwrap().path());
    // Pages of the documents; the others are mdbook's own.
    let written = |page: &std::path::PathBuf| {
        let name = page.file_stem().unwrap().to_str().unwrap();
        page.extension().is_some_and(|ending| ending == "html") && !["404", "print", "toc"].contains(&name)
    };
    let mut count = 0;
    for page in pages.filter(written) {
        let tab = browser.open(&format!("file://{}", page.display()));
        assert_eq!(tab.complaints(), Vec::<String>::new(), "{}", page.display());
        eprintln!("{}", page.display());
        tab.accessible();
        count += 1;
    }
    assert!(count > 20, "{count} pages");
    // The first has the live body in it.
    let tab = browser.open(&format!("file://{}", book.join("max/report.html").display()));
    tab.wait("document.querySelector('.hint') !== null");
}
