//! `bodyschema skin map`: which receptors are neighbours, learned from touch alone.

use std::path::PathBuf;

use serde_json::{Value, json};

use crate::cli::open::session_body;
use crate::cli::{Failure, Outcome, output, progress};
use crate::evaluation::MapAgreement;
use crate::senses::learn_map;
use crate::session::{FIRINGS_FILE, ReadLock, Session, read_firings, write_map};
use crate::skin::SomatotopicMap;

/// Learn which receptors are neighbours from nothing but when they fired.
///
/// Receptors that fire one after the other under strokes are neighbours, on one limb and across joints. The log of a
/// session that `bodyschema skin feel --strokes` wrote is read, the map is learned, and it is compared with the one that the
/// places of the receptors give: how many of its pairs were learned (recall), and how many of the learned pairs it has
/// (precision). What --out writes `bodyschema skin feel --map` gives to the touch sensor.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  bodyschema skin feel mjcf/max/max.xml --strokes 20 --out sessions/stroked     # takes minutes
  bodyschema skin map sessions/stroked
  bodyschema skin map sessions/stroked --out map.json --json
  bodyschema skin feel mjcf/max/max.xml --map map.json")]
pub struct MapArguments {
    /// The session's folder
    session: PathBuf,
    /// Where to write the learned map, as JSON
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
        return Err(Failure(format!(
            "{}: there is no such file: record one with `bodyschema skin feel MODEL --strokes MINUTES --out DIR`",
            log.display()
        )));
    }
    let firings = read_firings(&log, creature.name(), agent.skin())?;
    drop(reading);
    let limbs: Vec<usize> = agent.skin().receptors.iter().map(|receptor| receptor.limb).collect();
    let spinner = progress::spinner(&format!("learning from {} firings", firings.len()));
    let learned = learn_map(&limbs, &firings);
    let body = session_body(&session, None, false)?;
    let geometric = SomatotopicMap::at_ease(&body, agent.skin())?;
    let [within, across] = MapAgreement::within_and_across(&learned.map, &geometric, agent.skin());
    let by_limb = MapAgreement::by_limb(&learned.map, &geometric, agent.skin(), creature.limbs().len());
    let all = MapAgreement::of_all(&learned.map, &geometric);
    spinner.finish_and_clear();
    if let Some(path) = &args.out {
        write_map(path, creature.name(), agent.skin(), &learned.map)?;
    }
    let on = |limb: usize| limbs.iter().enumerate().filter(move |(_, on)| **on == limb);
    let receptors = |limb: usize| on(limb).count();
    let visited = |limb: usize| on(limb).filter(|(receptor, _)| learned.firings[*receptor] > 0).count();
    let felt: Vec<usize> = (0..creature.limbs().len()).filter(|&limb| receptors(limb) > 0).collect();
    let all_visited = learned.firings.iter().filter(|count| **count > 0).count();
    if args.json {
        let row = |limb: &usize| {
            json!({
                "limb": creature.limbs()[*limb],
                "receptors": receptors(*limb),
                "visited": visited(*limb),
                "learned": by_limb[*limb].learned,
                "geometric": by_limb[*limb].geometric,
                "shared": by_limb[*limb].shared,
            })
        };
        return output::json(&json!({
            "session": args.session,
            "creature": creature.name(),
            "strokes": learned.strokes,
            "firings": firings.len(),
            "receptors": limbs.len(),
            "visited": all_visited,
            "learned": all.learned,
            "geometric": all.geometric,
            "shared": all.shared,
            "recall": all.recall(),
            "precision": all.precision(),
            "agreement": all.agreement(),
            "within_limbs": agreement_json(&within),
            "across_joints": agreement_json(&across),
            "limbs": felt.iter().map(row).collect::<Vec<_>>(),
        }));
    }
    say!(
        "{}: {} firings of {all_visited} of {} receptors in {} strokes\n",
        creature.name(),
        firings.len(),
        limbs.len(),
        learned.strokes
    );
    let line = |name: &str, receptors: usize, visited: usize, of: &MapAgreement| {
        let [learned, geometric, shared] = [of.learned, of.geometric, of.shared];
        say!("{name:<28} {receptors:>9} {visited:>8} {learned:>8} {geometric:>9} {shared:>7}");
    };
    say!(
        "{:<28} {:>9} {:>8} {:>8} {:>9} {:>7}",
        "limb",
        "receptors",
        "visited",
        "learned",
        "geometric",
        "shared"
    );
    for &limb in &felt {
        line(&creature.limbs()[limb], receptors(limb), visited(limb), &by_limb[limb]);
    }
    line("across joints", 0, 0, &across);
    line("all", limbs.len(), all_visited, &all);
    say!(
        "\nof the pairs of the geometry {} were learned, of the learned pairs {} are the geometry's: agreement {}",
        output::number(all.recall()),
        output::number(all.precision()),
        output::number(all.agreement())
    );
    if across.geometric + across.learned > 0 {
        say!("across joints {} and {}", output::number(across.recall()), output::number(across.precision()));
    }
    Ok(())
}

/// What is counted of pairs, and the shares.
fn agreement_json(of: &MapAgreement) -> Value {
    json!({
        "learned": of.learned,
        "geometric": of.geometric,
        "shared": of.shared,
        "recall": of.recall(),
        "precision": of.precision(),
        "agreement": of.agreement(),
    })
}
