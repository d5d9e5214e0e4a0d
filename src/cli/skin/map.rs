//! `bodyschema skin map`: which receptors are neighbours, learned from touch alone.

use std::path::PathBuf;

use serde_json::{Value, json};

use crate::cli::open::session_body;
use crate::cli::{Failure, Outcome, output, progress};
use crate::evaluation::MapAgreement;
use crate::senses::learn_map;
use crate::session::{FIRINGS_FILE, ReadLock, Session, read_firings, write_map};
use crate::skin::SomatotopicMap;
use crate::view::table::Table;

/// Learn which receptors are neighbours from firing times alone.
///
/// Receptors that fire one after the other during strokes are neighbours, on one limb and across joints. The map is
/// learned from a session written by `bodyschema skin feel --strokes` and compared with the one given by the receptors'
/// positions: the share of its pairs that were learned (recall), and the share of the learned pairs that it contains
/// (precision). `bodyschema skin feel --map` uses the file written by --out.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema skin feel mjcf/max/max.xml --strokes 20 --out sessions/stroked     # takes minutes
  bodyschema skin map sessions/stroked
  bodyschema skin map sessions/stroked --out map.json --json
  bodyschema skin feel mjcf/max/max.xml --map map.json")]
pub struct MapArguments {
    /// The session's folder
    session: PathBuf,
    /// File for the learned map (JSON)
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    out: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long, help_heading = "Output")]
    json: bool,
}

pub fn run(args: &MapArguments) -> Outcome {
    let reading = ReadLock::take(&args.session)?;
    let session = Session::read(&args.session)?;
    let agent = &session.agent;
    let creature = agent.creature();
    let log = args.session.join(FIRINGS_FILE);
    if !log.exists() {
        let fix = "record one with `bodyschema skin feel MODEL --strokes MINUTES --out DIR`";
        return Err(Failure::at(&log, format_args!("no such file: {fix}")));
    }
    let firings = read_firings(&log, creature.name(), agent.skin())?;
    drop(reading);
    let limbs: Vec<usize> = agent.skin().receptors.iter().map(|receptor| receptor.limb).collect();
    let spinner = progress::spinner(&format!("learning from {} firings", firings.len()));
    let learned = learn_map(&limbs, &firings);
    let body = session_body(&session, None, false)?;
    let geometric = SomatotopicMap::at_ease(&body, agent.skin())?;
    let all = MapAgreement::of_all(&learned.map, &geometric);
    let [within, across] = [false, true].map(|apart| {
        MapAgreement::of_pairs(&learned.map, &geometric, |[a, b]| (limbs[a] != limbs[b]) == apart)
    });
    spinner.finish_and_clear();
    if let Some(path) = &args.out {
        write_map(path, creature.name(), agent.skin(), &learned.map)?;
    }
    let row = |limb: usize| {
        let on = || limbs.iter().zip(&learned.firings).filter(|(on, _)| **on == limb);
        let visited = on().filter(|(_, firings)| **firings > 0).count();
        let on = json!({ "limb": creature.limbs()[limb], "receptors": on().count(), "visited": visited });
        let is_on = |pair: [usize; 2]| pair.map(|receptor| limbs[receptor]) == [limb; 2];
        output::joined([on, json!(MapAgreement::of_pairs(&learned.map, &geometric, is_on))])
    };
    let felt = (0..creature.limbs().len()).filter(|limb| limbs.contains(limb));
    let mut found = json!({
        "session": args.session,
        "creature": creature.name(),
        "strokes": learned.strokes,
        "firings": firings.len(),
        "receptors": limbs.len(),
        "visited": learned.firings.iter().filter(|count| **count > 0).count(),
        "within_limbs": agreement_json(&within),
        "across_joints": agreement_json(&across),
        "limbs": felt.map(row).collect::<Vec<_>>(),
    });
    found = output::joined([found, agreement_json(&all)]);
    if args.json {
        return output::json(&found);
    }
    let [visited, receptors] = ["visited", "receptors"].map(|field| &found[field]);
    say!(
        "{}: {} firings of {visited} of {receptors} receptors in {} strokes\n",
        creature.name(),
        firings.len(),
        learned.strokes
    );
    let columns = ["limb", "receptors", "visited", "learned", "geometric", "shared"];
    output::table(&Table::of_json(&found["limbs"], &columns.map(|column| (column, column))));
    let shares = |of: &MapAgreement| [of.recall(), of.precision(), of.agreement()].map(output::number);
    let [recall, precision, agreement] = shares(&all);
    say!(
        "\nrecall {recall} (geometric pairs that were learned), precision {precision} (learned pairs that are \
         geometric), agreement {agreement}"
    );
    if across.geometric + across.learned > 0 {
        let [recall, precision, _] = shares(&across);
        say!("across joints {recall} and {precision}");
    }
    Ok(())
}

/// What is counted of pairs, and the shares.
fn agreement_json(of: &MapAgreement) -> Value {
    let shares = json!({ "recall": of.recall(), "precision": of.precision(), "agreement": of.agreement() });
    output::joined([json!(of), shares])
}
