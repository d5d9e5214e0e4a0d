//! Commands that write anything else than a session, killed at random moments: every file that has its name is whole, and the
//! same command once more comes to its end.
//!
//! Which files are the same each time is found out by two undisturbed runs; of those that tell times or folders it is looked
//! whether they are whole by their form.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tempfile::TempDir;

use crate::common::shell::copy;
use crate::common::{repository, two_arms};

/// Logs, which grow line by line: what a killed process leaves of them is their beginning.
const GROWING: [&str; 2] = ["touches.jsonl", ".txt"];
/// How often an undisturbed command is tried until it is killed before its end.
const TRIES: usize = 20;

/// A command that writes into the folder `s`, which is there, and what is there before.
struct Job {
    words: Vec<String>,
    before: Option<&'static str>,
    /// The files that it leaves by the way to them, with what is in those that are the same each time.
    files: BTreeMap<PathBuf, Option<Vec<u8>>>,
    takes: Duration,
}

/// A folder with all that the commands need.
struct Yard(TempDir);

impl Yard {
    fn new() -> Yard {
        let yard = Yard(tempfile::tempdir().unwrap());
        let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
        fs::write(yard.path("arms.xml"), arms).unwrap();
        let babble = "babble arms.xml --touches 60 --learner hersch --quiet";
        yard.succeeds(&format!("{babble} --out whole"));
        for number in [1, 2] {
            yard.succeeds(&format!(
                "study learners arms.xml --trials 2 --touches 12 --shard {number}/2 --out trials"
            ));
        }
        yard
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, words: &[String]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        command.args(words).current_dir(self.0.path()).stdin(Stdio::null());
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    fn succeeds(&self, words: &str) {
        let words: Vec<String> = words.split(' ').map(str::to_string).collect();
        let output = self.command(&words).output().unwrap();
        assert!(output.status.success(), "{words:?}: {}", said(&output));
    }

    /// Puts the folder `s` as it is before a job.
    fn prepare(&self, before: Option<&str>) {
        let _ = fs::remove_dir_all(self.path("s"));
        match before {
            Some(before) => copy(&self.path(before), &self.path("s")),
            None => fs::create_dir(self.path("s")).unwrap(),
        }
    }

    /// What is in the folder `s`, by the way to it.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        fn add(folder: &Path, way: &Path, files: &mut BTreeMap<PathBuf, Vec<u8>>) {
            for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
                let (path, way) = (entry.path(), way.join(entry.file_name()));
                if path.is_dir() {
                    add(&path, &way, files);
                } else {
                    files.insert(way, fs::read(path).unwrap());
                }
            }
        }
        let mut files = BTreeMap::new();
        add(&self.path("s"), Path::new(""), &mut files);
        files
    }

    /// A job, run twice to see what it leaves.
    fn job(&self, words: &str, before: Option<&'static str>) -> Job {
        let words: Vec<String> = words.split(' ').map(str::to_string).collect();
        let began = Instant::now();
        let [one, other] = [0, 1].map(|_| {
            self.prepare(before);
            let output = self.command(&words).output().unwrap();
            assert!(output.status.success(), "{words:?}: {}", said(&output));
            self.files()
        });
        let takes = began.elapsed() / 2;
        assert!(!one.is_empty() && one.keys().eq(other.keys()), "{words:?} leaves other files each time");
        let files = one.into_iter().map(|(way, bytes)| {
            // Pages tell rounded times, which are the same now and then.
            let is_page = way.extension().is_some_and(|ending| ending == "html" || ending == "md");
            let same = other[&way] == bytes && !is_page;
            (way, same.then_some(bytes))
        });
        Job { words, before, files: files.collect(), takes }
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).trim_end().to_string()
}

fn is_hidden(way: &Path) -> bool {
    way.iter().any(|name| name.to_string_lossy().starts_with('.'))
}

/// Whether a file that is not the same each time is whole, by its form.
fn is_whole(way: &Path, bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    match way.extension().and_then(|ending| ending.to_str()) {
        Some("json") => serde_json::from_slice::<serde_json::Value>(bytes).is_ok(),
        Some("html") => text.trim_end().ends_with("</html>"),
        Some("md") => text.ends_with('\n'),
        other => panic!("{} is another each time, and nothing is known of .{other:?}", way.display()),
    }
}

/// Kills a job at a moment; whether that was before its end.
fn kill(yard: &Yard, job: &Job, after: Duration, how: &str) -> bool {
    yard.prepare(job.before);
    let before = yard.files();
    let mut child = yard.command(&job.words).spawn().unwrap();
    std::thread::sleep(after);
    // On Unix this is SIGKILL, which nothing can catch.
    let _ = child.kill();
    let killed = child.wait().unwrap().code().is_none();
    for (way, bytes) in yard.files() {
        if is_hidden(&way) || before.get(&way) == Some(&bytes) {
            continue;
        }
        let expected = job.files.get(&way).unwrap_or_else(|| panic!("{how}: {} is left", way.display()));
        let grows = GROWING.iter().any(|end| way.to_string_lossy().ends_with(end));
        let right = match expected {
            Some(expected) if grows => expected.starts_with(&bytes),
            Some(expected) => *expected == bytes,
            None if grows => true,
            None => is_whole(&way, &bytes),
        };
        assert!(right, "{how}: {} is half or another, {} bytes", way.display(), bytes.len());
    }
    // Once more it comes to its end, or says that all is there.
    let output = yard.command(&job.words).output().unwrap();
    let complete = said(&output).contains("already") && output.status.code() == Some(1);
    assert!(output.status.success() || complete, "{how}, once more: {}", said(&output));
    let left = yard.files();
    for (way, expected) in &job.files {
        let found = left.get(way).unwrap_or_else(|| panic!("{how}, once more: {} is missing", way.display()));
        let right = expected.as_ref().map_or_else(|| is_whole(way, found), |expected| expected == found);
        assert!(right, "{how}, once more: {} is another", way.display());
    }
    let hidden: Vec<&PathBuf> = left.keys().filter(|way| is_hidden(way)).collect();
    assert!(hidden.is_empty(), "{how}, once more: {hidden:?} are left");
    killed
}

/// Kills each job so many times before its end.
fn kills(yard: &Yard, jobs: &[Job], times: usize, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for job in jobs {
        let (mut killed, mut tried) = (0, 0);
        while killed < times {
            tried += 1;
            assert!(tried <= TRIES * times, "{:?} cannot be killed before its end", job.words);
            let after = job.takes.mul_f64(rng.random_range(0.0..1.0));
            let how = format!("kill {tried} of seed {seed}, {}", job.words.join(" "));
            killed += usize::from(kill(yard, job, after, &how));
        }
        println!("{killed:>6} killed of {tried}: {}", job.words.join(" "));
    }
}

fn quick(yard: &Yard) -> Vec<Job> {
    let robot = repository("examples/robot");
    let (arms, table) = (robot.join("arms.urdf"), robot.join("touches.csv"));
    vec![
        yard.job("study learners arms.xml --trials 2 --touches 12 --out s", None),
        yard.job("study learners arms.xml --trials 2 --touches 12 --shard 1/1 --out s", None),
        yard.job("study merge s", Some("trials")),
        yard.job("skin arms.xml --out s/skin.xml", None),
        yard.job("export whole --out s/body.xml", None),
        yard.job(&format!("calibrate {} {} --free *.offset --out s", arms.display(), table.display()), None),
        yard.job(&format!("plan {} --free *.offset --touches 3 --out s/plan.csv", arms.display()), None),
    ]
}

#[test]
fn a_command_killed_at_any_moment_leaves_whole_files() {
    let yard = Yard::new();
    kills(&yard, &quick(&yard), 2, 1);
}

/// By `cargo test --release --test it large::results -- --ignored --nocapture`; pictures need OpenGL and films ffmpeg.
mod large {
    use super::*;

    #[test]
    #[ignore = "large: 50 kills of every command that writes no session"]
    fn results_of_commands_that_are_killed() {
        let yard = Yard::new();
        let mut jobs = vec![yard.job("study gallery arms.xml --trials 1 --out s", None)];
        jobs.extend(quick(&yard));
        jobs.push(yard.job("render whole --touch 1 --size 160x120 --out s/touch.png", None));
        jobs.push(yard.job("render whole --touches 1..2 --size 160x120 --out s/touches.mp4", None));
        kills(&yard, &jobs, 50, 7000);
    }
}
