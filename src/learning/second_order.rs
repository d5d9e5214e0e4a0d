//! The second-order learner: all touches at once, from any onset to the optimum.
//!
//! It starts from random onsets, growing the tree limb pair by limb pair or solving it whole by turns (see
//! [`growing`](super::growing)), and accepts a start only on touches that it was not fitted to: a low
//! residual on the touches used is no proof. What it accepts is fitted once more to all touches.

use nalgebra::Matrix3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::creature::Creature;
use crate::learning::growing::{Evidence, Nursery, Route, Start};
use crate::learning::least_squares::{Stopping, levenberg_marquardt};
use crate::learning::observation::{Input, Observation, ObservationModel, PointsMeet};
use crate::learning::split::SplitCreature;
use crate::learning::annealing::{Annealed, anneal, gaps, quantile};
use crate::learning::touch_set::{LimbTouch, TouchProblem, TouchSet};
use crate::learning::{AxisModel, Learned, Learner, Parameters, Verdict};
use crate::schema::BodySchema;
use crate::senses::Touch;
use crate::skin::Skin;

/// Every how many touches one is kept back to judge a start.
const KEPT_BACK: usize = 5;
/// Starts tried before the learner says that it failed.
const STARTS: usize = 8;
/// Touches of one limb pair that a start uses at most; the last fit uses all.
const TOUCHES_PER_PAIR: usize = 150;
/// How exact a contact point is taken to be, metres.
const CONTACT_DEVIATION: f64 = 1e-4;
/// How far a curved limb is taken to bulge out of a flat patch, metres.
const NORMAL_DEVIATION: f64 = 6e-3;

/// The learner `lm`.
pub struct SecondOrder<'a> {
    creature: &'a Creature,
    skin: &'a Skin,
    input: Input,
    seed: u64,
    touches: Vec<Touch>,
}

impl<'a> SecondOrder<'a> {
    /// A learner whose onsets are drawn from `seed`.
    pub fn new(creature: &'a Creature, skin: &'a Skin, input: Input, seed: u64) -> SecondOrder<'a> {
        SecondOrder { creature, skin, input, seed, touches: Vec::new() }
    }

    fn prepare<'t>(
        &self,
        creature: &Creature,
        limb_of: impl Fn(usize) -> usize,
        touches: impl Iterator<Item = &'t Touch>,
    ) -> TouchSet {
        let prepared = touches.map(|touch| {
            let receptors = touch.ends.map(|end| &self.skin.receptors[end.receptor]);
            let ends = touch.ends.map(|end| Observation {
                receptor: end.receptor,
                position: self.input.position(self.skin, &end),
                covariance: match self.input {
                    Input::Contact => Matrix3::identity() * (0.5 * CONTACT_DEVIATION * CONTACT_DEVIATION),
                    Input::Receptor => self.skin.receptors[end.receptor].covariance(NORMAL_DEVIATION),
                },
            });
            let limbs = receptors.map(|receptor| limb_of(receptor.limb));
            LimbTouch { limbs, posture: &touch.posture, ends }
        });
        TouchSet::new(creature, prepared)
    }

    /// The greatest root mean square of whitened residuals that a right answer can have.
    fn acceptance(&self) -> f64 {
        match self.input {
            Input::Contact => 1.0,
            Input::Receptor => 1.5,
        }
    }

    /// Fits all known joints to the surfaces of `touches`.
    fn anneal(&self, touches: &TouchSet, known: &[bool], start: BodySchema) -> Annealed {
        let used = touches.filter(|pair| pair.chain.joints().all(|joint| known[joint]));
        let parameters = Parameters::new(self.creature, AxisModel::Unit, |joint| known[joint]);
        anneal(self.creature, self.skin, &used, &parameters, start)
    }

    /// Fits all joints that are `known` to `touches` on the sphere.
    fn polish(&self, touches: &TouchSet, known: &[bool], start: BodySchema) -> (BodySchema, f64) {
        let used = touches.filter(|pair| pair.chain.joints().all(|joint| known[joint]));
        let parameters = Parameters::new(self.creature, AxisModel::Unit, |joint| known[joint]);
        let mut problem = TouchProblem::new(self.creature, &used, &parameters, PointsMeet);
        let stopping = Stopping { iterations: 60, relative_cost: 1e-9, cost: 0.0 };
        let solution = levenberg_marquardt(&mut problem, &parameters, start, stopping);
        let rms = (2.0 * solution.cost / (3 * used.len()).max(1) as f64).sqrt();
        (solution.schema, rms)
    }
}

/// Root mean square of the whitened residuals of a schema on touches between known joints.
fn residual(touches: &TouchSet, known: &[bool], schema: &BodySchema) -> f64 {
    let model = PointsMeet;
    let (mut sum, mut count) = (0.0, 0);
    for pair in touches.pairs.iter().filter(|pair| pair.chain.joints().all(|joint| known[joint])) {
        for touch in &pair.touches {
            let frames = touch.frames(schema);
            let whitening = model.whitening(&touch.ends, &frames);
            sum += 2.0 * model.cost(&touch.ends, &frames, &whitening);
            count += 3;
        }
    }
    if count == 0 { f64::INFINITY } else { (sum / f64::from(count)).sqrt() }
}

impl Learner for SecondOrder<'_> {
    fn touch(&mut self, touch: &Touch) {
        self.touches.push(touch.clone());
    }

    fn learn(&mut self) -> Learned {
        let kept_back = |(i, _): &(usize, &Touch)| i % KEPT_BACK == KEPT_BACK - 1;
        let fresh = self.touches.iter().enumerate().filter(kept_back).map(|(_, touch)| touch);
        let fresh = self.prepare(self.creature, |limb| limb, fresh);
        // A start needs no more than some touches of every limb pair.
        let mut per_pair = std::collections::BTreeMap::new();
        let fitted: Vec<&Touch> = self
            .touches
            .iter()
            .enumerate()
            .filter(|entry| !kept_back(entry))
            .map(|(_, touch)| touch)
            .filter(|touch| {
                let limbs = touch.ends.map(|end| self.skin.receptors[end.receptor].limb);
                let count = per_pair.entry(limbs).or_insert(0);
                *count += 1;
                *count <= TOUCHES_PER_PAIR
            })
            .collect();
        let split = SplitCreature::new(self.creature);
        let touches = self.prepare(self.creature, |limb| limb, fitted.iter().copied());
        let split_touches = self.prepare(&split.creature, |limb| split.limb_of[limb], fitted.iter().copied());
        let nursery = Nursery {
            creature: self.creature,
            split: &split,
            touches: &touches,
            split_touches: &split_touches,
            evidence: match self.input {
                Input::Contact => Evidence::Points(self.acceptance()),
                Input::Receptor => Evidence::Surfaces(self.skin),
            },
        };

        let mut best: Option<(f64, Start)> = None;
        let mut onsets = 0;
        for start in 0..STARTS {
            let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
            rng.set_stream(start as u64);
            let route = if self.input == Input::Receptor || start % 4 == 3 { Route::Whole } else { Route::Grown };
            onsets += 1;
            let start = nursery.start(route, &mut rng);
            let judged = match self.input {
                Input::Contact => residual(&fresh, &start.known, &start.schema) / self.acceptance(),
                Input::Receptor => {
                    let used = fresh.filter(|pair| pair.chain.joints().all(|joint| start.known[joint]));
                    quantile(&gaps(self.skin, &used, &start.schema), 0.8) / 3e-3
                }
            };
            let accepted = start.accepted && judged <= 1.0;
            if std::env::var("DBG").is_ok() { eprintln!("start {onsets} {route:?} accepted {} judged {judged} known {}", start.accepted, start.known.iter().filter(|k| **k).count()); }
            if best.as_ref().is_none_or(|(least, b)| accepted || (!b.accepted && judged < *least)) {
                best = Some((judged, Start { accepted, ..start }));
            }
            if accepted {
                break;
            }
        }
        let (judged, start) = best.expect("at least one start is made");
        let untouched: Vec<usize> =
            (0..self.creature.joints().len()).filter(|&joint| !start.known[joint]).collect();
        let mut schema = start.schema;
        let verdict = if start.accepted {
            let all = self.prepare(self.creature, |limb| limb, self.touches.iter());
            if self.input == Input::Contact { (schema, _) = self.polish(&all, &start.known, schema); }
            if self.input == Input::Receptor {
                let annealed = self.anneal(&all, &start.known, schema);
                if std::env::var("DBG").is_ok() { eprintln!("{:?} {} {} {}", annealed.gap_deviation, annealed.median_gap, annealed.p80_gap, annealed.iterations); }
                schema = annealed.schema;
            }
            Verdict::Converged
        } else {
            Verdict::Failed(format!(
                "none of {onsets} random onsets explains touches it was not fitted to (the best misses them \
                 by {judged:.1} times what the skin's patches allow); try more touches"
            ))
        };
        Learned { schema, verdict, onsets, fresh_rms: judged, untouched }
    }
}
