//! Calibrating a robot by a log of its self-contacts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bodyschema::calibration::{Calibration, folds, judge, objections, put_on_places, split};
use bodyschema::session::{RobotFile, add_fixed_places};
use bodyschema::view::report::calibration::{as_json, html};
use bodyschema::{
    Error as Fault, Estimator, EstimatorOptions, Judgement, Knowledge, RobotTouch, Value,
    read_calibration_log, read_robot,
};
use pyo3::prelude::*;

use crate::compute::{compute, warn};
use crate::errors::{raised, wrong};

/// A robot at its maker's numbers: joint poses, encoder offsets and gains, skin mounts, each a quantity with a name.
///
/// Parameters
/// ----------
/// path : path
///     URDF, MJCF, a table of Denavit-Hartenberg numbers (CSV), or a description in JSON.
#[pyclass(frozen, module = "bodyschema")]
pub struct Robot {
    file: Arc<RobotFile>,
    path: PathBuf,
}

#[pymethods]
impl Robot {
    #[new]
    fn new(py: Python, path: PathBuf) -> PyResult<Robot> {
        let place = path.clone();
        let file = compute(py, move |_| read_robot(&place))?.whole()?;
        file.notes.iter().try_for_each(|note| warn(py, &format!("{}: {note}", path.display())))?;
        Ok(Robot { file: Arc::new(file), path })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.file.robot.name
    }

    /// The names of all quantities that may be unknown, such as `elbow.offset`.
    #[getter]
    fn quantities(&self) -> Vec<String> {
        self.file.robot.quantities.iter().map(|quantity| quantity.name.clone()).collect()
    }

    /// The names of its joints' degrees of freedom.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.file.robot.dofs.iter().map(|dof| dof.name.clone()).collect()
    }

    fn __repr__(&self) -> String {
        let robot = &self.file.robot;
        format!(
            "<Robot {}: {} degrees of freedom, {} links>",
            robot.name,
            robot.dofs.len(),
            robot.links.len()
        )
    }
}

/// What a calibration found, to be written.
#[pyclass(frozen, module = "bodyschema")]
pub struct Fitted {
    file: Arc<RobotFile>,
    path: PathBuf,
    values: Vec<Value>,
    page: String,
}

#[pymethods]
impl Fitted {
    /// Writes the robot's file with the calibrated numbers and nothing else changed.
    fn save(&self, py: Python, path: PathBuf) -> PyResult<()> {
        let written = self.file.with_values(&self.path, &self.values).map_err(raised)?;
        std::fs::write(&path, written.bytes)?;
        written.left_out.iter().try_for_each(|sentence| warn(py, sentence))
    }

    /// The report as one page of HTML.
    fn html(&self) -> &str {
        &self.page
    }
}

/// Touches that are held out.
enum HeldOut {
    Nothing,
    Share(f64),
    Folds(usize),
    Log(PathBuf),
}

/// What a calibration comes to that outlives the numbers that it refers to.
struct Found {
    file: RobotFile,
    values: Vec<Value>,
    json: serde_json::Value,
    page: String,
    notes: Vec<String>,
}

/// Calibrates a robot: estimates its unknown quantities from a log of its self-contacts, and judges them by held-out touches.
///
/// Parameters
/// ----------
/// robot : Robot
/// log : path
///     The log of touches: comma-separated values with a column per joint, or JSON.
/// free : str or list of str, optional
///     Quantities of which nothing is known, by name; * stands for any part of one, as in "*.offset". By default all encoder
///     offsets, if there is no `prior`.
/// prior : dict of str to float, optional
///     Quantities that are nearly as they are given, with their standard deviation (metres or radians).
/// fix : str or list of str, optional
///     Quantities that are as they are given.
/// held_out : float or path, optional
///     The share of touches to hold out, such as 0.3, or another log.
/// folds : int, optional
///     Divide the log into so many parts and hold out each in turn, in place of `held_out`.
/// joint_noise : float or None
///     Standard deviation of encoders (radians, metres of slides); None estimates it.
/// false_touches : bool
///     Whether some touches may be false.
/// seed : int
///     Seed by which touches are held out.
///
/// Returns
/// -------
/// Fit
#[pyfunction]
#[pyo3(signature = (robot, log, *, free = None, prior = None, fix = None, held_out = None, folds = None, joint_noise = Some(0.0), false_touches = true, seed = 1),
    text_signature = "(robot, log, *, free=None, prior=None, fix=None, held_out=None, folds=None, joint_noise=0.0, false_touches=True, seed=1)")]
#[allow(clippy::too_many_arguments)]
pub fn calibrate<'py>(
    py: Python<'py>,
    robot: &Bound<Robot>,
    log: PathBuf,
    free: Option<&Bound<PyAny>>,
    prior: Option<BTreeMap<String, f64>>,
    fix: Option<&Bound<PyAny>>,
    held_out: Option<&Bound<PyAny>>,
    folds: Option<usize>,
    joint_noise: Option<f64>,
    false_touches: bool,
    seed: u64,
) -> PyResult<Bound<'py, PyAny>> {
    if joint_noise.is_some_and(|noise| !(noise.is_finite() && noise >= 0.0)) {
        return Err(wrong("joint_noise: give a finite number that is not negative, or None"));
    }
    let held_out = held(held_out, folds)?;
    let Robot { file, path } = robot.get();
    let mut file = RobotFile::clone(file);
    if let Some(name) = file.unplaced.first() {
        return Err(wrong(format!(
            "{}: nothing is said of where joint {name} is: give its position and axes",
            path.display()
        )));
    }
    add_fixed_places(&log, &mut file.robot).map_err(raised)?;
    if !file.says_what_is_open && free.is_none() && prior.is_none() {
        let offsets: Vec<usize> = file.robot.encoders().map(|(_, quantities)| quantities.offset).collect();
        offsets.into_iter().for_each(|offset| file.robot.quantities[offset].knowledge[0] = Knowledge::Free);
        warn(py, "neither free nor prior is given: estimating all encoder offsets")?;
    }
    let known = |fault: String, option: &str| wrong(format!("{option}: {fault}"));
    for pattern in names(free, "free")? {
        file.robot.set_knowledge(&pattern, Knowledge::Free).map_err(|fault| known(fault, "free"))?;
    }
    for (pattern, deviation) in prior.into_iter().flatten() {
        if !(deviation.is_finite() && deviation > 0.0) {
            return Err(wrong(format!(
                "prior: the deviation of {pattern} is {deviation}: give a number above 0"
            )));
        }
        file.robot
            .set_knowledge(&pattern, Knowledge::Near(deviation))
            .map_err(|fault| known(fault, "prior"))?;
    }
    for pattern in names(fix, "fix")? {
        file.robot.set_knowledge(&pattern, Knowledge::Known).map_err(|fault| known(fault, "fix"))?;
    }
    if !file.robot.quantities.iter().any(|quantity| quantity.is_open()) {
        return Err(wrong("no quantity is unknown: name some by free or prior"));
    }
    let options = EstimatorOptions { joint_noise, false_touches };
    let computed = compute(py, move |watcher| {
        watcher.begin("calibrating", 0, 0);
        calibrated(file, &log, options, &held_out, seed)
    })?;
    let Found { file, values, json, page, notes } = computed.whole()?;
    notes.iter().try_for_each(|note| warn(py, note))?;
    let fitted = Fitted { file: Arc::new(file), path: path.clone(), values, page };
    py.import("bodyschema._fit")?.getattr("Fit")?.call1((fitted, json.to_string()))
}

fn calibrated(
    file: RobotFile,
    log: &Path,
    options: EstimatorOptions,
    held_out: &HeldOut,
    seed: u64,
) -> Result<Found, Fault> {
    let robot = &file.robot;
    let read = read_calibration_log(log, robot)?;
    let (notes, touches) =
        (read.notes.iter().map(|note| format!("{}: {note}", log.display())).collect(), read.touches);
    let estimator = Estimator::new(robot, &touches, options);
    let fit = estimator.fit();
    let one = |[fitted, fresh]: [Vec<RobotTouch>; 2]| {
        let estimator = Estimator::new(robot, &fitted, options);
        judge(&estimator, &estimator.fit(), &fresh)
    };
    let judged: Vec<Judgement> = match held_out {
        HeldOut::Nothing => Vec::new(),
        HeldOut::Share(share) => vec![one(split(&touches, *share, seed))],
        HeldOut::Folds(count) => {
            folds(&touches, *count.min(&touches.len()), seed).into_iter().map(one).collect()
        }
        HeldOut::Log(path) => {
            let mut fresh = read_calibration_log(path, robot)?.touches;
            put_on_places(robot, &mut fresh);
            vec![judge(&estimator, &fit, &fresh)]
        }
    };
    let objections = objections(&estimator, &fit, &judged);
    let found = Calibration {
        robot,
        touches: &touches,
        estimator: &estimator,
        fit: &fit,
        judged: &judged,
        objections: &objections,
    };
    let mut json = as_json(&found);
    let after = bodyschema::calibration::Misses::mean(judged.iter().map(|judged| judged.after));
    json["held_out_after"] = serde_json::json!(after);
    let page = html(&found, file.format.name());
    let values = fit.values.clone();
    drop((objections, judged, fit));
    Ok(Found { values, json, page, notes, file: file.clone() })
}

/// What to hold out.
fn held(given: Option<&Bound<PyAny>>, folds: Option<usize>) -> PyResult<HeldOut> {
    match (given, folds) {
        (Some(_), Some(_)) => Err(wrong("held_out and folds exclude each other: give one of them")),
        (None, None) => Ok(HeldOut::Nothing),
        (None, Some(count)) if count >= 2 => Ok(HeldOut::Folds(count)),
        (None, Some(count)) => Err(wrong(format!("folds: it is {count}: give a number from 2 on"))),
        (Some(given), None) => match given.extract::<f64>() {
            Ok(share) if share > 0.0 && share < 1.0 => Ok(HeldOut::Share(share)),
            Ok(share) => Err(wrong(format!(
                "held_out: it is {share}: give a share between 0 and 1, such as 0.3, or a log"
            ))),
            Err(_) => given
                .extract()
                .map(HeldOut::Log)
                .map_err(|_| wrong("held_out: give a share such as 0.3, or the path of a log")),
        },
    }
}

/// A name or several.
fn names(given: Option<&Bound<PyAny>>, option: &str) -> PyResult<Vec<String>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    let several = given.extract::<String>().map(|one| vec![one]).or_else(|_| given.extract());
    several.map_err(|_| wrong(format!("{option}: give a name, or a list of names")))
}
