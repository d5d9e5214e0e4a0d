//! How to learn, as Python's functions are asked it.

use bodyschema::Creature;
use bodyschema::deadline::Deadline;
use bodyschema::learning::learners::{LEARNERS, LearnerKind};
use bodyschema::session::LearningOptions;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{raised, wrong};

/// The options of a learner.
#[derive(Clone, Default)]
pub struct Learning {
    pub options: LearningOptions,
    /// Whether anything is asked.
    pub is_asked: bool,
}

impl Learning {
    /// Reads the keyword arguments of a function.
    pub fn read(function: &str, given: Option<&Bound<PyDict>>) -> PyResult<Learning> {
        let mut learning = Learning::default();
        learning.options.deadline = Deadline::Asked;
        for (name, value) in given.into_iter().flatten() {
            if value.is_none() {
                continue;
            }
            learning.is_asked = true;
            let name: String = name.extract()?;
            let word = || value.extract::<String>().map_err(|_| wrong(format!("{name}: give a name")));
            let options = &mut learning.options;
            match name.as_str() {
                "learner" => options.learner = Some(learner(&word()?)?),
                "input" => options.input = Some(word()?.parse().map_err(raised)?),
                "skin" => options.skin = word()?.parse().map_err(raised)?,
                "frames" => options.frames = word()?.parse().map_err(raised)?,
                "known" => {
                    options.known =
                        Some(value.extract().map_err(|_| wrong("known: give the path of a file"))?)
                }
                "joint_noise_deg" => options.disturbances.joint_noise = amount(&name, &value)?,
                "receptor_noise_mm" => options.disturbances.receptor_noise = amount(&name, &value)?,
                "point_noise_mm" => options.disturbances.point_noise = amount(&name, &value)?,
                "false_touches" => {
                    options.disturbances.false_touches = amount(&name, &value)?;
                    if options.disturbances.false_touches >= 1.0 {
                        return Err(wrong("false_touches: give a share from 0 to below 1, such as 0.05"));
                    }
                }
                _ => {
                    let sentence = format!("{function}() got an unexpected keyword argument '{name}'");
                    return Err(PyTypeError::new_err(sentence));
                }
            }
        }
        Ok(learning)
    }
}

fn learner(name: &str) -> PyResult<&'static dyn LearnerKind> {
    let found = LEARNERS.iter().copied().find(|learner| learner.name() == name);
    let names = || LEARNERS.iter().map(|learner| learner.name()).collect::<Vec<_>>().join(", ");
    found.ok_or_else(|| wrong(format!("there is no learner {name}: choose one of {}", names())))
}

/// A number from 0 on.
fn amount(name: &str, value: &Bound<PyAny>) -> PyResult<f64> {
    let number = value.extract::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| wrong(format!("{name}: give a finite number that is not negative")))
}

/// A number above 0, if one is given.
pub fn positive(name: &str, value: Option<f64>) -> PyResult<Option<f64>> {
    match value {
        Some(number) if !(number.is_finite() && number > 0.0) => {
            Err(wrong(format!("{name}: it is {number}: give a finite number above 0")))
        }
        _ => Ok(value),
    }
}

/// The limb of a name.
pub fn limb(creature: &Creature, name: &str) -> PyResult<usize> {
    creature.limb(name).ok_or_else(|| {
        let sentence =
            format!("{} has no limb {name}: choose one of {}", creature.name(), creature.limbs().join(", "));
        wrong(sentence)
    })
}
