//! A learned body schema: its account, kinematics, and reaching.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use bodyschema::evaluation::evaluate_claims;
use bodyschema::export::ExportFormat;
use bodyschema::geometry::Frame;
use bodyschema::kinematics::{PosedLimbs, RelativePoses};
use bodyschema::session::{BabbledSession, LearningRecord, SCHEMA_FILE};
use bodyschema::view::report::{REPORT_FILE, write_report};
use bodyschema::{Level, OwnBody, Posture, ReachableMap};
use nalgebra::Vector3;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{Table, array, filled, point, postures, record};
use crate::compute::{compute, on_threads};
use crate::creature::Creature;
use crate::errors::{Error, wrong};
use crate::folder::Folder;
use crate::options::{limb, positive};

/// Postures that one thread computes at once.
const BATCH: usize = 64;

/// A learned body schema: where a body's joints are and how they turn, and how well that is known.
///
/// Frames: a limb's origin is the joint that carries it; in the reference posture it is parallel to its parent. Poses are in
/// the frame of the root limb, the creature's first one, unless `wrt` names another. Metres and radians.
#[pyclass(frozen, module = "bodyschema")]
pub struct Schema {
    own: Arc<OwnBody>,
    record: LearningRecord,
    babbled: Arc<BabbledSession>,
    folder: Arc<Folder>,
    /// Maps that help to reach, per limb.
    maps: Mutex<HashMap<usize, Arc<ReachableMap>>>,
}

impl Schema {
    pub fn new(
        own: OwnBody,
        record: LearningRecord,
        babbled: Arc<BabbledSession>,
        folder: Arc<Folder>,
    ) -> Schema {
        Schema { own: Arc::new(own), record, babbled, folder, maps: Mutex::default() }
    }

    fn limbs(&self, of: &str, wrt: Option<&str>) -> PyResult<[usize; 2]> {
        let creature = self.own.creature();
        Ok([limb(creature, of)?, wrt.map_or(Ok(0), |wrt| limb(creature, wrt))?])
    }

    /// A result of a shape per posture, with an axis for the postures unless there is but one. What `begin` makes is used for
    /// many postures.
    fn each<'py, B>(
        &self,
        q: &Bound<'py, PyAny>,
        shape: &[usize],
        begin: impl Fn() -> B + Sync,
        fill: impl Fn(&Posture, &mut B, &mut [f64]) + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (postures, single) = postures(q, "q", self.own.creature())?;
        let size = shape.iter().product::<usize>();
        let several = if single { Vec::new() } else { vec![postures.len()] };
        filled(q.py(), &[&several, shape].concat(), |all| {
            let one = |(numbers, postures): (&mut [f64], &[Posture])| {
                let mut room = begin();
                let each = numbers.chunks_mut(size).zip(postures);
                each.for_each(|(numbers, posture)| fill(posture, &mut room, numbers));
            };
            if size == 0 {
                // There is no limb.
            } else if postures.len() <= BATCH {
                one((all, &postures));
            } else {
                let batches = all.par_chunks_mut(size * BATCH).zip(postures.par_chunks(BATCH));
                on_threads(|| batches.for_each(one));
            }
        })
    }

    /// The same of one limb or several, with an axis for these.
    fn each_limb<'py>(
        &self,
        limbs: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        wrt: Option<&str>,
        shape: [usize; 2],
        fill: impl Fn(&RelativePoses, usize, &PosedLimbs, &mut [f64]) + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (creature, schema) = (self.own.creature(), &self.own.schema);
        let one = limbs.extract::<String>();
        let names = one.as_ref().map_or_else(|_| limbs.extract(), |one| Ok(vec![one.clone()]))?;
        let found = names.iter().map(|name| limb(creature, name)).collect::<PyResult<Vec<usize>>>()?;
        let wrt = wrt.map_or(Ok(0), |wrt| limb(creature, wrt))?;
        let relative = RelativePoses::new(creature, schema, &found, wrt);
        let several = if one.is_ok() { Vec::new() } else { vec![names.len()] };
        let all = [several, shape.to_vec()].concat();
        self.each(
            q,
            &all,
            || relative.room(),
            |posture, posed, numbers| {
                relative.put(posture, posed);
                let each = numbers.chunks_mut(shape[0] * shape[1]).enumerate();
                each.for_each(|(k, numbers)| fill(&relative, k, posed, numbers));
            },
        )
    }

    fn map(&self, py: Python, hand: usize) -> PyResult<Arc<ReachableMap>> {
        let kept = || self.maps.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(map) = kept().get(&hand) {
            return Ok(map.clone());
        }
        let own = self.own.clone();
        let map = Arc::new(compute(py, move |_| ReachableMap::coarse(&own, hand))?.whole()?);
        Ok(kept().entry(hand).or_insert(map).clone())
    }
}

#[pymethods]
impl Schema {
    /// The verdict in a sentence: how much of the body is located.
    #[getter]
    fn verdict(&self) -> &str {
        &self.record.verdict
    }

    /// Whether the schema predicts held-out touches.
    #[getter]
    fn converged(&self) -> bool {
        self.record.converged
    }

    /// The limbs that are located: how far off their skin may be in one another's frames is bounded.
    #[getter]
    fn located(&self) -> Vec<String> {
        let located = self.own.account().map_or(&[][..], |account| account.located());
        located.iter().map(|&limb| self.own.creature().limbs()[limb].clone()).collect()
    }

    /// The limbs with skin that are not located, each with the reason.
    #[getter]
    fn unlocated(&self) -> HashMap<String, String> {
        let reason =
            |limb: usize| Some((self.own.creature().limbs()[limb].clone(), self.own.unplaced(limb)?));
        self.own.agent().limbs_with_skin().into_iter().filter_map(reason).collect()
    }

    /// How well each limb with skin is located, the worst first, as a table of columns: `limb`, its `touches`, those that
    /// support the schema (`supporting`), how far off its skin may be at 95 % in the frame of another located limb, where it is
    /// known best (`best`) and worst (`worst`, metres, infinite without a bound), and `why` it is not located, or None.
    #[getter]
    fn account<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let creature = self.own.creature();
        let lines = self.own.account().map_or(Vec::new(), |account| account.limb_lines(creature));
        let table = Table::new(py)?
            .words("limb", lines.iter().map(|line| Some(creature.limbs()[line.limb].clone())))?
            .integers("touches", lines.iter().map(|line| line.touches))?
            .integers("supporting", lines.iter().map(|line| line.supporting))?
            .numbers("best", lines.iter().map(|line| line.bounds[0]))?
            .numbers("worst", lines.iter().map(|line| line.bounds[1]))?
            .words("why", lines.iter().map(|line| line.why.clone()))?;
        Ok(table.done())
    }

    /// The joints' positions in the frames of their parent limbs: (J, 3), metres, in the order of `Creature.joints`.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vectors(py, &self.own.schema.positions)
    }

    /// The unit axes of all hinges and slides in the frames of their parent limbs, one per degree of freedom in the order of
    /// the coordinates; zero for a ball: (K, 3).
    #[getter]
    fn axes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vectors(py, &self.own.schema.axes)
    }

    /// The pose of a limb, or of several at once.
    ///
    /// Parameters
    /// ----------
    /// limb : str or list of str
    /// q : array_like, shape (D,) or (N, D)
    ///     Postures: radians, metres.
    /// wrt : str, optional
    ///     The limb in whose frame it is. By default the root.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (4, 4) or (N, 4, 4); of L limbs (L, 4, 4) or (N, L, 4, 4)
    ///     Homogeneous transforms X with p_wrt = X p_limb, metres.
    #[pyo3(signature = (limb, q, *, wrt = None))]
    fn pose<'py>(
        &self,
        limb: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        wrt: Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.each_limb(limb, q, wrt, [4, 4], |relative, k, posed, pose| {
            let Frame { rotation, origin } = relative.pose(k, posed);
            for row in 0..3 {
                (0..3).for_each(|column| pose[4 * row + column] = rotation[(row, column)]);
                pose[4 * row + 3] = origin[row];
            }
            pose[15] = 1.0;
        })
    }

    /// The Jacobian of a limb's pose, or of several at once.
    ///
    /// Parameters
    /// ----------
    /// limb, q, wrt
    ///     As of `pose`.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (6, F) or (N, 6, F); of L limbs (L, 6, F) or (N, L, 6, F)
    ///     The velocity of the limb's origin (m) and the limb's angular velocity (rad), both in the frame of `wrt`, per change of
    ///     each of the F degrees of freedom. A hinge or a slide has one column; a ball has three, for turns about the axes of the
    ///     frame before it. Without balls F is D.
    #[pyo3(signature = (limb, q, *, wrt = None))]
    fn jacobian<'py>(
        &self,
        limb: &Bound<'py, PyAny>,
        q: &Bound<'py, PyAny>,
        wrt: Option<&str>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let shape = [6, self.own.creature().dof()];
        self.each_limb(limb, q, wrt, shape, |relative, k, posed, out| relative.jacobian(k, posed, out))
    }

    /// How well the position of a point of a limb is known, by the touches.
    ///
    /// Parameters
    /// ----------
    /// limb, q, wrt
    ///     As of `pose`.
    /// point : array_like, shape (3,), optional
    ///     The point in the limb's frame, metres. By default the skin that is farthest from the joint that carries the limb.
    ///
    /// Returns
    /// -------
    /// float ndarray, shape () or (N,)
    ///     One standard deviation, metres; infinite where the touches do not bound it.
    #[pyo3(signature = (limb, q, *, wrt = None, point = None))]
    fn position_std<'py>(
        &self,
        limb: &str,
        q: &Bound<'py, PyAny>,
        wrt: Option<&str>,
        point: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let limbs = self.limbs(limb, wrt)?;
        let tip = || self.own.tip_of(limbs[0]).map_or(Vector3::zeros(), |tip| tip.point);
        let at = point.map_or_else(|| Ok(tip()), |point| self::point(point, "point"))?;
        self.each(
            q,
            &[],
            || (),
            |posture, (), std| {
                let covariance = self.own.covariance(posture, limbs, &at);
                std[0] = covariance.map_or(f64::INFINITY, |covariance| covariance.trace().max(0.0).sqrt());
            },
        )
    }

    /// Seeks a posture that brings a limb to a point. Only the joints' ranges count: whether limbs are in each other's way is
    /// not regarded.
    ///
    /// Parameters
    /// ----------
    /// limb : str
    ///     A limb with skin; its skin farthest from the joint that carries it is what reaches.
    /// point : array_like, shape (3,)
    ///     The point in the root's frame, metres.
    ///
    /// Returns
    /// -------
    /// Reach
    ///     Its `posture`, or None with the `reason`.
    fn reach<'py>(
        &self,
        py: Python<'py>,
        limb: &str,
        point: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let [hand, _] = self.limbs(limb, None)?;
        let at = self::point(point, "point")?;
        let made = py.import("bodyschema._reach")?.getattr("Reach")?;
        if let Some(why) = self.own.unplaced(hand) {
            let reason = format!("{limb} is not located: {why}");
            return made.call1((py.None(), reason, f64::INFINITY, Level::OutOfReach.name()));
        }
        let map = self.map(py, hand)?;
        let mut reach = py.detach(|| map.reach(&map.frame.inverse_point(&at)));
        self.own.creature().couple(&mut reach.posture);
        let reached = reach.level != Level::OutOfReach;
        let posture = reached.then(|| array(py, &reach.posture, &[reach.posture.len()])).transpose()?;
        let reason = (!reached).then(|| format!("out of reach by {:.1} mm", 1e3 * reach.miss));
        made.call1((posture, reason, reach.miss, reach.level.name()))
    }

    /// Where a limb gets to: a map of voxels.
    ///
    /// Parameters
    /// ----------
    /// limb : str
    ///     A limb with skin.
    /// voxel : float
    ///     The side of a voxel, metres.
    #[pyo3(signature = (limb, voxel = 0.02))]
    fn reachable<'py>(&self, py: Python<'py>, limb: &str, voxel: f64) -> PyResult<Bound<'py, PyAny>> {
        let [hand, _] = self.limbs(limb, None)?;
        positive("voxel", Some(voxel))?;
        let own = self.own.clone();
        let map =
            compute(py, move |_| ReachableMap::new(&own, hand, own.carrier_of(&[hand]), voxel))?.whole()?;
        let middle = |cell| map.frame.point(&map.lattice().middle(cell));
        let points: Vec<Vector3<f64>> = map.voxels().map(|(cell, _)| middle(cell)).collect();
        let near: Vec<bool> = map.voxels().map(|(_, level)| level == Level::Near).collect();
        let near = py.import("numpy")?.call_method1("array", (near, "bool"))?;
        let volume: f64 = map.volumes().iter().sum();
        let made = py.import("bodyschema._reach")?.getattr("Reachable")?;
        made.call1((limb, voxel, volume, vectors(py, &points)?, near))
    }

    /// Writes the learned body into a file. The ending chooses the format: .xml for MJCF, .urdf for URDF, .csv for a table of
    /// the joints, .vtk for the skin in the reference posture, .json for the program's own.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        if path.extension().is_some_and(|ending| ending == "json") {
            std::fs::copy(self.folder.path().join(SCHEMA_FILE), path)?;
            return Ok(());
        }
        let format = ExportFormat::of(&path).map_err(wrong)?;
        for (path, bytes) in (format.files)(self.own.agent(), &self.own.schema, &path) {
            std::fs::write(&path, bytes)?;
        }
        Ok(())
    }

    /// The report of what was learned as one page of HTML, which stands alone.
    fn html(&self, py: Python) -> PyResult<String> {
        let (folder, babbled) = (self.folder.clone(), self.babbled.clone());
        let page = compute(py, move |_| {
            write_report(folder.path(), &babbled.session, &babbled.touches, None)?;
            Ok(folder.path().join(REPORT_FILE))
        })?;
        Ok(std::fs::read_to_string(page.whole()?)?)
    }

    /// Draws the limbs' joints and the skin in a posture, by default the reference; needs matplotlib. Returns the axes.
    #[pyo3(signature = (q = None, ax = None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        q: Option<Bound<'py, PyAny>>,
        ax: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("bodyschema._plot")?.call_method1("body", (slf, q, ax))
    }

    /// The limbs' names, and the limb that carries each; -1 for the root.
    #[getter]
    fn tree(&self) -> Vec<(String, isize)> {
        let creature = self.own.creature();
        let parent = |limb: usize| creature.parent_of(limb).map_or(-1, |parent| parent as isize);
        creature.limbs().iter().enumerate().map(|(limb, name)| (name.clone(), parent(limb))).collect()
    }

    /// The posture with every angle and distance at zero: (D,).
    #[getter]
    fn reference_posture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let posture = self.own.creature().reference_posture();
        array(py, &posture, &[posture.len()])
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("bodyschema._html")?.call_method1("page", (slf,))
    }

    fn __repr__(&self) -> String {
        format!("<Schema of {}: {}>", self.own.creature().name(), self.record.verdict)
    }
}

fn vectors<'py>(py: Python<'py>, vectors: &[Vector3<f64>]) -> PyResult<Bound<'py, PyAny>> {
    let all: Vec<f64> = vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    array(py, &all, &[vectors.len(), 3])
}

/// Measures a schema against the truth, which enters here and nowhere else.
///
/// Parameters
/// ----------
/// schema : Schema
/// creature : Creature
///     The creature whose body was learned.
///
/// Returns
/// -------
/// Evaluation
///     `heldout_mm`, `determined_mm`, `hand_mm`, `axis_deg` and `axis_line_mm`, each with `mean`, `median`, `p95` and `max`: where a
///     random skin point of a limb lands in another limb's frame (over all limbs, and over the located ones), and how far axes
///     are off.
#[pyfunction]
pub fn evaluate<'py>(
    py: Python<'py>,
    schema: &Bound<'py, Schema>,
    creature: &Bound<'py, Creature>,
) -> PyResult<Bound<'py, PyAny>> {
    let (own, embodied) = (schema.get().own.clone(), creature.get().embodied.clone());
    if own.creature().limbs() != embodied.creature().limbs()
        || own.creature().dof() != embodied.creature().dof()
    {
        let (learned, other) = (own.creature().name(), embodied.creature().name());
        return Err(wrong(format!(
            "the schema is of {learned}, and the creature {other} has other limbs or joints: give the same"
        )));
    }
    let computed =
        compute(py, move |_| Ok(evaluate_claims(own.agent(), embodied.truth(), &own.schema, own.account())))?;
    let json = serde_json::to_value(computed.whole()?).map_err(|error| Error::new_err(error.to_string()))?;
    record(py, &json)
}
