//! The live page as a browser shows it: it loads, draws, keeps up, and what is clicked is felt and answered.
//!
//! Where that is a browser, the test needs Chromium, and is ignored unless it is asked for.

use std::time::{Duration, Instant};

use crate::common::browser::{Browser, Tab, browser};
use crate::common::served::Served;
use crate::common::{repository, sessions};
use serde_json::{Value, json};

/// What draws bodies, in the report as well.
const VIEWER: [&str; 2] =
    [include_str!("../../src/view/body/paint.js"), include_str!("../../src/view/body/body.js")];
/// Touches that babbling has not made when the browser has seen enough.
const MANY: &str = "1000000";

fn open(browser: &'static Browser, served: &Served) -> Tab {
    let tab = browser.open(&served.address);
    tab.wait("!!window.live && window.live.updates > 0");
    tab
}

#[test]
#[ignore = "needs Chromium and axe-core"]
fn babbling_is_seen_while_it_goes_on() {
    let browser = browser();
    let place = tempfile::tempdir().unwrap();
    let model = repository("mjcf/max/max.xml");
    let arguments = ["babble", model.to_str().unwrap(), "--joints", "all", "--touches", MANY, "--out", "max"];
    let served = Served::new(place.path(), &arguments);
    let tab = open(browser, &served);
    let told = |tab: &Tab| tab.evaluate("document.getElementById('doing').textContent").to_string();
    assert!(told(&tab).contains("babbling"), "{}", told(&tab));
    tab.accessible();

    // It keeps up: how fast depends on the machine, so that only a page that stands still fails.
    let updates = |tab: &Tab| tab.evaluate("window.live.updates").as_f64().unwrap();
    let (before, words, began) = (updates(&tab), told(&tab), Instant::now());
    std::thread::sleep(Duration::from_secs(5));
    let rate = (updates(&tab) - before) / began.elapsed().as_secs_f64();
    eprintln!("{rate:.1} updates a second");
    assert!(rate > 1.0, "{rate} updates a second");
    assert_ne!(told(&tab), words);

    // Two bodies are drawn, in many colours; receptors light up and curves grow.
    let colours = r#"await (async () => {
        const place = document.getElementById("body");
        const data = place.getContext("2d").getImageData(0, 0, place.width, place.height).data;
        const colours = new Set();
        for (let i = 0; i < data.length; i += 4) {
            if (data[i + 3]) colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
        }
        return colours.size;
    })()"#;
    let colours = tab.evaluate(colours).as_u64().unwrap();
    assert!(colours > 30, "{colours} colours");
    tab.wait("document.querySelector('#made .line')?.getAttribute('d').split('L').length > 3");
    tab.wait("document.querySelectorAll('#missed circle').length > 3");

    tab.picture("babbling");
    // It is the report's viewer that draws.
    let page = served.answer("GET", "/", "host: HERE\r\n", "");
    assert!(VIEWER.iter().all(|script| page.contains(script)));

    // Other sites get nothing from it, and there is nobody to talk to.
    assert!(served.answer("GET", "/", "host: elsewhere.example\r\n", "").starts_with("HTTP/1.1 403"));
    assert!(served.answer("GET", "/report", "host: HERE\r\n", "").starts_with("HTTP/1.1 404"));
    let json = "host: HERE\r\ncontent-type: application/json\r\n";
    assert!(served.answer("POST", "/ask", json, "{\"touch\":0}").starts_with("HTTP/1.1 404"));
}

#[test]
#[ignore = "needs Chromium and axe-core"]
fn a_click_on_the_skin_is_felt_and_answered() {
    let browser = browser();
    let place = sessions::max();
    let scene = repository("mjcf/max/table.xml");
    let served = Served::new(place, &["talk", scene.to_str().unwrap(), "max"]);
    let tab = open(browser, &served);

    tab.accessible();
    tab.picture("talk");
    // Somewhere in sight on the upper right arm, which the left hand reaches.
    let session: Value =
        serde_json::from_str(&std::fs::read_to_string(place.join("max/session.json")).unwrap()).unwrap();
    let ids = session["skin"]["receptors"].as_array().unwrap().iter().map(|r| r["id"].as_str().unwrap());
    let arm: Vec<usize> =
        ids.enumerate().filter(|(_, id)| id.contains("right_forearm")).map(|(k, _)| k).collect();
    let in_sight = format!("{}.map((k) => window.live.whereIs(k)).filter((at) => at)", json!(arm));
    tab.wait(&format!("{in_sight}.length > 0"));
    let in_sight = tab.evaluate(&in_sight);
    let corner = tab.evaluate(
        "(({ left, top }) => [left, top])(document.getElementById('body').getBoundingClientRect())",
    );
    let lines =
        |tab: &Tab| tab.evaluate("[...document.querySelectorAll('#lines li')].map((li) => li.innerText)");
    let mut reached = false;
    for (clicks, at) in (1..).zip(in_sight.as_array().unwrap()) {
        let pixel = |k: usize| at[k].as_f64().unwrap() + corner[k].as_f64().unwrap();
        tab.click(pixel(0), pixel(1));
        tab.wait(&format!("document.querySelectorAll('#lines li').length == {}", 2 * clicks));
        let answered = lines(&tab)[2 * clicks - 1].to_string();
        eprintln!("{answered}");
        assert!(answered.contains("I feel you touch my right forearm"), "{answered}");
        reached = answered.contains("put my left hand");
        if reached {
            break;
        }
    }
    assert!(reached, "it reaches nowhere that it is touched");

    // A line that is typed is answered, too.
    let before = lines(&tab).as_array().unwrap().len();
    tab.click_on("#text");
    tab.type_line("what can you do?");
    tab.wait(&format!("document.querySelectorAll('#lines li').length == {}", before + 2));
    assert!(lines(&tab).to_string().contains("I can feel around"));

    // Pages of other sites cannot speak in its partner's place.
    let elsewhere = "host: HERE\r\norigin: http://elsewhere.example\r\ncontent-type: application/json\r\n";
    assert!(served.answer("POST", "/ask", elsewhere, "{\"say\":\"rest\"}").starts_with("HTTP/1.1 403"));
    let unknown = "host: HERE\r\ncontent-type: application/json\r\n";
    assert!(served.answer("POST", "/ask", unknown, "{\"touch\":999999}").starts_with("HTTP/1.1 404"));
}

#[test]
#[ignore = "needs Chromium and axe-core"]
fn sessions_are_looked_at_touch_by_touch_in_any_posture_and_beside_each_other() {
    let browser = browser();
    let place = sessions::max();
    let model = repository("mjcf/max/max.xml");
    let served = Served::new(place, &["view", "max", "max", model.to_str().unwrap()]);
    let tab = open(browser, &served);
    tab.accessible();
    let set = |id: &str, value: &str, event: &str| {
        let set = format!(
            "(() => {{ {id}.value = {value}; {id}.dispatchEvent(new Event('{event}')); return 0; }})()"
        );
        tab.evaluate(&set)
    };
    let element = |id: &str| format!("document.getElementById('{id}')");
    let joints = || tab.evaluate("document.getElementById('body').body.poses.learned.begins");
    let at_ease = joints();
    set(&element("touch"), "3", "input");
    tab.wait("document.getElementById('doing').textContent.startsWith('touch 3 of 1000: ')");
    let touched = joints();
    assert_ne!(touched, at_ease);

    // Another browser looks at its own; and where nothing changes nothing is drawn, lit receptors or not.
    let other = open(browser, &served);
    assert_eq!(other.evaluate("document.getElementById('touch').value"), "0");
    let rests = "await (async () => {
        const { body } = document.getElementById('body');
        await new Promise((done) => setTimeout(done, 1500));
        const before = body.draws();
        await new Promise((done) => setTimeout(done, 1500));
        return body.draws() - before;
    })()";
    for tab in [&tab, &other] {
        assert_eq!(tab.evaluate(rests), 0, "it is drawn on at rest");
    }
    drop(other);
    assert_eq!(joints(), touched);

    // Whatever is said above it, the body stays where it is, on a phone as well.
    let hops = "await (async () => {
        const places = new Set();
        for (const touch of [0, 1, 2, 3, 40, 0]) {
            document.getElementById('touch').value = touch;
            document.getElementById('touch').dispatchEvent(new Event('input'));
            await new Promise((done) => setTimeout(done, 300));
            document.querySelector('details.posture').open = touch % 2 === 1;
            const { left, top, width, height } = document.getElementById('body').getBoundingClientRect();
            places.add(`${left} ${top} ${width} ${height}`);
        }
        return [...places];
    })()";
    for (width, height) in [(1100, 900), (390, 844)] {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        tab.call("Emulation.setDeviceMetricsOverride", size);
        let places = tab.evaluate(hops);
        assert_eq!(places.as_array().unwrap().len(), 1, "{width} pixels wide the body hops: {places}");
    }
    tab.call("Emulation.clearDeviceMetricsOverride", json!({}));

    // A posture that is none of a touch.
    set(&element("touch"), "3", "input");
    tab.wait("document.getElementById('doing').textContent.startsWith('touch 3 of 1000: ')");
    let elbow = "[...document.querySelectorAll('.dofs label')].find((label) => \
                 label.textContent.includes('left_elbow_flexion')).querySelector('input')";
    set(elbow, "1.5", "input");
    tab.wait("document.getElementById('touch').value === '0'");
    assert_ne!(joints(), touched);
    // The page's own kinematics, by which a body is pulled, put every limb where the program has it.
    let apart = "(() => {
        const { body } = document.getElementById('body');
        const [own, program] = [body.kinematics.pose(body.posture()), body.poses.learned];
        const between = (a, b) => a.map((x, k) => Math.abs(Math.abs(x) - Math.abs(b[k])));
        return Math.max(...between(own.frames, program.frames), ...between(own.begins, program.begins));
    })()";
    let apart = tab.evaluate(apart).as_f64().unwrap();
    assert!(apart < 8.0, "{apart} tenths of a millimetre");

    // A click on a limb shows how well it is located. It is of the picture that is seen, so that the body is let come to rest.
    tab.evaluate(rests);
    let at = tab
        .wait("Array.from({ length: 300 }, (_, k) => window.live.whereIs(k)).find((at) => at && at[0] > 50)");
    let corner = tab.evaluate(
        "(({ left, top }) => [left, top])(document.getElementById('body').getBoundingClientRect())",
    );
    let pixel = |k: usize| at[k].as_f64().unwrap() + corner[k].as_f64().unwrap();
    tab.click(pixel(0), pixel(1));
    tab.wait("document.querySelector('.said').textContent.includes(': located to within ')");

    tab.picture("view");

    // The model itself beside it: another page, in which a further body stands.
    set(&element("beside"), "2", "change");
    tab.wait("document.querySelector('[data-layer=\"the other body\"]')");
    set(&element("shown"), "2", "change");
    tab.wait("document.getElementById('doing')?.textContent === 'the model as it is'");

    // What is none of it is refused.
    let json = "host: HERE\r\ncontent-type: application/json\r\n";
    for (asked, answer) in [
        ("{\"touch\":1001}", "404"),
        ("{\"posture\":[1.0]}", "404"),
        ("{\"session\":3}", "404"),
        ("{\"beside\":9}", "404"),
        ("{\"touch\":-1}", "422"),
        ("{\"beside\":null}", "200"),
    ] {
        let said = served.answer("POST", "/ask", json, &format!("{{\"show\":{asked}}}"));
        assert!(said.starts_with(&format!("HTTP/1.1 {answer}")), "{asked}: {said}");
    }
    for query in ["?session=3", "?session=0&beside=9", "?session=x"] {
        let said = served.answer("GET", &format!("/{query}"), "host: HERE\r\n", "");
        assert!(said.starts_with("HTTP/1.1 404"), "{query}: {said}");
    }
}

#[test]
fn a_page_stays_where_nobody_types_until_its_process_is_ended() {
    let place = tempfile::tempdir().unwrap();
    let model = repository("mjcf/hexapod/hexapod.xml");
    let served = Served::unattended(place.path(), &["view", model.to_str().unwrap()]);
    std::thread::sleep(Duration::from_millis(1500));
    assert!(served.answer("GET", "/", "host: HERE\r\n", "").starts_with("HTTP/1.1 200"));
    served.terminate();
    let (status, said) = served.end();
    assert!(!status.success() && said.contains("kill "), "{status}: {said}");
    // And a conversation goes on there of which no line was ever typed.
    let scene = repository("mjcf/max/table.xml");
    let served = Served::unattended(sessions::max(), &["talk", scene.to_str().unwrap(), "max"]);
    std::thread::sleep(Duration::from_millis(1500));
    assert!(served.answer("GET", "/", "host: HERE\r\n", "").starts_with("HTTP/1.1 200"));
}

#[test]
fn where_there_is_nothing_to_look_at_a_sentence_says_so() {
    let place = tempfile::tempdir().unwrap();
    let refused = crate::common::program::refused(place.path(), 1, &["view", "--live", "127.0.0.1:0"]);
    assert!(refused.contains("sessions: it contains no learned session"), "{refused}");
}
