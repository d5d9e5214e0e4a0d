//! NumPy's arrays in and out, and tables as dictionaries of columns.

use bodyschema::{Creature, DofKind, Posture};
use nalgebra::Vector3;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes, PyDict};
use serde_json::Value;

use crate::errors::wrong;

/// How far the length of a quaternion may be from 1.
const UNIT_LENGTH: f64 = 1e-6;

/// Numbers of an argument, row by row, and their shape.
///
/// # Errors
/// If it is no array of finite numbers.
pub fn numbers(given: &Bound<PyAny>, name: &str) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let py = given.py();
    let asked = PyDict::new(py);
    asked.set_item("dtype", "float64")?;
    asked.set_item("order", "C")?;
    let array = py.import("numpy")?.call_method("asarray", (given,), Some(&asked));
    let array =
        array.map_err(|error| wrong(format!("{name}: give an array of numbers ({})", error.value(py))))?;
    let shape = array.getattr("shape")?.extract()?;
    let bytes = array.call_method0("tobytes")?;
    let found: Vec<f64> =
        bytes.cast::<PyBytes>()?.as_bytes().as_chunks().0.iter().map(|b| f64::from_ne_bytes(*b)).collect();
    match found.iter().position(|x| !x.is_finite()) {
        Some(at) => Err(wrong(format!("{name}: number {at} (from 0) is {}: give finite numbers", found[at]))),
        None => Ok((found, shape)),
    }
}

/// A point of an argument, metres.
pub fn point(given: &Bound<PyAny>, name: &str) -> PyResult<Vector3<f64>> {
    let (found, shape) = numbers(given, name)?;
    match found[..] {
        [x, y, z] if shape == [3] => Ok(Vector3::new(x, y, z)),
        _ => Err(wrong(format!("{name}: its shape is {shape:?}: give three numbers, metres"))),
    }
}

/// Postures of a creature, and whether it was a single one without an axis for several.
///
/// # Errors
/// If it is no array of shape (D,) or (N, D), or has a quaternion that is not a unit one.
pub fn postures(given: &Bound<PyAny>, name: &str, creature: &Creature) -> PyResult<(Vec<Posture>, bool)> {
    let (found, shape) = numbers(given, name)?;
    let width = creature.coordinates();
    if !matches!(shape[..], [d] | [_, d] if d == width) {
        return Err(wrong(format!(
            "{name}: its shape is {shape:?}: give ({width},) or (N, {width}), for {} has {width} coordinates",
            creature.name()
        )));
    }
    let postures: Vec<Posture> = found.chunks(width).map(Posture::from).collect();
    for ball in creature.elements().filter(|element| element.kind == DofKind::Ball) {
        let length = |posture: &Posture| ball.of(posture).iter().map(|x| x * x).sum::<f64>().sqrt();
        if let Some(length) = postures.iter().map(length).find(|length| (length - 1.0).abs() > UNIT_LENGTH) {
            return Err(wrong(format!(
                "{name}: a quaternion of {} has length {length}: divide it by its length",
                ball.name
            )));
        }
    }
    Ok((postures, shape.len() == 1))
}

/// A new array of a shape.
pub fn array<'py>(py: Python<'py>, numbers: &[f64], shape: &[usize]) -> PyResult<Bound<'py, PyAny>> {
    let bytes = PyByteArray::new_with(py, 8 * numbers.len(), |bytes| {
        bytes.as_chunks_mut().0.iter_mut().zip(numbers).for_each(|(to, number)| *to = number.to_ne_bytes());
        Ok(())
    })?;
    let flat = py.import("numpy")?.call_method1("frombuffer", (bytes, "float64"))?;
    flat.call_method1("reshape", (shape.to_vec(),))
}

/// The address of the numbers of an array.
fn address(array: &Bound<PyAny>) -> PyResult<usize> {
    array.getattr("ctypes")?.getattr("data")?.extract()
}

/// A number as NumPy has it.
pub trait Number: Send {
    const DTYPE: &str;
}

impl Number for f64 {
    const DTYPE: &str = "float64";
}

impl Number for f32 {
    const DTYPE: &str = "float32";
}

/// A new array of a shape whose zeros are filled in.
pub fn filled<'py, T: Number>(
    py: Python<'py>,
    shape: &[usize],
    fill: impl FnOnce(&mut [T]) + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let array = py.import("numpy")?.call_method1("zeros", (shape.to_vec(), T::DTYPE))?;
    let (count, address) = (shape.iter().product(), address(&array)?);
    if count > 0 {
        // SAFETY: NumPy has just made so many numbers there in one piece, and nobody else has the array yet.
        let numbers =
            unsafe { std::slice::from_raw_parts_mut(std::ptr::with_exposed_provenance_mut(address), count) };
        py.detach(|| fill(numbers));
    }
    Ok(array)
}

/// The same of whole numbers.
pub fn integers<'py, T: IntoPyObject<'py>>(
    py: Python<'py>,
    numbers: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let flat = py.import("numpy")?.call_method1("array", (numbers, "int64"))?;
    flat.call_method1("reshape", (shape.to_vec(),))
}

/// A table being made: a dictionary of columns that pandas and polars take.
pub struct Table<'py>(Bound<'py, PyAny>);

impl<'py> Table<'py> {
    pub fn new(py: Python<'py>) -> PyResult<Table<'py>> {
        Ok(Table(py.import("bodyschema._tables")?.getattr("Table")?.call0()?))
    }

    /// Adds a column of numbers.
    pub fn numbers(self, name: &str, column: impl IntoIterator<Item = f64>) -> PyResult<Table<'py>> {
        let column: Vec<f64> = column.into_iter().collect();
        self.0.set_item(name, array(self.0.py(), &column, &[column.len()])?)?;
        Ok(self)
    }

    /// Adds a column of whole numbers.
    pub fn integers<T: IntoPyObject<'py>>(
        self,
        name: &str,
        column: impl IntoIterator<Item = T>,
    ) -> PyResult<Table<'py>> {
        let column: Vec<T> = column.into_iter().collect();
        let shape = [column.len()];
        self.0.set_item(name, integers(self.0.py(), column, &shape)?)?;
        Ok(self)
    }

    /// Adds a column of words, or of `None`.
    pub fn words(self, name: &str, column: impl IntoIterator<Item = Option<String>>) -> PyResult<Table<'py>> {
        let column: Vec<Option<String>> = column.into_iter().collect();
        self.0.set_item(name, self.0.py().import("numpy")?.call_method1("array", (column, "object"))?)?;
        Ok(self)
    }

    pub fn done(self) -> Bound<'py, PyAny> {
        self.0
    }
}

/// JSON as Python has it: dictionaries whose fields are attributes, too.
pub fn record<'py>(py: Python<'py>, json: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("bodyschema._tables")?.call_method1("record", (json.to_string(),))
}
