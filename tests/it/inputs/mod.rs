//! Bad files: whatever a reader is given, it ends with a value that can be or with a sentence, and never in a panic, for ever, or
//! by a signal.
//!
//! Good files of every kind are changed by a seed. A few of each are tried with all other tests; [`large`] tries twenty
//! thousand, and writes a sample of those that were taken, with what was changed in them, into the folder that
//! `BODYSCHEMA_ACCEPTED` names.

mod commands;
mod limits;
mod mutations;
mod readers;
mod refusals;

use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use mutations::mutated;
use readers::{Ending, Reader, Yard};

/// How long a reader may take with a file.
const PATIENCE: Duration = Duration::from_secs(20);
/// Bytes of a change that are shown at the most, and of what is before it.
const SHOWN: usize = 160;

/// How reading ended, of one reader.
#[derive(Default)]
struct Counts {
    inputs: usize,
    refused: usize,
    accepted: usize,
    /// Of these, read as the good file is.
    same: usize,
    panics: usize,
    hangs: usize,
    signals: usize,
}

/// Estimated quantities.
#[derive(Default)]
struct Findings {
    counts: BTreeMap<&'static str, Counts>,
    wrong: Vec<String>,
    /// Of every reader a sample of what it took.
    samples: BTreeMap<&'static str, Vec<String>>,
}

impl Findings {
    fn told(&self) {
        println!(
            "{:<20}{:>8}{:>9}{:>9}{:>10}{:>7}{:>7}{:>8}",
            "reader", "inputs", "refused", "accepted", "unchanged", "panics", "hangs", "signals"
        );
        let mut all = Counts::default();
        for (name, c) in &self.counts {
            println!(
                "{name:<20}{:>8}{:>9}{:>9}{:>10}{:>7}{:>7}{:>8}",
                c.inputs, c.refused, c.accepted, c.same, c.panics, c.hangs, c.signals
            );
            all.inputs += c.inputs;
            all.refused += c.refused;
            all.accepted += c.accepted;
            all.same += c.same;
            all.panics += c.panics;
            all.hangs += c.hangs;
            all.signals += c.signals;
        }
        println!(
            "{:<20}{:>8}{:>9}{:>9}{:>10}{:>7}{:>7}{:>8}",
            "all", all.inputs, all.refused, all.accepted, all.same, all.panics, all.hangs, all.signals
        );
        assert!(self.wrong.is_empty(), "{:#?}", self.wrong);
    }

    /// Writes the samples, `count` in all, into the folder that is named by the environment, if any.
    fn write_samples(&self, count: usize) {
        let Some(folder) = std::env::var_os("BODYSCHEMA_ACCEPTED").map(std::path::PathBuf::from) else {
            return;
        };
        fs::create_dir_all(&folder).unwrap();
        let each = count.div_ceil(self.samples.len().max(1));
        for (name, samples) in &self.samples {
            let text = samples.iter().take(each).cloned().collect::<String>();
            fs::write(folder.join(format!("{}.txt", name.replace([' ', ','], "_"))), text).unwrap();
        }
    }
}

/// What differs between two files: where, what it was, and what it is.
fn difference(old: &[u8], new: &[u8]) -> String {
    let begin = old.iter().zip(new).take_while(|(a, b)| a == b).count();
    let most = old.len().min(new.len()) - begin;
    let end = old.iter().rev().zip(new.iter().rev()).take(most).take_while(|(a, b)| a == b).count();
    let shown = |bytes: &[u8]| {
        let text: String = String::from_utf8_lossy(&bytes[..bytes.len().min(SHOWN)]).escape_debug().collect();
        let more = if bytes.len() > SHOWN { format!("… ({} bytes)", bytes.len()) } else { String::new() };
        format!("{text}{more}")
    };
    let before =
        String::from_utf8_lossy(&old[begin.saturating_sub(SHOWN)..begin]).escape_debug().collect::<String>();
    format!(
        "    …{before}\n  - {}\n  + {}\n",
        shown(&old[begin..old.len() - end]),
        shown(&new[begin..new.len() - end])
    )
}

/// Reads `count` bad files with a reader.
fn attack(
    reader: &Reader,
    count: usize,
    seed: u64,
    findings: &Mutex<Findings>,
    watch: &AtomicU64,
    began: Instant,
) {
    let original = {
        fs::write(&reader.file, &reader.good).unwrap();
        match (reader.read)(&reader.file) {
            Ending::Accepted(value) => value,
            Ending::Refused(sentence) => panic!("{}: the good file is refused: {sentence}", reader.name),
            _ => panic!("{}: the good file is not read", reader.name),
        }
    };
    for number in 0..count as u64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(number);
        let bad = mutated(&mut rng, &reader.good);
        fs::write(&reader.file, &bad.bytes).unwrap();
        let started = Instant::now();
        watch.store(started.duration_since(began).as_millis() as u64 + 1, Ordering::Relaxed);
        let ending = catch_unwind(AssertUnwindSafe(|| (reader.read)(&reader.file)));
        watch.store(0, Ordering::Relaxed);
        let took = started.elapsed();
        let mut findings = findings.lock().unwrap();
        let counts = findings.counts.entry(reader.name).or_default();
        counts.inputs += 1;
        let place = format!("{}, seed {seed}, number {number}: {}", reader.name, bad.how);
        let wrong = match ending {
            Ok(Ending::Accepted(value)) => {
                counts.accepted += 1;
                let same = value == original;
                counts.same += usize::from(same);
                let kept = if same { "read as before" } else { "read otherwise" };
                let sample = format!("{place} [{kept}]\n{}", difference(&reader.good, &bad.bytes));
                let taken = counts.accepted;
                let samples = findings.samples.entry(reader.name).or_default();
                // Each is as likely to be among them.
                if samples.len() < 40 {
                    samples.push(sample);
                } else {
                    let at = rng.random_range(0..taken);
                    if let Some(place) = samples.get_mut(at) {
                        *place = sample;
                    }
                }
                None
            }
            Ok(Ending::Refused(sentence)) => {
                counts.refused += 1;
                (sentence.trim().is_empty() || sentence.len() > 20_000)
                    .then(|| format!("no sentence: {sentence:.100}"))
            }
            Ok(Ending::Hang) => {
                counts.hangs += 1;
                Some("it hangs".into())
            }
            Ok(Ending::Signal(signal)) => {
                counts.signals += 1;
                Some(format!("signal {signal}"))
            }
            Ok(Ending::Panic(said)) => {
                counts.panics += 1;
                Some(said)
            }
            Err(_) => {
                counts.panics += 1;
                Some("it panics".into())
            }
        };
        let slow = (took > PATIENCE && !reader.process).then(|| format!("it takes {took:?}"));
        if let Some(wrong) = wrong.or(slow) {
            findings.wrong.push(format!("{place}: {wrong}"));
        }
    }
}

/// Reads `count` bad files in all.
fn attack_all(count: usize, seed: u64) -> Findings {
    let yard = Yard::new();
    let readers: Vec<Reader> = yard.readers().into_iter().chain(yard.commands()).collect();
    let shares: usize = readers.iter().map(|reader| reader.share).sum();
    let findings = Mutex::new(Findings::default());
    let (watch, began) = (AtomicU64::new(0), Instant::now());
    let done = AtomicU64::new(0);
    std::thread::scope(|scope| {
        let (findings, watch, done) = (&findings, &watch, &done);
        // What never ends in this process is told of, and ends it.
        scope.spawn(move || {
            while done.load(Ordering::Relaxed) == 0 {
                std::thread::sleep(Duration::from_millis(50));
                let since = watch.load(Ordering::Relaxed);
                if since > 0 && began.elapsed().as_millis() as u64 > since + 10 * PATIENCE.as_millis() as u64
                {
                    eprintln!("a reader does not come to an end");
                    std::process::abort();
                }
            }
        });
        let of_process = |process: bool| readers.iter().filter(move |reader| reader.process == process);
        let share = move |reader: &Reader| (count * reader.share).div_ceil(shares);
        let of_processes: Vec<&Reader> = of_process(true).collect();
        let processes = scope.spawn(move || {
            for reader in of_processes {
                attack(reader, share(reader), seed, findings, &AtomicU64::new(0), began);
            }
        });
        for reader in of_process(false) {
            attack(reader, share(reader), seed, findings, watch, began);
        }
        processes.join().unwrap();
        done.store(1, Ordering::Relaxed);
    });
    findings.into_inner().unwrap()
}

#[test]
fn bad_files_of_every_kind_end_in_a_value_or_a_sentence() {
    attack_all(2500, 1).told();
}

mod large {
    use super::*;

    #[test]
    #[ignore = "large: 20,000 bad files"]
    fn inputs() {
        let seed = std::env::var("BODYSCHEMA_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(7000);
        let findings = attack_all(20_000, seed);
        findings.write_samples(500);
        findings.told();
    }
}
