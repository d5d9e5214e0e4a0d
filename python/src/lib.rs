//! The Python package `bodyschema`: each class and function here calls the Rust library, which has the logic.

mod arrays;
mod compute;
mod creature;
mod driven;
mod errors;
mod folder;
mod options;
mod robot;
mod schema;
mod session;
mod study;

use pyo3::prelude::*;

/// The compiled part of the package.
#[pymodule]
fn _core(module: &Bound<PyModule>) -> PyResult<()> {
    let py = module.py();
    compute::remember_process();
    module.add("Error", py.get_type::<errors::Error>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<creature::Creature>()?;
    module.add_class::<driven::Crowd>()?;
    module.add_class::<session::Session>()?;
    module.add_class::<schema::Schema>()?;
    module.add_class::<robot::Robot>()?;
    module.add_class::<robot::Fitted>()?;
    module.add_function(wrap_pyfunction!(session::babble, module)?)?;
    module.add_function(wrap_pyfunction!(session::learn, module)?)?;
    module.add_function(wrap_pyfunction!(session::record, module)?)?;
    module.add_function(wrap_pyfunction!(session::open, module)?)?;
    module.add_function(wrap_pyfunction!(schema::evaluate, module)?)?;
    module.add_function(wrap_pyfunction!(robot::calibrate, module)?)?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_function(wrap_pyfunction!(rehearse, module)?)?;
    module.add_function(wrap_pyfunction!(mujoco_version, module)?)
}

/// Reads a model and computes a posture, in a process that may come to an end by it.
#[pyfunction]
fn rehearse(model: std::path::PathBuf) -> PyResult<()> {
    let read = || {
        let model = std::sync::Arc::new(bodyschema::mujoco::Model::read(&model)?.0);
        let mut data = bodyschema::mujoco::Data::new(model)?;
        data.kinematics().and_then(|()| data.collision().map(drop)).map_err(bodyschema::Error::from)
    };
    read().map_err(errors::raised)
}

/// The version of the MuJoCo that is used, such as "4.0.0".
#[pyfunction]
fn mujoco_version() -> PyResult<String> {
    bodyschema::mujoco::check()
        .map(|version| version.to_string())
        .map_err(|error| errors::raised(error.into()))
}
