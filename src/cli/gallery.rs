//! `bodyschema gallery`: many bodies, each babbled and measured by a process of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::ends_with::ENDS_WITH;
use super::folders::{Force, free_folder};
use super::{Failure, Outcome, output, progress};

/// The page that the gallery is.
const PAGE_FILE: &str = "gallery.md";
/// The same for programs.
const TABLE_FILE: &str = "gallery.json";
/// How the page begins.
const HEADING: &str = "# Gallery

Touches and seconds are of the sessions by receptors: the median, and in parentheses the most. The worst is the greatest error of skin
whose place is claimed, in another limb's frame, over random postures.

| | body | joints, DOF | receptors | touches | seconds | by receptors | by contact points |
|---|---|---|---|---|---|---|---|
";
/// Width and height of a picture, pixels.
const PICTURE: &str = "320x240";
/// A claim is not wrong by less than this, millimetres, …
const NEGLIGIBLE_MM: f64 = 1.0;
/// … nor where all errors are, in the root mean square, so many times as large as noise makes them at the least.
const BY_NOISE: f64 = 2.0;
/// What touches report, in the order of the table's columns.
const INPUTS: [&str; 2] = ["receptor", "contact"];

/// Babble many bodies, one after the other, and put what came of each on a page with its picture.
///
/// Each body is looked at, drawn, and babbled by receptors and by contact points, so often, with options that stand by
/// default. A claim is held against the model: what is not named is to be right. What cannot be read, cannot touch itself,
/// or is not learned is said in its row, in the program's own words.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema gallery mjcf/hexapod/hexapod.xml mjcf/snake/snake.xml --trials 1 --out bodies    # takes minutes
  bodyschema gallery mjcf/*/*.xml --trials 3 --out bodies    # takes minutes")]
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

/// What is known of a body before it moves.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Looked {
    creature: String,
    joints: usize,
    dof: usize,
    receptors: usize,
    #[serde(skip_serializing)]
    limb_pairs: Vec<LookedPair>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct LookedPair {
    limbs: [String; 2],
    relation: String,
}

/// One session.
#[derive(Clone, Debug, Serialize)]
struct Trial {
    input: &'static str,
    seed: u64,
    seconds: f64,
    /// What came of it; the sentence of a refusal where nothing did.
    came: Result<Came, String>,
}

/// What `babble --json` tells, as far as it is of use here.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Came {
    touches: usize,
    converged: bool,
    reason: Option<String>,
    undetermined: Vec<String>,
    undetermined_limbs: Vec<String>,
    changes: Vec<Value>,
    determined_mm: Option<Errors>,
    bound_mm: Option<Bound>,
}

/// Errors beside the least that the touches allow.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Bound {
    ratio: Option<f64>,
}

/// Errors of what is claimed, millimetres.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Errors {
    max: Option<f64>,
}

/// A body with its sessions.
#[derive(Clone, Debug, Serialize)]
struct Row {
    name: String,
    model: PathBuf,
    looked: Result<Looked, String>,
    picture: Option<String>,
    trials: Vec<Trial>,
}

pub fn run(args: &GalleryArguments) -> Outcome {
    let last = args.seed.checked_add(u64::from(args.trials) - 1);
    let last = last.ok_or("the last trial's seed would be too great: give a smaller --seed")?;
    let files = [PAGE_FILE, TABLE_FILE];
    let lock = free_folder(Some(&args.out), args.force, "gallery", &files, |_| args.out.clone())?;
    let out = lock.folder().to_path_buf();
    let sessions = lock.scratch()?;
    let bar = progress::steps(args.models.len() as u64);
    let mut rows = Vec::new();
    for model in &args.models {
        bar.set_message(model.display().to_string());
        rows.push(row(model, args.seed..=last, &out, &sessions)?);
        let table = json!({ "seed": args.seed, "trials": args.trials, "bodies": rows });
        // Written after every body: nothing is lost where it is interrupted.
        output::file(&out.join(TABLE_FILE), format!("{}\n", serde_json::to_string_pretty(&table)?))?;
        output::file(&out.join(PAGE_FILE), page(&rows))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    lock.commit()?;
    if args.json {
        return output::json(&json!({ "seed": args.seed, "trials": args.trials, "bodies": rows }));
    }
    say!("{}", page(&rows).trim_end());
    say!("\n{PAGE_FILE}, {TABLE_FILE} and the pictures are in {}", args.out.display());
    Ok(())
}

/// Looks at a body, draws it, and lets it babble.
fn row(
    model: &Path,
    seeds: impl Iterator<Item = u64> + Clone,
    out: &Path,
    sessions: &Path,
) -> Result<Row, Failure> {
    let name = model.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let looked: Result<Looked, String> = told(itself()?.arg("inspect").arg("--json").arg("--").arg(model))?;
    let mut row = Row { name, model: model.to_path_buf(), looked, picture: None, trials: Vec::new() };
    if row.looked.is_err() {
        return Ok(row);
    }
    let picture = format!("{}.png", row.name);
    let drawn = itself()?
        .arg("render")
        .arg(model)
        .args(["--size", PICTURE, "--out"])
        .arg(out.join(&picture))
        .output();
    row.picture = drawn.is_ok_and(|drawn| drawn.status.success()).then_some(picture);
    for input in INPUTS {
        for seed in seeds.clone() {
            let session = sessions.join(format!("{}-{input}-{seed}", row.name));
            let began = Instant::now();
            let seed_text = seed.to_string();
            let came = told(
                itself()?
                    .args(["babble", "--quiet", "--json", "--input", input, "--seed", &seed_text, "--out"])
                    .arg(&session)
                    .arg("--")
                    .arg(model),
            )?;
            let _ = std::fs::remove_dir_all(&session);
            row.trials.push(Trial { input, seed, seconds: began.elapsed().as_secs_f64(), came });
        }
    }
    Ok(row)
}

/// This program, to be run again.
fn itself() -> Result<Command, Failure> {
    let program = std::env::current_exe().map_err(|error| {
        Failure(format!("the program does not find itself ({error}): call it by its path"))
    })?;
    let mut command = Command::new(program);
    command.stdin(Stdio::null()).env(ENDS_WITH, std::process::id().to_string());
    Ok(command)
}

/// What a command told as JSON, or the sentence in which it refused.
fn told<T: for<'d> Deserialize<'d>>(command: &mut Command) -> Result<Result<T, String>, Failure> {
    let output = command.output().map_err(|error| {
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

/// The page: a row per body, and the command that made it.
fn page(rows: &[Row]) -> String {
    let mut text = HEADING.to_string();
    rows.iter().for_each(|row| text += &row.line());
    text + &format!("\n```text\n{}\n```\n", output::command_line().join(" "))
}

impl Row {
    fn line(&self) -> String {
        let looked = match &self.looked {
            Ok(looked) => looked,
            Err(sentence) => return format!("| | {} | | | | | {sentence} | |\n", self.name),
        };
        let picture = self.picture.as_ref().map_or(String::new(), |file| format!("![{}]({file})", self.name));
        let by = |input: &str| self.trials.iter().filter(|trial| trial.input == input).collect::<Vec<_>>();
        let [receptors, points] = INPUTS.map(by);
        let touches = receptors.iter().filter_map(|trial| Some(trial.came.as_ref().ok()?.touches as f64));
        let seconds = receptors.iter().map(|trial| trial.seconds);
        format!(
            "| {picture} | {} | {}, {} | {} | {} | {} | {} | {} |\n",
            self.name,
            looked.joints,
            looked.dof,
            looked.receptors,
            spread(touches),
            spread(seconds),
            looked.verdict(&receptors),
            looked.verdict(&points)
        )
    }
}

impl Looked {
    /// What came of some sessions, in words.
    fn verdict(&self, trials: &[&Trial]) -> String {
        let came: Vec<&Came> = trials.iter().filter_map(|trial| trial.came.as_ref().ok()).collect();
        let refusals = trials.iter().filter_map(|trial| trial.came.as_ref().err());
        let mut words: Vec<String> = refusals.take(1).map(|sentence| self.reason(sentence)).collect();
        let learned: Vec<&&Came> = came.iter().filter(|came| came.converged).collect();
        let not: Vec<&&Came> = came.iter().filter(|came| !came.converged).collect();
        if !learned.is_empty() {
            let worst = learned.iter().filter_map(|came| came.determined_mm.as_ref()?.max);
            let worst = worst.fold(f64::NAN, f64::max);
            let named = learned.iter().map(|came| self.named(came)).max().unwrap_or(0);
            let of =
                if not.is_empty() { String::new() } else { format!(" {} of {}", learned.len(), came.len()) };
            let except = match named {
                0 => String::new(),
                1 => ", but for 1 limb".to_string(),
                many => format!(", but for {many} limbs"),
            };
            let changes = if learned.iter().any(|came| !came.changes.is_empty()) { ", CHANGED" } else { "" };
            let wrong = if learned.iter().any(|came| came.is_wrong()) { " WRONG" } else { "" };
            words.push(format!("learned{of}{except}; worst {} mm{wrong}{changes}", short(worst)));
        }
        if let Some(reason) = not.first().and_then(|came| came.reason.as_ref()) {
            words.push(format!("not learned: {}", self.reason(reason)));
        }
        words.join("; ")
    }

    /// How many of the limbs that can touch others are named because touches leave them open.
    fn named(&self, came: &Came) -> usize {
        let touching = |limb: &&String| {
            self.limb_pairs.iter().any(|pair| pair.relation == "touch" && pair.limbs.contains(limb))
        };
        came.undetermined_limbs.iter().filter(touching).count()
    }

    /// A sentence without the file that it begins with.
    fn reason(&self, sentence: &str) -> String {
        let (file, rest) = sentence.split_once(": ").unwrap_or(("", sentence));
        let reason = if Path::new(file).extension().is_some() { rest } else { sentence };
        reason.replace('|', "/")
    }
}

impl Came {
    /// Whether anything that is claimed is off by more than matters, and by more than noisy senses make up for.
    fn is_wrong(&self) -> bool {
        let worst = self.determined_mm.as_ref().and_then(|errors| errors.max).unwrap_or(0.0);
        let ratio = self.bound_mm.as_ref().and_then(|bound| bound.ratio).unwrap_or(f64::INFINITY);
        worst > NEGLIGIBLE_MM && ratio > BY_NOISE
    }
}

/// The median of some numbers, and in parentheses the greatest where it is another.
fn spread(numbers: impl Iterator<Item = f64>) -> String {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.sort_by(f64::total_cmp);
    let Some(greatest) = numbers.last() else { return "–".to_string() };
    let [middle, greatest] = [numbers[numbers.len() / 2], *greatest].map(|number| format!("{number:.0}"));
    if middle == greatest { middle } else { format!("{middle} ({greatest})") }
}

/// A number of millimetres to two digits.
fn short(millimetres: f64) -> String {
    match millimetres {
        none if none.is_nan() => "–".to_string(),
        tiny if tiny < 1e-3 => "< 0.001".to_string(),
        small if small < 0.1 => format!("{small:.3}"),
        other => format!("{other:.2}"),
    }
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
        let pair = LookedPair { limbs: ["arm".into(), "leg".into()], relation: "touch".into() };
        let looked = Looked { creature: "c".into(), joints: 2, dof: 2, receptors: 9, limb_pairs: vec![pair] };
        let came = |max: f64, limbs: &[&str]| Trial {
            input: "receptor",
            seed: 1,
            seconds: 1.0,
            came: Ok(Came {
                touches: 100,
                converged: true,
                reason: None,
                undetermined: Vec::new(),
                undetermined_limbs: limbs.iter().map(ToString::to_string).collect(),
                changes: Vec::new(),
                determined_mm: Some(Errors { max: Some(max) }),
                bound_mm: None,
            }),
        };
        let [right, wrong] = [came(0.02, &["leg", "eye"]), came(12.5, &[])];
        assert_eq!(looked.verdict(&[&right]), "learned, but for 1 limb; worst 0.020 mm");
        assert!(looked.verdict(&[&right, &wrong]).ends_with("worst 12.50 mm WRONG"));
        let refused = Trial { came: Err("a.xml: no touch | at all".into()), ..right };
        assert_eq!(looked.verdict(&[&refused]), "no touch / at all");
    }
}
