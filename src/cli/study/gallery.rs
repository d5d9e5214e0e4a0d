//! `bodyschema study gallery`: many bodies, each babbled and measured.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};

use crate::cli::folders::{Force, new_folder};
use crate::cli::open::embodied;
use crate::cli::render::model_drawing;
use crate::cli::{Failure, Outcome, output, progress};
use crate::evaluation::Summary;
use crate::learning::Input;
use crate::mujoco::Renderer;
use crate::named::plural;
use crate::session::ModelSource;
use crate::study::by_default;
use crate::view::picture::png;
use crate::view::table::{NONE, Table};
use crate::view::text::error_number;

/// The page that the gallery is.
const PAGE_FILE: &str = "gallery.md";
/// The same for programs.
const TABLE_FILE: &str = "gallery.json";
/// How the page begins.
const HEADING: &str = "# Gallery

Touches and seconds are those of the sessions from receptors: median, and maximum in parentheses. Worst is the largest surface
error of a located limb in another limb's frame, over random postures.

";
/// The columns of its table.
const COLUMNS: [&str; 8] = [
    "picture",
    "body",
    "joints, DOF",
    "receptors",
    "touches",
    "seconds",
    "from receptors",
    "from contact points",
];
/// Width and height of a picture, pixels.
const PICTURE: [usize; 2] = [320, 240];
/// What touches report, in the order of the table's columns.
const INPUTS: [Input; 2] = [Input::Receptor, Input::Contact];

/// Learn many bodies, one after the other, and write a page with a picture and the results of each.
///
/// Each body is rendered, and learned from receptors and from contact points with default options. Claims are compared
/// with the model: every limb that is not reported as undetermined must be right. A body that cannot be read, has no
/// self-contact or is not learned is reported in its row with the program's message.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema study gallery mjcf/hexapod/hexapod.xml mjcf/snake/snake.xml --trials 1 --out bodies    # takes minutes
  bodyschema study gallery mjcf/*/*.xml --trials 3 --out bodies    # takes minutes")]
pub struct GalleryArguments {
    /// MJCF files of creatures
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// Sessions per input, each with its own seed
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    trials: u16,
    /// Seed of the first trial; the others follow consecutively
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
    let last = last.ok_or("the last trial's seed would be too large: give a smaller --seed")?;
    let lock = new_folder(&args.out, args.force, "gallery", &[PAGE_FILE, TABLE_FILE])?;
    let out = lock.folder();
    let bar = progress::steps(args.models.len() as u64);
    let mut table = json!({ "seed": args.seed, "trials": args.trials });
    let mut bodies: Vec<Value> = Vec::new();
    for model in &args.models {
        bar.set_message(model.display().to_string());
        bodies.push(body(model, args.seed..=last, out));
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
    say!("\n{PAGE_FILE}, {TABLE_FILE} and the pictures were written to {}", args.out.display());
    Ok(())
}

/// The page: a row per body, and the command that made it.
fn page(bodies: &[Value]) -> String {
    let table = Table::new(COLUMNS, bodies.iter().map(row)).markdown();
    format!("{HEADING}{table}\n```text\n{}\n```\n", output::command_line().join(" "))
}

/// Draws a body and lets it babble: its size, its picture, and a row of measurements per session; or why it is refused.
fn body(model: &Path, seeds: impl Iterator<Item = u64> + Clone, out: &Path) -> Value {
    let name = model.file_stem().unwrap_or_default().to_string_lossy();
    let source = ModelSource::new(model);
    let embodied = match embodied(source.clone()) {
        Err(Failure(sentence)) => return json!({ "name": name, "model": model, "refused": sentence }),
        Ok(embodied) => embodied,
    };
    let picture = format!("{name}.png");
    let picture = draw(&source, &out.join(&picture)).is_ok().then_some(picture);
    let trial = |(input, seed): (Input, u64)| {
        let began = Instant::now();
        let mut row = by_default(&source, input, seed);
        (row["input"], row["seed"]) = (json!(input.to_string()), json!(seed));
        row["seconds"] = json!(began.elapsed().as_secs_f64());
        row
    };
    let all = INPUTS.into_iter().flat_map(|input| seeds.clone().map(move |seed| (input, seed)));
    json!({
        "name": name,
        "model": model,
        "picture": picture,
        "joints": embodied.creature().joints().len(),
        "dof": embodied.creature().dof(),
        "receptors": embodied.agent().skin().receptors.len(),
        "trials": all.map(trial).collect::<Vec<_>>(),
    })
}

fn draw(source: &ModelSource, path: &Path) -> Outcome {
    let drawing = model_drawing(source, None)?;
    let mut renderer = Renderer::new(&drawing.model, PICTURE[0], PICTURE[1], true)?;
    let camera = drawing.camera(&renderer, None, None)?;
    output::file(path, png(&drawing.draw(&mut renderer, &drawing.shots[0], camera)?))
}

/// A body's row of the page.
fn row(body: &Value) -> [String; 8] {
    let name = body["name"].as_str().unwrap_or_default().to_string();
    if let Some(sentence) = body["refused"].as_str() {
        let mut row = [const { String::new() }; 8];
        (row[1], row[6]) = (name, reason(sentence));
        return row;
    }
    let picture = body["picture"].as_str().map_or(String::new(), |file| format!("![{name}]({file})"));
    let trials = || body["trials"].as_array().into_iter().flatten();
    let [receptors, points] =
        INPUTS.map(|input| trials().filter(|row| row["input"] == input.to_string()).collect::<Vec<_>>());
    let numbers = |field: &str| spread(receptors.iter().filter_map(|row| row[field].as_f64()));
    [
        picture,
        name,
        format!("{}, {}", body["joints"], body["dof"]),
        body["receptors"].to_string(),
        numbers("touches"),
        numbers("seconds"),
        verdict(&receptors),
        verdict(&points),
    ]
}

/// The results of some sessions in words.
fn verdict(rows: &[&Value]) -> String {
    let (learned, not): (Vec<&Value>, Vec<&Value>) =
        rows.iter().partition(|row| row["outcome"] == "learned" || row["outcome"] == "learned partly");
    let mut words = Vec::new();
    if !learned.is_empty() {
        let numbers = |field: &'static str| learned.iter().filter_map(move |row| row[field].as_f64());
        let worst = numbers("worst_mm").fold(f64::NAN, f64::max);
        let of = if not.is_empty() { String::new() } else { format!(" {} of {}", learned.len(), rows.len()) };
        let except = match numbers("limbs_named").fold(0.0, f64::max) as usize {
            0 => String::new(),
            many => format!(", except for {}", plural(many, "limb")),
        };
        let wrong = if numbers("wrong").any(|claims| claims > 0.0) { " WRONG" } else { "" };
        words.push(format!("learned{of}{except}; worst {} mm{wrong}", error_number(worst)));
    }
    words.extend(not.first().map(|row| {
        format!(
            "{}: {}",
            row["outcome"].as_str().unwrap_or_default(),
            reason(row["reason"].as_str().unwrap_or_default())
        )
    }));
    words.join("; ")
}

/// A sentence without the file that it begins with.
fn reason(sentence: &str) -> String {
    let (file, rest) = sentence.split_once(": ").unwrap_or(("", sentence));
    if Path::new(file).extension().is_some() { rest.to_string() } else { sentence.to_string() }
}

/// The median of some numbers, and in parentheses the greatest if it is another.
fn spread(numbers: impl Iterator<Item = f64>) -> String {
    let Summary { median, max, .. } = Summary::of(numbers);
    let [middle, greatest] = [median, max].map(|number| format!("{number:.0}"));
    match middle == greatest {
        _ if median.is_nan() => NONE.to_string(),
        true => middle,
        false => format!("{middle} ({greatest})"),
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
    }

    #[test]
    fn a_claim_that_is_off_is_said_to_be_wrong_and_limbs_that_are_not_located_are_counted() {
        let row = |outcome: &str, worst: f64, named: usize, wrong: usize| json!({"outcome": outcome, "worst_mm": worst, "limbs_named": named, "wrong": wrong});
        let [right, wrong] = [row("learned partly", 0.02, 1, 0), row("learned", 12.5, 0, 1)];
        assert_eq!(verdict(&[&right]), "learned, except for 1 limb; worst 0.020 mm");
        assert!(verdict(&[&right, &wrong]).ends_with("worst 12.5 mm WRONG"));
        let refused = json!({ "outcome": "refused", "reason": "a.xml: no touch | at all" });
        assert_eq!(verdict(&[&refused]), "refused: no touch | at all");
    }
}
