//! Errors of the library as Python's exceptions, in one place.

use pyo3::exceptions::{PyException, PyFileNotFoundError, PyValueError};
use pyo3::{PyErr, create_exception};

create_exception!(
    bodyschema,
    Error,
    PyException,
    "What could not be done, in one sentence: the file and line if it is about one, the fault, and the fix."
);

/// The exception for an error: `FileNotFoundError`, `ValueError` for wrong usage, else `bodyschema.Error`.
pub fn raised(error: bodyschema::Error) -> PyErr {
    let sentence = error.to_string();
    if error.is_missing() {
        PyFileNotFoundError::new_err(sentence)
    } else if error.is_usage() {
        PyValueError::new_err(sentence)
    } else {
        Error::new_err(sentence)
    }
}

/// The exception for a wrong argument.
pub fn wrong(sentence: impl Into<String>) -> PyErr {
    PyValueError::new_err(sentence.into())
}
