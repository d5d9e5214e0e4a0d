//! What a calibration found: printed, as JSON, and as files.

use std::path::Path;

use crate::calibration::Calibration;
use crate::cli::folders::{Force, new_folder};
use crate::cli::{Failure, Outcome, output};
use crate::session::{FolderLock, RobotFile};
use crate::view::report::REPORT_FILE;
use crate::view::report::calibration::{CORRELATED, REACH, as_json, html, tables};

/// The files beside the robot's and the page.
const FILES: [&str; 4] = ["calibration.json", "quantities.csv", "residuals.csv", "correlations.csv"];
/// Correlations that are named at the most.
const MOST_CORRELATIONS: usize = 5;

/// The folder for the results about a robot, whose file gets there as well.
pub fn folder(out: &Path, force: Force, robot: &Path) -> Result<FolderLock, Failure> {
    let robot = robot.file_name().unwrap_or_default().to_string_lossy();
    let files = [&FILES[..], &[REPORT_FILE, &robot]].concat();
    new_folder(out, force, "calibration", &files)
}

/// Prints what a person wants to know.
pub fn print(found: &Calibration) {
    let (touches, unknowns) = (found.touches.len(), found.estimator.unknowns.len());
    say!("{}: {touches} touches, {unknowns} parameters to estimate", found.robot.name);
    say!("{}", found.verdict());
    if found.is_calibrated() {
        say!("{REACH}");
    }
    say!("");
    output::table(&tables::misses(found));
    found.held_out().iter().for_each(|sentence| say!("  {sentence}"));
    if found.fit.noise.false_share > 0.0 {
        let share = 100.0 * found.fit.noise.false_share;
        say!("  {share:.1} % of the touches are classified as false; residuals.csv (--out) lists them");
    }
    say!("");
    output::table(&tables::quantities(found));
    found.untold().iter().for_each(|sentence| say!("  {sentence}"));
    for (a, b, correlation) in found.correlations(CORRELATED).into_iter().take(MOST_CORRELATIONS) {
        say!(
            "  {a} and {b} are strongly correlated ({correlation:.3}): their combination is known much better than either"
        );
    }
}

/// Writes the robot with its new numbers, the page and the tables into a folder.
pub fn write(found: &Calibration, lock: &FolderLock, path: &Path, file: &RobotFile) -> Outcome {
    let (name, folder) = (path.file_name().unwrap_or_default(), lock.part()?);
    let written = file.with_values(path, &found.fit.values)?;
    output::file(&folder.join(name), &written.bytes)?;
    for sentence in &written.left_out {
        tell!("{}: {sentence}", lock.place().join(name).display());
    }
    output::file(&folder.join(REPORT_FILE), html(found, file.format.name()))?;
    let tables = [tables::numbers(found), tables::residuals(found), tables::correlations(found)];
    let tables = tables.iter().map(|table| table.csv());
    let all = format!("{}\n", serde_json::to_string_pretty(&as_json(found))?);
    for (file, content) in FILES.iter().zip(std::iter::once(all).chain(tables)) {
        output::file(&folder.join(file), content)?;
    }
    Ok(lock.commit()?)
}

/// What is in the folder.
pub fn contents(lock: &FolderLock, path: &Path, file: &RobotFile) -> String {
    let [json, tables @ ..] = FILES;
    format!(
        "{}: the calibrated {}, {REPORT_FILE}, {} and {json}",
        lock.place().join(path.file_name().unwrap_or_default()).display(),
        file.format.name(),
        tables.join(", ")
    )
}
