//! Several processes on one folder, processes that are killed, and disks that are full: nothing is lost or mixed, and the
//! folder is of one generation.
//!
//! Which commands run together, when they are killed and how much may be written are drawn by a seed. A few tens of each
//! are tried with all other tests; [`large`] tries thousands.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use tempfile::TempDir;

use crate::common::shell::copy;
use crate::common::two_arms;

/// Touches of the sessions.
const TOUCHES: &str = "40";
/// The two seeds that sessions are babbled with.
const SEEDS: [&str; 2] = ["1", "2"];
/// What else sessions are babbled with.
const BABBLE: [&str; 7] = ["babble", "arms.xml", "--touches", TOUCHES, "--learner", "hersch", "--quiet"];
/// How the session is learned from again, by the words that tell the results apart.
const LEARN: [&[&str]; 2] =
    [&["--learner", "hersch", "--input", "contact"], &["--learner", "hersch", "--joint-noise", "5"]];
/// How the same touches are learned from as those of a recording.
const RECORDING: [&str; 8] =
    ["learn", "--creature", "creature.json", "--log", "log.jsonl", "--learner", "hersch", "--quiet"];
/// Files that only learning writes, the same each time.
const LEARNED: [&str; 3] = ["schema.json", "learned.xml", "learning.csv"];
/// All files that are of one generation.
const OF_GENERATION: [&str; 5] =
    ["schema.json", "learned.xml", "learning.csv", "learning.json", "report.html"];
/// How much later than the first the second of two processes begins at the most.
const APART: Duration = Duration::from_millis(12);
/// Blocks of 1024 bytes that a disk is filled with at the most.
const MOST_FILLED: usize = 1 << 16;
/// How long a command may take before it hangs.
const PATIENCE: Duration = Duration::from_secs(120);

/// Estimated quantities wrong, by its kind, and how much was tried.
#[derive(Default)]
struct Findings {
    tried: BTreeMap<String, usize>,
    wrong: BTreeMap<&'static str, Vec<String>>,
    /// Times that all new files were whole, and not all in their places when the process was killed.
    pending: usize,
}

impl Findings {
    fn tried(&mut self, what: &str) {
        *self.tried.entry(what.to_string()).or_default() += 1;
    }

    fn wrong(&mut self, kind: &'static str, how: impl fmt::Display) {
        self.wrong.entry(kind).or_default().push(how.to_string());
    }

    /// Counts what is wrong unless `right`.
    fn check(&mut self, right: bool, kind: &'static str, how: impl Fn() -> String) {
        if !right {
            self.wrong(kind, how());
        }
    }

    fn told(&self) {
        for (what, times) in &self.tried {
            println!("{times:>6} {what}");
        }
        println!("{:>6} of the kills came between two moves of a whole generation", self.pending);
        for kind in KINDS {
            println!("{:>6} {kind}", self.wrong.get(kind).map_or(0, Vec::len));
        }
        assert!(self.wrong.is_empty(), "{:#?}", self.wrong);
    }
}

/// What can be wrong.
const LOST: &str = "logs with lines lost or mixed";
const HALF: &str = "half files";
const MIXED: &str = "mixed generations";
const STALE: &str = "stale locks, parts and folders";
const ENDED: &str = "ends that no sentence tells";
const KINDS: [&str; 5] = [LOST, HALF, MIXED, STALE, ENDED];

/// A folder with a creature, sessions of it as they are without any mishap, and one for what is tried.
struct Yard {
    place: TempDir,
    /// Per way of learning, the files of [`LEARNED`].
    generations: Vec<Vec<Vec<u8>>>,
    /// Per seed the log.
    logs: Vec<Vec<u8>>,
}

impl Yard {
    fn new() -> Yard {
        Yard::on(tempfile::tempdir().unwrap())
    }

    fn on(place: TempDir) -> Yard {
        let arms = two_arms(r#"type="capsule" size="0.12 0.2""#, r#"type="capsule" size="0.03 0.2""#);
        fs::write(place.path().join("arms.xml"), arms).unwrap();
        let mut yard = Yard { place, generations: Vec::new(), logs: Vec::new() };
        for seed in SEEDS {
            yard.succeeds(&[&BABBLE[..], &["--seed", seed, "--out", &format!("whole-{seed}")]].concat());
            yard.logs.push(fs::read(yard.path(&format!("whole-{seed}/touches.jsonl"))).unwrap());
        }
        yard.generations.push(yard.learned("whole-1").unwrap());
        let about = fs::read(yard.path("whole-1/session.json")).unwrap();
        let about: Value = serde_json::from_slice(&about).unwrap();
        let parts = serde_json::json!({"creature": about["creature"], "skin": about["skin"]});
        fs::write(yard.path("creature.json"), parts.to_string()).unwrap();
        fs::write(yard.path("log.jsonl"), &yard.logs[0]).unwrap();
        for (k, way) in LEARN.iter().enumerate() {
            let folder = format!("learned-{k}");
            yard.copy("whole-1", &folder);
            yard.succeeds(&[&["learn", &folder, "--quiet"], *way].concat());
            let learned = yard.learned(&folder).unwrap();
            assert!(!yard.generations.contains(&learned), "{way:?} makes no difference");
            yard.generations.push(learned);
        }
        // What is learned of the same touches without the model has other columns.
        yard.succeeds(&[&RECORDING[..], &["--out", "recorded"]].concat());
        yard.generations.push(yard.learned("recorded").unwrap());
        yard.succeeds(&["skin", "feel", "arms.xml", "--strokes", "0.02", "--out", "stroked", "--quiet"]);
        // One that babbled and did not learn, and one that was interrupted.
        yard.copy("whole-1", "cut");
        for file in OF_GENERATION {
            fs::remove_file(yard.path("cut").join(file)).unwrap();
        }
        let about = fs::read(yard.path("cut/session.json")).unwrap();
        let mut about: Value = serde_json::from_slice(&about).unwrap();
        about["effort"] = Value::Null;
        fs::write(yard.path("cut/session.json"), about.to_string()).unwrap();
        fs::write(yard.path("cut/touches.jsonl"), &yard.logs[0][..yard.logs[0].len() / 2]).unwrap();
        yard
    }

    fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    fn copy(&self, from: &str, to: &str) {
        let _ = fs::remove_dir_all(self.path(to));
        copy(&self.path(from), &self.path(to));
    }

    fn begin(&self, arguments: &[&str]) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bodyschema"));
        command.args(arguments).current_dir(self.place.path()).stdin(Stdio::null());
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    fn succeeds(&self, arguments: &[&str]) {
        let output = self.begin(arguments).wait_with_output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// Whether a command succeeds, and what it says if not.
    fn tries(&self, arguments: &[&str]) -> Result<(), String> {
        said(&self.begin(arguments).wait_with_output().unwrap())
    }

    fn learned(&self, session: &str) -> Option<Vec<Vec<u8>>> {
        LEARNED.iter().map(|file| fs::read(self.path(session).join(file)).ok()).collect()
    }

    /// The number of the generation that a session's files are of, if they are all of one; none where there is none of them.
    fn generation(&self, session: &str) -> Result<Option<usize>, String> {
        let folder = self.path(session);
        let there: Vec<&str> = OF_GENERATION.into_iter().filter(|file| folder.join(file).exists()).collect();
        if there.is_empty() {
            return Ok(None);
        }
        if there.len() < OF_GENERATION.len() {
            return Err(format!("only {there:?} are there"));
        }
        let learned = self.learned(session).unwrap();
        let found = self.generations.iter().position(|generation| *generation == learned);
        let found = found.ok_or("its files are of no generation, or of several")?;
        let text = |file: &str| fs::read_to_string(folder.join(file)).unwrap_or_default();
        let record: Value =
            serde_json::from_str(&text("learning.json")).map_err(|error| error.to_string())?;
        let words: Vec<&str> =
            record["command"].as_array().into_iter().flatten().flat_map(Value::as_str).collect();
        let (record, report) = (words.join(" "), text("report.html"));
        for (k, way) in LEARN.iter().enumerate() {
            let is = k + 1 == found;
            let way = way.join(" ");
            if record.contains(&way) != is || report.contains(&way) != is {
                return Err(format!("its schema is number {found}, its record or report is not"));
            }
        }
        if !report.trim_end().ends_with("</html>") {
            return Err("its report has no end".into());
        }
        Ok(Some(found))
    }

    /// Looks at a session that nobody writes: no log is changed but for its end, no file is half.
    fn look(&self, session: &str, seeds: &[usize], whole: bool, how: &str, findings: &mut Findings) {
        let folder = self.path(session);
        let Ok(about) = fs::read(folder.join("session.json")) else { return };
        let about: Result<Value, _> = serde_json::from_slice(&about);
        findings.check(about.is_ok(), HALF, || format!("{how}: session.json"));
        let log = fs::read(folder.join("touches.jsonl")).unwrap_or_default();
        let right = seeds.iter().any(|&seed| {
            let expected = &self.logs[seed];
            if whole { log == *expected } else { expected.starts_with(&log) }
        });
        findings.check(right, LOST, || format!("{how}: {} bytes of touches", log.len()));
        for file in ["schema.json", "learning.json", "space.json", "babbling.json", "map.json"] {
            if let Ok(json) = fs::read(folder.join(file)) {
                let whole = serde_json::from_slice::<Value>(&json).is_ok();
                findings.check(whole, HALF, || format!("{how}: {file}"));
            }
        }
    }

    /// Looks for what nothing should have been left of.
    fn swept(&self, session: &str, how: &str, findings: &mut Findings) {
        for entry in fs::read_dir(self.path(session)).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            findings.check(!name.starts_with('.'), STALE, || format!("{how}: {name}"));
        }
    }
}

/// Whether a process succeeded; if not, its one sentence.
fn said(output: &Output) -> Result<(), String> {
    if output.status.success() {
        return Ok(());
    }
    Err(format!("{:?}: {}", output.status.code(), String::from_utf8_lossy(&output.stderr).trim_end()))
}

/// Whether an end is one that a sentence tells.
fn is_told(end: &Result<(), String>, of: &str) -> bool {
    end.as_ref().err().is_none_or(|message| {
        message.starts_with("Some(1): bodyschema: ") && message.lines().count() == 1 && message.contains(of)
    })
}

/// Two commands on one folder at the same time.
fn pairs(yard: &Yard, count: usize, seed: u64, findings: &mut Findings) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for k in 0..count {
        let _ = fs::remove_dir_all(yard.path("s"));
        let _ = fs::remove_dir_all(yard.path("sessions"));
        let babble = |seed: usize| [&BABBLE[..], &["--seed", SEEDS[seed]]].concat();
        let out = ["--out", "s"];
        let learn = |way: usize| [&["learn", "s", "--quiet"], LEARN[way]].concat();
        let (resume, report) = (vec!["babble", "--resume", "s", "--quiet"], vec!["report", "s", "--quiet"]);
        let recording = [&RECORDING[..], &out].concat();
        let with_out = |seed: usize| [&babble(seed)[..], &out].concat();
        let (kind, before, [one, other]) = match k % 8 {
            0 | 1 => ("two babble --out", None, [with_out(0), with_out(1)]),
            2 => ("two babble without --out", None, [babble(0), babble(1)]),
            3 => ("two learn", Some("whole-1"), [learn(0), learn(1)]),
            4 => ("learn and report", Some("whole-1"), [learn(rng.random_range(0..2)), report]),
            5 => ("two babble --resume", Some("cut"), [resume.clone(), resume]),
            6 => ("learn and babble --resume", Some("cut"), [learn(0), resume]),
            _ => ("babble --out and learn of a recording", None, [with_out(1), recording]),
        };
        if let Some(before) = before {
            yard.copy(before, "s");
        }
        let swap = rng.random_bool(0.5);
        let [first, second] = if swap { [&other, &one] } else { [&one, &other] };
        let began = yard.begin(first);
        std::thread::sleep(APART.mul_f64(rng.random_range(0.0..1.0)));
        let then = yard.begin(second);
        let ends = [began, then].map(|child| said(&child.wait_with_output().unwrap()));
        findings.tried(kind);
        let how = format!("pair {k} of seed {seed}, {kind}, {ends:?}");
        let told = ends.iter().all(|end| is_told(end, "s"));
        let done = ends.iter().filter(|end| end.is_ok()).count();
        findings.check(told && done > 0, ENDED, || how.clone());
        if k % 8 == 2 {
            findings.check(done == 2, ENDED, || how.clone());
            let mut logs: Vec<Vec<u8>> = ["1", "2"]
                .map(|n| {
                    fs::read(yard.path(&format!("sessions/two_arms-{n}/touches.jsonl"))).unwrap_or_default()
                })
                .into();
            if logs[0] != yard.logs[0] {
                logs.reverse();
            }
            findings.check(logs == yard.logs, LOST, || how.clone());
            ["sessions/two_arms-1", "sessions/two_arms-2"].iter().for_each(|s| yard.swept(s, &how, findings));
            continue;
        }
        if before.is_none() {
            findings.check(done == 1, ENDED, || how.clone());
        }
        // A session of half a log may have been learned from as it was, before or instead of being gone on with.
        let cut = before == Some("cut");
        yard.look("s", &[0, 1], !cut, &how, findings);
        yard.swept("s", &how, findings);
        if k % 8 == 3 || k % 8 == 4 {
            let generation = yard.generation("s");
            findings.check(matches!(generation, Ok(Some(_))), MIXED, || format!("{how}: {generation:?}"));
        }
    }
}

/// A command that is killed: its words, the session that it begins with, and the generations that it may leave.
struct Victim {
    words: Vec<&'static str>,
    before: Option<&'static str>,
    /// How long it takes when nothing happens to it.
    takes: Duration,
}

impl Victim {
    /// Whether its session is one of touches and what is learned from them.
    fn learns(&self) -> bool {
        !["skin", "feel", "map"].contains(&self.words[0])
    }
}

fn victims() -> Vec<Victim> {
    let victim =
        |words: &[&'static str], before| Victim { words: words.to_vec(), before, takes: Duration::ZERO };
    vec![
        victim(&[&BABBLE[..], &["--seed", "1", "--out", "s"]].concat(), None),
        victim(&["babble", "--resume", "s", "--quiet"], Some("cut")),
        victim(&[&["learn", "s", "--quiet"], LEARN[0]].concat(), Some("whole-1")),
        victim(&[&["learn", "s", "--quiet"], LEARN[1]].concat(), Some("learned-0")),
        victim(&["learn", "whole-1", "--out", "s", "--learner", "hersch", "--quiet"], None),
        victim(&[&RECORDING[..], &["--out", "s"]].concat(), None),
        victim(&["report", "s"], Some("whole-1")),
        victim(&["export", "s", "--out", "s/learned.urdf"], Some("whole-1")),
        victim(&["reach", "s", "--hand", "left_fore"], Some("whole-1")),
        victim(&["skin", "map", "s", "--out", "s/map.json", "--quiet"], Some("stroked")),
        victim(&["skin", "feel", "arms.xml", "--strokes", "0.02", "--out", "s", "--quiet"], None),
    ]
}

/// What a victim's end, whatever it was, has left: looked at as it is, and again after the same command once more.
fn aftermath(yard: &Yard, victim: &Victim, how: &str, findings: &mut Findings) {
    let folder = yard.path("s");
    let pending = folder.join(".generation").exists();
    findings.pending += usize::from(pending);
    if !pending {
        if victim.learns() {
            yard.look("s", &[0, 1], false, how, findings);
        }
        if victim.learns() {
            let generation = yard.generation("s");
            let right = match victim.words[0] {
                "learn" if victim.before.is_some() => matches!(generation, Ok(Some(_))),
                _ => generation.is_ok() || !folder.exists(),
            };
            findings.check(right, MIXED, || format!("{how}: {generation:?}"));
        } else {
            let files =
                ["session.json", "firings.jsonl", "sensations.jsonl"].map(|file| folder.join(file).exists());
            findings.check(files == [files[0]; 3], MIXED, || format!("{how}: {files:?}"));
        }
    } else if folder.join("session.json").exists() {
        // Whoever reads it first puts it in order.
        let read = match victim.learns() {
            true => yard.tries(&["export", "s", "--out", "other.xml"]),
            false => yard.tries(&["skin", "map", "s", "--out", "other.json", "--quiet"]),
        };
        findings.check(read.is_ok(), STALE, || format!("{how}: {read:?}"));
        if victim.learns() {
            let generation = yard.generation("s");
            findings
                .check(matches!(generation, Ok(Some(_))), MIXED, || format!("{how}, read: {generation:?}"));
        }
    }
    // The same once more comes to its end; of what is there already that is said.
    let begun = folder.join("session.json").exists() || folder.join(".generation/session.json").exists();
    let again = match (victim.words[0], victim.before) {
        ("babble", None) if begun => yard.tries(&["babble", "--resume", "s", "--quiet"]),
        (_, None) if begun => match yard.tries(&victim.words) {
            Err(message) if message.contains("already contains a session") => Ok(()),
            other => Err(format!("it is written twice: {other:?}")),
        },
        _ => yard.tries(&victim.words),
    };
    findings.check(again.is_ok(), STALE, || format!("{how}: once more {again:?}"));
    yard.swept("s", how, findings);
    if victim.learns() {
        yard.look("s", &[0], true, how, findings);
        let generation = yard.generation("s");
        findings
            .check(matches!(generation, Ok(Some(_))), MIXED, || format!("{how}, once more: {generation:?}"));
    }
}

/// Commands of which so many are killed at random moments before their end.
fn kills(yard: &Yard, count: usize, seed: u64, findings: &mut Findings) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut victims = victims();
    let prepare = |victim: &Victim| {
        let _ = fs::remove_dir_all(yard.path("s"));
        if let Some(before) = victim.before {
            yard.copy(before, "s");
        }
    };
    for victim in &mut victims {
        prepare(victim);
        let began = Instant::now();
        yard.succeeds(&victim.words);
        victim.takes = began.elapsed();
        assert!(victim.takes < PATIENCE);
    }
    let (mut done, mut k) = (0, 0);
    while done < count {
        assert!(k < 10 * count, "commands end before they are killed");
        let victim = &victims[k % victims.len()];
        prepare(victim);
        let mut child = yard.begin(&victim.words);
        std::thread::sleep(victim.takes.mul_f64(rng.random_range(0.0..1.0)));
        // On Unix this is SIGKILL, which nothing can catch.
        let _ = child.kill();
        let killed = child.wait().unwrap().code().is_none();
        let verb = victim.words[..2].join(" ");
        findings.tried(if killed { "killed" } else { "came to their end first" });
        aftermath(yard, victim, &format!("kill {k} of seed {seed}, {verb}"), findings);
        (done, k) = (done + usize::from(killed), k + 1);
    }
}

/// Commands of which no file may become longer than so many blocks of 1024 bytes, as on a disk with no more room.
fn no_room(yard: &Yard, blocks: impl Iterator<Item = usize> + Clone, findings: &mut Findings) {
    for victim in victims() {
        for blocks in blocks.clone() {
            let _ = fs::remove_dir_all(yard.path("s"));
            if let Some(before) = victim.before {
                yard.copy(before, "s");
            }
            let line = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
            let mut shell = Command::new("bash");
            shell.args(["-c", &line, env!("CARGO_BIN_EXE_bodyschema")]).args(&victim.words);
            let end = said(&shell.current_dir(yard.place.path()).output().unwrap());
            findings.tried(if end.is_ok() {
                "ended well within their room"
            } else {
                "ended for want of room"
            });
            let how = format!("{blocks} blocks, {}: {end:?}", victim.words[..2].join(" "));
            findings.check(is_told(&end, "s"), ENDED, || how.clone());
            aftermath(yard, &victim, &how, findings);
        }
    }
}

/// Commands on a disk that has so many blocks of 1024 bytes left.
fn full_disk(yard: &Yard, blocks: impl Iterator<Item = usize> + Clone, findings: &mut Findings) {
    for victim in victims() {
        for blocks in blocks.clone() {
            let _ = fs::remove_dir_all(yard.path("s"));
            if let Some(before) = victim.before {
                yard.copy(before, "s");
            }
            let path = yard.path("fill");
            fs::write(yard.path("room"), vec![0; 1024 * blocks]).unwrap();
            let mut file = fs::File::create(&path).unwrap();
            let full = (0..MOST_FILLED).any(|_| file.write_all(&[0; 1024]).is_err());
            assert!(full, "the disk is too great to be filled: name a smaller one");
            // One that is open keeps its room when it is removed.
            drop(file);
            fs::remove_file(yard.path("room")).unwrap();
            let end = said(&yard.begin(&victim.words).wait_with_output().unwrap());
            fs::remove_file(&path).unwrap();
            findings.tried(if end.is_ok() {
                "ended well within their room"
            } else {
                "ended for want of room"
            });
            let how = format!("{blocks} blocks, {}: {end:?}", victim.words[..2].join(" "));
            findings.check(is_told(&end, ""), ENDED, || how.clone());
            aftermath(yard, &victim, &how, findings);
        }
    }
}

#[test]
fn two_processes_on_one_folder_lose_and_mix_nothing() {
    let (yard, mut findings) = (Yard::new(), Findings::default());
    pairs(&yard, 16, 1, &mut findings);
    findings.told();
}

#[test]
fn a_process_killed_at_any_moment_leaves_one_generation() {
    let (yard, mut findings) = (Yard::new(), Findings::default());
    kills(&yard, 22, 1, &mut findings);
    findings.told();
}

#[test]
fn a_process_without_room_ends_with_a_sentence_and_leaves_one_generation() {
    let (yard, mut findings) = (Yard::new(), Findings::default());
    no_room(&yard, [0, 20].into_iter(), &mut findings);
    findings.told();
}

/// By `cargo test --release --test it large::writers -- --ignored --nocapture`.
mod large {
    use super::*;

    #[test]
    #[ignore = "large: 1,000 pairs of processes"]
    fn writers_in_pairs() {
        let (yard, mut findings) = (Yard::new(), Findings::default());
        pairs(&yard, 1000, 7000, &mut findings);
        findings.told();
    }

    #[test]
    #[ignore = "large: 1,000 processes that are killed"]
    fn writers_that_are_killed() {
        let (yard, mut findings) = (Yard::new(), Findings::default());
        kills(&yard, 1000, 7000, &mut findings);
        findings.told();
    }

    /// The disk is a small one, as `mount -t tmpfs -o size=16m tmpfs DIR` makes it; `BODYSCHEMA_SMALL_DISK` names it.
    #[test]
    #[ignore = "large: every command on a disk with 0 to 640 kilobytes left"]
    fn writers_on_a_full_disk() {
        let disk = std::env::var_os("BODYSCHEMA_SMALL_DISK").expect("BODYSCHEMA_SMALL_DISK names no folder");
        let (yard, mut findings) = (Yard::on(TempDir::new_in(disk).unwrap()), Findings::default());
        full_disk(&yard, (0..=640).step_by(32), &mut findings);
        findings.told();
    }

    #[test]
    #[ignore = "large: every command on a disk that is full after each of 40 blocks"]
    fn writers_without_room() {
        let (yard, mut findings) = (Yard::new(), Findings::default());
        no_room(&yard, 0..40, &mut findings);
        findings.told();
    }
}
