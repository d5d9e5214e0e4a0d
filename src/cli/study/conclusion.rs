//! What a study found, in its folder and for a person.

use std::path::Path;

use serde_json::{Value, json};

use super::asked::AskedStudy;
use crate::cli::{Outcome, output};
use crate::experiment::study::{FoundTables, Study, WallTime};
use crate::record::{FolderLock, STUDY_FILE};
use crate::view::study_chart;

/// All that a study leaves in its folder.
pub const FILES: [&str; 3] = [STUDY_FILE, TABLE_FILE, PLOT_FILE];
/// The measurements, in the study's folder.
const TABLE_FILE: &str = "study.csv";
/// The plot, in the study's folder.
const PLOT_FILE: &str = "study.svg";

pub fn save_and_print(
    asked: &AskedStudy,
    lock: &FolderLock,
    findings: &FoundTables,
    seconds: WallTime,
) -> Outcome {
    let (args, folder) = (asked.args, lock.place().to_path_buf());
    let study = args.name;
    let mut result = asked.about()?;
    result["seeds"] = json!(asked.seeds);
    result["seconds"] = json!(seconds);
    result["summary"] = findings.summary.to_json();
    result["notes"] = json!(findings.notes);
    result["rows"] = findings.measurements.to_json();
    result["folder"] = json!(folder);
    findings.numbers.iter().for_each(|(name, number)| result[*name] = number.clone());
    save(lock.part()?, study, &result, findings)?;
    lock.commit()?;
    if args.json {
        return output::json(&result);
    }
    say!("study {}: {}", study.name, study.about);
    asked.heading().iter().for_each(|line| say!("{line}"));
    say!("");
    findings.summary.lines().iter().for_each(|line| say!("{line}"));
    say!("");
    findings.notes.iter().for_each(|note| say!("{note}"));
    say!("\n{:.0} s; {TABLE_FILE}, {PLOT_FILE} and {STUDY_FILE} are in {}", seconds.0, folder.display());
    Ok(())
}

fn save(folder: &Path, study: &Study, result: &Value, findings: &FoundTables) -> Outcome {
    output::file(&folder.join(STUDY_FILE), format!("{}\n", serde_json::to_string_pretty(result)?))?;
    output::file(&folder.join(TABLE_FILE), findings.measurements.to_csv()?)?;
    let title = format!("{}: {}", study.name, study.about);
    output::file(&folder.join(PLOT_FILE), study_chart(&findings.plot, &title).alone())
}
