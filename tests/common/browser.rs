//! Chromium for tests. Where there is none they say so and are skipped, unless `BODYSCHEMA_BROWSER=required`.

use std::ffi::OsStr;
use std::time::Duration;

use headless_chrome::browser::default_executable;
use headless_chrome::{Browser, LaunchOptions, Tab};
use serde_json::Value;

/// The variable that forbids to skip these tests.
const REQUIRED: &str = "BODYSCHEMA_BROWSER";
/// How long a browser without a graphics card may take on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A browser without a window; none where there is none and none is required.
pub fn browser() -> Option<Browser> {
    let path = match default_executable() {
        Ok(path) => path,
        Err(_) => {
            let required = std::env::var(REQUIRED).is_ok_and(|value| value == "required");
            assert!(!required, "no browser was found: install chromium, or unset {REQUIRED}");
            eprintln!("skipped: no browser was found; `apt-get install chromium` brings one");
            return None;
        }
    };
    // Drawing in three dimensions goes on without a graphics card, and containers have little shared memory.
    let arguments = [
        "--use-gl=angle",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--disable-dev-shm-usage",
    ];
    let options = LaunchOptions::default_builder()
        .path(Some(path))
        .sandbox(false)
        .enable_gpu(true)
        .window_size(Some((1100, 900)))
        .idle_browser_timeout(PATIENCE)
        .args(arguments.iter().map(OsStr::new).collect())
        .build()
        .unwrap();
    Some(Browser::new(options).unwrap())
}

/// What a script of the page comes to, as JSON.
pub fn evaluate(tab: &Tab, script: &str) -> Value {
    let found = tab.evaluate(&format!("(async () => JSON.stringify({script}))()"), true).unwrap();
    let text = found.value.unwrap_or_else(|| panic!("{script} gave nothing: {:?}", found.description));
    serde_json::from_str(text.as_str().unwrap()).unwrap()
}
