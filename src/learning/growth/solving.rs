//! One part of a body from random initial guesses to an answer.

use nalgebra::{DMatrix, DVector, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{FEWEST_UNKNOWNS, GrownTouch, Growth, Part};
use crate::deadline::in_parallel;
use crate::learning::annealing::{HOPELESS, POINT_FITS, WIDEST, meet, usual_miss};
use crate::learning::initial_guess::randomize_joint;
use crate::learning::least_squares::Linearization;
use crate::learning::open_gaps::MOST_FALSE;
use crate::learning::prediction::invert;
use crate::learning::scrutiny::{CLOSED, Member, SHARP, Testimony};
use crate::learning::touch_set::TouchSet;
use crate::learning::{AxisModel, Parameters, Prior};
use crate::schema::BodySchema;
use crate::senses::Input;

/// A gap narrower than this is nearly closed, metres: an answer that leaves most of them may be right but for a joint.
const NEARLY: f64 = 5e-5;
/// What stays open of an answer is worth looking at where this share of its touches is closed.
const HOPEFUL: f64 = 0.5;
/// The share of a part's touches that an answer closes: all others are false.
pub(super) const ENOUGH: f64 = 1.0 - MOST_FALSE;
/// The share from which on none better is looked for.
const AS_GOOD_AS_ALL: f64 = 0.97;
/// Starts that are made at once: always so many, for what is taken must not depend on the number of threads.
pub(super) const AT_ONCE: usize = 4;
/// An answer of a first part that closes less may be what chance finds again and again.
const OFTEN_DRAWN: f64 = 0.7;
/// Starts of the first part whose points nearly meet and whose surfaces do not, after which no more are made.
const MOST_NEAR: usize = 16;
/// Deviations of the gap, metres, from which surfaces are closed: wide ones find answers from farther away, among false touches only
/// narrow ones find any. Starts that are made at once have one of these and one of the next each, for their points often meet alike.
const FIRST_GAPS: [f64; 2] = [WIDEST, 0.5 * WIDEST];
/// Those down to which axes stay relaxed: joints that turn little are caught in one wrong minimum or another, and which depends on
/// this.
const RELAXED_GAPS: [f64; 2] = [3e-3, WIDEST];
/// What so many starts come to is the best that there is.
const AGREEING: usize = 4;
/// Touches that the first part needs, in units of its joints' unknowns, to do without limbs beyond joints that rest.
const INNER_TOUCHES: f64 = 1.6;
/// Touches that a part is solved by at the most, in units of its unknowns.
const MOST_TOUCHES: usize = 8;
/// Positions and axes known to this, metres and radians, are held while a part is solved: it makes no difference.
const KNOWN_POSITION: f64 = 3e-5;
const KNOWN_AXIS: f64 = 3e-4;
/// Share of a limb's or joint's touches, beyond that of all others, that stay open and give it up. As many at the most are given
/// up, …
const OPEN_SHARE: f64 = 0.25;
const GIVEN_UP: usize = 6;
/// … and an answer explains this share of a part's touches without them, …
const MOST_OF_ALL: f64 = 0.6;
/// … or so many in units of its unknowns, or none.
const MANY: usize = 3;

/// An answer for a part.
pub(super) struct Solved {
    /// The schema with it.
    pub schema: BodySchema,
    /// The share of the touches that it nearly closes, but for those of what is given up: by it answers are looked for.
    pub share: f64,
    /// The share of them that it closes: by it an answer stands; and how many these are.
    pub exact: f64,
    pub closed: usize,
    /// Limbs and joints without whose touches it does.
    pub given_up: Vec<Member>,
}

impl Solved {
    /// What makes one answer better than another: what explains most of its touches, by how many.
    fn worth(&self) -> f64 {
        self.share + if self.exact > ENOUGH { self.closed as f64 } else { 0.0 }
    }

    /// Whether hardly a touch is left open: no better answer is looked for.
    pub fn closes_all(&self) -> bool {
        self.exact > AS_GOOD_AS_ALL
    }
}

/// The problem of one part.
pub(super) struct PartProblem<'a> {
    pub part: &'a Part,
    /// The touches that tell of it, by their numbers; and those that it is solved by.
    pub numbers: Vec<usize>,
    pub solved_by: Vec<usize>,
    pub touches: TouchSet,
    /// Per joint, whether it is between limbs that touched, and whether its position is free.
    between: Vec<bool>,
    free: Vec<bool>,
    /// Axes of the part, relaxed; and all that is free, with unit axes.
    relaxed: Parameters,
    pub unit: Parameters,
    /// What is believed besides the touches: little of what is new, much of what is known.
    prior: Prior,
    /// What is known, and the lower Cholesky factor of its covariance.
    spread: Option<(Parameters, DMatrix<f64>)>,
    /// What starts begin with.
    pub base: BodySchema,
}

impl PartProblem<'_> {
    /// What is believed besides the touches of it, as information over its parameters with unit axes.
    pub fn information(&self, schema: &BodySchema) -> DMatrix<f64> {
        let mut model = Linearization::nothing(self.unit.len());
        self.prior.add(&self.unit, schema, &mut model);
        model.hessian
    }
}

impl Growth {
    /// The best answer of so many starts; none where no touch tells anything.
    pub(super) fn solve(&mut self, problem: &PartProblem, starts: usize) -> Option<Solved> {
        self.solves += 1;
        let numbers: Vec<usize> = (0..starts).collect();
        let mut solved: Vec<Solved> = Vec::new();
        for wave in numbers.chunks(AT_ONCE) {
            let made: Vec<Solved> =
                in_parallel(wave.to_vec(), |number| self.start(problem, number, HOPELESS));
            self.starts += made.len();
            solved.extend(made);
            let good = solved.iter().any(Solved::closes_all);
            let most = solved.iter().map(|solved| solved.share).fold(0.0, f64::max);
            let as_good = |other: &&Solved| (most - other.share) * (problem.touches.len() as f64) < 1.5;
            // What comes again and again is the best that chance finds.
            let drawn = most > if self.belief.is_some() { 0.0 } else { OFTEN_DRAWN };
            let again = drawn && solved.iter().filter(as_good).count() >= AGREEING;
            // Where an answer is among those whose points nearly meet, it is one in three.
            let near = solved.iter().filter(|solved| solved.share > 0.0).count();
            let in_vain = self.belief.is_none() && near >= MOST_NEAR && most <= ENOUGH;
            let late = self.deadline.has_passed();
            if late || again || in_vain || good {
                break;
            }
        }
        let at = (0..solved.len()).max_by(|&a, &b| solved[a].worth().total_cmp(&solved[b].worth()))?;
        let mut best = solved.swap_remove(at);
        best.schema = self.carried(problem, &best.schema);
        Some(best)
    }

    /// The problem of a part; none where no touch tells of it.
    pub(super) fn part_problem<'p>(&self, part: &'p Part) -> Option<PartProblem<'p>> {
        let creature = self.agent.creature();
        let joints = creature.joints();
        let numbers: Vec<usize> =
            (0..self.touches.len()).filter(|&number| self.is_of(&self.touches[number], part)).collect();
        let mut solved_by = numbers.clone();
        if self.belief.is_none() {
            // Limbs beyond joints that rest only add unknowns, where touches of the others are enough.
            let of = |number: &usize| &self.touches[*number];
            let within =
                |number: &usize| of(number).told.chain.iter().all(|joint| part.joints.contains(joint));
            let inner: Vec<usize> = solved_by.iter().copied().filter(within).collect();
            let width = self.width(&part.joints);
            let enough = inner.iter().filter(|number| of(number).suffices).count() as f64;
            if enough >= INNER_TOUCHES * width as f64 && width >= FEWEST_UNKNOWNS {
                solved_by = inner;
            }
        }
        if solved_by.is_empty() {
            return None;
        }
        // Of very many the freest do.
        let most = MOST_TOUCHES * (self.width(&part.joints) + 3 * part.limbs.len());
        if self.belief.is_some() && solved_by.len() > most {
            solved_by.sort_by_key(|&number| std::cmp::Reverse(self.touches[number].told.moving.len()));
            solved_by.truncate(most);
        }
        let touches: Vec<&GrownTouch> = solved_by.iter().map(|&number| &self.touches[number]).collect();
        let (mut between, mut moving) = (vec![false; joints.len()], vec![false; joints.len()]);
        let mut touched = vec![false; creature.limbs().len()];
        for touch in &touches {
            touch.told.chain.iter().for_each(|&joint| between[joint] = true);
            touch.told.moving.iter().for_each(|&joint| moving[joint] = true);
            touch.told.limbs.iter().for_each(|&limb| touched[limb] = true);
        }
        let belief = self.belief.as_ref();
        let position = |joint: usize| belief.and_then(|belief| belief.parameters.positions[joint]);
        let axis = |dof: usize| belief.and_then(|belief| belief.parameters.axes[dof]);
        let sure = |place: Option<usize>, size: usize, limit: f64| {
            place.zip(belief).is_some_and(|(place, belief)| {
                (place..place + size).all(|i| belief.covariance[(i, i)] < limit * limit)
            })
        };
        // Positions of joints at rest add up: it takes the sums up to limbs that are touched and joints that move.
        let carries_motion =
            |limb: usize| (0..joints.len()).any(|next| joints[next].parent == limb && moving[next]);
        let new = |joint: &usize| part.joints.contains(joint);
        let free: Vec<bool> = (0..joints.len())
            .map(|joint| {
                let matters = moving[joint] || touched[joint + 1] || carries_motion(joint + 1);
                let known = sure(position(joint), 3, KNOWN_POSITION) && !new(&joint);
                between[joint] && matters && !known
            })
            .collect();
        let free_axis =
            |joint: usize, dof: usize| moving[joint] && (new(&joint) || !sure(axis(dof), 2, KNOWN_AXIS));
        let mut prior = self.known.prior.clone();
        let known_positions = (0..joints.len()).filter(|&joint| position(joint).is_some());
        known_positions.for_each(|joint| prior.position_deviations[joint].fill(f64::INFINITY));
        prior.correlated = belief.and_then(|belief| {
            let parameters = Parameters::of(
                creature,
                AxisModel::Unit,
                |joint| free[joint] && position(joint).is_some(),
                |joint, dof| !new(&joint) && free_axis(joint, dof) && axis(dof).is_some(),
            );
            belief.marginal(parameters)
        });
        let spread = prior.correlated.as_ref().and_then(|known| {
            let lower = invert(known.information.clone())?.cholesky()?.l();
            Some((known.parameters.clone(), lower))
        });
        Some(PartProblem {
            part,
            numbers,
            touches: self.set(touches.into_iter()),
            solved_by,
            relaxed: Parameters::of(
                creature,
                AxisModel::Relaxed,
                |joint| free[joint],
                |joint, _| new(&joint) && moving[joint],
            ),
            unit: Parameters::of(creature, AxisModel::Unit, |joint| free[joint], free_axis),
            between,
            free,
            prior,
            spread,
            base: self.believed(),
        })
    }

    /// One start: the receptors' places, or the contact points, as points with relaxed axes, which is cheap, and only from what
    /// comes near them the surfaces; no further where the points miss by so many deviations in half of all touches.
    pub(super) fn start(&self, problem: &PartProblem, number: usize, hopeless: f64) -> Solved {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream((self.solves << 16) + number as u64);
        let guess = self.guess(problem, number, &mut rng);
        self.start_from(problem, guess, number, hopeless)
    }

    /// The same from an initial guess.
    pub(super) fn start_from(
        &self,
        problem: &PartProblem,
        mut schema: BodySchema,
        number: usize,
        hopeless: f64,
    ) -> Solved {
        let creature = self.agent.creature();
        let PartProblem { touches, relaxed, unit, .. } = problem;
        let meet = |parameters: &Parameters, schema: BodySchema, fits: usize| {
            meet(creature, touches, parameters, &problem.prior, schema, (fits, self.deadline))
        };
        schema = meet(relaxed, schema, POINT_FITS);
        schema.normalize_axes(creature);
        schema = meet(unit, schema, POINT_FITS / 2);
        let hopeless = self.input == Input::Receptor && usual_miss(touches, &schema) > hopeless;
        if hopeless || self.deadline.has_passed() {
            return Solved { schema, share: 0.0, exact: 0.0, closed: 0, given_up: Vec::new() };
        }
        self.closed(problem, schema, number)
    }

    /// The answer that is nearest to one for fewer touches.
    pub(super) fn gone_on(&self, problem: &PartProblem, from: BodySchema) -> Solved {
        let schema = self.closest([WIDEST, SHARP], &problem.touches, &problem.unit, &problem.prior, from);
        self.without_open(problem, schema)
    }

    /// The answer that closes the surfaces from a schema that is near; starts differ in how wide gaps are at first, and in how long
    /// axes stay relaxed.
    fn closed(&self, problem: &PartProblem, mut schema: BodySchema, number: usize) -> Solved {
        let creature = self.agent.creature();
        let PartProblem { touches, relaxed, unit, .. } = problem;
        let widest = FIRST_GAPS[number / RELAXED_GAPS.len() % FIRST_GAPS.len()];
        let narrowest = RELAXED_GAPS[number % RELAXED_GAPS.len()].min(widest);
        schema = self.closest([widest, narrowest], touches, relaxed, &problem.prior, schema);
        schema.normalize_axes(creature);
        schema = self.closest([widest, SHARP], touches, unit, &problem.prior, schema);
        self.without_open(problem, schema)
    }

    /// What is left of an answer without what stays open, a limb or a joint given up after the other: most of a part may be
    /// right where a joint is not.
    fn without_open(&self, problem: &PartProblem, mut schema: BodySchema) -> Solved {
        let first = self.belief.is_none();
        let unit = &problem.unit;
        let all = problem.solved_by.len() as f64;
        let mut numbers = problem.solved_by.clone();
        let mut given_up = Vec::new();
        let may = |member| match member {
            Member::Limb(limb) => first || problem.part.limbs.contains(&limb),
            Member::Joint(joint) => problem.part.joints.contains(&joint),
        };
        loop {
            let gap = |&number: &usize| self.scrutiny().felt_gap(NEARLY, &self.touches[number].told, &schema);
            let gaps: Vec<f64> = numbers.iter().map(gap).collect();
            let (open, worst) = self.open_member(&numbers, &gaps, may);
            let share = (numbers.len() - open) as f64 / numbers.len().max(1) as f64;
            let hopeful = share > HOPEFUL && share < AS_GOOD_AS_ALL && given_up.len() < GIVEN_UP;
            let Some(worst) = worst.filter(|_| hopeful) else {
                let share_within = |tolerance: f64| {
                    let closed = gaps.iter().filter(|&&gap| gap < tolerance).count();
                    let enough = closed as f64 >= MOST_OF_ALL * all || closed >= MANY * unit.len();
                    let of = if enough { numbers.len().max(1) as f64 } else { all };
                    (closed as f64 / of, closed)
                };
                let (exact, closed) = share_within(CLOSED);
                let share = share_within(NEARLY).0;
                return Solved { schema, share, exact, closed, given_up };
            };
            given_up.push(worst);
            numbers.retain(|&number| !self.touches[number].told.tells_of(worst));
            let touches = self.set(numbers.iter().map(|&number| &self.touches[number]));
            schema = self.closest([WIDEST, SHARP], &touches, unit, &problem.prior, schema);
        }
    }

    /// An initial guess of a part, drawn from what is believed, if anything is; in the first one, what is known stays as it is.
    fn guess(&self, problem: &PartProblem, number: usize, rng: &mut ChaCha8Rng) -> BodySchema {
        let mut guess = problem.base.clone();
        if self.belief.is_none() {
            let between = (0..problem.between.len()).filter(|&joint| problem.between[joint]);
            between.for_each(|joint| randomize_joint(self.agent.creature(), &mut guess, joint, rng));
            return guess;
        }
        for &joint in &problem.part.joints {
            let position = guess.positions[joint];
            randomize_joint(self.agent.creature(), &mut guess, joint, rng);
            guess.positions[joint] = position;
        }
        if number == 0 {
            return guess;
        }
        let mut standard = || -> f64 { StandardNormal.sample(rng) };
        for joint in (0..problem.free.len()).filter(|&joint| problem.free[joint]) {
            let deviation = problem.prior.position_deviations[joint];
            if deviation.iter().all(|deviation| deviation.is_finite()) {
                let shift = Vector3::from_fn(|i, _| deviation[i] * standard());
                guess.positions[joint] = problem.prior.mean.positions[joint] + shift;
            }
        }
        if let Some((parameters, lower)) = &problem.spread {
            let step = lower * DVector::from_fn(lower.nrows(), |_, _| standard());
            guess = parameters.step(&guess, &step);
        }
        guess
    }

    /// How many of some touches leave gaps (metres) open, and the limb or joint among those that may be given up of whose touches
    /// most stay open, if these are more than chance.
    fn open_member(
        &self,
        numbers: &[usize],
        gaps: &[f64],
        may: impl Fn(Member) -> bool,
    ) -> (usize, Option<Member>) {
        let touches = numbers.iter().map(|&number| &*self.touches[number].told);
        let told = touches.zip(gaps.iter().map(|gap| *gap >= CLOSED));
        let open = gaps.iter().filter(|gap| **gap >= CLOSED).count();
        let wrong = |member, of_it: &Testimony| may(member) && of_it.beyond() > OPEN_SHARE;
        (open, self.scrutiny().most_suspect(told, wrong))
    }

    /// What follows for all that is believed from what an answer says of some of it: a Gaussian's conditional mean. What its touches
    /// tell of stays as it was solved, also what was held: they would open.
    pub(super) fn carried(&self, problem: &PartProblem, schema: &BodySchema) -> BodySchema {
        let (Some(belief), Some(known)) = (&self.belief, &problem.prior.correlated) else {
            return schema.clone();
        };
        let places = known.parameters.places_in(&belief.parameters);
        let pull = &known.information * known.difference(schema);
        let mut step = DVector::zeros(belief.parameters.len());
        for &(from, to) in &places {
            step.axpy(pull[from], &belief.covariance.column(to), 1.0);
        }
        let told = |joint: usize| problem.between[joint];
        let told = Parameters::of(self.agent.creature(), AxisModel::Unit, told, |joint, _| told(joint));
        told.places_in(&belief.parameters).iter().for_each(|&(_, to)| step[to] = 0.0);
        belief.parameters.step(schema, &step)
    }
}
