//! `bodyschema study gallery`: many bodies, each babbled and measured by a process of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::{Map, Value, json};

use crate::cli::ends_with::ENDS_WITH;
use crate::cli::folders::{Force, free_folder};
use crate::cli::{Failure, Outcome, output, progress};
use crate::view::table::{NONE, Table};
use crate::view::text::{error_number, plural};

/// The page that the gallery is.
const PAGE_FILE: &str = "gallery.md";
/// The same for programs.
const TABLE_FILE: &str = "gallery.json";
/// How the page begins.
const HEADING: &str = "# Gallery

Touches and seconds are of the sessions by receptors: the median, and in parentheses the most. The worst is the greatest error of
located skin, in another limb's frame, over random postures.

";
/// The columns of its table.
const COLUMNS: [&str; 8] =
    ["", "body", "joints, DOF", "receptors", "touches", "seconds", "by receptors", "by contact points"];
/// Width and height of a picture, pixels.
const PICTURE: &str = "320x240";
/// A claim is not wrong by less than this, millimetres, …
const NEGLIGIBLE_MM: f64 = 1.0;
/// … nor if all errors are, in the root mean square, so many times as large as noise makes them at least.
const BY_NOISE: f64 = 2.0;
/// What touches report, in the order of the table's columns.
const INPUTS: [&str; 2] = ["receptor", "contact"];
/// What is kept of what `inspect --json` prints, and `babble --json`.
const OF_LOOK: [&str; 4] = ["creature", "joints", "dof", "receptors"];
const OF_SESSION: [&str; 7] =
    ["touches", "converged", "reason", "undetermined_limbs", "changes", "determined_mm", "bound_mm"];

/// Babble many bodies, one after the other, and put what came of each on a page with its picture.
///
/// Each body is inspected, drawn, and babbled by receptors and by contact points, so often, with default options. A claim is
/// compared with the model: what is not named must be right. What cannot be read, cannot touch itself, or is not learned is
/// reported in its row, in the program's own words.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema study gallery mjcf/hexapod/hexapod.xml mjcf/snake/snake.xml --trials 1 --out bodies    # takes minutes
  bodyschema study gallery mjcf/*/*.xml --trials 3 --out bodies    # takes minutes")]
pub struct GalleryArguments {
    /// MJCF files of creatures
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// Sessions by each input, with seeds of their own
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    trials: u16,
    /// Seed of the first trial; the next ones count on from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The gallery's folder
    #[arg(long, short, value_name = "DIR", default_value = "gallery", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub fn run(args: &GalleryArguments) -> Outcome {
    let last = args.seed.checked_add(u64::from(args.trials) - 1);
    let last = last.ok_or("the last trial's seed would be too great: give a smaller --seed")?;
    let files = [PAGE_FILE, TABLE_FILE];
    let lock = free_folder(Some(&args.out), args.force, "gallery", &files, |_| args.out.clone())?;
    let (out, sessions) = (lock.folder(), lock.scratch()?);
    let bar = progress::steps(args.models.len() as u64);
    let mut table = json!({ "seed": args.seed, "trials": args.trials });
    let mut bodies: Vec<Value> = Vec::new();
    for model in &args.models {
        bar.set_message(model.display().to_string());
        bodies.push(babbled(model, args.seed..=last, out, &sessions)?);
        // Written after every body: nothing is lost if it is interrupted.
        table["bodies"] = json!(bodies);
        output::file(&out.join(TABLE_FILE), format!("{table:#}\n"))?;
        output::file(&out.join(PAGE_FILE), page(&bodies))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    lock.commit()?;
    if args.json {
        return output::json(&table);
    }
    say!("{}", page(&bodies).trim_end());
    say!("\n{PAGE_FILE}, {TABLE_FILE} and the pictures are in {}", args.out.display());
    Ok(())
}

/// The page: a row per body, and the command that made it.
fn page(bodies: &[Value]) -> String {
    let table = Table::new(COLUMNS, bodies.iter().map(row)).markdown();
    format!("{HEADING}{table}\n```text\n{}\n```\n", output::command_line().join(" "))
}

/// This program, to be run again with some words.
fn itself(words: &[&str]) -> Result<Command, Failure> {
    let program = std::env::current_exe().map_err(|error| {
        Failure(format!("the program does not find itself ({error}): call it by its path"))
    })?;
    let mut command = Command::new(program);
    command.args(words).stdin(Stdio::null()).env(ENDS_WITH, std::process::id().to_string());
    Ok(command)
}

/// What a command about a model printed as JSON, or the sentence in which it refused.
fn printed(words: &[&str], model: &Path) -> Result<Result<Value, String>, Failure> {
    let output = itself(words)?.arg("--json").arg("--").arg(model).output().map_err(|error| {
        Failure(format!(
            "the program cannot be run again ({error}): see that there are processes and memory left"
        ))
    })?;
    if output.status.success() {
        return Ok(Ok(serde_json::from_slice(&output.stdout)?));
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let last = said.trim().lines().last().unwrap_or_default();
    let sentence = last.strip_prefix("bodyschema: ").unwrap_or(last).to_string();
    Ok(Err(if sentence.is_empty() { format!("it ended with {}", output.status) } else { sentence }))
}

/// Some fields of what a command printed; the sentence in which it refused as `refused`.
fn kept(printed: Result<Value, String>, fields: &[&str]) -> Value {
    match printed {
        Ok(all) => {
            fields.iter().map(|field| (field.to_string(), all[field].clone())).collect::<Map<_, _>>().into()
        }
        Err(sentence) => json!({ "refused": sentence }),
    }
}

/// Inspects a body, draws it, and lets it babble: what is known of it before it moves, the limbs that can touch others, and
/// what came of each session.
fn babbled(
    model: &Path,
    seeds: impl Iterator<Item = u64> + Clone,
    out: &Path,
    sessions: &Path,
) -> Result<Value, Failure> {
    let name = model.file_stem().unwrap_or_default().to_string_lossy();
    let looked = printed(&["inspect"], model)?;
    let pairs = looked.as_ref().ok().and_then(|all| all["limb_pairs"].as_array());
    let touching = pairs.into_iter().flatten().filter(|pair| pair["relation"] == "touch");
    let touching: Vec<Value> =
        touching.flat_map(|pair| pair["limbs"].as_array()).flatten().cloned().collect();
    let refused = looked.is_err();
    let mut body =
        json!({ "name": name, "model": model, "touching": touching, "looked": kept(looked, &OF_LOOK) });
    if refused {
        return Ok(body);
    }
    let picture = format!("{name}.png");
    let mut draw = itself(&["render", "--size", PICTURE, "--out"])?;
    let drawn = draw.arg(out.join(&picture)).arg("--").arg(model).output();
    body["picture"] = json!(drawn.is_ok_and(|drawn| drawn.status.success()).then_some(picture));
    let mut trials = Vec::new();
    for (input, seed) in INPUTS.iter().flat_map(|input| seeds.clone().map(move |seed| (input, seed))) {
        let session = sessions.join(format!("{name}-{input}-{seed}")).display().to_string();
        let (began, seed_word) = (Instant::now(), seed.to_string());
        let words = ["babble", "--quiet", "--input", input, "--seed", &seed_word, "--out", &session];
        let came = kept(printed(&words, model)?, &OF_SESSION);
        let _ = std::fs::remove_dir_all(&session);
        let seconds = began.elapsed().as_secs_f64();
        trials.push(json!({ "input": input, "seed": seed, "seconds": seconds, "came": came }));
    }
    body["trials"] = json!(trials);
    Ok(body)
}

/// A body's row of the page.
fn row(body: &Value) -> [String; 8] {
    let (name, looked) = (body["name"].as_str().unwrap_or_default().to_string(), &body["looked"]);
    if let Some(sentence) = looked["refused"].as_str() {
        let mut row = [const { String::new() }; 8];
        (row[1], row[6]) = (name, sentence.to_string());
        return row;
    }
    let picture = body["picture"].as_str().map_or(String::new(), |file| format!("![{name}]({file})"));
    let trials = || body["trials"].as_array().into_iter().flatten();
    let [receptors, points] =
        INPUTS.map(|input| trials().filter(|trial| trial["input"] == input).collect::<Vec<_>>());
    let touching = body["touching"].as_array().map_or(&[][..], Vec::as_slice);
    [
        picture,
        name,
        format!("{}, {}", looked["joints"], looked["dof"]),
        looked["receptors"].to_string(),
        spread(receptors.iter().filter_map(|trial| trial["came"]["touches"].as_f64())),
        spread(receptors.iter().filter_map(|trial| trial["seconds"].as_f64())),
        verdict(&receptors, touching),
        verdict(&points, touching),
    ]
}

/// What came of some sessions, in words; `touching` are the limbs that can touch others.
fn verdict(trials: &[&Value], touching: &[Value]) -> String {
    let all = || trials.iter().map(|trial| &trial["came"]);
    let mut words: Vec<String> =
        all().filter_map(|came| came["refused"].as_str()).take(1).map(reason).collect();
    let came: Vec<&Value> = all().filter(|came| came["refused"].is_null()).collect();
    let (learned, not): (Vec<&Value>, Vec<&Value>) = came.iter().partition(|came| came["converged"] == true);
    if !learned.is_empty() {
        let worst = learned.iter().filter_map(|came| came["determined_mm"]["max"].as_f64());
        let worst = short(worst.fold(f64::NAN, f64::max));
        let named = |came: &&Value| {
            let limbs = came["undetermined_limbs"].as_array().into_iter().flatten();
            limbs.filter(|limb| touching.contains(limb)).count()
        };
        let of = if not.is_empty() { String::new() } else { format!(" {} of {}", learned.len(), came.len()) };
        let except = match learned.iter().map(named).max().unwrap_or(0) {
            0 => String::new(),
            many => format!(", but for {}", plural(many, "limb")),
        };
        let changed = |came: &&Value| came["changes"].as_array().is_some_and(|all| !all.is_empty());
        let changes = if learned.iter().any(changed) { ", CHANGED" } else { "" };
        let wrong = if learned.iter().any(|came| is_wrong(came)) { " WRONG" } else { "" };
        words.push(format!("learned{of}{except}; worst {worst} mm{wrong}{changes}"));
    }
    if let Some(why) = not.first().and_then(|came| came["reason"].as_str()) {
        words.push(format!("not learned: {}", reason(why)));
    }
    words.join("; ")
}

/// A sentence without the file that it begins with.
fn reason(sentence: &str) -> String {
    let (file, rest) = sentence.split_once(": ").unwrap_or(("", sentence));
    if Path::new(file).extension().is_some() { rest.to_string() } else { sentence.to_string() }
}

/// Whether any claim of a session is off by more than matters, and by more than noisy senses make up for.
fn is_wrong(came: &Value) -> bool {
    let worst = came["determined_mm"]["max"].as_f64().unwrap_or(0.0);
    let ratio = came["bound_mm"]["ratio"].as_f64().unwrap_or(f64::INFINITY);
    worst > NEGLIGIBLE_MM && ratio > BY_NOISE
}

/// The median of some numbers, and in parentheses the greatest if it is another.
fn spread(numbers: impl Iterator<Item = f64>) -> String {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.sort_by(f64::total_cmp);
    let Some(greatest) = numbers.last() else { return NONE.to_string() };
    let [middle, greatest] = [numbers[numbers.len() / 2], *greatest].map(|number| format!("{number:.0}"));
    if middle == greatest { middle } else { format!("{middle} ({greatest})") }
}

/// A number of millimetres to two digits, as pages of galleries have it.
fn short(millimetres: f64) -> String {
    if millimetres >= 0.1 { format!("{millimetres:.2}") } else { error_number(millimetres) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_told_shortly() {
        assert_eq!(spread([3.0, 1.0, 2.0].into_iter()), "2 (3)");
        assert_eq!(spread([2.0].into_iter()), "2");
        assert_eq!(spread([].into_iter()), "–");
        assert_eq!([f64::NAN, 1e-9, 0.0123, 4.567].map(short), ["–", "< 0.001", "0.012", "4.57"]);
    }

    #[test]
    fn a_claim_that_is_off_is_said_to_be_wrong_and_what_touches_nothing_is_not_named() {
        let touching = ["arm", "leg"].map(Value::from);
        let came = |max: f64, limbs: &[&str]| {
            let came = json!({"converged": true, "undetermined_limbs": limbs, "determined_mm": {"max": max}});
            json!({ "came": came })
        };
        let [right, wrong] = [came(0.02, &["leg", "eye"]), came(12.5, &[])];
        assert_eq!(verdict(&[&right], &touching), "learned, but for 1 limb; worst 0.020 mm");
        assert!(verdict(&[&right, &wrong], &touching).ends_with("worst 12.50 mm WRONG"));
        let refused = json!({ "came": { "refused": "a.xml: no touch | at all" } });
        assert_eq!(verdict(&[&refused], &touching), "no touch | at all");
    }
}
