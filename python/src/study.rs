//! Studies: cases measured over seeds.

use bodyschema::study::{STUDIES, Studied, Study, StudyOptions, StudyRun};
use pyo3::prelude::*;

use crate::compute::compute;
use crate::creature::Creature;
use crate::errors::wrong;
use crate::options::positive;

/// Trials of a study at most.
const MOST_TRIALS: u64 = 1_000_000;

/// Measures something over many seeds, on all cores, as `bodyschema study` does.
///
/// An interruption (Ctrl-C) ends it and keeps the trials that were finished.
///
/// Parameters
/// ----------
/// name : {"bodies", "learners", "hersch", "disturbances", "acting", "senses", "calibration"}
///     The question.
/// seeds : range
///     The seeds of the trials, one after the other.
/// cases : list of str, optional
///     Only these cases: their names, or parts of the names of several.
/// touches : int, optional
///     Touches of a trial, of studies that babble.
/// work : float, optional
///     Work that a case may take, of the study bodies: about what one core does in so many seconds.
/// creature : Creature, optional
///     The creature to study, unless the seeds generate one.
///
/// Returns
/// -------
/// Table
///     A row per measurement, as columns.
#[pyfunction]
#[pyo3(signature = (name, *, seeds, cases = None, touches = None, work = None, creature = None))]
pub fn study<'py>(
    py: Python<'py>,
    name: &str,
    seeds: &Bound<'py, PyAny>,
    cases: Option<Vec<String>>,
    touches: Option<usize>,
    work: Option<f64>,
    creature: Option<&Bound<'py, Creature>>,
) -> PyResult<Bound<'py, PyAny>> {
    let study = Study::of_name(name).ok_or_else(|| {
        let names: Vec<&str> = STUDIES.iter().map(|study| study.name).collect();
        wrong(format!("there is no study {name}: choose one of {}", names.join(", ")))
    })?;
    let (seed, trials) = consecutive(seeds)?;
    if (study.of == Studied::Generated) != creature.is_none() {
        let what = if creature.is_some() {
            "makes what it is of by its seeds: leave out"
        } else {
            "is of a creature: give"
        };
        return Err(wrong(format!("study {name} {what} creature")));
    }
    let source = creature.map(|creature| creature.get().embodied.source().clone());
    let seconds = positive("work", work)?;
    let options =
        StudyOptions { trials, seed, cases: cases.unwrap_or_default(), touches, seconds, session: None };
    let computed = compute(py, move |watcher| {
        let creature = source.map(|source| bodyschema::Embodied::open(source, &())).transpose()?;
        let run = StudyRun::new(study, options, creature)?;
        watcher.begin("trials", trials as usize, 0);
        Ok(run.findings(|_| watcher.step())?.table().to_json().to_string())
    })?;
    let rows = computed.kept(py, "the trials that were finished are kept")?;
    py.import("bodyschema._tables")?.call_method1("columns", (rows,))
}

/// The first of some seeds and how many there are, if each is the one before and one more.
fn consecutive(seeds: &Bound<PyAny>) -> PyResult<(u64, u64)> {
    let wrong_seeds = || wrong("seeds: give a range such as range(1, 11)");
    let length = seeds.len().map_err(|_| wrong_seeds())? as u64;
    if length == 0 || length > MOST_TRIALS {
        return Err(wrong(format!("seeds: there are {length}: give from 1 to {MOST_TRIALS}")));
    }
    let at = |k: u64| seeds.get_item(k).and_then(|seed| seed.extract::<u64>()).map_err(|_| wrong_seeds());
    let first = at(0)?;
    for k in 1..length {
        if at(k)? != first.saturating_add(k) {
            return Err(wrong_seeds());
        }
    }
    Ok((first, length))
}
