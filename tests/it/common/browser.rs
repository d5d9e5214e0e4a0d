//! Chromium for tests, spoken to in its DevTools protocol through a pipe.
//!
//! One browser serves all tests of a process, each in a window of its own; it ends with the process.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command, Stdio};
use std::sync::{Condvar, LazyLock, Mutex};
use std::time::{Duration, Instant};

use base64::Engine;
use serde_json::{Value, json};

use super::python;

/// The variable that names another browser of this family.
const NAMED: &str = "CHROME";
/// What the browser is called.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome-stable", "google-chrome"];
/// How long a browser without a graphics card may take on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(60);
/// How often a page is asked whether it has come to something.
const OFTEN: Duration = Duration::from_millis(50);
/// Headless, and drawing in three dimensions without a graphics card; containers have little shared memory; and pages
/// that are not in front go on.
const ARGUMENTS: [&str; 13] = [
    "--headless",
    "--remote-debugging-pipe",
    "--no-sandbox",
    "--no-first-run",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-background-timer-throttling",
    "--disable-backgrounding-occluded-windows",
    "--disable-renderer-backgrounding",
    "--window-size=1100,900",
];
/// Runs a browser with the two ends of its protocol where it looks for them, and clears away after it.
const LAUNCH: &str = r#"profile=$(mktemp -d)
"$@" --user-data-dir="$profile" 3<&0 4>&1 </dev/null >/dev/null
rm -rf "$profile""#;

/// A browser without a window.
pub struct Browser {
    /// Where it reads commands, and how many it was given.
    commands: Mutex<(ChildStdin, u64)>,
    told: Mutex<Told>,
    news: Condvar,
}

/// What a browser told and nobody has asked for yet.
#[derive(Default)]
struct Told {
    /// Answers to commands, by their numbers.
    answers: HashMap<u64, Value>,
    /// Events of tabs, by their sessions.
    events: HashMap<String, Vec<Value>>,
    ended: bool,
}

/// A page in a browser; it is closed when it is dropped.
pub struct Tab {
    browser: &'static Browser,
    session: String,
    target: Value,
}

/// The browser.
pub fn browser() -> &'static Browser {
    static BROWSER: LazyLock<Option<&Browser>> = LazyLock::new(|| executable().map(|path| start(&path)));
    BROWSER.expect("no browser was found: install Debian's package chromium, or name one in CHROME")
}

/// Where the browser's program is.
fn executable() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os(NAMED) {
        return Some(named.into());
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&folders).collect();
    let mut paths = NAMES.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    paths.find(|path| path.is_file())
}

fn start(path: &Path) -> &'static Browser {
    let mut program = Command::new("sh")
        .args(["-c", LAUNCH, "sh"])
        .arg(path)
        .args(ARGUMENTS)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let browser: &Browser = Box::leak(Box::new(Browser {
        commands: Mutex::new((program.stdin.take().unwrap(), 0)),
        told: Mutex::default(),
        news: Condvar::new(),
    }));
    let answers = program.stdout.take().unwrap();
    std::thread::spawn(move || {
        browser.listen(answers);
        program.wait()
    });
    browser
}

impl Browser {
    /// Takes down what the browser tells, until it ends.
    fn listen(&self, told: impl Read) {
        for message in BufReader::new(told).split(0).map_while(Result::ok) {
            let mut message: Value = serde_json::from_slice(&message).unwrap();
            let mut told = self.told.lock().unwrap();
            if let Some(id) = message["id"].as_u64() {
                told.answers.insert(id, message);
            } else if let Value::String(session) = message["sessionId"].take() {
                told.events.entry(session).or_default().push(message);
            }
            drop(told);
            self.news.notify_all();
        }
        self.told.lock().unwrap().ended = true;
        self.news.notify_all();
    }

    /// Waits until something is found in what was told.
    fn wait<T>(&self, what: &str, mut find: impl FnMut(&mut Told) -> Option<T>) -> T {
        let mut told = self.told.lock().unwrap();
        let began = Instant::now();
        loop {
            if let Some(found) = find(&mut told) {
                return found;
            }
            assert!(!told.ended, "the browser ended before {what}");
            let left = PATIENCE.checked_sub(began.elapsed());
            let left = left.unwrap_or_else(|| panic!("the browser never came to {what}"));
            told = self.news.wait_timeout(told, left).unwrap().0;
        }
    }

    /// What a command of the protocol comes to.
    fn call(&self, session: Option<&str>, method: &str, parameters: Value) -> Value {
        let id = {
            let mut commands = self.commands.lock().unwrap();
            let (pipe, count) = &mut *commands;
            *count += 1;
            let mut command = json!({ "id": count, "method": method, "params": parameters });
            if let Some(session) = session {
                command["sessionId"] = session.into();
            }
            pipe.write_all(format!("{command}\0").as_bytes()).unwrap();
            *count
        };
        let mut answer = self.wait(method, |told| told.answers.remove(&id));
        assert!(answer.get("error").is_none(), "{method}: {}", answer["error"]);
        answer["result"].take()
    }

    /// A page, loaded.
    pub fn open(&'static self, address: &str) -> Tab {
        let blank = json!({ "url": "about:blank", "newWindow": true });
        let target = self.call(None, "Target.createTarget", blank)["targetId"].take();
        let attach = json!({ "targetId": target, "flatten": true });
        let attached = self.call(None, "Target.attachToTarget", attach);
        let tab = Tab { browser: self, session: attached["sessionId"].as_str().unwrap().into(), target };
        for domain in ["Page", "Runtime", "Log", "Network"] {
            tab.call(&format!("{domain}.enable"), json!({}));
        }
        tab.call("Page.navigate", json!({ "url": address }));
        self.wait(address, |told| {
            let mut events = told.events.get(&tab.session)?.iter();
            events.find(|event| event["method"] == "Page.loadEventFired").map(|_| ())
        });
        tab
    }
}

impl Tab {
    /// What a command of the DevTools protocol comes to.
    pub fn call(&self, method: &str, parameters: Value) -> Value {
        self.browser.call(Some(&self.session), method, parameters)
    }

    /// What a script of the page comes to, as JSON; it may await.
    pub fn evaluate(&self, script: &str) -> Value {
        let script = format!("(async () => ({script}))()");
        let parameters = json!({ "expression": script, "awaitPromise": true, "returnByValue": true });
        let mut found = self.call("Runtime.evaluate", parameters);
        assert!(found.get("exceptionDetails").is_none(), "{script}: {}", found["exceptionDetails"]);
        found["result"]["value"].take()
    }

    /// Waits until a script of the page comes to something that is true, and gives it.
    pub fn wait(&self, script: &str) -> Value {
        let began = Instant::now();
        loop {
            let found = self.evaluate(script);
            if !matches!(found, Value::Bool(false) | Value::Null) {
                return found;
            }
            assert!(began.elapsed() < PATIENCE, "it never came to: {script}");
            std::thread::sleep(OFTEN);
        }
    }

    /// Holds the page, light and dark, against axe-core's rules.
    pub fn accessible(&self) {
        let place = python::packages().join("axe_playwright_python/axe.min.js");
        let script =
            std::fs::read_to_string(&place).unwrap_or_else(|error| panic!("{}: {error}", place.display()));
        self.call("Runtime.evaluate", json!({ "expression": script }));
        let told = "violations.map(({ id, nodes }) => [id, nodes.map((node) => `${node.html}: ${node.failureSummary}`)])";
        for scheme in ["dark", "light"] {
            let scheme = json!({ "name": "prefers-color-scheme", "value": scheme });
            self.call("Emulation.setEmulatedMedia", json!({ "features": [scheme] }));
            let found = self.evaluate(&format!("(await axe.run()).{told}"));
            assert_eq!(found, json!([]), "{scheme}: {found:#}");
        }
    }

    /// Writes what is seen now, for eyes, where `BODYSCHEMA_PICTURES` names a folder; on a phone and printed as well.
    pub fn picture(&self, name: &str) {
        let Some(folder) = std::env::var_os("BODYSCHEMA_PICTURES") else { return };
        let folder = Path::new(&folder);
        std::fs::create_dir_all(folder).unwrap();
        let write = |file: String, answer: Value| {
            let bytes = base64::engine::general_purpose::STANDARD.decode(answer["data"].as_str().unwrap());
            std::fs::write(folder.join(file), bytes.unwrap()).unwrap();
        };
        for scheme in ["dark", "light"] {
            let media = json!({ "name": "prefers-color-scheme", "value": scheme });
            self.call("Emulation.setEmulatedMedia", json!({ "features": [media] }));
            for (device, width, height) in [("", 1280, 960), ("-phone", 390, 844)] {
                let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
                self.call("Emulation.setDeviceMetricsOverride", size);
                // What rests is drawn sharp.
                std::thread::sleep(Duration::from_millis(600));
                write(format!("{name}-{scheme}{device}.png"), self.call("Page.captureScreenshot", json!({})));
            }
        }
        self.call("Emulation.clearDeviceMetricsOverride", json!({}));
        write(format!("{name}.pdf"), self.call("Page.printToPDF", json!({ "printBackground": true })));
    }

    /// Clicks on a place of the page, pixels from its top left.
    pub fn click(&self, x: f64, y: f64) {
        for (kind, buttons) in [("mouseMoved", 0), ("mousePressed", 1), ("mouseReleased", 0)] {
            let button = if kind == "mouseMoved" { "none" } else { "left" };
            let at = json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", at);
        }
    }

    /// Clicks in the middle of an element.
    pub fn click_on(&self, selector: &str) {
        let middle = "(({ left, top, width, height }) => [left + width / 2, top + height / 2])";
        let element = format!("document.querySelector('{selector}')");
        let at = self.evaluate(&format!("{middle}({element}.getBoundingClientRect())"));
        self.click(at[0].as_f64().unwrap(), at[1].as_f64().unwrap());
    }

    /// Types a line, and Enter.
    pub fn type_line(&self, text: &str) {
        self.call("Input.insertText", json!({ "text": text }));
        for kind in ["keyDown", "keyUp"] {
            let key = json!({
                "type": kind, "key": "Enter", "code": "Enter", "windowsVirtualKeyCode": 13, "text": "\r",
            });
            self.call("Input.dispatchKeyEvent", key);
        }
    }

    /// The addresses that the page asked for so far.
    pub fn requests(&self) -> Vec<String> {
        self.events("Network.requestWillBeSent", |event| Some(event["request"]["url"].as_str()?.to_string()))
    }

    /// What the page's console was told so far, and errors.
    pub fn complaints(&self) -> Vec<String> {
        let text = |event: &Value| Some(event.to_string());
        // Browsers also log advice on speed, which is no complaint.
        let error = |event: &Value| (event["entry"]["level"] == "error").then(|| event.to_string());
        let told = [
            self.events("Runtime.exceptionThrown", text),
            self.events("Runtime.consoleAPICalled", text),
            self.events("Log.entryAdded", error),
        ];
        told.concat()
    }

    fn events<T>(&self, method: &str, read: impl Fn(&Value) -> Option<T>) -> Vec<T> {
        let told = self.browser.told.lock().unwrap();
        let events = told.events.get(&self.session).into_iter().flatten();
        events.filter(|event| event["method"] == method).filter_map(|event| read(&event["params"])).collect()
    }
}

impl Drop for Tab {
    fn drop(&mut self) {
        // A test that fails drops it, too: another panic would end the process.
        if !std::thread::panicking() {
            self.browser.call(None, "Target.closeTarget", json!({ "targetId": self.target }));
        }
    }
}
