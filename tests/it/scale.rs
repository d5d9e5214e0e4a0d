//! Bodies of many limbs and logs of many touches: what they cost, and that what is written of them stays readable.

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::program::succeeds;
use crate::common::repository;

/// How often it is looked how much memory a process has taken.
const OFTEN: Duration = Duration::from_millis(20);
/// The longest page that a browser is to be bothered with, bytes.
const LONGEST_PAGE: u64 = 2_000_000;

/// A hub with arms on a ball about it, all of so many limbs: each arm a chain of `chain` of them, the last one what is left.
pub(crate) fn body(limbs: usize, chain: usize) -> String {
    let arms = (limbs - 1).div_ceil(chain);
    let hub = 0.03 * (arms as f64).sqrt().max(2.0);
    let mut xml = format!(
        "<mujoco model=\"arms{limbs}\">\n<compiler angle=\"radian\" autolimits=\"true\"/>\n<worldbody>\n\
         <body name=\"hub\"><geom type=\"sphere\" size=\"{hub:.4}\"/>\n"
    );
    let mut made = 1;
    for arm in 0..arms {
        // Points that are spread evenly on a ball.
        let (up, turn) = (1.0 - 2.0 * (arm as f64 + 0.5) / arms as f64, 2.399_963 * arm as f64);
        let across = (1.0 - up * up).sqrt();
        let out = [across * turn.cos(), across * turn.sin(), up];
        let along = |length: f64| out.map(|x| format!("{:.4}", x * length)).join(" ");
        // About an axis across the arm, and askew.
        let axis = [-turn.sin(), turn.cos(), 0.4 * (arm as f64).sin()].map(|x| format!("{x:.3}")).join(" ");
        let here = chain.min(limbs - made);
        let length = if chain == 1 { 0.2 } else { 0.1 };
        for link in 0..here {
            let from = along(if link == 0 { hub + 0.02 } else { 0.12 });
            let _ = writeln!(
                xml,
                "<body name=\"l{made}\" pos=\"{from}\"><joint name=\"j{made}\" axis=\"{axis}\" range=\"-1.5 1.5\"/>\
                 <geom type=\"capsule\" size=\".01\" fromto=\"0 0 0 {}\"/>",
                along(length)
            );
            made += 1;
        }
        xml += &"</body>".repeat(here);
    }
    xml + "</body>\n</worldbody>\n</mujoco>\n"
}

/// What a command line took: seconds of the processor, and the most memory, megabytes.
struct Cost {
    seconds: f64,
    megabytes: f64,
}

fn cost(place: &Path, arguments: &[&str]) -> Cost {
    // Bash waits for the program, and then tells what the processor was busy with.
    let line = "TIMEFORMAT='%U %S'; time \"$0\" \"$@\" 2>/dev/null";
    let mut program = Command::new("bash")
        .args(["-c", line, env!("CARGO_BIN_EXE_bodyschema")])
        .args(arguments)
        .current_dir(place)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let children = format!("/proc/{0}/task/{0}/children", program.id());
    let mut kilobytes = 0.0f64;
    while program.try_wait().unwrap().is_none() {
        let child = std::fs::read_to_string(&children).unwrap_or_default();
        let status = child.split_whitespace().next().map(|child| format!("/proc/{child}/status"));
        let status = status.and_then(|path| std::fs::read_to_string(path).ok()).unwrap_or_default();
        let peak = status
            .lines()
            .find_map(|line| line.strip_prefix("VmHWM:")?.split_whitespace().next()?.parse().ok());
        kilobytes = kilobytes.max(peak.unwrap_or(0.0));
        std::thread::sleep(OFTEN);
    }
    let told = program.wait_with_output().unwrap();
    assert!(told.status.success(), "{arguments:?}");
    let told = String::from_utf8(told.stderr).unwrap();
    let seconds = told.split_whitespace().map(|number| number.parse::<f64>().unwrap()).sum();
    Cost { seconds, megabytes: kilobytes / 1024.0 }
}

/// Babbles touches of a body with Hersch's rule, which costs next to nothing, into the folder `s`.
fn babble(model: &Path, touches: usize) -> Vec<String> {
    let (model, touches) = (model.display().to_string(), touches.to_string());
    let line =
        ["babble", &model, "--policy", "random", "--touches", &touches, "--learner", "hersch", "--jobs", "1"];
    line.iter().chain(&["--out", "s"]).map(|word| word.to_string()).collect()
}

fn words(line: &[String]) -> Vec<&str> {
    line.iter().map(String::as_str).collect()
}

#[test]
fn a_page_of_very_many_limbs_can_be_opened() {
    let place = tempfile::tempdir().unwrap();
    let model = place.path().join("star.xml");
    std::fs::write(&model, body(320, 1)).unwrap();
    succeeds(place.path(), &words(&babble(&model, 40)));
    let page = std::fs::read_to_string(place.path().join("s/report.html")).unwrap();
    assert!((page.len() as u64) < LONGEST_PAGE, "{} bytes", page.len());
    // What is left out is said, and every joint stands in the table.
    assert!(page.contains("Shown are the 60 of 320 limbs"));
    assert!((1..320).all(|k| page.contains(&format!(">j{k}</th>"))));
}

/// By `cargo test --release --test it large::scale -- --ignored --nocapture`.
mod large {
    use super::*;

    /// The sessions of each body, of whose times the mean is told: what one takes differs by a tenth.
    const SEEDS: std::ops::RangeInclusive<u64> = 1..=5;

    #[test]
    #[ignore = "large: bodies of 10 to 1,000 limbs"]
    fn scale_of_bodies() {
        println!(
            "| body | limbs | to the first touches, s | a touch, ms | a touch and limb, µs | MB | KB a limb | page, MB |"
        );
        println!("|---|---|---|---|---|---|---|---|");
        for (name, chain) in [("star", 1), ("arms of 8", 8)] {
            for limbs in [10, 30, 100, 300, 1000] {
                let place = tempfile::tempdir().unwrap();
                let model = place.path().join("body.xml");
                std::fs::write(&model, body(limbs, chain)).unwrap();
                let run = |touches: usize| {
                    let mut mean = Cost { seconds: 0.0, megabytes: 0.0 };
                    for seed in SEEDS {
                        let _ = std::fs::remove_dir_all(place.path().join("s"));
                        let line =
                            [&babble(&model, touches)[..], &["--seed".into(), seed.to_string()]].concat();
                        let Cost { seconds, megabytes } = cost(place.path(), &words(&line));
                        mean.seconds += seconds / SEEDS.count() as f64;
                        mean.megabytes = mean.megabytes.max(megabytes);
                    }
                    mean
                };
                let (few, many) = (20, 220);
                let (begun, all) = (run(few), run(many));
                let touch = 1e3 * (all.seconds - begun.seconds) / (many - few) as f64;
                let page = std::fs::metadata(place.path().join("s/report.html")).unwrap().len();
                println!(
                    "| {name} | {limbs} | {:.2} | {touch:.2} | {:.1} | {:.0} | {:.0} | {:.2} |",
                    begun.seconds,
                    1e3 * touch / limbs as f64,
                    all.megabytes,
                    1024.0 * all.megabytes / limbs as f64,
                    1e-6 * page as f64,
                );
                assert!(page < LONGEST_PAGE, "{page} bytes");
            }
        }
    }

    /// `BODYSCHEMA_SCALE` names another most than a million.
    #[test]
    #[ignore = "large: logs of 1,000 to 1,000,000 touches"]
    fn scale_of_logs() {
        let most = std::env::var("BODYSCHEMA_SCALE").ok().and_then(|most| most.parse().ok());
        let most: usize = most.unwrap_or(1_000_000);
        let place = tempfile::tempdir().unwrap();
        let model = repository("mjcf/max/max.xml");
        println!("| command | touches | s | µs a touch | MB | bytes a touch |");
        println!("|---|---|---|---|---|---|");
        let sizes = || (3..7).map(|power| 10usize.pow(power)).filter(|&touches| touches <= most);
        let tell = |name: &str, touches: usize, cost: Cost| {
            println!(
                "| {name} | {touches} | {:.2} | {:.0} | {:.0} | {:.0} |",
                cost.seconds,
                1e6 * cost.seconds / touches as f64,
                cost.megabytes,
                1024.0 * 1024.0 * cost.megabytes / touches as f64
            );
        };
        for touches in sizes() {
            let _ = std::fs::remove_dir_all(place.path().join("s"));
            let line = [&babble(&model, touches)[..], &["--input".into(), "contact".into()]].concat();
            tell("babble", touches, cost(place.path(), &words(&line)));
            for (name, line) in [
                ("learn --learner lm", &["learn", "s", "--learner", "lm"][..]),
                ("report", &["report", "s"]),
                ("report", &["report", "s"]),
            ] {
                tell(name, touches, cost(place.path(), line));
            }
        }
    }
}
