//! The learner touch by touch.
//!
//! A filter from a random initial guess diverges, so the first touches are learned from all at once, by
//! [`SecondOrder`], as soon as there are enough of them and again whenever half as many more have come. Once
//! that has locked in, every touch is first predicted, then learned from by an extended Kalman filter (see
//! [`belief`]); whenever the touches have doubled, all are fitted again, so that no derivative is old.
//!
//! The schema is usable at any time, and its covariance says how far. A body that changes is noticed from the
//! predictions and followed without starting over (see `change.rs`).

pub mod belief;
mod change;
mod tool;

use std::borrow::Cow;

use crate::agent::Agent;
use crate::deadline::Deadline;
use crate::kinematics::Chain;
use crate::learning::annealing::NARROWEST;
use crate::learning::growing::WHOLE_DOF;
use crate::learning::least_squares::LeastSquares;
use crate::learning::observability::Observability;
use crate::learning::open_gaps::witnesses;
use crate::learning::scrutiny::{Scrutiny, ToldTouch};
use crate::learning::surface_gap::SurfaceGap;
use crate::learning::touch_set::{PreparedTouch, TouchProblem, TouchSet};
use crate::learning::{
    Account, Basis, Input, Learned, Learner, LengthUnit, Prior, PriorKnowledge, SecondOrder, Witnesses,
};
use crate::schema::BodySchema;
use crate::senses::Touch;
pub use belief::{Belief, Expectation, fit_again};
use change::{Explanation, Watch, Watched};
pub use tool::Tool;

/// Touches after which learning is first tried; a body too large to be solved whole is learned in the end.
const FIRST_TRIAL: usize = 240;
/// Starts of the first trial: none that doubts its touches, for those are dear.
const FIRST_STARTS: usize = 2;
/// Starts of a trial before the last: not all, for more touches make it easier.
const STARTS: usize = 4;
/// Predicted deviations of a gap beyond which a touch surprises and is not learned from.
const SURPRISING: f64 = 5.0;
/// … and beyond which it counts ever less.
const TAIL: f64 = 3.0;
/// Gaps narrower than this never surprise, metres: it is what shapes are known to.
const CLOSE_ENOUGH: f64 = 2e-4;
/// Touches with joints that the schema has no place for which are not worth to learn all anew.
const FEW_BEYOND: usize = 10;
/// How far from where it was found a joint that moved may be, metres: a standard deviation.
const MOVED: f64 = 0.01;
/// Touches since a change without an explanation after which all is learned anew from them.
const PATIENCE: usize = 300;
/// Noise of the gaps above which the touches are learned from all at once, too, in the end, metres.
const CERTAIN_NOISE: f64 = 2e-5;
/// The last touches by which the schema is judged.
const JUDGED: usize = 100;
/// Share of surprises among them that false touches may make up.
const TOLERATED: f64 = 0.25;

/// Touches after a change in which its explanation may still turn out to be wrong.
const PROBATION: usize = 80;
/// Touches after a change until all since are fitted again for the first time.
const FEW_MORE: usize = 15;
/// Share of all touches with a joint, from before a change and since, that its new place explains where it had
/// been there all the time.
const EXPLAINS_ALL: f64 = 0.7;

/// A change of the body, as the agent understood it.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyChange {
    /// The number of the touch at which it was understood, from 0.
    pub touch: usize,
    /// The number of the first touch that it explains.
    pub since: usize,
    /// What changed.
    pub what: What,
}

/// What can change of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A joint is now so far, in metres, from where it was on the limb that carries it.
    Joint {
        /// The joint.
        joint: usize,
        /// How far it moved, metres.
        distance: f64,
    },
    /// The agent had been wrong about a joint, by so much, in metres.
    Corrected {
        /// The joint.
        joint: usize,
        /// How far it was off, metres.
        distance: f64,
    },
    /// A stick is held.
    Tool(Tool),
    /// More than the agent could explain; all is learned anew.
    Beyond,
}

/// Another way to learn from touches until a deadline; `None` if it finds nothing, or does not suit the body.
pub type Search = Box<dyn Fn(&[Touch], Deadline) -> Option<Learned>>;

/// The learner `lm` on receptors and surfaces.
pub struct Online {
    agent: Agent,
    known: PriorKnowledge,
    batch: SecondOrder,
    /// The unit in which what it goes on from was learned: what counts as placed is told in it.
    unit: LengthUnit,
    deadline: Deadline,
    /// Touches seen.
    seen: usize,
    /// Touches at which learning is tried next.
    next_trial: usize,
    /// What is tried before all joints at once.
    search: Option<Search>,
    locked: Option<Locked>,
    /// Initial guesses used by trials so far.
    initial_guesses: usize,
    expectation: Option<Expectation>,
    /// Whether each of the last touches surprised.
    surprises: Vec<bool>,
    /// How many of its predicted deviations each missed by.
    deviations: Vec<f64>,
    changes: Vec<BodyChange>,
    sticks: Vec<HeldStick>,
    /// All of this before the last change was explained, as long as the explanation is on probation.
    snapshot: Option<Box<Snapshot>>,
}

/// What there was before a change was explained.
struct Snapshot {
    locked: Locked,
    sticks: Vec<HeldStick>,
    /// The touch at which it was explained, and the first of those explained.
    number: usize,
    onset: usize,
}

/// A stick that is held.
#[derive(Clone)]
struct HeldStick {
    tool: Tool,
    /// The touches that it explained.
    touches: Vec<PreparedTouch>,
    /// How many of these there will be when it is fitted again.
    next_fit: usize,
}

/// What there is once a schema is found.
#[derive(Clone)]
struct Locked {
    belief: Belief,
    /// What was known before the touches below: once the body has changed, what those from before determine.
    prior: Prior,
    touches: TouchSet,
    /// Touches with joints that the belief has no place for.
    beyond: usize,
    /// Touches at which all are fitted again.
    next_fit: usize,
    watch: Watch,
}

impl Online {
    /// A learner whose initial guesses are drawn from `seed`.
    pub fn new(agent: &Agent, seed: u64) -> Online {
        let known = PriorKnowledge::nothing(agent);
        let batch = SecondOrder::new(agent, Input::Receptor, seed);
        Online {
            agent: agent.clone(),
            known,
            batch,
            unit: LengthUnit::METRE,
            deadline: Deadline::Never,
            seen: 0,
            next_trial: if agent.creature().dof() > WHOLE_DOF { usize::MAX } else { FIRST_TRIAL },
            search: None,
            locked: None,
            initial_guesses: 0,
            expectation: None,
            surprises: Vec::new(),
            deviations: Vec::new(),
            changes: Vec::new(),
            sticks: Vec::new(),
            snapshot: None,
        }
    }

    /// A learner that goes on from what was learned before, by touches of which it is given no more than what they
    /// determined: it predicts every touch from the first one on. `deviation` is that of a touch's gap, metres. None where the
    /// account is of no use for that.
    pub fn going_on(
        agent: &Agent,
        schema: BodySchema,
        account: &Account,
        deviation: f64,
        seed: u64,
    ) -> Option<Online> {
        let found = &account.observability;
        let belief = Belief::new(schema, found.parameters.clone(), found.information().clone(), deviation)?;
        let prior = belief.as_prior(agent.creature())?;
        let mut learner = Online::new(agent, seed);
        learner.known.frozen.copy_from_slice(found.known());
        learner.unit = found.unit();
        let watch = Watch::default();
        let touches = TouchSet::default();
        // Not before it would be noticed that the body has changed: touches from before and after fit nothing.
        learner.locked = Some(Locked { belief, prior, touches, beyond: 0, next_fit: PATIENCE, watch });
        Some(learner)
    }

    /// Per touch since it first had a schema, whether that had not foretold it.
    pub fn surprises(&self) -> &[bool] {
        &self.surprises
    }

    /// Sets what is tried first where no schema was found so far and nothing was known before.
    pub fn with_search(self, search: Search) -> Online {
        Online { search: Some(search), ..self }
    }

    /// Sets what is known of the joints already.
    pub fn with_known(mut self, known: PriorKnowledge) -> Online {
        self.batch = self.batch.with_known(known.clone());
        self.known = known;
        self
    }

    /// The schema and its covariance; none before the learner has one.
    pub fn belief(&self) -> Option<&Belief> {
        self.locked.as_ref().map(|locked| &locked.belief)
    }

    /// How the body changed, as far as the agent understood.
    pub fn changes(&self) -> &[BodyChange] {
        &self.changes
    }

    /// Tries to learn from all touches at once.
    fn try_all(&mut self) {
        let learned = self.batch.learn_in(if self.initial_guesses == 0 { FIRST_STARTS } else { STARTS });
        self.initial_guesses += learned.initial_guesses;
        self.next_trial = self.seen + self.batch.touches().len().max(FIRST_TRIAL) / 2;
        if learned.verdict.converged() {
            self.lock(&learned);
        }
    }

    fn lock(&mut self, learned: &Learned) {
        let (Some(account), Some(deviation)) = (&learned.account, learned.deviation) else {
            return;
        };
        let parameters = account.observability.parameters.clone();
        let mut touches = TouchSet::default();
        let mut beyond = 0;
        for (limbs, touch) in self.batch.prepared() {
            let chain = Chain::between(self.agent.creature(), limbs[0], limbs[1]);
            let mut joints = chain.joints();
            if joints.all(|j| self.known.frozen[j] || parameters.positions[j].is_some()) {
                touches.push_prepared(self.agent.creature(), limbs, touch);
            } else {
                beyond += 1;
            }
        }
        let schema = learned.schema.clone();
        let belief = Belief::at(&self.agent, &touches, parameters, &self.known.prior, schema, deviation);
        let Some(belief) = belief else { return };
        let next_fit = 2 * touches.len();
        let watch = Watch::default();
        let prior = self.known.prior.clone();
        self.locked = Some(Locked { belief, prior, touches, beyond, next_fit, watch });
    }

    /// Predicts a touch, then learns from it.
    fn follow(&mut self, touch: &Touch) {
        let number = self.seen - 1;
        let (limbs, prepared) = self.batch.prepare_one(touch);
        let Some(locked) = self.locked.as_mut() else { return };
        let chain = Chain::between(self.agent.creature(), limbs[0], limbs[1]);
        if !locked.belief.knows(chain.joints(), &self.known.frozen) {
            locked.beyond += 1;
            if locked.beyond > locked.touches.len().min(FIRST_TRIAL) {
                self.locked = None;
                self.next_trial = self.seen;
            }
            return;
        }
        let mut expectation = locked.belief.expect(self.agent.skin(), &prepared);
        let skin = self.agent.skin();
        let of_limbs = self.sticks.iter_mut().filter(|stick| limbs.contains(&stick.tool.limb));
        let by_stick = of_limbs
            .filter_map(|stick| Some((stick.tool.gap(skin, &locked.belief.schema, &prepared)?, stick)))
            .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
            .filter(|(gap, _)| gap.abs() < expectation.gap.abs());
        let is_by_stick = by_stick.is_some();
        if let Some((gap, stick)) = by_stick {
            expectation.gap = gap;
            stick.touches.push(prepared.clone());
            if stick.touches.len() >= stick.next_fit {
                let all: Vec<&PreparedTouch> = stick.touches.iter().collect();
                stick.tool = stick.tool.refitted(skin, &locked.belief.schema, &all, CLOSE_ENOUGH);
                stick.next_fit = 3 * stick.touches.len() / 2;
            }
        }
        self.expectation = Some(expectation);
        let deviations = expectation.gap.abs() / expectation.deviation;
        let surprising = deviations > SURPRISING && expectation.gap.abs() > CLOSE_ENOUGH;
        self.surprises.push(surprising);
        self.deviations.push(deviations);
        let watched = Watched { number, limbs, touch: prepared.clone(), surprising };
        let changed = locked.watch.see(&chain, watched);
        if !is_by_stick {
            if !surprising {
                locked.belief.learn((TAIL / deviations.max(TAIL)).powi(2));
            }
            locked.touches.push_prepared(self.agent.creature(), limbs, prepared);
        }
        if let Some(onset) = changed {
            self.adapt(onset, number);
        } else if locked.touches.len() >= locked.next_fit {
            self.fit_again();
        }
    }

    fn fit_again(&mut self) {
        let Some(locked) = self.locked.as_mut() else { return };
        if let Some(belief) = locked.belief.fitted_again(&self.agent, &locked.touches, &locked.prior) {
            locked.belief = belief;
        }
        locked.next_fit = 2 * locked.touches.len();
    }

    /// Looks for what explains the touches since `onset`, and goes by it.
    fn adapt(&mut self, mut onset: usize, number: usize) {
        // An explanation that so soon leaves touches unexplained was wrong, or the change went on.
        if let Some(before) = self.snapshot.take_if(|before| number < before.number + PROBATION) {
            let watch = self.locked.take().map(|locked| locked.watch).unwrap_or_default();
            self.locked = Some(Locked { watch, ..before.locked });
            self.sticks = before.sticks;
            self.changes.pop();
            onset = before.onset;
        }
        let Some(locked) = self.locked.as_mut() else { return };
        let agent = &self.agent;
        let belief = &locked.belief;
        let explanation =
            locked.watch.explain(onset, agent, &belief.schema, &belief.parameters, belief.deviation);
        let since: Vec<Watched> = locked.watch.since(onset).cloned().collect();
        if explanation.is_some() {
            let (locked, sticks) = (locked.clone(), self.sticks.clone());
            self.snapshot = Some(Box::new(Snapshot { locked, sticks, number, onset }));
        }
        match explanation {
            None if since.len() < PATIENCE => {}
            None => {
                self.changes.push(BodyChange { touch: number, since: onset, what: What::Beyond });
                self.batch.forget_before(since.len());
                self.locked = None;
                self.next_trial = self.seen;
            }
            Some(Explanation::Holds(tool)) => {
                let by_stick = since.iter().filter(|w| w.surprising && w.limbs.contains(&tool.limb));
                let touches: Vec<&PreparedTouch> = by_stick.map(|watched| &watched.touch).collect();
                let tool = tool.settled(agent.skin(), &belief.schema, &touches);
                self.sticks.retain(|stick| stick.tool.limb != tool.limb);
                let touches = Vec::from_iter(touches.into_iter().cloned());
                self.sticks.push(HeldStick { tool, next_fit: 3 * touches.len() / 2, touches });
                self.changes.push(BodyChange { touch: number, since: onset, what: What::Tool(tool) });
                locked.watch.calm();
            }
            Some(Explanation::Moved(joint, schema)) => {
                let distance = (schema.positions[joint] - belief.schema.positions[joint]).norm();
                let with_joint = locked.touches.filter(|pair| pair.chain.joints().any(|j| j == joint));
                let close = CLOSE_ENOUGH.max(SURPRISING * belief.deviation);
                // Of the touches before, too: the body is the same, and had been learned wrongly.
                let explains_all = change::closed(agent.skin(), &with_joint, &schema, close) > EXPLAINS_ALL;
                if explains_all && locked.prior.correlated.is_none() {
                    locked.belief.schema = schema;
                    let what = What::Corrected { joint, distance };
                    self.changes.push(BodyChange { touch: number, since: onset, what });
                    locked.watch.calm();
                    self.fit_again();
                    return;
                }
                locked.belief.schema = schema;
                locked.belief.doubt_position(joint, MOVED);
                let Some(prior) = locked.belief.as_prior(agent.creature()) else { return };
                locked.touches = TouchSet::default();
                for watched in since {
                    locked.touches.push_prepared(agent.creature(), watched.limbs, watched.touch);
                }
                locked.prior = prior;
                locked.watch.calm();
                let what = What::Joint { joint, distance };
                self.changes.push(BodyChange { touch: number, since: onset, what });
                self.fit_again();
                if let Some(locked) = self.locked.as_mut() {
                    locked.next_fit = locked.touches.len() + FEW_MORE;
                }
            }
        }
    }

    /// Whether the touches that there are were all made by the body as it is now: those before a change that nothing explains are
    /// forgotten, and one that was but an error was none.
    fn is_one_body(&self) -> bool {
        let is_none = |change: &BodyChange| matches!(change.what, What::Beyond | What::Corrected { .. });
        let has_changed = self.locked.as_ref().is_some_and(|locked| locked.prior.correlated.is_some());
        !has_changed && self.changes.iter().all(is_none)
    }

    /// Whether the last predictions held.
    fn trustworthy(&self) -> bool {
        let last = &self.surprises[self.surprises.len().saturating_sub(JUDGED)..];
        let surprising = last.iter().filter(|&&surprising| surprising).count();
        surprising as f64 <= TOLERATED * last.len() as f64
    }

    /// Root mean square of how far the last touches, false ones left out, were from what was predicted, in
    /// predicted deviations.
    fn fresh_rms(&self) -> f64 {
        let first = self.deviations.len().saturating_sub(JUDGED);
        let last = self.deviations[first..].iter().zip(&self.surprises[first..]);
        let true_ones: Vec<f64> = last.filter(|(_, surprising)| !**surprising).map(|(d, _)| d * d).collect();
        (true_ones.iter().sum::<f64>() / true_ones.len() as f64).sqrt()
    }

    /// All touches since the body last changed, fitted once more; none where there is no schema yet.
    pub fn conclude(&mut self) -> Option<Learned> {
        let fresh_rms = self.fresh_rms();
        if !self.changes.is_empty() {
            self.fit_again();
        }
        let locked = self.locked.as_ref()?;
        let belief = &locked.belief;
        // All touches count alike, and the last fit is that of all at once.
        if self.is_one_body() {
            let known = |j: usize| self.known.frozen[j] || belief.parameters.positions[j].is_some();
            let known = (0..self.agent.creature().joints().len()).map(known).collect();
            let refined = self.batch.refine_known(&belief.schema, known);
            return Some(Learned {
                verdict: refined.account.as_ref()?.verdict(self.agent.creature()),
                initial_guesses: self.initial_guesses,
                fresh_rms,
                changes: self.changes.clone(),
                ..refined
            });
        }
        let told = witnesses(&self.agent, &locked.touches, &belief.schema, |_| belief.deviation, false);
        let model = SurfaceGap::new(self.agent.skin(), belief.deviation);
        let mut problem = TouchProblem::new(self.agent.creature(), &told, &belief.parameters, model);
        if locked.prior.correlated.is_some() {
            problem = problem.with_prior(&locked.prior);
        }
        let information = problem.linearize(&belief.schema).hessian;
        let rows = 5 * told.len();
        let observability = Observability::new(
            self.agent.creature(),
            belief.parameters.clone(),
            &self.known.frozen,
            information,
            rows,
            self.unit,
        );
        let witnesses = Witnesses {
            of_limbs: told.count_of_limbs(self.agent.creature()),
            made_of_limbs: locked.touches.count_of_limbs(self.agent.creature()),
            point_deviation: 0.0,
            at_floor: belief.deviation <= NARROWEST,
        };
        let account = Account::new(&self.agent, &belief.schema, observability, witnesses);
        Some(Learned {
            schema: belief.schema.clone(),
            basis: Basis::SURFACES,
            verdict: account.verdict(self.agent.creature()),
            initial_guesses: self.initial_guesses,
            fresh_rms,
            account: Some(account),
            deviation: Some(belief.deviation),
            changes: self.changes.clone(),
        })
    }
}

impl Online {
    /// What all touches tell: found part by part where they are exact, even if some are false; else by starts of the whole body,
    /// which take noise.
    fn all_at_once(&mut self) -> Learned {
        let search = self.search.as_ref().filter(|_| self.locked.is_none() && !self.known.is_given());
        let found = search.and_then(|search| search(self.batch.touches(), self.deadline));
        found.filter(|found| found.verdict.converged()).unwrap_or_else(|| self.batch.learn())
    }

    /// What was learned of all touches at once, as far as it stands before those between limbs that it places. Where there is
    /// noise, a wrong answer shows by how likely it makes that before it is taken.
    fn standing(&self, learned: Learned) -> Learned {
        let is_sharp = learned.deviation.is_some_and(|deviation| deviation <= CERTAIN_NOISE);
        if !learned.verdict.converged() || !is_sharp {
            return learned;
        }
        let Some(account) = &learned.account else { return learned };
        let creature = self.agent.creature();
        let all = self.batch.touches();
        let told = |touch: &Touch| {
            let (limbs, prepared) = self.batch.prepare_one(touch);
            ToldTouch::new(creature, limbs, prepared, &touch.posture)
        };
        let touches: Vec<ToldTouch> = all.iter().map(told).collect();
        let touches: Vec<&ToldTouch> = touches.iter().collect();
        let claimed = |number: &usize| {
            let [a, b] = touches[*number].limbs;
            account.claims(a, b)
        };
        let claimed: Vec<usize> = (0..touches.len()).filter(claimed).collect();
        let fit = |schema: &BodySchema, told: &[usize]| {
            let mut last = SecondOrder::new(&self.agent, Input::Receptor, 0).with_known(self.known.clone());
            told.iter().for_each(|&number| last.touch(&all[number]));
            last.refine(schema)
        };
        let (initial_guesses, fresh_rms) = (learned.initial_guesses, learned.fresh_rms);
        let scrutiny = Scrutiny::new(&self.agent, Input::Receptor, &self.known).with_false_touches();
        let (standing, _) = scrutiny.standing(&touches, claimed, learned, fit);
        Learned { initial_guesses, fresh_rms, ..standing }
    }
}

impl Learner for Online {
    fn end_at(&mut self, deadline: Deadline) {
        self.deadline = deadline;
        self.batch.end_at(deadline);
    }

    fn touch(&mut self, touch: &Touch) {
        self.seen += 1;
        self.expectation = None;
        self.batch.touch(touch);
        if self.locked.is_some() {
            self.follow(touch);
        }
        if self.locked.is_none() && self.seen >= self.next_trial && !self.deadline.has_passed() {
            self.try_all();
        }
    }

    fn expectation(&self) -> Option<Expectation> {
        self.expectation
    }

    fn schema(&self) -> Option<Cow<'_, BodySchema>> {
        self.belief().map(|belief| Cow::Borrowed(&belief.schema))
    }

    fn learn(&mut self) -> Learned {
        let complete = self.locked.as_ref().is_some_and(|locked| locked.beyond < FEW_BEYOND);
        if complete && self.trustworthy() {
            let noisy = self.belief().is_some_and(|belief| belief.deviation > CERTAIN_NOISE);
            let is_one_body = self.is_one_body();
            if let Some(learned) = self.conclude().filter(|_| !noisy || !is_one_body) {
                return if is_one_body { self.standing(learned) } else { learned };
            }
        }
        let mut learned = self.all_at_once();
        learned.initial_guesses += self.initial_guesses;
        learned.changes = self.changes.clone();
        self.initial_guesses = learned.initial_guesses;
        let learned = self.standing(learned);
        if learned.verdict.converged() {
            self.lock(&learned);
        }
        learned
    }
}
