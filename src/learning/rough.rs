//! A rough schema from few touches, good enough to aim by.
//!
//! An agent that chooses its motions needs a schema long before its touches prove one. This learner takes
//! the best explanation it finds, right or not: relaxed axes by the receptors' centres, then unit axes by
//! the surfaces, from what it believed before, from the same with suspect joints drawn anew, and from
//! random onsets. What the touches leave open a weak belief closes: a joint is near the skin of the limb
//! that it is mounted on.

use nalgebra::{DVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::creature::Creature;
use crate::learning::least_squares::{LeastSquares, Linearization, Stopping, levenberg_marquardt};
use crate::learning::observation::{Observation, ObservationModel, PointsMeet};
use crate::learning::onset::{random_onset, randomize_joint};
use crate::learning::split::SplitCreature;
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{LimbTouch, TouchProblem, TouchSet};
use crate::learning::{AxisModel, Learned, Learner, Parameters, Verdict};
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::skin::Skin;

/// How far a curved limb is taken to bulge out of a flat patch, metres.
const NORMAL_DEVIATION: f64 = 6e-3;
/// How far a joint may be from the skin of its parent limb, beyond that skin's own extent, metres.
const BEYOND_SKIN: f64 = 0.1;
/// Standard deviation of a relaxed axis's components: weak, or it makes the minima that relaxing removes.
const AXIS_DEVIATION: f64 = 3.0;
/// Deviations of the gap that a fit passes through, metres.
const DEVIATIONS: [f64; 6] = [0.02, 0.01, 4e-3, 1.5e-3, 5e-4, 1e-4];
/// The deviation of the gap at which explanations are compared, metres.
const COMPARED: f64 = 5e-3;
/// New starts at each learning while the answer is not found.
const STARTS: usize = 4;
/// Touches that must be foretold before the answer counts as found …
const FORETOLD: usize = 8;
/// … and the gap that eight tenths of them stay below, metres.
const FORETOLD_GAP: f64 = 2e-3;

/// The learner of rough schemas: receptor input and known surfaces.
pub struct RoughFit<'a> {
    creature: &'a Creature,
    skin: &'a Skin,
    split: SplitCreature,
    belief: Belief,
    rng: ChaCha8Rng,
    touches: Vec<Touch>,
    /// The last schema and the number of touches it is fitted to.
    last: Option<(BodySchema, usize)>,
}

/// Where the agent believes its joints to be before any touch: mean and weight per position, 1/m².
struct Belief {
    positions: Vec<(Vector3<f64>, f64)>,
}

impl Belief {
    fn new(creature: &Creature, skin: &Skin) -> Belief {
        let near_parent = |parent: usize| {
            let skin: Vec<_> = skin.receptors.iter().filter(|r| r.limb == parent).collect();
            let count = skin.len().max(1) as f64;
            let mean: Vector3<f64> = skin.iter().map(|r| r.position).sum::<Vector3<f64>>() / count;
            let scatter = skin.iter().map(|r| (r.position - mean).norm_squared()).sum::<f64>() / count;
            let deviation = BEYOND_SKIN + (scatter / 3.0).sqrt();
            (mean, 1.0 / (deviation * deviation))
        };
        Belief { positions: creature.joints().iter().map(|joint| near_parent(joint.parent)).collect() }
    }
}

/// A problem and the weak belief about what its touches leave open.
struct Believed<'a, P> {
    problem: P,
    parameters: &'a Parameters,
    /// Mean and weight per position; an inner position of a split joint is believed to be zero.
    positions: Vec<(Vector3<f64>, f64)>,
}

impl<P> Believed<'_, P> {
    /// Mean-free value, offset and weight of every vector that is believed in.
    fn terms<'s>(&'s self, schema: &'s BodySchema) -> impl Iterator<Item = (usize, Vector3<f64>, f64)> + 's {
        let positions = self.positions.iter().zip(&schema.positions).zip(&self.parameters.positions);
        let positions =
            positions.filter_map(|(((mean, weight), position), at)| Some(((*at)?, position - mean, *weight)));
        let relaxed = self.parameters.axis_model == AxisModel::Relaxed;
        let axes = schema.axes.iter().zip(&self.parameters.axes).filter(move |_| relaxed);
        let weight = 1.0 / (AXIS_DEVIATION * AXIS_DEVIATION);
        positions.chain(axes.filter_map(move |(axis, at)| Some(((*at)?, *axis, weight))))
    }
}

impl<P: LeastSquares> LeastSquares for Believed<'_, P> {
    fn linearize(&mut self, schema: &BodySchema) -> Linearization {
        let mut model = self.problem.linearize(schema);
        let mut gradient = DVector::zeros(self.parameters.len());
        for (offset, value, weight) in self.terms(schema) {
            for k in 0..3 {
                model.hessian[(offset + k, offset + k)] += weight;
                gradient[offset + k] += weight * value[k];
            }
            model.cost += 0.5 * weight * value.norm_squared();
        }
        model.gradient += gradient;
        model
    }

    fn cost(&self, schema: &BodySchema) -> f64 {
        let belief: f64 =
            self.terms(schema).map(|(_, value, weight)| 0.5 * weight * value.norm_squared()).sum();
        self.problem.cost(schema) + belief
    }
}

/// Touches made ready for a fit: receptors' centres with the shape of their patches.
pub fn prepare<'t>(
    creature: &Creature,
    skin: &Skin,
    limb_of: impl Fn(usize) -> usize,
    touches: impl IntoIterator<Item = &'t Touch>,
) -> TouchSet {
    let prepared = touches.into_iter().map(|touch| {
        let receptors = touch.ends.map(|end| &skin.receptors[end.receptor]);
        let ends = [0, 1].map(|k| Observation {
            receptor: touch.ends[k].receptor,
            position: receptors[k].position,
            covariance: receptors[k].covariance(NORMAL_DEVIATION),
        });
        LimbTouch { limbs: receptors.map(|r| limb_of(r.limb)), posture: &touch.posture, ends }
    });
    TouchSet::new(creature, prepared)
}

/// The absolute gaps that a schema leaves in touches, in their order by limb pair, metres.
pub fn surface_gaps(skin: &Skin, touches: &TouchSet, schema: &BodySchema) -> Vec<f64> {
    let model = SurfaceGap::new(skin, 1.0);
    let touches = touches.pairs.iter().flat_map(|pair| &pair.touches);
    touches.map(|touch| model.meeting(&touch.ends, &touch.frames(schema)).gap.abs()).collect()
}

/// How one start begins.
enum Onset {
    /// From a schema: straight to the surfaces.
    Continued(BodySchema),
    /// From a schema, by centres first.
    Relaxed(BodySchema),
    /// From random axes, every degree of freedom with a position of its own at first.
    Split(BodySchema),
}

impl<'a> RoughFit<'a> {
    /// A learner whose onsets are drawn from `seed`.
    pub fn new(creature: &'a Creature, skin: &'a Skin, seed: u64) -> RoughFit<'a> {
        RoughFit {
            creature,
            skin,
            split: SplitCreature::new(creature),
            belief: Belief::new(creature, skin),
            rng: ChaCha8Rng::seed_from_u64(seed),
            touches: Vec::new(),
            last: None,
        }
    }

    fn solve<M: ObservationModel>(
        &self,
        creature: &Creature,
        touches: &TouchSet,
        axis_model: AxisModel,
        model: M,
        start: BodySchema,
        iterations: usize,
    ) -> BodySchema {
        let parameters = Parameters::new(creature, axis_model, |_| true);
        let mut positions = self.belief.positions.clone();
        if creature.joints().len() != positions.len() {
            let mut before = None;
            let parts = self.split.joint_of.iter().map(|&joint| {
                let first = before.replace(joint) != Some(joint);
                if first { self.belief.positions[joint] } else { (Vector3::zeros(), BEYOND_SKIN.powi(-2)) }
            });
            positions = parts.collect();
        }
        let problem = TouchProblem::new(creature, touches, &parameters, model);
        let mut problem = Believed { problem, parameters: &parameters, positions };
        let stopping = Stopping { iterations, relative_cost: 1e-3, cost: 0.0 };
        levenberg_marquardt(&mut problem, &parameters, start, stopping).schema
    }

    /// One start: the schema it reaches and its cost.
    fn start(&self, touches: &TouchSet, split_touches: &TouchSet, onset: Onset) -> (f64, BodySchema) {
        let (relaxed, mut deviation) = (AxisModel::Relaxed, 0);
        let mut schema = match onset {
            Onset::Continued(schema) => {
                deviation = 1;
                schema
            }
            Onset::Relaxed(schema) => {
                self.solve(self.creature, touches, relaxed, PointsMeet::Anyhow, schema, 30)
            }
            Onset::Split(schema) => {
                let unfolded = self.split.unfold(&schema);
                let model = PointsMeet::Anyhow;
                let solved = self.solve(&self.split.creature, split_touches, relaxed, model, unfolded, 60);
                let folded = self.split.fold(&solved);
                self.solve(self.creature, touches, relaxed, PointsMeet::Anyhow, folded, 40)
            }
        };
        schema.normalize_axes(self.creature);
        if deviation == 0 {
            schema = self.solve(self.creature, touches, AxisModel::Unit, PointsMeet::Shaped, schema, 20);
        }
        for &gap in &DEVIATIONS[deviation..] {
            let model = SurfaceGap::new(self.skin, gap);
            schema = self.solve(self.creature, touches, AxisModel::Unit, model, schema, 6);
        }
        (self.misfit(touches, &schema), schema)
    }

    /// What explanations are compared by: the robust cost of gaps and patches, and the belief's.
    fn misfit(&self, touches: &TouchSet, schema: &BodySchema) -> f64 {
        let parameters = Parameters::new(self.creature, AxisModel::Unit, |_| true);
        let model = SurfaceGap::new(self.skin, COMPARED);
        let problem = TouchProblem::new(self.creature, touches, &parameters, model);
        let positions = self.belief.positions.clone();
        Believed { problem, parameters: &parameters, positions }.cost(schema)
    }

    /// Per joint, the mean gap of the touches with it in their chain, metres.
    fn blame(&self, touches: &TouchSet, schema: &BodySchema) -> Vec<f64> {
        let joints = self.creature.joints().len();
        let (mut sum, mut count) = (vec![0.0; joints], vec![1e-9; joints]);
        let model = SurfaceGap::new(self.skin, 1.0);
        for pair in &touches.pairs {
            for touch in &pair.touches {
                let gap = model.meeting(&touch.ends, &touch.frames(schema)).gap.abs();
                let miss = gap.min(0.05) + 0.1 * touch.miss(schema).norm().min(0.2);
                pair.chain
                    .joints()
                    .for_each(|joint| (sum[joint], count[joint]) = (sum[joint] + miss, count[joint] + 1.0));
            }
        }
        sum.iter().zip(&count).map(|(sum, count)| sum / count).collect()
    }
}

impl Learner for RoughFit<'_> {
    fn touch(&mut self, touch: &Touch) {
        self.touches.push(touch.clone());
    }

    fn learn(&mut self) -> Learned {
        let touches = prepare(self.creature, self.skin, |limb| limb, &self.touches);
        // What the last schema foretold of the touches since: the only honest measure of it.
        let foretold = self.last.as_ref().map(|(schema, fitted)| {
            let fresh = prepare(self.creature, self.skin, |limb| limb, &self.touches[*fitted..]);
            let mut gaps = surface_gaps(self.skin, &fresh, schema);
            gaps.sort_by(f64::total_cmp);
            gaps
        });
        let quantile = |gaps: &[f64], share: f64| gaps[((gaps.len() - 1) as f64 * share).round() as usize];
        let found = foretold
            .as_ref()
            .is_some_and(|gaps| gaps.len() >= FORETOLD && quantile(gaps, 0.8) < FORETOLD_GAP);
        let mut onsets = Vec::new();
        if let Some((schema, _)) = &self.last {
            onsets.push(Onset::Continued(schema.clone()));
            if !found {
                onsets.push(Onset::Relaxed(schema.clone()));
                let blame = self.blame(&touches, schema);
                for k in 0..STARTS / 2 {
                    // Suspects are drawn by their blame, one at the first start, two at the second.
                    let mut kicked = schema.clone();
                    for _ in 0..=k {
                        let mut left = self.rng.random_range(0.0..blame.iter().sum::<f64>().max(1e-12));
                        let suspect = blame.iter().position(|share| {
                            left -= share;
                            left <= 0.0
                        });
                        let joint = suspect.unwrap_or(0);
                        randomize_joint(self.creature, &mut kicked, joint, &mut self.rng);
                        kicked.positions[joint] = schema.positions[joint];
                    }
                    onsets.push(Onset::Relaxed(kicked));
                }
            }
        }
        if !found {
            while onsets.len() < STARTS + 2 {
                onsets.push(Onset::Split(random_onset(self.creature, &mut self.rng)));
            }
        }
        let limb_of = |limb: usize| self.split.limb_of[limb];
        let split_touches = prepare(&self.split.creature, self.skin, limb_of, &self.touches);
        let count = onsets.len();
        let starts: Vec<(f64, BodySchema)> =
            onsets.into_par_iter().map(|onset| self.start(&touches, &split_touches, onset)).collect();
        let best = starts.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("at least one start is made");
        self.last = Some((best.1.clone(), self.touches.len()));
        let why = "a rough schema: it does not foretell the touches yet";
        Learned {
            schema: best.1,
            verdict: if found { Verdict::Converged } else { Verdict::Failed(why.to_string()) },
            onsets: count,
            fresh_rms: foretold
                .as_ref()
                .filter(|gaps| !gaps.is_empty())
                .map_or(f64::INFINITY, |gaps| quantile(gaps, 0.8) / FORETOLD_GAP),
            undetermined: Vec::new(),
            observability: None,
            deviation: foretold.filter(|gaps| !gaps.is_empty()).map(|gaps| quantile(&gaps, 0.5)),
        }
    }
}
