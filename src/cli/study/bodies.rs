//! `bodyschema study bodies`: the study that makes its creatures itself.

use std::path::Path;
use std::time::Instant;

use serde_json::json;

use super::{STUDY_FILE, StudyArguments, save, told};
use crate::cli::folders::free_folder;
use crate::cli::progress::Bars;
use crate::cli::{Failure, Outcome, output};
use crate::experiment::study::FoundTables;
use crate::experiment::study::bodies::{BodiesOptions, BodyTrial, STUDY, findings, trial};
use crate::experiment::{Observer, Phase};
use crate::record::{Generation, PROGRAM};

pub fn run(args: &StudyArguments, seeds: &[u64]) -> Outcome {
    let given = [
        (args.model != [Path::new(super::DEFAULT_MODEL)], "the model"),
        (args.joints.is_some(), "--joints"),
        (args.open.root.is_some(), "--root"),
        (args.session.is_some(), "--session"),
        (args.jobs.is_some(), "--jobs"),
    ];
    if let Some((_, what)) = given.into_iter().find(|(given, _)| *given) {
        return Err(Failure(format!(
            "study {} makes its creatures by its seeds: leave out {what}",
            STUDY.name
        )));
    }
    let standard = BodiesOptions::default();
    let options = BodiesOptions {
        touches: args.touches.unwrap_or(standard.touches),
        seconds: args.seconds.unwrap_or(standard.seconds),
        ways: if args.ways.is_empty() { standard.ways } else { args.ways.clone() },
    };
    let touches = options.touches;
    let numbered = |k: u32| match k {
        1 => Path::new("studies").join(STUDY.name),
        _ => Path::new("studies").join(format!("{}-{k}", STUDY.name)),
    };
    let lock = free_folder(args.out.as_deref(), "study", &[STUDY_FILE], numbered)?;
    let folder = lock.folder();
    let (bars, began) = (Bars::default(), Instant::now());
    let trials = seeds.iter().enumerate().map(|(k, &seed)| {
        bars.phase(Phase::Trial { trial: k + 1, trials: seeds.len(), doing: "babbling and learning" });
        trial(seed, &options)
    });
    let trials: Vec<BodyTrial> = trials.collect();
    let seconds = began.elapsed().as_secs_f64();
    bars.phase(Phase::Done);
    let findings: FoundTables = findings(&trials).into();
    let mut result = json!({
        "study": STUDY.name,
        "about": STUDY.about,
        "program": PROGRAM,
        "options": { "touches": touches, "seconds": options.seconds, "ways": options.ways, "trials": args.trials, "seed": args.seed },
        "seeds": seeds,
        "seconds": seconds,
        "summary": findings.summary.to_json(),
        "notes": findings.notes,
        "rows": findings.measurements.to_json(),
        "folder": folder,
    });
    findings.numbers.iter().for_each(|(name, number)| result[*name] = number.clone());
    let generation = Generation::begin(&lock)?;
    save(generation.folder(), &STUDY, &result, &findings)?;
    generation.commit()?;
    if args.json {
        return output::json(&result);
    }
    say!("study {}: {}", STUDY.name, STUDY.about);
    say!(
        "{} generated bodies, {touches} touches at random, seeds {} to {}\n",
        seeds.len(),
        args.seed,
        seeds[seeds.len() - 1]
    );
    told(&findings, folder, seconds);
    Ok(())
}
