//! A creature in its model.

use std::path::PathBuf;
use std::sync::Arc;

use bodyschema::{DofKind, Embodied, JointSelection, ModelSource, Posture};
use pyo3::exceptions::PyFileNotFoundError;
use pyo3::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::arrays::{Table, array};
use crate::compute::compute;
use crate::errors::wrong;

/// Postures that are sampled at once, at the most: numbers of them.
const MOST_NUMBERS: usize = 1 << 28;

/// A creature: the tree of its joints, its limbs and its skin. It is what an agent is given of its body; where the joints are
/// it has to learn.
///
/// Parameters
/// ----------
/// model : str or path
///     "max", the virtual human that comes with the package, or the path of an MJCF or URDF file. On limbs
///     without touch sensors a skin is grown, with a warning.
/// joints : str, optional
///     The joints that move: a set that the model names (such as "torso"), "all", or names separated by commas. By default
///     "torso" if the model names it, else all.
/// root : str, optional
///     The body at which the creature begins. By default the first of the tree with most joints.
#[pyclass(frozen, module = "bodyschema")]
pub struct Creature {
    pub embodied: Arc<Embodied>,
}

#[pymethods]
impl Creature {
    #[new]
    #[pyo3(signature = (model = PathBuf::from("max"), *, joints = None, root = None),
        text_signature = "(model='max', *, joints=None, root=None)")]
    fn new(py: Python, model: PathBuf, joints: Option<String>, root: Option<String>) -> PyResult<Creature> {
        let is_packaged = model.as_os_str() == "max";
        let model = if is_packaged { packaged(py)? } else { model };
        if model.is_dir() {
            let sentence =
                format!("{}: it is a folder: give the path of an MJCF or URDF file", model.display());
            return Err(wrong(sentence));
        }
        if !is_packaged {
            py.import("bodyschema._rehearsal")?.call_method1("rehearse", (&model,))?;
        }
        let joints = joints.map_or(JointSelection::Default, JointSelection::from);
        let source = ModelSource { joints, root, ..ModelSource::new(model) };
        let embodied = compute(py, move |watcher| Embodied::open(source, watcher))?.whole()?;
        Ok(Creature { embodied: Arc::new(embodied) })
    }

    /// Its name in the model.
    #[getter]
    fn name(&self) -> &str {
        self.embodied.creature().name()
    }

    /// The path of its model's file.
    #[getter]
    fn model(&self) -> String {
        self.embodied.model().display().to_string()
    }

    /// The names of its limbs; the first is the root.
    #[getter]
    fn limbs(&self) -> Vec<String> {
        self.embodied.creature().limbs().to_vec()
    }

    /// The names of its joints; joint i carries limb i + 1.
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.embodied.creature().joints().iter().map(|joint| joint.name.clone()).collect()
    }

    /// The names of the D coordinates of a posture; a ball joint has four, its quaternion: `NAME.w`, `NAME.x`, ….
    #[getter]
    fn coordinates(&self) -> Vec<String> {
        coordinates(self.embodied.creature())
    }

    /// The number of degrees of freedom; a ball joint counts three.
    #[getter]
    fn dof(&self) -> usize {
        self.embodied.creature().dof()
    }

    /// Least and greatest value of each coordinate: (D, 2), radians and metres.
    #[getter]
    fn ranges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ranges = self.embodied.creature().dofs().flat_map(|dof| match dof.kind {
            DofKind::Ball => [-1.0, 1.0].repeat(4),
            _ => dof.range.to_vec(),
        });
        let ranges: Vec<f64> = ranges.collect();
        array(py, &ranges, &[ranges.len() / 2, 2])
    }

    /// The posture with every angle and distance at zero: (D,).
    #[getter]
    fn reference_posture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let posture = self.embodied.creature().reference_posture();
        array(py, &posture, &[posture.len()])
    }

    /// The touch receptors as a table of columns: `id`, `limb`, `geom` (the number of the geom in the model; -1 if it is on none),
    /// centre `x`, `y`, `z` and outward normal `nx`, `ny`, `nz` in the limb's frame, metres.
    #[getter]
    fn receptors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (limbs, skin) = (self.embodied.creature().limbs(), self.embodied.agent().skin());
        let receptors = &skin.receptors;
        let geoms = receptors.iter().map(|receptor| receptor.surface.map(|k| skin.surfaces[k].geom));
        let mut table = Table::new(py)?
            .words("id", receptors.iter().map(|receptor| Some(receptor.id.clone())))?
            .words("limb", receptors.iter().map(|receptor| Some(limbs[receptor.limb].clone())))?
            .integers("geom", geoms.map(|geom| geom.map_or(-1, |geom| geom as i64)))?;
        for (k, [position, normal]) in [["x", "nx"], ["y", "ny"], ["z", "nz"]].into_iter().enumerate() {
            table = table.numbers(position, receptors.iter().map(|receptor| receptor.position[k]))?;
            table = table.numbers(normal, receptors.iter().map(|receptor| receptor.normal[k]))?;
        }
        Ok(table.done())
    }

    /// Postures drawn uniformly from the joints' ranges, always the same of one seed.
    ///
    /// Parameters
    /// ----------
    /// n : int
    ///     How many.
    /// seed : int
    ///     Seed of the random numbers.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n, D)
    ///     Radians of hinges, metres of slides, unit quaternions (w, x, y, z) of balls.
    #[pyo3(signature = (n, *, seed = 1))]
    fn sample_postures<'py>(&self, py: Python<'py>, n: usize, seed: u64) -> PyResult<Bound<'py, PyAny>> {
        let creature = self.embodied.creature();
        let width = creature.coordinates();
        if n.saturating_mul(width) > MOST_NUMBERS {
            return Err(wrong(format!("n: {n} postures are too many: sample them in parts")));
        }
        let drawn: Vec<f64> = py.detach(|| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            (0..n).flat_map(|_| Posture::random(creature, &mut rng).to_vec()).collect()
        });
        array(py, &drawn, &[n, width])
    }

    fn __repr__(&self) -> String {
        let creature = self.embodied.creature();
        format!(
            "<Creature {}: {} limbs, {} joints, {} degrees of freedom, {} receptors>",
            creature.name(),
            creature.limbs().len(),
            creature.joints().len(),
            creature.dof(),
            self.embodied.agent().skin().receptors.len()
        )
    }
}

/// The names of a posture's coordinates.
pub fn coordinates(creature: &bodyschema::Creature) -> Vec<String> {
    let names = creature.dofs().flat_map(|dof| match dof.kind {
        DofKind::Ball => ["w", "x", "y", "z"].map(|axis| format!("{}.{axis}", dof.name)).to_vec(),
        _ => vec![dof.name.clone()],
    });
    names.collect()
}

/// The model that comes with the package.
fn packaged(py: Python) -> PyResult<PathBuf> {
    let module: PathBuf = py.import("bodyschema")?.getattr("__file__")?.extract()?;
    let model = module.with_file_name("models").join("max").join("max.xml");
    if model.is_file() {
        return Ok(model);
    }
    Err(PyFileNotFoundError::new_err(format!(
        "{}: the package lacks its model: install it again",
        model.display()
    )))
}
